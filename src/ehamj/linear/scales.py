"""Sizes and units of states: what a state is divided by, so that those of a moderate motion are all about one.

In SI, displacements of 1e-6 m stand beside pressures of 1e4 Pa. Programs that turn the state with orthogonal matrices
(Hessenberg form, minimal realisations, Riccati equations: SLICOT, LAPACK) err relative to the largest state, and lose
the smallest altogether; after scaling they do not. Sizes are powers of two: to scale changes no digit.
"""

from typing import Final

import numpy as np

from ehamj.arrays import Array
from ehamj.control.channels import quantity_of
from ehamj.control.units import UNITS, turning
from ehamj.memory import PLACES

SIZES: Final = {
    "displacement": 2.0**-20, "velocity": 2.0**-13, "acceleration": 2.0**-7, "spool": 1.0, "spool_rate": 2.0**10,
    "pressure": 2.0**13, "line_flow": 2.0**-17,
}  # fmt: skip
"""Sizes in a moderate motion: about 1 µm (µrad), 0.1 mm/s, 10 mm/s², 1 mA, 1 A/s, 10 kPa and 0.01 l/s."""

OWN: Final = {
    state: 2.0 ** round(np.log2(100.0 * size))
    for option in PLACES
    for state, size in zip(option.State._fields, option.scales, strict=True)
}
"""Sizes of the states that options of valves have: a hundred steps of their differences."""


def _kind(state: str) -> str:
    """What a state is, of `SIZES`; '' for the states of options, laws and delays."""
    words = state.split(" ")
    if words[:2] == ["controller", "sensor"]:  # of the size of what the instrument measures
        quantity = quantity_of(words[2])
        return quantity if quantity in SIZES else "spool" if quantity == "position" else "pressure"
    if words[0] in SIZES or words[0] == "controller":
        return words[0]
    return "pressure" if "pressure" in words[0] else ""


def sizes(states: tuple[str, ...]) -> Array:
    """What states of these names are divided by, (state,): SI, spools in mA, commands in V."""
    return np.array([SIZES.get(_kind(state), OWN.get(state.split(" ")[0], 1.0)) for state in states])


def state_units(states: tuple[str, ...]) -> tuple[str, ...]:
    """Units of states before they are divided; '' for those of options, laws and instruments, which have their own."""
    found = []
    for state in states:
        unit = "" if state.startswith("controller") else UNITS.get(_kind(state), "")
        found.append(turning(unit, state.split(" ")[-1]))
    return tuple(found)
