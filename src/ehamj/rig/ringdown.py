"""Ring-down: free decays of a simulated machine after jolts of the floor, and the modes in them."""

import math
from typing import Any, Final

import numpy as np

from ehamj.arrays import Array
from ehamj.estimate.identification import Estimates, realise
from ehamj.plant.axes import DOFS
from ehamj.rig.plan import Plan, with_noise
from ehamj.run.simulate import simulate_many
from ehamj.scenario.load import parse_scenario
from ehamj.scenario.model import Scenario

PULSE = 0.7e-3
"""Duration of the floor's jolt [s]; it excites up to about 1 kHz."""
JOLTS = {"x": 5e-4, "y": 4e-4, "z": 3e-4, "rx": 4e-4, "ry": 3e-4, "rz": 6e-4}
"""Peak velocity of the jolt in each degree of freedom [m/s, rad/s]: micrometres, where the machine is linear."""
RING_ORDERS: Final = range(18, 27, 2)
"""Orders of the eigensystem realisation that must agree."""
FAINT: Final = 1e-3
"""Share of the strongest oscillation in a decay, from which on one counts: what is fainter is distortion."""


def free_decays(scenario: Scenario, duration: float = 0.12, rate: float = 4000.0, longest_step: float = 1e-4) -> Array:
    """Displacement of the mount plane's centre about its rest after jolts of the floor, one in each direction.

    Args:
        scenario: the machine; its ground and control are replaced.
        duration: of each simulation [s].
        rate: recording rate [Hz].
        longest_step: integration step [s] that is not exceeded.

    Returns:
        (jolt, n, 6) [m, rad], from the end of the jolt on.
    """
    table: dict[str, Any] = scenario.model_dump() | {"control": {"kind": "passive"}, "compare": ()}
    table |= {
        "record_rate": rate,
        "duration": duration,
        "timestep": 1.0 / rate / np.ceil(1.0 / (longest_step * rate) - 1e-9),
    }
    jolt = {"kind": "shock", "pulse_time": PULSE, "begin": 1e-3, "return_time": 1e6}
    runs = simulate_many(
        parse_scenario(table | {"ground": {**jolt, "dof": dof, "velocity": v}}) for dof, v in JOLTS.items()
    )
    decays = []
    for dof, run in zip(JOLTS, runs, strict=True):
        motion = run.dataset["machine_displacement"].sel(time=slice(1e-3 + PULSE + 0.5 / rate, None)).values
        moved = np.zeros(len(DOFS))
        moved[DOFS.index(dof)] = JOLTS[dof] * 2 * PULSE / np.pi  # where the floor has come to rest
        decays.append(motion - moved - run.dataset["machine_displacement"].values[0])
    return np.array(decays)


def ring_down(scenario: Scenario, plan: Plan, realisations: int, noise: float) -> tuple[list[Estimates], str]:
    """Fits of eigensystem realisation to free decays, and how they were made, in words."""
    rate = 1000.0 * math.ceil(5.0 * plan.high / 1000.0)
    duration = math.ceil(1.4 / plan.decay * 1000.0) / 1000.0
    decays = free_decays(scenario, duration, rate, plan.step)
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
