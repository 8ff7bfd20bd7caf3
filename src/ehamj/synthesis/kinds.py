"""Every control that a scenario may have. One more synthesis is a file beside this one and an entry here."""

from typing import TYPE_CHECKING, Final

from ehamj.control.architectures.file import Law
from ehamj.control.commands import OpenLoop, Passive
from ehamj.control.kinds import ARCHITECTURES, CombinedSettings
from ehamj.control.settings import ControlSettings
from ehamj.registry import Registry
from ehamj.settings import one_of
from ehamj.synthesis.hinfinity import HInfinitySettings
from ehamj.synthesis.lqg import LqgSettings
from ehamj.synthesis.settings import SynthesisSettings

SYNTHESES: Final[Registry[type[SynthesisSettings]]] = Registry("synthesis")
"""Laws that are found for the machine at hand."""

_SYNTHESES: tuple[type[SynthesisSettings], ...] = (
    HInfinitySettings,
    LqgSettings,
)
for _synthesis in _SYNTHESES:
    SYNTHESES.add(_synthesis.name(), _synthesis)

CONTROLS: Final[Registry[type[ControlSettings]]] = Registry("control")
"""Everything that [control] of a scenario may be."""

_CONTROLS: tuple[type[ControlSettings], ...] = (
    Passive, OpenLoop, *ARCHITECTURES.values(), CombinedSettings, *SYNTHESES.values(), Law,
)  # fmt: skip
for _control in _CONTROLS:
    CONTROLS.add(_control.name(), _control)

STANDARD: Final[dict[str, ControlSettings]] = {
    name: made for name, kind in CONTROLS.items() if (made := kind.standard()) is not None
}
"""Controls that need nothing stated, with their defaults: a scenario may be compared with them."""

if TYPE_CHECKING:
    Control = ControlSettings
else:
    Control = one_of(CONTROLS.values())
