"""The linear actuator, its loop and its merits against closed forms, python-control, and what physics.md prints."""

import math
from dataclasses import replace
from typing import Any

import control
import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st
from oracles import linear

from ehamj.errors import InputError
from ehamj.isolator.actuator import Actuator
from ehamj.isolator.presets import FIRST_GENERATION, RECOMMENDED
from ehamj.paper.actuator import (
    FAST_VALVE,
    LARGE_SIGNAL_VALVE,
    LINEAR,
    PAPER_MASS,
    WITHOUT_EFFECT,
    bode,
    g_act,
    g_eha,
    g_valve,
)
from ehamj.paper.loop import PositionLoop
from ehamj.paper.merits import figures_of_merit
from ehamj.settings import PROVENANCE

HERTZ = np.geomspace(0.01, 3000.0, 200)
S = 2j * np.pi * HERTZ

OVERLAPPING = FIRST_GENERATION.with_values({"valve_frequency": FAST_VALVE, "flow_pressure": 1e-11})
"""Lightly damped, with the resonance before the valve: its closed loop crosses a gain of 1 more than once."""

DESIGNS = {
    "first": FIRST_GENERATION,
    "large signal": FIRST_GENERATION.with_values({"valve_frequency": LARGE_SIGNAL_VALVE}),
    "recommended": RECOMMENDED,
    "fast valve": RECOMMENDED.with_values({"valve_frequency": FAST_VALVE}),
    "lightly damped": OVERLAPPING,
    "no membrane": FIRST_GENERATION.with_values({"membrane_stiffness": 0.0, "membrane_damping": 0.0}),
    "overdamped": FIRST_GENERATION.with_values({"flow_pressure": 6.6e-10, "membrane_stiffness": 0.0}),
}
each_design = pytest.mark.parametrize("actuator", DESIGNS.values(), ids=list(DESIGNS))


def oracle(actuator: Actuator, mass: float = PAPER_MASS) -> linear.PaperActuator:
    """The oracle's actuator with these values."""
    return linear.PaperActuator(mass, **{linear.SYMBOLS[name]: getattr(actuator, name) for name in LINEAR})


def actuators() -> st.SearchStrategy[Actuator]:
    """Actuators whose values lie within a factor of ten of Table I."""
    scale = st.floats(0.1, 10.0)
    table = {name: scale.map(lambda f, name=name: f * getattr(FIRST_GENERATION, name)) for name in LINEAR}
    return st.builds(Actuator, **table)


# --- transfer functions --------------------------------------------------------------------------------------------


@given(actuators(), st.floats(100.0, 40000.0))
def test_transfer_functions_are_the_oracles(actuator: Actuator, mass: float) -> None:
    p = oracle(actuator, mass)
    # Polynomials of degree five against products: some roundings each, enlarged where terms cancel at a resonance.
    close = {"rtol": 1e-9, "atol": 0.0}
    np.testing.assert_allclose(g_valve(actuator)(S), linear.valve(p, S), **close)
    np.testing.assert_allclose(g_act(actuator, mass)(S), linear.actuator_exact(p, S), **close)
    np.testing.assert_allclose(g_act(actuator, mass, "eq8")(S), linear.actuator_eq8(p, S), **close)
    np.testing.assert_allclose(g_eha(actuator, mass)(S), linear.valve(p, S) * linear.actuator_exact(p, S), **close)


def test_signals_have_names_that_connect() -> None:
    whole = control.interconnect(
        [g_valve(FIRST_GENERATION), g_act(FIRST_GENERATION)], inputs=["voltage"], outputs=["stroke"]
    )
    direct = g_eha(FIRST_GENERATION)
    assert (direct.input_labels, direct.output_labels, direct.name) == (["voltage"], ["stroke"], "G_EHA")
    np.testing.assert_allclose(whole(S), direct(S), rtol=1e-9)  # through control's own state space


def test_eq_8_as_printed_is_an_undamped_resonance_in_the_wrong_place() -> None:
    p = oracle(FIRST_GENERATION)
    w, d, corner = linear.omega_h(p), linear.delta_h(p), p.K_C * p.K_L / p.A_p**2
    letter = (p.K_Q / p.A_p) / ((S + corner) * (S**2 / w**2 + 2 * d / w + 1))
    np.testing.assert_allclose(g_act(FIRST_GENERATION, PAPER_MASS, "eq8-printed")(S), letter, rtol=1e-9)
    poles = g_act(FIRST_GENERATION, PAPER_MASS, "eq8-printed").poles()
    pair = poles[poles.imag > 0]
    assert abs(pair[0].real) < 1e-9 * w
    assert pair[0].imag == pytest.approx(w * math.sqrt(1 + 2 * d / w), rel=1e-12)
    assert pair[0].imag / w - 1 == pytest.approx(0.00013, abs=0.000005)  # the 0.013 % of the docstring
    with pytest.raises(InputError, match="not damped, so it has no margins"):
        PositionLoop.of_actuator(FIRST_GENERATION, PAPER_MASS, "eq8-printed")


def test_eq_8_is_the_exact_form_without_membrane() -> None:
    soft = FIRST_GENERATION.with_values({"membrane_stiffness": 0.0, "membrane_damping": 0.0})
    np.testing.assert_allclose(g_act(soft, PAPER_MASS, "eq8")(S), g_act(soft)(S), rtol=1e-10)


@each_design
def test_bode_is_the_transfer_function_with_a_phase_that_only_falls(actuator: Actuator) -> None:
    magnitude, phase = bode(actuator, PAPER_MASS, HERTZ)
    np.testing.assert_allclose(magnitude * np.exp(1j * np.radians(phase)), g_eha(actuator)(S), rtol=1e-9)
    assert np.all(np.diff(phase) < 0.0)
    assert -450.0 < phase[-1] < phase[0] < 0.0


def test_bode_jumps_by_half_a_turn_at_the_printed_resonance() -> None:
    hertz = linear.omega_h(oracle(FIRST_GENERATION)) / (2 * np.pi) * np.array([0.999, 1.001])
    _, phase = bode(FIRST_GENERATION, PAPER_MASS, hertz, "eq8-printed")
    assert phase[0] - phase[1] == pytest.approx(180.0, abs=0.5)  # 0.2 % of frequency costs the valve 0.2°


# --- figures of merit: what physics.md prints, to its last digit ---------------------------------------------------


def test_figures_of_the_first_prototype() -> None:
    found = figures_of_merit(FIRST_GENERATION)
    assert found.hydraulic_stiffness == pytest.approx(1.051e10, abs=0.0005e10)
    assert found.stiffness_ratio == pytest.approx(0.065, abs=0.0005)
    assert found.break_frequency == pytest.approx(44.4, abs=0.05)
    assert found.merritt_limit == pytest.approx(685.7, abs=0.05)
    assert found.omega_h_hz == pytest.approx(256.2, abs=0.05)
    assert found.delta_h == pytest.approx(0.213, abs=0.0005)
    assert (found.gain_margin_db, found.phase_crossover_hz) == pytest.approx((135.8, 183.5), abs=0.05)
    assert (found.gain_margin_db_eq8, found.phase_crossover_hz_eq8) == pytest.approx((135.2, 178.6), abs=0.05)
    assert found.valve_hz == pytest.approx(250.0, abs=0.05)
    assert found.valve_ratio < 1.0  # the valve lies below the load, so the rule of three cannot hold
    assert not found.rule_of_three


def test_figures_of_the_recommendation() -> None:
    found = figures_of_merit(RECOMMENDED)
    assert found.omega_h_hz == pytest.approx(724.5, abs=0.05)
    assert found.delta_h == pytest.approx(0.301, abs=0.0005)
    assert (found.gain_margin_db, found.phase_crossover_hz) == pytest.approx((147.9, 221.9), abs=0.05)
    # 221.53 Hz; physics.md prints 221.5
    assert (found.gain_margin_db_eq8, found.phase_crossover_hz_eq8) == pytest.approx((147.9, 221.5), abs=0.05)


def test_a_quarter_of_the_machine_is_another_case() -> None:
    found = figures_of_merit(FIRST_GENERATION, PAPER_MASS / 4)
    assert found.omega_h_hz == pytest.approx(512.0, abs=0.5)
    assert found.delta_h == pytest.approx(0.107, abs=0.0005)
    assert found.merritt_limit == pytest.approx(figures_of_merit(FIRST_GENERATION).merritt_limit, rel=1e-14)


@each_design
def test_figures_are_the_oracles(actuator: Actuator) -> None:
    p, found = oracle(actuator), figures_of_merit(actuator)
    assert found.omega_h == pytest.approx(linear.omega_h(p), rel=1e-14)
    assert found.delta_h == pytest.approx(linear.delta_h(p), rel=1e-14)
    assert found.merritt_limit == pytest.approx(4 * p.beta * p.K_C / p.V_t, rel=1e-14)
    # The oracle brackets Im L = 0 on its own grid to 1e-10 Hz.
    assert (found.gain_margin_db, found.phase_crossover_hz) == pytest.approx(linear.gain_margin(p), abs=1e-9)
    eq8 = linear.gain_margin(p, exact=False)
    assert (found.gain_margin_db_eq8, found.phase_crossover_hz_eq8) == pytest.approx(eq8, abs=1e-9)


def test_load_resonance_is_the_exact_pole_pair() -> None:
    found = figures_of_merit(FIRST_GENERATION)
    p = oracle(FIRST_GENERATION)
    assert found.resonance_hz is not None
    assert found.resonance_damping is not None
    w = 2 * np.pi * found.resonance_hz
    pole = w * complex(-found.resonance_damping, math.sqrt(1 - found.resonance_damping**2))
    leak = p.K_C / p.A_p**2 + p.V_t * pole / (4 * p.beta * p.A_p**2)
    assert abs(pole + leak * (p.M * pole**2 + p.C * pole + p.K_L)) < 1e-11 * w
    overdamped = figures_of_merit(DESIGNS["overdamped"])
    assert (overdamped.resonance_hz, overdamped.resonance_damping) == (None, None)


def test_rule_of_three_holds_for_a_valve_three_times_as_fast() -> None:
    three_times = 3.001 * figures_of_merit(FIRST_GENERATION).omega_h
    assert figures_of_merit(FIRST_GENERATION.with_values({"valve_frequency": three_times})).rule_of_three


# --- crossings -----------------------------------------------------------------------------------------------------


@each_design
def test_phase_crossover_is_the_root_of_a_quadratic(actuator: Actuator) -> None:
    # The imaginary part of the denominator at jω is ω (d1 − d3 ω² + d5 ω⁴): a closed form to the last digits.
    loop = PositionLoop.of_actuator(actuator)
    _, d1, _, d3, _, d5 = loop.denominator[::-1]
    root = math.sqrt(2 * d1 / (d3 + math.sqrt(d3**2 - 4 * d5 * d1)))
    assert loop.phase_crossover == pytest.approx(root, rel=1e-12)


@each_design
@pytest.mark.parametrize("degrees", [-100.0, -135.0, -180.0, -225.0, -300.0, -440.0])
def test_phase_crossings_have_that_phase(actuator: Actuator, degrees: float) -> None:
    loop = PositionLoop.of_actuator(actuator)
    found = loop.phase_crossing(degrees)
    assert found is not None
    turned = loop.response(found) * np.exp(-1j * math.radians(degrees))
    assert abs(turned.imag) < 1e-10 * turned.real


def test_a_phase_that_never_comes_is_none() -> None:
    loop = PositionLoop.of_actuator(FIRST_GENERATION)
    assert loop.phase_crossing(-451.0) is None
    assert loop.phase_crossing(1.0) is None
    assert PositionLoop.of_actuator(DESIGNS["no membrane"]).phase_crossing(-89.0) is None
    first_order = PositionLoop(1.0, np.array([1.0, 1.0]))
    assert math.isinf(first_order.phase_crossover)
    assert math.isinf(first_order.stability_gain)


@each_design
def test_stability_gain_is_where_roots_turn(actuator: Actuator) -> None:
    loop = PositionLoop.of_actuator(actuator)
    for factor, stable in ((1 - 1e-7, True), (1 + 1e-7, False)):
        roots = np.roots(np.polyadd(loop.denominator, [factor * loop.stability_gain * loop.numerator]))
        assert bool(roots.real.max() < 0.0) is stable


@each_design
def test_margins_and_bandwidth_are_python_controls(actuator: Actuator) -> None:
    # python-control finds roots of polynomials without polishing: 1e-6 is what it leaves in the worst of these cases.
    loop = PositionLoop.of_actuator(actuator)
    gain = 0.7 * loop.stability_gain
    gain_margin, phase_margin, _, phase_crossover, gain_crossover, _ = control.stability_margins(gain * g_eha(actuator))
    assert loop.stability_gain / gain == pytest.approx(gain_margin, rel=1e-6)
    assert loop.phase_crossover == pytest.approx(phase_crossover, rel=1e-6)
    # Beyond −180° its phase margin is negative although the loop is stable; here it is a distance.
    assert loop.phase_margin(gain) == pytest.approx((abs(phase_margin), gain_crossover), rel=1e-6)
    assert loop.bandwidth(gain) == pytest.approx(control.bandwidth(control.feedback(gain * g_eha(actuator))), rel=1e-6)


def test_every_gain_crossing_is_found_and_the_worst_counts() -> None:
    loop = PositionLoop.of_actuator(OVERLAPPING)
    gain = 0.9 * loop.stability_gain
    crossings = loop.gain_crossings(gain)
    assert len(crossings) == 1 or len(crossings) == 3
    grid = np.geomspace(1.0, 1e5, 200_001)
    over = gain * np.abs(loop.response(grid)) > 1.0
    seen = grid[:-1][over[:-1] != over[1:]]
    np.testing.assert_allclose(crossings, seen, rtol=1e-4)  # one step of the grid
    margins = [abs(float(loop.phase(w)) + 180.0) for w in crossings]
    assert loop.phase_margin(gain) == pytest.approx((min(margins), crossings[int(np.argmin(margins))]))


@each_design
def test_bandwidth_is_3_db_below_the_static_value(actuator: Actuator) -> None:
    loop = PositionLoop.of_actuator(actuator)
    gain = loop.highest_gain(6.0, 45.0)
    bandwidth = loop.bandwidth(gain)
    closed = control.feedback(gain * g_eha(actuator))
    static = abs(closed(0.0))
    assert 20 * math.log10(abs(closed(1j * bandwidth)) / static) == pytest.approx(-3.0, abs=1e-9)
    before = np.abs(closed(1j * np.linspace(1e-3, 1.0 - 1e-9, 2000) * bandwidth))
    assert before.min() >= static * 10 ** (-3 / 20)


@settings(max_examples=60)
@given(actuators(), st.floats(0.0, 20.0), st.floats(0.0, 90.0))
@example(Actuator(bulk_modulus=5.6e9, valve_frequency=3142.0), 0.0, math.nextafter(90.0, 0.0))  # a root at 1e19 rad/s
@example(Actuator(membrane_stiffness=1.36e9, valve_frequency=3142.0, valve_damping=1.3), 0.0, 90.0)
def test_highest_gain_keeps_both_margins_and_no_higher_one_does(
    actuator: Actuator, gain_margin: float, phase_margin: float
) -> None:
    loop = PositionLoop.of_actuator(actuator)
    gain = loop.highest_gain(gain_margin, phase_margin)

    def kept(at: float) -> bool:
        reached = loop.phase_margin(at)
        decibels = 20.0 * math.log10(loop.stability_gain / at)
        return decibels >= gain_margin - 1e-9 and (reached is None or reached[0] >= phase_margin - 1e-6)

    assert kept(gain * (1 - 1e-9))
    assert not kept(gain * (1 + 1e-4))
    assert all(kept(share * gain) for share in (0.1, 0.5, 0.8, 0.99))


def test_a_loop_of_low_gain_has_no_crossover() -> None:
    found = figures_of_merit(FIRST_GENERATION, gain=1.0)  # 1 V/m: 111 dB below 1 at rest
    assert (found.gain_crossover_hz, found.phase_margin_deg) == (None, None)
    assert found.bandwidth_hz > 0.0


def test_figures_at_a_stated_gain() -> None:
    limit = 10 ** (figures_of_merit(FIRST_GENERATION).gain_margin_db / 20)
    found = figures_of_merit(FIRST_GENERATION, gain=0.5 * limit)
    default = figures_of_merit(FIRST_GENERATION, gain_margin_db=20 * math.log10(2), phase_margin_deg=0.0)
    assert found.bandwidth_hz == pytest.approx(default.bandwidth_hz, rel=1e-12)
    assert found.gain == pytest.approx(0.5 * limit, rel=1e-12)


# --- refusals ------------------------------------------------------------------------------------------------------


def test_an_unstable_loop_has_no_bandwidth() -> None:
    loop = PositionLoop.of_actuator(FIRST_GENERATION)
    with pytest.raises(
        InputError, match=r"gain = .* V/m: the closed loop is unstable .* below 6\.13\d*e\+06 V/m.*183\.5"
    ):
        figures_of_merit(FIRST_GENERATION, gain=1.001 * loop.stability_gain)


@pytest.mark.parametrize("mass", [0.0, -1.0, math.nan, math.inf, "4056", None, True])
def test_mass_must_be_a_positive_number(mass: Any) -> None:
    for ask in (figures_of_merit, g_act, g_eha):
        with pytest.raises(InputError, match=r"mass = .* must be a positive, finite number"):
            ask(FIRST_GENERATION, mass)


@pytest.mark.parametrize("gain", [0.0, -1.0, math.nan, math.inf])
def test_gain_must_be_a_positive_number(gain: float) -> None:
    with pytest.raises(InputError, match="gain = "):
        figures_of_merit(FIRST_GENERATION, gain=gain)


@pytest.mark.parametrize(
    ("name", "value"),
    [("gain_margin_db", -0.1), ("gain_margin_db", math.nan), ("phase_margin_deg", -1.0), ("phase_margin_deg", 91.0)],
)
def test_margins_have_a_range(name: str, value: float) -> None:
    with pytest.raises(InputError, match=name):
        figures_of_merit(FIRST_GENERATION, **{name: value})


def test_an_undamped_load_is_refused() -> None:
    with pytest.raises(InputError, match=r"flow_pressure = 0.0 .* must be a positive"):
        figures_of_merit(FIRST_GENERATION.with_values({"flow_pressure": 0.0}))


@pytest.mark.parametrize(
    ("name", "value"),
    [
        ("foot_stiffness", 1e9),
        ("area_ratio", 0.8),
        ("volume_share", 0.4),
        ("air_fraction", 0.01),
        ("wall_modulus", 1e9),
        ("overlap", (0.1, 0.1, 0.1, 0.1)),
        ("flow_curve", ((0.0, 0.0), (0.5, 0.2), (1.0, 1.0))),
        ("rated_flow", 1e-4),
        ("spool_stuck", True),
        ("outside_leakage_1", 1e-12),
        ("outside_leakage_2", 1e-12),
    ],
)
def test_what_the_paper_does_not_have_is_refused(name: str, value: Any) -> None:
    with pytest.raises(InputError, match=f"{name} = .* it must be .* here"):
        g_act(FIRST_GENERATION.with_values({name: value}))


def test_every_other_setting_is_known_to_have_no_effect() -> None:
    """A new option of the isolator is refused until someone says what eqs. 1 to 9 make of it."""
    beyond = {"foot_stiffness", "area_ratio", "volume_share", "air_fraction", "wall_modulus"}
    beyond |= {
        "overlap",
        "flow_curve",
        "rated_flow",
        *PROVENANCE,
        "spool_stuck",
        "outside_leakage_1",
        "outside_leakage_2",
    }
    assert {*LINEAR, *WITHOUT_EFFECT} == set(Actuator.model_fields) - beyond


def test_an_unknown_form_is_refused() -> None:
    with pytest.raises(InputError, match="form = 'eq9': must be one of exact, eq8, eq8-printed"):
        g_act(FIRST_GENERATION, PAPER_MASS, "eq9")  # type: ignore[arg-type]


def test_loops_of_another_kind_are_refused() -> None:
    with pytest.raises(InputError, match="five poles at most"):
        PositionLoop(1.0, np.poly([-1.0] * 6))
    with pytest.raises(InputError, match="must have a negative real part"):
        PositionLoop(1.0, np.poly([1.0, -1.0]))
    with pytest.raises(InputError, match="must have a negative real part"):
        PositionLoop(1.0, np.poly([0.0, 0.0, -1.0]))
    with pytest.raises(InputError, match="never turns unstable"):
        PositionLoop(1.0, np.array([1.0, 1.0])).highest_gain(6.0, 45.0)


def test_results_are_frozen() -> None:
    found = figures_of_merit(FIRST_GENERATION)
    with pytest.raises(AttributeError):
        found.gain = 1.0  # type: ignore[misc]
    assert replace(found) == found
