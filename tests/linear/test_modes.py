"""Modes: the default machine's published ones, closed forms in limits, and a digital loop discretised another way."""

import json
from typing import Any

import numpy as np
import pytest
from oracles import linear
from scipy.linalg import expm
from scipy.optimize import linear_sum_assignment

from ehamj.control import Controller
from ehamj.control.sensors import IDEAL
from ehamj.linear.eigen import mac
from ehamj.linear.loop import Loop
from ehamj.linear.machine import LinearModel, linear_model
from ehamj.linear.modes import Mode, modes
from ehamj.linear.names import energy_shares, group_of, motion_name
from ehamj.linear.shapes import centre_of_rotation, in_phase
from ehamj.plant.axes import DOFS
from ehamj.plant.machine import Machine
from ehamj.plant.mounts import DEFAULT_MOUNTS, MOUNTS
from ehamj.scenario.load import parse_scenario

STROKES = tuple(f"stroke {mount}" for mount in MOUNTS)
TABLE_I = linear.PaperActuator()


def model_of(machine: dict[str, Any] | None = None, **isolator: Any) -> LinearModel:
    return linear_model(parse_scenario({"machine": machine or {}, "actuators": {"isolator": isolator}}).plant)


def named(found: tuple[Mode, ...], name: str) -> Mode:
    (mode,) = (mode for mode in found if mode.name == name)
    return mode


# --- the default machine ------------------------------------------------------------------------------------------

DEFAULT = (
    ("sway-rocking about x", 70.03, 0.042),
    ("sway-rocking about y", 70.66, 0.031),
    ("yaw", 76.99, 0.024),
    ("rocking about x", 455.2, 0.114),
    ("heave", 528.0, 0.098),
    ("rocking about y", 552.1, 0.094),
)
"""From an independent model (physics.md, section 3)."""


@pytest.fixture(scope="module")
def default() -> tuple[Mode, ...]:
    return modes(model_of())


@pytest.mark.parametrize(("name", "frequency", "damping"), DEFAULT)
def test_a_mode_of_the_default_machine(name: str, frequency: float, damping: float, default: tuple[Mode, ...]) -> None:
    mode = named(default, name)
    assert mode.frequency == pytest.approx(frequency, rel=1e-3)
    assert round(mode.damping_ratio, 3) == damping


def test_the_default_machine_has_four_valves(default: tuple[Mode, ...]) -> None:
    valves = [mode for mode in default if mode.name.startswith("valve")]
    assert [round(mode.frequency, 1) for mode in valves] == [250.0] * 4
    np.testing.assert_allclose([mode.damping_ratio for mode in valves], 0.65, rtol=1e-6)
    assert [mode.name for mode in valves] == [f"valve {mount}" for mount in MOUNTS]


def test_the_default_machine_has_no_further_mode(default: tuple[Mode, ...]) -> None:
    assert sorted(mode.name for mode in default) == sorted(
        [name for name, _, _ in DEFAULT] + [f"valve {mount}" for mount in MOUNTS]
    )


def test_modes_come_by_frequency(default: tuple[Mode, ...]) -> None:
    frequencies = [mode.frequency for mode in default]
    assert frequencies == sorted(frequencies)


def test_plates_on_joints_of_their_own_leave_the_machines_modes_as_they_are(default: tuple[Mode, ...]) -> None:
    sliding = modes(linear_model(parse_scenario({}).plant, feet=True))
    for name, _, _ in DEFAULT:
        assert named(sliding, name).frequency == pytest.approx(named(default, name).frequency, rel=1e-4)


def test_a_ring_down_shows_the_damped_frequency() -> None:
    mode = Mode("heave", 100.0, 0.6, np.ones(6, complex), {})
    assert mode.damped_frequency == pytest.approx(80.0, rel=1e-14)


def test_a_mode_as_plain_data_is_strict_json(default: tuple[Mode, ...]) -> None:
    table = json.loads(json.dumps([mode.to_dict() for mode in default], allow_nan=False))
    assert {"name", "frequency_hz", "damping_ratio", "shape"} <= set(table[0])
    assert (table[2]["name"], table[2]["frequency_hz"]) == ("yaw", default[2].frequency)
    assert table[2]["shape"]["rz"] == [1.0, 0.0]


# --- shapes -------------------------------------------------------------------------------------------------------


def test_every_mode_of_the_asymmetric_machine_is_the_oracles() -> None:
    machine = {"cg": [0.15, -0.1, 0.9], "inertia": [2500.0, 3600.0, 4100.0]}
    oracle = linear.LinearMachine(cg=(0.15, -0.1, 0.9), inertia=(2500.0, 3600.0, 4100.0))
    found = np.array([(mode.frequency, mode.damping_ratio) for mode in modes(model_of(machine))])
    expected = linear.oscillators(linear.passive_modes(oracle))
    # 1e-5: the oracle's chambers stand at stroke 0.
    np.testing.assert_allclose(found, expected, rtol=1e-5)


def test_shapes_are_the_oracles_eigenvectors() -> None:
    machine = {"cg": [0.15, -0.1, 0.9], "inertia": [2500.0, 3600.0, 4100.0]}
    a = linear.state_space(linear.LinearMachine(cg=(0.15, -0.1, 0.9), inertia=(2500.0, 3600.0, 4100.0)))[0]
    values, vectors = np.linalg.eig(a)
    for mode in modes(model_of(machine)):
        if mode.name.startswith("valve"):
            continue  # four equal eigenvalues: any combination of them is a mode
        pole = 2 * np.pi * mode.frequency * complex(-mode.damping_ratio, np.sqrt(1 - mode.damping_ratio**2))
        shape = vectors[:6, np.argmin(np.abs(values - pole))]
        shape = shape / shape[np.argmax(np.abs(shape))]
        np.testing.assert_allclose(mode.shape, shape, rtol=0, atol=1e-4)


@pytest.mark.parametrize(
    ("moves", "name"),
    [
        ({"z": 1.0, "rx": 0.1}, "heave"),
        ({"rz": 1.0, "x": 0.1}, "yaw"),
        # About the mount plane's centre; at the CG, 0.75 m above, x + 0.75 ry counts.
        ({"x": 1.0}, "sway-rocking about y"),
        ({"y": 1.0}, "sway-rocking about x"),
        ({"ry": 1.0, "x": -0.75}, "rocking about y"),
        ({"rx": 1.0, "y": 0.75}, "rocking about x"),
    ],
)
def test_a_motion_is_named_by_where_its_energy_is(moves: dict[str, float], name: str) -> None:
    shape = np.array([moves.get(dof, 0.0) for dof in ("x", "y", "z", "rx", "ry", "rz")], complex)
    assert motion_name(model_of().plant.machine, shape) == name


def test_shares_of_energy_are_those_of_mass_and_inertia_at_the_centre_of_gravity() -> None:
    shape = np.array([0.2, 0.0, 0.1, 0.0, 0.4j, 0.0])
    # v at the CG: x + 0.75 ry, z.
    energy = {"x": 4000 * (0.2**2 + 0.3**2), "z": 4000 * 0.1**2, "ry": 3000 * 0.4**2}
    found = energy_shares(model_of().plant.machine, shape)
    for dof, share in found.items():
        assert share == pytest.approx(energy.get(dof, 0.0) / sum(energy.values()), abs=1e-12), dof


def test_a_mode_gives_the_motion_of_any_point() -> None:
    mode = named(modes(model_of(), points={"spindle": (0.2, -0.1, 1.4)}), "rocking about y")
    x, _, z, _, ry, _ = mode.shape
    np.testing.assert_allclose(mode.points["spindle"], [x + 1.4 * ry, 0, z - 0.2 * ry], rtol=0, atol=1e-9)
    np.testing.assert_allclose(mode.points["cg"][0], x + 0.75 * ry, rtol=0, atol=1e-12)
    np.testing.assert_allclose(mode.points["rear-left"][2], z + 0.9 * ry, rtol=0, atol=1e-12)


# --- what a shape means -------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("motion", "point", "direction", "pitch"),
    [
        # x + z ry = 0 at z = 2.
        ([1.0, 0, 0, 0, -0.5, 0], [0, 0, 2.0], [0, 1, 0], 0.0),
        # y − z rx = 0 at z = −0.25; 3 m along the axis per rad.
        ([12.0, -1.0, 0, 4.0, 0, 0], [0, 0, -0.25], [1, 0, 0], 3.0),
        # x − y rz = 0, y + x rz = 0.
        ([0.2, 0.1, 0, 0, 0, 2.0], [-0.05, 0.1, 0], [0, 0, 1], 0.0),
    ],
)
def test_a_motion_turns_about_an_axis(
    motion: list[float], point: list[float], direction: list[float], pitch: float
) -> None:
    axis = centre_of_rotation(np.array(motion))
    assert axis is not None
    np.testing.assert_allclose(axis.point, point, atol=1e-14)
    np.testing.assert_allclose(axis.direction, direction, atol=1e-14)
    assert axis.pitch == pytest.approx(pitch, abs=1e-14)


@pytest.mark.parametrize("motion", [[1.0, 0, 0, 0, 0, 0], [0, 0, 1.0, 1e-9, 0, 0]])
def test_a_translation_turns_about_nothing(motion: list[float]) -> None:
    assert centre_of_rotation(np.array(motion)) is None


def test_a_shape_in_step_is_real_whatever_its_phase() -> None:
    shape = np.array([0.3, 0, 0, 0, -1.0, 0.1])
    part, angle = in_phase(Machine(), 2.0 * shape * np.exp(0.7j))
    np.testing.assert_allclose(np.abs(part), 2.0 * np.abs(shape), atol=1e-14)
    assert angle == pytest.approx(0.0, abs=1e-6)


def test_a_circulating_shape_is_half_out_of_step() -> None:
    # The CG at the mount plane's centre: x and y a quarter period apart, of equal energy.
    _, angle = in_phase(Machine(cg=(0.0, 0.0, 0.0)), np.array([1.0, 1.0j, 0, 0, 0, 0]))
    assert angle == pytest.approx(45.0, abs=1e-6)


@pytest.mark.parametrize(
    "table",
    [
        {},
        {"machine": {"cg": [0.15, -0.1, 0.9]}},
        {"actuators": {"isolator": {"foot_stiffness": 1e10, "foot_damping": 1e4}}},
    ],
    ids=["default", "uneven", "flexible feet"],
)
def test_damping_ratios_are_the_sum_of_what_is_lost(table: dict[str, Any]) -> None:
    # dE/dt = −(lost power), E ~ exp(2 Re λ t): an identity of the exact linear machine.
    for mode in modes(linear_model(parse_scenario(table).plant)):
        if mode.energies is None:
            continue
        # 1e-7: the differences that the linear model is made of.
        assert sum(mode.energies.damping.values()) == pytest.approx(mode.damping_ratio, rel=1e-7), mode.name
        assert sum(mode.energies.damping_by.values()) == pytest.approx(mode.damping_ratio, rel=1e-7), mode.name
        for shares in (mode.energies.kinetic, mode.energies.strain, mode.energies.strain_by):
            assert sum(shares.values()) == pytest.approx(1.0, abs=1e-12)


def test_a_stiff_mount_holds_the_strain() -> None:
    table = {
        "mount": [m.model_dump() | {"actuator": m.name} for m in DEFAULT_MOUNTS],
        "actuators": {m: {"lateral_stiffness": 8e8 if m == "front-left" else 1e6} for m in MOUNTS},
    }
    yaw = next(mode for mode in modes(linear_model(parse_scenario(table).plant)) if "yaw" in mode.name)
    assert yaw.energies is not None
    assert yaw.energies.strain["front-left"] > 0.9


# --- repeated and following modes ---------------------------------------------------------------------------------

SQUARE: dict[str, Any] = {
    "machine": {"inertia": [3000.0, 3000.0, 4000.0]},
    "mount": [m.model_dump() | {"position": [0.8 * np.sign(p) for p in m.position]} for m in DEFAULT_MOUNTS],
}


def test_modes_of_a_square_machine_each_stay_in_their_plane() -> None:
    found = modes(linear_model(parse_scenario(SQUARE).plant))
    for what in ("sway-rocking", "rocking"):
        about_x, about_y = (named(found, f"{what} about {axis}") for axis in "xy")
        assert about_x.frequency == pytest.approx(about_y.frequency, rel=1e-8)
        for mode, others in ((about_x, ("x", "ry")), (about_y, ("y", "rx"))):
            assert max(abs(mode.shape[DOFS.index(dof)]) for dof in others) <= 1e-6


def test_left_and_right_vectors_of_repeated_modes_pair() -> None:
    found = modes(linear_model(parse_scenario(SQUARE).plant))
    left, right = (np.array([getattr(mode, side) for mode in found]) for side in ("left", "vector"))
    # Columns of very different units: 1e-6 of rounding.
    np.testing.assert_allclose(left.conj() @ right.T, np.eye(len(found)), atol=1e-6)


def test_valves_in_a_symmetric_loop_swing_in_patterns() -> None:
    names = {mode.name for mode in modes(model_of(), looped(-5e6))}
    assert {"valves in heave", "valves about x", "valves about y", "valves in warp"} <= names


def test_mac_knows_a_shape_in_any_scale_and_phase() -> None:
    random = np.random.default_rng(0)
    shapes = random.normal(size=(6, 3)) + 1j * random.normal(size=(6, 3))
    likeness = mac(shapes, shapes * np.array([2.0, -1j, np.exp(0.3j)]), random.uniform(0.1, 10, 6))
    np.testing.assert_allclose(np.diag(likeness), 1.0, rtol=1e-12)
    assert (likeness - np.eye(3)).max() < 1.0
    np.testing.assert_allclose(mac(np.eye(3), np.eye(3)), np.eye(3))


def test_bypassed_chambers_leave_the_membranes() -> None:
    found = modes(model_of(), bypassed=True)
    assert len(found) == 6
    # 4 K_L over machine and plates; the differentiated model's rounding.
    heave = named(found, "heave")
    assert heave.frequency == pytest.approx(np.sqrt(4 * 6.8e8 / 4056.0) / (2 * np.pi), rel=1e-8)
    assert heave.damping_ratio == pytest.approx(4 * 3900.0 / (2 * np.sqrt(4 * 6.8e8 * 4056.0)), rel=1e-6)


# --- closed forms -------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("mass", [1000.0, 4056.0])
def test_heave_is_the_papers_single_actuator_under_a_quarter_of_the_machine(mass: float) -> None:
    # Denominator of eqs. 3, 6 and 7: s + (K_C/A_p² + s/K_h)(M s² + C s + K_L).
    k_h = 4 * TABLE_I.beta * TABLE_I.A_p**2 / TABLE_I.V_t
    motion = np.array([mass, TABLE_I.C, TABLE_I.K_L])
    cubic = np.polyadd([1.0, 0.0], np.polymul([1 / k_h, TABLE_I.K_C / TABLE_I.A_p**2], motion))
    pole = next(root for root in np.roots(cubic) if root.imag > 0)
    heave = named(modes(model_of({"mass": 4 * mass - 56.0})), "heave")
    # 1e-5: chambers at −15 µm of 8.5 mm or −60 µm.
    assert heave.frequency == pytest.approx(abs(pole) / (2 * np.pi), rel=1e-4)
    assert heave.damping_ratio == pytest.approx(-pole.real / abs(pole), rel=1e-4)


def test_yaw_is_a_spring_and_a_damper_at_the_mounts_distance() -> None:
    r2 = 4 * (0.9**2 + 0.6**2)
    yaw = named(modes(model_of()), "yaw")
    assert yaw.frequency == pytest.approx(np.sqrt(2e8 * r2 / 4000) / (2 * np.pi), rel=1e-6)
    assert yaw.damping_ratio == pytest.approx(2e4 * r2 / 2 / np.sqrt(2e8 * r2 * 4000), rel=1e-6)


@pytest.mark.parametrize(("height", "stiffness"), [(0.75, 6.8e8), (1.4, 5e7)])
def test_without_oil_and_damping_sway_and_rocking_solve_a_quadratic(height: float, stiffness: float) -> None:
    free = {
        "piston_area": 1e-7,
        "membrane_damping": 0.0,
        "lateral_damping": 0.0,
        "membrane_stiffness": stiffness,
        "moving_volume": False,
    }
    found = modes(model_of({"cg": [0.0, 0.0, height]}, **free))
    m, inertia, a = 4000.0, 3000.0, 0.9
    rocking = inertia + m * height**2 + 4 * 14.0 * a**2
    stands = 4 * stiffness * a**2 - m * 9.80665 * height
    # det([[4k − m ω², −m h ω²], [−m h ω², K_θ − J ω²]]) = 0
    squares = np.roots([m * rocking - (m * height) ** 2, -(m * stands + 4 * 2e8 * rocking), 4 * 2e8 * stands])
    expected = np.sqrt(np.sort(squares)) / (2 * np.pi)
    about_y = sorted(mode.frequency for mode in found if "about y" in mode.name)
    np.testing.assert_allclose(about_y, expected, rtol=1e-6)
    assert all(abs(mode.damping_ratio) < 1e-6 for mode in found if not mode.name.startswith("valve"))


def test_a_machine_held_very_stiffly_sideways_heaves_and_rocks_only() -> None:
    stiff = modes(model_of(lateral_stiffness=1e14, lateral_damping=0.0))
    slow = {mode.name[-7:]: mode for mode in stiff if mode.frequency < 2000.0 and mode.machine_moves}
    assert set(slow) == {"heave", "about x", "about y"}
    # About the mount plane then: J + m h² + Σ m_p r², a lever of the single actuator's cubic.
    for about, inertia, arm in (("x", 2000.0, 0.6), ("y", 3000.0, 0.9)):
        equivalent = (inertia + 4000 * 0.75**2 + 56 * arm**2) / (4 * arm**2)
        k_h = 4 * TABLE_I.beta * TABLE_I.A_p**2 / TABLE_I.V_t
        topple = 4000 * 9.80665 * 0.75 / (4 * arm**2)
        motion = np.array([equivalent, TABLE_I.C, TABLE_I.K_L - topple])
        cubic = np.polyadd([1.0, 0.0], np.polymul([1 / k_h, TABLE_I.K_C / TABLE_I.A_p**2], motion))
        pole = next(root for root in np.roots(cubic) if root.imag > 0)
        # 1e-4: 1e14 N/m is not infinite.
        assert slow[f"about {about}"].frequency == pytest.approx(abs(pole) / (2 * np.pi), rel=1e-4)


# --- under a digital controller -----------------------------------------------------------------------------------


def stroke_feedback(gain: float, states: bool = False, **settings: Any) -> Controller:
    """At each mount: proportional, or through a discrete low-pass of its own."""
    if not states:
        return Controller(np.zeros((0, 0)), np.zeros((0, 4)), np.zeros((4, 0)), gain * np.eye(4), STROKES, **settings)
    pole = np.diag([0.9, 0.8, 0.7, 0.6])
    return Controller(pole, np.eye(4) - pole, 0.7 * gain * np.eye(4), 0.3 * gain * np.eye(4), STROKES, **settings)


def looped(gain: float) -> Loop:
    return Loop(stroke_feedback(gain), IDEAL, 0)


def loop_eigenvalues(model: LinearModel, law: Controller, parts: int) -> np.ndarray:
    """Eigenvalues λ of the sampled loop, by carrying every unit state through one period in ``parts`` equal parts.

    Between samples the machine is a matrix exponential under the command that the converter holds; commands wait in a
    queue, newest first, and each becomes the converter's when its time has come.
    """
    n, c, period = model.A.shape[0], law.states, law.period
    part = period / parts
    ticks = round(law.latency / part)
    queue = -(-ticks // parts)  # samples whose commands may be on their way
    valves = model.B[:, :4]
    step = expm(np.block([[model.A, valves], [np.zeros((4, n + 4))]]) * part)
    C, D = model.rows(law.inputs)
    assert not D[:, :4].any()

    def one_period(state: np.ndarray) -> np.ndarray:
        machine, law_state, held = state[:n], state[n : n + c], state[n + c : n + c + 4]
        waiting = list(state[n + c + 4 :].reshape(queue, 4))
        u = C @ machine
        waiting.insert(0, law.C @ law_state + law.D @ u)
        law_state = law.A @ law_state + law.B @ u
        for k in range(parts):
            for age, command in enumerate(waiting):  # sampled age periods ago
                if age * parts + k == ticks:
                    held = command
            machine, held = np.split(step @ np.r_[machine, held], [n])
        return np.r_[machine, law_state, held, np.array(waiting[:queue]).ravel()]

    size = n + c + 4 + 4 * queue
    loop = np.array([one_period(unit) for unit in np.eye(size)]).T
    values = np.linalg.eigvals(loop)
    return np.log(values[np.abs(values) > 0.05]) / period


@pytest.mark.parametrize("states", [False, True], ids=["proportional", "filtered"])
@pytest.mark.parametrize(
    ("period", "delay", "parts"),
    [(1e-4, 0.0, 1), (1e-4, None, 1), (1e-4, 1.5e-4, 2), (1e-4, 2.5e-4, 2), (1e-4, 3.7e-5, 100), (5e-4, 7e-4, 5)],
)
def test_modes_of_a_closed_loop_are_those_of_another_discretisation(
    period: float, delay: float | None, parts: int, states: bool
) -> None:
    model = model_of()
    law = stroke_feedback(-5e6, states, period=period, delay=delay)
    found = [
        2 * np.pi * mode.frequency * complex(-mode.damping_ratio, np.sqrt(1 - mode.damping_ratio**2))
        for mode in modes(model, Loop(law, IDEAL, 0))
    ]
    expected = loop_eigenvalues(model, law, parts)
    expected = expected[(expected.imag > 1.0) & (np.exp(expected.real * period) > 0.05)]
    distance = np.abs(np.array(found)[:, None] - expected[None, :]) / np.abs(expected)
    # Both from the same continuous matrices: rounding of exponentials and eigenvalues.
    assert distance[linear_sum_assignment(distance)].max() <= 1e-9
    assert distance.shape[1] >= 6


def test_the_loop_moves_the_modes() -> None:
    # So that the comparison above is of more than the passive machine: three of four valves, warp having no stroke.
    closed = modes(model_of(), looped(-5e6))
    assert sum(mode.frequency < 0.8 * 250.0 for mode in closed if mode.name.startswith("valve")) == 3


def test_a_controller_that_commands_nothing_leaves_the_modes_as_they_are() -> None:
    model = model_of()
    passive, sampled = modes(model), modes(model, looped(0.0))
    for name, _, _ in DEFAULT:
        one, other = named(passive, name), named(sampled, name)
        assert other.frequency == pytest.approx(one.frequency, rel=1e-9)
        assert other.damping_ratio == pytest.approx(one.damping_ratio, rel=1e-7)


def test_an_unstable_loop_has_negative_damping() -> None:
    assert min(mode.damping_ratio for mode in modes(model_of(), looped(-2e7))) < -0.1


def test_a_stable_loop_has_none() -> None:
    assert min(mode.damping_ratio for mode in modes(model_of(), looped(-5e4))) > 0.0


def test_oscillations_of_the_controller_are_named_so() -> None:
    turn = 0.99 * np.array([[np.cos(0.3), -np.sin(0.3)], [np.sin(0.3), np.cos(0.3)]])
    law = Controller(turn, np.zeros((2, 1)), np.zeros((4, 2)), np.zeros((4, 1)), STROKES[:1])
    mode = named(modes(model_of(), Loop(law, IDEAL, 0)), "controller")
    pole = np.log(0.99 * np.exp(0.3j)) * 1e4
    assert mode.frequency == pytest.approx(abs(pole) / (2 * np.pi), rel=1e-9)
    assert mode.damping_ratio == pytest.approx(-pole.real / abs(pole), rel=1e-9)


@pytest.mark.parametrize(
    ("state", "group"),
    [("velocity plate rear-left", "motion"), ("spool front-left", "valve"), ("torque_current front-left", "valve"),
     ("pressure_1 front-left", "pressure"), ("line_flow", "pressure"), ("controller 3", "controller")],
)  # fmt: skip
def test_a_state_belongs_to_what_it_is_of(state: str, group: str) -> None:
    """A state of a valve's option too, whatever its name."""
    assert group_of(state) == group
