"""The paper's linear actuator: one valve and one cylinder under a translating mass, and what a loop can make of them.

Eqs. 3, 6 and 7 of the paper solve without approximation to a system of third order, the project's truth:

    x_p/x_v = (K_Q/A_p) / [s + (K_C/A_p² + s/K_h)(M s² + C s + K_L)],    K_h = 4βA_p²/V_t

Eq. 8 is its approximation for K_L ≪ K_h and C = 0, with ω_h = sqrt(K_h/M) and δ_h = (K_C/A_p)·sqrt(βM/V_t):

    x_p/x_v = (K_Q/A_p) / [(s + K_C K_L/A_p²)(s²/ω_h² + 2δ_h s/ω_h + 1)]

The paper prints it without the s in 2δ_h s/ω_h. Taken at its word that is (form ``eq8-printed``)

    x_p/x_v = (K_Q/A_p) / [(s + K_C K_L/A_p²)(s²/ω_h² + (1 + 2δ_h/ω_h))]

which adds a time to a number, and as numbers in SI has an undamped pole pair at ω_h·sqrt(1 + 2δ_h/ω_h), for Table I
0.013 % above ω_h: the resonance is infinite, the phase there jumps by 180°, and δ_h shifts a frequency instead of
damping it.
"""

import math
from typing import Any, Final, Literal, get_args

import numpy as np
from numpy import polyadd, polymul
from numpy.typing import NDArray

from ehamj.errors import InputError
from ehamj.isolator.actuator import Actuator

Array = NDArray[np.floating[Any]]

Form = Literal["exact", "eq8", "eq8-printed"]
"""``exact``: eqs. 3, 6, 7; ``eq8``: eq. 8 with its damping term corrected; ``eq8-printed``: eq. 8 to the letter."""

PAPER_MASS: Final = 4056.0
"""Translating mass of the paper's single actuator [kg]: 4000 of machine and, *assumed*, 4 × 14 of plates (Table I has
only the sum). The whole machine on one actuator: a mount of the four-mount machine carries a quarter of it."""

LARGE_SIGNAL_VALVE: Final = 2.0 * math.pi * 100.0
"""Natural frequency of the prototype's valve at ±90 % of its signal [rad/s] (paper, section 3)."""

FAST_VALVE: Final = 2.0 * math.pi * 400.0
"""Natural frequency of the faster valve that section 5 suggests [rad/s]."""

LINEAR: Final = (
    "piston_area", "chamber_volume", "bulk_modulus", "membrane_stiffness", "membrane_damping",
    "flow_gain", "flow_pressure", "valve_gain", "valve_frequency", "valve_damping",
)  # fmt: skip
"""The parameters that the linear actuator has, beside its mass."""

WITHOUT_EFFECT: Final = (
    "moving_volume", "vapour_pressure", "polytropic_exponent", "edge_leakage_share", "laminar_ratio", "null_offset",
    "hysteresis", "threshold", "end_stops", "spool_drive_limit", "spool_stroke", "rated_drop", "voltage_limit",
    "plate_mass", "lateral_stiffness", "lateral_damping", "foot_damping", "null_drift", "null_drift_from",
    "null_drift_limit", "spool_stuck_at", "check_valve", "passive",
)  # fmt: skip
"""Those that change nothing about the centre, for small signals along the axis, under a stated mass, or alone."""


def g_valve(actuator: Actuator) -> Any:
    """Eq. 1, G_valve: ``voltage`` [V] → ``spool`` [mA], as a ``control.TransferFunction``."""
    return _system([actuator.valve_gain], _valve_denominator(actuator), "voltage", "spool", "G_valve")


def g_act(actuator: Actuator, mass: float = PAPER_MASS, form: Form = "exact") -> Any:
    """G_act: ``spool`` [mA] → ``stroke`` [m], as a ``control.TransferFunction``.

    Args:
        actuator: with defaults but for what is `LINEAR` or `WITHOUT_EFFECT`.
        mass: translating mass M, machine and plate [kg].
        form: ``exact``, ``eq8`` (corrected) or ``eq8-printed``; the module says what they are.

    Raises:
        InputError: if a value is not one of these.
    """
    gain = actuator.flow_gain / actuator.piston_area
    return _system([gain], act_denominator(actuator, mass, form), "spool", "stroke", "G_act")


def g_eha(actuator: Actuator, mass: float = PAPER_MASS, form: Form = "exact") -> Any:
    """Eq. 9, G_EHA = G_valve·G_act: ``voltage`` [V] → ``stroke`` [m]; arguments and errors as `g_act`."""
    numerator, denominator = eha(actuator, mass, form)
    return _system([numerator], denominator, "voltage", "stroke", "G_EHA")


def bode(actuator: Actuator, mass: float, hertz: Array, form: Form = "exact") -> tuple[Array, Array]:
    """G_EHA of any form over frequency: magnitude [m/V] and continuous phase [deg], shaped as ``hertz``."""
    gain, denominator = eha(actuator, mass, form)
    omega = 2.0 * np.pi * np.asarray(hertz, float)
    return gain / np.abs(np.polyval(denominator, 1j * omega)), phase_of(np.roots(denominator), omega)


def phase_of(poles: NDArray[Any], omega: float | Array) -> Any:
    """Continuous phase [deg] of 1/∏(jω − pole) at ω > 0 [rad/s]: pole by pole, so that nothing has to be unwrapped."""
    return -np.degrees(np.angle(1j * np.asarray(omega)[..., None] - poles).sum(axis=-1))


def _system(numerator: list[float], denominator: Array, given: str, taken: str, name: str) -> Any:
    import control

    return control.TransferFunction(numerator, denominator, inputs=given, outputs=taken, name=name)


def _valve_denominator(actuator: Actuator) -> Array:
    """1 + 2ζs/ω_v + (s/ω_v)², eq. 1; highest power first, here and below."""
    w = actuator.valve_frequency
    return np.array([1.0 / w**2, 2.0 * actuator.valve_damping / w, 1.0])


def act_denominator(actuator: Actuator, mass: float, form: Form) -> Array:
    """Denominator of G_act with x_p/x_v = (K_Q/A_p)/it; errors as `g_act`."""
    checked(actuator, mass)
    if form not in get_args(Form):
        raise InputError(f"form = {form!r}: must be one of {', '.join(get_args(Form))}")
    k_h, k_l = actuator.hydraulic_stiffness, actuator.membrane_stiffness
    leak = actuator.flow_pressure / actuator.piston_area**2
    if form == "exact":
        motion = [mass, actuator.membrane_damping, k_l]
        return polyadd([1.0, 0.0], polymul([1.0 / k_h, leak], motion))
    w, d = omega_h(actuator, mass), delta_h(actuator, mass)
    resonance = [1.0 / w**2, 2.0 * d / w, 1.0] if form == "eq8" else [1.0 / w**2, 0.0, 1.0 + 2.0 * d / w]
    return polymul([1.0, leak * k_l], resonance)


def eha(actuator: Actuator, mass: float, form: Form) -> tuple[float, Array]:
    """Numerator [m/s/V] and denominator of G_EHA (eq. 9), which has no zeros; errors as `g_act`."""
    gain = actuator.valve_gain * actuator.flow_gain / actuator.piston_area
    return gain, polymul(_valve_denominator(actuator), act_denominator(actuator, mass, form))


def omega_h(actuator: Actuator, mass: float = PAPER_MASS) -> float:
    """Hydro-mechanical natural frequency ω_h = sqrt(4βA_p²/(V_t M)) [rad/s] (below eq. 8)."""
    return math.sqrt(actuator.hydraulic_stiffness / checked(actuator, mass))


def delta_h(actuator: Actuator, mass: float = PAPER_MASS) -> float:
    """Hydraulic damping ratio δ_h = (K_C/A_p)·sqrt(βM/V_t) [-] (below eq. 8)."""
    inertia = actuator.bulk_modulus * checked(actuator, mass) / actuator.chamber_volume
    return actuator.flow_pressure / actuator.piston_area * math.sqrt(inertia)


def scaled(actuator: Actuator, mass: float, parameter: str, factor: float) -> tuple[Actuator, float]:
    """Actuator and mass [kg] with one parameter, ``mass`` or one of the actuator's, multiplied."""
    if parameter == "mass":
        return actuator, mass * factor
    return actuator.with_values({parameter: getattr(actuator, parameter) * factor}), mass


def checked(actuator: Actuator, mass: float) -> float:
    """The mass, of a design that eqs. 1 to 9 describe."""
    for name, value in actuator.beyond((*LINEAR, *WITHOUT_EFFECT)).items():
        raise InputError(
            f"{name} = {value!r}: the paper's linear actuator knows nothing of it, so it must be "
            f"{Actuator.model_fields[name].default!r} here; linearise the machine for such an actuator"
        )
    return positive("mass", mass, "kg")


def positive(name: str, value: float, unit: str = "") -> float:
    """The value, if it is a positive, finite number."""
    if isinstance(value, bool) or not isinstance(value, int | float | np.number) or not 0.0 < value < math.inf:
        raise InputError(f"{name} = {' '.join([repr(value), unit]).strip()}: must be a positive, finite number")
    return float(value)
