"""What a run would need, told before it begins."""

from pathlib import Path

import pytest

from ehamj.control.clock import exact
from ehamj.errors import InputError
from ehamj.run import budget
from ehamj.run.budget import check_rows, check_steps, fastest_part, row_bytes
from ehamj.run.simulate import simulate
from ehamj.scenario.load import load_scenario, parse_scenario


def test_rows_that_do_not_fit_are_refused_with_what_they_need(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    scenario = parse_scenario({"duration": 100.0, "record_rate": 1000.0})
    size = 1e5 * row_bytes(scenario)
    free = type("Free", (), {"available": 2.0 * size, "free": size})
    monkeypatch.setattr(budget.psutil, "virtual_memory", lambda: free)
    monkeypatch.setattr(budget.psutil, "disk_usage", lambda _: free)
    check_rows(scenario, 1, tmp_path)
    with pytest.raises(InputError, match=r"record_rate = 1000 Hz, 2 runs together: 2e\+05 rows need about .* memory"):
        check_rows(scenario, 2, tmp_path)
    free.free = 0.9 * size
    with pytest.raises(InputError, match=r"1e\+05 rows need about .* on disk and .* are free in"):
        check_rows(scenario, 1, tmp_path / "a" / "b")


def test_a_row_has_more_of_every_point_and_of_every_relative_motion() -> None:
    points = {"points": {"nose": [1.0, 0.0, 0.5], "tail": [-1.0, 0.0, 0.5]}}
    one, two = row_bytes(parse_scenario({"points": {"nose": [1.0, 0.0, 0.5]}})), row_bytes(parse_scenario(points))
    both = row_bytes(parse_scenario({**points, "relative": [{"name": "gap", "from": "nose", "to": "tail"}]}))
    assert (two - one, both - two) == (9 * 8, 6 * 8)


def test_what_a_row_is_thought_to_need_is_what_it_needs() -> None:
    """Within a factor of two: a row of the reference, whose law has most states."""
    scenario = load_scenario("vc-c-floor", ["duration=0.1", "compare=[]", "engine=small-motion"])
    result = simulate(scenario)
    rows = result.dataset.sizes["time"]
    assert 0.5 < result.dataset.nbytes / rows / row_bytes(scenario) < 2.0


@pytest.mark.parametrize(
    ("table", "said"),
    [
        ({"actuators": {"isolator": {"valve_frequency": 9e7}}}, r"from valve_frequency, has 9e\+07 rad/s: a step of"),
        ({"machine": {"mass": 1e-3}}, r"from machine\.mass, machine\.inertia and membrane_damping"),
    ],
)
def test_steps_that_nobody_meant_are_refused_by_the_fastest_part(table: dict[str, object], said: str) -> None:
    with pytest.raises(InputError, match=said):
        simulate({**table, "duration": 0.01})


@pytest.mark.parametrize(
    "table",
    [
        {"machine": {"mass": 1e-3}},
        {"machine": {"inertia": [1e-6, 1e-6, 1e-6]}},
        {"actuators": {"isolator": {"plate_mass": 0.0, "membrane_damping": 1e11}}},
    ],
)
def test_what_is_too_light_is_named_also_without_plates(table: dict[str, object]) -> None:
    plant = parse_scenario({"plates": "tied", **table}).plant
    assert "machine.mass, machine.inertia and membrane_damping" in fastest_part(plant)


def test_a_force_that_is_too_short_is_what_asks_for_short_steps() -> None:
    blow = {"kind": "hammer", "peak": 10.0, "pulse_time": 1e-8}
    with pytest.raises(InputError, match=r"force\.0 \(hammer\), which is so short or fast, asks for steps of 5e-10 s"):
        simulate(parse_scenario({"plates": "tied", "force": [blow], "duration": 1.0}))


def test_a_random_force_of_too_many_lines_is_refused_before_they_are_drawn() -> None:
    shaken = {"kind": "random", "rms": 1.0, "last": 1e7}
    with pytest.raises(InputError, match=r"a random force up to last = 1e\+07 Hz .* has 1e\+10 lines"):
        simulate(parse_scenario({"force": [shaken], "duration": 1000.0, "record_rate": 100.0}))


def test_a_run_of_months_is_refused() -> None:
    with pytest.raises(InputError, match=r"timestep = 1e-08 s: a step of 1e-08 s is 1e\+13 steps .* 1\.67e\+04 h"):
        check_steps(parse_scenario({"duration": 1e5, "timestep": 1e-8}), 1e-8)
    check_steps(parse_scenario({"duration": 1e5}), 1e-4)


def test_the_fastest_part_of_the_default_machine_is_its_lightest() -> None:
    assert "bulk_modulus, membrane_stiffness" in fastest_part(parse_scenario({}).plant)


def test_a_period_too_short_for_the_clock_is_refused_and_no_other() -> None:
    """It was lost before: the law of that period never ran."""
    with pytest.raises(InputError, match=r"3\.33333e-08 s: must be zero or at least 1e-07 s"):
        exact(1.0 / 3e7)
    assert float(exact(1.0 / 30001.0)) == 1.0 / 30001.0
