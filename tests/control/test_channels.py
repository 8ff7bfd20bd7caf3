"""Channels along a mount's own direction, and what instruments out of line see of them."""

from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from ehamj.control.channels import CROSS, MountChannels, UnknownChannelError, channel_row
from ehamj.control.sensors import Sensors
from ehamj.errors import InputError
from ehamj.plant.levers import cross_axes
from ehamj.plant.plant import Plant
from ehamj.scenario.load import parse_scenario

SKEW = [0.3, -0.5, 0.8]


def legs(*directions: list[float], **more: Any) -> Plant:
    """Three upright mounts, and one for each further direction, above the mount plane."""
    places = [[0.9, 0.6], [0.9, -0.6], [-0.9, 0.0]]
    mounts: list[dict[str, Any]] = [{"name": f"up-{k}", "position": place} for k, place in enumerate(places)]
    for k, direction in enumerate(directions):
        mounts.append({"name": f"leg-{k}", "position": [0.2, 0.4, 0.5], "direction": direction, **more})
    return parse_scenario({"mount": mounts, "actuators": {"isolator": {}, "soft": {"preset": "elastic-mount"}}}).plant


@pytest.mark.parametrize("what", ["ground", "foot"])
@pytest.mark.parametrize("motion", ["displacement", "velocity", "acceleration"])
def test_along_is_the_component_in_the_mount_s_direction(what: str, motion: str) -> None:
    plant = legs(SKEW)
    along = channel_row(f"{what}_{motion} leg-0 along", plant)
    parts = [channel_row(f"{what}_{motion} leg-0 {axis}", plant) for axis in "xyz"]
    np.testing.assert_allclose(along, np.array(SKEW) / np.linalg.norm(SKEW) @ parts, atol=1e-15)


def test_a_foot_s_motion_along_its_mount_is_its_row_of_the_lever_matrix() -> None:
    plant = legs(SKEW, [1, 0, 0])
    rows = [channel_row(f"foot_displacement {mount} along", plant)[:6] for mount in plant.mounts]
    np.testing.assert_allclose(rows, plant.layout.rows, atol=1e-15)


def test_upright_mounts_are_measured_along_z_under_the_name_that_they_had() -> None:
    at = MountChannels.of(legs([0, 0, 2], [1, 0, 0]))
    assert at.feet[2:] == ("foot_velocity up-2 z", "foot_velocity leg-0 z", "foot_velocity leg-1 along")
    assert at.ground[3:] == ("ground_velocity leg-0 z", "ground_velocity leg-1 along")


def test_passive_mounts_are_not_measured() -> None:
    assert MountChannels.of(legs([1, 0, 0], actuator="soft")).strokes == ("stroke up-0", "stroke up-1", "stroke up-2")


def test_a_law_for_passive_mounts_alone_is_refused() -> None:
    table = {"actuators": {"isolator": {"preset": "elastic-mount"}}, "control": {"kind": "modal"}}
    with pytest.raises(InputError, match=r"no mount obeys commands, all 4 are passive; set control\.kind = 'passive'"):
        parse_scenario(table).controller()


direction = st.tuples(*(st.floats(-1.0, 1.0),) * 3).filter(lambda d: np.hypot(*d[:2]) > 1e-3 or abs(d[2]) > 1e-3)


@settings(max_examples=100)
@given(direction)
def test_across_is_at_right_angles_and_one_of_it_level(d: tuple[float, float, float]) -> None:
    along = np.array(d) / np.linalg.norm(d)
    axes = np.vstack([cross_axes(along), along])
    np.testing.assert_allclose(axes @ axes.T, np.eye(3), atol=1e-12)
    assert axes[0, 2] == 0.0


def test_an_instrument_out_of_line_sees_what_is_across() -> None:
    sensors = Sensors.model_validate({"inertial": {"kind": "geophone", "misalignment": 2.0}})
    found = sensors.mixture("foot_velocity leg-0 along", 7)
    assert list(found) == ["foot_velocity leg-0 along", *(f"foot_velocity leg-0 {label}" for label in CROSS)]
    assert np.linalg.norm(list(found.values())) == pytest.approx(1.0)
    # What is read is the component along one unit vector, 2° off the mount's.
    axis = sensors.rows(["foot_velocity leg-0 along"], legs(SKEW), 7)[0] @ np.linalg.pinv(
        [channel_row(f"foot_velocity leg-0 {axis}", legs(SKEW)) for axis in "xyz"]
    )
    assert np.linalg.norm(axis) == pytest.approx(1.0)
    assert np.degrees(np.arccos(axis @ SKEW / np.linalg.norm(SKEW))) == pytest.approx(2.0)


def test_what_is_neither_an_axis_nor_along_is_refused() -> None:
    with pytest.raises(UnknownChannelError, match="'foot_velocity up-0 athwart' is unknown"):
        channel_row("foot_velocity up-0 athwart", legs())
