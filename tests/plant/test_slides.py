"""Courses of slides against their definitions, and what is refused."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from ehamj.errors import InputError
from ehamj.plant.slide import Slide
from ehamj.scenario.load import load_scenario, parse_scenario

SLIDE: dict[str, Any] = {
    "name": "ram",
    "mass": 500.0,
    "position": [0.0, 0.0, 1.0],
    "rail": [0.0, 3.0, 4.0],
    "travel": [-0.3, 0.3],
}
positive = st.floats(0.01, 100.0)


@given(to=st.floats(-0.3, 0.3), speed=positive, acceleration=positive, jerk=positive)
def test_a_move_keeps_its_limits_and_arrives(to: float, speed: float, acceleration: float, jerk: float) -> None:
    move = {"time": 0.1, "to": to, "speed": speed, "acceleration": acceleration, "jerk": jerk}
    course = Slide.model_validate({**SLIDE, "profile": {"kind": "moves", "moves": [move]}}).course()
    times = np.concatenate([np.linspace(0.0, 1.0, 400), np.linspace(1.0, 300.0, 400)])
    x, v, a = course.sample(times)
    assert (np.abs(v) <= speed * (1 + 1e-9)).all()
    assert (np.abs(a) <= acceleration * (1 + 1e-9)).all()
    assert (np.abs(x) <= abs(to) + 1e-9).all()
    np.testing.assert_allclose(x[-1], to, atol=1e-12)
    # Speed is the slope of the place, to what a change of jerk does in 0.1 ms.
    shift = 1e-4
    ahead, behind = (course.sample(times[:400] + sign * shift).value for sign in (1.0, -1.0))
    np.testing.assert_allclose((ahead - behind) / (2 * shift), v[:400], atol=jerk * shift**2 + 1e-9)


def test_a_table_goes_through_its_positions_and_begins_and_ends_at_rest(tmp_path: Path) -> None:
    times, positions = [0.5, 1.0, 1.6, 2.0], [0.0, 0.1, -0.1, 0.2]
    (tmp_path / "path.csv").write_text(
        "# s, m\n" + "".join(f"{t}, {x}\n" for t, x in zip(times, positions, strict=True))
    )
    own = {"kind": "table", "times": times, "positions": positions}
    read = {"kind": "table", "file": str(tmp_path / "path.csv")}
    courses = [Slide.model_validate({**SLIDE, "profile": profile}).course() for profile in (own, read)]
    for x in (course.sample(np.array([0.0, *times, 9.0])).value for course in courses):
        np.testing.assert_allclose(x, [0.0, *positions, 0.2], atol=1e-12)
    for side in (-1e-6, 1e-6):
        _, v, a = courses[0].sample(np.array([0.5, 1.0, 2.0]) + side)
        np.testing.assert_allclose([v[0], v[2], a[0], a[2]], 0.0, atol=1e-3)
    inside = [courses[0].sample(np.array([1.0 + side])).curvature[0] for side in (-1e-9, 1e-9)]
    np.testing.assert_allclose(*inside, rtol=1e-6)  # continuous


MOVES = {"kind": "moves", "moves": [{"time": 1.0, "to": 0.3}, {"time": 1.1, "to": 0.0}]}


@pytest.mark.parametrize(
    ("values", "said"),
    [
        ({"rail": [0.0, 0.0, 0.0]}, "has no length"),
        ({"start": 0.4}, "start takes it to 0.4 m, off its rail: travel = [-0.3, 0.3] m"),
        ({"travel": [0.3, 0.3]}, "must be from a coordinate to a larger one"),
        (
            {"profile": {"kind": "moves", "moves": [{"time": 1.0, "to": 1.0}]}},
            "profile.moves.0.to takes it to 1 m, off its rail",
        ),
        ({"profile": MOVES}, "moves.1.time = 1.1 s: it must be at least"),
        ({"profile": {"kind": "table", "times": [0.0, 1.0], "positions": [0.0]}}, "both must have as many"),
        ({"profile": {"kind": "table", "times": [1.0, 1.0], "positions": [0.0, 0.1]}}, "must be later"),
        ({"profile": {"kind": "table", "times": [0.0, 1.0, 2.0], "positions": [-0.3, 0.29, 0.29]}}, "off its rail"),
        ({"start": 0.1, "profile": {"kind": "table", "times": [0.0, 1.0], "positions": [0.0, 0.1]}}, "begins at 0 m"),
        ({"profile": {"kind": "table", "file": "/nowhere.csv"}}, "there is no such file"),
        ({"position": [0.0, 0.0, 9.0]}, "must lie within 1 m of the machine's outline"),
        ({"inertia": [1.0, 1.0, 3.0]}, "is of no rigid body"),
        ({"mass": 0.0}, "slide.0.mass"),
    ],
)
def test_what_cannot_slide_is_refused(values: dict[str, Any], said: str) -> None:
    with pytest.raises(InputError) as error:
        parse_scenario({"slide": [{**SLIDE, **values}]})
    assert said in str(error.value)


def test_slides_are_named_in_keys_and_stand_anywhere_for_linear_models() -> None:
    plant = load_scenario("moving-slide", ["slide.table.start=0.25", "compare=[]"]).plant
    assert plant.slides[0].begins == 0.25
    moved = load_scenario("moving-slide", ["compare=[]"]).plant.locked({"table": 0.25})
    assert moved.machine == plant.locked().machine == plant.machine
    with pytest.raises(InputError, match=r"slide table: 0\.7 m is off its rail"):
        plant.locked({"table": 0.7})
    with pytest.raises(InputError, match="slide 'head': must be one of table"):
        plant.locked({"head": 0.0})
