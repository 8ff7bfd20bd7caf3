"""DIN 4150-3: peak velocities up to which short-term vibration is not expected to damage buildings.

At the foundation the guideline values depend on the frequency of the peak, with straight lines between the corners
(Table 1 and its figure): constant to 10 Hz, rising to 50 and on to 100 Hz; above, the values of 100 Hz may be used. The
largest of the three components counts. On floors they do not: one value for horizontal motion in the plane of the
topmost one, and 20 mm/s vertically anywhere on a slab (of sensitive buildings less may be needed).

The frequency is that of the half period between the zero crossings around a peak. A swing that the ends of a record cut
has none, and the strictest value counts. All swings are judged, not only the largest: a smaller slow one may be worse.

The standard itself was not at hand. The numbers are those of the edition of 1999 as handbooks and makers of instruments
print them (geothermie.de, innomic.com); that the edition of 2016 kept them was not looked up. Its values for long-term
vibration are left out, since those for slabs could not be found.
"""

from ehamj.criteria.curves import Limit, Norm

FOUNDATION: dict[str, tuple[float, float, float]] = {
    "industrial building": (20e-3, 40e-3, 50e-3),
    "dwelling": (5e-3, 15e-3, 20e-3),
    "sensitive building": (3e-3, 8e-3, 10e-3),
}
"""Peak velocity at up to 10, at 50 and from 100 Hz on [m/s]: lines 1, 2 and 3."""

TOPMOST_FLOOR = {"industrial building": 40e-3, "dwelling": 15e-3, "sensitive building": 8e-3}
"""Horizontal peak velocity at any frequency [m/s]."""

SLAB = 20e-3
"""Vertical peak velocity of a floor [m/s]."""


def _foundation(name: str, axis: str) -> Limit:
    low, middle, high = FOUNDATION[name]
    return Limit.of_swings(((1.0, low), (10.0, low), (50.0, middle), (100.0, high), (1e4, high)))


def _floors(name: str, axis: str) -> Limit:
    return Limit(SLAB if axis == "z" else TOPMOST_FLOOR[name], "velocity", "peak")


NOTE = "Peaks of the whole history, all frequencies together"

DIN_4150_3 = Norm(
    "DIN 4150-3, foundations",
    tuple(FOUNDATION),
    whole=_foundation,
    note=f"{NOTE}; each at the frequency of its swing, between the zero crossings around it.",
)
DIN_4150_3_FLOORS = Norm("DIN 4150-3, floors", tuple(FOUNDATION), whole=_floors, note=f"{NOTE}.")
