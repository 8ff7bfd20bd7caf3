"""What a dotted key means in a scenario: its own value and its unit."""

from typing import Any

from ehamj.bounds import unit_of
from ehamj.designs.parameters import FOOTPRINT, changes_of, footprint, quantity_of
from ehamj.errors import InputError, did_you_mean
from ehamj.scenario.keys import plain
from ehamj.scenario.load import changed
from ehamj.scenario.model import Scenario
from ehamj.scenario.places import by_kind, inside, only


def own_value(scenario: Scenario, key: str, said: str = "vary") -> Any:
    """The scenario's value of a key, as TOML has it; None where it is left out, or there is no such key.

    Args:
        scenario: whose.
        key: dotted, as ``--set`` has it.
        said: the table that names the key, for messages.

    Raises:
        InputError: if it is of isolators that there are none of.
    """
    if key in FOOTPRINT:
        return footprint(scenario.plant, key)
    place: Any = scenario
    for part in key.split("."):
        if place is scenario.actuators and part not in place:
            raise InputError(
                f"{said}: {key}: {did_you_mean(part, place)}there are the actuators {', '.join(scenario.actuators)}"
            )
        place = _entry(place, part)
    return plain(place)


def check_known(scenario: Scenario, key: str, said: str = "vary") -> None:
    """Refuse a key that is none, in the scenario's words.

    Raises:
        InputError: which names what may have been meant.
    """
    try:
        changed(scenario, changes_of(scenario, {key: 1.0}))
    except InputError as error:
        if "unknown key" in str(error) or "must be an index" in str(error):
            raise InputError(f"{said}: {str(error).replace(f'{key} = 1.0', key)}") from None


def unit_at(scenario: Scenario, key: str) -> str:
    """Unit of a key, "1" where it has none."""
    try:
        unit = quantity_of(scenario, key)[0]
    except InputError:
        unit = _stated_unit(scenario, key)
    return "1" if unit == "-" else unit


def _stated_unit(scenario: Scenario, key: str) -> str:
    """Unit in the description of the field that a key leads to; an entry of a list has the list's."""
    place, kind, unit = scenario, Scenario, "-"
    for part in key.split("."):
        table = by_kind(kind).get(str(getattr(place, "kind", "")), only(kind))
        if field := getattr(table, "model_fields", {}).get(part):
            unit = unit_of(field.description) or "-"
        kind = inside(table, 0 if isinstance(place, tuple) else part)
        place = _entry(place, part)
    return unit


def _entry(place: Any, part: str) -> Any:
    """What a part of a key leads to: a field, an entry of a table, or one of a list by number or name."""
    if isinstance(place, tuple):
        names = [getattr(entry, "name", None) for entry in place]
        number = names.index(part) if part in names else int(part) if part.isdigit() else len(place)
        return place[number] if number < len(place) else None
    if isinstance(place, dict):
        return place.get(part)
    return getattr(place, part, None) if part in getattr(type(place), "model_fields", {}) else None
