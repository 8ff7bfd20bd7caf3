"""Forces on the machine itself: blows, moving axes, unbalance, shakers. Machines shake themselves."""

from ehamj.forces.load import Load
from ehamj.forces.settings import Force

__all__ = ["Force", "Load"]
