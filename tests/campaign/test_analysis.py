"""Sensitivities, effects and regressions against closed forms."""

import numpy as np
import pytest
from numpy.polynomial import polynomial
from oracles.sensitivity_cases import cube, g_function, g_indices, ishigami, ishigami_indices
from scipy import stats

from ehamj.campaign.analysis.effects import one_at_a_time
from ehamj.campaign.analysis.regression import regression, response_surface
from ehamj.campaign.analysis.sensitivity import SobolIndices, morris_effects, sobol_indices
from ehamj.campaign.plans.indices import Morris, Sobol
from ehamj.campaign.plans.plan import Goals
from ehamj.errors import InputError
from ehamj.paper.sensitivity import SensitivityStudy, elasticities

THREE = ("x0", "x1", "x2")


def ishigami_found(seed: int, failed: tuple[int, ...] = ()) -> SobolIndices:
    """Of 1,024 groups."""
    plan = Sobol(kind="sobol", groups=1024, second_order=True, seed=seed)
    merit = ishigami(next(plan.batches(cube(3), Goals())))
    merit[list(failed)] = np.nan
    return sobol_indices(plan, THREE, merit)


@pytest.mark.parametrize("seed", [0, 1, 2])
def test_indices_of_ishigami_lie_within_their_intervals(seed: int) -> None:
    found, (first, total, second) = ishigami_found(seed), ishigami_indices()
    assert np.all(np.abs(found.first - first) <= found.first_reach)
    assert np.all(np.abs(found.total - total) <= found.total_reach)
    upper = np.triu_indices(3, 1)
    assert found.second is not None
    assert found.second_reach is not None
    assert np.all(np.abs(found.second - second)[upper] <= found.second_reach[upper])
    assert np.all(found.first_reach < 0.08)


def test_intervals_of_few_groups_hold_the_indices_as_often_as_they_say() -> None:
    """Of 120 intervals of 95 % at most 6 miss."""
    missed, (first, total, _) = 0, ishigami_indices()
    for seed in range(20):
        plan = Sobol(kind="sobol", groups=128, seed=seed)
        found = sobol_indices(plan, THREE, ishigami(next(plan.batches(cube(3), Goals()))))
        missed += int(np.sum(np.abs(found.first - first) > found.first_reach))
        missed += int(np.sum(np.abs(found.total - total) > found.total_reach))
    assert missed <= 6


def test_indices_of_the_g_function_lie_within_their_intervals() -> None:
    a = np.array([0.0, 1.0, 4.5, 9.0, 99.0, 99.0])
    plan = Sobol(kind="sobol", groups=2048)
    keys = tuple(f"x{k}" for k in range(6))
    found = sobol_indices(plan, keys, g_function(next(plan.batches(cube(6), Goals())), a))
    first, total = g_indices(a)
    assert np.all(np.abs(found.first - first) <= found.first_reach)
    assert np.all(np.abs(found.total - total) <= found.total_reach)
    assert found.second is None


def test_a_design_that_failed_takes_its_group_with_it() -> None:
    found = ishigami_found(0, failed=(0, 3, 8, 8 * 1024 - 1))
    assert (found.used, found.dropped) == (1021, 3)
    assert np.all(np.abs(found.total - ishigami_indices()[1]) <= found.total_reach)


def test_groups_that_are_not_there_yet_are_left_out() -> None:
    plan = Sobol(kind="sobol", groups=64)
    merit = ishigami(next(plan.batches(cube(3), Goals())))
    found = sobol_indices(plan, THREE, merit[:-7])
    assert (found.used, found.dropped) == (62, 2)


def test_intervals_are_the_same_every_time() -> None:
    np.testing.assert_array_equal(ishigami_found(0).total_reach, ishigami_found(0).total_reach)


def test_a_merit_that_never_changes_has_no_indices() -> None:
    found = sobol_indices(Sobol(kind="sobol", groups=8), THREE, np.ones(40))
    assert np.isnan(found.total).all()
    assert found.used == 8


def test_designs_of_another_plan_are_refused() -> None:
    with pytest.raises(InputError, match=r"must be \(40,\), 5 designs in each group of 8"):
        sobol_indices(Sobol(kind="sobol", groups=8), THREE, np.ones(41))


def test_effects_of_a_linear_function_are_its_slopes() -> None:
    plan, slopes = Morris(kind="morris", paths=7, levels=6), np.array([3.0, -2.0, 0.0])
    found = morris_effects(plan, THREE, next(plan.batches(cube(3), Goals())) @ slopes)
    np.testing.assert_allclose(found.mean, slopes, atol=1e-13)
    np.testing.assert_allclose(found.size, np.abs(slopes), atol=1e-13)
    np.testing.assert_allclose(found.scatter, 0.0, atol=1e-13)
    np.testing.assert_allclose(found.size_reach, 0.0, atol=1e-13)


def test_effects_of_a_square_scatter_as_its_slope_does() -> None:
    """Of x² over steps of 2/3 from the levels 0 and 1/3: 2/3 or 4/3, half of them each, or with the signs turned."""
    plan = Morris(kind="morris", paths=400)
    found = morris_effects(plan, THREE, (next(plan.batches(cube(3), Goals())) ** 2)[:, 0])
    assert found.size[0] == pytest.approx(1.0, abs=1.5 * found.size_reach[0])
    assert found.scatter[0] == pytest.approx(1.0 / 3.0, rel=0.02)


def test_a_path_that_failed_is_left_out() -> None:
    plan = Morris(kind="morris", paths=7)
    merit = next(plan.batches(cube(3), Goals())) @ np.array([3.0, -2.0, 1.0])
    merit[[5, 6]] = np.nan
    found = morris_effects(plan, THREE, merit)
    assert (found.used, found.dropped) == (6, 1)
    np.testing.assert_allclose(found.mean, [3.0, -2.0, 1.0], atol=1e-13)


def test_one_parameter_at_a_time_has_the_slopes_of_the_paper() -> None:
    """Relative sensitivities of all figures of the paper's actuator, from ±1 % of each parameter by itself."""
    study, exact = SensitivityStudy(), elasticities()
    keys = ("mass", "piston_area", "bulk_modulus", "flow_gain", "membrane_stiffness")
    factors = [[1.0] * 5] + [[f if j == k else 1.0 for j in range(5)] for k in range(5) for f in (0.99, 1.01)]
    changed = [next(((key, f) for key, f in zip(keys, row, strict=True) if f != 1.0), ("mass", 1.0)) for row in factors]
    merits = [study.values(key, factor) for key, factor in changed]
    for name in ("omega_h", "delta_h", "hydraulic_stiffness", "velocity_gain", "merritt_limit"):
        found = one_at_a_time(keys, factors, np.array([merit[name] for merit in merits]))
        expected = exact.sel(figure=name, parameter=list(keys)).values
        np.testing.assert_allclose([effect.slope for effect in found], expected, atol=2e-4)


def test_a_slope_to_both_sides_is_exact_for_a_square_whatever_the_steps() -> None:
    rows = [[2.0], [1.7], [2.9]]
    (effect,) = one_at_a_time(["p"], rows, np.array([(row[0] - 5.0) ** 2 - 30.0 for row in rows]))
    assert effect.values == (1.7, 2.0, 2.9)
    assert effect.slope == pytest.approx(2.0 * (2.0 - 5.0) * 2.0 / (9.0 - 30.0), rel=1e-12)


def test_a_power_has_its_exponent_to_one_side_too() -> None:
    (effect,) = one_at_a_time(["p"], [[2.0], [3.0]], np.array([2.0**-1.5, 3.0**-1.5]))
    assert effect.slope == pytest.approx(-1.5, rel=1e-12)


def test_the_side_that_failed_is_not_used() -> None:
    (effect,) = one_at_a_time(["p"], [[2.0], [1.0], [3.0]], np.array([4.0, np.nan, 9.0]))
    assert effect.slope == pytest.approx(2.0, rel=1e-12)
    np.testing.assert_array_equal(effect.change, [np.nan, 0.0, 5.0])


def test_values_without_order_have_changes_and_no_slope() -> None:
    rows = [["a", 1.0], ["b", 1.0], ["c", 1.0], ["b", 2.0]]
    letter, _ = one_at_a_time(["k", "p"], rows, np.array([1.0, 3.0, 0.5, 99.0]))
    assert letter.values == ("a", "b", "c")
    np.testing.assert_allclose(letter.change, [0.0, 2.0, -0.5])
    assert letter.reach == 2.5
    assert np.isnan(letter.slope)


def test_a_value_that_the_scenario_leaves_out_is_one_of_its_own() -> None:
    left_out = float("nan")
    rows = [[left_out, 1.0], [2.0, 1.0], [float("nan"), 3.0]]
    found = one_at_a_time(["k", "p"], rows, np.array([1.0, 5.0, 9.0]))
    np.testing.assert_array_equal([effect.change for effect in found], [[0.0, 4.0], [0.0, 8.0]])


DRAWN = np.random.default_rng(3).normal([5.0, -2.0, 100.0], [1.0, 0.1, 20.0], (400, 3))


def test_coefficients_of_a_sum_are_its_shares_of_deviation() -> None:
    merit = DRAWN @ np.array([2.0, 10.0, 0.0]) + 7.0
    found = regression(THREE, DRAWN, merit)
    np.testing.assert_allclose(found.coefficients, [2.0, 10.0, 0.0] * DRAWN.std(axis=0) / merit.std(), atol=1e-12)
    assert found.explained == pytest.approx(1.0, abs=1e-12)


def test_intervals_are_those_of_a_single_regression() -> None:
    merit = DRAWN[:, 0] + np.random.default_rng(4).normal(0.0, 2.0, 400)
    found, known = regression(THREE[:1], DRAWN[:, :1], merit), stats.linregress(DRAWN[:, 0], merit)
    scale = DRAWN[:, 0].std() / merit.std()
    assert found.coefficients[0] == pytest.approx(known.slope * scale)
    assert found.reach[0] == pytest.approx(stats.t.ppf(0.975, 398) * known.stderr * scale)
    assert found.explained == pytest.approx(known.rvalue**2)


def quadratic(values: np.ndarray) -> np.ndarray:
    """One that the surface can be."""
    return np.asarray(polynomial.polyval2d(values[..., 0], values[..., 1], [[1, 2, -3], [0.5, 4, 0], [2, 0, 0]]))


def test_a_quadratic_is_found_as_it_is() -> None:
    found = response_surface(THREE[:2], DRAWN[:, :2], quadratic(DRAWN))
    other = np.array([[[1.0, 2.0], [7.0, -4.0]], [[0.0, 0.0], [3.0, 3.0]]])
    np.testing.assert_allclose(found.at(other), quadratic(other), rtol=1e-9)
    assert found.explained == pytest.approx(1.0)
    assert found.predicted == pytest.approx(1.0)
    assert found.error < 1e-9 * np.abs(quadratic(DRAWN)).max()


def test_what_it_predicts_is_what_it_says_of_designs_left_out() -> None:
    values, merit = DRAWN[:40, :2], np.sin(3.0 * DRAWN[:40, 0]) + DRAWN[:40, 1]
    found = response_surface(THREE[:2], values, merit)
    off = [
        response_surface(THREE[:2], np.delete(values, k, 0), np.delete(merit, k)).at(values[k]) - merit[k]
        for k in range(40)
    ]
    assert found.error == pytest.approx(np.sqrt(np.mean(np.square(off))), rel=1e-9)
    assert found.predicted == pytest.approx(
        1.0 - np.sum(np.square(off)) / np.sum((merit - merit.mean()) ** 2), rel=1e-9
    )


def test_noise_is_explained_by_many_terms_and_not_predicted() -> None:
    merit = np.random.default_rng(5).normal(size=14)
    found = response_surface(THREE, DRAWN[:14], merit)
    assert found.explained > 0.5
    assert found.predicted < 0.0


def test_a_parameter_with_two_values_has_no_square() -> None:
    values = np.column_stack([np.tile([0.0, 1.0], 30), DRAWN[:60, 0]])
    merit = 3.0 * values[:, 0] + values[:, 1] ** 2
    found = response_surface(THREE[:2], values, merit)
    np.testing.assert_allclose(found.at(values), merit, rtol=1e-9)
    assert found.predicted == pytest.approx(1.0)


def test_designs_that_failed_say_nothing() -> None:
    merit = quadratic(DRAWN)
    merit[::5] = np.nan
    found = response_surface(THREE[:2], DRAWN[:, :2], merit)
    assert found.used == 320
    np.testing.assert_allclose(found.at(DRAWN[:5, :2]), quadratic(DRAWN[:5]), rtol=1e-9)


@pytest.mark.parametrize(
    ("values", "said"),
    [
        (DRAWN[:6], "6 designs have the merit; at least 11 are needed"),
        (DRAWN * [1.0, 0.0, 1.0], "x1 is -0 in all designs"),
    ],
)
def test_too_little_is_refused(values: np.ndarray, said: str) -> None:
    with pytest.raises(InputError, match=said):
        response_surface(THREE, values, np.arange(len(values), dtype=float))
