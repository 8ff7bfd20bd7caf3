"""Cases of modes and equilibria: the default machine, held commands, tipping."""

import numpy as np
from scipy.optimize import brentq

from ehamj.linear.modes import modes
from ehamj.scenario.load import parse_scenario
from ehamj.verify.case import Finding, Subject, case
from ehamj.verify.reference import simulate_reference
from ehamj.verify.setup import ALL_OPTIONS, SHARED_SUPPLY, open_loop, scenario_of

MODES = (
    (70.03, 0.005, 0.042),
    (70.66, 0.005, 0.031),
    (76.99, 0.005, 0.024),
    *[(250.0, 0.05, 0.65)] * 4,
    (455.2, 0.05, 0.114),
    (528.0, 0.05, 0.098),
    (552.1, 0.05, 0.094),
)
"""Natural frequency [Hz], half its last digit, damping ratio (physics.md section 3)."""


@case(
    "modes of the default machine",
    "ten natural frequencies and damping ratios",
    "physics.md section 3, from an independent model",
    "halves of the last digit stated",
    1.0,
    "the values are stated to 0.01 Hz (below 100 Hz), 0.1 Hz and 0.001",
)
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


@case(
    "sinking under gravity",
    "height of the default machine at rest",
    "closed form −m g/ΣK_L = −14.62 µm",
    "of the height",
    1e-6,
    "Newton's method stops at 1e-7 m/s² of 10; 1e-4 of the feet's stiffness would show",
)
def default_statics(subject: Subject) -> Finding:
    """How far the default machine sinks."""
    scenario = parse_scenario({"duration": 0.001})
    plant = scenario.plant
    exact = -plant.total_mass * plant.gravity / sum(actuator.membrane_stiffness for actuator in plant.actuators)
    (moved,) = subject.channels(scenario, "machine_displacement")
    return Finding(abs(moved[0, 2] / exact - 1.0), f"{1e6 * moved[0, 2]:.4f} µm")


@case(
    "standing under held commands",
    "heights, tilts and pressures under 0.5, −0.3, 0.2 and 1 V, every option on",
    "ehamj.verify.reference: Newton's method on its own equations",
    "of the largest of its kind",
    1e-6,
    "both are solved to rounding; Newton's method stops at 1e-9 of the full flow",
)
def held_statics(subject: Subject) -> Finding:
    """Where the machine stands under four held commands, every option on."""
    volts = {"front-left": 0.5, "front-right": -0.3, "rear-left": 0.2, "rear-right": 1.0}
    signals = [{"kind": "step", "mounts": [m], "amplitude": v, "start": -1.0} for m, v in volts.items()]
    scenario = scenario_of(
        ALL_OPTIONS, gravity=9.80665, supply=SHARED_SUPPLY, control=open_loop(*signals), duration=0.001
    )
    reference = simulate_reference(scenario)
    moved, p, supply = subject.channels(scenario, "machine_displacement", "chamber_pressure", "supply_pressure")
    pairs = (
        (moved[0, 2:5], reference.q[0, 2:5]), (p[0], reference.pressure[0]), (supply[:1], reference.supply[:1])
    )  # fmt: skip
    error = max(float(np.abs(found - exact).max() / np.abs(exact).max()) for found, exact in pairs)
    return Finding(error, f"z {1e6 * reference.q[0, 2]:.2f} µm, supply {reference.supply[0] / 1e5:.2f} bar")


@case(
    "tipping",
    "membrane stiffness at which a machine with its CG at 1.8 m stops standing; oil leaks, K_C × 100, and "
    "carries no constant load",
    "closed form K_L Σy² = m g h",
    "of the stiffness",
    1e-5,
    "the Jacobian is by differences, 1e-7 rad: 1e-6 of the stiffness",
)
def tipping(subject: Subject) -> Finding:
    """The membrane stiffness at which an eigenvalue of the tall machine passes zero."""

    leaky = {"membrane_damping": 1e4, "flow_pressure": 6.6e-9, "moving_volume": False}

    def growth(stiffness: float) -> float:
        isolator = {"membrane_stiffness": stiffness, **leaky}
        model = subject.linearise(scenario_of(isolator, gravity=9.80665, machine={"cg": [0.0, 0.0, 1.8]}))
        return float(np.linalg.eigvals(model.A).real.max())

    plant = scenario_of().plant
    exact = plant.machine.mass * 9.80665 * 1.8 / sum(y * y for _, y, _ in plant.positions)
    found = brentq(growth, 0.9 * exact, 1.1 * exact, xtol=1e-9 * exact)
    return Finding(abs(found / exact - 1.0), f"{found / 1e3:.4f} kN/m per mount")
