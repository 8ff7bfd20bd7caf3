"""The identified machine as a scenario, each value that the data tell with its source and its deviation."""

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

from ehamj.control.settings import DigitalSettings
from ehamj.identification.machine import with_values
from ehamj.scenario.model import Scenario
from ehamj.settings import Parameters

if TYPE_CHECKING:
    from ehamj.identification.outcome import Identified


def identified_machine(scenario: Scenario, found: Mapping[str, "Identified"]) -> Scenario:
    """A scenario with the values that were found.

    Values that the data tell are ``identified``, with their deviations; those that what was known before tells are
    ``given``. A law that is derived for the machine is derived for this one.

    Args:
        scenario: on which the tests were made, as far as it was known.
        found: by the scenario's key.
    """
    known = {key: one for key, one in found.items() if one.value is not None}
    made = with_values(scenario, {key: float(one.value) for key, one in known.items() if one.value is not None})
    control = made.control
    if isinstance(control, DigitalSettings) and _law_of(scenario) is None and control.designed_for is not None:
        made = made.model_copy(update={"control": control.model_copy(update={"designed_for": None})})
    told = {key: one for key, one in known.items() if one.status == "identified" and one.deviation is not None}
    return _with_provenance(made, told)


def _law_of(scenario: Scenario) -> Any:
    return scenario.control.designed_for if isinstance(scenario.control, DigitalSettings) else None


def _with_provenance(scenario: Scenario, told: Mapping[str, "Identified"]) -> Scenario:
    """State source and deviation of each value in the table that holds it; tables without sources have none."""
    found: dict[tuple[str, ...], dict[str, Any]] = {}
    for key, one in told.items():
        place = _place(scenario, key)
        if place is None or one.deviation is None:
            continue
        table, name, index = place
        owner = _owner(scenario, table)
        deviations = found.setdefault(table, {})
        deviations[name] = _spread(getattr(owner, name), index, one.deviation, deviations.get(name))
    for table, deviations in found.items():
        sources = dict.fromkeys(deviations, "identified")
        new = _owner(scenario, table).with_values({"sources": sources, "deviations": deviations})
        value = {**scenario.actuators, table[1]: new} if table[0] == "actuators" else new
        scenario = scenario.model_copy(update={table[0]: value})
    return scenario


def _owner(scenario: Scenario, table: tuple[str, ...]) -> Parameters:
    found: Parameters = scenario.actuators[table[1]] if table[0] == "actuators" else getattr(scenario, table[0])
    return found


def _place(scenario: Scenario, key: str) -> tuple[tuple[str, ...], str, tuple[int, ...]] | None:
    """Table, quantity and place in it that a key means; None where its table has no sources."""
    first, _, rest = key.partition(".")
    table: tuple[str, ...] = (first,)
    if first == "mount":
        first, rest = "actuators", rest.replace(".actuator.", ".", 1)
    if first == "actuators":
        name = max((one for one in scenario.actuators if rest.startswith(f"{one}.")), key=len, default=None)
        if name is None:
            return None
        table, rest = ("actuators", name), rest.removeprefix(f"{name}.")
    elif first not in ("machine", "supply"):
        return None
    quantity, *index = rest.split(".")
    if quantity not in _owner(scenario, table).quantities() or not all(part.isdigit() for part in index):
        return None
    return table, quantity, tuple(map(int, index))


def _spread(value: Any, index: tuple[int, ...], deviation: float, before: Any) -> Any:
    """The deviation in a value's own shape: at one entry, beside those that are there; without an index at all."""
    if not isinstance(value, tuple):
        return deviation
    entries = []
    for k, own in enumerate(value):
        known = 0.0 if before is None else before[k]
        if index and k != index[0]:
            entries.append(_spread(own, (), 0.0, None) if before is None else known)
        else:
            entries.append(_spread(own, index[1:], deviation, None if before is None else known))
    return tuple(entries)
