"""What cases share: machines of equal isolators, every option of theirs, and what is read from a result."""

from collections.abc import Sequence
from typing import Any

import numpy as np

from ehamj.arrays import Array
from ehamj.plant.mounts import MOUNTS
from ehamj.scenario.load import parse_scenario
from ehamj.scenario.model import Scenario

SMOOTH_OPTIONS: dict[str, Any] = {
    "overlap": [0.2, 0.2, -0.1, 0.1],
    "null_offset": 0.1,
    "threshold": 0.05,
    "flow_curve": [[0.0, 0.0], [0.1, 0.05], [0.5, 0.4], [1.0, 1.0]],
    "rated_flow": 3.9e-5,
    "air_fraction": 0.01,
    "wall_modulus": 8e9,
    "area_ratio": 0.9,
    "volume_share": 0.45,
    "vapour_pressure": 5e3,
    "null_drift": 0.5,
    "null_drift_limit": 2.0,
    "outside_leakage_1": 4e-12,
    "outside_leakage_2": 2e-12,
    "check_valve": True,
}
"""Every hydraulic option but hysteresis and end stops; a stuck spool has a case of its own."""

ALL_OPTIONS = SMOOTH_OPTIONS | {"hysteresis": 0.1, "end_stops": True, "spool_stroke": 6.0}
"""All that a spool that moves can have, with a stroke so short that the stops are hit."""

SHARED_SUPPLY = {"dynamic": True, "tank_pressure": 2e5}


def scenario_of(isolator: dict[str, Any] | None = None, **table: Any) -> Scenario:
    """A scenario whose mounts have one kind of actuator; without gravity and with tied plates where not stated."""
    return parse_scenario({"gravity": 0.0, "plates": "tied", "actuators": {"isolator": isolator or {}}, **table})


def open_loop(*signals: dict[str, Any]) -> dict[str, Any]:
    """A table [control] with open-loop commands."""
    return {"kind": "open-loop", "signals": list(signals)}


def sines(amplitude: float, hertz: Sequence[float] | Array, mounts: Sequence[str] = MOUNTS) -> list[dict[str, Any]]:
    """Open-loop commands [V] of one frequency [Hz] per mount."""
    return [
        {"kind": "sine", "mounts": [mount], "amplitude": amplitude, "frequency": float(f)}
        for mount, f in zip(mounts, hertz, strict=True)
    ]


def fitted_order(steps: Array, errors: Array) -> Array:
    """Slope of each error (steps, …) over the step, both logarithmic."""
    return np.polyfit(np.log(steps), np.log(errors), 1)[0]
