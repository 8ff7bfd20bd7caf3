"""How the stepping of a simulation ends, on either engine."""

from typing import Final, NamedTuple

DONE: Final = 0
NOT_FINITE: Final = 1
CHAMBER_1_EMPTY: Final = 2
CHAMBER_2_EMPTY: Final = 3
LAW_FAILED: Final = 4
TOO_LARGE: Final = 5
"""The machine turned further than small motions go."""


class Stopped(NamedTuple):
    """How a stretch ended: steps done, why (`DONE`, `NOT_FINITE`, …), and at which mount (−1: the machine)."""

    steps: int
    status: int
    mount: int
