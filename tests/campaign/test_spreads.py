"""Values follow their distribution: closed forms of SciPy's own distributions, and what every spread must keep."""

import math
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from pydantic import Field
from scipy import stats

from ehamj.campaign.spreads import Vary
from ehamj.errors import InputError
from ehamj.scenario.explain import checked
from ehamj.settings import Settings


class Table(Settings):
    """As a study file has them."""

    vary: Vary = Field(description="spreads")


def spread(**table: Any) -> Any:
    """A spread as TOML gives it."""
    return checked(Table, {"vary": {"key": table}}).vary["key"]


SHARES = np.linspace(0.01, 0.99, 25)


@pytest.mark.parametrize(
    ("table", "known"),
    [
        ({"low": -2.0, "high": 6.0}, stats.uniform(-2.0, 8.0)),
        ({"low": 0.5, "high": 20.0, "scale": "log"}, stats.loguniform(0.5, 20.0)),
        ({"mean": 3.0, "deviation": 0.5}, stats.norm(3.0, 0.5)),
        ({"deviation": 0.5}, stats.norm(8.0, 0.5)),
        ({"low": 1.0, "mode": 2.0, "high": 5.0}, stats.triang(0.25, 1.0, 4.0)),
        ({"tolerance": 0.05}, stats.uniform(7.6, 0.8)),
        ({"off": 0.3}, stats.uniform(7.7, 0.6)),
        ({"factor": 2.0}, stats.loguniform(4.0, 16.0)),
    ],
    ids=lambda value: "-".join(value) if isinstance(value, dict) else "",
)
def test_a_share_of_the_values_is_below_its_quantile(table: dict[str, Any], known: Any) -> None:
    np.testing.assert_allclose(known.cdf(spread(**table).quantiles(SHARES, 8.0)), SHARES, rtol=1e-9)


def test_a_limited_normal_is_the_normal_within_its_limits() -> None:
    whole = stats.norm(3.0, 0.5).cdf
    values = spread(mean=3.0, deviation=0.5, low=2.9, high=4.0).quantiles(SHARES, None)
    np.testing.assert_allclose((whole(values) - whole(2.9)) / (whole(4.0) - whole(2.9)), SHARES, rtol=1e-9)


def test_a_normal_tolerance_ends_at_three_deviations() -> None:
    values = spread(tolerance=0.06, shape="normal").quantiles(np.array([0.0, 0.25, 1.0]), 100.0)
    np.testing.assert_allclose(values[[0, 2]], [94.0, 106.0], rtol=1e-14)
    within = stats.norm.cdf(3.0) - stats.norm.cdf(-3.0)
    assert stats.norm.cdf((values[1] - 100.0) / 2.0) == pytest.approx(stats.norm.cdf(-3.0) + 0.25 * within, rel=1e-9)


def test_a_tolerance_of_a_negative_value_is_about_it() -> None:
    np.testing.assert_allclose(spread(tolerance=0.1).quantiles(np.array([0.0, 0.5, 1.0]), -2.0), [-2.2, -2.0, -1.8])


def test_a_factor_of_a_negative_value_keeps_its_sign_and_rises() -> None:
    np.testing.assert_allclose(spread(factor=2.0).quantiles(np.array([0.0, 0.5, 1.0]), -3.0), [-6.0, -3.0, -1.5])


def test_every_integer_is_as_likely_as_any_other() -> None:
    values = spread(low=3, high=7).whole(np.linspace(0.0, 1.0, 1001)[:-1], 4)
    assert np.unique(values, return_counts=True)[1].tolist() == [200] * 5
    assert set(values) == {3.0, 4.0, 5.0, 6.0, 7.0}


def test_integers_end_where_they_are_said_to() -> None:
    assert spread(low=3, high=7).whole(np.array([0.0, 1.0]), 4).tolist() == [3.0, 7.0]


FINITE = st.floats(-1e6, 1e6).map(lambda value: round(value, 3))
POINTS = st.lists(st.floats(0.0, 1.0), min_size=2, max_size=30).map(lambda points: np.sort(np.array(points)))


@st.composite
def tables(draw: st.DrawFn) -> tuple[dict[str, Any], float, float]:
    """A spread's table, and the limits that its values must keep about an own value of 50."""
    low, wide = draw(FINITE), draw(st.floats(1e-3, 1e6))
    high = low + wide
    kind = draw(st.sampled_from(("range", "log", "normal", "triangle", "tolerance", "off", "factor")))
    if kind == "factor":
        return {"factor": 1.0 + wide}, 50.0 / (1.0 + wide), 50.0 * (1.0 + wide)
    if kind == "range":
        return {"low": low, "high": high}, low, high
    if kind == "log":
        return {"low": wide, "high": 3.0 * wide, "scale": "log"}, wide, 3.0 * wide
    if kind == "normal":
        mean = draw(st.floats(0.0, 1.0)) * wide + low
        return {"mean": mean, "deviation": draw(st.floats(1e-3, 1e3)) * wide, "low": low, "high": high}, low, high
    if kind == "triangle":
        return {"low": low, "mode": min(high, low + draw(st.floats(0.0, 1.0)) * wide), "high": high}, low, high
    shape = draw(st.sampled_from(("even", "normal")))
    if kind == "tolerance":
        share = draw(st.floats(1e-6, 0.999))
        return {"tolerance": share, "shape": shape}, 50.0 - 50.0 * share, 50.0 + 50.0 * share
    return {"off": wide, "shape": shape}, 50.0 - wide, 50.0 + wide


@given(tables(), POINTS)
def test_values_rise_with_their_share_and_keep_their_limits(
    drawn: tuple[dict[str, Any], float, float], points: np.ndarray
) -> None:
    table, low, high = drawn
    values = spread(**table).quantiles(points, 50.0)
    rough = 1e-9 * max(abs(low), abs(high))
    assert np.all(np.diff(values) >= -rough)
    assert np.all((values >= low) & (values <= high))


NUMBERS = st.floats() | st.integers(-(2**70), 2**70)
WRITTEN = NUMBERS | st.text(max_size=3) | st.booleans() | st.lists(st.integers(0, 3), max_size=3)
WORDS = st.sampled_from(
    ("low", "high", "mode", "mean", "deviation", "values", "tolerance", "off", "factor", "scale", "shape", "each", "x")
)


@given(st.dictionaries(WORDS, WRITTEN, max_size=4))
def test_whatever_is_written_has_finite_values_or_is_refused_by_its_key(table: dict[str, Any]) -> None:
    said, found = "vary.key", None
    try:
        found = spread(**table)
        found.check(50.0)
    except InputError as refused:
        said = str(refused)
    except ValueError:  # of a parameter that is about 50: what names its key stands around it
        return
    assert said.startswith("vary.key")
    assert found is None or np.isfinite(found.quantiles(np.array([0.0, 1e-300, 0.5, 1.0]), 50.0)).all()


@given(st.integers(2, 40), POINTS)
def test_entries_of_a_list_are_taken_in_order(count: int, points: np.ndarray) -> None:
    numbers = spread(values=list(range(count))).quantiles(points, None)
    assert np.all(np.diff(numbers) >= 0)
    assert np.all((numbers >= 0) & (numbers < count))


@pytest.mark.parametrize(
    ("table", "said"),
    [
        ({}, "vary.key: must have low and high, or values, or mean"),
        ({"lo": 1.0, "hi": 2.0}, "vary.key: must have low and high, or values"),
        ({"low": 1.0}, "vary.key.high: is missing"),
        ({"low": 2.0, "high": 2.0}, "vary.key.low = 2: must be below high = 2"),
        ({"low": 0.0, "high": 2.0, "scale": "log"}, "vary.key.low = 0: must be above 0 for scale = 'log'"),
        ({"low": "1", "high": 2.0}, "vary.key.low = '1': must be a valid number"),
        ({"values": [1.0]}, "must have at least 2 items"),
        ({"values": [1.0, 2.0, 1.0]}, "values has 1.0 twice"),
        ({"values": [1.0, math.nan]}, "values has nan; must be finite"),
        ({"tolerance": 1.5}, "vary.key.tolerance = 1.5: must be less than 1"),
        ({"tolerance": 0.1, "low": 1.0}, "vary.key.low = 1.0: unknown key; allowed: each, shape, tolerance"),
        ({"mean": 3.0}, "vary.key.deviation: is missing"),
        ({"mean": 3.0, "deviation": 0.1, "low": 5.0}, "20 deviations off the mean = 3: must be at most 6"),
        ({"low": 1.0, "mode": 3.0, "high": 2.0}, "vary.key.mode = 3: must be from low = 1 to high = 2"),
    ],
    ids=lambda value: "-".join(value) if isinstance(value, dict) else "",
)
def test_a_spread_without_values_is_refused_by_its_key(table: dict[str, Any], said: str) -> None:
    with pytest.raises(InputError) as refused:
        spread(**table)
    assert said in str(refused.value)


def test_keys_without_quotes_are_read_as_what_they_mean() -> None:
    bare = {"machine": {"mass": {"tolerance": 0.1}, "cg": {"0": {"off": 0.01}}}, "seed": {"low": 0, "high": 3}}
    assert list(checked(Table, {"vary": bare}).vary) == ["machine.mass", "machine.cg.0", "seed"]


def test_the_schema_describes_every_spread() -> None:
    import jsonschema

    schema = Table.model_json_schema()
    jsonschema.validate({"vary": {"machine.mass": {"tolerance": 0.1}, "a": {"values": ["x", "y"]}}}, schema)
    with pytest.raises(jsonschema.ValidationError):
        jsonschema.validate({"vary": {"machine.mass": {"tolerance": 0.1, "low": 1.0}}}, schema)
