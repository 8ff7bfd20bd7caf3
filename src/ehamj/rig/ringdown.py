"""Ring-down: free decays of a simulated machine after jolts of the floor, and the modes in them."""

import math
from typing import Any, Final

import numpy as np

from ehamj.arrays import Array
from ehamj.estimate.identification import Estimates, realise
from ehamj.plant.axes import DOFS
from ehamj.rig.plan import Plan, with_noise
from ehamj.run.many import observe_many
from ehamj.run.simulate import Observed
from ehamj.scenario.load import changed
from ehamj.scenario.model import Scenario

PULSE = 0.7e-3
"""Duration of the floor's jolt [s]; it excites up to about 1 kHz."""
BEGIN: Final = 1e-3
"""Time at which it begins [s]."""
JOLTS = {"x": 5e-4, "y": 4e-4, "z": 3e-4, "rx": 4e-4, "ry": 3e-4, "rz": 6e-4}
"""Peak velocity of the jolt in each degree of freedom [m/s, rad/s]: micrometres, where the machine is linear."""
RING_ORDERS: Final = range(18, 27, 2)
"""Orders of the eigensystem realisation that must agree."""
FAINT: Final = 1e-3
"""Share of the strongest oscillation in a decay, from which on one counts: what is fainter is distortion."""


def jolt(dof: str) -> dict[str, Any]:
    """The floor's jolt in one degree of freedom, which leaves it displaced."""
    return {
        "kind": "shock", "dof": dof, "velocity": JOLTS[dof], "pulse_time": PULSE, "begin": BEGIN, "return_time": 1e6
    }  # fmt: skip


def step_for(rate: float, longest: float = 1e-4) -> float:
    """Integration step [s], a whole part of the time between rows at ``rate`` [Hz] and at most ``longest``."""
    return float(1.0 / rate / np.ceil(1.0 / (longest * rate) - 1e-9))


def decay(run: Observed, *dofs: str) -> Array:
    """Displacement of the mount plane's centre about its rest from the end of jolts in ``dofs`` on, (n, 6) [m, rad]."""
    motion = run.dataset["machine_displacement"]
    moved = [JOLTS[dof] * 2 * PULSE / np.pi if dof in dofs else 0.0 for dof in DOFS]  # where the floor has come to rest
    after = slice(BEGIN + PULSE + 0.5 / run.scenario.record_rate, None)
    return np.asarray((motion - motion[0]).sel(time=after).values - moved)


def ring_down(scenario: Scenario, plan: Plan, realisations: int, noise: float) -> tuple[list[Estimates], str]:
    """Fits of eigensystem realisation to free decays, valves held, and how they were made, in words."""
    rate = 1000.0 * math.ceil(5.0 * plan.high / 1000.0)
    duration = math.ceil(1.4 / plan.decay * 1000.0) / 1000.0
    values = {"record_rate": rate, "duration": duration, "timestep": step_for(rate, plan.step)}
    runs = observe_many((changed(scenario, values | {"ground": jolt(dof)}) for dof in JOLTS), lambda run: run)
    decays = np.array([decay(run, dof) for dof, run in zip(JOLTS, runs, strict=True)])
    fits = []
    for k in range(realisations):
        noisy = with_noise(decays, noise, scenario.seed, k)
        size = np.abs(noisy).max(axis=(0, 1))
        for poles, shapes in realise(noisy / size, rate, RING_ORDERS):
            strength = np.abs(shapes).max(axis=0)
            strong = strength > FAINT * strength.max()
            fits.append(plan.within(poles[strong], size[:, None] * shapes[:, strong]))
    words = f"free decays of {duration:g} s after a jolt of the floor in each direction"
    words += f", eigensystem realisation, {len(fits)} fits"
    return fits, words
