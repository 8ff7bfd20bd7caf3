"""Cases of the whole machine: against the reference model, benchmark, modes, statics."""

import tomllib
from functools import cache
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import brentq

from ehamj.linear.modes import modes
from ehamj.result import Result
from ehamj.scenario.load import load_scenario, parse_scenario, shipped_scenarios
from ehamj.scenario.model import Scenario
from ehamj.verify.case import Case, Finding, Subject, fitted_order, open_loop, scenario_of
from ehamj.verify.reference import ReferenceRun, simulate_reference

Array = NDArray[np.float64]

SMOOTH_OPTIONS: dict[str, Any] = {
    "overlap": [0.2, 0.2, -0.1, 0.1],
    "null_offset": 0.1,
    "threshold": 0.05,
    "flow_curve": [[0.0, 0.0], [0.1, 0.05], [0.5, 0.4], [1.0, 1.0]],
    "rated_flow": 3.9e-5,
    "air_fraction": 0.01,
    "wall_modulus": 8e9,
    "area_ratio": 0.9,
    "volume_share": 0.45,
    "vapour_pressure": 5e3,
}
"""Every hydraulic option but hysteresis and end stops."""

ALL_OPTIONS = SMOOTH_OPTIONS | {"hysteresis": 0.1, "end_stops": True, "spool_stroke": 6.0}
"""All of them, with a stroke so short that the stops are hit."""

SHARED_SUPPLY = {"dynamic": True, "tank_pressure": 2e5}


def workshop(isolator: dict[str, Any], shock: float = 0.5e-3) -> Scenario:
    """The shipped workshop for two seconds under feedforward, its shock at 1 s."""
    table = tomllib.loads(shipped_scenarios()["workshop"].read_text(encoding="utf-8"))
    parts = [
        {**part, "begin": 1.0, "velocity": shock} if part["kind"] == "shock" else part
        for part in table["ground"]["parts"]
    ]
    own = {"duration": 2.0, "compare": [], "ground": {**table["ground"], "parts": parts}}
    return parse_scenario({**table, **own, "actuators": {"isolator": isolator}, "supply": SHARED_SUPPLY})


def motion_error(result: Result, reference: ReferenceRun, vapour: float = 0.0) -> float:
    """Largest deviation over time over the channel's own peak about its start: six coordinates, four load pressures.

    Coordinates that move by less than 1e-9 of a metre or radian are left out.
    """
    pressure = result.dataset["chamber_pressure"].values
    exact = np.maximum(reference.pressure, vapour)
    found = np.hstack([result.dataset["machine_displacement"].values, pressure[:, :, 0] - pressure[:, :, 1]])
    wanted = np.hstack([reference.q, exact[:, :, 0] - exact[:, :, 1]])
    peak = np.abs(wanted - wanted[0]).max(axis=0)
    moves = peak > 1e-9
    return float((np.abs(found - wanted).max(axis=0)[moves] / peak[moves]).max())


def smooth_machine(subject: Subject) -> Finding:
    """Every option but hysteresis and stops."""
    scenario = workshop(SMOOTH_OPTIONS)
    reference = simulate_reference(scenario, 1e-8)
    return Finding(motion_error(subject.simulate(scenario), reference), f"{reference.steps} steps of the reference")


def full_machine(subject: Subject) -> Finding:
    """Every option."""
    scenario = workshop(ALL_OPTIONS, shock=2e-3)
    reference = simulate_reference(scenario, 1e-8)
    result = subject.simulate(scenario)
    supply = reference.supply / 1e5
    detail = (
        f"{reference.switches} changes of play and stops, supply {supply.min():.1f} to {supply.max():.1f} bar, "
        f"spool to {np.abs(reference.spool).max():.2f} mA"
    )
    return Finding(motion_error(result, reference, 5e3), detail)


@cache
def benchmark_reference() -> ReferenceRun:
    """The benchmark case at 1e-10."""
    return simulate_reference(load_scenario("benchmark"), 1e-10)


def benchmark(subject: Subject) -> Finding:
    """The benchmark case at the automatic step, compared as benchmark.md says."""
    result = subject.simulate(load_scenario("benchmark"))
    steps = round(result.summary.timing.steps / 2.0)
    return Finding(motion_error(result, benchmark_reference()), f"{steps} steps per second")


def benchmark_order(subject: Subject) -> Finding:
    """Order with which the benchmark converges."""
    rates = np.array([3000, 4000, 6000, 8000])
    errors = [
        motion_error(subject.simulate(load_scenario("benchmark", [f"timestep={1 / rate!r}"])), benchmark_reference())
        for rate in rates.tolist()
    ]
    order = fitted_order(1.0 / rates, np.array(errors))
    return Finding(4.0 - order, f"order {order:.2f}, {errors[-1]:.1e} at 1/8000 s")


MODES = (
    (70.03, 0.005, 0.042),
    (70.66, 0.005, 0.031),
    (76.99, 0.005, 0.024),
    (250.0, 0.05, 0.65),
    (250.0, 0.05, 0.65),
    (250.0, 0.05, 0.65),
    (250.0, 0.05, 0.65),
    (455.2, 0.05, 0.114),
    (528.0, 0.05, 0.098),
    (552.1, 0.05, 0.094),
)
"""Natural frequency [Hz], half its last digit, damping ratio (physics.md section 3)."""


def default_modes(subject: Subject) -> Finding:
    """Frequencies and damping ratios of the default machine."""
    found = sorted((m.frequency, m.damping_ratio) for m in modes(subject.linearise(parse_scenario({}))))
    if len(found) != len(MODES):
        return Finding(float("inf"), f"{len(found)} modes")
    off = [
        max(abs(f - frequency) / half, abs(zeta - damping) / 0.0005)
        for (f, zeta), (frequency, half, damping) in zip(found, MODES, strict=True)
    ]
    return Finding(max(off), ", ".join(f"{f:.2f}" for f, _ in found) + " Hz")


def default_statics(subject: Subject) -> Finding:
    """How far the default machine sinks."""
    scenario = parse_scenario({"duration": 0.001})
    plant = scenario.plant
    exact = -plant.total_mass * plant.gravity / sum(actuator.membrane_stiffness for actuator in plant.actuators)
    found = float(subject.simulate(scenario).dataset["machine_displacement"].values[0, 2])
    return Finding(abs(found / exact - 1.0), f"{1e6 * found:.4f} µm")


def held_statics(subject: Subject) -> Finding:
    """Where the machine stands under four held commands, every option on."""
    volts = {"front-left": 0.5, "front-right": -0.3, "rear-left": 0.2, "rear-right": 1.0}
    signals = [{"kind": "step", "mounts": [m], "amplitude": v, "start": -1.0} for m, v in volts.items()]
    scenario = scenario_of(
        ALL_OPTIONS, gravity=9.80665, supply=SHARED_SUPPLY, control=open_loop(*signals), duration=0.001
    )
    reference = simulate_reference(scenario)
    d = subject.simulate(scenario).dataset
    pairs = (
        (d["machine_displacement"].values[0, 2:5], reference.q[0, 2:5]),
        (d["chamber_pressure"].values[0], reference.pressure[0]),
        (d["supply_pressure"].values[:1], reference.supply[:1]),
    )
    error = max(float(np.abs(found - exact).max() / np.abs(exact).max()) for found, exact in pairs)
    return Finding(error, f"z {1e6 * reference.q[0, 2]:.2f} µm, supply {reference.supply[0] / 1e5:.2f} bar")


def tipping(subject: Subject) -> Finding:
    """The membrane stiffness at which an eigenvalue of the tall machine passes zero."""

    def growth(stiffness: float) -> float:
        isolator = {
            "membrane_stiffness": stiffness,
            "membrane_damping": 1e4,
            "flow_pressure": 6.6e-9,
            "moving_volume": False,
        }
        model = subject.linearise(scenario_of(isolator, gravity=9.80665, machine={"cg": [0.0, 0.0, 1.8]}))
        return float(np.linalg.eigvals(model.A).real.max())

    plant = scenario_of().plant
    exact = plant.machine.mass * 9.80665 * 1.8 / sum(y * y for _, y in plant.positions)
    found = brentq(growth, 0.9 * exact, 1.1 * exact, xtol=1e-9 * exact)
    return Finding(abs(found / exact - 1.0), f"{found / 1e3:.4f} kN/m per mount")


_REFERENCE = "ehamj.verify.reference: the equations in NumPy, SciPy's Runge–Kutta at 1e-8"

CASES = (
    Case(
        "whole machine, smooth options",
        "2 s of workshop floor under feedforward, every option but hysteresis and stops, at the automatic step",
        _REFERENCE,
        "of each channel's peak",
        1e-4,
        "what a long run may lose before a user would see it",
        smooth_machine,
    ),
    Case(
        "whole machine, every option",
        "as above with hysteresis and end stops, and a shock of 2 mm/s that drives the spools into them",
        _REFERENCE + "; changes of play and stops found as roots",
        "of each channel's peak",
        1e-3,
        "a kink inside a step costs second order",
        full_machine,
    ),
    Case(
        "benchmark case",
        "2 s of four valves at 13 to 29 Hz, at the automatic step",
        "ehamj.verify.reference at 1e-10 (DOP853)",
        "of each channel's peak",
        1e-4,
        "what the best peer reaches at its best (benchmark.md)",
        benchmark,
    ),
    Case(
        "order of the benchmark",
        "error over the step, from 1/3000 to 1/8000 s",
        "RK4 is of order 4",
        "below order 4",
        0.5,
        "3.5 is asked; at longer steps the fastest mode is not yet resolved",
        benchmark_order,
    ),
    Case(
        "modes of the default machine",
        "ten natural frequencies and damping ratios",
        "physics.md section 3, from an independent model",
        "halves of the last digit stated",
        1.0,
        "the values are stated to 0.01 Hz (below 100 Hz), 0.1 Hz and 0.001",
        default_modes,
    ),
    Case(
        "sinking under gravity",
        "height of the default machine at rest",
        "closed form −m g/ΣK_L = −14.62 µm",
        "of the height",
        1e-6,
        "Newton's method stops at 1e-7 m/s² of 10; 1e-4 of the feet's stiffness would show",
        default_statics,
    ),
    Case(
        "standing under held commands",
        "heights, tilts and pressures under 0.5, −0.3, 0.2 and 1 V, every option on",
        "ehamj.verify.reference: Newton's method on its own equations",
        "of the largest of its kind",
        1e-6,
        "both are solved to rounding; Newton's method stops at 1e-9 of the full flow",
        held_statics,
    ),
    Case(
        "tipping",
        "membrane stiffness at which a machine with its CG at 1.8 m stops standing; oil leaks, K_C × 100, and "
        "carries no constant load",
        "closed form K_L Σy² = m g h",
        "of the stiffness",
        1e-5,
        "the Jacobian is by differences, 1e-7 rad: 1e-6 of the stiffness",
        tipping,
    ),
)
