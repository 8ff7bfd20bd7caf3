"""The corner where MuJoCo's process-global callbacks live.

`offsets` finds the fields of mjModel and mjData, `views` reads them in compiled code, `unpacking` takes their records
apart, `callbacks` is the hydraulics as seen by MuJoCo, `advance` the loop around it, `hold` the context manager that
installs and restores.
"""

from ehamj.mujoco.hold import ForeignCallbackError, hydraulics

__all__ = ["ForeignCallbackError", "hydraulics"]
