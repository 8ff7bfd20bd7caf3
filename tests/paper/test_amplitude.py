"""The amplitude study against the paper: its transfer function at small signals, its valve frequency at large ones."""

import numpy as np
import pytest
import xarray as xr
from oracles import linear

from ehamj import load_scenario
from ehamj.paper.amplitude import AmplitudeStudy, amplitude_response, write_amplitude


@pytest.fixture(scope="module")
def response() -> xr.Dataset:
    """The paper's actuator at two amplitudes."""
    return amplitude_response(AmplitudeStudy(load_scenario("single-actuator"), (0.01, 0.90), (20.0, 100.0, 250.0)))


def test_small_signals_follow_the_papers_transfer_function(response: xr.Dataset) -> None:
    s = 2j * np.pi * response["frequency"].values
    exact = linear.valve(linear.PaperActuator(), s) * linear.actuator_exact(linear.PaperActuator(), s)
    small = response.sel(share=0.01)
    # ±0.1 V bends the root law of the edges by 1e-3 of the flow; RK4 at its automatic step is finer.
    np.testing.assert_allclose(small["stroke_gain"], np.abs(exact), rtol=2e-3)
    np.testing.assert_allclose(small["stroke_phase"], np.degrees(np.unwrap(np.angle(exact))), atol=0.2)


def test_at_ninety_per_cent_the_valve_is_a_quarter_turn_late_at_100_hz(response: xr.Dataset) -> None:
    # The paper reads its figure to about 3 Hz, which is 3° there.
    assert float(response["spool_phase"].sel(share=0.9, frequency=100.0)) == pytest.approx(-90.0, abs=3.0)
    assert float(response["stroke_gain"].sel(share=0.9, frequency=250.0)) < 0.2 * float(
        response["stroke_gain"].sel(share=0.01, frequency=250.0)
    )


def test_figure_and_data_are_written(response: xr.Dataset, tmp_path) -> None:  # type: ignore[no-untyped-def]
    write_amplitude(tmp_path, response)
    assert sorted(path.name for path in tmp_path.iterdir()) == ["amplitude.nc", "amplitude.png", "amplitude.svg"]
    with xr.open_dataset(tmp_path / "amplitude.nc", engine="h5netcdf") as stored:
        xr.testing.assert_equal(stored.load(), response)
