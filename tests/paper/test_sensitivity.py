"""Sensitivities against closed forms, the oracle and the paper's cases."""

import math
from dataclasses import replace

import numpy as np
import pytest
import xarray as xr
from oracles import linear

from ehamj.errors import InputError
from ehamj.isolator.presets import FIRST_GENERATION
from ehamj.paper.merits import figures_of_merit
from ehamj.paper.reproduction import reproduce
from ehamj.paper.sensitivity import (
    MERITS,
    PARAMETERS,
    SensitivityStudy,
    elasticities,
    one_at_a_time,
)

POWERS = {
    "hydraulic_stiffness": {"piston_area": 2, "bulk_modulus": 1, "chamber_volume": -1},
    "omega_h": {"piston_area": 1, "chamber_volume": -0.5, "bulk_modulus": 0.5, "mass": -0.5},
    "delta_h": {"flow_pressure": 1, "piston_area": -1, "bulk_modulus": 0.5, "mass": 0.5, "chamber_volume": -0.5},
    "break_frequency": {"flow_pressure": 1, "membrane_stiffness": 1, "piston_area": -2},
    "velocity_gain": {"valve_gain": 1, "flow_gain": 1, "piston_area": -1},
    "merritt_limit": {"bulk_modulus": 1, "flow_pressure": 1, "chamber_volume": -1},
}
"""Figures that are products of powers."""


@pytest.fixture(scope="module")
def slopes() -> xr.DataArray:
    return elasticities()


# --- slopes --------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", POWERS)
def test_slopes_of_powers_are_the_exponents(slopes: xr.DataArray, name: str) -> None:
    expected = [POWERS[name].get(parameter, 0.0) for parameter in PARAMETERS]
    # Rounding of ln f over the step, 1e-15·ln(1e10)/1e-3; the truncation of a power is nothing.
    np.testing.assert_allclose(slopes.sel(figure=name), expected, atol=1e-10)


def test_slopes_obey_dimensional_analysis(slopes: xr.DataArray) -> None:
    """Rescaling the unit of time, mass or length moves a figure as its unit says: exact relations between slopes."""
    units = {  # exponents of kg, m, s
        "mass": (1, 0, 0),
        "piston_area": (0, 2, 0),
        "chamber_volume": (0, 3, 0),
        "bulk_modulus": (1, -1, -2),
        "membrane_stiffness": (1, 0, -2),
        "membrane_damping": (1, 0, -1),
        "flow_gain": (0, 3, -1),
        "flow_pressure": (-1, 4, 1),
        "valve_gain": (0, 0, 0),
        "valve_frequency": (0, 0, -1),
        "valve_damping": (0, 0, 0),
    }
    of_figure = {
        "resonance": (0, 0, -1),
        "resonance_damping": (0, 0, 0),
        "gain_margin": (0, -1, 0),
        "phase_crossover": (0, 0, -1),
        "velocity_gain_limit": (0, 0, -1),
        "gain_crossover": (0, 0, -1),
        "bandwidth": (0, 0, -1),
    }
    powers = np.array([units[name] for name in PARAMETERS])
    for figure, expected in of_figure.items():
        # Eight-fold cancellation of roots found to 1e-13, over a step of 1e-3.
        np.testing.assert_allclose(slopes.sel(figure=figure).values @ powers, expected, atol=1e-8, err_msg=figure)


def test_slopes_are_those_of_plain_differences(slopes: xr.DataArray) -> None:
    base = figures_of_merit(FIRST_GENERATION)
    ahead = figures_of_merit(FIRST_GENERATION.with_values({"valve_damping": 0.65 * 1.0001}))
    plain = math.log(ahead.bandwidth_hz / base.bandwidth_hz) / math.log(1.0001)
    found = float(slopes.sel(figure="bandwidth", parameter="valve_damping"))
    assert found == pytest.approx(plain, abs=2e-4)  # one-sided: an error of the order of the step


def test_flow_gain_is_a_gain_only(slopes: xr.DataArray) -> None:
    of_gain = slopes.sel(parameter="flow_gain")
    assert float(of_gain.sel(figure="gain_margin")) == pytest.approx(-1.0, abs=1e-10)
    for figure in ("phase_crossover", "bandwidth", "gain_crossover", "velocity_gain_limit"):
        assert float(of_gain.sel(figure=figure)) == pytest.approx(0.0, abs=1e-10)


def test_slopes_where_a_parameter_is_zero_are_zero() -> None:
    soft = FIRST_GENERATION.with_values({"membrane_damping": 0.0})
    assert np.all(elasticities(SensitivityStudy(soft)).sel(parameter="membrane_damping") == 0.0)


# --- one at a time -------------------------------------------------------------------------------------------------


def test_one_at_a_time_holds_the_papers_cases() -> None:
    table, cases = one_at_a_time(), reproduce().cases
    names = {"volume": "chamber_volume", "area": "piston_area"}
    names |= {name: name for name in ("flow_gain", "flow_pressure")}
    for short, parameter in names.items():
        for factor, word in ((2.0, "double"), (0.5, "half")):
            found, case = table.sel(parameter=parameter, factor=factor), cases[f"{short}_{word}"].merits
            assert float(found.omega_h) == pytest.approx(case.omega_h, rel=1e-13)
            assert float(found.delta_h) == pytest.approx(case.delta_h, rel=1e-13)
            assert 20 * math.log10(float(found.gain_margin)) == pytest.approx(case.gain_margin_db, rel=1e-13)
            assert float(found.bandwidth) == pytest.approx(case.bandwidth_hz, rel=1e-13)


def test_one_at_a_time_covers_everything_with_units() -> None:
    table = one_at_a_time()
    assert tuple(table.parameter.values) == PARAMETERS
    assert set(table.data_vars) == set(MERITS)
    assert table.bandwidth.attrs["units"] == "Hz"


@pytest.mark.parametrize("name", POWERS)
def test_multiplied_powers_are_powers(name: str) -> None:
    table = one_at_a_time(SensitivityStudy(factors=(1.0, 0.4, 3.0)))[name]
    for parameter in PARAMETERS:
        for factor in (0.4, 3.0):
            ratio = table.sel(parameter=parameter, factor=factor) / table.sel(parameter=parameter, factor=1.0)
            assert float(ratio) == pytest.approx(factor ** POWERS[name].get(parameter, 0.0), rel=1e-12), parameter


@pytest.mark.parametrize("parameter", PARAMETERS)
def test_multiplied_loops_are_the_oracles(parameter: str) -> None:
    table = one_at_a_time(SensitivityStudy(factors=(0.4, 3.0))).sel(parameter=parameter)
    symbol, plain = linear.SYMBOLS[parameter], linear.PaperActuator()
    for factor in (0.4, 3.0):
        changed = replace(plain, **{symbol: factor * getattr(plain, symbol)})
        found = table.sel(factor=factor)
        margin = 20 * math.log10(float(found.gain_margin))
        # The oracle brackets Im L = 0 on its own grid to 1e-10 Hz.
        assert (margin, float(found.phase_crossover)) == pytest.approx(linear.gain_margin(changed), abs=1e-9)


def test_a_figure_that_does_not_exist_is_nan() -> None:
    still = SensitivityStudy(FIRST_GENERATION.with_values({"flow_pressure": 6.6e-10, "membrane_stiffness": 0.0}))
    values = still.values("mass", 1.0)
    assert math.isnan(values["resonance"])
    assert values["bandwidth"] > 0.0


# --- refusals ------------------------------------------------------------------------------------------------------


def test_what_is_not_physical_is_refused() -> None:
    with pytest.raises(InputError, match=r"factors = .* positive"):
        SensitivityStudy(factors=(0.5, 0.0))
    with pytest.raises(InputError, match="parameter = 'colour': must be one of mass, piston_area"):
        SensitivityStudy().values("colour", 2.0)
    with pytest.raises(InputError, match=r"mass = -1.0 kg"):
        elasticities(SensitivityStudy(mass=-1.0))
