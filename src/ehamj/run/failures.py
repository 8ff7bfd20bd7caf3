"""What a run says that failed: where, when and why, and what is kept."""

import numpy as np
import xarray as xr

from ehamj.columns import columns, places
from ehamj.errors import SimulationFailed
from ehamj.judge.levels import duration_of
from ehamj.mujoco.warned import warned
from ehamj.result import Result
from ehamj.run.faults import plants
from ehamj.run.prepare import Prepared
from ehamj.run.timestep import follows
from ehamj.run.unjudged import in_words
from ehamj.smallmotion.advance import LARGEST_TURN
from ehamj.stopped import CHAMBER_1_EMPTY, CHAMBER_2_EMPTY, DONE, LAW_FAILED, TOO_LARGE, Stopped
from ehamj.unfinished import NO_ROOM
from ehamj.variables import first_lost

EMPTY = {CHAMBER_1_EMPTY: 1, CHAMBER_2_EMPTY: 2}
"""Chamber that ran empty, by status."""


class Incomplete(SimulationFailed):
    """A simulation that stopped early; ``result`` holds what was computed until then."""

    def __init__(self, message: str, result: Result) -> None:
        super().__init__(message)
        self.result = result


def failure(prepared: Prepared, stopped: Stopped, dataset: xr.Dataset, lost: Exception | None = None) -> str | None:
    """What went wrong, in words; None where nothing did. ``lost``: why rows could not be made or written, if so."""
    scenario, timestep = prepared.scenario, prepared.timestep
    if lost is not None:
        return _left_out(lost, duration_of(dataset))
    if stopped.status != DONE:
        return _stopped(prepared, stopped, duration_of(dataset))
    if found := not_finite(dataset):
        return found
    if doubt := warned(prepared.data):
        return f"simulation failed: {doubt}. Kept to the end, marked incomplete"
    if scenario.timestep == "auto" or all(follows(plant, timestep) for plant in plants(scenario)):
        return None
    whose = "" if not follows(scenario.plant, timestep) else " of the machine with its faults"
    # It ended although its step is too long: where and when the oil first tore, if it did.
    voids, where = dataset["chamber_void"].variable, ""
    each = zip(places(voids), columns(voids), strict=True)
    torn = [(int(np.argmax(one > 0.0)), at[0]) for at, one in each if one.max() > 0.0]
    if torn:
        row, mount = min(torn)
        where = f" at {float(dataset.time[row]):.6g} s, at {dataset['mount'].values[mount]}"
    return (
        f"simulation failed{where}: timestep = {timestep:g} s is beyond the integrator's stability for the fastest "
        f"mode{whose}, and only voids in the oil kept the motion bounded. Kept to the end, marked incomplete; use "
        "timestep = 'auto' or a shorter one"
    )


def _left_out(lost: Exception, recorded: float) -> str:
    """Of a run whose rows could be made or written until a time [s] only."""
    why, way_out = in_words(lost), ""
    if isinstance(lost, MemoryError):
        why, way_out = "they do not fit in memory", ". Lower record_rate, or end what else takes memory"
    elif isinstance(lost, OSError) and lost.errno in NO_ROOM:
        why = f"{str(lost.filename)!r}: {lost.strerror}"
        way_out = ". Make room there or lower record_rate, and run it again"
    return (
        f"simulation broken off: rows beyond {recorded:.6g} s could not be kept: {why}. Kept until {recorded:.6g} s, "
        f"marked incomplete{way_out}"
    )


def not_finite(dataset: xr.Dataset) -> str | None:
    """Where a channel has what is no number, in words."""
    lost = first_lost(dataset)
    return lost and (
        f"simulation failed at {lost[1]:.6g} s: {lost[0]} is no longer finite. Kept to the end, "
        "marked incomplete; smaller commands or gains may help"
    )


def _stopped(prepared: Prepared, stopped: Stopped, recorded: float) -> str:
    """Of a run that broke off, after ``recorded`` [s]."""
    what, way_out = broken_off(prepared, stopped)
    kept = f"Kept until {recorded:.6g} s, marked incomplete"
    return f"{what}. {kept}. {way_out}" if way_out else f"{what}. {kept}"


def broken_off(prepared: Prepared, stopped: Stopped) -> tuple[str, str]:
    """What broke off the stepping, where and when, and the way out, in words."""
    at = f"simulation failed at {stopped.steps * prepared.timestep:.6g} s"
    if stopped.status == LAW_FAILED:
        error = prepared.loop.failures[0]
        return f"{at}, in the Python controller: {type(error).__name__}: {error}", ""
    if stopped.status == TOO_LARGE:
        return (
            f"{at}, at the machine: it turned by more than {1e3 * LARGEST_TURN:g} mrad, which is no small motion",
            "engine = 'mujoco' follows any turn",
        )
    where = prepared.scenario.plant.mounts[stopped.mount] if stopped.mount >= 0 else "the machine"
    what = "a state is no longer finite"
    if stopped.status in EMPTY:
        chamber = EMPTY[stopped.status]
        what = f"chamber {chamber} ran empty: the stroke left its range, or the step is too long to follow the oil"
    found = f"{at}, at {where}: {what}; step {prepared.timestep:.3g} s"
    return found, "A shorter timestep or smaller commands may help"
