"""Cases of oil and energy: what the chambers hold against what crossed their borders."""

from functools import cache

import numpy as np

from ehamj.result import Result
from ehamj.scenario.model import Scenario
from ehamj.verify.case import Finding, Subject, case
from ehamj.verify.setup import fitted_order, open_loop, scenario_of, sines

HERTZ = (7.0, 11.0, 13.0, 17.0)
_ROUGH = "10 s of saturated valves on 20 bar, three blows of 0.3 m/s from below, with cavitation, at the automatic step"


def _balanced(amplitude: float, step: float | str, **table: object) -> Scenario:
    return scenario_of(
        {"vapour_pressure": 5e3}, gravity=9.80665, timestep=step, output={"bookkeeping": True},
        control=open_loop(*sines(amplitude, HERTZ)), **table,
    )  # fmt: skip


@cache
def rough(subject: Subject, step: float | str = "auto", duration: float = 10.0) -> tuple[float, float, str]:
    """Saturated valves on 20 bar, and blows from below that tear the oil apart: errors of oil and energy."""
    blow = {"kind": "shock", "velocity": 0.3, "pulse_time": 0.015}
    blows = [{**blow, "begin": begin} for begin in (0.5, 4.0, 7.5) if begin < duration]
    table = {"supply": {"pressure": 20e5}, "ground": {"kind": "sum", "parts": blows}, "duration": duration}
    result = subject.simulate(_balanced(10.0, step, **table))
    spool, cavitation = (100 * max(result.summary.saturation[name].values()) for name in ("spool", "cavitation"))
    void = 1e9 * float(result.dataset["chamber_void"].max())
    detail = f"{spool:.1f} % saturated, {cavitation:.2f} % cavitating, void {void:.0f} mm³"
    if min(spool, cavitation) == 0.0:
        return float("nan"), float("nan"), f"{detail}: not what this case is about"
    return *imbalance(result), detail


@cache
def smooth(subject: Subject, step: float) -> tuple[float, float, str]:
    """Valves far from saturation over a shaking floor: errors of oil and energy."""
    ground = {"kind": "sine", "amplitude": 1e-4, "frequency": 60.0, "fade_in": 0.2}
    return *imbalance(subject.simulate(_balanced(3.0, step, ground=ground, duration=1.0))), ""


def imbalance(result: Result) -> tuple[float, float]:
    """Oil held less received, over all that moved in that chamber; energy held less received, over that supplied."""
    d = {name: result.dataset[name].values for name in ("oil_in", "oil_held", "oil_energy", "energy_in")}
    moved = np.abs(np.diff(d["oil_in"], axis=0)).sum(axis=0)
    oil = np.abs(d["oil_held"] - d["oil_held"][0] - d["oil_in"]).max(axis=0) / moved
    received = d["energy_in"] - result.dataset["piston_work"].values
    energy = np.abs(d["oil_energy"] - d["oil_energy"][0] - received).max()
    return float(oil.max()), float(energy / result.dataset["supplied_energy"].values[-1])


def _conserved(name: str, source: str, unit: str, tolerance: float, which: int) -> None:
    """Register the case of one balance over a long rough run."""

    @case(name, _ROUGH, source, unit, tolerance, "what a long run may lose before a user would see it")
    def measure(subject: Subject) -> Finding:
        oil, energy, detail = rough(subject)
        return Finding((oil, energy)[which], detail)


_conserved(
    "oil is conserved", "conservation: change of mass in each chamber = ∫ρQ dt", "of the oil that moved", 1e-6, which=0
)
_conserved(
    "energy is conserved", "conservation: change of energy in the oil = ∫(enthalpy in − p dV) dt",
    "of the energy supplied", 1e-4, which=1,
)  # fmt: skip


@case(
    "order of conservation",
    "oil and energy, smooth run, steps from 1/3000 to 1/8000 s",
    "RK4 is of order 4",
    "below order 4",
    0.5,
    "half an order below the integrator's fourth",
)
def smooth_order(subject: Subject) -> Finding:
    """Order with which both balances close on a smooth run."""
    steps = 1.0 / np.array([3000.0, 4000.0, 6000.0, 8000.0])
    errors = np.array([smooth(subject, float(step))[:2] for step in steps])
    oil, energy = fitted_order(steps, errors)
    return Finding(max(0.0, 4.0 - min(oil, energy)), f"oil {oil:.2f}, energy {energy:.2f}")


@case(
    "conservation through kinks",
    "oil and energy, 1 s with saturation and cavitation, steps from 1/3000 to 1/12000 s",
    "a shorter step must help",
    "largest ratio of errors, shorter over longer step",
    1.0,
    "monotone decrease; the order is stated, since kinks inside steps leave no fixed one",
)
def rough_descent(subject: Subject) -> Finding:
    """Through kinks: the largest factor from one step to a shorter one."""
    steps = 1.0 / np.array([3000.0, 4000.0, 6000.0, 8000.0, 12000.0])
    errors = np.array([rough(subject, float(step), 1.0)[:2] for step in steps])
    oil, energy = fitted_order(steps, errors)
    return Finding(float((errors[1:] / errors[:-1]).max()), f"fitted order: oil {oil:.2f}, energy {energy:.2f}")
