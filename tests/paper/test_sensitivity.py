"""Sensitivities against closed forms and the paper's cases; the map of the paper's rule against whole designs."""

import math
from pathlib import Path

import numpy as np
import pytest
import xarray as xr

from ehamj.errors import InputError
from ehamj.isolator.presets import FIRST_GENERATION, RECOMMENDED
from ehamj.paper.actuator import figures_of_merit
from ehamj.paper.paper import reproduce
from ehamj.paper.sensitivity import (
    MERITS,
    PARAMETERS,
    RuleStudy,
    SensitivityStudy,
    elasticities,
    elasticity_figure,
    one_at_a_time,
    paper_marks,
    rule_curves,
    rule_figure,
    rule_map,
    write_sensitivity,
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


@pytest.fixture(scope="module")
def curves() -> xr.Dataset:
    return rule_curves(RuleStudy(damping=(0.1, 0.2, 0.3, 0.7)), points=41)


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
            found, case = table.sel(parameter=parameter, factor=factor), cases[f"{short}_{word}"].figures
            assert float(found.omega_h) == pytest.approx(case.omega_h, rel=1e-13)
            assert float(found.delta_h) == pytest.approx(case.delta_h, rel=1e-13)
            assert 20 * math.log10(float(found.gain_margin)) == pytest.approx(case.gain_margin_db, rel=1e-13)
            assert float(found.bandwidth) == pytest.approx(case.bandwidth_hz, rel=1e-13)


def test_one_at_a_time_covers_everything_with_units() -> None:
    table = one_at_a_time()
    assert tuple(table.parameter.values) == PARAMETERS
    assert set(table.data_vars) == set(MERITS)
    assert table.bandwidth.attrs["units"] == "Hz"
    unchanged = table.sel(factor=1.0)
    for name in MERITS:
        values = unchanged[name].values
        np.testing.assert_allclose(values, values[0], rtol=1e-14)


def test_a_figure_that_does_not_exist_is_nan() -> None:
    still = SensitivityStudy(FIRST_GENERATION.with_values({"flow_pressure": 6.6e-10, "membrane_stiffness": 0.0}))
    values = still.values("mass", 1.0)
    assert math.isnan(values["resonance"])
    assert values["bandwidth"] > 0.0


# --- the rule ------------------------------------------------------------------------------------------------------


def test_map_is_the_loop_at_each_place() -> None:
    study = RuleStudy(points=9)
    found = rule_map((0.2,), study)
    for load, valve in ((0, 0), (3, 7), (8, 1)):
        here = found.isel(damping=0, load_hz=load, valve_hz=valve)
        ratio = float(here.load_hz / here.valve_hz)
        bandwidth, crossover = study.reach(ratio, 0.2)
        # The map takes powers of the grid's step for the ratio.
        assert float(here.bandwidth) == pytest.approx(bandwidth * float(here.valve_hz), rel=1e-11)
        assert float(here.gain_crossover) == pytest.approx(crossover * float(here.valve_hz), rel=1e-11)
    assert found.bandwidth.attrs["units"] == "Hz"


@pytest.mark.parametrize("design", [FIRST_GENERATION, RECOMMENDED])
def test_map_is_the_figures_of_merit_without_membrane(design: object) -> None:
    assert isinstance(design, type(FIRST_GENERATION))
    bare = design.with_values({"membrane_stiffness": 0.0, "membrane_damping": 0.0})
    found, whole = figures_of_merit(bare), figures_of_merit(design)
    bandwidth, crossover = RuleStudy().reach(1.0 / found.valve_ratio, found.delta_h)
    assert bandwidth * found.valve_hz == pytest.approx(found.bandwidth_hz, rel=1e-10)
    assert found.gain_crossover_hz is not None
    assert crossover * found.valve_hz == pytest.approx(found.gain_crossover_hz, rel=1e-10)
    assert 1.0 <= whole.bandwidth_hz / found.bandwidth_hz < 1.09  # what the map's docstring promises


def test_bandwidth_is_limited_by_the_lesser_frequency(curves: xr.Dataset) -> None:
    """The paper's rule: where the two are ten times apart the bandwidth is at most 5 % above the lesser one."""
    for ratio in (0.1, 10.0):
        reached = curves.bandwidth.sel(ratio=ratio, method="nearest")
        assert float(reached.max()) < 1.05
    valve_limited = curves.bandwidth.sel(ratio=10.0, method="nearest")
    np.testing.assert_allclose(valve_limited, 1.0, atol=0.05)


def test_a_slow_lightly_damped_load_allows_far_less(curves: xr.Dataset) -> None:
    """Behind a fast valve Merritt's limit with 6 dB is a velocity gain of δ_hω_h, and the bandwidth about that."""
    for damping in (0.1, 0.2):
        reached = curves.gain_crossover.sel(damping=damping, ratio=0.1, method="nearest")
        assert float(reached) == pytest.approx(damping, rel=0.05)  # valve and resonance add a little


def test_where_the_frequencies_meet_the_loop_reaches_less(curves: xr.Dataset) -> None:
    """Against a load three times as fast as the valve, where they meet, the gain crossover is well below."""
    crossover = curves.gain_crossover
    meeting, apart = crossover.sel(ratio=1.0, method="nearest"), crossover.sel(ratio=3.2, method="nearest")
    assert bool((meeting < 0.66 * apart).all())


def test_marks_are_the_papers_designs() -> None:
    first, slow, recommended, fast = (mark.figures for mark in paper_marks())
    assert (first.valve_hz, slow.valve_hz, recommended.valve_hz, fast.valve_hz) == pytest.approx(
        (250.03, 100.0, 250.03, 400.0), abs=0.005
    )
    assert recommended.omega_h_hz == fast.omega_h_hz == pytest.approx(724.5, abs=0.05)


# --- figures and files ---------------------------------------------------------------------------------------------


def test_files_are_written(tmp_path: Path) -> None:
    written = write_sensitivity(tmp_path / "new", rule=RuleStudy(points=15, damping=(0.2, 0.4)))
    assert {path.name for path in written} == {
        "elasticities.csv",
        "one-at-a-time.csv",
        *(f"{name}.{kind}" for name in ("rule", "elasticities") for kind in ("svg", "png")),
    }
    assert all(path.stat().st_size > 1000 for path in written)


def test_figures_take_other_studies(slopes: xr.DataArray) -> None:
    study = RuleStudy(points=15, damping=(0.2, 0.4))
    assert len(rule_figure(study, marks=()).axes) == 5  # two maps, two curves, a colour bar
    assert len(rule_figure(study, marks=paper_marks()[:1]).axes) == 5
    assert len(elasticity_figure(slopes).axes) == 2


# --- refusals ------------------------------------------------------------------------------------------------------


def test_what_is_not_physical_is_refused() -> None:
    with pytest.raises(InputError, match=r"factors = .* positive"):
        SensitivityStudy(factors=(0.5, 0.0))
    with pytest.raises(InputError, match="parameter = 'colour': must be one of mass, piston_area"):
        SensitivityStudy().values("colour", 2.0)
    with pytest.raises(InputError, match=r"hertz = .* rising"):
        RuleStudy(hertz=(100.0, 10.0))
    with pytest.raises(InputError, match=r"damping = 0.0"):
        RuleStudy(damping=(0.0,))
    with pytest.raises(InputError, match=r"damping = -1.0"):
        rule_map((-1.0,))
    with pytest.raises(InputError, match="points = 1"):
        RuleStudy(points=1)
    with pytest.raises(InputError, match=r"mass = -1.0 kg"):
        elasticities(SensitivityStudy(mass=-1.0))
