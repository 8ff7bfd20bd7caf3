"""The compiled model: masses, membranes, plates and feet against closed forms and the linear oracle."""

import itertools
from dataclasses import replace
from typing import Any

import mujoco
import numpy as np
import pytest
from oracles import linear
from scipy.optimize import linear_sum_assignment

from ehamj.errors import InputError
from ehamj.isolator.actuator import Actuator
from ehamj.linear.machine import linear_model
from ehamj.memory import isolators
from ehamj.mujoco import hydraulics
from ehamj.mujoco.equilibrium import Inputs, equilibrium, jacobian
from ehamj.mujoco.model import build_model
from ehamj.plant.axes import DOF_OF_JOINT
from ehamj.plant.machine import Machine
from ehamj.plant.mounts import MOUNTS
from ehamj.plant.plant import Plant
from ehamj.result import Result
from ehamj.run.simulate import simulate
from ehamj.scenario.load import parse_scenario
from ehamj.views.statics import static_loads

STEP = 1e-4
GRAVITY = 9.80665
DEFLECTION = -14.62e-6
TOPOLOGIES = ("sliding", "tied")
DOFS = list(DOF_OF_JOINT)


def default_plant(plates: str, **changes: Any) -> Plant:
    return replace(parse_scenario({"plates": plates}).plant, **changes)


def uneven_plant(plates: str) -> Plant:
    """No two mounts alike, none where symmetry would put it, the centre of gravity off centre."""
    scales = (1.0, 1.3, 0.7, 1.1)
    actuators = tuple(
        Actuator(
            lateral_stiffness=2e8 * scale**2,
            lateral_damping=2e4 / scale,
            membrane_stiffness=6.8e8 / scale,
            membrane_damping=3900 * scale,
            plate_mass=14.0 * scale,
            piston_area=3.18e-2 * scale,
            chamber_volume=5.39e-4 * scale**1.5,
        )
        for scale in scales
    )
    return default_plant(
        plates,
        machine=Machine(mass=3500.0, inertia=(1500.0, 2500.0, 3200.0), cg=(0.12, -0.07, 0.9)),
        positions=((0.95, 0.62, 0.0), (0.8, -0.55, 0.0), (-0.9, 0.7, 0.0), (-1.0, -0.48, 0.0)),
        actuators=actuators,
    )


def oracle_of(plant: Plant, **changes: Any) -> linear.LinearMachine:
    """The same machine for the linear oracle, by value."""
    names = {
        "m_plate": "plate_mass",
        "k_lat": "lateral_stiffness",
        "c_lat": "lateral_damping",
        "K_L": "membrane_stiffness",
        "C": "membrane_damping",
        "A_p": "piston_area",
        "V_t": "chamber_volume",
    }
    per_mount = {ours: tuple(getattr(a, theirs) for a in plant.actuators) for ours, theirs in names.items()}
    machine = plant.machine
    return linear.LinearMachine(
        mass=machine.mass,
        inertia=machine.inertia,
        cg=machine.cg,
        mounts=tuple(at[:2] for at in plant.positions),
        **per_mount,
        **changes,
    )


def machine_mass_matrix(plant: Plant) -> np.ndarray:
    """Mass matrix (6, 6) at rest in the order x, y, z, rx, ry, rz; plates follow their feet."""
    model = build_model(plant, STEP)
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    full = np.zeros((model.nv, model.nv))
    mujoco.mj_fullM(model, data, full)
    follow = np.vstack([np.eye(6), linear.foot_maps(oracle_of(plant))[2][:, np.argsort(DOFS)]])[: model.nv]
    return (follow.T @ full @ follow)[np.ix_(DOFS, DOFS)]


def linearised(plant: Plant) -> tuple[np.ndarray, np.ndarray]:
    """Eigenvalues at the static equilibrium, and its strokes."""
    model = build_model(plant, STEP)
    data = mujoco.MjData(model)
    with hydraulics():
        state = equilibrium(model, data, Inputs.rest(model))
        values = np.linalg.eigvals(jacobian(model, data, state, Inputs.rest(model)))
        mujoco.mj_forward(model, data)
    return values, data.actuator_length.copy()


def assert_same_modes(found: np.ndarray, expected: np.ndarray, tolerance: float) -> None:
    """Each eigenvalue has its partner, relative to its own size."""
    distance = np.abs(found[:, None] - expected[None, :]) / np.abs(expected)[None, :]
    assert distance[linear_sum_assignment(distance)].max() <= tolerance


@pytest.mark.parametrize("build", [default_plant, uneven_plant])
@pytest.mark.parametrize("plates", TOPOLOGIES)
def test_mass_matrix_is_that_of_the_machine_with_plates_on_its_feet(plates: str, build: Any) -> None:
    plant = build(plates)
    expected = linear.mass_matrix(oracle_of(plant))
    np.testing.assert_allclose(machine_mass_matrix(plant), expected, rtol=0, atol=1e-12 * expected.max())


@pytest.mark.parametrize("plates", TOPOLOGIES)
def test_the_whole_machine_weighs_on_its_mounts(plates: str) -> None:
    plant = uneven_plant(plates)
    model = build_model(plant, STEP)
    data = mujoco.MjData(model)
    with hydraulics():
        mujoco.mj_forward(model, data)
    pull = data.qfrc_actuator - data.qfrc_bias
    vertical = [model.joint(name).id for name in ("z", *(f"plate {m}" for m in MOUNTS if plates == "sliding"))]
    assert plant.total_mass == pytest.approx(3500 + 14 * (1 + 1.3 + 0.7 + 1.1))
    assert pull[vertical].sum() == pytest.approx(-plant.total_mass * GRAVITY, rel=1e-12)


def test_a_sliding_plate_has_a_joint_of_its_own_and_a_tie_to_its_foot() -> None:
    model = build_model(default_plant("sliding"), STEP)
    assert (model.nq, model.neq, model.nu, model.na) == (10, 4, 4, 16)
    assert [model.joint(6 + k).name for k in range(4)] == [f"plate {name}" for name in MOUNTS]


def test_a_tied_plate_is_inertia_of_the_stroke_and_nothing_else() -> None:
    model = build_model(default_plant("tied"), STEP)
    assert (model.nq, model.neq, model.nu, model.na) == (6, 0, 4, 16)
    np.testing.assert_array_equal(model.tendon_armature, [14.0] * 4)


@pytest.fixture(scope="module", params=TOPOLOGIES)
def run(request: pytest.FixtureRequest) -> Result:
    """A short run of the default machine, with the model that is saved beside it."""
    return simulate(parse_scenario({"plates": request.param, "duration": 0.01}))


def test_the_saved_model_stands_in_plain_mujoco(run: Result) -> None:
    model = mujoco.MjModel.from_xml_string(run.model_xml)
    data = mujoco.MjData(model)
    mujoco.mj_step(model, data, nstep=round(4.0 / model.opt.timestep))
    # After 4 s without oil the heave, which decays as exp(−1.9 t), has 0.05 % of its swing left. A tied plate's weight,
    # 1.4 % of the whole, is a force of the callbacks.
    assert data.qpos[2] == pytest.approx(DEFLECTION, rel=0.02)
    assert np.abs(np.delete(data.qpos[:6], 2)).max() < 1e-12
    assert not data.warning.number.any()


def test_the_saved_model_carries_the_actuators_parameters(run: Result) -> None:
    saved = mujoco.MjModel.from_xml_string(run.model_xml)
    compiled = build_model(run.scenario.plant, STEP)
    # MuJoCo writes MJCF with six digits.
    np.testing.assert_allclose(saved.actuator_user, compiled.actuator_user, rtol=1e-5)


@pytest.mark.parametrize("plates", TOPOLOGIES)
def test_the_drawing_does_not_change_the_motion(plates: str) -> None:
    motions = []
    for drawn in (False, True):
        model = build_model(uneven_plant(plates), STEP, drawn)
        data = mujoco.MjData(model)
        with hydraulics():
            equilibrium(model, data, Inputs.rest(model))
            data.userdata[:] = 0.0
            data.ctrl[:] = 1.0, 2.0, -0.5, 0.3
            mujoco.mj_step(model, data, nstep=500)
        motions.append(np.concatenate([data.qpos, data.qvel, data.act]))
    np.testing.assert_array_equal(*motions)


@pytest.mark.parametrize("plates", TOPOLOGIES)
def test_modes_of_an_uneven_machine_are_the_oracles(plates: str) -> None:
    plant = uneven_plant(plates)
    found, strokes = linearised(plant)
    expected = linear.passive_modes(oracle_of(plant, stroke=tuple(strokes)))
    # The machine leans by some 1e-6 rad, which the oracle leaves out; differences have 1e-7 of their own.
    # A sliding plate's constraint adds fast modes: only the oracle's are looked for.
    assert_same_modes(found, expected, 1e-5)


@pytest.mark.parametrize("plates", TOPOLOGIES)
def test_lateral_membranes_act_at_their_own_mounts(plates: str) -> None:
    plant = uneven_plant(plates)
    model = build_model(plant, STEP)
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    along, across, _ = linear.foot_maps(oracle_of(plant))
    for state, name, size in (("qpos", "lateral_stiffness", 1e-6), ("qvel", "lateral_damping", 1e-3)):
        value = np.array([getattr(a, name) for a in plant.actuators])
        expected = (along.T * value) @ along + (across.T * value) @ across
        for dof in (0, 1, 5):
            mujoco.mj_resetData(model, data)
            getattr(data, state)[DOFS[dof]] = size
            mujoco.mj_forward(model, data)
            force = -data.qfrc_passive[DOFS] / size
            # Plane motion loads no vertical membrane; rounding of 1e9 N/m sums.
            np.testing.assert_allclose(force, expected[:, dof], rtol=0, atol=1e-12 * expected.max())


@pytest.mark.parametrize("foot", [1e9, 1e10, 1e11])
def test_a_soft_foot_lowers_heave_as_two_masses_in_series(foot: float) -> None:
    actuator = Actuator(foot_stiffness=foot, foot_damping=1e3)
    found, _ = linearised(default_plant("sliding", actuators=(actuator,) * 4))
    # A quarter of the machine on a foot, on a plate, on membrane and oil: z, z', plate, plate', load pressure.
    m, p, a = 1000.0, actuator.plate_mass, actuator.piston_area
    oil = 4 * actuator.bulk_modulus / actuator.chamber_volume
    k, c = actuator.membrane_stiffness, actuator.membrane_damping
    f, d = foot, actuator.foot_damping
    matrix = np.array(
        [
            [0, 1, 0, 0, 0],
            [-f / m, -d / m, f / m, d / m, 0],
            [0, 0, 0, 1, 0],
            [f / p, d / p, -(f + k) / p, -(d + c) / p, a / p],
            [0, 0, 0, -oil * a, -oil * actuator.flow_pressure],
        ]
    )
    expected = np.linalg.eigvals(matrix)
    nearest = np.abs(found[:, None] - expected[None, :]).min(axis=0) / np.abs(expected)
    # 1e-5: the moving volumes at −15 µm, and differences of a mode at up to 13 kHz.
    assert nearest.max() < 1e-5


def test_a_foot_of_ten_giganewtons_per_metre_pulls_heave_to_365_hz() -> None:
    found, _ = linearised(default_plant("sliding", actuators=(Actuator(foot_stiffness=1e10),) * 4))
    frequencies = np.abs(found[found.imag > 0]) / (2 * np.pi)
    assert np.abs(frequencies - 365.0).min() < 0.5  # physics.md rounds to a hertz


def test_the_rigid_foot_yields_as_little_as_it_says() -> None:
    plant = default_plant("sliding")
    model = build_model(plant, STEP)
    data = mujoco.MjData(model)
    with hydraulics():
        equilibrium(model, data, Inputs.rest(model))
    # A quarter of the machine stands on each foot. 1e-3: the stretch, 1e-12 m, is solved to 1e-15 m.
    expected = foot_compliances(model) * plant.machine.mass * GRAVITY / 4
    np.testing.assert_allclose(data.ten_length, expected, rtol=1e-3)


def test_tied_plates_refuse_soft_feet() -> None:
    soft = Actuator(foot_stiffness=1e10)
    with pytest.raises(ValueError, match=r"needs rigid feet.*front-right.*use plates = 'sliding'"):
        build_model(default_plant("tied", actuators=(Actuator(), soft, Actuator(), Actuator())), STEP)


def test_sliding_plates_need_mass() -> None:
    light = Actuator(plate_mass=0.0)
    with pytest.raises(ValueError, match=r"needs plates with mass.*rear-left.*use plates = 'tied'"):
        build_model(default_plant("sliding", actuators=(Actuator(), Actuator(), light, Actuator())), STEP)


def foot_compliances(model: mujoco.MjModel) -> np.ndarray:
    """Rest compliance [m/N] of each rigid-foot constraint as compiled: R·τ²·d², R = (1 − d)/d · inverse weight."""
    found = []
    for k in range(model.neq):
        tau, d = model.eq_solref[k, 0], model.eq_solimp[k, 0]
        found.append((1 - d) / d * model.tendon_invweight0[model.eq_obj1id[k]] * (tau * d) ** 2)
    return np.array(found)


@pytest.mark.parametrize("plates", TOPOLOGIES)
def test_callbacks_read_the_membranes_that_the_engine_has(plates: str) -> None:
    model = build_model(uneven_plant(plates), STEP)
    table = isolators(model)
    if plates == "tied":
        springs, dampers = model.tendon_stiffness[-4:], model.tendon_damping[-4:]
    else:
        springs, dampers = model.jnt_stiffness[6:], model.dof_damping[6:]
    np.testing.assert_array_equal(table["membrane_stiffness"], np.asarray(springs).reshape(4, -1)[:, 0])
    np.testing.assert_array_equal(table["membrane_damping"], np.asarray(dampers).reshape(4, -1)[:, 0])


def test_each_row_of_parameters_belongs_to_its_mount() -> None:
    plant = uneven_plant("tied")
    model = build_model(plant, STEP)
    for (row, actuator), position in zip(
        itertools.zip_longest(isolators(model), plant.actuators), plant.positions, strict=True
    ):
        assert row["piston_area"] == actuator.piston_area
        assert (row["mount_x"], row["mount_y"]) == position[:2]
        assert row["volume_1"] + row["volume_2"] == pytest.approx(actuator.chamber_volume, rel=1e-15)
        assert row["weight"] == -actuator.plate_mass * GRAVITY


def test_tied_plates_on_soft_feet_are_refused_wherever_the_machine_is_built() -> None:
    scenario = parse_scenario({"plates": "tied", "actuators": {"isolator": {"foot_stiffness": 1e8}}})
    with pytest.raises(InputError, match="plates = 'tied' needs rigid feet"):
        linear_model(scenario.plant)
    with pytest.raises(InputError, match="plates = 'tied' needs rigid feet"):
        static_loads(scenario)
