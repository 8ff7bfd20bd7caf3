"""Forces on the machine itself: blows, moving axes, unbalance, shakers. Machines shake themselves."""

from ehamj.forces.force import Load

__all__ = ["Load"]
