"""Cases of the oil in one cylinder, against closed forms."""

from typing import Any

import numpy as np
from scipy.optimize import brentq

from ehamj.isolator.actuator import Actuator
from ehamj.verify.case import Finding, Subject, case
from ehamj.verify.setup import Array, open_loop, scenario_of

NEEDLE = 1e-9
"""Piston area so small that the chambers neither feel nor move the machine [m²]."""

ATMOSPHERE = 101325.0


def _compressed(subject: Subject, isolator: dict[str, Any]) -> tuple[Actuator, Array, Array]:
    """Closed chambers over a shaking floor, below a machine too heavy to follow: actuator, strokes, pressures."""
    scenario = scenario_of(
        {"flow_pressure": 0.0, "vapour_pressure": 1e4, **isolator},
        machine={"mass": 4e6, "inertia": [2e6, 3e6, 4e6]},
        ground={"kind": "sine", "amplitude": 20e-6, "frequency": 100.0, "fade_in": 0.02},
        duration=0.1,
        timestep=1e-4,
    )
    stroke, pressure = subject.channels(scenario, "stroke", "chamber_pressure")
    return scenario.plant.actuators[0], stroke, pressure


@case(
    "chamber compression",
    "pressure in closed chambers against their volume, 20 µm at 100 Hz",
    "closed form p₀ − β ln(V/V₀)",
    "of the pressure's swing",
    1e-6,
    "fourth order at 1e-4 s: (2π·100 Hz·1e-4 s)⁴/120 = 1e-7, with room",
)
def chamber_compression(subject: Subject) -> Finding:
    """p = p₀ − β ln(V/V₀) in both chambers."""
    a, stroke, pressure = _compressed(subject, {})
    volume = a.chamber_volume / 2 + a.piston_area * stroke[:, :, None] * [1.0, -1.0]
    exact = pressure[0] - a.bulk_modulus * np.log(volume / volume[0])
    errors = np.abs(pressure - exact).max(axis=(0, 1)) / np.ptp(exact, axis=(0, 1))
    return Finding(float(errors.max()), f"{np.ptp(pressure[:, 0, 0]) / 1e5:.1f} bar of swing")


@case(
    "chamber compression, air and walls",
    "pressure in a closed chamber with 2 % of air and elastic walls against its volume",
    "conservation of mass V(1 + p/β_w)/v(p), solved for p",
    "of the pressure's swing",
    1e-6,
    "as without air",
)
def aerated_compression(subject: Subject) -> Finding:
    """The mass V·w(p)/v(p) stays: liquid and polytropic air in a chamber whose walls stretch."""
    a, stroke, pressure = _compressed(subject, {"air_fraction": 0.02, "wall_modulus": 5e9})

    def mass(volume: float, p: float) -> float:
        liquid = (1 - a.air_fraction) * np.exp(-(p - ATMOSPHERE) / a.bulk_modulus)
        gas = a.air_fraction * (ATMOSPHERE / p) ** (1 / a.polytropic_exponent)
        return float(volume * (1 + (p - ATMOSPHERE) / a.wall_modulus) / (liquid + gas))

    volumes = a.chamber_volume / 2 + a.piston_area * stroke[:, 0]
    held = mass(volumes[0], pressure[0, 0, 0])
    exact = [brentq(lambda p, volume=volume: mass(volume, p) - held, 1e5, 2e7, xtol=1e-6) for volume in volumes]
    error = np.abs(pressure[:, 0, 0] - exact).max() / np.ptp(exact)
    return Finding(float(error), f"{np.ptp(exact) / 1e5:.1f} bar of swing")


@case(
    "orifice into closed chamber",
    "pressures behind an edge opened by 2 mA, until no drop is left",
    "closed form of the root law, √Δp = √Δp₀ − βK_Q/(2V√Δp₀)·∫x dt",
    "of the first drop",
    1e-4,
    "the root ends with infinite slope, where a step of 0.3 ms leaves (βK_Q x h/V)²/Δp₀ = 1e-5 of the drop; ten "
    "times that",
)
def orifice_discharge(subject: Subject) -> Finding:
    """√Δp falls linearly with ∫x dt, in the chamber that fills and in the one that drains, to the last drop."""
    scenario = scenario_of(
        {"piston_area": NEEDLE, "flow_pressure": 0.0, "laminar_ratio": 0.0, "spool_drive_limit": float("inf")},
        control=open_loop({"kind": "step", "amplitude": 1.0}),
        duration=0.5,
    )
    a = scenario.plant.actuators[0]
    time, found = subject.channels(scenario, "time", "chamber_pressure")
    rated = scenario.supply.rating_pressure
    zeta, omega = a.valve_damping, a.valve_frequency
    damped = omega * np.sqrt(1 - zeta**2)
    decay = np.exp(-zeta * omega * time)
    wave = 2 * zeta / omega * np.cos(damped * time) + (2 * zeta**2 - 1) / damped * np.sin(damped * time)
    opened = a.valve_gain * 1.0 * (time - 2 * zeta / omega + decay * wave)
    slope = a.bulk_modulus * a.flow_gain / (a.chamber_volume / 2) / (2 * np.sqrt(rated))
    drop = np.maximum(np.sqrt(rated) - slope * opened, 0.0) ** 2
    errors = [np.abs(scenario.supply.pressure - found[:, :, 0] - drop[:, None]), np.abs(found[:, :, 1] - drop[:, None])]
    full = float(time[np.argmax(drop == 0.0)])
    return Finding(float(np.max(errors)) / rated, f"full and empty after {1e3 * full:.0f} ms")


@case(
    "leak-down",
    "load pressure of a chamber that leaks over edges and piston",
    "closed form exp(−4βK_C t/V_t)",
    "of the first load pressure",
    1e-6,
    "the equation is linear and slow: only rounding and the spool's last 1e-13 remain",
)
def leak_down(subject: Subject) -> Finding:
    """After a held command is taken away, the load pressure decays as exp(−4βK_C t/V_t)."""
    scenario = scenario_of(
        {"piston_area": NEEDLE, "flow_pressure": 6.6e-13},
        control=open_loop({"kind": "step", "amplitude": 0.05, "start": -1.0}, {"kind": "step", "amplitude": -0.05}),
        duration=0.5,
    )
    a = scenario.plant.actuators[0]
    time, pressure = subject.channels(scenario, "time", "chamber_pressure")
    load = pressure[:, :, 0] - pressure[:, :, 1]
    after = int(np.searchsorted(time, 0.03))  # the spool is back to 1e-13 of its way
    rate = 4 * a.bulk_modulus * a.flow_pressure / a.chamber_volume
    exact = load[after] * np.exp(-rate * (time[after:] - time[after]))[:, None]
    return Finding(
        float(np.abs(load[after:] - exact).max() / load[after].max()), f"{load[after, 0] / 1e5:.2f} bar, {rate:.3f} 1/s"
    )
