"""A position loop under proportional control: its crossings, its margins, and the highest gain that keeps them."""

import math
from dataclasses import dataclass
from functools import cached_property
from typing import Any, Final, Self

import numpy as np
from numpy import polyadd, polymul
from numpy.typing import NDArray

from ehamj.errors import InputError
from ehamj.isolator.actuator import Actuator
from ehamj.paper.actuator import PAPER_MASS, Array, Form, eha, phase_of, positive

UNDAMPED: Final = 1e-9
"""Damping ratio of a pole below which a loop counts as undamped."""


@dataclass(frozen=True, eq=False)
class PositionLoop:
    """A stable loop without zeros, L = numerator/denominator(s), of order five at most.

    The phase of such a loop only falls, to −450° at most: it passes each angle once, and −180° alone decides on
    stability.

    Raises:
        InputError: if it has more than five poles, or one that is not damped (one integrator is allowed).
    """

    numerator: float
    denominator: Array
    """Coefficients, highest power first."""

    def __post_init__(self) -> None:
        poles = self.poles
        positive("numerator", self.numerator, "(of the loop)")
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
        """G_EHA (eq. 9); errors as `ehamj.paper.actuator.g_act`."""
        return cls(*eha(actuator, mass, form))

    @cached_property
    def poles(self) -> NDArray[Any]:
        """Roots of the denominator [rad/s]."""
        return np.roots(self.denominator)

    def response(self, omega: float | Array) -> Any:
        """Complex gain at ``omega`` [rad/s]."""
        return self.numerator / np.polyval(self.denominator, 1j * np.asarray(omega))

    def phase(self, omega: float | Array) -> Any:
        """Continuous phase [deg] at ``omega`` > 0 [rad/s]."""
        return phase_of(self.poles, omega)

    def phase_crossing(self, degrees: float) -> float | None:
        """Frequency [rad/s] at which the phase passes ``degrees``; None if it starts below or never gets there.

        There the denominator, turned by that angle, is real: of the roots of its imaginary part it is the one whose
        phase is not a multiple of 180° away.
        """
        start = -90.0 * np.count_nonzero(self.poles == 0)
        if not -90.0 * len(self.poles) < degrees < start:
            return None
        powers = 1j ** np.arange(len(self.denominator))[::-1]
        turned = self.denominator * powers * np.exp(1j * math.radians(degrees))
        # What only rounding leaves of a coefficient would be a root far away that costs the others their digits.
        crossings = _positive_roots(np.where(np.abs(turned.imag) > 4e-16 * np.abs(turned), turned.imag, 0.0))
        return min(crossings, key=lambda omega: abs(float(self.phase(omega)) - degrees))

    @cached_property
    def phase_crossover(self) -> float:
        """Frequency at which the phase passes −180° [rad/s]; inf if it never does."""
        return self.phase_crossing(-180.0) or math.inf

    @property
    def stability_gain(self) -> float:
        """Proportional gain at which the closed loop turns unstable, 1/|L| at −180°; inf if it never does."""
        crossover = self.phase_crossover
        return math.inf if math.isinf(crossover) else float(1.0 / abs(self.response(crossover)))

    def gain_crossings(self, gain: float) -> list[float]:
        """Frequencies at which gain·|L| passes 1, rising [rad/s]."""
        square = _squared(self.denominator)
        square[-1] -= (gain * self.numerator) ** 2
        return [math.sqrt(x) for x in _positive_roots(square)]

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
            turns = [math.sqrt(x) for x in _positive_roots(np.polyder(_squared(self.denominator)))]
            within = [w for w in (first, *turns, last) if first <= w <= last and math.isfinite(w)]
            limits.append(1.0 / max(abs(self.response(w)) for w in within))
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
        if not positive("gain", gain, "V/m") < limit:
            raise InputError(
                f"gain = {gain:.6g} V/m: the closed loop is unstable and has no bandwidth; it must be below {limit:.6g}"
                f" V/m, the limit at {self.phase_crossover / (2 * math.pi):.4g} Hz"
            )
        square = _squared(polyadd(self.denominator, [gain * self.numerator]))
        square[-1] *= 1.0 - 10.0**0.3
        return math.sqrt(_positive_roots(square)[0])


def _squared(polynomial: Array) -> Array:
    """|p(jω)|² as a polynomial in ω², highest power first: p(s)·p(−s) with s² = −ω²."""
    signs = (-1.0) ** np.arange(len(polynomial))[::-1]
    square = polymul(polynomial, polynomial * signs)[::2]
    return square * (-1.0) ** np.arange(len(square))[::-1]


def _positive_roots(polynomial: Array) -> list[float]:
    """Real roots above zero, rising; one Newton step each gives back what roots of very different sizes cost."""
    roots = np.roots(polynomial)
    found = roots.real[(np.abs(roots.imag) <= 1e-9 * np.abs(roots)) & (roots.real > 0.0)]
    return sorted((found - np.polyval(polynomial, found) / np.polyval(np.polyder(polynomial), found)).tolist())
