"""The one table of names: mounts, axes, states, parameter columns and shared memory.

Everything that must agree between the model, the compiled callbacks, the stepping loop and the result reads its order
from here and from nowhere else.
"""

from typing import Final

from ehamj.plant.axes import DOFS
from ehamj.plant.mounts import MOUNTS, N_MOUNTS

STATES: Final = ("spool", "spool_rate", "pressure_1", "pressure_2")
"""Activation states of one hydraulic actuator [mA, mA/s, Pa, Pa]."""

CURVE_POINTS: Final = 11
"""Points of a valve's flow curve, at equal shares of its stroke from 0 to 1."""

PARAMETERS: Final = (
    "kind",  # what a row describes: VALVE, SUPPLY or LEDGER
    "piston_area",  # A_p of chamber 1 [m²]
    "piston_area_2",  # of chamber 2
    "volume_1",  # chamber volume at stroke 0 [m³]
    "volume_2",
    "moving_volume",  # 1: volumes follow the stroke, 0: constant
    "bulk_modulus",  # β [Pa]
    "vapour_pressure",  # [Pa]
    "air_fraction",  # α at atmospheric pressure [-]
    "polytropic_exponent",  # n [-]
    "wall_compliance",  # 1/β_w [1/Pa]
    "flow_gain",  # K_Q [m³/s/mA]
    "edge_leakage",  # g₀ [m³/s/Pa]
    "cross_leakage",  # c [m³/s/Pa]
    "laminar_ratio",  # ε [-]
    "rated_pressure",  # Δp₀ [Pa]
    "shared_supply",  # 1: the supply has states of its own, 0: supply_pressure holds
    "supply_pressure",  # P_s [Pa]
    "tank_pressure",  # P_t [Pa]
    "valve_gain",  # K_v [mA/V]
    "valve_frequency",  # ω_v [rad/s]
    "valve_damping",  # ζ [-]
    "spool_drive_limit",  # a_max [mA/s²]
    "spool_stroke",  # x_max [mA]
    "end_stops",  # 1: the spool stops there
    "threshold",  # [mA]
    "hysteresis",  # [mA]
    "null_offset",  # [mA]
    "lapped",  # 1: the edges have overlaps
    "overlap_supply_1",  # [mA]
    "overlap_1_tank",
    "overlap_supply_2",
    "overlap_2_tank",
    "curved",  # 1: the opening follows the flow curve
    *(f"flow_curve_{k}" for k in range(CURVE_POINTS)),  # share of full opening [-]
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

VALVE: Final = 0.0
SUPPLY: Final = 1.0
LEDGER: Final = 2.0
"""Kinds of rows of actuator_user."""

SUPPLY_PARAMETERS: Final = (
    "kind",
    "set_pressure",  # [Pa]
    "pump_conductance",  # [m³/s/Pa]
    "pump_flow",  # limit [m³/s]
    "gas_volume",  # V₀ [m³]
    "precharge",  # p₀ [Pa]
    "polytropic_exponent",  # n [-]
    "line_resistance",  # R [Pa s/m³]
    "line_inertance",  # L [Pa s²/m³]
    "manifold_volume",  # [m³]
    "bulk_modulus",  # [Pa]
)
"""Columns of the supply's row."""

SUPPLY_STATES: Final = ("station_pressure", "line_flow", "supply_pressure")
"""Activation states of the supply [Pa, m³/s, Pa]."""

LEDGER_STATES: Final = (
    *(f"oil_in {mount} {chamber}" for mount in MOUNTS for chamber in (1, 2)),  # ∫ρQ/ρ₀ dt [m³]
    "energy_in",  # ∫Σ(enthalpy that flows into chambers) dt [J]
    "piston_work",  # ∫Σp V̇ dt [J]
    "supplied_energy",  # ∫P_s Q_s dt [J]
    "throttled_energy",  # ∫Σ q Δp dt over all edges and leaks [J]
)
"""Activation states of the ledger: what crossed the chambers' borders since the start."""

COLUMN: Final = {name: column for column, name in enumerate(PARAMETERS)}

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
STAGE_FORCE: Final = STAGE_DRAWN + N_MOUNTS  # force of each actuator on its plate, ground's share included [N]
METERING: Final = STAGE_FORCE + N_MOUNTS  # where the metering edges of each valve stood at the last step [mA]
LOADED: Final = METERING + N_MOUNTS  # 1: forces act on the machine itself
LOAD: Final = LOADED + 1  # per degree of freedom: force at the CG as a cubic, as above [N, N m]
N_USERDATA: Final = LOAD + 4 * len(DOFS)

MACHINE_BODY: Final = 1
"""Number of the machine's body in the model."""
