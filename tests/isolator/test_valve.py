"""The valve's kernels: limits, symmetries and the linearisation that the paper gives."""

import math

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from ehamj.isolator.edges import Edges, port_flow, turbulence
from ehamj.isolator.spool import Command, Spool, spool_acceleration, spool_target
from ehamj.isolator.supply import Feed

GAIN, LEAK, EPS = 1.94e-6, 3.3e-12, 1e-3
SUPPLY, TANK = 70e5, 2e5
MIDDLE = 0.5 * (SUPPLY + TANK)
FEED = Feed(SUPPLY, TANK, (SUPPLY - TANK) / 2)
EDGES = Edges.Values(GAIN, LEAK, 0.0, EPS, 0.0, 0.0, 0.0)
SPOOL = Spool.Values(2.0, 1571.0, 0.65, 5.42e6, 20.0, 10.0)

pressures = st.floats(-20e5, 90e5)
openings = st.floats(-20.0, 20.0)
ratios = st.floats(1e-12, 1e3)
laminar = st.floats(1e-9, 0.1)


@given(st.floats(-100.0, 100.0))
def test_the_spool_is_asked_for_the_command_within_its_range(voltage: float) -> None:
    assert spool_target(Command(voltage, 0.0), SPOOL) == 2.0 * min(max(voltage, -10.0), 10.0)
    assert spool_target(Command(voltage, 1.0), SPOOL) == 2.0 * (min(max(voltage, -10.0), 10.0) + 1.0)


@given(st.floats(-1.0, 1.0), st.floats(-1e3, 1e3), st.floats(-1.0, 1.0))
def test_a_small_spool_motion_obeys_the_second_order_lag(spool: float, rate: float, target: float) -> None:
    # Paper eq. 1: ẍ/ω² + 2ζẋ/ω + x = c.
    omega, zeta = 1571.0, 0.65
    bend = spool_acceleration(target - spool, rate, SPOOL)
    restored = bend / omega**2 + 2 * zeta * rate / omega + spool
    assert restored == pytest.approx(target, abs=1e-12)


@given(st.floats(2.2, 40.0), st.floats(-3e4, 3e4), st.sampled_from([-1.0, 1.0]))
def test_the_drive_saturates_and_the_damping_does_not(distance: float, rate: float, side: float) -> None:
    # Beyond a_max/ω² = 2.196 mA from its target the spool feels a_max.
    omega, zeta, limit = 1571.0, 0.65, 5.42e6
    found = spool_acceleration(side * distance, rate, SPOOL)
    assert found == pytest.approx(side * limit - 2 * zeta * omega * rate, rel=1e-12, abs=1e-5)


@given(st.floats(-1e3, 1e3), laminar)
def test_the_orifice_law_is_odd(ratio: float, eps: float) -> None:
    assert turbulence(-ratio, eps) == -turbulence(ratio, eps)


@given(st.floats(-1e3, 1e3))
def test_without_a_laminar_end_it_is_the_signed_root(ratio: float) -> None:
    # Down to the guard against 0/0, which shows below 1e-140.
    expected = math.copysign(math.sqrt(abs(ratio)), ratio) if abs(ratio) > 1e-140 else 0.0
    assert turbulence(ratio, 0.0) == pytest.approx(expected, rel=1e-12, abs=1e-70)


def test_no_pressure_drop_gives_no_flow_and_no_division_by_zero() -> None:
    assert turbulence(0.0, 0.0) == 0.0


@given(laminar, st.floats(1e2, 1e6))
def test_far_from_the_laminar_end_the_flow_is_turbulent(eps: float, multiple: float) -> None:
    ratio = eps * multiple
    # (1 + ε²/r²)^-¼ = 1 − ε²/(4r²) + …
    assert turbulence(ratio, eps) == pytest.approx(math.sqrt(ratio) * (1 - 0.25 / multiple**2), rel=1e-8)


@given(laminar, st.floats(1e-6, 1e-2))
def test_within_the_laminar_end_the_flow_is_proportional(eps: float, share: float) -> None:
    ratio = eps * share
    # (1 + r²/ε²)^-¼ = 1 − r²/(4ε²) + …
    assert turbulence(ratio, eps) == pytest.approx(ratio / math.sqrt(eps) * (1 - 0.25 * share**2), rel=1e-8)


@given(ratios, st.floats(1e-6, 1.0), laminar)
def test_more_pressure_drop_gives_more_flow(ratio: float, more: float, eps: float) -> None:
    assert turbulence(ratio * (1 + more), eps) > turbulence(ratio, eps)


@given(st.floats(0.01, 20.0), st.sampled_from([-1.0, 1.0]))
def test_at_the_rated_drop_the_flow_is_the_gain_times_the_opening(opening: float, side: float) -> None:
    flow, drawn = port_flow(side * opening, MIDDLE, FEED, EDGES._replace(edge_leakage=0.0))
    # ε lowers it by ε²/4 = 2.5e-7.
    assert flow == pytest.approx(side * GAIN * opening, rel=3e-7)
    assert drawn == (flow if side > 0 else 0.0)


@given(openings, pressures)
def test_supply_and_tank_change_roles_with_the_sign_of_the_spool(opening: float, pressure: float) -> None:
    # Turn pressures upside down about the middle, and the spool: the flow turns round.
    forth, _ = port_flow(opening, pressure, FEED, EDGES)
    back, _ = port_flow(-opening, SUPPLY + TANK - pressure, FEED, EDGES)
    # 1e-9 of the rated flow: the mirrored pressure is rounded to 1e-9 Pa, where the root is steepest (ε = 1e-3).
    assert back == pytest.approx(-forth, rel=1e-9, abs=1e-9 * GAIN)


@given(openings, pressures)
def test_what_enters_a_port_comes_from_the_supply_or_the_tank(opening: float, pressure: float) -> None:
    flow, drawn = port_flow(opening, pressure, FEED, EDGES)
    # What runs to the tank is what the mirrored port draws from its supply.
    _, drained = port_flow(-opening, SUPPLY + TANK - pressure, FEED, EDGES)
    assert flow == pytest.approx(drawn - drained, rel=1e-9, abs=1e-9 * GAIN)


@given(pressures)
def test_a_closed_port_only_leaks(pressure: float) -> None:
    flow, drawn = port_flow(0.0, pressure, FEED, EDGES)
    assert drawn == LEAK * (SUPPLY - pressure)
    assert flow == pytest.approx(LEAK * (SUPPLY + TANK - 2 * pressure), rel=1e-12, abs=1e-20)


@given(openings, pressures)
def test_oil_only_flows_downhill(opening: float, pressure: float) -> None:
    assume(abs(opening) > 1e-3)
    flow, _ = port_flow(opening, pressure, FEED, EDGES._replace(edge_leakage=0.0))
    source = SUPPLY if opening > 0 else TANK
    assert np.sign(flow) == np.sign(source - pressure)
