"""Figures of merit of many of the paper's actuators at once: those of `ehamj.paper.merits`, as arrays.

The same equations in the same form (`ehamj.paper.loop`), with roots of all polynomials at once.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Final

import numpy as np

from ehamj.arrays import Array, ComplexArray
from ehamj.isolator.actuator import hydraulic_stiffness

STEPS: Final = 60
"""Of the bisection for a phase: it halves a range of nine decades to the last digits."""
FIGURES: Final[Mapping[str, tuple[str, str]]] = {
    "hydraulic_stiffness": ("N/m", "stiffness of the trapped oil, K_h = 4βA_p²/V_t"),
    "stiffness_ratio": ("1", "K_L/K_h"),
    "hydraulic_frequency": ("Hz", "hydro-mechanical natural frequency ω_h/2π"),
    "hydraulic_damping": ("1", "hydraulic damping ratio δ_h"),
    "resonance_frequency": ("Hz", "natural frequency of the load's pole pair in the exact form"),
    "resonance_damping": ("1", "damping ratio of that pair"),
    "break_frequency": ("Hz", "K_C K_L/A_p² over 2π: below it the actuator follows the spool, above it its integral"),
    "velocity_gain": ("m/s/V", "stroke velocity per volt, K_v K_Q/A_p"),
    "gain_margin": ("dB", "gain margin of G_EHA at 1 V/m"),
    "phase_crossover": ("Hz", "where its phase passes −180°"),
    "velocity_gain_limit": ("1/s", "highest loop velocity gain of a stable proportional loop"),
    "merritt_limit": ("1/s", "2δ_hω_h, that limit for an infinitely fast valve"),
    "gain": ("V/m", "highest proportional gain with 6 dB and 45° of margins"),
    "gain_crossover": ("Hz", "where the loop's gain passes 1 with that gain"),
    "phase_margin": ("deg", "phase margin with that gain"),
    "bandwidth": ("Hz", "closed-loop bandwidth (−3 dB) with that gain"),
    "valve_frequency": ("Hz", "natural frequency of the valve"),
    "valve_ratio": ("1", "valve's over hydro-mechanical frequency; valve makers ask for three"),
}
"""Unit and description of each figure."""


@dataclass(frozen=True)
class Actuators:
    """Values of actuators, arrays of one shape: the paper's `LINEAR` and the mass [SI, mA]."""

    piston_area: Array
    chamber_volume: Array
    bulk_modulus: Array
    membrane_stiffness: Array
    membrane_damping: Array
    flow_gain: Array
    flow_pressure: Array
    valve_gain: Array
    valve_frequency: Array
    valve_damping: Array
    mass: Array


def figures(own: Actuators, gain_margin_db: float = 6.0, phase_margin_deg: float = 45.0) -> dict[str, Array]:
    """`FIGURES` of each actuator, NaN where one is not defined (no leakage: nothing is damped; no oscillation)."""
    k_h = hydraulic_stiffness(own.bulk_modulus, own.piston_area, own.chamber_volume)
    leak = own.flow_pressure / own.piston_area**2
    w_h, w_v = np.sqrt(k_h / own.mass), own.valve_frequency
    d_h = own.flow_pressure / own.piston_area * np.sqrt(own.bulk_modulus * own.mass / own.chamber_volume)
    numerator = own.valve_gain * own.flow_gain / own.piston_area
    load = np.stack(
        [
            own.mass / k_h,
            own.membrane_damping / k_h + leak * own.mass,
            1.0 + own.membrane_stiffness / k_h + leak * own.membrane_damping,
            leak * own.membrane_stiffness,
        ],
        axis=-1,
    )
    valve = np.stack([1.0 / w_v**2, 2.0 * own.valve_damping / w_v, np.ones_like(w_v)], axis=-1)
    denominator = _product(valve, load)
    swings = np.take_along_axis(poles := _roots(load), poles.imag.argmax(axis=-1)[..., None], axis=-1)[..., 0]
    swings = np.where(swings.imag > 0.0, swings, np.nan)
    found = {
        "hydraulic_stiffness": k_h,
        "stiffness_ratio": own.membrane_stiffness / k_h,
        "hydraulic_frequency": w_h / (2 * np.pi),
        "hydraulic_damping": d_h,
        "resonance_frequency": np.abs(swings) / (2 * np.pi),
        "resonance_damping": -swings.real / np.abs(swings),
        "break_frequency": leak * own.membrane_stiffness / (2 * np.pi),
        "velocity_gain": numerator,
        "merritt_limit": 2.0 * d_h * w_h,
        "valve_frequency": w_v / (2 * np.pi),
        "valve_ratio": w_v / w_h,
    }
    found |= _loop(numerator, denominator, gain_margin_db, phase_margin_deg)
    damped = own.flow_pressure > 0.0
    undamped = ("hydraulic_stiffness", "stiffness_ratio", "hydraulic_frequency", "hydraulic_damping", "velocity_gain")
    kept = (*undamped, "break_frequency", "merritt_limit", "valve_frequency", "valve_ratio", "resonance_frequency")
    return {name: found[name] if name in kept else np.where(damped, found[name], np.nan) for name in FIGURES}


def _loop(numerator: Array, denominator: Array, gain_margin_db: float, phase_margin_deg: float) -> dict[str, Array]:
    """Figures of the proportional loop around numerator/denominator, five poles, no zeros."""
    poles, one = _roots(denominator), np.ones(1)
    c5, _, c3, _, c1, _ = np.moveaxis(denominator, -1, 0)
    turning = np.sqrt(2.0 * c1 / (c3 + np.sqrt(c3**2 - 4.0 * c5 * c1)))  # Im of the denominator is nothing there
    stable = np.abs(_at(denominator, turning)) / numerator
    first, last = (_phase_crossing(poles, -180.0 + sign * phase_margin_deg) for sign in (1.0, -1.0))
    square = _squared(denominator)
    turns = np.sqrt(_positive(square[..., :-1] * np.arange(5, 0, -1.0)))
    within = np.where((turns >= first[..., None]) & (turns <= last[..., None]), turns, first[..., None])
    looked = np.concatenate([first[..., None], within, last[..., None]], axis=-1)
    loudest = (numerator[..., None] / np.abs(_at(denominator[..., None, :], looked))).max(axis=-1)
    gain = np.minimum(stable * 10.0 ** (-gain_margin_db / 20.0), 1.0 / loudest)
    least = square.copy()
    least[..., -1] -= (gain * numerator) ** 2
    crossings = np.sqrt(_positive(least))
    margins = np.abs(_phase(poles, crossings) + 180.0)
    nearest = np.argmin(np.nan_to_num(margins, nan=np.inf), axis=-1)[..., None]
    closed = denominator + 0.0
    closed[..., -1] += gain * numerator
    passed = _squared(closed)
    passed[..., -1] *= 1.0 - 10.0**0.3
    bandwidth = np.sqrt(np.nan_to_num(_positive(passed), nan=np.inf).min(axis=-1))
    hertz = one / (2 * np.pi)
    return {
        "gain_margin": 20.0 * np.log10(stable),
        "phase_crossover": turning * hertz,
        "velocity_gain_limit": stable * numerator,
        "gain": gain,
        "gain_crossover": np.take_along_axis(crossings, nearest, axis=-1)[..., 0] * hertz,
        "phase_margin": np.take_along_axis(margins, nearest, axis=-1)[..., 0],
        "bandwidth": np.where(np.isfinite(bandwidth), bandwidth, np.nan) * hertz,
    }


def _product(one: Array, other: Array) -> Array:
    """Coefficients of the product of polynomials, highest power first, as all here."""
    found = np.zeros((*one.shape[:-1], one.shape[-1] + other.shape[-1] - 1))
    for k in range(one.shape[-1]):
        found[..., k : k + other.shape[-1]] += one[..., k, None] * other
    return found


def _squared(polynomial: Array) -> Array:
    """|p(jω)|² as a polynomial in ω²."""
    signs = (-1.0) ** np.arange(polynomial.shape[-1])[::-1]
    square = _product(polynomial, polynomial * signs)[..., ::2]
    return np.asarray(square * (-1.0) ** np.arange(square.shape[-1])[::-1])


def _at(polynomial: Array, omega: Array) -> ComplexArray:
    found = np.zeros(np.broadcast_shapes(polynomial.shape[:-1], omega.shape), complex)
    for k in range(polynomial.shape[-1]):
        found = found * (1j * omega) + polynomial[..., k]
    return found


def _roots(polynomial: Array) -> ComplexArray:
    """Roots (…, degree), by the eigenvalues of companions."""
    degree = polynomial.shape[-1] - 1
    companion = np.zeros((*polynomial.shape[:-1], degree, degree))
    companion[..., 0, :] = -polynomial[..., 1:] / polynomial[..., :1]
    companion[..., range(1, degree), range(degree - 1)] = 1.0
    return np.asarray(np.linalg.eigvals(companion), complex)


def _positive(polynomial: Array) -> Array:
    """Real roots above zero (…, degree), NaN for the others; a Newton step gives back what companions cost."""
    roots = _roots(polynomial)
    real = (np.abs(roots.imag) <= 1e-9 * np.abs(roots)) & (roots.real > 0.0)
    x = np.where(real, roots.real, np.nan)
    value, slope = np.zeros_like(x), np.zeros_like(x)
    for k in range(polynomial.shape[-1]):
        slope = slope * x + value
        value = value * x + polynomial[..., k, None]
    return np.asarray(x - value / slope)


def _phase(poles: ComplexArray, omega: Array) -> Array:
    """Continuous phase of 1/∏(jω − pole) at ω (…, k) [deg]."""
    return np.asarray(-np.degrees(np.angle(1j * omega[..., None] - poles[..., None, :]).sum(axis=-1)))


def _phase_crossing(poles: ComplexArray, degrees: float) -> Array:
    """Where the phase, which only falls, passes an angle [rad/s]."""
    size = np.abs(poles).max(axis=-1)
    low, high = np.log(1e-6 * size), np.log(1e3 * size)
    for _ in range(STEPS):
        middle = 0.5 * (low + high)
        above = _phase(poles, np.exp(middle)[..., None])[..., 0] > degrees
        low, high = np.where(above, middle, low), np.where(above, high, middle)
    return np.asarray(np.exp(0.5 * (low + high)))
