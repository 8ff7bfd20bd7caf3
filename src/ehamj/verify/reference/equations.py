"""The reference model: its constants, from a plant, and its right-hand side.

State of n mounts: coordinates x, y, z, rx, ry, rz (6), their rates (6), spools (n) [mA], their rates (n), pressures
(mount, chamber) (2n) [Pa]; with a shared supply the accumulator's pressure [Pa], the line's flow [m³/s] and the
manifold's pressure [Pa].
"""

import math
from collections.abc import Callable, Sequence
from typing import Any, Final, NamedTuple

import numba
import numpy as np
from numpy.typing import NDArray

from ehamj.plant.plant import Plant
from ehamj.verify.reference.inputs import GRID, Array

ATMOSPHERE: Final = 101325.0
"""Pressure at which the air fraction and the walls' stretch are stated [Pa]."""

OF_ISOLATOR: Final = (
    "piston_area", "area_ratio", "chamber_volume", "volume_share", "moving_volume", "bulk_modulus", "vapour_pressure",
    "air_fraction", "polytropic_exponent", "wall_modulus", "flow_gain", "flow_pressure", "edge_leakage_share",
    "laminar_ratio", "overlap", "null_offset", "hysteresis", "threshold", "spool_stroke", "end_stops", "valve_gain",
    "voltage_limit", "valve_frequency", "valve_damping", "spool_drive_limit", "membrane_stiffness", "membrane_damping",
    "lateral_stiffness", "lateral_damping", "plate_mass", "spool_stuck", "spool_stuck_at", "null_drift",
    "null_drift_from", "null_drift_limit", "outside_leakage_1", "outside_leakage_2", "check_valve",
)  # fmt: skip
"""Settings of an isolator that the model has as they stand, beside its ``flow_curve``."""

WITHOUT_EFFECT: Final = ("rated_drop", "foot_damping", "passive")
"""Settings that only count with one that the model does not have, or for laws; a plant has no rated_flow but the
flow_gain of it."""

OF_SUPPLY: Final = (
    "pressure", "tank_pressure", "dynamic", "pump_flow", "pump_droop", "accumulator_volume", "accumulator_precharge",
    "accumulator_exponent", "line_length", "line_diameter", "oil_viscosity", "oil_density", "oil_modulus",
    "manifold_volume",
)  # fmt: skip
"""Settings of the supply that the model has."""


class Constants(NamedTuple):
    """The equations' constants. SI, spool in mA."""

    inverse_mass: Array  # (6, 6)
    frames: Array  # two unit vectors across each mount and the one along it (mount, axis, 3)
    feet: Array  # motion of each foot in its frame per coordinate (mount, axis, 6)
    bends: Array  # and its second derivatives over the rotations (mount, axis, 3, 3)
    weight: Array  # of the machine, generalised (6,)
    topple: Array  # and what tilting adds to it, m g h on rocking (3, 3)
    loads: Array  # weight of each plate along its mount (mount,)
    heights: Array  # shims (mount,)
    isolators: NDArray[Any]  # records of `OF_ISOLATOR` (mount,)
    curves: Array  # (mount, 2, points): positions and flows as shares
    supply: NDArray[Any]  # one record of `OF_SUPPLY` (1,)


def constants(plant: Plant) -> Constants:
    """The constants of a plant.

    Raises:
        ValueError: for a setting of an actuator or of the supply that this model does not have, and that is not at its
            default.
    """
    known = (*OF_ISOLATOR, "flow_curve", *WITHOUT_EFFECT)
    found = [(f"isolator of {m}", a.beyond(known)) for m, a in zip(plant.mounts, plant.actuators, strict=True)]
    for place, unknown in [*found, ("supply", plant.supply.beyond(OF_SUPPLY))]:
        for name, value in unknown.items():
            raise ValueError(f"{place}: the reference model does not have {name} = {value!r}")
    if plant.slides:
        raise ValueError("the reference model has no slides")
    isolators, supply = _records(plant.actuators, OF_ISOLATOR), _records([plant.supply], OF_SUPPLY)
    parts = (*_rigid_body(plant, isolators["plate_mass"]), isolators, _flow_curves(plant), supply)
    return Constants._make(parts)


def _records(parts: Sequence[Any], names: Sequence[str]) -> NDArray[Any]:
    """Settings of like parts by name, as numbers."""
    rows = [tuple(getattr(part, name) for name in names) for part in parts]
    return np.array(rows, [(name, np.float64, np.shape(value)) for name, value in zip(names, rows[0], strict=True)])


def _rigid_body(plant: Plant, plates: Array) -> tuple[Array, ...]:
    """The constants up to ``heights``; ``plates`` are masses (mount,)."""
    along, machine = np.array(plant.directions), plant.machine
    frames = np.array([np.eye(3) if d[2] > 1.0 - 1e-12 else np.vstack([_across(d), d]) for d in along])
    feet = np.array([frame @ _first(place) for frame, place in zip(frames, plant.positions, strict=True)])
    bends = np.array([
        np.tensordot(frame, _second(place), 1) for frame, place in zip(frames, plant.positions, strict=True)
    ])  # fmt: skip
    cg, rows, m, g = _first(machine.cg), feet[:, 2], machine.mass, plant.gravity
    mass = m * cg.T @ cg + rows.T @ (plates[:, None] * rows)
    mass[3:, 3:] += machine.tensor
    topple = -m * g * _second(machine.cg)[2]
    loads, heights = -g * plates * along[:, 2], np.array(plant.heights)
    return np.linalg.inv(mass), frames, feet, bends, -m * g * cg[2], topple, loads, heights


def _across(along: Array) -> Array:
    """Two unit vectors across one."""
    return np.linalg.svd(along[None])[2][1:]


def _first(place: Sequence[float]) -> Array:
    """Motion x, y, z of a point of the machine per coordinate (3, 6)."""
    x, y, z = place
    return np.array([[1, 0, 0, 0, z, -y], [0, 1, 0, -z, 0, x], [0, 0, 1, y, -x, 0]], float)


def _second(place: Sequence[float]) -> Array:
    """Second derivatives of a point's x, y, z over rx, ry, rz, which turn in the order z, x, y, (3, 3, 3)."""
    x, y, z = place
    crosses = np.array([
        [[0, 0, 0], [0, 0, -1], [0, 1, 0]], [[0, 0, 1], [0, 0, 0], [-1, 0, 0]], [[0, -1, 0], [1, 0, 0], [0, 0, 0]]
    ], float)  # fmt: skip
    found, order = np.zeros((3, 3, 3)), (2, 0, 1)
    for outer in range(3):
        for inner in range(outer, 3):
            a, b = order[outer], order[inner]
            found[:, a, b] = found[:, b, a] = crosses[a] @ crosses[b] @ (x, y, z)
    return found


def _flow_curves(plant: Plant) -> Array:
    """Points of each flow curve, the last one repeated where another has more."""
    curves = [np.array(a.flow_curve or ((0.0, 0.0), (1.0, 1.0))).T for a in plant.actuators]
    points = max(curve.shape[1] for curve in curves)
    return np.array([np.pad(curve, ((0, 0), (0, points - curve.shape[1])), mode="edge") for curve in curves])


# --- the right-hand side: ``a`` is the record of an isolator ---------------------------------------------------------

_compiled: Callable[[Callable[..., Any]], Callable[..., Any]] = numba.njit(error_model="numpy", cache=True)


@_compiled
def _quintic(k, s):  # type: ignore[no-untyped-def]
    return ((((k[5] * s + k[4]) * s + k[3]) * s + k[2]) * s + k[1]) * s + k[0]


@_compiled
def _slope(k, s):  # type: ignore[no-untyped-def]
    return ((((5 * k[5] * s + 4 * k[4]) * s + 3 * k[3]) * s + 2 * k[2]) * s + k[1]) / GRID


@_compiled
def drive(a, spool, voltage):  # type: ignore[no-untyped-def]
    """Force of the solenoid over the spool's mass [mA/s²]."""
    wanted = a.valve_gain * max(-a.voltage_limit, min(a.voltage_limit, voltage))
    error = (a.spool_stuck_at * a.spool_stroke if a.spool_stuck != 0.0 else wanted) - spool
    if abs(error) <= a.threshold:
        return 0.0
    error -= math.copysign(a.threshold, error)
    return max(-a.spool_drive_limit, min(a.spool_drive_limit, a.valve_frequency**2 * error))


@_compiled
def _modulus(a, p):  # type: ignore[no-untyped-def]
    """Bulk modulus of liquid with polytropic air at the pressure p: harmonic by volume."""
    if a.air_fraction == 0.0:
        return a.bulk_modulus
    liquid = (1.0 - a.air_fraction) * math.exp(-(p - ATMOSPHERE) / a.bulk_modulus)
    gas = a.air_fraction * (ATMOSPHERE / p) ** (1.0 / a.polytropic_exponent)
    share = gas / (liquid + gas)
    return 1.0 / ((1.0 - share) / a.bulk_modulus + share / (a.polytropic_exponent * p))


@_compiled
def _stand(a, c, i, y, ground, s, lift, force):  # type: ignore[no-untyped-def]
    """Add mount i's forces to the machine's, ``lift`` is its oil's; returns its stroke and the stroke's rate."""
    offset, speed = 0.0, 0.0
    for axis in range(3):
        offset, speed = 0.0, 0.0
        for k in range(3):
            offset -= c.frames[i, axis, k] * _quintic(ground[k], s)
            speed -= c.frames[i, axis, k] * _slope(ground[k], s)
        for j in range(6):
            offset += c.feet[i, axis, j] * y[j]
            speed += c.feet[i, axis, j] * y[6 + j]
        for j in range(3):
            for k in range(3):
                offset += 0.5 * c.bends[i, axis, j, k] * y[3 + j] * y[3 + k]
                speed += c.bends[i, axis, j, k] * y[3 + j] * y[9 + k]
        if axis == 2:
            offset -= c.heights[i]
            push = -a.membrane_stiffness * offset - a.membrane_damping * speed + lift + c.loads[i]
        else:
            push = -a.lateral_stiffness * offset - a.lateral_damping * speed
        for j in range(6):
            force[j] += c.feet[i, axis, j] * push
        for j in range(3):
            for k in range(3):
                force[3 + j] += c.bends[i, axis, j, k] * y[3 + k] * push
    return offset, speed


@_compiled
def _opening(a, curve, edge, t):  # type: ignore[no-untyped-def]
    """Opening behind the metering edges' position at a time, along the flow curve [mA]."""
    drift = a.null_drift * (t - a.null_drift_from) if t > a.null_drift_from else 0.0
    null = a.null_offset + max(-a.null_drift_limit, min(a.null_drift_limit, drift))
    opening = max(-a.spool_stroke, min(a.spool_stroke, edge + null))
    share = np.interp(abs(opening) / a.spool_stroke, curve[0], curve[1])
    return math.copysign(share * a.spool_stroke, opening)


@_compiled
def _edge(a, opening, drop, rated):  # type: ignore[no-untyped-def]
    """Flow over one edge: K_Q·opening·φ(Δp/Δp₀) and a laminar leak."""
    r = drop / rated
    root = (r * r + a.laminar_ratio * a.laminar_ratio) ** 0.25
    turbulent = a.flow_gain * min(max(opening, 0.0), a.spool_stroke) * r / root if root > 0.0 else 0.0
    return turbulent + a.flow_pressure * a.edge_leakage_share * drop


@_compiled
def _flows(a, opening, supply, tank, rated, p1, p2):  # type: ignore[no-untyped-def]
    """What flows into chamber 1 and 2, and what is taken from the supply [m³/s]."""
    least = 0.0 if a.check_valve != 0.0 else -math.inf
    from_1 = _edge(a, opening - a.overlap[0], max(supply - p1, least), rated)
    to_1 = _edge(a, -opening - a.overlap[1], p1 - tank, rated)
    from_2 = _edge(a, -opening - a.overlap[2], max(supply - p2, least), rated)
    to_2 = _edge(a, opening - a.overlap[3], p2 - tank, rated)
    across = (a.flow_pressure - a.flow_pressure * a.edge_leakage_share) * (p1 - p2)
    out_1, out_2 = a.outside_leakage_1 * (p1 - tank), a.outside_leakage_2 * (p2 - tank)
    return from_1 - to_1 - across - out_1, from_2 - to_2 + across - out_2, from_1 + from_2


@_compiled
def _compress(a, area, volume, state, flow, offset, speed):  # type: ignore[no-untyped-def]
    """Rate of a chamber's pressure state [Pa/s]; its ``area`` is negative where the stroke makes it smaller."""
    modulus = _modulus(a, max(state, a.vapour_pressure))
    stretch = 1.0 + (state - ATMOSPHERE) / a.wall_modulus
    # compliance of oil and walls at this pressure [m³/Pa]
    compliance = (volume + a.moving_volume * area * offset) * (stretch / modulus + 1.0 / a.wall_modulus)
    # Below the vapour pressure the state stands for a void: p_v − p = −β ln(share that is oil). What the oil's
    # volume gains must be the flow, so that the flow counts more the less oil there is.
    filled = math.exp(min(state - a.vapour_pressure, 0.0) / modulus)
    return (flow / filled - stretch * area * speed) / compliance


@_compiled
def _station(station, accumulator, line, manifold, drawn, out):  # type: ignore[no-untyped-def]
    """Rates of the shared supply."""
    wanted = station.pump_flow / station.pump_droop * (station.pressure - accumulator)
    pump = min(max(wanted, 0.0), station.pump_flow)
    n, section = station.accumulator_exponent, math.pi * station.line_diameter**2
    filled = station.accumulator_volume * (station.accumulator_precharge / accumulator) ** (1.0 / n)
    resistance = 128.0 * station.oil_viscosity * station.line_length / (section * station.line_diameter**2)
    inertance = 4.0 * station.oil_density * station.line_length / section
    out[0] = n * accumulator / filled * (pump - line)
    out[1] = (accumulator - manifold - resistance * line) / inertance
    out[2] = station.oil_modulus / station.manifold_volume * (line - drawn)


@_compiled
def rates(t, y, c, quintics, held, side, memory, stopped, out):  # type: ignore[no-untyped-def]
    """Time derivative of the state; ``held`` [V] comes from a controller, the modes from the integration."""
    n, station = len(c.isolators), c.supply[0]
    piece = min(max(int(t / GRID), 0), quintics.shape[0] - 1)
    s = t / GRID - piece
    force = c.weight.copy()
    for j in range(3):
        for k in range(3):
            force[3 + j] += c.topple[j, k] * y[3 + k]
    first, last, tank = 12 + 2 * n, 12 + 4 * n, station.tank_pressure
    rated = 0.5 * (station.pressure - tank)
    supply = y[last + 2] if station.dynamic else station.pressure
    drawn = 0.0
    for i in range(n):
        a, k = c.isolators[i], first + 2 * i
        p1, p2 = max(y[k], a.vapour_pressure), max(y[k + 1], a.vapour_pressure)
        area_1, area_2 = a.piston_area, a.piston_area * a.area_ratio
        lift = area_1 * p1 - area_2 * p2
        offset, speed = _stand(a, c, i, y, quintics[piece, 3 * i : 3 * i + 3], s, lift, force)
        spool, rate = y[12 + i], y[12 + n + i]
        if stopped[i] != 0.0:
            out[12 + i] = out[12 + n + i] = 0.0
        else:
            pull = drive(a, spool, held[i] + _quintic(quintics[piece, 3 * n + i], s))
            out[12 + i] = rate
            out[12 + n + i] = pull - 2.0 * a.valve_damping * a.valve_frequency * rate
        edge = memory[i] if side[i] == 0.0 and a.hysteresis > 0.0 else spool - side[i] * 0.5 * a.hysteresis
        into_1, into_2, taken = _flows(a, _opening(a, c.curves[i], edge, t), supply, tank, rated, p1, p2)
        drawn += taken
        volume_1, volume_2 = a.chamber_volume * a.volume_share, a.chamber_volume * (1.0 - a.volume_share)
        out[k] = _compress(a, area_1, volume_1, y[k], into_1, offset, speed)
        out[k + 1] = _compress(a, -area_2, volume_2, y[k + 1], into_2, offset, speed)
    out[:6] = y[6:12]
    out[6:12] = c.inverse_mass @ force
    if station.dynamic:
        _station(station, y[last], y[last + 1], y[last + 2], drawn, out[last:])
