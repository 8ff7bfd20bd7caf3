"""What faults made of a run: its parts before, while they settle and after, and what was to be expected."""

import math
from collections.abc import Sequence

import numpy as np
import xarray as xr

from ehamj.columns import finite
from ehamj.control import PythonController
from ehamj.faults.sensor import SensorFault
from ehamj.faults.valve_stuck import ValveStuck
from ehamj.judge.faults import NOTHING, Expectation, FaultFound, Phase
from ehamj.judge.levels import LEAST_ROWS, duration_of
from ehamj.judge.verdicts import decided_after
from ehamj.plant.plant import Plant
from ehamj.run.expected import expected
from ehamj.run.faults import Struck
from ehamj.run.phases import part_of, phase
from ehamj.run.prepare import Prepared

OFTEN = 0.01
"""Share of the time at a limit after a fault from which it is worth a word."""
GROWN = 10.0
"""Strokes after a fault over those before, from which they are worth a word."""


def aftermath(prepared: Prepared, struck: Sequence[Struck], dataset: xr.Dataset) -> list[FaultFound]:
    """What each fault made of the run, in order.

    Args:
        prepared: what was simulated.
        struck: faults that struck.
        dataset: channels of the run.
    """
    end = duration_of(dataset)
    found: list[FaultFound] = []
    before_s = 0.0
    for k, one in enumerate(struck):
        until = struck[k + 1].time if k + 1 < len(struck) else end + 0.5 / prepared.scenario.record_rate
        due = one.time + one.fault.lasts
        settled_s = min(due, until)
        after = _phase(prepared, dataset, (settled_s, until))
        span = (settled_s, until) if after else (before_s, until)
        expectation, note = linear(prepared, struck[: k + 1], dataset, span)
        if expectation is not None and after is None:  # the run did something else there
            expectation = expectation.model_copy(update={"run_db": {}})
        lacks_time = after is None and k + 1 == len(struck) and end > prepared.scenario.duration - 1e-3
        found.append(
            FaultFound(
                kind=one.fault.kind,
                where=one.fault.where,
                time_s=one.time,
                what=one.fault.what,
                opening=_opening(one),
                channels=list(one.channels),
                before=_phase(prepared, dataset, (before_s, one.time)),
                during=_phase(prepared, dataset, (one.time, settled_s), transient=True),
                after=after,
                settled_s=due,
                needed_s=_needed(prepared, due) if lacks_time else None,
                idle=_idle(one, dataset),
                expected=expectation,
                note=note,
            )
        )
        before_s = settled_s
    return found


def _needed(prepared: Prepared, settled_s: float) -> float:
    """Duration of a run that judges what comes after a time [s]."""
    motion, norm = prepared.motion, next(iter(prepared.norms.values()))
    length = decided_after(norm, prepared.scenario.record_rate, motion.usable_to, motion.usable_from)
    return float(math.ceil(settled_s - 1e-9) + length)


def _idle(one: Struck, dataset: xr.Dataset) -> bool:
    """Whether a fault changed nothing: a valve stuck that never moved nor was told to, a sensor that nothing reads."""
    if isinstance(one.fault, SensorFault):
        return not one.channels
    if not isinstance(one.fault, ValveStuck):
        return False
    own = (dataset[name].sel(mount=one.fault.mount).values for name in ("spool", "valve_command"))
    return all(bool(np.all(values == values[:1])) for values in own)


def _opening(one: Struck) -> float | None:
    """Where a valve sticks, as share of its spool's stroke; None of other faults."""
    if not isinstance(one.fault, ValveStuck):
        return None
    return one.plant.actuators[one.plant.mounts.index(one.fault.mount)].spool_stuck_at


def _phase(prepared: Prepared, dataset: xr.Dataset, span: tuple[float, float], transient: bool = False) -> Phase | None:
    scenario, motion = prepared.scenario, prepared.motion
    usable = motion.usable_from, motion.usable_to
    return phase(dataset, scenario.plant, scenario.record_rate, span, prepared.norms, usable, transient)


def linear(
    prepared: Prepared, struck: Sequence[Struck], dataset: xr.Dataset, span: tuple[float, float]
) -> tuple[Expectation | None, str]:
    """What the linear machine with these faults does from one time to another [s]; in words why it is not known."""
    if isinstance(prepared.controller, PythonController):
        return None, "no linear expectation: the law is a Python function"
    plant: Plant = prepared.scenario.plant
    until = max(span[1], struck[-1].time + struck[-1].fault.lasts)
    for one in struck:
        plant = one.fault.settled(plant, one.spools, until - one.time)
    usable = prepared.motion.usable_from, prepared.motion.usable_to
    faults, part = [one.fault for one in struck], part_of(dataset, *span)
    if part.time.size < LEAST_ROWS:
        return None, "no linear expectation: the run is too short for one"
    if not all(finite(part[name].variable) for name in ("ground_velocity", "cg_velocity", "valve_command")):
        return None, "no linear expectation: the run is not finite"
    return expected(prepared.scenario, plant, prepared.law, faults, part, usable)


def warnings(found: Sequence[FaultFound]) -> list[str]:
    """In words: what struck, that levels of the whole run mix what was before and after, and what ran away."""
    if not found:
        return []
    said = [f"fault {one.in_words()}" + (f": {NOTHING}" if one.idle else "") for one in found]
    found = [one for one in found if not one.idle]
    if not found:
        return said
    said.append(
        "levels, classes and attenuation of the whole run mix the machine before and after its faults: the parts of "
        "the run are judged by themselves in the section on faults (summary.json: fault)"
    )
    for one in found:
        said += _runaway(one)
        if one.note:
            said.append(f"fault {one.in_words()}: {one.note}")
    return said


def _runaway(one: FaultFound) -> list[str]:
    said, last = [], one.after or one.during
    if one.expected is not None and not one.expected.stable:
        said.append(f"after the fault {one.in_words()}, the loop is unstable: {one.expected.pole}")
    if last is None:
        return said
    for limit, words in (("command", "commands are at their limit"), ("cavitation", "oil cavitates")):
        mount, share = max(last.saturation[limit].items(), key=lambda item: item[1])
        known = 0.0 if one.before is None else one.before.saturation[limit][mount]
        if share >= OFTEN and share > 2.0 * known:
            said.append(
                f"after the fault {one.in_words()}, {words} for {100 * share:.3g} % of the time ({mount}), before for "
                f"{100 * known:.3g} %"
            )
    if one.before is not None:
        mount, stroke = max(last.stroke.items(), key=lambda item: item[1] or 0.0)
        usual = max((value or 0.0 for value in one.before.stroke.values()), default=0.0)
        if stroke is not None and stroke > GROWN * max(usual, np.finfo(float).tiny) and stroke > 1e-6:
            said.append(
                f"after the fault {one.in_words()}, strokes run off to {1e6 * stroke:.3g} µm from equilibrium "
                f"({mount}); before it {1e6 * usual:.3g} µm"
            )
    return said
