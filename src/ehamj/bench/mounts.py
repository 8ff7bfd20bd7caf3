"""What a step costs over the number of mounts: upright ones, and ones in any direction off the plane."""

import math
from typing import Any, Final

import numpy as np

from ehamj.bench.runs import Run, interleaved
from ehamj.scenario.load import parse_scenario
from ehamj.scenario.model import Scenario

COUNTS: Final = (3, 4, 8, 16, 32)
TILT: Final = 0.6
"""How far a skew mount is tilted: horizontal over vertical part of its direction [-]."""


def standing(mounts: int, skew: bool, plates: str) -> Scenario:
    """The default machine on so many isolators in a circle; skew ones lean inwards, half of them 0.3 m higher."""
    table: list[dict[str, Any]] = []
    for k in range(mounts):
        x, y = math.cos(2 * math.pi * k / mounts), math.sin(2 * math.pi * k / mounts)
        place = {"position": [0.75 * x, 0.75 * y]}
        if skew:
            place = {"position": [0.75 * x, 0.75 * y, 0.3 * (k % 2)], "direction": [-TILT * x, -TILT * y, 1.0]}
        table.append({"name": f"m{k + 1}", **place})
    return parse_scenario({"mount": table, "plates": plates})


def cost_over_mounts(repetitions: int, plates: str = "tied", steps: int = 2000) -> dict[str, dict[str, float]]:
    """Time of a step over that of four upright mounts, by layout and number of mounts; ground moves, rows are kept."""
    runs: dict[str, Run] = {}
    for layout in ("upright", "skew"):
        for mounts in COUNTS:
            runs[f"{layout} {mounts}"] = Run(standing(mounts, layout == "skew", plates), 1e-4, steps)
    times = {name: np.median(each) for name, each in interleaved(runs, repetitions).items()}
    four = times["upright 4"]
    return {
        layout: {str(mounts): float(times[f"{layout} {mounts}"] / four) for mounts in COUNTS}
        for layout in ("upright", "skew")
    }
