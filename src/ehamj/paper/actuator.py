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
from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise
from typing import Any, Final, Literal, Self, get_args

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import brentq

from ehamj.errors import InputError
from ehamj.isolator.actuator import Actuator

Array = NDArray[np.float64]
Complex = NDArray[np.complex128]

Form = Literal["exact", "eq8", "eq8-printed"]
"""``exact``: eqs. 3, 6, 7; ``eq8``: eq. 8 with its damping term corrected; ``eq8-printed``: eq. 8 to the letter."""

PAPER_MASS: Final = 4056.0
"""Translating mass of the paper's single actuator [kg]: 4000 of machine and, *assumed*, 4 × 14 of plates (Table I has
only the sum). The whole machine on one actuator: a mount of the four-mount machine carries a quarter of it."""

LARGE_SIGNAL_VALVE: Final = 2.0 * math.pi * 100.0
"""Natural frequency of the prototype's valve at ±90 % of its signal [rad/s] (paper, section 3)."""

FAST_VALVE: Final = 2.0 * math.pi * 400.0
"""Natural frequency of the faster valve that section 5 suggests [rad/s]."""

RULE_OF_THREE: Final = 3.0
"""What valve makers ask for: the valve's −90° at no less than three times the load's resonance."""

BEYOND_THE_PAPER: Final = (
    "foot_stiffness",
    "area_ratio",
    "volume_share",
    "air_fraction",
    "wall_modulus",
    "overlap",
    "flow_curve",
    "rated_flow",
)
"""Parameters that change the linear behaviour in ways that eqs. 1 to 9 do not have: at their defaults only."""

UNDAMPED: Final = 1e-9
"""Damping ratio of a pole below which a loop counts as undamped."""


def g_valve(actuator: Actuator) -> Any:
    """Eq. 1, G_valve: ``voltage`` [V] → ``spool`` [mA], as a ``control.TransferFunction``."""
    return _system([actuator.valve_gain], _valve_denominator(actuator), "voltage", "spool", "G_valve")


def g_act(actuator: Actuator, mass: float = PAPER_MASS, form: Form = "exact") -> Any:
    """G_act: ``spool`` [mA] → ``stroke`` [m], as a ``control.TransferFunction``.

    Args:
        actuator: with defaults for what is `BEYOND_THE_PAPER`; play and threshold of its spool do not count.
        mass: translating mass M, machine and plate [kg].
        form: ``exact``, ``eq8`` (corrected) or ``eq8-printed``; the module says what they are.

    Raises:
        InputError: if a value is not one of these.
    """
    gain = actuator.flow_gain / actuator.piston_area
    return _system([gain], _act_denominator(actuator, mass, form), "spool", "stroke", "G_act")


def g_eha(actuator: Actuator, mass: float = PAPER_MASS, form: Form = "exact") -> Any:
    """Eq. 9, G_EHA = G_valve·G_act: ``voltage`` [V] → ``stroke`` [m]; arguments and errors as `g_act`."""
    numerator, denominator = _eha(actuator, mass, form)
    return _system([numerator], denominator, "voltage", "stroke", "G_EHA")


def closed_loop(actuator: Actuator, mass: float, gain: float, form: Form = "exact") -> Any:
    """Stroke under proportional control, voltage = gain·(reference − stroke): ``reference`` [m] → ``stroke`` [m].

    Args:
        actuator: as in `g_act`, also ``mass`` and ``form``.
        mass: [kg].
        gain: proportional gain [V/m]; it may be unstable.
        form: see `Form`.
    """
    numerator, denominator = _eha(actuator, mass, form)
    closed = _sum(denominator, [gain * numerator])
    return _system([gain * numerator], closed, "reference", "stroke", "closed_loop")


def bode(actuator: Actuator, mass: float, hertz: Array, form: Form = "exact") -> tuple[Array, Array]:
    """G_EHA of any form over frequency: magnitude [m/V] and continuous phase [deg], shaped as ``hertz``."""
    gain, denominator = _eha(actuator, mass, form)
    omega = 2.0 * np.pi * np.asarray(hertz, float)
    return gain / np.abs(np.polyval(denominator, 1j * omega)), _phase(_roots(denominator), omega)


def _system(numerator: list[float], denominator: Array, given: str, taken: str, name: str) -> Any:
    import control

    return control.TransferFunction(numerator, denominator, inputs=given, outputs=taken, name=name)


def _valve_denominator(actuator: Actuator) -> Array:
    """1 + 2ζs/ω_v + (s/ω_v)², eq. 1; highest power first, here and below."""
    w = actuator.valve_frequency
    return np.array([1.0 / w**2, 2.0 * actuator.valve_damping / w, 1.0])


def _product(a: Any, b: Any) -> Array:
    return np.asarray(np.polymul(a, b), np.float64)


def _sum(a: Any, b: Any) -> Array:
    return np.asarray(np.polyadd(a, b), np.float64)


def _roots(polynomial: Array) -> Complex:
    return np.roots(polynomial).astype(np.complex128)


def _act_denominator(actuator: Actuator, mass: float, form: Form) -> Array:
    _check(actuator, mass)
    if form not in get_args(Form):
        raise InputError(f"form = {form!r}: must be one of {', '.join(get_args(Form))}")
    k_h, k_l = actuator.hydraulic_stiffness, actuator.membrane_stiffness
    leak = actuator.flow_pressure / actuator.piston_area**2
    if form == "exact":
        motion = [mass, actuator.membrane_damping, k_l]
        return _sum([1.0, 0.0], _product([1.0 / k_h, leak], motion))
    w, d = omega_h(actuator, mass), delta_h(actuator, mass)
    resonance = [1.0 / w**2, 2.0 * d / w, 1.0] if form == "eq8" else [1.0 / w**2, 0.0, 1.0 + 2.0 * d / w]
    return _product([1.0, leak * k_l], resonance)


def _eha(actuator: Actuator, mass: float, form: Form) -> tuple[float, Array]:
    gain = actuator.valve_gain * actuator.flow_gain / actuator.piston_area
    return gain, _product(_valve_denominator(actuator), _act_denominator(actuator, mass, form))


def omega_h(actuator: Actuator, mass: float = PAPER_MASS) -> float:
    """Hydro-mechanical natural frequency ω_h = sqrt(4βA_p²/(V_t M)) [rad/s] (below eq. 8)."""
    return math.sqrt(actuator.hydraulic_stiffness / _check(actuator, mass))


def delta_h(actuator: Actuator, mass: float = PAPER_MASS) -> float:
    """Hydraulic damping ratio δ_h = (K_C/A_p)·sqrt(βM/V_t) [-] (below eq. 8)."""
    inertia = actuator.bulk_modulus * _check(actuator, mass) / actuator.chamber_volume
    return actuator.flow_pressure / actuator.piston_area * math.sqrt(inertia)


def _check(actuator: Actuator, mass: float) -> float:
    for name in BEYOND_THE_PAPER:
        value, plain = getattr(actuator, name), Actuator.model_fields[name].default
        if value != plain:
            raise InputError(
                f"{name} = {value!r}: the paper's linear actuator knows nothing of it, so it must be {plain!r} here; "
                "linearise the machine for such an actuator"
            )
    return _positive("mass", mass, "kg")


def _positive(name: str, value: float, unit: str) -> float:
    if isinstance(value, bool) or not isinstance(value, int | float | np.number) or not 0.0 < value < math.inf:
        raise InputError(f"{name} = {value!r} {unit}: must be a positive, finite number")
    return float(value)


@dataclass(frozen=True, eq=False)
class Loop:
    """A stable loop without zeros, numerator/denominator(s), of order five at most: its crossings and what they allow.

    The phase of such a loop only falls, to −450° at most: it passes each angle once, and −180° alone decides on
    stability. Crossings are roots of the exact phase and magnitude, good to 1e-12.

    Raises:
        InputError: if it has zeros, more than five poles, or a pole that is not damped (one integrator is allowed).
    """

    numerator: float
    denominator: Array
    """Coefficients, highest power first."""

    def __post_init__(self) -> None:
        poles = self.poles
        _positive("numerator", self.numerator, "(of the loop)")
        if len(poles) > 5:
            raise InputError(f"order = {len(poles)}: a loop may have five poles at most")
        free = np.count_nonzero(poles == 0)
        if free > 1 or np.any(poles.real[poles != 0] > -UNDAMPED * np.abs(poles[poles != 0])):
            worst = poles[np.argmax(poles.real)]
            raise InputError(
                f"pole = {worst:.6g} rad/s: the open loop is not damped, so it has no margins; every pole but one "
                "integrator must have a negative real part"
            )

    @classmethod
    def of_actuator(cls, actuator: Actuator, mass: float = PAPER_MASS, form: Form = "exact") -> Self:
        """G_EHA (eq. 9); errors as `g_act`."""
        return cls(*_eha(actuator, mass, form))

    @classmethod
    def of_system(cls, system: Any) -> Self:
        """A single-input, single-output ``control`` system.

        Raises:
            InputError: if it is none, or not of the kind this class takes.
        """
        import control

        transfer = control.tf(system)
        if transfer.ninputs != 1 or transfer.noutputs != 1 or not transfer.isctime():
            raise InputError("system: must have one input, one output and continuous time")
        numerator, denominator = (np.trim_zeros(part[0][0], "f") for part in (transfer.num, transfer.den))
        if len(numerator) != 1:
            raise InputError(f"system: has {len(numerator) - 1} zeros, it must have none")
        return cls(float(numerator[0]), np.asarray(denominator, float))

    @cached_property
    def poles(self) -> Complex:
        """Roots of the denominator [rad/s]."""
        return _roots(self.denominator)

    def response(self, omega: float | Array) -> Any:
        """Complex gain at ``omega`` [rad/s]."""
        return self.numerator / np.polyval(self.denominator, 1j * np.asarray(omega))

    def phase(self, omega: float | Array) -> Any:
        """Continuous phase [deg] at ``omega`` > 0 [rad/s], pole by pole, so that nothing has to be unwrapped."""
        return _phase(self.poles, omega)

    def phase_crossing(self, degrees: float) -> float | None:
        """Frequency [rad/s] at which the phase passes ``degrees``; None if it starts below or never gets there."""
        poles = self.poles
        start = -90.0 * np.count_nonzero(poles == 0)
        if not -90.0 * len(poles) < degrees < start:
            return None
        parts = [(-float(pole.real), float(pole.imag)) for pole in poles]

        def excess(omega: float) -> float:
            return -math.radians(degrees) - sum(math.atan2(omega - turn, decay) for decay, turn in parts)

        low = high = float(np.abs(poles).max())
        while excess(high) >= 0.0:
            high *= 2.0
        while excess(low) <= 0.0:
            low /= 2.0
        return float(brentq(excess, low, high, xtol=1e-14 * low, rtol=1e-14))

    @cached_property
    def phase_crossover(self) -> float:
        """Frequency at which the phase passes −180° [rad/s]; inf if it never does."""
        found = self.phase_crossing(-180.0)
        return math.inf if found is None else found

    @property
    def stability_gain(self) -> float:
        """Proportional gain at which the closed loop turns unstable, 1/|L| at −180°; inf if it never does."""
        crossover = self.phase_crossover
        return math.inf if math.isinf(crossover) else float(1.0 / abs(self.response(crossover)))

    def gain_crossings(self, gain: float) -> list[float]:
        """Frequencies at which gain·|L| passes 1, rising [rad/s]."""
        return _level_crossings(self.denominator, gain * self.numerator)

    def phase_margin(self, gain: float) -> tuple[float, float] | None:
        """Smallest distance [deg] of the phase from −180° where gain·|L| = 1, and that frequency [rad/s].

        Negative if the closed loop is unstable; None if the gain never reaches 1.
        """
        crossings = self.gain_crossings(gain)
        if not crossings:
            return None
        distance, where = min((abs(float(self.phase(w)) + 180.0), w) for w in crossings)
        return (distance if gain < self.stability_gain else -distance), where

    def highest_gain(self, gain_margin_db: float, phase_margin_deg: float) -> float:
        """Highest proportional gain up to which every lower one, too, keeps both margins.

        Args:
            gain_margin_db: ≥ 0 [dB].
            phase_margin_deg: from 0 to 90 [deg].

        Raises:
            InputError: if a margin is out of range, or the loop takes any gain.
        """
        if not 0.0 <= gain_margin_db < math.inf:
            raise InputError(f"gain_margin_db = {gain_margin_db!r} dB: must be zero or positive, and finite")
        if not 0.0 <= phase_margin_deg <= 90.0:
            raise InputError(f"phase_margin_deg = {phase_margin_deg!r} deg: must be from 0 to 90")
        limits = [self.stability_gain * 10.0 ** (-gain_margin_db / 20.0)]
        first = self.phase_crossing(-180.0 + phase_margin_deg)
        if first is not None and phase_margin_deg > 0.0:  # no crossing may lie from `first` to `last`
            last = self.phase_crossing(-180.0 - phase_margin_deg) or math.inf
            inner = [w for w in _stationary(self.denominator) if first < w < last]
            ends = [first] if math.isinf(last) else [first, last]
            limits.append(1.0 / max(abs(self.response(w)) for w in ends + inner))
        highest = float(min(limits))
        if math.isinf(highest):
            raise InputError("gain_margin_db: this loop never turns unstable; give a proportional gain instead")
        return highest

    def bandwidth(self, gain: float) -> float:
        """Frequency [rad/s] at which the closed loop gain·L/(1 + gain·L) is first 3 dB below its static value.

        Raises:
            InputError: if the gain is not positive, or the loop unstable with it.
        """
        limit = self.stability_gain
        if not _positive("gain", gain, "V/m") < limit:
            raise InputError(
                f"gain = {gain:.6g} V/m: the closed loop is unstable and has no bandwidth; it must be below {limit:.6g}"
                f" V/m, the limit at {self.phase_crossover / (2 * math.pi):.4g} Hz"
            )
        closed = _sum(self.denominator, [gain * self.numerator])
        return _level_crossings(closed, abs(float(closed[-1])) * 10.0 ** (3.0 / 20.0))[0]


def _phase(poles: Complex, omega: float | Array) -> Any:
    return -np.degrees(np.angle(1j * np.asarray(omega)[..., None] - poles).sum(axis=-1))


def _squared(polynomial: Array, scale: float) -> Array:
    """|p(jω)|² as a polynomial in x = (ω/scale)², highest power first."""
    rising = polynomial[::-1] * scale ** np.arange(len(polynomial))
    signs = np.array([(1, 1, -1, -1)[k % 4] for k in range(len(rising))])
    even, odd = (rising * signs)[0::2][::-1], (rising * signs)[1::2][::-1]
    return _sum(_product(even, even), _product([1.0, 0.0], _product(odd, odd)))


def _scale(polynomial: Array) -> float:
    return float(np.abs(_roots(polynomial)).max())


def _stationary(polynomial: Array) -> list[float]:
    """Frequencies > 0 at which |p(jω)| is stationary, rising [rad/s]."""
    scale = _scale(polynomial)
    roots = np.roots(np.polyder(_squared(polynomial, scale)))
    real = roots.real[(np.abs(roots.imag) <= 1e-9 * np.abs(roots)) & (roots.real > 0)]
    return sorted(float(scale * math.sqrt(x)) for x in real)


def _level_crossings(polynomial: Array, level: float) -> list[float]:
    """Frequencies > 0 at which |p(jω)| passes ``level``, rising [rad/s]: one root per stretch without a turn."""
    scale = _scale(polynomial)
    square = _squared(polynomial, scale)

    def excess(x: float) -> float:
        return float(np.polyval(square, x)) / level**2 - 1.0

    edges = [0.0, *((w / scale) ** 2 for w in _stationary(polynomial))]
    edges.append(2.0 * max(edges[-1], 1.0))
    while excess(edges[-1]) <= 0.0:
        edges[-1] *= 2.0
    found = []
    for low, high in pairwise(edges):
        if excess(low) * excess(high) < 0.0:
            found.append(scale * math.sqrt(brentq(excess, low, high, xtol=1e-300, rtol=1e-14)))
    return found


@dataclass(frozen=True)
class FiguresOfMerit:
    """What an actuator under a mass can do; the margins are those of G_EHA at a gain of 1 V/m."""

    hydraulic_stiffness: float
    """K_h = 4βA_p²/V_t [N/m]."""
    stiffness_ratio: float
    """K_L/K_h [-]; eq. 8 takes it as small."""
    omega_h: float
    """Hydro-mechanical natural frequency, the paper's [rad/s]."""
    omega_h_hz: float
    """The same [Hz]."""
    delta_h: float
    """Hydraulic damping ratio, the paper's [-]."""
    resonance_hz: float | None
    """Natural frequency of the load's pole pair in the exact form [Hz]; None if it does not oscillate."""
    resonance_damping: float | None
    """Damping ratio of that pair [-]."""
    break_frequency: float
    """K_C K_L/A_p² [rad/s]: below it the actuator follows the spool itself, above it the spool's integral."""
    velocity_gain: float
    """K_v K_Q/A_p, stroke velocity per volt [m/s/V]."""
    gain_margin_db: float
    """Exact form [dB re 1 V/m]."""
    phase_crossover_hz: float
    """Exact form [Hz]."""
    gain_margin_db_eq8: float
    phase_crossover_hz_eq8: float
    velocity_gain_limit: float
    """Gain margin times velocity gain [1/s]: the highest loop velocity gain of a stable loop; compare Merritt's."""
    merritt_limit: float
    """2δ_hω_h = 4βK_C/V_t [1/s]: that limit for an infinitely fast valve (Merritt)."""
    gain: float
    """Proportional gain of the following numbers [V/m], exact form."""
    gain_crossover_hz: float | None
    """Where the loop's gain passes 1 with the least phase margin [Hz]; None if it stays below."""
    phase_margin_deg: float | None
    """Phase margin there [deg]; None: unlimited."""
    bandwidth_hz: float
    """Closed-loop bandwidth: −3 dB from the static value [Hz]."""
    valve_hz: float
    """Frequency at which the valve lags by 90° [Hz]: its natural frequency, since it is linear here."""
    valve_ratio: float
    """valve_hz over omega_h_hz [-]."""
    rule_of_three: bool
    """Whether that ratio is at least three, as valve makers ask."""


def figures_of_merit(
    actuator: Actuator,
    mass: float = PAPER_MASS,
    *,
    gain: float | None = None,
    gain_margin_db: float = 6.0,
    phase_margin_deg: float = 45.0,
) -> FiguresOfMerit:
    """The figures of merit of one actuator under a mass.

    Args:
        actuator: as in `g_act`, and its K_C positive: without leakage eq. 8 has no damping.
        mass: translating mass M [kg].
        gain: proportional gain for bandwidth and phase margin [V/m]; without it the highest one that keeps the two
            margins that follow.
        gain_margin_db: gain margin to keep [dB].
        phase_margin_deg: phase margin to keep [deg].

    Raises:
        InputError: if a value is not physical, the open loop is undamped, or the closed loop unstable at ``gain``.
    """
    _positive("flow_pressure", actuator.flow_pressure, "m³/s/Pa")
    exact, eq8 = (Loop.of_actuator(actuator, mass, form) for form in ("exact", "eq8"))
    chosen = exact.highest_gain(gain_margin_db, phase_margin_deg) if gain is None else gain
    bandwidth = exact.bandwidth(chosen)
    phase_margin, crossover = exact.phase_margin(chosen) or (None, None)
    resonance = _load_resonance(actuator, mass)
    w_h, d_h = omega_h(actuator, mass), delta_h(actuator, mass)
    valve_hz = actuator.valve_frequency / (2.0 * math.pi)
    ratio = actuator.valve_frequency / w_h
    return FiguresOfMerit(
        hydraulic_stiffness=actuator.hydraulic_stiffness,
        stiffness_ratio=actuator.membrane_stiffness / actuator.hydraulic_stiffness,
        omega_h=w_h,
        omega_h_hz=w_h / (2.0 * math.pi),
        delta_h=d_h,
        resonance_hz=None if resonance is None else abs(resonance) / (2.0 * math.pi),
        resonance_damping=None if resonance is None else -resonance.real / abs(resonance),
        break_frequency=actuator.flow_pressure * actuator.membrane_stiffness / actuator.piston_area**2,
        velocity_gain=exact.numerator,
        gain_margin_db=20.0 * math.log10(exact.stability_gain),
        phase_crossover_hz=exact.phase_crossover / (2.0 * math.pi),
        gain_margin_db_eq8=20.0 * math.log10(eq8.stability_gain),
        phase_crossover_hz_eq8=eq8.phase_crossover / (2.0 * math.pi),
        velocity_gain_limit=exact.stability_gain * exact.numerator,
        merritt_limit=2.0 * d_h * w_h,
        gain=chosen,
        gain_crossover_hz=None if crossover is None else crossover / (2.0 * math.pi),
        phase_margin_deg=phase_margin,
        bandwidth_hz=bandwidth / (2.0 * math.pi),
        valve_hz=valve_hz,
        valve_ratio=ratio,
        rule_of_three=ratio >= RULE_OF_THREE,
    )


def _load_resonance(actuator: Actuator, mass: float) -> complex | None:
    """The exact form's pole above the real axis [rad/s]; None if all its poles are real."""
    upper = [pole for pole in _roots(_act_denominator(actuator, mass, "exact")) if pole.imag > 0]
    return complex(upper[0]) if upper else None
