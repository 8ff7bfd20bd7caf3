"""Directions that are judged apart from each other, and how the machine's valves reach each of them."""

from typing import Final

from ehamj.plant.axes import AXES, DOFS
from ehamj.plant.layout import Layout

DIRECTIONS: Final = {"overall": AXES, "vertical": ("z",), "horizontal": ("x", "y")}
"""Axes of each direction that is judged apart from the others; overall only where all six motions are actuated."""
TILTING: Final = {"x": "ry", "y": "rx"}
"""The rotation that moves what stands above the mounts along an axis."""
PASSIVE: Final = "passive"
"""What a machine is whose valves nothing commands."""
WHOLE: Final = 1.0 - 1e-6
"""Share of a motion from which isolators drive it as it is."""
PART: Final = 1e-2
"""Share from which they drive some of it."""


def actuation(layout: Layout) -> dict[str, str]:
    """How valves that are commanded reach each direction, in words; the directions that a machine is judged in."""
    x, y, z = (_reached(layout, axis) for axis in AXES)
    found = {"overall": "actuated in all six motions"} if layout.rank == len(DOFS) else {}
    return found | {"vertical": z, "horizontal": x if x == y else f"x {x}, y {y}"}


def _reached(layout: Layout, axis: str) -> str:
    share = layout.share(axis)
    if share > WHOLE:
        return "actuated"
    if share > PART:
        return "actuated in part"
    tilts = axis in TILTING and layout.share(TILTING[axis]) > PART
    return "actuated by tilting only" if tilts else "not actuated"
