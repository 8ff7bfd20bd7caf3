"""Everything that can be designed: architectures with loops that are tuned, and syntheses, which find their loops."""

from typing import Final

from ehamj.control.kinds import STANDARD
from ehamj.control.settings import DigitalSettings
from ehamj.design.hinfinity import HInfinitySettings
from ehamj.design.lqg import LqgSettings
from ehamj.design.motions import SynthesisSettings

DESIGNABLE: Final = {name: one for name, one in STANDARD.items() if isinstance(one, DigitalSettings)}
"""Architectures that can be designed: the settings of each begin from their defaults."""

SYNTHESES: Final[dict[str, type[SynthesisSettings]]] = {one.name(): one for one in (HInfinitySettings, LqgSettings)}
"""Settings of each synthesis by its name."""
