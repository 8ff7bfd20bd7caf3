"""Points of the machine and relative motions: what is accepted, and that their motion is the rigid machine's."""

import re
import tomllib
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from oracles.levels import whole_run_rms

from ehamj.errors import InputError
from ehamj.plant.mounts import MOUNTS
from ehamj.plant.points import places
from ehamj.result import Result, load_result
from ehamj.run.simulate import simulate
from ehamj.scenario.load import parse_scenario
from ehamj.scenario.model import Scenario

POINTS = {"nose": [0.3, 0.1, 1.1], "table": [0.5, -0.2, 0.7], "at-cg": [0.1, 0.05, 0.75], "low": [-0.9, -0.6, 0.0]}
RELATIVE = [
    {"name": "tool", "from": "nose", "to": "table"},
    {"name": "laser", "from": "nose", "to": "ground front-left"},
    {"name": "corner", "from": "low", "to": "foot rear-right"},
    {"name": "still", "from": "at-cg", "to": "cg"},
    {"name": "floors", "from": "ground rear-left", "to": "ground front-right"},
]


@pytest.fixture(scope="module")
def run() -> Result:
    """A wave that heaves, rocks and shears a machine whose CG is off its middle."""
    floor = {
        "kind": "broadband",
        "level": "VC-A",
        "axes": ["x", "y", "z"],
        "highest": 200.0,
        "wave": {"direction": 30.0},
    }
    table = {"plates": "tied", "duration": 3.0, "seed": 5, "ground": floor, "points": POINTS, "relative": RELATIVE}
    return simulate(parse_scenario({**table, "machine": {"cg": [0.1, 0.05, 0.75]}}))


# --- what a user writes -------------------------------------------------------------------------------------------


def test_a_scenario_without_points_has_the_drawings_spindle_nose() -> None:
    # models/machine.xml: a cylinder of ±0.14 m about z = 1.20 m.
    assert Scenario().points == {"spindle-nose": pytest.approx((0.33, 0.0, 1.06))}


def test_the_spindle_nose_follows_the_machines_size() -> None:
    scenario = parse_scenario({"machine": {"size": [4.4, 1.6, 0.95], "cg": [0.0, 0.0, 0.4]}})
    assert scenario.points == {"spindle-nose": pytest.approx((0.66, 0.0, 0.53))}


def test_an_empty_table_has_no_points() -> None:
    scenario = parse_scenario({"points": {}, "plates": "tied", "duration": 0.02})
    result = simulate(scenario)
    assert scenario.points == {}
    assert "point" not in result.dataset.dims
    assert list(result.summary["third_octave_velocity"]) == ["floor", "feet", "machine"]


def test_points_and_relative_motions_survive_the_resolved_file() -> None:
    scenario = parse_scenario({"points": POINTS, "relative": RELATIVE, "criteria": {"response_spectrum": {}}})
    assert parse_scenario(tomllib.loads(scenario.to_toml())) == scenario
    assert tomllib.loads(scenario.to_toml())["relative"][0] == RELATIVE[0]


@pytest.mark.parametrize(
    ("table", "message"),
    [
        ({"points": {"nose": [2.2, 0.0, 1.0]}}, r"points.nose = [2.2, 0.0, 1.0] must lie within 1 m"),
        ({"points": {"nose": [0.0, 0.0, -1.1]}}, r"x, y, z in -2.1 to 2.1, -1.8 to 1.8, -1 to 2.9 m"),
        ({"points": {"nose": [0.0, 0.0]}}, r"points.nose = [0.0, 0.0]: entry 3 is missing"),
        ({"points": {"nose": [0.0, 0.0, float("nan")]}}, r"points.nose.2 = nan: must be a finite number"),
        ({"points": {"my nose": [0.0, 0.0, 1.0]}}, r"points: the name 'my nose' must consist of at most 32 letters"),
        (
            {"points": {"n" * 33: [0.0, 0.0, 1.0]}},
            r"must consist of at most 32 letters, digits, - and _, and not be one",
        ),
        ({"points": {"cg": [0.0, 0.0, 1.0]}}, r"points: the name 'cg' must"),
        (
            {"relative": [{"name": "a", "from": "nose", "to": "cg"}]},
            r"relative.0.from = 'nose': must be one of 'spindle",
        ),
        ({"relative": [{"name": "a", "from": "cg", "to": "ground"}]}, r"relative.0.to = 'ground': must be one of"),
        ({"relative": [{"name": "a", "from": "cg", "to": "cg"}]}, r"relative.0.to = 'cg' must differ from its from"),
        ({"relative": [{"name": "a", "to": "cg"}]}, r"relative.0.from: is missing"),
        ({"relative": [{"name": "a", "of": "cg", "to": "cg"}]}, r"relative.0.of = 'cg': unknown key"),
        ({"relative": [*RELATIVE[3:4]] * 2, "points": POINTS}, r"relative.1.name = 'still' must be unique"),
        (
            {"criteria": {"norms": ["vdi"]}},
            "criteria.norms.0 = 'vdi': must be 'vc', 'nist-a', 'iso-2631-2', 'din-4150-3' or ",
        ),
        ({"criteria": {"norms": ["vc", "vc"]}}, r"norms = ['vc', 'vc'] must name each norm once"),
        ({"criteria": {"norms": []}}, r"criteria.norms = []: must have at least 1 item"),
        ({"criteria": {"low_frequency": "new"}}, r"criteria.low_frequency = 'new': must be 'classic' or 'flat'"),
        (
            {"criteria": {"response_spectrum": {"damping": 1.0}}},
            r"criteria.response_spectrum.damping = 1.0: must be less",
        ),
        (
            {"criteria": {"response_spectrum": {"first": 20.0, "last": 10.0}}},
            r"last = 10 Hz must be at least first = 20 Hz",
        ),
        (
            {"record_rate": 500.0, "criteria": {"response_spectrum": {}}},
            r"criteria.response_spectrum.last = 100 Hz must be at most record_rate/10 = 50 Hz",
        ),
    ],
)
def test_what_cannot_be_is_refused_with_key_value_and_what_is_allowed(table: dict[str, Any], message: str) -> None:
    with pytest.raises(InputError, match=re.escape(message)):
        parse_scenario(table)


@given(st.dictionaries(st.text(max_size=8), st.lists(st.floats(-5, 5), min_size=2, max_size=4), max_size=3))
def test_any_table_of_points_is_taken_or_refused_in_words(points: dict[str, list[float]]) -> None:
    usable = all(
        re.fullmatch(r"[A-Za-z0-9][A-Za-z0-9_-]*", name) and len(place) == 3 and -1.0 <= place[2] <= 2.9
        and abs(place[0]) <= 2.1 and abs(place[1]) <= 1.8 for name, place in points.items()
    )  # fmt: skip
    if usable and not {"cg", "foot", "feet", "floor", "worst", "title"} & set(points):
        assert parse_scenario({"points": points}).points == {name: tuple(place) for name, place in points.items()}
    else:
        with pytest.raises(InputError, match=r"^points"):
            parse_scenario({"points": points})


def test_places_are_points_the_cg_feet_and_ground() -> None:
    assert places({"nose": (0.0, 0.0, 1.0)}, MOUNTS) == (
        "nose",
        "cg",
        *(f"foot {mount}" for mount in MOUNTS),
        *(f"ground {mount}" for mount in MOUNTS),
    )


# --- their motion -------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("motion", ["displacement", "velocity", "acceleration"])
def test_a_point_at_the_cg_or_at_a_foot_moves_with_it(run: Result, motion: str) -> None:
    data = run.dataset
    points = data[f"point_{motion}"]
    np.testing.assert_array_equal(points.sel(point="at-cg"), data[f"cg_{motion}"])
    np.testing.assert_array_equal(points.sel(point="low"), data[f"foot_{motion}"].sel(mount="rear-right"))


def test_two_points_of_the_machine_move_apart_by_its_rotation(run: Result) -> None:
    arm = np.array(POINTS["nose"]) - POINTS["table"]
    turn = run.dataset["machine_displacement"].values[:, 3:]
    found = run.dataset["relative_displacement"].sel(relative="tool").values
    # θ × r leaves out θ²: some 1e-6 rad of 1e-6 rad. Rounding: 1e-16 of the 15 µm sag.
    second = (turn**2).sum(axis=1).max() * np.linalg.norm(arm)
    np.testing.assert_allclose(found, np.cross(turn, arm), rtol=0, atol=1e-12 + second)
    assert np.abs(found).max() > 1e-9


@pytest.mark.parametrize("motion", ["displacement", "velocity"])
def test_a_point_against_the_ground_is_the_difference(run: Result, motion: str) -> None:
    data = run.dataset
    relative = data[f"relative_{motion}"]
    nose = data[f"point_{motion}"].sel(point="nose") - data[f"ground_{motion}"].sel(mount="front-left")
    np.testing.assert_array_equal(relative.sel(relative="laser"), nose)
    ground = data[f"ground_{motion}"]
    floors = ground.sel(mount="rear-left") - ground.sel(mount="front-right")
    np.testing.assert_array_equal(relative.sel(relative="floors"), floors)
    np.testing.assert_array_equal(relative.sel(relative="still"), 0.0)
    np.testing.assert_array_equal(relative.sel(relative="corner"), 0.0)


def test_relative_motions_in_the_summary_are_those_of_the_dataset(run: Result) -> None:
    laser = run.summary["relative"]["laser"]
    moved = run.dataset["relative_displacement"].sel(relative="laser").values
    about = moved - moved[0]
    assert (laser["from"], laser["to"]) == ("nose", "ground front-left")
    for k, axis in enumerate("xyz"):
        assert laser["peak"][axis] == pytest.approx(np.abs(about[:, k]).max(), rel=1e-12)
        assert laser["peak"][axis] == run.summary["peak"]["relative_displacement"]["laser"][axis]
        assert laser["rms"][axis] == pytest.approx(
            run.summary["rms"]["relative_displacement"]["laser"][axis], rel=1e-12
        )
    assert laser["peak"]["total"] == pytest.approx(np.linalg.norm(about, axis=1).max(), rel=1e-12)
    assert laser["rms"]["total"] == pytest.approx(np.sqrt((about**2).sum(axis=1).mean()), rel=1e-12)


def test_third_octaves_of_a_relative_motion_are_those_of_its_history(run: Result) -> None:
    moved = run.dataset["relative_displacement"].sel(relative="laser", axis="z").values
    found = run.summary["relative"]["laser"]["third_octave_displacement"]["z"]
    for band, centre in (("31.5", 31.62), ("125", 125.9)):
        level = whole_run_rms(moved - moved.mean(), 1000.0, 0.3, centre)
        assert 20 * np.log10(found[band] / level) == pytest.approx(0.0, abs=0.1)


def test_points_and_relative_motions_are_stored_with_names_and_units(run: Result, tmp_path: Path) -> None:
    run.write(tmp_path)
    stored = load_result(tmp_path)
    assert stored.dataset["point"].values.tolist() == list(POINTS)
    assert stored.dataset["relative"].values.tolist() == [entry["name"] for entry in RELATIVE]
    for name in ("point_acceleration", "relative_displacement"):
        assert stored.dataset[name].attrs["units"]
        np.testing.assert_array_equal(stored.dataset[name], run.dataset[name])
    assert stored.scenario == run.scenario
    assert stored.summary == run.summary
