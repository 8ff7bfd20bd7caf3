"""Designs of each plan: how many, where, and the same whenever it is asked."""

from typing import Any

import numpy as np
import pytest
from oracles.sensitivity_cases import cube
from pydantic import Field

from ehamj.campaign.correlations import Correlation
from ehamj.campaign.parameters import Space
from ehamj.campaign.plans.kinds import PLANS
from ehamj.campaign.plans.plan import Goals, Plan, Told
from ehamj.campaign.spreads import Between, Listed, Normal, Tolerance
from ehamj.errors import InputError
from ehamj.scenario.explain import checked
from ehamj.scenario.load import load_scenario
from ehamj.settings import Settings, one_of


class Table(Settings):
    """As a study file has it."""

    plan: one_of(PLANS) = Field(description="which designs")  # type: ignore[valid-type]


def plan(kind: str, **table: Any) -> Plan:
    """A plan as TOML gives it."""
    return checked(Table, {"plan": {"kind": kind, **table}}).plan  # type: ignore[no-any-return]


EVERY = {
    "grid": {},
    "one-at-a-time": {},
    "latin-hypercube": {"number": 20, "seed": 3},
    "sobol-sequence": {"number": 32, "seed": 3},
    "monte-carlo": {"number": 20, "seed": 3},
    "morris": {"paths": 5, "seed": 3},
    "sobol": {"groups": 8, "seed": 3},
    "optimise": {"population": 12, "generations": 4, "seed": 3},
}
LETTERS = (Listed(values=("a", "b", "c")), "a")
WHOLE = (Between(low=0.0, high=4.0), 2)
GOALS = Goals([("one", 1.0), ("two", -1.0)], [("three", None, 2.0)])


def all_batches(of: Plan, space: Space) -> list[np.ndarray]:
    """Every batch, told what smooth functions give, and of every seventh design that it failed."""
    asked = of.batches(space, GOALS)
    found = [next(asked)]
    while True:
        points = np.nan_to_num(found[-1], nan=0.5)
        objectives = np.column_stack([points.sum(axis=1), (points**2).sum(axis=1)])
        objectives[::7] = np.nan
        try:
            found.append(asked.send(Told(objectives, points[:, :1] - 0.8)))
        except StopIteration:
            return found


def test_every_kind_is_tried_here() -> None:
    assert set(EVERY) == {one.model_fields["kind"].annotation.__args__[0] for one in PLANS}  # type: ignore[union-attr]


@pytest.mark.parametrize("kind", EVERY)
def test_the_same_designs_come_whenever_it_is_asked(kind: str) -> None:
    space = cube(2, LETTERS, WHOLE)
    np.random.seed(1)  # noqa: NPY002  # nothing may depend on the common generator
    once = all_batches(plan(kind, **EVERY[kind]), space)
    np.random.seed(2)  # noqa: NPY002
    again = all_batches(plan(kind, **EVERY[kind]), space)
    assert len(once) == len(again)
    for one, other in zip(once, again, strict=True):
        np.testing.assert_array_equal(one, other)


@pytest.mark.parametrize("kind", EVERY)
def test_there_are_as_many_as_are_counted(kind: str) -> None:
    space, one = cube(2, LETTERS, WHOLE), plan(kind, **EVERY[kind])
    assert sum(map(len, all_batches(one, space))) == one.count(space)


@pytest.mark.parametrize("kind", EVERY)
def test_all_of_them_lie_in_the_unit_cube_and_have_values(kind: str) -> None:
    space = cube(2, LETTERS, WHOLE)
    points = np.vstack(all_batches(plan(kind, **EVERY[kind]), space))
    assert np.all(np.isnan(points) | ((points >= 0.0) & (points <= 1.0)))
    for row in space.values(points):
        assert row["x2"] in ("a", "b", "c")
        assert row["x3"] in range(5)


@pytest.mark.parametrize("kind", [kind for kind in EVERY if kind not in ("grid", "one-at-a-time")])
def test_another_seed_makes_others(kind: str) -> None:
    one, other = (all_batches(plan(kind, **EVERY[kind] | {"seed": seed}), cube(3))[0] for seed in (3, 4))
    assert not np.array_equal(one, other)


def test_a_grid_has_every_value_with_every_other() -> None:
    space = cube(2, LETTERS, WHOLE)
    rows = space.values(next(plan("grid", levels=2, levels_of={"x0": 3}).batches(space, Goals())))
    expected = {
        (x, y, letter, whole) for x in (0.0, 0.5, 1.0) for y in (0.0, 1.0) for letter in "abc" for whole in (0, 4)
    }
    assert {tuple(row.values()) for row in rows} == expected
    assert len(rows) == len(expected)


def test_one_at_a_time_differs_in_one_value_from_the_scenario() -> None:
    space = cube(2, LETTERS, WHOLE)
    first, *others = space.values(next(plan("one-at-a-time").batches(space, Goals())))
    assert first == {"x0": 0.5, "x1": 0.5, "x2": "a", "x3": 2}
    changes = [[(key, row[key]) for key in row if row[key] != first[key]] for row in others]
    alone = [("x0", 0.0), ("x0", 1.0), ("x1", 0.0), ("x1", 1.0), ("x2", "b"), ("x2", "c"), ("x3", 0), ("x3", 4)]
    assert changes == [[change] for change in alone]


def test_every_stratum_of_a_latin_hypercube_has_one_design() -> None:
    points = next(plan("latin-hypercube", number=50).batches(cube(4), Goals()))
    np.testing.assert_array_equal(np.sort(np.floor(50 * points), axis=0), np.tile(np.arange(50.0)[:, None], 4))


def test_every_box_of_a_sobol_sequence_has_one_design() -> None:
    points = next(plan("sobol-sequence", number=64).batches(cube(2), Goals()))
    for across, up in ((64, 1), (16, 4), (8, 8), (2, 32)):  # a (0, 6, 2)-net in base 2
        boxes = {(int(across * x), int(up * y)) for x, y in points}
        assert len(boxes) == 64


def test_more_designs_at_random_begin_with_the_same() -> None:
    few, many = (next(plan("monte-carlo", number=n).batches(cube(3), Goals())) for n in (10, 100))
    np.testing.assert_array_equal(few, many[:10])


def test_each_step_of_a_path_changes_one_parameter() -> None:
    points = next(plan("morris", paths=6).batches(cube(4), Goals())).reshape(6, 5, 4)
    steps = np.abs(np.diff(points, axis=1))
    np.testing.assert_allclose(np.sort(steps, axis=2)[..., -1], 2.0 / 3.0)
    np.testing.assert_allclose(np.sort(steps, axis=2)[..., :-1], 0.0, atol=1e-15)
    assert np.all(np.count_nonzero(steps > 0.5, axis=1) == 1)


def test_a_path_over_a_normal_without_limits_ends_at_three_deviations() -> None:
    space = cube(1, (Normal(mean=10.0, deviation=2.0), None))
    values = [row["x1"] for row in space.values(next(plan("morris", paths=20).batches(space, Goals())))]
    assert (min(values), max(values)) == (pytest.approx(4.0), pytest.approx(16.0))


def test_designs_of_a_group_have_their_values_from_two() -> None:
    points = next(plan("sobol", groups=8, second_order=True).batches(cube(3), Goals())).reshape(8, 8, 3)
    first, last = points[:, 0], points[:, -1]
    for k in range(3):
        np.testing.assert_array_equal(points[:, 1 + k], np.where(np.arange(3) == k, last, first))
        np.testing.assert_array_equal(points[:, 4 + k], np.where(np.arange(3) == k, first, last))


@pytest.mark.parametrize(
    ("kind", "table", "said"),
    [
        ("grid", {"levels": 1}, "plan.levels = 1: must be greater than or equal to 2"),
        ("sobol-sequence", {"number": 1000}, "plan.number = 1000: must be a power of two, such as 512 or 1024"),
        ("sobol", {"groups": 100}, "plan.groups = 100: must be a power of two, such as 64 or 128"),
        ("morris", {"levels": 5}, "plan.levels = 5: must be even, such as 6"),
        ("monte-carlo", {}, "plan.number: is missing"),
        ("montecarlo", {}, "plan.kind = 'montecarlo': did you mean 'monte-carlo'?"),
    ],
)
def test_a_plan_that_cannot_be_is_refused_by_its_key(kind: str, table: dict[str, Any], said: str) -> None:
    with pytest.raises(InputError) as refused:
        plan(kind, **table)
    assert said in str(refused.value)


def test_levels_of_what_does_not_vary_are_refused() -> None:
    with pytest.raises(InputError, match="'x00' does not vary; did you mean 'x0'"):
        plan("grid", levels_of={"x00": 3}).count(cube(2))


NEED = ("grid", "one-at-a-time", "morris", "sobol", "optimise")


@pytest.mark.parametrize("kind", EVERY)
def test_correlated_parameters_are_refused_where_they_mean_nothing(kind: str) -> None:
    mass, delay = "machine.mass", "footprint.x"
    vary = {mass: Tolerance(tolerance=0.1), delay: Tolerance(tolerance=0.1)}
    space = Space.of(load_scenario("benchmark"), vary, [Correlation(between=(mass, delay), coefficient=0.5)])
    asked = plan(kind, **EVERY[kind]).batches(space, GOALS)
    if kind not in NEED:
        assert next(asked).shape[1] == 2
        return
    with pytest.raises(InputError, match=r"must be independent here.*plan\.kind = 'monte-carlo'"):
        next(asked)
