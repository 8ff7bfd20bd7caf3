"""A scenario as a notebook shows it: what it is, and what of it differs from the default."""

from collections.abc import Iterator, Mapping
from typing import TYPE_CHECKING, Any, Final

from ehamj.scenario.keys import differences
from ehamj.settings import PROVENANCE

if TYPE_CHECKING:
    from ehamj.scenario.model import Scenario

LONGEST: Final = 120
"""Letters of a value that are shown."""


def rows(scenario: "Scenario") -> Iterator[tuple[str, str]]:
    """The machine in words, then every key whose value is not the default [SI], as ``--set`` takes it."""
    plant = scenario.plant
    said = f"{plant.machine.mass:g} kg on {len(plant.mounts)} mounts, {scenario.duration:g} s"
    yield "machine", f"{said}; floor: {scenario.ground.kind}; law: {scenario.control.kind}"
    for key, (_, value) in differences(type(scenario)().table, scenario.table).items():
        yield from _flat(key, value)


def _flat(key: str, value: Any) -> Iterator[tuple[str, str]]:
    """Values of nested tables by dotted key."""
    if isinstance(value, Mapping) and value:
        for name, own in value.items():
            if name not in PROVENANCE:
                yield from _flat(f"{key}.{name}", own)
    elif value is not None:
        text = str(value)
        yield key, text if len(text) <= LONGEST else f"{text[: LONGEST - 1]}…"
