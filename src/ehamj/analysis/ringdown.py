"""Modes identified from the free decay of a simulated machine, as a hammer test would.

Eigensystem realisation (Juang and Pappa 1985): the Hankel matrix of the decaying signals is factored by singular
values, and the shifted factors give the eigenvalues of the sampled motion.
"""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from ehamj.layout import DOFS
from ehamj.scenario import Scenario, parse_scenario
from ehamj.simulate import simulate

Array = NDArray[np.float64]

PULSE = 0.7e-3
"""Duration of the floor's jolt [s]; it excites up to about 1 kHz."""
JOLTS = {"x": 5e-4, "y": 4e-4, "z": 3e-4, "rx": 4e-4, "ry": 3e-4, "rz": 6e-4}
"""Peak velocity of the jolt in each degree of freedom [m/s, rad/s]: micrometres, where the machine is linear."""


def identify(decay: Array, rate: float, order: int) -> NDArray[np.complex128]:
    """Eigenvalues of a free decay.

    Args:
        decay: signals (n, channels), each scaled to about one.
        rate: sampling rate [Hz].
        order: number of eigenvalues looked for.

    Returns:
        Continuous eigenvalues λ [1/s], by magnitude, (order,).
    """
    n, channels = decay.shape
    rows = n // 2
    hankel = np.concatenate([decay[k : k + n - rows].T for k in range(rows)], axis=0)
    left, singular, _ = np.linalg.svd(hankel, full_matrices=False)
    observed = left[:, :order] * np.sqrt(singular[:order])
    shift = np.linalg.lstsq(observed[:-channels], observed[channels:], rcond=None)[0]
    values = np.log(np.linalg.eigvals(shift).astype(complex)) * rate
    return values[np.argsort(np.abs(values))]


def ring_down(scenario: Scenario, duration: float = 0.12, rate: float = 4000.0) -> NDArray[np.complex128]:
    """Eigenvalues λ [1/s] identified from the machine's decay after a jolt of the floor in all six directions.

    Oscillations only (Im λ > 0), by magnitude. The scenario's ground and control are replaced.
    """
    jolts = [
        {"kind": "shock", "dof": dof, "velocity": v, "pulse_time": PULSE, "begin": 1e-3, "return_time": 1e6}
        for dof, v in JOLTS.items()
    ]
    table: dict[str, Any] = scenario.model_dump()
    table |= {"ground": {"kind": "sum", "parts": jolts}, "control": {"kind": "passive"}, "compare": ()}
    table |= {"record_rate": rate, "duration": duration, "timestep": 1.0 / rate / np.ceil(1e4 / rate)}
    dataset = simulate(parse_scenario(table)).dataset
    free = dataset.sel(time=slice(1e-3 + PULSE + 0.5 / rate, None))["machine_displacement"].values
    moved = [JOLTS[dof] * 2 * PULSE / np.pi for dof in DOFS]  # where the floor has come to rest
    decay = free - np.array(moved) - dataset["machine_displacement"].values[0]
    values = identify(decay / np.abs(decay).max(axis=0), rate, order=22)
    return values[values.imag > 2 * np.pi]
