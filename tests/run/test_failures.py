"""What a run says that failed though it came to its end."""

import numpy as np
import xarray as xr

from ehamj.run.failures import not_finite


def channels(**values: object) -> xr.Dataset:
    return xr.Dataset({name: ("time", value) for name, value in values.items()}, {"time": [0.0, 0.1, 0.2]})


def test_a_result_that_is_complete_is_finite() -> None:
    assert not_finite(channels(stroke=[0.0, 1.0, 2.0])) is None
    assert not_finite(channels(stroke=[1.5e308, 1.5e308, 0.0])) is None  # though their sum is not


def test_the_first_channel_that_is_not_is_named_with_its_time() -> None:
    said = not_finite(channels(stroke=[0.0, 1.0, 2.0], spool=[0.0, np.nan, 1.0], supply_pressure=[np.inf, 0.0, 0.0]))
    assert said is not None
    assert said.startswith("simulation failed at 0.1 s: spool is no longer finite. Kept to the end, marked incomplete")
