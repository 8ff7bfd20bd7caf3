"""The cylinder's kernels: the paper's coefficients at null, conservation of oil and energy, cavitation."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from ehamj.isolator.edges import Edges, chamber_flows
from ehamj.isolator.fluid import actual_pressure, pressure_rate
from ehamj.isolator.supply import Feed

GAIN, STROKE, EPS = 1.94e-6, 20.0, 1e-3
K_C, SHARE = 6.6e-11, 0.05
EDGE, CROSS = SHARE * K_C, (1 - SHARE) * K_C
SUPPLY, TANK = 70e5, 2e5
MIDDLE = 0.5 * (SUPPLY + TANK)
FEED = Feed(SUPPLY, TANK, 0.5 * (SUPPLY - TANK))
FULL = GAIN * STROKE

spools = st.floats(-40.0, 40.0)
pressures = st.floats(0.0, 90e5)


def flows(spool: float, pressure_1: float, pressure_2: float, cross: float = CROSS) -> np.ndarray:
    """Flow into chamber 1, into chamber 2 and from the supply, of a valve that opens no further than its stroke."""
    opening = min(max(spool, -STROKE), STROKE)
    edges = Edges.Values(GAIN, EDGE, cross, EPS, 0.0, 0.0, 0.0)
    return np.array(chamber_flows(opening, pressure_1, pressure_2, FEED, edges))


def load_flow(spool: float, load: float) -> float:
    """Q_L = (Q1 − Q2)/2 at a load pressure about the middle."""
    one, two, _ = flows(spool, MIDDLE + load / 2, MIDDLE - load / 2)
    return 0.5 * (one - two)


def test_flow_gain_at_null_is_the_papers() -> None:
    slope = (load_flow(0.01, 0.0) - load_flow(-0.01, 0.0)) / 0.02
    assert slope == pytest.approx(GAIN, rel=3e-7)  # the laminar end lowers it by ε²/4


def test_flow_pressure_coefficient_at_null_is_the_papers() -> None:
    # Laminar leakage is linear: the difference is exact, but for the rounding of 35 bar ± 1 bar.
    slope = -(load_flow(0.0, 1e5) - load_flow(0.0, -1e5)) / 2e5
    assert slope == pytest.approx(K_C, rel=1e-12)


def test_nothing_enters_the_chambers_at_rest() -> None:
    one, two, drawn = flows(0.0, MIDDLE, MIDDLE)
    assert [one, two] == pytest.approx([0.0, 0.0], abs=1e-12 * EDGE * SUPPLY)
    assert drawn == pytest.approx(2 * EDGE * (SUPPLY - MIDDLE), rel=1e-12)


@given(spools, pressures, pressures)
def test_the_chambers_change_roles_with_the_sign_of_the_spool(spool: float, one: float, two: float) -> None:
    forth, back = flows(spool, one, two), flows(-spool, two, one)
    # The supply's flow is a sum in another order: rounding.
    np.testing.assert_allclose(back, forth[[1, 0, 2]], rtol=0, atol=1e-14 * FULL)


@given(spools, pressures, pressures)
def test_oil_is_conserved(spool: float, one: float, two: float) -> None:
    into = flows(spool, one, two)
    # What the tank receives is what the supply gives when pressures and spool are turned upside down.
    drained = flows(-spool, SUPPLY + TANK - one, SUPPLY + TANK - two)[2]
    # 1e-9 of full flow: the mirrored pressures are rounded to 1e-9 Pa.
    assert into[0] + into[1] == pytest.approx(into[2] - drained, abs=1e-9 * FULL)


@given(spools, pressures, pressures)
def test_leakage_across_the_piston_takes_from_one_chamber_what_it_gives_the_other(
    spool: float, one: float, two: float
) -> None:
    difference = flows(spool, one, two) - flows(spool, one, two, cross=0.0)
    across = CROSS * (one - two)
    np.testing.assert_allclose(difference, [-across, across, 0.0], rtol=0, atol=1e-14 * FULL)


@given(spools, pressures, pressures)
def test_valve_and_leakage_never_make_energy(spool: float, one: float, two: float) -> None:
    into = flows(spool, one, two)
    drained = into[2] - into[0] - into[1]
    lost = SUPPLY * into[2] - TANK * drained - one * into[0] - two * into[1]
    assert lost >= -1e-12 * SUPPLY * FULL  # rounding of a sum of powers


@given(st.floats(-1e-4, 1e-4), st.floats(-1e-4, 1e-4), st.floats(1e-5, 1e-3))
def test_pressure_answers_what_enters_beyond_what_the_piston_sweeps(inflow: float, swept: float, volume: float) -> None:
    # Paper eq. 4.
    rate = pressure_rate(inflow, swept, 35e5, volume, 1.4e9, 0.0)
    assert rate == pytest.approx(1.4e9 * (inflow - swept) / volume, rel=1e-12)


def test_a_chamber_without_oil_holds_the_vapour_pressure() -> None:
    assert actual_pressure(-3e5, 1e3) == 1e3
    assert actual_pressure(2e3, 1e3) == 2e3


@given(st.floats(1e-9, 1e-4))
def test_a_void_closes_with_the_volume_that_opened_it(taken: float) -> None:
    # The state falls below the vapour pressure by what left, and rises by what comes back: nothing is forgotten.
    falling = pressure_rate(-taken, 0.0, -1e5, 2.7e-4, 1.4e9, 0.0)
    rising = pressure_rate(taken, 0.0, -1e5, 2.7e-4, 1.4e9, 0.0)
    assert falling == -rising == pytest.approx(-1.4e9 * taken / 2.7e-4, rel=1e-12)
