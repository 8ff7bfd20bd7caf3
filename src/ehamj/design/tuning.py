"""Automatic gains: the highest crossings that leave the required margins on a machine and all its variations.

The loop gain is linear in the crossings, L = Σ f_k L_k + L_0, so that one frequency response per loop and machine
serves every trial. Each crossing in turn is the highest that leaves its motion the margins, twice round; then all come
down together until the disk margin of all valves at once suffices. The law that comes out is judged again as a whole,
with the eigenvalues of its sampled loop.

A loop that can only cross lower needs a lower integral and lead too: each is tried as it is and slowed (`SLOWED`). The
notch stays where it is, since it mostly makes good for the valve's lag: moved with the oil's resonance, it made every
machine that was tried slower (heave from 77 to below 60 Hz at 5200 kg).
"""

from typing import Final

import numpy as np

from ehamj.arrays import Array, ComplexArray
from ehamj.control import blocks
from ehamj.control.inertial import MotionLoop
from ehamj.control.settings import DigitalSettings
from ehamj.design.kinds import DESIGNABLE
from ehamj.errors import InputError
from ehamj.linear.loop import Loop, opened
from ehamj.linear.margins import disk_margin, grid, in_patterns, margins, of_active
from ehamj.linear.modes import modes
from ehamj.plant.plant import Plant
from ehamj.scenario.model import Scenario
from ehamj.synthesis.judged import Design, judged
from ehamj.synthesis.requirements import NOMINAL, Machines, Requirements

Trial = tuple[Array, ComplexArray, dict[str, ComplexArray]]
"""A machine: frequencies [Hz], loop gain of all but the loops, loop gain of each at a crossing of 1 Hz."""

STEP: Final = 1.03
STEPS: Final = 3.0 * STEP ** -np.arange(116.0)
"""Factors on a crossing that are tried, from 3 down to 0.1."""

SLOWED: Final = (1.0, 0.85, 0.7, 0.55, 0.4)
"""Factors on a loop's integral and lead that are tried."""


def tune(scenario: Scenario, machines: Machines, requirements: Requirements | None = None) -> Design:
    """Choose the crossings of a scenario's feedback.

    Args:
        scenario: whose control is tuned: an architecture with loops, or combined with one of them.
        machines: the machine and its variations.
        requirements: margins.

    Raises:
        InputError: if the control has no loop to tune, or no crossing leaves the margins.
    """
    wanted = requirements or Requirements()
    control = scenario.control
    members = control.members if isinstance(control, DigitalSettings) else ()
    tunable = [number for number, member in enumerate(members) if member.loops(scenario.plant)]
    if not isinstance(control, DigitalSettings) or len(tunable) != 1:
        able = [name for name, one in DESIGNABLE.items() if any(member.loops() for member in one.members)]
        raise InputError(
            f"control.kind = {control.kind!r}: has {len(tunable) or 'no'} laws with loops to tune; there must be one "
            f"loop to tune, {', '.join(able[:-1])} or {able[-1]}"
        )
    model = machines[NOMINAL]
    shaped = members[tunable[0]].fitted([(one.name, one.frequency) for one in modes(model)], model.plant.machine.cg[2])
    settings = control.with_member(tunable[0], _raised(shaped, scenario, machines, wanted))
    law = settings.controller(scenario.plant, scenario.sensors)
    return judged(settings, law, scenario.sensors, machines, wanted, scenario.seed)


def _only(settings: DigitalSettings, name: str | None) -> DigitalSettings:
    """The settings with one of their loops; None: with everything but the loops."""
    off = {
        other: loop.model_copy(update={"crossing": 0.0}) for other, loop in settings.loops().items() if other != name
    }
    return settings.model_copy(update=off)


def _raised(settings: DigitalSettings, scenario: Scenario, machines: Machines, wanted: Requirements) -> DigitalSettings:
    trials = _trials(settings, scenario, machines)
    plant, driven = scenario.plant, scenario.plant.central.motions
    loops = dict(settings.loops(plant))
    crossings = {name: loop.crossing for name, loop in loops.items()}
    for turn in range(2):
        for name in loops:
            places = [driven.index(name)] if name in driven else list(range(len(plant.obeying.mounts)))
            shapes = SLOWED if turn == 0 else (1.0,)
            found = _highest(trials, name, loops[name], crossings, shapes, plant, wanted, places, settings.period)
            if found is None:
                raise InputError(
                    f"control: no crossing of the loop {name!r} from {STEPS[-1] * loops[name].crossing:.2g} to "
                    f"{STEPS[0] * loops[name].crossing:.3g} Hz leaves the margins {wanted.gain_margin:g} dB, "
                    f"{wanted.phase_margin:g}° and {wanted.disk_margin:g} on every variation; ask for less, or change "
                    "the shape of the loop"
                )
            crossings[name], loop = found
            if loop != loops[name]:
                trials = [_reshaped(trial, name, loops[name], loop, settings.period) for trial in trials]
                loops[name] = loop
    while not all(
        disk_margin(of_active(_sensitivity(trial, crossings), plant)) >= wanted.disk_margin for trial in trials
    ):
        crossings = {name: value / STEP for name, value in crossings.items()}
        if max(crossings.values()) < 1.0:
            raise InputError(
                f"control: no crossings leave a disk margin of {wanted.disk_margin:g} at all valves at once"
            )
    tuned = {name: loop.model_copy(update={"crossing": crossings[name]}) for name, loop in loops.items()}
    return settings.model_copy(update=tuned)


def _trials(settings: DigitalSettings, scenario: Scenario, machines: Machines) -> list[Trial]:
    """The loop gains of which every trial is made, on each machine."""
    plant, sensors = scenario.plant, scenario.sensors
    everything = settings.controller(plant, sensors)
    rest = _only(settings, None).controller(plant, sensors)
    loops = settings.loops(plant)
    alone = {name: _only(settings, name).controller(plant, sensors) for name in loops}
    trials = []
    for model in machines.values():
        f = grid(everything, model)
        own = opened(model, Loop.of(scenario, rest), f).gain
        # A loop alone still holds what the rest is.
        each = {name: opened(model, Loop.of(scenario, law), f).gain - own for name, law in alone.items()}
        trials.append((f, own, {name: gain / loops[name].crossing for name, gain in each.items()}))
    return trials


def _highest(
    trials: list[Trial], name: str, loop: MotionLoop, crossings: dict[str, float], shapes: tuple[float, ...],
    plant: Plant, wanted: Requirements, places: list[int], period: float,
) -> tuple[float, MotionLoop] | None:  # fmt: skip
    """The best crossing of a loop, and its shape: crossing times the root of what it is slowed by counts, since the
    attenuation is of the crossing above the integral's corner and of its product with the integral below."""
    best, least = None, 0.0
    for by in shapes:
        slower = loop.model_copy(update={"integral": by * loop.integral, "lead": by * loop.lead})
        own = [_reshaped(trial, name, loop, slower, period) for trial in trials]
        for factor in STEPS:
            crossing = float(factor) * loop.crossing
            if crossing * np.sqrt(by) <= least:
                break
            tried = crossings | {name: crossing}
            failed = next((k for k, trial in enumerate(own) if not _leaves(trial, tried, plant, wanted, places)), None)
            if failed is None:
                best, least = (crossing, slower), crossing * np.sqrt(by)
                break
            own.insert(0, own.pop(failed))  # the machine that forbids this one is likely to forbid the next
    return best


def _reshaped(trial: Trial, name: str, loop: MotionLoop, other: MotionLoop, period: float) -> Trial:
    """The trial with another shape of one loop."""
    f, rest, each = trial
    if other == loop:
        return trial
    z = np.exp(2j * np.pi * f * period)
    old, new = (blocks.response(z, *one.block(0.0).sampled(period)) for one in (loop, other))
    return f, rest, each | {name: new / old * each[name]}


def _sensitivity(trial: Trial, crossings: dict[str, float]) -> ComplexArray:
    _, rest, each = trial
    loop = np.asarray(rest + sum(crossings[name] * gain for name, gain in each.items()))
    return np.asarray(np.linalg.inv(np.eye(loop.shape[1]) + loop), complex)


def _leaves(trial: Trial, crossings: dict[str, float], plant: Plant, wanted: Requirements, places: list[int]) -> bool:
    """Whether crossings leave the margins at some patterns of motion, and go round −1 nowhere there (Nyquist)."""
    moved = in_patterns(_sensitivity(trial, crossings), plant)
    for k in places:
        difference = 1.0 / moved[:, k, k]
        if round(float(np.unwrap(np.angle(difference))[-1]) / (2 * np.pi)) != 0:
            return False
        one = margins(trial[0], difference - 1.0)
        if not wanted.met_by((one.gain, one.phase, one.disk)):
            return False
    return True
