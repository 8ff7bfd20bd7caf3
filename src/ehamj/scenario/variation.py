"""Other machines beside a scenario's: with its law held, as on a machine that is not quite the one it was made for, or
with the law derived anew, as for another machine."""

import warnings
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any, Literal, get_args

import numpy as np

from ehamj.control.installation import PARTS, Installation
from ehamj.control.settings import ControlSettings, DigitalSettings
from ehamj.errors import DerivedAnew, InputError
from ehamj.scenario.explain import checked
from ehamj.scenario.keys import differences, entries, place, plain
from ehamj.synthesis.settings import SynthesisSettings

if TYPE_CHECKING:
    from ehamj.scenario.model import Scenario

LawChoice = Literal["held", "derived"]
"""What becomes of a law whose machine is varied."""

SHOWN = 4
"""Differences that a message names."""


def changed(scenario: "Scenario", values: Mapping[Any, Any]) -> "Scenario":
    """The scenario with other values, checked as a file is. A law is derived for what came out, unless it is held.

    Args:
        scenario: what they differ from.
        values: by dotted key, as ``--set`` has them: ``{"control.delay": 3e-4, "mount.0.actuator": "soft"}``, or by key
            in parts, ``("actuators", "v2.0", "oil")``; a whole table replaces the one that is there.

    Raises:
        InputError: with one message that names the key, the value and what is allowed.
    """
    table = stated(scenario)
    touched = set()
    for key, value in values.items():
        parts = key.split(".") if isinstance(key, str) else list(key)
        place(table, key, plain(value), f"{'.'.join(parts)} = {value!r}")
        touched.add(parts[0])
    # What nothing is changed of has been checked; that it fits the rest is checked again.
    return checked(
        type(scenario), {name: one if name in touched else getattr(scenario, name) for name, one in table.items()}
    )


def otherwise(scenario: "Scenario", table: Mapping[str, Any], where: str) -> "Scenario":
    """`changed`, by a table as files of studies and identifications have it; the scenario itself if that is empty.

    Args:
        scenario: what it differs from.
        table: what is otherwise; a first key may be dotted, as those of ``--set`` are.
        where: key of the table in its file, with which messages begin.

    Raises:
        InputError: as `changed`.
    """
    try:
        values = {(*key[0].split("."), *key[1:]): value for key, value in entries(table)}
        return changed(scenario, values) if values else scenario
    except InputError as error:
        raise InputError(f"{where}: {error}") from error


def stated(scenario: "Scenario") -> dict[str, Any]:
    """The scenario's table without points that nobody stated: they follow the machine's size."""
    return {key: value for key, value in scenario.table.items() if key != "points" or key in scenario.model_fields_set}


def varied(scenario: "Scenario", values: Mapping[str, Any], law: LawChoice = "held") -> "Scenario":
    """`changed`, with the law ``held``: derived from the machine that it was derived from before, or ``derived`` anew.

    Warns:
        DerivedAnew: if the law changed together with its machine.

    Raises:
        InputError: as `changed`, and if ``law`` is neither.
    """
    if law not in get_args(LawChoice):
        raise InputError(f"law = {law!r}: must be one of {', '.join(map(repr, get_args(LawChoice)))}")
    new, before = changed(scenario, values), scenario.nominal
    control = new.control
    if not isinstance(control, DigitalSettings):
        standards = [new.variant(name).control for name in new.compare]
        _warn(next((one for one in standards if derived_anew(one, before, new.installation)), None), before, new)
    elif law == "derived":
        new = new.model_copy(update={"control": control.model_copy(update={"designed_for": None})})
        _warn(new.control if derived_anew(new.control, before, new.installation) else None, before, new)
    elif control.designed_for is None and unlike(before, new.installation):
        new = new.model_copy(update={"control": control.model_copy(update={"designed_for": before})})
    return new


def unlike(one: Installation, other: Installation) -> dict[str, tuple[Any, Any]]:
    """Values in which two machines with their instruments differ, by dotted key."""
    named = [name for name in PARTS if getattr(one, name) != getattr(other, name)]
    ours, theirs = (plain({name: getattr(whose, name) for name in named}) for whose in (one, other))
    return differences(ours, theirs)


def derived_anew(control: ControlSettings, one: Installation, other: Installation) -> bool:
    """Whether a control is another law on another machine; a law that is held, or comes from a file, is not."""
    if not isinstance(control, DigitalSettings) or control.designed_for is not None or not unlike(one, other):
        return False
    if isinstance(control, SynthesisSettings):
        return True  # found for the machine at hand
    laws = [control.controller(where.plant, where.sensors).to_dict() for where in (one, other)]
    return any(not np.array_equal(laws[0][name], laws[1][name]) for name in laws[0])


def held(scenario: "Scenario") -> tuple[str, ...]:
    """What a reader must know of a law that is held for another machine than it runs on; nothing of any other."""
    found = unlike(scenario.nominal, scenario.installation)
    said = named(found, "{key} = {one}, here {other}")
    return (f"the law is held: it was derived for a machine that differs ({said})",) if found else ()


def named(found: Mapping[str, tuple[Any, Any]], words: str = "{key} = {one} → {other}") -> str:
    """Differences in words, the first few."""

    def value(given: Any) -> str:
        if isinstance(given, Sequence) and not isinstance(given, str):
            return f"[{', '.join(map(value, given))}]" if len(given) <= SHOWN else "…"
        return f"{given:.5g}" if isinstance(given, float) else "…" if isinstance(given, Mapping) else str(given)

    parts = [words.format(key=key, one=value(one), other=value(other)) for key, (one, other) in found.items()]
    more = f" and {len(parts) - SHOWN} more" if len(parts) > SHOWN else ""
    return ", ".join(parts[:SHOWN]) + more


def _warn(control: ControlSettings | None, before: Installation, new: "Scenario", depth: int = 5) -> None:
    if control is not None:
        warn_derived(control, unlike(before, new.installation), depth)


def warn_derived(control: ControlSettings, found: Mapping[str, tuple[Any, Any]], depth: int = 2) -> None:
    """Say that a law was derived for a changed machine, which it so knows exactly."""
    warnings.warn(
        f"the {control.name()} law was derived anew for the changed machine and instruments ({named(found)}) and so "
        "knows its values exactly; to see what the law of the machine before does on this one, hold it: "
        "control.designed_for, or scenario.varied({...}) in Python",
        DerivedAnew,
        stacklevel=depth,
    )
