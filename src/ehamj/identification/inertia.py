"""What is to be known of moments of inertia: that they were held as nobody gave them, and what no body has."""

from collections.abc import Iterable, Iterator
from typing import Final

import numpy as np

from ehamj.scenario.model import Scenario

MASS: Final = "machine.mass"
MOMENT: Final = "machine.inertia."
MOST: Final = 0.995
"""Share of the sum of the others, which a moment is at most, from which one stands there."""


def inertia_notes(start: Scenario, found: Scenario, looked_for: Iterable[str]) -> Iterator[str]:
    """Of a machine as it was before and as it was found, whose values of these keys were looked for."""
    keys = list(looked_for)
    moments = [key for key in keys if key.startswith(MOMENT)]
    held = [f"{MOMENT}{k}" for k in range(3) if f"{MOMENT}{k}" not in moments]
    if start.machine.sources["inertia"] == "assumed" and held and (MASS in keys or moments):
        values = ", ".join(f"{start.machine.tensor[k, k]:.4g}" for k in range(3) if f"{MOMENT}{k}" in held)
        yield (
            f"{', '.join(held)}: not given, and held at the assumed {values} kg m², whatever the mass; give them, or "
            "look for them as well"
        )
    principal = np.linalg.eigvalsh(found.machine.tensor)
    if moments and principal[2] > MOST * (principal[0] + principal[1]):
        yield (
            "moments of inertia stand where the largest is the sum of the others, more than which no body has: their "
            "deviations say little"
        )
