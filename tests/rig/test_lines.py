"""Responses measured from the nonlinear simulation lie on the linear ones, and on the paper's exact transfer function.

Measured with a few millivolts or µm/s per line, where the machine is linear: 1 % and 1° from 1 to 300 Hz.
"""

from functools import cache
from typing import Any

import numpy as np
import pytest
from oracles import linear

from ehamj.errors import InputError
from ehamj.linear.machine import linear_model
from ehamj.plant.mounts import MOUNTS
from ehamj.rig.lines import Measured, channel, lines, measure_floor, measure_valves
from ehamj.run.simulate import simulate
from ehamj.scenario.load import parse_scenario
from ehamj.scenario.model import Scenario

DOFS = ("x", "y", "z", "rx", "ry", "rz")
MOTION = tuple(f"machine_displacement {dof}" for dof in DOFS[:5])
OIL = ("stroke front-left", "load_pressure front-left", "chamber_pressure rear-left 2")

CORNERS = ((0.9, 0.6), (0.8, -0.7), (-1.0, 0.5), (-0.9, -0.6))
ASYMMETRIC: dict[str, Any] = {
    "machine": {"mass": 5200.0, "inertia": [2500.0, 3600.0, 4100.0], "cg": [0.12, -0.07, 0.9]},
    "mount": [
        {"name": name, "position": list(at), **({"actuator": "other"} if name == "rear-left" else {})}
        for name, at in zip(MOUNTS, CORNERS, strict=True)
    ],
    "actuators": {"isolator": {}, "other": {"preset": "recommended", "valve_frequency": 2000.0, "plate_mass": 20.0}},
}
"""CG off centre, mounts on no rectangle, one actuator different."""
MACHINES: dict[str, dict[str, Any]] = {"default": {}, "asymmetric": ASYMMETRIC}


def scenario(kind: str, **table: Any) -> Scenario:
    return parse_scenario({"plates": "tied", **MACHINES[kind], **table})


@cache
def driven(machine: str, pattern: tuple[str, ...]) -> Measured:
    return measure_valves(scenario(machine), (*OIL, *MOTION), pattern)


@cache
def shaken(machine: str, dof: str) -> Measured:
    return measure_floor(scenario(machine), (*OIL, *MOTION), dof)


def assert_on_the_line(measured: Measured, expected: np.ndarray, outputs: tuple[str, ...]) -> None:
    """Amplitude within 1 % and phase within 1° at every line, all of which must be coherent."""
    assert measured.frequency[0] == 1.0
    assert measured.frequency[-1] == 300.0
    for name in outputs:
        k = measured.outputs.index(name)
        ratio = measured.response[:, k] / expected[:, k]
        assert measured.coherence[:, k].min() > 0.99, name
        assert np.abs(np.abs(ratio) - 1).max() <= 0.01, name
        assert np.abs(np.degrees(np.angle(ratio))).max() <= 1.0, name


# --- valves -------------------------------------------------------------------------------------------------------


def test_all_valves_together_move_the_default_machine_as_linear_theory_says() -> None:
    measured = driven("default", MOUNTS)
    commands = [f"valve_command {mount}" for mount in MOUNTS]
    expected = linear_model(scenario("default")).response(measured.frequency, measured.outputs, commands).sum(axis=2)
    assert_on_the_line(measured, expected, (*OIL, "machine_displacement z"))


@pytest.mark.parametrize("machine", MACHINES)
def test_one_valve_moves_and_rocks_the_machine_as_linear_theory_says(machine: str) -> None:
    measured = driven(machine, ("rear-left",))
    model = linear_model(scenario(machine))
    expected = model.response(measured.frequency, measured.outputs, ["valve_command rear-left"])[:, :, 0]
    assert_on_the_line(measured, expected, (*OIL, *MOTION))


def test_one_actuator_under_4056_kg_is_the_papers_exact_transfer_function() -> None:
    table = {"machine": {"mass": 4 * 4056.0 - 4 * 14.0}}
    measured = measure_valves(scenario("default", **table), ("stroke rear-right", "load_pressure rear-right"))
    paper, s = linear.PaperActuator(), 2j * np.pi * measured.frequency
    stroke = linear.valve(paper, s) * linear.actuator_exact(paper, s)
    pressure = stroke * (paper.M * s**2 + paper.C * s + paper.K_L) / paper.A_p  # eq. 7
    assert_on_the_line(measured, np.column_stack([stroke, pressure]), measured.outputs)


# --- floor --------------------------------------------------------------------------------------------------------

FOLLOWS = {"z": ("z",), "x": ("x", "ry"), "y": ("y", "rx"), "rx": ("rx", "y"), "ry": ("ry", "x")}
"""What moves with a floor under the symmetric machine; the rest is of second order."""


@pytest.mark.parametrize("dof", FOLLOWS)
def test_the_default_machine_follows_a_floor_as_the_oracle_says(dof: str) -> None:
    measured = shaken("default", dof)
    response = np.array([linear.transmissibility(linear.LinearMachine(), dof, f) for f in measured.frequency])
    expected = np.zeros((measured.frequency.size, len(measured.outputs)), complex)
    expected[:, len(OIL) :] = response[:, :5]
    assert_on_the_line(measured, expected, tuple(f"machine_displacement {name}" for name in FOLLOWS[dof]))


@pytest.mark.parametrize("dof", ["z", "ry"])
@pytest.mark.parametrize("machine", MACHINES)
def test_strokes_and_pressures_follow_a_floor_as_linear_theory_says(machine: str, dof: str) -> None:
    measured = shaken(machine, dof)
    assert_on_the_line(measured, from_the_floor(machine, dof, measured), OIL)


@pytest.mark.parametrize("dof", ["z", "ry"])
def test_the_asymmetric_machine_follows_a_floor_in_every_direction(dof: str) -> None:
    measured = shaken("asymmetric", dof)
    assert_on_the_line(measured, from_the_floor("asymmetric", dof, measured), MOTION)


def from_the_floor(machine: str, dof: str, measured: Measured) -> np.ndarray:
    model = linear_model(scenario(machine))
    maps = linear.foot_maps(linear.LinearMachine(mounts=tuple(model.plant.positions)))
    slab = np.stack([part[:, DOFS.index(dof)] for part in maps], axis=1)
    return model.from_ground(measured.frequency, measured.outputs, slab.astype(complex))


# --- coherence ----------------------------------------------------------------------------------------------------


def test_a_command_that_saturates_is_not_coherent() -> None:
    # 33 lines of 4 V: 16 V RMS against ±10 V.
    measured = measure_valves(scenario("default"), ("stroke front-left",), amplitude=4.0)
    assert measured.coherence.min() < 0.95


def test_coherence_lies_between_none_and_all_of_it() -> None:
    coherence = driven("asymmetric", ("rear-left",)).coherence
    assert np.all((coherence >= 0.0) & (coherence <= 1.0 + 1e-12))


# --- lines and channels -------------------------------------------------------------------------------------------


def test_lines_are_whole_hertz_about_evenly_spaced_in_logarithm() -> None:
    found = lines(2.0, 200.0, 12)
    np.testing.assert_array_equal(found, [2, 3, 5, 7, 11, 16, 25, 37, 57, 87, 132, 200])


def test_lines_that_fall_together_are_one() -> None:
    assert lines(1.0, 4.0, 50).tolist() == [1.0, 2.0, 3.0, 4.0]


def test_channels_of_a_result_are_found_by_name() -> None:
    step = {"kind": "step", "mounts": ["rear-left"], "amplitude": 1.0}
    data = simulate(scenario("default", duration=0.02, control={"kind": "open-loop", "signals": [step]})).dataset
    for name, expected in (
        ("stroke rear-left", data["stroke"].values[:, 2]),
        ("chamber_pressure rear-left 2", data["chamber_pressure"].values[:, 2, 1]),
        ("foot_acceleration front-right x", data["foot_acceleration"].values[:, 1, 0]),
        ("cg_velocity z", data["cg_velocity"].values[:, 2]),
        ("machine_displacement ry", data["machine_displacement"].values[:, 4]),
        (
            "load_pressure rear-left",
            data["chamber_pressure"].values[:, 2, 0] - data["chamber_pressure"].values[:, 2, 1],
        ),
    ):
        assert np.ptp(expected) > 0, name
        np.testing.assert_array_equal(channel(data, name), expected, err_msg=name)


# --- refusals -----------------------------------------------------------------------------------------------------


def test_a_floor_in_no_direction_is_refused() -> None:
    with pytest.raises(InputError, match=r"^dof = 'w': must be one of x, y, z, rx, ry, rz"):
        measure_floor(scenario("default"), MOTION, dof="w")


def test_lines_off_the_grid_are_refused() -> None:
    with pytest.raises(InputError, match=r"^frequency: lines must be multiples of 1 Hz"):
        measure_valves(scenario("default"), OIL, frequency=[1.0, 2.5])


def test_an_unknown_mount_is_refused() -> None:
    with pytest.raises(InputError, match="front-middle"):
        measure_valves(scenario("default"), OIL, pattern=["front-middle"])


def test_an_unknown_channel_is_refused_before_anything_is_simulated() -> None:
    with pytest.raises(InputError, match="channel 'strok front-left' is unknown"):
        measure_valves(scenario("default"), ["strok front-left"], frequency=[10.0])
