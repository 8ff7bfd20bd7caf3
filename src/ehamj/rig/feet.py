"""Modes in the responses of the feet: to noise or a sweep of the floor, or to a hammer on an upper corner."""

import math
from collections.abc import Callable
from typing import Any, Final, NamedTuple

import numpy as np

from ehamj.arrays import ComplexArray
from ehamj.estimate.identification import Estimates, polyreference, residues
from ehamj.linear.response import TURNS, lever_scale
from ehamj.plant.axes import AXES, DOFS
from ehamj.plant.levers import slab_fit
from ehamj.plant.plant import Plant
from ehamj.rig.plan import Plan, with_noise
from ehamj.run.many import observe_many
from ehamj.run.simulate import Observed
from ehamj.scenario.load import changed
from ehamj.scenario.model import Scenario

LEVEL: Final = 5e-6
"""RMS velocity of each line of a random excitation [m/s]; of a rotation, at the mounts' mean distance."""
SWEEP_SPEED: Final = 5e-4
"""Peak velocity at the end of a sweep [m/s]."""
BLOW: Final = 2000.0
"""Peak force of a hammer [N]: the machine moves by micrometres."""
BLOW_WIDTH: Final = 0.8
"""Duration of a blow times the highest frequency of the band [-]: there half of the spectrum's height is left."""
POLES: Final = range(36, 73, 6)
"""Numbers of poles that fits of responses have, and which must agree."""


class Excitation(NamedTuple):
    """One way to excite a machine, one input after the other."""

    words: str
    inputs: tuple[str, ...]
    """Directions of the floor, or of the hammer."""
    motion: str
    """Of the feet that is fitted. Velocities are as large in one line as in the other."""
    table: Callable[[Scenario, Plan, str, int], dict[str, Any]]
    """Ground or force, and duration, by scenario, plan, input and realisation."""


def _noise(scenario: Scenario, plan: Plan, name: str, realisation: int) -> dict[str, Any]:
    """A multisine of random phases on all lines, of which one period is fitted when the beginning is over."""
    f = plan.lines
    random = np.random.default_rng([scenario.seed, realisation, DOFS.index(name)])
    ground = {"kind": "multisine", "dof": name, "frequencies": f.tolist()}
    ground["phases"] = random.uniform(0.0, 2.0 * np.pi, f.size).tolist()
    ground["velocities"] = [LEVEL / _scale(scenario.plant, name)]
    return {"ground": ground, "duration": plan.over + 1.0 / plan.spacing}


def _sweep(scenario: Scenario, plan: Plan, name: str, realisation: int) -> dict[str, Any]:
    """An exponential sweep of the floor through the band."""
    growth = math.log(plan.high / plan.low)
    turns = math.ceil(2.0 * (plan.high - plan.low) / growth)  # whole turns: the sweep ends where it began
    time = turns * growth / (plan.high - plan.low)
    ground = {"kind": "sweep", "dof": name, "first": plan.low, "last": plan.high, "sweep_time": time}
    ground["amplitude"] = SWEEP_SPEED / (2 * np.pi * plan.high) / _scale(scenario.plant, name)
    return {"ground": ground, "duration": math.ceil(time * plan.spacing) / plan.spacing + plan.over}


def _hammer(scenario: Scenario, plan: Plan, name: str, realisation: int) -> dict[str, Any]:
    """A blow on an upper corner."""
    length, width, height = scenario.machine.size
    blow = {"kind": "hammer", "point": [0.45 * length, 0.45 * width, 0.9 * height], "peak": BLOW}
    blow["direction"] = [float(axis == name) for axis in AXES]
    blow |= {"begin": 10 * plan.step, "pulse_time": plan.step * max(4, round(BLOW_WIDTH / plan.high / plan.step))}
    return {"force": [blow], "duration": plan.over}


EXCITATIONS: Final = {
    "random": Excitation("periodic noise of the floor", DOFS, "velocity", _noise),
    # A sweep's floor ends with a jump of velocity: displacements there.
    "sweep": Excitation("sweep of the floor", DOFS, "displacement", _sweep),
    "hammer": Excitation("hammer on a corner", AXES, "velocity", _hammer),
}


def responses(
    scenario: Scenario, kind: str, plan: Plan, realisations: int, noise: float
) -> tuple[list[Estimates], str]:
    """Fits of pLSCF to responses of the feet under one of `EXCITATIONS`, and how they were made, in words."""
    way, plant = EXCITATIONS[kind], scenario.plant
    steps = {"record_rate": 1.0 / plan.step, "timestep": plan.step}
    cases = (
        changed(scenario, steps | way.table(scenario, plan, name, realisation))
        for realisation in range(realisations)
        for name in way.inputs
    )
    runs = observe_many(cases, lambda run: run)
    fits, to_centre = [], slab_fit(plant.positions)
    for realisation in range(realisations):
        columns = [
            _response(runs[realisation * len(way.inputs) + k], name, kind, plan, noise, [scenario.seed, realisation, k])
            for k, name in enumerate(way.inputs)
        ]
        response = np.stack(columns, axis=-1)
        if kind != "hammer":
            response = response / np.array([_scale(plant, name) for name in way.inputs])
        for order in (count // len(way.inputs) for count in POLES):
            poles = polyreference(plan.lines, response, order)
            fit = plan.within(poles, np.zeros((1, poles.size), complex))
            shapes = to_centre @ residues(plan.lines, response, fit.poles)
            fits.append(Estimates(fit.poles, shapes))
    band = f"{plan.lines[0]:.0f} to {plan.lines[-1]:.0f} Hz, lines {plan.spacing:.3g} Hz apart"
    return fits, f"{way.words}, {band}, pLSCF, {len(fits)} fits of {realisations} records"


def _scale(plant: Plant, name: str) -> float:
    """By what a degree of freedom of the floor is divided, so that the mounts move alike: 1, or a distance [m]."""
    return lever_scale(plant) if name in TURNS else 1.0


def _response(run: Observed, name: str, kind: str, plan: Plan, noise: float, seed: list[int]) -> ComplexArray:
    """Motion of the feet over that of the floor in one degree of freedom, or over the force, (line, mount·axis)."""
    time, rate, motion = run.dataset.sizes["time"], run.scenario.record_rate, EXCITATIONS[kind].motion
    # Of noise, one period; of what begins and ends at rest, everything.
    count = round(rate / plan.spacing) if kind == "random" else time - 1
    feet = run.dataset[f"foot_{motion}"].values.reshape(time, -1)[-count:]
    if kind == "hammer":
        given = run.dataset["external_force"].values[-count:, DOFS.index(name)]
    else:
        floor = run.dataset[f"ground_{motion}"].values.reshape(time, -1)[-count:]
        given = floor @ slab_fit(run.scenario.plant.positions)[DOFS.index(name)]
    answers = with_noise(feet - feet[-1], noise, *seed)
    index = np.round(plan.lines * count / rate).astype(int)
    return np.asarray(np.fft.rfft(answers, axis=0)[index] / np.fft.rfft(given)[index, None])
