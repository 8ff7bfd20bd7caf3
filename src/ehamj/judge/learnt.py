"""What laws that learn have learnt in a run, beside what was stated."""

from typing import Final

from ehamj.findings import Finding

UNITS: Final = {
    "flow_gain": "m³/s/mA",
    "oil_stiffness": "N/m",
    "overlap": "mA",
    "play": "mA",
    "null_offset": "mA",
}
"""What is told of each mount, and in which unit: oil_stiffness is K_h = 4βA_p²/V_t, play the threshold and half of the
hysteresis."""


class Belief(Finding):
    """A quantity of one mount as stated and as learnt at the end, in the unit that `UNITS` has."""

    stated: float
    learnt: float

    def words(self, name: str) -> str:
        """In words."""
        return f"{name.replace('_', ' ')} {self.learnt:.4g} {UNITS[name]} ({self.stated:.4g} stated)"


Beliefs = dict[str, dict[str, Belief]]
"""Of each mount, by quantity."""


def nothing(told: dict[str, Belief]) -> bool:
    """Whether nothing was learnt of a mount: all is as stated."""
    return all(one.learnt == one.stated for one in told.values())
