"""A scenario as a notebook shows it: what it is, and what it states that is not left to the default."""

from collections.abc import Iterator, Mapping
from typing import TYPE_CHECKING, Any, Final

if TYPE_CHECKING:
    from ehamj.scenario.model import Scenario

LONGEST: Final = 120
"""Letters of a value that are shown."""


def rows(scenario: "Scenario") -> Iterator[tuple[str, str]]:
    """The machine in words, then every key that the scenario states [SI], as ``--set`` takes it."""
    plant = scenario.plant
    said = f"{plant.machine.mass:g} kg on {len(plant.mounts)} mounts, {scenario.duration:g} s"
    yield "machine", f"{said}; floor: {scenario.ground.kind}; law: {scenario.control.kind}"
    yield from _stated(scenario.model_dump(mode="json", exclude_unset=True))


def _stated(table: Mapping[str, Any], before: str = "") -> Iterator[tuple[str, str]]:
    """Values of nested tables by dotted key; a table that states nothing is one as well."""
    for key, value in table.items():
        if isinstance(value, Mapping) and value:
            yield from _stated(value, f"{before}{key}.")
        elif key != "sources":
            text = str(value)
            yield f"{before}{key}", text if len(text) <= LONGEST else f"{text[: LONGEST - 1]}…"
