"""What a unit has: parameters by the scenario's keys, inputs that are held, outputs as channels of a result."""

import math
import re
from collections.abc import Iterator, Sequence
from itertools import product
from typing import Any, Final, Literal, NamedTuple

from pydantic import BaseModel

from ehamj.bounds import unit_of
from ehamj.control import AnyController
from ehamj.control.units import plain_unit, signal_units
from ehamj.errors import InputError
from ehamj.plant.axes import AXES
from ehamj.scenario.model import Scenario
from ehamj.settings import PROVENANCE
from ehamj.variables import FIXED, MOTIONS, VARIABLES, labels_of, variables_of

TABLES: Final = (
    *("gravity", "seed", "machine", "part", "slide", "mount", "actuators", "supply", "sensors", "ground", "force"),
    *("fault", "control"),
)  # fmt: skip
"""Of a scenario, whose numbers are parameters; the others say how a run is recorded, judged and shown."""
LONGEST: Final = 16
"""Numbers in a list that become parameters of their own."""
INT: Final = 2**31 - 1
"""Largest integer of FMI 2."""
CONTROL: Final = "use_control"
GROUND: Final = "use_ground"
READS_EVERY: Final = "reads_every"

SHOWN: Final = (
    *(f"{place}_{motion}" for place in ("cg", "foot", "point", "ground") for motion in reversed(MOTIONS)),
    *("machine_velocity", "machine_displacement", "relative_velocity", "relative_displacement"),
    *("stroke", "stroke_velocity", "spool", "valve_command", "actuator_force", "chamber_pressure", "chamber_flow"),
    *("supply_pressure", "slide", "measured"),
)
"""Variables of a result that are outputs, of those that a run has."""

Role = Literal["parameter", "input", "output"]
Type = Literal["Real", "Integer", "Boolean"]


class Variable(NamedTuple):
    """A variable of a unit."""

    name: str
    """Structured, as FMI has it: identifiers with dots, numbers of a list from 1 in brackets."""
    role: Role
    unit: str
    """As ehamj writes it; "-" of what has none."""
    text: str
    """What it is."""
    start: Any = None
    """Of a parameter and an input; its type is the variable's."""
    keys: tuple[str, ...] = ()
    """Parts of the scenario's key of a parameter; variable of a result of an output."""
    place: tuple[int, ...] = ()
    """Of an output in that variable, time left aside."""

    @property
    def type(self) -> Type:
        """Of FMI."""
        return "Boolean" if isinstance(self.start, bool) else "Integer" if isinstance(self.start, int) else "Real"


def identifier(word: str) -> str:
    """A name as an identifier: other signs than letters and digits become ``_``."""
    found = re.sub(r"\W", "_", word, flags=re.ASCII)
    return f"_{found}" if found[:1].isdigit() else found


def parameters(scenario: Scenario, has_law: bool, law_is_given: bool) -> list[Variable]:
    """Numbers and switches of a scenario, and those of the unit itself.

    Args:
        scenario: whose keys they are.
        has_law: a law reads, at its own period.
        law_is_given: the law comes with a result or a design, and nothing in [control] changes it.
    """
    found = []
    active = scenario.control.kind != "passive"
    if active:
        text = "the scenario's own control commands the valves; false: the inputs alone"
        found.append(Variable(CONTROL, "parameter", "-", text, True))
    text = "the ground moves as the scenario's; false: by the inputs alone"
    found.append(Variable(GROUND, "parameter", "-", text, True))
    if not has_law:
        text = "period of the readings"
        found.append(Variable(READS_EVERY, "parameter", "s", text, 1.0 / scenario.record_rate))
    for keys, value, description in _numbers(scenario):
        if law_is_given and keys[0] == "control":
            continue
        unit = unit_of(description) or "-"
        text = description.removesuffix(f" [{unit}]")
        found.append(Variable(structured(keys), "parameter", unit, f"{'.'.join(keys)}: {text}", value, keys))
    return found


def structured(keys: Sequence[str]) -> str:
    """A key as a name: entries of a list count from 1."""
    parts = [f"[{int(part) + 1}]" if part.isdigit() else f".{identifier(part)}" for part in keys]
    return "".join(parts).removeprefix(".")


def _numbers(scenario: Scenario) -> Iterator[tuple[tuple[str, ...], Any, str]]:
    """Key in parts, value and description of every finite number and switch."""
    for table in TABLES:
        about = type(scenario).model_fields.get(table)
        yield from _within((table,), getattr(scenario, table), (about and about.description) or "")


def _within(keys: tuple[str, ...], value: Any, description: str) -> Iterator[tuple[tuple[str, ...], Any, str]]:
    if isinstance(value, BaseModel):
        for name, about in type(value).model_fields.items():
            if name not in (*PROVENANCE, "designed_for"):
                yield from _within((*keys, about.alias or name), getattr(value, name), about.description or "")
    elif isinstance(value, dict):
        for name, entry in value.items():
            yield from _within((*keys, str(name)), entry, description)
    elif isinstance(value, tuple | list) and len(value) <= LONGEST:
        for number, entry in enumerate(value):
            yield from _within((*keys, str(number)), entry, description)
    elif (
        isinstance(value, bool)
        or (isinstance(value, int) and abs(value) <= INT)
        or (isinstance(value, float) and math.isfinite(value))
    ):
        yield keys, value, description


def inputs(mounts: Sequence[str]) -> list[Variable]:
    """Commands, ground accelerations, force and moment, in the order of `ehamj.Stepper.hold`'s arrays."""

    def made(name: str, unit: str, text: str) -> Variable:
        return Variable(f"held.{name}", "input", unit, f"{text}, held between communication points", 0.0)

    text = "command to the valve of"
    found = [made(f"command.{identifier(one)}", "V", f"{text} {one}, added to the law's") for one in mounts]
    for one in mounts:
        text = "acceleration of the ground below"
        found += [made(f"ground.{identifier(one)}.{axis}", "m/s²", f"{text} {one} along {axis}") for axis in AXES]
    found += [made(f"force.{axis}", "N", f"force at the centre of gravity along {axis}") for axis in AXES]
    found += [made(f"moment.{axis}", "N m", f"moment about {axis} at the centre of gravity") for axis in AXES]
    return found


def outputs(scenario: Scenario, law: AnyController | None) -> list[Variable]:
    """Channels of a run of a scenario, under a law or with one that only reads."""
    found, has, along = [], variables_of(scenario, law), FIXED | labels_of(scenario, law)
    for name in SHOWN:
        if name in has:
            dimensions, units, text = VARIABLES[name]
            for place in product(*(enumerate(along[dimension]) for dimension in dimensions)):
                one = _output(name, [str(label) for _, label in place], units, text)
                found.append(one._replace(place=tuple(number for number, _ in place)))
    return found


def _output(name: str, labels: Sequence[str], units: str, text: str) -> Variable:
    said = f"{' '.join((name, *labels))}: {text}"
    words = [word for label in labels for word in label.split(" ")]
    if name == "measured":
        units, said = plain_unit(signal_units(labels[:1])[0]), f"reading of {labels[0]}"
    parts = [f"[{word}]" if word.isdigit() else f".{identifier(word)}" for word in words]
    return Variable(f"{name}{''.join(parts)}", "output", _unit_of(units, words), said, keys=(name,))


def _unit_of(units: str, words: Sequence[str]) -> str:
    """Unit of one number of a variable whose turns have another one: ``m (rx, ry, rz: rad)``."""
    both = re.fullmatch(r"(.+) \(rx, ry, rz: (.+)\)", units)
    if both is None:
        return "-" if units == "1" else units
    return both[2 if words and words[-1] in ("rx", "ry", "rz") else 1]


def check_names(variables: Sequence[Variable]) -> None:
    """Refuse two variables of one name.

    Raises:
        InputError: if names that differ in other signs than letters and digits meet.
    """
    seen: dict[str, Variable] = {}
    for one in variables:
        if other := seen.get(one.name):
            raise InputError(f"--fmu: {one.text!r} and {other.text!r} would both be called {one.name!r}; rename one")
        seen[one.name] = one
