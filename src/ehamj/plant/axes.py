"""Names and order of axes, degrees of freedom and chambers."""

from typing import Final

AXES: Final = ("x", "y", "z")
DOFS: Final = ("x", "y", "z", "rx", "ry", "rz")
"""Degrees of freedom of the machine as they are reported: motion of the mount plane's centre [m, rad]."""

JOINTS: Final = ("x", "y", "z", "rz", "rx", "ry")
"""The same degrees of freedom in the order of the model's joints: with yaw outermost, the stroke coordinate
z + y·rx − x·ry is exact to third order."""

DOF_OF_JOINT: Final = tuple(JOINTS.index(dof) for dof in DOFS)
"""Column of each reported degree of freedom in the model's qpos."""

CHAMBERS: Final = (1, 2)
