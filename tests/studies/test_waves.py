"""Waves that rock the machine, and what pure motions of the floor excite."""

from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import ehamj
from ehamj.errors import InputError
from ehamj.linear.machine import linear_model
from ehamj.plant.axes import DOFS
from ehamj.scenario.load import parse_scenario
from ehamj.studies import waves as study

MACHINE = parse_scenario({"name": "a machine", "plates": "tied"})
PHASOR = st.complex_numbers(max_magnitude=10.0, allow_nan=False)


@given(PHASOR, PHASOR)
def test_largest_turn_is_the_longest_vector_of_a_period(rx: complex, ry: complex) -> None:
    """Against 720 points of the period: their longest is short of the ellipse's axis by at most (π/720)²/2."""
    angle = np.exp(1j * np.linspace(0.0, 2 * np.pi, 721))
    longest = np.hypot((rx * angle).real, (ry * angle).real).max()
    assert float(study.largest_turn(np.array(rx), np.array(ry))) == pytest.approx(longest, rel=1e-5, abs=1e-12)


def test_a_wave_reaches_each_mount_at_its_time() -> None:
    places = np.array(MACHINE.plant.positions)[:, :2]
    motion = study.wave_motion(places, np.array([10.0]), 180.0, 90.0, "z")[0, :, 2]
    delay = np.angle(motion[0] / motion[1]) / (2 * np.pi * 10.0)  # left after right, 1.2 m apart
    assert delay == pytest.approx(-1.2 / 180.0)
    assert np.abs(motion) == pytest.approx(np.full(4, 1 / (2 * np.pi * 10.0)))


def test_a_slow_wave_tilts_the_machine_as_the_floor() -> None:
    """Far below all modes, and with a wavelength of 200 machines, the machine turns with the floor's slope."""
    few = study.WaveSettings(speeds=(400.0,), directions=(0.0, 90.0), frequencies=(1.0,))
    found = study.rocking(linear_model(MACHINE.plant), None, few)[:, 0, 0]
    assert found == pytest.approx(np.full(2, 2 * np.pi / 400.0), rel=1e-3)


def test_the_worst_wave_rocks_as_much_in_a_nonlinear_run() -> None:
    """1e-3: the machine turns by 3e-7 rad, where it is linear; what is left is the step."""
    few = study.WaveSettings(speeds=(100.0, 150.0, 200.0), directions=(90.0,), frequencies=(60.0, 64.0, 68.0))
    table = study.rocking_table(few, {"held": study.rocking(linear_model(MACHINE.plant), None, few)})
    worst = study.worst_wave(table, "held")
    assert study.simulated_rocking(MACHINE, "z", worst) == pytest.approx(worst["rocking"], rel=1e-3)


EXCITED = {"z": {"z"}, "rx": {"y", "rx"}, "ry": {"x", "ry"}, "x": {"x", "ry"}, "y": {"y", "rx"}, "rz": {"rz"}}
"""Motions of a symmetric machine that each motion of the floor excites."""


def test_the_floor_excites_its_own_plane_only_in_the_linear_model() -> None:
    """To 1e-6 of the largest, the rounding of the differences that the model comes from."""
    gain = study.coupling_table(linear_model(MACHINE.plant), np.array([5.0, 40.0, 70.3, 300.0]))["gain"]
    for dof, moved in EXCITED.items():
        row = {name: float(gain.sel(floor=dof, machine=name)) for name in DOFS}
        largest = max(row.values())
        assert all((value > 1e-4 * largest) == (name in moved) for name, value in row.items()), (dof, row)
        assert max((value for name, value in row.items() if name not in moved), default=0.0) < 1e-6 * largest


@pytest.mark.parametrize("dof", ["rx", "ry", "z"])
def test_the_floor_excites_its_own_plane_only_in_a_nonlinear_run(dof: str) -> None:
    """A nanometre of motion over a broad range: second orders are then 1e-9 of it, and rounding 1e-9 with the sag."""
    lines: dict[str, Any] = {"kind": "multisine", "dof": dof, "frequencies": [20.0, 70.0, 150.0, 450.0]}
    ground = lines | {"velocities": [1e-7], "fade_in": 0.1}
    table = {"name": "floor", "plates": "tied", "duration": 0.5, "record_rate": 4000.0, "ground": ground}
    motion = ehamj.simulate(parse_scenario(table)).dataset["machine_displacement"]
    peak = np.abs(motion - motion[0]).max("time")
    moved = [name for name in DOFS if name in EXCITED[dof]]
    others = [name for name in DOFS if name not in EXCITED[dof]]
    assert float(peak.sel(dof=moved).min()) > 1e-10
    assert float(peak.sel(dof=others).max()) < 1e-8 * float(peak.sel(dof=dof))


def test_a_speed_must_be_positive() -> None:
    with pytest.raises(InputError, match=r"speeds.0 = -1.0: must be greater than 0"):
        study.waves.with_settings({"speeds": (-1.0,)})
