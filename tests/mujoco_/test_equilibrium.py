"""Static equilibrium and linearisation against closed forms, the nonlinear oracle and its linear sibling."""

from typing import Any

import mujoco
import numpy as np
import pytest
from oracles import linear, machine
from scipy.optimize import brentq, linear_sum_assignment, root

from ehamj.isolator.presets import FIRST_GENERATION
from ehamj.memory import activations
from ehamj.mujoco import hydraulics
from ehamj.mujoco.equilibrium import EquilibriumError, Inputs, equilibrium, jacobian, rates
from ehamj.mujoco.model import build_model
from ehamj.plant.axes import DOF_OF_JOINT
from ehamj.scenario.load import load_scenario, parse_scenario

DOFS = list(DOF_OF_JOINT)
TOPOLOGIES = ("sliding", "tied")
MIDDLE = 35e5


def model_of(plates: str = "tied", machine: dict[str, Any] | None = None, **actuator: Any) -> mujoco.MjModel:
    """The default machine with other actuator values."""
    table = {"plates": plates, "machine": machine or {}, "actuators": {"isolator": actuator}}
    return build_model(parse_scenario(table).plant, 1e-4)


def command(volts: Any) -> Inputs:
    """Ground at rest, valves driven."""
    return Inputs(np.zeros((4, 3)), np.zeros((4, 3)), np.broadcast_to(np.asarray(volts, float), (4,)).copy())


def solved(model: mujoco.MjModel, inputs: Inputs) -> tuple[np.ndarray, np.ndarray]:
    """Position (6,) in the order x, y, z, rx, ry, rz and pressures (4, 2) at the equilibrium."""
    data = mujoco.MjData(model)
    with hydraulics():
        state = equilibrium(model, data, inputs)
    states = activations(model, state[model.nq + model.nv :]).isolators
    return state[DOFS], np.column_stack([states["pressure_1"], states["pressure_2"]])


def eigenvalues(model: mujoco.MjModel) -> np.ndarray:
    data = mujoco.MjData(model)
    with hydraulics():
        return np.linalg.eigvals(
            jacobian(model, data, equilibrium(model, data, Inputs.rest(model)), Inputs.rest(model))
        )


def worst_mode(found: np.ndarray, expected: np.ndarray) -> float:
    """Largest distance of an expected eigenvalue from its partner, over its own size (1 rad/s for zero)."""
    distance = np.abs(found[:, None] - expected[None, :]) / np.maximum(np.abs(expected), 1.0)[None, :]
    return float(distance[linear_sum_assignment(distance)].max())


@pytest.mark.parametrize("plates", TOPOLOGIES)
def test_the_default_machine_stands_14_62_micrometres_down(plates: str) -> None:
    position, pressure = solved(model_of(plates), command(0.0))
    assert position[2] == pytest.approx(-14.62e-6, abs=0.005e-6)  # physics.md's last digit
    # 1e-6: a sliding plate's tie yields a little.
    assert position[2] == pytest.approx(-4056 * 9.80665 / (4 * 6.8e8), rel=1e-6)
    np.testing.assert_allclose(pressure, MIDDLE, rtol=1e-9)


@pytest.mark.parametrize("plates", TOPOLOGIES)
def test_nothing_moves_at_the_equilibrium(plates: str) -> None:
    model = model_of(plates)
    data = mujoco.MjData(model)
    with hydraulics():
        state = equilibrium(model, data, command([5.0, -3.0, 1.0, 0.0]))
        still = rates(model, data, state, command([5.0, -3.0, 1.0, 0.0]))
    # What the solver promises: 1e-7 m/s², which at 70 Hz is a motion of 1e-12 m.
    assert np.abs(still[: model.nq + model.nv]).max() <= 1e-7
    assert np.abs(still[model.nq + model.nv :].reshape(4, 4)[:, :2]).max() <= 1e-9


def test_held_inputs_do_not_depend_on_the_clock() -> None:
    model = model_of()
    inputs = Inputs(np.full((4, 3), 1e-5), np.full((4, 3), 1e-2), np.full(4, 3.0))
    found = []
    for moment in (0.0, 7.3):
        data = mujoco.MjData(model)
        data.time = moment
        with hydraulics():
            found.append(rates(model, data, np.zeros(model.nq + model.nv + model.na), inputs))
    np.testing.assert_array_equal(*found)


@pytest.mark.parametrize("volts", [0.01, 1.0, -4.0, 10.0, 30.0])
def test_a_held_command_lifts_by_what_the_leaking_valve_holds(volts: float) -> None:
    position, pressure = solved(model_of(), command(volts))
    a, supply = FIRST_GENERATION, 2 * MIDDLE
    spool = a.valve_gain * np.clip(volts, -10.0, 10.0)

    def inflow(load: float) -> float:
        """Flow into chamber 1, P1 = middle + load/2; chamber 2 is its mirror image."""
        drop = supply - (MIDDLE + load / 2) if spool > 0 else MIDDLE + load / 2
        ratio = drop / MIDDLE
        through = a.flow_gain * spool * ratio / (ratio**2 + a.laminar_ratio**2) ** 0.25
        return through - (a.edge_leakage + a.cross_leakage) * load

    load = brentq(inflow, -supply, supply, xtol=1e-9, rtol=1e-15)
    lift = (a.piston_area * load - 4056 * 9.80665 / 4) / a.membrane_stiffness
    # 1e-7: the solver's tolerance of 1e-9 of the full flow.
    assert position[2] == pytest.approx(lift, abs=1e-7 * 14.62e-6)
    np.testing.assert_allclose(pressure, [[MIDDLE + load / 2, MIDDLE - load / 2]] * 4, rtol=1e-7)


@pytest.mark.parametrize("volts", [(5.0, -3.0, 1.0, 0.0), (-12.0, 12.0, 12.0, -12.0)])
def test_unequal_commands_tilt_the_machine_as_in_the_oracle(volts: tuple[float, ...]) -> None:
    position, pressure = solved(model_of(), command(volts))
    oracle = machine.default_machine()
    spool = 2.0 * np.clip(volts, -10.0, 10.0)

    def imbalance(unknown: np.ndarray) -> np.ndarray:
        state = machine.OracleState(
            unknown[:6] * 1e-5, np.zeros(6), spool, np.zeros(4), (1 + unknown[6:].reshape(4, 2)) * MIDDLE
        )
        rate = machine.rates(oracle, state, volts)
        return np.concatenate([rate.qd, rate.pressure.ravel() / 1e8])

    found = root(imbalance, np.zeros(14), tol=1e-13)
    # 1e-6 of 10 µm: the oracle's kinematics are linear, and both solvers have 1e-7.
    np.testing.assert_allclose(position, found.x[:6] * 1e-5, rtol=0, atol=1e-11)
    np.testing.assert_allclose(pressure, (1 + found.x[6:].reshape(4, 2)) * MIDDLE, rtol=1e-6)


def test_a_raised_floor_raises_the_machine() -> None:
    floor = np.zeros((4, 3))
    floor[:] = 2e-5, -3e-5, 1e-4
    position, _ = solved(model_of(), Inputs(floor, np.zeros((4, 3)), np.zeros(4)))
    np.testing.assert_allclose(position, [2e-5, -3e-5, 1e-4 - 4056 * 9.80665 / (4 * 6.8e8), 0, 0, 0], atol=1e-12)


@pytest.mark.parametrize("plates", TOPOLOGIES)
def test_without_edge_leakage_the_mean_pressure_stays_at_half_the_supply(plates: str) -> None:
    # Nothing determines the mean then: the static equations are singular.
    position, pressure = solved(model_of(plates, edge_leakage_share=0.0), command(0.0))
    # 1e-7: differences across a sliding plate's tie, a spring of 1e16 N/m, are noisy: 0.1 Pa.
    np.testing.assert_allclose(pressure.mean(axis=1), MIDDLE, rtol=1e-7)
    np.testing.assert_allclose(pressure[:, 0] - pressure[:, 1], 0.0, atol=1e-9 * MIDDLE)  # the piston leaks it away
    assert position[2] == pytest.approx(-14.62e-6, abs=0.005e-6)


@pytest.mark.parametrize("plates", TOPOLOGIES)
def test_modes_of_the_default_machine_are_the_oracles(plates: str) -> None:
    found = eigenvalues(model_of(plates))
    # 1e-5: the oracle's chambers stand at stroke 0, here at −14.6 µm of 8.5 mm.
    assert worst_mode(found, linear.passive_modes(linear.LinearMachine())) <= 1e-5


def test_modes_of_the_benchmark_are_the_oracles_with_four_neutral_pressures() -> None:
    found = eigenvalues(build_model(load_scenario("benchmark").plant, 1e-4))
    assert worst_mode(found, linear.passive_modes(linear.benchmark_linear())) <= 1e-6
    assert np.sum(np.abs(found) < 1e-6) == 4


def test_a_tall_machine_on_soft_mounts_falls_as_fast_as_the_oracle_says() -> None:
    soft = {"membrane_stiffness": 5e4, "lateral_stiffness": 2e7, "flow_pressure": 1e-8, "moving_volume": False}
    shape = {"cg": (0.0, 0.0, 3.0), "size": (2.2, 1.6, 4.0), "inertia": (2000.0, 3000.0, 4000.0)}
    found = eigenvalues(model_of(machine=shape, **soft))
    oracle = linear.LinearMachine(cg=(0.0, 0.0, 3.0), K_L=5e4, k_lat=2e7, g0=0.05e-8, cross=0.95e-8)
    expected = linear.passive_modes(oracle)
    fastest = expected.real.max()
    assert fastest > 0.1  # gravity beats the mounts
    assert found.real.max() == pytest.approx(fastest, rel=1e-4)


def test_a_machine_without_membranes_cannot_stand() -> None:
    # Leaking oil carries no static load.
    plant = parse_scenario({"plates": "tied"}).plant
    for name in plant.mounts:
        plant = plant.with_actuator(name, {"membrane_stiffness": 0.0})  # a scenario like this is refused before
    with pytest.raises(EquilibriumError, match="cannot stand"):
        solved(build_model(plant, 1e-4), command(0.0))


@pytest.mark.parametrize("plates", TOPOLOGIES)
def test_a_machine_that_sags_to_the_end_of_its_strokes_cannot_stand(plates: str) -> None:
    # 9.94 mm, where 8.475 mm empty the lower chamber.
    with pytest.raises(EquilibriumError, match="cannot stand"):
        solved(model_of(plates, membrane_stiffness=1e6), command(0.0))


def test_a_machine_that_hangs_beside_its_mounts_has_tipped_over() -> None:
    # Three soft mounts behind the centre of gravity balance it where it has turned by 1.2 rad.
    table = [
        {"name": name, "position": [x, y], "actuator": "soft"}
        for name, x, y in (("a", -0.9, 0.6), ("b", -0.9, -0.6), ("c", -0.2, 0.0))
    ]
    given = {"plates": "tied", "mount": table, "actuators": {"soft": {"preset": "pneumatic-mount"}}}
    model = build_model(parse_scenario(given).plant, 1e-4)
    with pytest.raises(EquilibriumError, match=r"turned by 1\.2 rad"):
        solved(model, Inputs.rest(model))
