"""Figures of merit of the paper's actuator: what it is, and what a proportional loop around it can reach."""

import math
from dataclasses import dataclass
from typing import Final

import numpy as np

from ehamj.isolator.actuator import Actuator
from ehamj.isolator.presets import FIRST_GENERATION
from ehamj.paper.actuator import PAPER_MASS, act_denominator, delta_h, omega_h, positive
from ehamj.paper.loop import PositionLoop

RULE_OF_THREE: Final = 3.0
"""What valve makers ask for: the valve's −90° at no less than three times the load's resonance."""


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
    positive("flow_pressure", actuator.flow_pressure, "m³/s/Pa")
    exact, eq8 = (PositionLoop.of_actuator(actuator, mass, form) for form in ("exact", "eq8"))
    chosen = exact.highest_gain(gain_margin_db, phase_margin_deg) if gain is None else gain
    bandwidth = exact.bandwidth(chosen)
    phase_margin, crossover = exact.phase_margin(chosen) or (None, None)
    load = max(np.roots(act_denominator(actuator, mass, "exact")), key=lambda pole: float(pole.imag))
    resonance = complex(load) if load.imag > 0.0 else None
    w_h, d_h = omega_h(actuator, mass), delta_h(actuator, mass)
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
        valve_hz=actuator.valve_frequency / (2.0 * math.pi),
        valve_ratio=ratio,
        rule_of_three=ratio >= RULE_OF_THREE,
    )


@dataclass(frozen=True)
class DesignStudy:
    """A design, and the margins that a proportional loop around it keeps."""

    actuator: Actuator = FIRST_GENERATION
    """The initial design; only its `LINEAR` parameters count."""
    mass: float = PAPER_MASS
    """Translating mass [kg]."""
    gain_margin_db: float = 6.0
    """Gain margin of the closed loop [dB]."""
    phase_margin_deg: float = 45.0
    """Its phase margin [deg]."""

    def merits(self, actuator: Actuator, mass: float) -> FiguresOfMerit:
        """Figures of merit of an actuator under a mass [kg], with the study's margins; errors as `figures_of_merit`."""
        margins = {"gain_margin_db": self.gain_margin_db, "phase_margin_deg": self.phase_margin_deg}
        return figures_of_merit(actuator, mass, **margins)
