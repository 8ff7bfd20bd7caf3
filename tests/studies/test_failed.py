"""A failed actuator: forces at rest against statics, residual isolation against nonlinear runs."""

import numpy as np
import pytest

from ehamj.errors import InputError
from ehamj.isolator.presets import FIRST_GENERATION
from ehamj.linear.loop import Loop
from ehamj.linear.machine import linear_model
from ehamj.scenario.load import parse_scenario
from ehamj.studies import failed as study
from ehamj.studies.rest import static_forces

MACHINE = parse_scenario({"name": "a machine", "plates": "tied", "control": {"kind": "feedforward"}})
LINES = np.array(study.FailedSettings().lines)


@pytest.mark.parametrize("failure", [study.INTACT, *study.FAILURES])
def test_mounts_carry_the_weight(failure: str) -> None:
    """Force and moment balance of the whole machine, whose CG moves aside as it tilts."""
    model = linear_model(study.failed(MACHINE, failure).plant)
    plant, forces = model.plant, static_forces(model)
    carried = forces["oil"] + forces["membrane"]
    x, y, _ = np.array(plant.positions).T
    assert carried.sum() == pytest.approx(plant.total_mass * plant.gravity, rel=1e-7)
    rx, ry = (model.equilibrium[model.states.index(f"displacement {joint}")] for joint in ("rx", "ry"))
    moved = plant.machine.mass * plant.gravity * plant.machine.cg[2] * np.array([ry, -rx])
    assert np.array([x @ carried, y @ carried]) == pytest.approx(moved, abs=1e-4)


def test_a_leaking_piston_keeps_its_edges() -> None:
    worn = study.failed(MACHINE, "piston leaks", "rear-left").plant.actuators[2]
    assert worn.edge_leakage == pytest.approx(FIRST_GENERATION.edge_leakage)
    assert worn.edge_leakage + worn.cross_leakage == pytest.approx(100 * FIRST_GENERATION.flow_pressure)


def test_a_stuck_valve_ignores_its_command() -> None:
    model = linear_model(study.failed(MACHINE, "valve stuck centred").plant)
    spools = [model.states.index(f"spool_rate {mount}") for mount in ("front-left", "front-right")]
    gains = np.abs(model.B[spools, [0, 1]])
    assert gains[0] < 1e-8 * gains[1]


@pytest.mark.parametrize("failure", ["valve stuck fully open", "membrane only"])
def test_the_run_agrees_with_the_linear_residual(failure: str) -> None:
    """1e-3 of the floor's motion, the law's 16 bit and the valve's root law; the residual itself is 250 of that."""
    scenario, law = study.failed(MACHINE, failure), Loop.of(MACHINE, MACHINE.controller())
    linear = study.residual(linear_model(scenario.plant), law, LINES)
    simulated = study.simulated_residual(scenario, law)
    assert np.abs(simulated - linear)[:, 0].max() < 1e-3
    assert np.abs(simulated - linear)[:, 1:].max() < 3e-3  # rad/m, of 0.5


def test_without_a_law_the_run_agrees_far_better() -> None:
    """Nothing is quantised: 1e-4 is the step's error at 100 Hz."""
    scenario = study.failed(MACHINE, "membrane only")
    linear = study.residual(linear_model(scenario.plant), None, LINES)
    assert np.abs(study.simulated_residual(scenario, None) - linear).max() < 1e-4


def test_a_valve_that_runs_away_ends_where_the_stuck_one_stands() -> None:
    """The run ends 60 time constants of the slowest motion later."""
    static = static_forces(linear_model(study.failed(MACHINE, "valve stuck 5 % open").plant))
    event = study.simulated_event(MACHINE, study.STUCK)
    for part in ("oil", "membrane"):
        assert event[part] == pytest.approx(static[part], abs=0.01), part
    assert static["oil"][0] > 500.0


def test_three_actuators_leave_a_quarter() -> None:
    """Far below the modes the stiff machine heaves with the mean of its corners, of which one follows the floor."""
    gain = np.abs(
        study.residual(
            linear_model(study.failed(MACHINE, "valve stuck centred").plant),
            Loop.of(MACHINE, MACHINE.controller()),
            LINES,
        )
    )
    assert gain[:3, 0] == pytest.approx(np.full(3, 0.25), rel=0.01)


def test_names_are_checked() -> None:
    with pytest.raises(InputError, match=r"mount = 'front'.*front-left"):
        study.failed_actuator(MACHINE, study.FailedSettings(mount="front"))
    with pytest.raises(InputError, match=r"failure = 'rust'.*intact.*membrane only"):
        study.failed(MACHINE, "rust")
