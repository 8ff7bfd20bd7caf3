"""The linear machine against the oracle built by hand, its differences at loaded operating points, names, refusals."""

from dataclasses import replace
from typing import Any

import control
import numpy as np
import pytest
from oracles import linear, machine

import ehamj
from ehamj.control.channels import channel_names
from ehamj.errors import InputError
from ehamj.linear.machine import LinearModel, linear_model
from ehamj.linear.response import ground_response
from ehamj.plant.mounts import MOUNTS
from ehamj.scenario.load import parse_scenario
from ehamj.scenario.model import Scenario
from ehamj.views.linear import linearise

DOFS = ("x", "y", "z", "rx", "ry", "rz")
AXES = ("x", "y", "z")
STATES = (
    *(f"{what} {dof}" for what in ("displacement", "velocity") for dof in DOFS),
    *(f"{what} {mount}" for what in ("spool", "spool_rate", "pressure_1", "pressure_2") for mount in MOUNTS),
)
INPUTS = (
    *(f"valve_command {mount}" for mount in MOUNTS),
    *(f"ground_{what} {mount} {axis}" for what in ("displacement", "velocity") for mount in MOUNTS for axis in AXES),
)
"""States and inputs in the oracle's order."""
KINDS = {"displacement": slice(0, 6), "velocity": slice(6, 12), "spool": slice(12, 16), "rate": slice(16, 20)}
STATE_KINDS = {**KINDS, "pressure": slice(20, 28)}
INPUT_KINDS = {"command": slice(0, 4), "ground displacement": slice(4, 16), "ground velocity": slice(16, 28)}

ASYMMETRIC = {
    "machine": {"mass": 5200.0, "inertia": [2500.0, 3600.0, 4100.0], "cg": [0.12, -0.07, 0.9]},
    "mount": [
        {"name": "front-left", "position": [0.9, 0.6]},
        {"name": "front-right", "position": [0.8, -0.7]},
        {"name": "rear-left", "position": [-1.0, 0.5], "actuator": "other"},
        {"name": "rear-right", "position": [-0.9, -0.6]},
    ],
    "actuators": {
        "isolator": {},
        "other": {
            "preset": "recommended",
            "valve_frequency": 2000.0,
            "lateral_stiffness": 1.5e8,
            "lateral_damping": 1e4,
            "membrane_stiffness": 5e8,
            "membrane_damping": 6000.0,
            "plate_mass": 20.0,
        },
    },
}
"""CG off centre, mounts on no rectangle, one actuator different in everything linear."""


def linear_oracle(asymmetric: bool) -> linear.LinearMachine:
    if not asymmetric:
        return linear.LinearMachine()

    def at_rear_left(usual: float, other: float) -> tuple[float, float, float, float]:
        return usual, usual, other, usual

    return linear.LinearMachine(
        mass=5200.0,
        inertia=(2500.0, 3600.0, 4100.0),
        cg=(0.12, -0.07, 0.9),
        mounts=((0.9, 0.6), (0.8, -0.7), (-1.0, 0.5), (-0.9, -0.6)),
        m_plate=at_rear_left(14.0, 20.0),
        k_lat=at_rear_left(2e8, 1.5e8),
        c_lat=at_rear_left(2e4, 1e4),
        K_L=at_rear_left(6.8e8, 5e8),
        C=at_rear_left(3900.0, 6000.0),
        A_p=at_rear_left(3.18e-2, 6.36e-2),
        V_t=at_rear_left(5.39e-4, 2.695e-4),
        g0=at_rear_left(3.3e-12, 6.6e-12),
        cross=at_rear_left(6.27e-11, 1.254e-10),
        omega_v=at_rear_left(1571.0, 2000.0),
    )


def nonlinear_oracle(asymmetric: bool) -> machine.OracleMachine:
    if not asymmetric:
        return machine.default_machine()
    usual, of = machine.OracleActuator(), linear_oracle(True)
    other = replace(
        usual, A_p=6.36e-2, V_t=2.695e-4, g0=6.6e-12, cross=1.254e-10, omega_v=2000.0, K_L=5e8, C=6000.0, k_lat=1.5e8,
        c_lat=1e4, m_plate=20.0,
    )  # fmt: skip
    return machine.OracleMachine(of.mass, of.inertia, of.cg, of.mounts, actuators=(usual, usual, other, usual))


def scenario(asymmetric: bool = False, **table: Any) -> Scenario:
    return parse_scenario({**(ASYMMETRIC if asymmetric else {}), **table})


def in_oracles_order(model: LinearModel) -> tuple[np.ndarray, np.ndarray]:
    """A and B with rows and columns picked by name."""
    rows, columns = [model.states.index(name) for name in STATES], [model.inputs.index(name) for name in INPUTS]
    return model.A[np.ix_(rows, rows)], model.B[np.ix_(rows, columns)]


def assert_blocks(found: np.ndarray, expected: np.ndarray, columns: dict[str, slice], tolerance: float) -> None:
    """Entries agree within ``tolerance`` of the largest entry of their block of like units."""
    for row, rows in STATE_KINDS.items():
        for column, at in columns.items():
            block, wanted = found[rows, at], expected[rows, at]
            # A block of zeros beside others: 1e-15 of these are rounding.
            largest = max(np.abs(wanted).max(), 1e-9 * np.abs(expected[rows]).max())
            assert np.abs(block - wanted).max() <= tolerance * largest, (row, column)


# --- matrices -----------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("plates", ["sliding", "tied"])
@pytest.mark.parametrize(("asymmetric", "tolerance"), [(False, 1e-6), (True, 1e-5)], ids=["default", "asymmetric"])
def test_the_matrices_are_the_oracles(asymmetric: bool, tolerance: float, plates: str) -> None:
    model = linear_model(scenario(asymmetric, plates=plates).plant)
    strokes = linear.foot_maps(linear_oracle(asymmetric))[2] @ machine.equilibrium(nonlinear_oracle(asymmetric)).q
    a, b, _, _ = linear.state_space(replace(linear_oracle(asymmetric), stroke=tuple(strokes)))
    A, B = in_oracles_order(model)
    # 1e-6: differences over 0.1 µm and 10 µA. 1e-5: the asymmetric machine leans by 3e-6 rad.
    assert_blocks(A, a, STATE_KINDS, tolerance)
    assert_blocks(B, b, INPUT_KINDS, tolerance)


@pytest.mark.parametrize("asymmetric", [False, True], ids=["default", "asymmetric"])
def test_a_force_at_the_centre_of_gravity_accelerates_the_machine_by_the_oracles_mass(asymmetric: bool) -> None:
    model, oracle = linear_model(scenario(asymmetric).plant), linear_oracle(asymmetric)
    x, y, z = oracle.cg
    at_cg = np.eye(6)
    at_cg[:3, 3:] = [[0, z, -y], [-z, 0, x], [y, -x, 0]]
    rows = [model.states.index(f"velocity {dof}") for dof in DOFS]
    columns = [model.inputs.index(f"cg_force {dof}") for dof in DOFS]
    found = model.B[np.ix_(rows, columns)]
    expected = np.linalg.inv(linear.mass_matrix(oracle)) @ at_cg.T
    np.testing.assert_allclose(found, expected, rtol=0, atol=1e-5 * np.abs(expected).max())


OPERATING_POINTS = {
    "commands": ((5.0, -3.0, 1.0, 0.0), (0.0,) * 6),
    "at the range": ((9.0, 9.0, 9.0, 9.0), (0.0,) * 6),
    "loaded": ((0.0,) * 4, (2e3, -1e3, -4e5, 2e4, -1e4, 3e3)),
    "both": ((-2.0, 4.0, -6.0, 8.0), (0.0, 3e3, 3e5, -1e4, 5e3, 0.0)),
}


def oracle_differences(of: machine.OracleMachine, at: np.ndarray, volts: Any) -> tuple[np.ndarray, np.ndarray]:
    """A and B of the nonlinear oracle by central differences at a state, in the oracle's order."""
    volts, rest = np.asarray(volts, float), np.zeros((4, 3))

    def rate(state: np.ndarray, voltage: np.ndarray, moved: np.ndarray, moving: np.ndarray) -> np.ndarray:
        return machine.rates(of, machine.OracleState.unpack(state), voltage, moved, moving).pack()

    def slope(step: float, ahead: Any, behind: Any) -> np.ndarray:
        return (rate(*ahead) - rate(*behind)) / (2 * step)

    steps = np.repeat([1e-8, 1e-5, 1e-3, 1.0, 1e3], [6, 6, 4, 4, 8])
    a = [
        slope(h, *((at + s * h * unit, volts, rest, rest) for s in (1, -1)))
        for h, unit in zip(steps, np.eye(28), strict=True)
    ]
    b = [slope(1e-3, *((at, volts + s * 1e-3 * unit, rest, rest) for s in (1, -1))) for unit in np.eye(4)]
    for order, h in ((0, 1e-8), (1, 1e-5)):
        for unit in np.eye(12).reshape(12, 4, 3):
            pair = [[rest, rest], [rest, rest]]
            pair[0][order], pair[1][order] = h * unit, -h * unit
            b.append(slope(h, *((at, volts, *moved) for moved in pair)))
    return np.array(a).T, np.array(b).T


@pytest.mark.parametrize("asymmetric", [False, True], ids=["default", "asymmetric"])
@pytest.mark.parametrize("point", OPERATING_POINTS)
def test_at_a_loaded_operating_point_the_matrices_are_the_oracles_differences(point: str, asymmetric: bool) -> None:
    commands, load = OPERATING_POINTS[point]
    model, oracle = linear_model(scenario(asymmetric).plant, commands=commands, load=load), linear_oracle(asymmetric)
    at = model.equilibrium[[model.states.index(name) for name in STATES]]
    a, b = oracle_differences(nonlinear_oracle(asymmetric), at, commands)
    # The oracle knows no load: held at the centre of gravity, it turns the machine as its weight does.
    a[6:12, 3:5] -= np.linalg.inv(linear.mass_matrix(oracle))[:, 3:5] * load[2] * oracle.cg[2]
    A, B = in_oracles_order(model)
    # 1e-4: the oracle's kinematics are linear, the engine's are turned by 4e-5 rad.
    assert_blocks(A, a, STATE_KINDS, 1e-4)
    assert_blocks(B, b, INPUT_KINDS, 1e-4)


@pytest.mark.parametrize("asymmetric", [False, True], ids=["default", "asymmetric"])
@pytest.mark.parametrize("point", OPERATING_POINTS)
def test_at_its_operating_point_the_oracle_stands_still_too(point: str, asymmetric: bool) -> None:
    commands, load = OPERATING_POINTS[point]
    model, oracle = linear_model(scenario(asymmetric).plant, commands=commands, load=load), linear_oracle(asymmetric)
    at = model.equilibrium[[model.states.index(name) for name in STATES]]
    rate = machine.rates(nonlinear_oracle(asymmetric), machine.OracleState.unpack(at), commands)
    force = np.r_[load[:3], np.asarray(load[3:]) + np.cross(oracle.cg, load[:3])]
    push = np.linalg.inv(linear.mass_matrix(oracle)) @ force
    # As above, angles of 4e-5 rad; and the solver's 1e-7 m/s² and 1e-9 of the full flow.
    assert np.abs(rate.qd + push).max() <= 1e-4 * np.abs(push).max() + 1e-6
    assert np.abs(rate.pressure).max() <= 1e-9 * (2 * 1.4e9 / 2.695e-4) * 20 * 1.94e-6


def test_commands_beyond_the_range_hold_the_spool_at_its_end() -> None:
    model = linear_model(scenario().plant, commands=[30.0, 0.0, 0.0, -30.0])
    spools = model.equilibrium[[model.states.index(f"spool {mount}") for mount in MOUNTS]]
    np.testing.assert_array_equal(spools, [20.0, 0.0, 0.0, -20.0])


# --- channels -----------------------------------------------------------------------------------------------------


def expected_channel(name: str, value: dict[str, float], of: linear.LinearMachine) -> float:
    """A channel from named states, rates and inputs; rotations small, plates tied to the machine."""
    variable, *labels = name.split(" ")
    what, _, order = variable.rpartition("_")

    def moved(motion: str, point: Any) -> np.ndarray:
        x, y, z, *turn = (value[f"{motion} {dof}"] for dof in DOFS)
        return np.array([x, y, z]) + np.cross(turn, point)

    def foot(motion: str, mount: str) -> np.ndarray:
        return moved(motion, (*of.mounts[MOUNTS.index(mount)], 0.0))

    if what == "ground":
        return value[name.replace("along", "z")]
    if what == "foot":
        return float(foot(order, labels[0])[AXES.index(labels[1].replace("along", "z"))])
    if what == "cg":
        return float(moved(order, of.cg)[AXES.index(labels[0])])
    if what == "tip":
        return float(moved(order, (0.3, -0.4, 1.5))[AXES.index(labels[0])])
    if what == "machine":
        return value[f"{order} {labels[0]}"]
    if variable in ("stroke", "stroke_velocity"):
        motion = "velocity" if variable == "stroke_velocity" else "displacement"
        return float(foot(motion, labels[0])[2]) - value[f"ground_{motion} {labels[0]} z"]
    if variable == "edges":
        return value[f"spool {labels[0]}"]  # without hysteresis there is no play between them
    if variable == "supply_pressure":
        return 0.0  # constant
    if variable == "load_pressure":
        return value[f"pressure_1 {labels[0]}"] - value[f"pressure_2 {labels[0]}"]
    return value[f"pressure_{labels[1]} {labels[0]}" if variable == "chamber_pressure" else name]


def test_every_output_is_the_channel_of_its_name() -> None:
    system = linearise(scenario(True), points={"tip": (0.3, -0.4, 1.5)})
    draw = np.random.default_rng(3).uniform
    # In units in which all states weigh alike: µm, mm/s, mA, A/s, bar; V, N.
    state = draw(-1, 1, 28) * [{"d": 1e-6, "v": 1e-3, "s": 1.0, "p": 1e5}[name[0]] for name in system.state_labels]
    given = draw(-1, 1, 34) * [
        {"v": 1.0, "c": 1e3}.get(name[0], 1e-3 if "velocity" in name else 1e-6) for name in system.input_labels
    ]
    rate = system.scales * (system.A @ (state / system.scales) + system.B @ given)
    value = dict(zip([*system.state_labels, *system.input_labels], [*state, *given], strict=True))
    value |= {f"acceleration {dof}": rate[system.state_labels.index(f"velocity {dof}")] for dof in DOFS}
    found = system.C @ (state / system.scales) + system.D @ given
    expected = [expected_channel(name, value, linear_oracle(True)) for name in system.output_labels]
    np.testing.assert_allclose(found, expected, rtol=1e-9)


def test_all_signals_have_names() -> None:
    system = linearise(scenario(), points={"tip": (0.0, 0.0, 2.0)})
    assert isinstance(system, control.StateSpace)
    assert set(system.state_labels) == set(STATES)
    assert system.input_labels == [*INPUTS, *(f"cg_force {dof}" for dof in DOFS)]
    moving = {name for name in channel_names() if not name.startswith("ground_")}
    points = {f"tip_{what} {axis}" for what in ("displacement", "velocity", "acceleration") for axis in AXES}
    assert set(system.output_labels) == moving | points


def test_outputs_come_in_the_order_asked_for() -> None:
    asked = ["chamber_pressure rear-left 2", "ground_velocity front-left z", "cg_velocity z"]
    assert linearise(scenario(), outputs=asked).output_labels == asked


def test_the_static_stiffness_is_that_of_the_membranes() -> None:
    system = linearise(scenario(), outputs=["cg_displacement z", "cg_displacement x"])
    gain = -system.C @ np.linalg.solve(system.A, system.B) + system.D
    up, along = (system.input_labels.index(f"cg_force {axis}") for axis in ("z", "x"))
    # Leaking oil carries nothing. A push in x also rocks the machine about its mounts: h²/(4 K_L a² − m g h).
    assert gain[0, up] == pytest.approx(1 / (4 * 6.8e8), rel=1e-6)
    rocking = 4 * 6.8e8 * 0.9**2 - 4000 * 9.80665 * 0.75
    assert gain[1, along] == pytest.approx(1 / (4 * 2e8) + 0.75**2 / rocking, rel=1e-6)


def test_the_package_offers_it_by_name() -> None:
    assert ehamj.linearise is linearise


# --- feet ---------------------------------------------------------------------------------------------------------


def test_plates_kept_as_states_do_not_change_the_machines_response() -> None:
    hertz, outputs = [1.0, 50.0, 300.0], ("cg_displacement z", "machine_displacement ry", "stroke front-left")
    given = ("valve_command front-left", "cg_force x")
    tied, sliding = (linear_model(scenario().plant, feet=feet) for feet in (False, True))
    assert (len(tied.states), len(sliding.states)) == (28, 36)
    one, other = (model.response(hertz, outputs, given) for model in (tied, sliding))
    # The tie is a spring of 1e16 N/m, stiff but of poles of 1e4 1/s: 1e-4 at 300 Hz.
    np.testing.assert_allclose(other, one, rtol=0, atol=1e-4 * np.abs(one).max(axis=0).max())


def test_soft_feet_are_in_series_with_the_membranes() -> None:
    system = linearise(scenario(actuators={"isolator": {"foot_stiffness": 2e9}}), outputs=["cg_displacement z"])
    gain = -system.C @ np.linalg.solve(system.A, system.B) + system.D
    found = gain[0, system.input_labels.index("cg_force z")]
    assert found == pytest.approx((1 / 6.8e8 + 1 / 2e9) / 4, rel=1e-6)


# --- responses ----------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("dof", DOFS)
@pytest.mark.parametrize("asymmetric", [False, True], ids=["default", "asymmetric"])
def test_the_response_to_a_slab_is_the_oracles_transmissibility(dof: str, asymmetric: bool) -> None:
    oracle, hertz = linear_oracle(asymmetric), [0.5, 10.0, 70.0, 300.0]
    slab = np.stack([part[:, DOFS.index(dof)] for part in linear.foot_maps(oracle)], axis=1)
    outputs = [f"machine_displacement {name}" for name in DOFS]
    found = ground_response(linear_model(scenario(asymmetric).plant), np.array(hertz), outputs) @ slab.ravel()
    expected = np.array([linear.transmissibility(oracle, dof, f) for f in hertz])
    # 1e-4: the oracle's chambers stand at stroke 0, here at −14.6 µm of 8.5 mm or less, squared; resonance magnifies.
    np.testing.assert_allclose(found, expected, rtol=0, atol=1e-4 * np.abs(expected).max())


# --- refusals -----------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("table", "settings", "message"),
    [
        ({"actuators": {"isolator": {"membrane_stiffness": 0.0}}}, {}, r"mount: .*nothing holds sliding along z"),
        ({"actuators": {"isolator": {"membrane_stiffness": 1e6}}}, {}, r"operating point: .*cannot stand"),
        ({}, {"load": (0, 0, -3e7, 0, 0, 0)}, r"operating point: .*load = \[0\.0, 0\.0, -30000000\.0, .*must carry"),
        ({}, {"commands": (1.0, 2.0)}, r"commands = \[1\.0, 2\.0\]"),
        ({}, {"commands": (np.nan,) * 4}, r"commands = \[nan"),
        ({}, {"load": (1.0, 2.0, 3.0)}, r"load = \[1\.0, 2\.0, 3\.0\]"),
        ({}, {"load": (np.inf, 0, 0, 0, 0, 0)}, r"load = \[inf"),
    ],
)  # fmt: skip
def test_an_operating_point_that_does_not_exist_is_refused(
    table: dict[str, Any], settings: dict[str, Any], message: str
) -> None:
    with pytest.raises(InputError, match=f"^{message}"):
        linearise(scenario(**table), **settings)


@pytest.mark.parametrize(
    ("name", "message"),
    [
        ("strok front-left", r"output: channel 'strok front-left' is unknown; near it are: 'stroke front-left'"),
        ("tip_displacement q", r"output: channel 'tip_displacement q' is unknown"),
        ("top_displacement z", r"output: channel 'top_displacement z' is unknown"),
        (
            "ground_acceleration front-left z",
            r"output 'ground_acceleration front-left z': the ground's displacement and",
        ),
    ],
)
def test_an_unknown_output_is_refused_with_one_that_is_near(name: str, message: str) -> None:
    with pytest.raises(InputError, match=f"^{message}"):
        linearise(scenario(), outputs=[name], points={"tip": (0.0, 0.0, 1.0)})
