"""The drive limit identified from data sheets: the paper's two points, made-up ones, and ones that cannot be."""

import numpy as np
import pytest

from ehamj import InputError
from ehamj.isolator.presets import FIRST_GENERATION
from ehamj.rig.valve import Point, identify_drive_limit, quarter_lag_frequency, spool_response


def test_the_papers_two_points_give_the_preset() -> None:
    # The preset is rounded to three digits, and the points to a hertz.
    assert identify_drive_limit(FIRST_GENERATION) == pytest.approx(FIRST_GENERATION.spool_drive_limit, rel=0.01)


@pytest.mark.parametrize(("share", "frequency"), [(0.05, 250.0), (0.25, 175.8), (0.50, 130.5), (0.90, 100.0)])
def test_the_preset_lags_a_quarter_where_an_independent_integration_says(share: float, frequency: float) -> None:
    assert quarter_lag_frequency(FIRST_GENERATION, share) == pytest.approx(frequency, abs=0.1)  # stated to 0.1 Hz


def test_a_limit_is_found_again_from_the_frequencies_that_it_makes() -> None:
    valve = FIRST_GENERATION.with_values({"spool_drive_limit": 9e6, "valve_frequency": 2000.0})
    points = [Point(share, quarter_lag_frequency(valve, share)) for share in (0.1, 0.5, 1.0)]
    guess = valve.with_values({"spool_drive_limit": np.inf})
    assert identify_drive_limit(guess, points) == pytest.approx(9e6, rel=1e-3)  # the search stops at 1e-5 of ln a


def test_unlimited_it_is_the_papers_second_order_lag() -> None:
    valve = FIRST_GENERATION.with_values({"spool_drive_limit": np.inf})
    s = 2j * np.pi * 120.0 / valve.valve_frequency
    # RK4 at 400 steps a period, and a beginning that has decayed to exp(−200).
    assert spool_response(valve, 0.9, 120.0) == pytest.approx(1 / (1 + 2 * valve.valve_damping * s + s**2), abs=1e-6)


@pytest.mark.parametrize("point", [(0.05, 250.0), (1.5, 100.0), (0.5, -3.0), (0.5, 400.0), None])
def test_points_that_show_no_limit_are_refused(point: tuple[float, float] | None) -> None:
    points = [] if point is None else [Point(*point)]
    with pytest.raises(InputError, match="point"):
        identify_drive_limit(FIRST_GENERATION, points)
