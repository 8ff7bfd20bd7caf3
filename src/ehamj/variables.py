"""What a result's histories are: every variable with its dimensions and units, and which of them a run has."""

from collections.abc import Collection, Mapping, Sequence
from fnmatch import fnmatchcase
from typing import Any, Final

import numpy as np
import xarray as xr

from ehamj.columns import blocks
from ehamj.control import AnyController, LinearController
from ehamj.control.learners import Learnt
from ehamj.errors import InputError, did_you_mean
from ehamj.judge.summary import Summary
from ehamj.memory import LEDGER
from ehamj.plant.axes import AXES, CHAMBERS, DOFS
from ehamj.scenario.model import Scenario

FIXED: dict[str, Sequence[Any]] = {"axis": AXES, "dof": DOFS, "chamber": CHAMBERS}
"""Dimensions whose labels are the same in every result; plant, scenario or controller give the others."""

DIMENSIONS = {
    "axis": "axis",
    "dof": "degree of freedom of the machine, at the mount plane's centre",
    "chamber": "chamber; oil in chamber 1 pushes the plate towards the machine",
    "mount": "mount, by its name (+x front, +y left)",
    "point": "point of the machine",
    "slide_name": "slide of the machine",
    "relative": "relative motion, as named in the scenario",
    "sensor": "channel that the controller reads",
    "law_state": "number of the controller's state",
    "line": "line that the controller follows, as stated [Hz]",
}
"""Long name of each dimension beside ``time``."""

VARIABLES: dict[str, tuple[tuple[str, ...], str, str]] = {
    "ground_displacement": (("mount", "axis"), "m", "displacement of the ground at each mount"),
    "ground_velocity": (("mount", "axis"), "m/s", "velocity of the ground at each mount"),
    "ground_acceleration": (("mount", "axis"), "m/s^2", "acceleration of the ground at each mount"),
    "machine_displacement": (("dof",), "m (rx, ry, rz: rad)", "displacement of the mount plane's centre"),
    "machine_velocity": (("dof",), "m/s (rx, ry, rz: rad/s)", "velocity of the mount plane's centre"),
    "foot_displacement": (("mount", "axis"), "m", "displacement of the machine's foot at each mount"),
    "foot_velocity": (("mount", "axis"), "m/s", "velocity of the machine's foot at each mount"),
    "foot_acceleration": (("mount", "axis"), "m/s^2", "acceleration of the machine's foot at each mount"),
    "cg_displacement": (("axis",), "m", "displacement of the machine's centre of gravity"),
    "cg_velocity": (("axis",), "m/s", "velocity of the machine's centre of gravity"),
    "cg_acceleration": (("axis",), "m/s^2", "acceleration of the machine's centre of gravity"),
    "point_displacement": (("point", "axis"), "m", "displacement of a point of the machine"),
    "point_velocity": (("point", "axis"), "m/s", "velocity of a point of the machine"),
    "point_acceleration": (("point", "axis"), "m/s^2", "acceleration of a point of the machine"),
    "relative_displacement": (("relative", "axis"), "m", "displacement of one place relative to another"),
    "relative_velocity": (("relative", "axis"), "m/s", "velocity of one place relative to another"),
    "stroke": (("mount",), "m", "plate relative to its ground, along the mount's direction"),
    "stroke_velocity": (("mount",), "m/s", "plate relative to its ground, along the mount's direction"),
    "spool": (("mount",), "mA", "spool position"),
    "valve_command": (("mount",), "V", "command to the valve"),
    "actuator_force": (("mount",), "N", "force of the oil on the plate, towards the machine positive"),
    "chamber_pressure": (("mount", "chamber"), "Pa", "absolute pressure in each chamber"),
    "chamber_flow": (("mount", "chamber"), "m^3/s", "flow into each chamber"),
    "supply_pressure": ((), "Pa", "absolute supply pressure"),
    "chamber_void": (("mount", "chamber"), "m^3", "void by cavitation in each chamber"),
    "oil_in": (("mount", "chamber"), "m^3", "oil that entered each chamber since the start, at atmospheric density"),
    "oil_held": (("mount", "chamber"), "m^3", "oil in each chamber, at atmospheric density"),
    "energy_in": ((), "J", "energy that flowed into all chambers since the start"),
    "piston_work": ((), "J", "work of the oil on pistons and walls since the start"),
    "supplied_energy": ((), "J", "energy drawn from the supply since the start"),
    "throttled_energy": ((), "J", "energy lost over edges and leaks since the start"),
    "oil_energy": ((), "J", "energy stored in the oil by compression"),
    "slide": (("slide_name",), "m", "coordinate of a slide along its rail"),
    "external_force": (("dof",), "N (rx, ry, rz: N m)", "force on the machine itself, at its centre of gravity"),
    "measured": (("sensor",), "SI, as the channel", "what the controller last read of each channel"),
    "controller_state": (("law_state",), "1", "states of the controller"),
    "line_frequency": (("line",), "Hz", "frequency that the law follows of each line"),
    "learnt_flow_gain": (("mount",), "1", "flow gain that the law has learnt, over the stated one"),
    "learnt_compliance": (("mount",), "1", "compliance of the oil that the law has learnt, over the stated one"),
    "learnt_overlap": (("mount",), "mA", "overlap of each edge that the law has learnt, more than stated"),
    "learnt_play": (("mount",), "mA", "threshold and half of the hysteresis that the law has learnt, more than stated"),
    "learnt_null_offset": (("mount",), "mA", "null offset that the law has learnt, more than stated"),
}
"""Every variable of a result beside ``time``: further dimensions, units, long name."""

MOTIONS: Final = ("displacement", "velocity", "acceleration")
ALWAYS: Final = (
    *(f"{place}_{motion}" for place in ("ground", "foot", "cg") for motion in MOTIONS),
    *("machine_displacement", "machine_velocity", "stroke", "stroke_velocity", "spool", "valve_command"),
    *("actuator_force", "chamber_pressure", "chamber_flow", "chamber_void", "supply_pressure"),
)
"""What every run has."""


def labels_of(scenario: Scenario, law: AnyController | None) -> dict[str, list[Any]]:
    """What lies along the dimensions of a run's histories that are not `FIXED`, of those that it has."""
    found: dict[str, Sequence[Any]] = {
        "mount": scenario.plant.mounts,
        "point": list(scenario.points),
        "slide_name": [slide.name for slide in scenario.slide],
        "relative": [relative.name for relative in scenario.relative],
        "sensor": law.reads if law is not None else (),
        "law_state": range(law.states) if law is not None else (),
        "line": [line.frequency for line in law.lines] if law is not None else (),
    }
    return {name: list(along) for name, along in found.items() if len(along)}


def variables_of(scenario: Scenario, law: AnyController | None) -> set[str]:
    """Names of all variables that a run of a scenario under a law has."""
    along = labels_of(scenario, law)
    optional = {
        "point": tuple(f"point_{motion}" for motion in MOTIONS),
        "relative": ("relative_displacement", "relative_velocity"),
        "slide_name": ("slide",),
        "sensor": ("measured",),
        "law_state": ("controller_state",),
        "line": ("line_frequency",),
    }
    found = {*ALWAYS, *(name for dimension, names in optional.items() if dimension in along for name in names)}
    if scenario.force:
        found.add("external_force")
    if law is not None and law.converter.learners:
        found |= {f"learnt_{name}" for name in Learnt._fields}
    if scenario.output.bookkeeping:
        found |= {*(LEDGER.names or ()), "oil_in", "oil_held", "oil_energy"}
    return found


def stored_of(patterns: Sequence[str], there: Collection[str]) -> set[str]:
    """Names of the variables that a result's file holds, of those that ``there`` are.

    Args:
        patterns: the scenario's ``output.channels``.
        there: all that the run has.

    Raises:
        InputError: if one of them stands for none, which names those that there are.
    """
    found = set[str]()
    for number, pattern in enumerate(patterns):
        own = {name for name in there if fnmatchcase(name, pattern)}
        if not own:
            raise InputError(
                f"output.channels.{number} = {pattern!r}: {did_you_mean(pattern, there)}must be a channel of this run, "
                f"or stand for some by * and ?: {', '.join(sorted(there))}"
            )
        found |= own
    return found


class Stored(xr.Dataset):
    """Histories of a file that holds some of a run's channels; whoever asks for another is told so."""

    __slots__ = ()

    def __getitem__(self, key: Any) -> Any:
        missing = [str(one) for one in (key if isinstance(key, list) else [key]) if _left_out(self, one)]
        if missing:
            raise InputError(
                f"output.channels: {', '.join(missing)} was not stored with this result; name it there, or leave "
                "output.channels out, and run the result's scenario.toml again"
            )
        return super().__getitem__(key)


def _left_out(dataset: xr.Dataset, name: Any) -> bool:
    return isinstance(name, str) and name in VARIABLES and name not in dataset.variables


def check_histories(dataset: xr.Dataset, scenario: Scenario, law: LinearController | None, summary: Summary) -> None:
    """Refuse histories that are not those of a run; reads one block of rows after another, so that a file may be large.

    Args:
        dataset: as a file holds it, read or not.
        scenario: what was simulated.
        law: that ran; None of none, and of a Python function.
        summary: of the run.

    Raises:
        ValueError: which names the variable, what is wrong with it, and what it must be.
    """
    python = summary.python_law
    wanted, along = variables_of(scenario, law), labels_of(scenario, law)
    if python and "sensor" in dataset.coords:  # what a function reads stands nowhere else
        wanted.add("measured")
        along["sensor"] = dataset["sensor"].values.tolist()
    wanted = stored_of(scenario.output.channels, wanted)
    for name in sorted(wanted ^ set(map(str, dataset.data_vars))):
        raise ValueError(f"{name} is missing" if name in wanted else f"{name} is no variable of this run")
    _check_labels(dataset, {**along, **{name: list(labels) for name, labels in FIXED.items()}})
    for name in sorted(wanted):
        _check_variable(name, dataset[name])
    _check_time(dataset["time"], scenario, summary)
    if summary.complete and (lost := first_lost(dataset)):
        raise ValueError(f"{lost[0]} is not finite at {lost[1]:.6g} s, and the run is said to be complete")


def _check_labels(dataset: xr.Dataset, wanted: Mapping[str, list[Any]]) -> None:
    for name in sorted({"time", *wanted} ^ set(map(str, dataset.coords))):
        raise ValueError(f"{name} is {'missing' if name in {'time', *wanted} else 'no dimension of this run'}")
    for name, labels in wanted.items():
        found = dataset[name]
        if found.dims != (name,) or found.values.tolist() != labels:
            said, be = ", ".join(map(str, found.values.ravel()[:8])), ", ".join(map(str, labels[:8]))
            raise ValueError(f"{name} holds {said}; of this run it must hold {be}, in this order")


def _check_variable(name: str, found: xr.DataArray) -> None:
    further, units, _ = VARIABLES[name]
    dimensions = ("time", *further)
    if found.dims != dimensions:
        raise ValueError(f"{name} lies along {', '.join(map(str, found.dims))}; it must along {', '.join(dimensions)}")
    if found.attrs.get("units") != units:
        raise ValueError(f"{name} is in {found.attrs.get('units')!r}; it must be in {units!r}")
    if found.dtype.kind != "f":
        raise ValueError(f"{name} holds {found.dtype}; it must hold floating-point numbers")


def _check_time(time: xr.DataArray, scenario: Scenario, summary: Summary) -> None:
    """Rows are as many as they must be, and as far apart."""
    rate, timing = scenario.record_rate, summary.timing
    if time.dims != ("time",) or time.dtype.kind != "f" or time.attrs.get("units") != "s":
        raise ValueError("time must be numbers in s along itself")
    every = round(1.0 / (rate * timing.timestep_s))
    whole = round(scenario.duration / timing.timestep_s) // max(every, 1) + 1
    if time.size > whole or (summary.complete and time.size < whole):
        raise ValueError(
            f"time has {time.size} rows; a complete run of {scenario.duration:g} s at record_rate = {rate:g} Hz has "
            f"{whole}"
        )
    off = np.abs(time.values * rate - np.arange(time.size))
    wrong = np.flatnonzero(~(off < 1e-6))
    if wrong.size:
        raise ValueError(
            f"time is {time.values[wrong[0]]:.9g} s in row {wrong[0]}; it must run from 0 in steps of "
            f"1/record_rate = {1.0 / rate:g} s"
        )


def first_lost(dataset: xr.Dataset) -> tuple[str, float] | None:
    """The first variable with what is no finite number, and the time of its row [s]; None where there is none."""
    for name, channel in dataset.data_vars.items():
        for rows in blocks(channel.sizes["time"]):
            values = channel[rows].values
            with np.errstate(invalid="ignore", over="ignore"):  # a sum tells sooner whether any is lost
                total = values.sum()
            if np.isfinite(total) or np.isfinite(values).all():
                continue
            row = rows.start + int(np.argwhere(~np.isfinite(values))[0][0])
            return str(name), float(dataset["time"][row])
    return None
