"""Laws as other tools write them: discrete systems with names, in python-control's JSON and in MATLAB's structs.

What comes out is the table that a law's own file holds, so that `ehamj.control.law.Controller.from_dict` judges it. One
thing that is not stated differs from there, ``from_rest``: a linear law is designed about the machine's rest, so that
its readings of displacements, strokes and pressures count from where the machine stands.
"""

import json
import re
from collections.abc import Mapping, Sequence
from typing import Any, Final

from ehamj.control.channels import UnknownChannelError, check_channel, reads_static, valve_commands
from ehamj.control.tables import check_keys, names_in, number_in
from ehamj.control.units import plain_unit, signal_units
from ehamj.errors import InputError
from ehamj.plant.mounts import MOUNTS

SPELLINGS: Final[dict[str, tuple[str, ...]]] = {
    "A": ("A", "a"),
    "B": ("B", "b"),
    "C": ("C", "c"),
    "D": ("D", "d"),
    "period_s": ("dt", "Ts", "period_s", "period", "sample_time", "SampleTime", "tsam"),
    "inputs": ("inputs", "InputName", "inputname", "InputNames", "input_names", "input_labels", "u_names", "inname"),
    "outputs": (
        *("outputs", "OutputName", "outputname", "OutputNames", "output_names", "output_labels", "y_names"),
        "outname",
    ),
}
"""Names of what a law must have, by the key of a law's own file; outputs may be left out where mounts are usual."""

OWN: Final = (
    *("delay_s", "voltage_limit_v", "bits", "switch_on_s", "fade_s", "from_rest", "anti_windup"),
    *("valves", "learners", "lines", "spools"),
)
"""Keys of a law's own file that may stand beside them."""
BEYOND: Final = "beyond"
"""Key of a text in JSON with those that no matrix holds."""

TOLD: Final = (
    *("name", "Name", "states", "StateName", "StateNames", "statename", "state_labels", "x_names", "StateUnit"),
    *("StatePath", "scales", "about", "Notes", "notes", "note", "UserData", "InputGroup", "OutputGroup"),
    *("SamplingGrid", "Scaled", "Offsets", "signal_types", "version", "run"),
)
"""Keys of what changes nothing in a law."""
EMPTY: Final = ("InputDelay", "OutputDelay", "InternalDelay", "ioDelay", "E", "e")
"""Keys of what a law here cannot have: empty, zeros, and of E a unit matrix are let pass."""
UNITS: Final = ("InputUnit", "OutputUnit", "TimeUnit")
"""Keys of units, which must be those of a law here."""
LAW: Final = ("A", "B", "C", "D", "dt", "inputs", "outputs")
"""How messages spell what a law is."""


def is_foreign(table: Mapping[str, Any]) -> bool:
    """Whether a table is another tool's: a law's own file states ``period_s``, or ``parts``."""
    timed = bool(table.keys() & SPELLINGS["period_s"])
    return bool({"law", "plant"} & table.keys()) or (timed and not {"period_s", "parts"} & table.keys())


def own_table(table: Mapping[str, Any]) -> dict[str, Any]:
    """The table of a law's own file from another tool's: one system, or ``law`` beside others, as exports have it.

    Raises:
        InputError: if there is no law in it, or not one only; if it is continuous; if it has what a law cannot.
    """
    found = table.get("law", table)
    settings = table.get("law_settings", {}) if "law" in table else {}
    if "law" not in table and "plant" in table:
        raise InputError("controller: holds a plant and no law; a law stands under the key 'law'")
    if isinstance(found, list | tuple):
        more = settings if isinstance(settings, list) else [settings] * len(found)
        if not found or len(more) != len(found) or not all(isinstance(one, Mapping) for one in (*found, *more)):
            raise InputError("controller.law: must be a system, or a list of systems that run side by side")
        parts = [_system({**one, **own}) for one, own in zip(found, more, strict=True)]
        return parts[0] if len(parts) == 1 else {"parts": parts}
    if not isinstance(found, Mapping) or not isinstance(settings, Mapping):
        raise InputError(
            "controller.law: must be a system: matrices A, B, C and D, dt, and names of inputs and outputs"
        )
    return _system({**found, **settings})


def _system(table: Mapping[str, Any]) -> dict[str, Any]:
    """The table of one law of one system."""
    known = {name for names in SPELLINGS.values() for name in names} | {*OWN, BEYOND, *TOLD, *EMPTY, *UNITS}
    check_keys("controller", dict.fromkeys(key for key in table if key not in known), (*LAW, *OWN))
    found = {key: _spelled(table, key) for key in SPELLINGS}
    missing = [key for key, value in found.items() if value is None and key != "outputs"]
    if missing:
        wanted = " or ".join(SPELLINGS[missing[0]][:3])
        raise InputError(f"controller: {missing[0]} is missing, as {wanted}; a law is {', '.join(LAW)}")
    _check_period(found["period_s"])
    for name in EMPTY:
        _check_empty(name, table.get(name))
    rows = found["C"] if isinstance(found["C"], list) and found["C"] else found["D"]
    outputs, order = _outputs(found["outputs"], len(rows) if isinstance(rows, list) else 0)
    found |= {"outputs": outputs, **{key: _picked(key, found[key], order) for key in "CD"}}
    found["inputs"] = list(names_in(_named(found["inputs"])))
    found |= {name: table[name] for name in OWN if name in table}
    if "from_rest" not in found and reads_static(found["inputs"]):
        found["from_rest"] = True
    found |= _beyond(table.get(BEYOND))
    if order is not None and found.get("anti_windup") is not None:
        found["anti_windup"] = _columns("anti_windup", found["anti_windup"], order)
    _check_units(table, found)
    return found


def _spelled(table: Mapping[str, Any], key: str) -> Any:
    """What stands under one of a key's spellings; None where nothing does."""
    given = {name: table[name] for name in SPELLINGS[key] if table.get(name) is not None}
    if key in ("inputs", "outputs"):
        given = {name: value for name, value in given.items() if not all(map(_is_no_name, _named(value)))}
    values = list(given.values())
    if any(value != values[0] for value in values[1:]):
        raise InputError(f"controller: {' and '.join(given)} differ, and mean the same; leave one out")
    return values[0] if values else None


def _is_no_name(name: Any) -> bool:
    """Whether this is what MATLAB and python-control call a signal without a name."""
    return name == "" or (isinstance(name, str) and re.fullmatch(r"[uy]\[\d+\]", name) is not None)


def _check_period(value: Any) -> None:
    if isinstance(value, bool) or number_in(value, "controller.dt") <= 0.0:
        raise InputError(
            f"controller.dt = {value}: must be the period of the samples [s], positive; a continuous law is made "
            "discrete first, as by c2d"
        )


def _check_empty(name: str, value: Any) -> None:
    """Refuse what a law here cannot have."""
    rows = value if isinstance(value, list) else [] if value is None else [value]
    unit = name in "Ee" and all(isinstance(row, list) for row in rows) and rows == _unit(len(rows))
    if not unit and any(number != 0 for number in _flat(rows)):
        instead = "as delay_s, one for all commands" if "Delay" in name else "solve for x first"
        raise InputError(f"controller.{name}: is no part of a law; {instead}")


def _unit(size: int) -> list[list[float]]:
    return [[float(row == column) for column in range(size)] for row in range(size)]


def _flat(value: Any) -> list[Any]:
    return [number for one in value for number in _flat(one)] if isinstance(value, list) else [value]


def _outputs(names: Any, count: int) -> tuple[list[str], list[int] | None]:
    """Names of the commands as a law's own file has them, and which rows of the system they are, where moved."""
    usual = list(valve_commands(MOUNTS))
    if names is None:
        if count == len(usual):
            return usual, None
        raise InputError(
            f"controller.outputs: are missing; name the {count} of them after the mounts whose valves they command"
        )
    names = _named(names)
    if not all(isinstance(name, str) for name in names):
        raise InputError("controller.outputs: must be a list of names, such as 'valve_command front-left'")
    full = [f"valve_command {name.removeprefix('valve_command').strip()}" for name in names]
    if sorted(full) == sorted(usual) and full != usual:
        return usual, [full.index(name) for name in usual]
    return full, None


def _picked(key: str, rows: Any, order: Sequence[int] | None) -> Any:
    if order is None or not rows:
        return rows
    if not isinstance(rows, list) or len(rows) != len(order):
        raise InputError(f"controller.{key}: has not one row for each of {len(order)} outputs")
    return [rows[k] for k in order]


def _columns(key: str, rows: Any, order: Sequence[int]) -> list[list[Any]]:
    if not isinstance(rows, list) or not all(isinstance(row, list) and len(row) == len(order) for row in rows):
        raise InputError(f"controller.{key}: has not one column for each of {len(order)} outputs")
    return [[row[k] for k in order] for row in rows]


def _beyond(text: Any) -> dict[str, Any]:
    """What no matrix holds, from a text in JSON."""
    if text is None or text == "":
        return {}
    try:
        found = json.loads(text)
    except (TypeError, ValueError, RecursionError) as error:
        raise InputError(f"controller.{BEYOND}: must be JSON as an export has it ({error})") from error
    if not isinstance(found, dict):
        raise InputError(f"controller.{BEYOND}: must be one JSON object")
    check_keys(f"controller.{BEYOND}", found, OWN[-4:])
    return found


def _check_units(table: Mapping[str, Any], law: Mapping[str, Any]) -> None:
    """Refuse units in which a law here does not read or command."""
    wanted = {"InputUnit": _named(law["inputs"]), "OutputUnit": law["outputs"]}
    for key, names in wanted.items():
        for name, unit in zip(names, _named(table.get(key)), strict=False):
            _check_channel(name, law["outputs"])
            own = plain_unit(signal_units([name])[0])
            if unit and plain_unit(str(unit)) != own:
                raise InputError(f"controller.{key}: {name!r} is in {unit!r}; it must be in {own}")
    for unit in _named(table.get("TimeUnit")):
        if unit not in ("seconds", "s", ""):
            raise InputError(f"controller.TimeUnit = {unit!r}: must be seconds")


def _check_channel(name: str, outputs: Sequence[str]) -> None:
    """Refuse what is no channel, before it is asked for its unit."""
    if name in outputs:
        return
    try:
        check_channel(name, tuple(one.removeprefix("valve_command ") for one in outputs))
    except UnknownChannelError as error:
        raise InputError(f"controller.inputs: {error}") from error


def _named(given: Any) -> list[Any]:
    """Names as a list; of one, and of none."""
    return given if isinstance(given, list) else [] if given is None else [given]
