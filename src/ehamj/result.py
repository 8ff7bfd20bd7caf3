"""A labelled result, and its files: ``result.nc``, ``summary.json``, ``scenario.toml``, ``model.xml``."""

import contextlib
import json
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from html import escape
from pathlib import Path
from typing import Any, Self

import numpy as np
import xarray as xr

from ehamj import growing
from ehamj.control import LinearController, load_controller
from ehamj.errors import InputError
from ehamj.folders import RESULT_FILES, SAVING
from ehamj.growing import Kept
from ehamj.judge.brief import brief
from ehamj.judge.summary import Summary
from ehamj.plain.hdf5 import LARGEST, check_hdf5
from ehamj.plain.text import json_of, text_of
from ehamj.plain.xml import check_xml
from ehamj.plant.axes import AXES, CHAMBERS, DOFS
from ehamj.scenario.load import load_scenario
from ehamj.scenario.model import Scenario
from ehamj.unfinished import HELD, beside, check_room, clear_leftovers, remove

CONTROLLER_FILE = "controller.json"

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


@dataclass(frozen=True, repr=False)
class Result:
    """What a simulation gave.

    ``dataset`` holds the time histories (`VARIABLES`), ``summary`` the numbers a person asks for first,
    ``model_xml`` the compiled model as MJCF, ``controller`` the law that ran (none of a Python
    function, which no file can hold).
    """

    scenario: Scenario
    dataset: xr.Dataset
    summary: Summary
    model_xml: str = field(repr=False, default="")
    controller: LinearController | None = field(repr=False, default=None)
    kept: Kept | None = field(repr=False, default=None)
    """The file that the channels of a long run are read from."""

    @property
    def complete(self) -> bool:
        """Whether the simulation reached its end."""
        return self.summary.complete

    def in_memory(self) -> Self:
        """The same with all channels in memory, which pages and recordings need; raises InputError where they do not
        fit."""
        return self if self.kept is None else replace(self, dataset=self.kept.load(), kept=None)

    def __repr__(self) -> str:
        state = "complete" if self.complete else "INCOMPLETE"
        return f"<ehamj.Result {self.scenario.name!r}: {self.summary.timing.simulated_s:g} s, {state}>"

    def __str__(self) -> str:
        """The result in ten lines."""
        return "\n".join(f"{name + ':':14}{text}" for name, text in brief(self.summary).items())

    def _repr_html_(self) -> str:
        """The same ten lines, as a notebook shows them."""
        rows = (
            f'<tr><th style="text-align:left">{escape(name)}</th><td style="text-align:left">{escape(text)}</td></tr>'
            for name, text in brief(self.summary).items()
        )
        return f"<table>{''.join(rows)}</table>"

    def save(self, folder: str | Path, overwrite: bool = False, variants: "Iterable[Result]" = ()) -> None:
        """Write the folder that ``ehamj run`` writes, with report and replay as the scenario's ``output`` asks.

        Args:
            folder: to be made; one that is there must be empty, or a result and ``overwrite`` given.
            overwrite: whether another result may be replaced.
            variants: results of variants that the scenario's ``compare`` names (``scenario.variant("passive")``), which
                are shown beside it and get folders of their own.

        Raises:
            InputError: if the folder cannot be written, or a variant is none of the scenario's.
        """
        for saving in SAVING:
            saving(self, folder, overwrite, variants)

    def write(self, folder: Path) -> None:
        """Write the result's files into an existing folder, each renamed into place when it is whole."""
        summary = json.dumps(self.summary.to_dict(), indent=2, allow_nan=False) + "\n"
        texts = {"scenario.toml": self.scenario.to_toml(), "model.xml": self.model_xml, "summary.json": summary}
        if self.controller is not None:
            with written_whole(folder / CONTROLLER_FILE) as path:
                self.controller.save(path)
        with written_whole(folder / "result.nc") as path:
            if self.kept is not None and self.kept.dataset is self.dataset:
                self.kept.put(path)
            else:
                check_room(path, self.dataset.nbytes)
                # Uncompressed: noise-like histories shrink by a sixth only, at the price of seconds.
                self.dataset.to_netcdf(path, engine="h5netcdf")
        for name, text in texts.items():
            with written_whole(folder / name) as path:
                path.write_text(text, encoding="utf-8")


def check_result(folder: str | Path) -> Path:
    """A folder, checked to hold the files of a result; raises InputError otherwise."""
    folder = Path(folder)
    if not folder.exists():
        raise InputError(f"result {str(folder)!r}: there is no such folder")
    missing = [name for name in RESULT_FILES if not (folder / name).is_file()]
    if missing:
        raise InputError(f"result {str(folder)!r}: is no result folder, {missing[0]} is missing")
    return folder


def load_result(folder: str | Path) -> Result:
    """Read a result folder; channels of a long run are read when they are asked for (`ehamj.growing.Kept`).

    Raises:
        InputError: if the folder is not a result, damaged, or its summary is not one of today's.
    """
    folder = check_result(folder)
    try:
        kept, dataset = _channels_of(folder / "result.nc")
        summary = json_of(folder / "summary.json")
        model = _model_of(folder / "model.xml")
    except Exception as error:  # h5py and xarray raise what they like at damage
        raise InputError(f"result {str(folder)!r}: is damaged: {error}") from error
    return Result(
        scenario=load_scenario(folder / "scenario.toml"),
        dataset=dataset,
        summary=Summary.read(summary, f"result {str(folder)!r}: summary.json"),
        model_xml=model,
        controller=load_controller(law) if (law := folder / CONTROLLER_FILE).is_file() else None,
        kept=kept,
    )


def _channels_of(path: Path) -> tuple[Kept | None, xr.Dataset]:
    """Stored channels in memory, or, of a long run, as they are asked for, in a file that is kept open."""
    size = path.stat().st_size
    check_hdf5(path, max(LARGEST, 2 * size))  # what is not compressed unfolds to what is there
    kept = Kept.of(path)
    if size > growing.IN_MEMORY:
        return kept, kept.dataset
    with kept.dataset as stored:
        return None, stored.load()


def _model_of(path: Path) -> str:
    """The stored model, if there is one; raises ValueError where it would draw in other files."""
    if not path.is_file():
        return ""

    def alone(name: str, attributes: dict[str, str]) -> None:
        if name in ("include", "plugin") or "file" in attributes:
            raise ValueError(f"model.xml: <{name}> draws in another file")

    text = text_of(path)
    check_xml(text.encode(), alone)
    return text


@contextlib.contextmanager
def written_whole(path: Path) -> Iterator[Path]:
    """A temporary name beside ``path`` to write to; renamed to ``path`` at the end, removed on failure."""
    clear_leftovers(path.parent)
    temporary = beside(path)
    HELD.add(temporary)
    try:
        yield temporary
        temporary.replace(path)
    finally:
        remove(temporary)


def make_dataset(
    time: np.ndarray,
    values: dict[str, np.ndarray],
    attributes: dict[str, Any],
    labels: Mapping[str, Sequence[Any]],
) -> xr.Dataset:
    """Label arrays of shape (time, …) with dimensions, units and names; ``values`` are keyed as `VARIABLES`.

    ``labels`` names what lies along the `DIMENSIONS` that are not `FIXED`, of those that the result has.
    """
    data = {}
    for name, array in values.items():
        dimensions, units, long_name = VARIABLES[name]
        data[name] = (("time", *dimensions), array, {"units": units, "long_name": long_name})
    coordinates: dict[str, Any] = {"time": ("time", time, {"units": "s", "long_name": "time"})}
    for name, along in {**labels, **FIXED}.items():
        coordinates[name] = (name, list(along), {"long_name": DIMENSIONS[name]})
    return xr.Dataset(data, coordinates, attributes)
