"""The constants of the reference model's equations, from a plant."""

import math
from typing import Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ehamj.isolator.supply import Supply
from ehamj.plant.plant import Plant

Array = NDArray[np.float64]

PLAIN: Final = {
    "moves": "moving_volume",
    "beta": "bulk_modulus",
    "vapour": "vapour_pressure",
    "air": "air_fraction",
    "exponent": "polytropic_exponent",
    "K_Q": "flow_gain",
    "eps": "laminar_ratio",
    "offset": "null_offset",
    "play": "hysteresis",
    "stroke": "spool_stroke",
    "K_v": "valve_gain",
    "v_max": "voltage_limit",
    "omega": "valve_frequency",
    "zeta": "valve_damping",
    "a_max": "spool_drive_limit",
    "threshold": "threshold",
}
"""Constants that are a setting of the actuator as it stands."""

COMBINED: Final = (
    "piston_area", "area_ratio", "chamber_volume", "volume_share", "wall_modulus", "flow_pressure",
    "edge_leakage_share", "overlap", "flow_curve", "end_stops", "membrane_stiffness", "membrane_damping",
    "lateral_stiffness", "lateral_damping", "plate_mass",
)  # fmt: skip
"""Settings that enter them otherwise."""

WITHOUT_EFFECT: Final = ("rated_drop", "foot_damping")
"""Settings that only count with one that the model does not have; a plant has no rated_flow but the flow_gain of it."""

OF_SUPPLY: Final = (
    "pressure", "tank_pressure", "dynamic", "pump_flow", "pump_droop", "accumulator_volume", "accumulator_precharge",
    "accumulator_exponent", "line_length", "line_diameter", "oil_viscosity", "oil_density", "oil_modulus",
    "manifold_volume",
)  # fmt: skip
"""Settings of the supply that the model has."""


class Constants(NamedTuple):
    """The equations' constants; one entry per mount where not said otherwise. SI, spool in mA."""

    inverse_mass: Array  # (6, 6)
    feet: Array  # motion of each foot per coordinate (mount, axis, 6)
    stiffness: Array  # membranes (mount, axis)
    damping: Array
    weight: Array  # generalised (6,)
    topple: Array  # m g h on rocking (6,)
    area: Array  # (mount, chamber)
    volume: Array
    moves: Array
    beta: Array
    vapour: Array
    air: Array
    exponent: Array
    wall: Array  # 1/β_w
    K_Q: Array
    g0: Array
    cross: Array
    eps: Array
    laps: Array  # (mount, edge)
    offset: Array
    play: Array
    stroke: Array
    curve: Array  # (mount, 2, points): positions and flows as shares
    K_v: Array
    v_max: Array
    omega: Array
    zeta: Array
    a_max: Array
    threshold: Array
    P_s: float
    P_t: float
    supply: Array  # conductance, limit, V0, p0, n, R, L, Vm, β; empty: the supply holds


def constants(plant: Plant) -> Constants:
    """The constants of a plant.

    Raises:
        ValueError: for a setting of an actuator or of the supply that this model does not have, and that is not at its
            default.
    """
    _check(plant)
    feet, inverse_mass, weight, topple = _rigid_body(plant)
    area, volume, leak = (_each(plant, name) for name in ("piston_area", "chamber_volume", "flow_pressure"))
    share, g0 = _each(plant, "volume_share"), leak * _each(plant, "edge_leakage_share")
    lateral, vertical = (
        [_each(plant, f"{what}_{kind}") for kind in ("stiffness", "damping")] for what in ("lateral", "membrane")
    )
    plain = {name: _each(plant, setting) for name, setting in PLAIN.items()}
    return Constants(
        inverse_mass=inverse_mass,
        feet=feet,
        stiffness=np.stack([lateral[0]] * 2 + [vertical[0]], axis=1),
        damping=np.stack([lateral[1]] * 2 + [vertical[1]], axis=1),
        weight=weight,
        topple=topple,
        area=np.stack([area, area * _each(plant, "area_ratio")], axis=1),
        volume=volume[:, None] * np.stack([share, 1.0 - share], axis=1),
        wall=1.0 / _each(plant, "wall_modulus"),
        g0=g0,
        cross=leak - g0,
        laps=np.array([a.overlap for a in plant.actuators], float),
        curve=_flow_curves(plant),
        P_s=plant.supply.pressure,
        P_t=plant.supply.tank_pressure,
        supply=np.array(_station(plant.supply) if plant.supply.dynamic else []),
        **plain,
    )


def _check(plant: Plant) -> None:
    known = (*PLAIN.values(), *COMBINED, *WITHOUT_EFFECT)
    found = [(f"isolator of {m}", a.beyond(known)) for m, a in zip(plant.mounts, plant.actuators, strict=True)]
    for place, unknown in [*found, ("supply", plant.supply.beyond(OF_SUPPLY))]:
        for name, value in unknown.items():
            raise ValueError(f"{place}: the reference model does not have {name} = {value!r}")


def _each(plant: Plant, name: str) -> Array:
    return np.array([getattr(a, name) for a in plant.actuators], float)


def _rigid_body(plant: Plant) -> tuple[Array, Array, Array, Array]:
    """Motion of the feet, inverse of the mass matrix, weight, and m g h on rocking."""
    x, y = np.array(plant.positions).T
    o, i = np.zeros(len(x)), np.ones(len(x))
    feet = np.array([[i, o, o, o, o, -y], [o, i, o, o, o, x], [o, o, i, y, -x, o]]).transpose(2, 0, 1)
    cx, cy, h = plant.machine.cg
    cg = np.array([[1, 0, 0, 0, h, -cy], [0, 1, 0, -h, 0, cx], [0, 0, 1, cy, -cx, 0]], float)
    m, g = plant.machine.mass, plant.gravity
    plates, up = _each(plant, "plate_mass"), feet[:, 2]
    mass = m * cg.T @ cg + up.T @ (plates[:, None] * up)
    mass[3:, 3:] += np.diag(plant.machine.inertia)
    weight = -g * (m * cg[2] + plates @ up)
    return np.ascontiguousarray(feet), np.linalg.inv(mass), weight, m * g * h * np.array([0.0, 0.0, 0.0, 1.0, 1.0, 0.0])


def _flow_curves(plant: Plant) -> Array:
    """Points of each flow curve, the last one repeated where another has more."""
    points = max((len(a.flow_curve) for a in plant.actuators), default=0)
    curve = np.zeros((len(plant.actuators), 2, max(points, 2)))
    for k, actuator in enumerate(plant.actuators):
        pairs = np.array(actuator.flow_curve or ((0.0, 0.0), (1.0, 1.0))).T
        curve[k] = np.pad(pairs, ((0, 0), (0, curve.shape[2] - pairs.shape[1])), mode="edge")
    return curve


def _station(supply: Supply) -> list[float]:
    line = supply.line_diameter
    return [
        supply.pump_flow / supply.pump_droop,
        supply.pump_flow,
        supply.accumulator_volume,
        supply.accumulator_precharge,
        supply.accumulator_exponent,
        128.0 * supply.oil_viscosity * supply.line_length / (math.pi * line**4),
        4.0 * supply.oil_density * supply.line_length / (math.pi * line**2),
        supply.manifold_volume,
        supply.oil_modulus,
    ]
