"""Responses measured from the nonlinear simulation lie on the linear ones, and on the paper's exact transfer function.

Measured with a few millivolts or µm/s per line, where the machine is linear: 1 % and 1° from 1 to 300 Hz.
"""

from collections.abc import Iterable, Sequence
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from oracles import linear

from ehamj.control import Controller
from ehamj.errors import InputError
from ehamj.estimate.spectra import Spectra, estimate
from ehamj.linear.machine import linear_model
from ehamj.linear.response import ground_response
from ehamj.plant.mounts import MOUNTS
from ehamj.rig.measurement import Measurement, channel
from ehamj.rig.multisine import PERIOD, PERIODS, by_multisine, excited, line_amplitudes, lines
from ehamj.run.many import simulate_many
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


def measure_valves(
    case: Scenario, outputs: Sequence[str], pattern: Sequence[str] = MOUNTS, amplitude: float = 0.01
) -> Measurement:
    """Channels over a command [V] given to the valves of ``pattern`` alike, by four realisations of a multisine."""
    f, settling = lines(), 2.0  # the slowest oscillation, near 70 Hz, has then decayed to 1e-11
    signal = {"kind": "multisine", "mounts": list(pattern), "amplitude": amplitude, "frequencies": f.tolist()}
    phases = [np.random.default_rng([case.seed, k]).uniform(0, 2 * np.pi, f.size) for k in range(4)]
    controls = [{"kind": "open-loop", "signals": [signal | {"phases": phase.tolist()}]} for phase in phases]
    runs = simulate_many(excited(case, {"control": control}, f, settling + PERIOD) for control in controls)
    index, names = np.round(f * PERIOD).astype(int), (f"valve_command {pattern[0]}", *outputs)
    parts = [run.dataset.sel(time=slice(settling - 1e-9, settling + PERIOD - 0.5e-3)) for run in runs]
    found = np.array([[line_amplitudes(channel(part, name), index) for name in names] for part in parts])
    found = found.transpose(0, 2, 1)
    measured = estimate(Spectra.of_lines(f, found[:, :, :1], found[:, :, 1:]))
    return Measurement(tuple(outputs), tuple(pattern), measured, "")


@cache
def driven(machine: str, pattern: tuple[str, ...]) -> Measurement:
    return measure_valves(scenario(machine), (*OIL, *MOTION), pattern)


@cache
def shaken(machine: str, dof: str) -> Measurement:
    return by_multisine(scenario(machine), (*OIL, *MOTION), (dof,))


def assert_on_the_line(measured: Measurement, expected: np.ndarray, outputs: tuple[str, ...]) -> None:
    """Amplitude within 1 % and phase within 1° at every line, all of which must be coherent."""
    found = measured.estimate
    assert found.frequency[0] == 1.0
    assert found.frequency[-1] == 300.0
    for name in outputs:
        k = measured.outputs.index(name)
        ratio = found.response[:, k, 0] / expected[:, k]
        assert found.multiple[:, k].min() > 0.99, name
        assert np.abs(np.abs(ratio) - 1).max() <= 0.01, name
        assert np.abs(np.degrees(np.angle(ratio))).max() <= 1.0, name


# --- valves -------------------------------------------------------------------------------------------------------


def test_all_valves_together_move_the_default_machine_as_linear_theory_says() -> None:
    measured = driven("default", MOUNTS)
    commands = [f"valve_command {mount}" for mount in MOUNTS]
    expected = (
        linear_model(scenario("default").plant)
        .response(measured.estimate.frequency, measured.outputs, commands)
        .sum(axis=2)
    )
    assert_on_the_line(measured, expected, (*OIL, "machine_displacement z"))


@pytest.mark.parametrize("machine", MACHINES)
def test_one_valve_moves_and_rocks_the_machine_as_linear_theory_says(machine: str) -> None:
    measured = driven(machine, ("rear-left",))
    model = linear_model(scenario(machine).plant)
    expected = model.response(measured.estimate.frequency, measured.outputs, ["valve_command rear-left"])[:, :, 0]
    assert_on_the_line(measured, expected, (*OIL, *MOTION))


def test_one_actuator_under_4056_kg_is_the_papers_exact_transfer_function() -> None:
    table = {"machine": {"mass": 4 * 4056.0 - 4 * 14.0, "inertia": [2000.0, 3000.0, 4000.0]}}
    measured = measure_valves(scenario("default", **table), ("stroke rear-right", "load_pressure rear-right"))
    paper, s = linear.PaperActuator(), 2j * np.pi * measured.estimate.frequency
    stroke = linear.valve(paper, s) * linear.actuator_exact(paper, s)
    pressure = stroke * (paper.M * s**2 + paper.C * s + paper.K_L) / paper.A_p  # eq. 7
    assert_on_the_line(measured, np.column_stack([stroke, pressure]), measured.outputs)


# --- floor --------------------------------------------------------------------------------------------------------

FOLLOWS = {"z": ("z",), "x": ("x", "ry"), "y": ("y", "rx"), "rx": ("rx", "y"), "ry": ("ry", "x")}
"""What moves with a floor under the symmetric machine; the rest is of second order."""


@pytest.mark.parametrize("dof", FOLLOWS)
def test_the_default_machine_follows_a_floor_as_the_oracle_says(dof: str) -> None:
    measured = shaken("default", dof)
    response = np.array([linear.transmissibility(linear.LinearMachine(), dof, f) for f in measured.estimate.frequency])
    expected = np.zeros((measured.estimate.frequency.size, len(measured.outputs)), complex)
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


def from_the_floor(machine: str, dof: str, measured: Measurement) -> np.ndarray:
    model = linear_model(scenario(machine).plant)
    maps = linear.foot_maps(linear.LinearMachine(mounts=tuple(at[:2] for at in model.plant.positions)))
    slab = np.stack([part[:, DOFS.index(dof)] for part in maps], axis=1)
    return ground_response(model, measured.estimate.frequency, measured.outputs) @ slab.ravel()


# --- coherence ----------------------------------------------------------------------------------------------------


def test_a_command_that_saturates_is_not_coherent() -> None:
    # 33 lines of 4 V: 16 V RMS against ±10 V.
    measured = measure_valves(scenario("default"), ("stroke front-left",), amplitude=4.0)
    assert measured.estimate.multiple.min() < 0.95


# --- the loop that is measured ------------------------------------------------------------------------------------


class Begun(Exception):
    """A simulation begins, of this duration [s]."""


def test_it_begins_when_the_loop_with_its_instruments_as_they_are_turned_has_settled(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    """Feedback of geophones 20° off the vertical, in directions that the seed draws: some damp sway, some drive it."""

    def begin(scenarios: Iterable[Scenario], reduce: Any) -> None:
        raise Begun(next(iter(scenarios)).duration)

    monkeypatch.setattr("ehamj.rig.multisine.observe_many", begin)
    nothing = np.zeros((4, 0))
    feet = tuple(f"foot_velocity {mount} z" for mount in MOUNTS)
    Controller(nothing.T @ nothing, nothing.T, nothing, -5e3 * np.eye(4), feet).save(tmp_path / "law.json")
    table = {"control": {"kind": "law", "file": str(tmp_path / "law.json")}}
    table["sensors"] = {"inertial": {"kind": "geophone", "misalignment": 20.0}}
    with pytest.raises(Begun) as caught:
        by_multisine(scenario("default", seed=2, **table), dofs=("z",))
    assert caught.value.args[0] == pytest.approx(6.3 + PERIODS * PERIOD)
    with pytest.raises(InputError, match=r"sway-rocking about y .* has a damping ratio of"):
        by_multisine(scenario("default", seed=0, **table), dofs=("z",))


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


def test_an_unknown_channel_is_refused_before_anything_is_simulated() -> None:
    with pytest.raises(InputError, match="channel 'strok front-left' is unknown"):
        by_multisine(scenario("default"), ["strok front-left"], ["z"], [10.0])
