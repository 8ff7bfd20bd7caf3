"""Single numbers of a run's summary, by the keys that lead to them: what of the run they need is computed, alone.

A summary takes longer than most short runs. Of many runs a few numbers are wanted, alike to the bit.
"""

from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any, Final, NamedTuple

import numpy as np
import xarray as xr

from ehamj.criteria import vc
from ehamj.criteria.curves import CANDIDATES
from ehamj.errors import SimulationFailed
from ehamj.judge.attenuation import attenuation_along
from ehamj.judge.extremes import peak_and_rms
from ehamj.judge.levels import Loudness, known_bands, motions_of
from ehamj.judge.summary import Summary
from ehamj.plant.axes import AXES
from ehamj.run.drive import Driven
from ehamj.run.failures import failure
from ehamj.run.limits import at_limit, oil, saturation
from ehamj.run.observe import observe
from ehamj.run.prepare import Prepared
from ehamj.run.simulate import seen
from ehamj.run.summarise import loop_margins, loops_about_spools, summarise
from ehamj.stopped import DONE

Path = tuple[str, ...]
"""Keys of a summary that lead to a number."""

MOVED: Final = {"machine": "cg_velocity", "feet": "foot_velocity"}
"""Channel of a place; that of points has its own."""


@dataclass(frozen=True)
class Run:
    """A run of which figures are wanted, with the channels that they need."""

    prepared: Prepared
    driven: Driven
    dataset: xr.Dataset

    @property
    def states(self) -> int:
        """How many states were counted of a run that is complete: one before each step, and the last one."""
        return max(self.driven.stopped.steps + 1, 1)

    @cached_property
    def heard(self) -> Loudness:
        """Its levels in bands."""
        motion, scenario = self.prepared.motion, self.prepared.scenario
        known = known_bands(motion.usable_from, motion.usable_to)
        return Loudness(self.dataset, scenario.plant, scenario.record_rate, known)


class Figure(NamedTuple):
    """A part of a summary that is found by itself: what stands below some of its first keys."""

    keys: int
    """How many of them tell it from others."""
    channels: Callable[[Path], Collection[str]]
    """That it needs, by these keys."""
    found: Callable[[Run, Path], Any]
    """What stands there, nested as in the summary."""


def _nothing(_: Path) -> Collection[str]:
    return ()


def _attenuation(run: Run, path: Path) -> Any:
    place, motion = (None, path[1]) if path[0] == "attenuation_db" else (path[1], path[2])
    return attenuation_along(run.heard, place, motion)


def _moved(path: Path) -> Collection[str]:
    """Channels for the attenuation of a motion of the machine, or at a place."""
    if path[0] == "attenuation_db":
        return "ground_velocity", "cg_velocity" if path[1] in AXES else "machine_velocity"
    return "ground_velocity", MOVED.get(path[1], "point_velocity")


def _timing(run: Run, _: Path) -> Any:
    steps, prepared = run.driven.stopped.steps, run.prepared
    return {"steps": steps, "timestep_s": prepared.timestep, "simulated_s": float(run.dataset.time[-1])}


def _limits(run: Run, _: Path) -> Any:
    scenario = run.prepared.scenario
    return at_limit(run.dataset, scenario.plant, scenario.record_rate)


def _extreme(run: Run, path: Path) -> Any:
    found = peak_and_rms(run.dataset[[path[1]]])[path[0] == "rms"]
    return found[path[1]]


def _flow(run: Run, _: Path) -> Any:
    """Oil that all valves together pass, half of what they pass at both chambers [m³/s]."""
    passed = 0.5 * np.abs(run.dataset["chamber_flow"].values).sum(axis=(1, 2))
    return {"rms": float(np.sqrt((passed**2).mean())), "peak": float(passed.max())}


def _power(run: Run, _: Path) -> Any:
    """Mean hydraulic power that is drawn from the supply [W]."""
    return oil(run.driven.tally, run.states, run.driven.stopped.steps * run.prepared.timestep).mean_power_w


def _below(run: Run, path: Path) -> Any:
    """By how much the machine's worst place stays below a class of the VC curves along an axis, in the band that comes
    nearest to it [dB]; NaN where a band with a limit is not known."""
    _, name, axis = path
    flat = run.prepared.scenario.criteria.low_frequency == "flat"
    heard, places = run.heard, [place for place in motions_of(run.dataset, "velocity") if place != "floor"]
    limits = {band: value for band in CANDIDATES if (value := vc.limit(name, band, flat)) is not None}
    if not limits.keys() <= set(heard.bands):
        return np.nan
    rows = [heard.bands.index(band) for band in limits]
    levels = [heard.at(place, axis)[rows].reshape(len(rows), -1).max(axis=1) for place in places]
    share = float((np.max(levels, axis=0) / list(limits.values())).max())
    return np.inf if share == 0.0 else -20.0 * np.log10(share)  # NaN stays NaN


FIGURES: Final[Mapping[str, Figure]] = {
    "below": Figure(3, lambda _: ("foot_velocity", "cg_velocity", "point_velocity"), _below),
    "attenuation_db": Figure(2, _moved, _attenuation),
    "attenuation_at_db": Figure(3, _moved, _attenuation),
    "saturation": Figure(
        1, _nothing, lambda run, _: saturation(run.driven.tally, run.states, run.prepared.scenario.plant.mounts)
    ),
    "oil": Figure(
        1,
        _nothing,
        lambda run, _: oil(run.driven.tally, run.states, run.driven.stopped.steps * run.prepared.timestep),
    ),
    "peak": Figure(2, lambda path: (path[1],), _extreme),
    "rms": Figure(2, lambda path: (path[1],), _extreme),
    "at_limit": Figure(1, lambda _: ("valve_command", "spool", "chamber_void"), _limits),
    "margins": Figure(1, _nothing, lambda run, _: loop_margins(run.prepared.scenario, run.prepared.law)[0]),
    "spools": Figure(1, _nothing, lambda run, _: loops_about_spools(run.prepared.scenario, run.prepared.law)[0]),
    "timing": Figure(1, _nothing, _timing),
    "flow": Figure(1, lambda _: ("chamber_flow",), _flow),
    "power": Figure(1, _nothing, _power),
}
"""What of a summary is found by itself, by its first key; "below", "flow" and "power" stand beside it. All else is
taken from a whole summary."""


def figures(prepared: Prepared, driven: Driven, paths: Sequence[Path]) -> dict[Path, float]:
    """Numbers of a run's summary, NaN where it has null or nothing.

    Args:
        prepared: what was simulated.
        driven: what the stepping loop left.
        paths: of the numbers that are wanted.

    Raises:
        SimulationFailed: if the run failed, with what a result says of that.
    """
    run = _run(prepared, driven, paths)
    known: dict[Path, Any] = {}
    found = {}
    for path in paths:
        head = path[: FIGURES[path[0]].keys] if path[0] in FIGURES else ()
        if head not in known:
            known[head] = FIGURES[path[0]].found(run, head) if head else _summary(run)
        found[path] = number_at(known[head], path[len(head) :])
    return found


def _run(prepared: Prepared, driven: Driven, paths: Sequence[Path]) -> Run:
    """A run with the channels that its figures need, none of which failed."""
    alone = all(path[0] in FIGURES for path in paths)
    if driven.rows is None or not alone or not _finite(driven):
        whole = seen(prepared, driven)
        run, failed = Run(prepared, driven, whole.dataset), whole.failed
    else:
        wanted = {channel for path in paths for channel in FIGURES[path[0]].channels(path)}
        wanted |= set() if prepared.scenario.timestep == "auto" else {"chamber_void"}  # tells of a step too long
        run = Run(prepared, driven, observe(prepared, driven.rows, driven.struck, wanted=wanted))
        failed = failure(prepared, driven.stopped, run.dataset, driven.lost)
    if failed is not None:
        raise SimulationFailed(failed)
    return run


def _summary(run: Run) -> Summary:
    return summarise(run.prepared, run.driven, run.dataset, 0.0, None)


def _finite(driven: Driven) -> bool:
    """Whether a run ended with what is finite, in single precision too: what is lost stays lost."""
    if driven.rows is None or driven.stopped.status != DONE:
        return driven.rows is not None
    with np.errstate(over="ignore"):
        return all(bool(np.isfinite(table[-1].astype(np.float32)).all()) for table in driven.rows)


def number_at(found: Any, path: Path) -> float:
    """The number that keys lead to; NaN where there is none."""
    for key in path:
        if not isinstance(found, Mapping) or key not in found:
            return float("nan")
        found = found[key]
    return float(found) if isinstance(found, bool | int | float) else float("nan")
