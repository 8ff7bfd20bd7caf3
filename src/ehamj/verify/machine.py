"""Cases of the whole machine against the reference model."""

import tomllib
from functools import cache
from typing import Any

import numpy as np

from ehamj.result import Result
from ehamj.scenario.load import load_scenario, parse_scenario, shipped_scenarios
from ehamj.scenario.model import Scenario
from ehamj.verify.case import Finding, Subject, case
from ehamj.verify.reference import ReferenceRun, simulate_reference
from ehamj.verify.setup import ALL_OPTIONS, SHARED_SUPPLY, SMOOTH_OPTIONS, fitted_order, open_loop, sines

_REFERENCE = "ehamj.verify.reference: the equations in NumPy, SciPy's Runge–Kutta at 1e-8"


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


@cache
def smooth_reference() -> ReferenceRun:
    """The workshop with smooth options at 1e-8."""
    return simulate_reference(workshop(SMOOTH_OPTIONS), 1e-8)


@case(
    "whole machine, smooth options",
    "2 s of workshop floor under feedforward, every option but hysteresis and stops, at the automatic step",
    _REFERENCE,
    "of each channel's peak",
    1e-4,
    "what a long run may lose before a user would see it",
)
def smooth_machine(subject: Subject) -> Finding:
    """Every option but hysteresis and stops."""
    scenario, reference = workshop(SMOOTH_OPTIONS), smooth_reference()
    return Finding(motion_error(subject.simulate(scenario), reference), f"{reference.steps} steps of the reference")


@case(
    "whole machine, a stuck spool",
    "0.3 s of four valves at 13 to 29 Hz, one of them stuck 5 % open, options as above, at a step of 0.1 ms",
    _REFERENCE,
    "of each channel's peak",
    1e-4,
    "as above; at the automatic step kinks of these options cost 7e-4 under such commands, stuck or not",
)
def stuck_machine(subject: Subject) -> Finding:
    """One valve that is stuck, beside three that work."""
    stuck = {**SMOOTH_OPTIONS, "spool_stuck": True, "spool_stuck_at": 0.05}
    mounts = [mount.model_dump(include={"name", "position"}) for mount in parse_scenario({}).mount]
    mounts[1]["actuator"] = "stuck"
    control = open_loop(*sines(1.0, (13.0, 17.0, 23.0, 29.0)))
    scenario = parse_scenario({
        "plates": "tied", "mount": mounts, "actuators": {"isolator": SMOOTH_OPTIONS, "stuck": stuck},
        "supply": SHARED_SUPPLY, "control": control, "duration": 0.3, "timestep": 1e-4,
    })  # fmt: skip
    reference = simulate_reference(scenario, 1e-8)
    spool = np.abs(reference.spool[:, 1] / (0.05 * scenario.plant.actuators[1].spool_stroke) - 1.0).max()
    return Finding(motion_error(subject.simulate(scenario), reference), f"its spool within {spool:.0e} of its place")


SKEW = (
    ((0.9, 0.5, 0.0), (0.8, 0.3, 1.0)), ((0.9, -0.5, 0.3), (0.0, -0.6, 1.0)), ((-0.2, 0.7, -0.4), (-0.3, 0.7, 1.0)),
    ((-0.8, 0.4, 0.2), (-0.5, 0.0, 1.0)), ((-0.8, -0.5, 0.0), (0.2, 0.9, 0.5)), ((0.0, -0.7, 0.1), (-1.0, 0.2, 0.1)),
)  # fmt: skip
"""Places and directions of six mounts that drive all six motions."""


@case(
    "whole machine, six skew isolators",
    "0.3 s of six isolators in six directions, one on a shim, over a floor that moves in all; an inertia with products",
    _REFERENCE,
    "of each channel's peak",
    1e-4,
    "as above; angles of 1e-5 rad at rest, kept to second order, leave 1e-10",
)
def skew_machine(subject: Subject) -> Finding:
    """Six isolators in any direction."""
    mounts = [
        {"name": f"m{k}", "position": place, "direction": way, "height": 2e-6 if k == 1 else 0.0}
        for k, (place, way) in enumerate(SKEW, start=1)
    ]
    floor = (("x", 3e-6, 9.0), ("y", 2e-6, 14.0), ("z", 2e-6, 23.0), ("rx", 1e-6, 12.0), ("rz", 2e-6, 7.0))
    parts = [
        {"kind": "sine", "dof": dof, "amplitude": size, "frequency": hertz, "fade_in": 0.1}
        for dof, size, hertz in floor
    ]
    scenario = parse_scenario({
        "plates": "tied", "mount": mounts, "duration": 0.3,
        "machine": {"cg": [0.05, -0.1, 0.9], "inertia": [[2100, 120, -80], [120, 2900, 60], [-80, 60, 3900]]},
        "ground": {"kind": "sum", "parts": parts},
        "control": open_loop(*sines(0.3, (13.0, 15.0, 17.0, 19.0, 23.0, 29.0), [f"m{k}" for k in range(1, 7)])),
    })  # fmt: skip
    reference = simulate_reference(scenario, 1e-9)
    found = motion_error(subject.simulate(scenario), reference)
    return Finding(found, f"tilts to {1e6 * np.abs(reference.q[:, 3:]).max():.0f} µrad")


@case(
    "whole machine, every option",
    "as above with hysteresis and end stops, and a shock of 2 mm/s that drives the spools into them",
    _REFERENCE + "; changes of play and stops found as roots",
    "of each channel's peak",
    1e-3,
    "a kink inside a step costs second order",
)
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


@case(
    "benchmark case",
    "2 s of four valves at 13 to 29 Hz, at the automatic step",
    "ehamj.verify.reference at 1e-10 (DOP853)",
    "of each channel's peak",
    1e-4,
    "what the best peer reaches at its best (benchmark.md)",
)
def benchmark(subject: Subject) -> Finding:
    """The benchmark case at the automatic step, compared as benchmark.md says."""
    result = subject.simulate(load_scenario("benchmark"))
    steps = round(result.summary.timing.steps / 2.0)
    return Finding(motion_error(result, benchmark_reference()), f"{steps} steps per second")


@case(
    "order of the benchmark",
    "error over the step, from 1/3000 to 1/8000 s",
    "RK4 is of order 4",
    "below order 4",
    0.5,
    "3.5 is asked; at longer steps the fastest mode is not yet resolved",
)
def benchmark_order(subject: Subject) -> Finding:
    """Order with which the benchmark converges."""
    steps = 1.0 / np.array([3000.0, 4000.0, 6000.0, 8000.0])
    runs = (subject.simulate(load_scenario("benchmark", [f"timestep={step!r}"])) for step in steps.tolist())
    errors = [motion_error(run, benchmark_reference()) for run in runs]
    order = float(fitted_order(steps, np.array(errors)))
    return Finding(4.0 - order, f"order {order:.2f}, {errors[-1]:.1e} at 1/8000 s")
