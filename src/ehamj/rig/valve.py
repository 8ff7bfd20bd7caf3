"""A valve's response by amplitude, and the limit of its drive identified from what a maker's data sheet states.

The spool's drive saturates (`ehamj.isolator.spool.spool_acceleration`), so that the frequency at which it lags by 90°
falls with the amplitude. A data sheet gives that frequency at a few amplitudes, which determines the limit.
"""

from collections.abc import Sequence
from functools import cache
from typing import Any, NamedTuple

import numba
import numpy as np
from scipy.optimize import brentq, minimize_scalar

from ehamj.errors import InputError
from ehamj.isolator.actuator import Actuator
from ehamj.isolator.spool import Spool, spool_acceleration

STEPS = 400
"""Integration steps per period."""
SETTLING = 25
"""Periods before the one that is evaluated."""


class Point(NamedTuple):
    """One line of a data sheet: at this share of full signal [-] the spool lags by 90° at this frequency [Hz]."""

    share: float
    frequency: float


PAPER_POINTS = (Point(0.05, 250.0), Point(0.90, 100.0))
"""What the paper states of its valve."""


def spool_response(actuator: Actuator, share: float, hertz: float) -> complex:
    """Fundamental of the spool over the command (describing function) at a share of full signal and a frequency [Hz].

    The spool alone is integrated (RK4, `STEPS` per period), with the actuator's frequency, damping and drive limit.
    """
    amplitude = share * actuator.spool_stroke
    omega = 2.0 * np.pi * hertz
    real, imaginary = _last_period()(amplitude, omega, Spool.values_of(actuator), STEPS, SETTLING)
    return complex(real, imaginary) / amplitude


def quarter_lag_frequency(actuator: Actuator, share: float) -> float:
    """Frequency [Hz] at which the spool lags by 90° at a share of full signal."""
    natural = actuator.valve_frequency / (2 * np.pi)
    return float(
        brentq(lambda hertz: spool_response(actuator, share, hertz).real, 0.02 * natural, 1.5 * natural, xtol=1e-4)
    )


def identify_drive_limit(actuator: Actuator, points: Sequence[Point] = PAPER_POINTS) -> float:
    """The drive limit a_max [mA/s²] that fits the stated −90° frequencies best, in the ratio of frequencies.

    Args:
        actuator: its valve's natural frequency and damping are kept.
        points: from a data sheet; at least one must lie below the natural frequency, or nothing shows a limit.

    Raises:
        InputError: if a point is impossible, or none shows a limit.
    """
    natural = actuator.valve_frequency / (2 * np.pi)
    for point in points:
        if not (0.0 < point.share <= 1.0 and 0.0 < point.frequency <= 1.2 * natural):
            raise InputError(
                f"point {tuple(point)}: share must be above 0 and at most 1, frequency above 0 and at most the "
                f"valve's own, {natural:.4g} Hz"
            )
    if not points or min(point.frequency for point in points) > 0.98 * natural:
        raise InputError(f"points: one frequency at least must lie below the valve's own, {natural:.4g} Hz")
    # Unclamped, the drive of full signal would reach this.
    scale = actuator.valve_frequency**2 * actuator.spool_stroke

    def misfit(logarithm: float) -> float:
        limited = actuator.with_values({"spool_drive_limit": scale * float(np.exp(logarithm))})
        found = [quarter_lag_frequency(limited, point.share) / point.frequency for point in points]
        return float(np.sum(np.log(found) ** 2))

    best = minimize_scalar(misfit, bounds=(np.log(1e-3), np.log(2.0)), method="bounded", options={"xatol": 1e-5})
    return scale * float(np.exp(best.x))


@cache
def _last_period() -> Any:
    def rate(x, v, target, spool):  # type: ignore[no-untyped-def]
        return v, spool_acceleration(target - x, v, spool)

    compiled_rate = numba.njit(rate)

    def run(amplitude, omega, spool, steps, settling):  # type: ignore[no-untyped-def]
        h = 2.0 * np.pi / omega / steps
        x, v = 0.0, 0.0
        cosine, sine = 0.0, 0.0
        for k in range(steps * (settling + 1)):
            angle = omega * h * k
            first = amplitude * np.sin(angle)
            middle, last = amplitude * np.sin(angle + 0.5 * omega * h), amplitude * np.sin(angle + omega * h)
            if k >= steps * settling:
                cosine += 2.0 / steps * x * np.cos(angle)
                sine += 2.0 / steps * x * np.sin(angle)
            x1, v1 = compiled_rate(x, v, first, spool)
            x2, v2 = compiled_rate(x + 0.5 * h * x1, v + 0.5 * h * v1, middle, spool)
            x3, v3 = compiled_rate(x + 0.5 * h * x2, v + 0.5 * h * v2, middle, spool)
            x4, v4 = compiled_rate(x + h * x3, v + h * v3, last, spool)
            x += h / 6.0 * (x1 + 2.0 * x2 + 2.0 * x3 + x4)
            v += h / 6.0 * (v1 + 2.0 * v2 + 2.0 * v3 + v4)
        return sine, cosine

    return numba.njit(run)
