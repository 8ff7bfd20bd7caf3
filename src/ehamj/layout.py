"""The one table of names: mounts, axes, states, parameter columns and shared memory.

Everything that must agree between the model, the compiled callbacks, the stepping loop and the result reads its order
from here and from nowhere else.
"""

from typing import Final

MOUNTS: Final = ("front-left", "front-right", "rear-left", "rear-right")
"""Mounts in order; +x is front, +y is left."""

AXES: Final = ("x", "y", "z")
DOFS: Final = ("x", "y", "z", "rx", "ry", "rz")
"""Degrees of freedom of the machine as they are reported: motion of the mount plane's centre [m, rad]."""

JOINTS: Final = ("x", "y", "z", "rz", "rx", "ry")
"""The same degrees of freedom in the order of the model's joints: with yaw outermost, the stroke coordinate
z + y·rx − x·ry is exact to third order."""

DOF_OF_JOINT: Final = tuple(JOINTS.index(dof) for dof in DOFS)
"""Column of each reported degree of freedom in the model's qpos."""

CHAMBERS: Final = (1, 2)

STATES: Final = ("spool", "spool_rate", "pressure_1", "pressure_2")
"""Activation states of one hydraulic actuator [mA, mA/s, Pa, Pa]."""

PARAMETERS: Final = (
    "piston_area",  # A_p [m²]
    "volume_1",  # chamber volume at stroke 0 [m³]
    "volume_2",
    "moving_volume",  # 1: volumes follow the stroke, 0: constant
    "bulk_modulus",  # β [Pa]
    "vapour_pressure",  # [Pa]
    "flow_gain",  # K_Q [m³/s/mA]
    "edge_leakage",  # g₀ [m³/s/Pa]
    "cross_leakage",  # c [m³/s/Pa]
    "laminar_ratio",  # ε [-]
    "supply_pressure",  # P_s [Pa]
    "tank_pressure",  # P_t [Pa]
    "valve_gain",  # K_v [mA/V]
    "valve_frequency",  # ω_v [rad/s]
    "valve_damping",  # ζ [-]
    "spool_drive_limit",  # a_max [mA/s²]
    "spool_stroke",  # x_max [mA]
    "voltage_limit",  # [V]
    "membrane_stiffness",  # K_L [N/m]
    "membrane_damping",  # C [N s/m]
    "lateral_stiffness",  # [N/m]
    "lateral_damping",  # [N s/m]
    "mount_x",  # [m]
    "mount_y",
    "weight",  # constant force on the stroke coordinate, up positive [N]
)
"""Columns of the model's actuator_user, one row per actuator. SI, spool in mA."""

COLUMN: Final = {name: column for column, name in enumerate(PARAMETERS)}

N_MOUNTS: Final = len(MOUNTS)
N_STATES: Final = len(STATES)
N_INPUTS: Final = 16
"""Inputs that every step carries as cubics: ground x, y, z of each mount (mount-major) [m], then four commands [V]."""

# mjData.userdata: what a step hands to the callbacks, and what the callbacks hand back.
STEP_START: Final = 0  # time at which the step's cubics begin [s]
STEP_RATE: Final = 1  # 1/step [1/s]
CUBICS: Final = 2  # per input: value and slope·step at the start, value and slope·step at the end
STAGE_GROUND: Final = CUBICS + 4 * N_INPUTS  # ground z of each mount at the current stage [m]
STAGE_GROUND_RATE: Final = STAGE_GROUND + N_MOUNTS  # [m/s]
STAGE_COMMAND: Final = STAGE_GROUND_RATE + N_MOUNTS  # open-loop command of each valve [V]
STAGE_FLOW: Final = STAGE_COMMAND + N_MOUNTS  # flow into chamber 1 and 2 of each mount [m³/s]
STAGE_DRAWN: Final = STAGE_FLOW + 2 * N_MOUNTS  # flow that each mount draws from the supply [m³/s]
N_USERDATA: Final = STAGE_DRAWN + N_MOUNTS

WARP: Final = (1.0, -1.0, -1.0, 1.0)
"""Pattern of the four mounts that moves nothing and only builds pressure."""
