"""The corner where MuJoCo's process-global callbacks live.

`offsets` finds the fields of mjModel and mjData, `pointers` reads them in compiled code, `callbacks` is the
hydraulics as seen by MuJoCo, `stepping` the loop around it, `hold` the context manager that installs and restores.
"""

from ehamj.mujoco.hold import ForeignCallbackError, hydraulics

__all__ = ["ForeignCallbackError", "hydraulics"]
