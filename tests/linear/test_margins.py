"""Margins: textbook loops in closed form, python-control's disk margin, and the sampled loop's own stability."""

import json
from dataclasses import replace

import control
import numpy as np
import pytest
from numpy.typing import NDArray

from ehamj.control import Controller
from ehamj.control.architectures.modal import ModalSettings
from ehamj.control.architectures.resonant import ResonantSettings
from ehamj.control.kinds import CombinedSettings
from ehamj.control.sensors import IDEAL
from ehamj.linear.loop import Loop, feeds_back, opened
from ehamj.linear.machine import LinearModel, linear_model
from ehamj.linear.margins import LoopReport, disk_margin, grid, loop_of, margins, margins_behind, report
from ehamj.linear.sampled import STABLE, sampled_machine, spectral_radius
from ehamj.plant.mounts import MOUNTS
from ehamj.scenario.load import parse_scenario
from ehamj.scenario.model import Scenario

HERTZ = np.geomspace(0.01, 5000.0, 6000)
S = 2j * np.pi * HERTZ

# --- textbook loops -----------------------------------------------------------------------------------------------


@pytest.mark.parametrize("lead", [0.3, 0.5, 1.2])
def test_an_integrator_with_delay_has_its_closed_form_margins(lead: float) -> None:
    gain, delay = 2 * np.pi * 20.0, lead / (2 * np.pi * 20.0)  # L = k e^(−sT)/s with k T = lead
    found = margins(HERTZ, gain * np.exp(-S * delay) / S)
    assert found.gain == pytest.approx(20 * np.log10(np.pi / 2 / lead), abs=0.01)
    assert found.phase == pytest.approx(90.0 - np.degrees(lead), abs=0.05)
    assert found.crossings == pytest.approx((20.0,), rel=1e-3)


def test_a_bare_integrator_has_no_gain_margin_and_the_whole_disk() -> None:
    found = margins(HERTZ, 2 * np.pi * 20.0 / S)
    assert found.gain == np.inf
    assert found.phase == pytest.approx(90.0, abs=1e-6)
    assert found.disk == pytest.approx(2.0, rel=1e-9)
    assert found.peak == pytest.approx(1.0, abs=1e-4)  # |jω/(jω + k)| comes up to one from below
    assert found.to_dict()["gain_db"] is None


@pytest.mark.parametrize("zeta", [0.05, 0.2, 0.6])
def test_a_second_order_loop_has_its_closed_form_margins(zeta: float) -> None:
    omega = 2 * np.pi * 30.0
    found = margins(HERTZ, omega**2 / (S * (S + 2 * zeta * omega)))
    root = np.sqrt(1 + 4 * zeta**4) - 2 * zeta**2
    x = (1 + np.sqrt(1 + 8 * zeta**2)) / 2  # where |S|² has no slope
    peak = np.sqrt(x * (x + 4 * zeta**2) / ((1 - x) ** 2 + 4 * zeta**2 * x))
    assert found.phase == pytest.approx(np.degrees(np.arctan(2 * zeta / np.sqrt(root))), abs=0.01)
    assert found.crossings == pytest.approx((30.0 * np.sqrt(root),), rel=1e-4)
    # The grid's step of 0.2 % misses the top of a peak of width 2ζ by (0.001/ζ)²/2.
    assert found.peak == pytest.approx(peak, rel=2e-3)
    assert found.peak_hertz == pytest.approx(30.0 * np.sqrt(x), rel=3e-3)
    assert found.disk == pytest.approx(2 * zeta / np.sqrt(1 + zeta**2), rel=2e-3)
    assert found.gain == np.inf


def test_a_margin_may_lie_below_as_well_as_above() -> None:
    # Conditionally stable: k (s + a)²/s³ needs k > a/2, and its phase goes through −180° there from below.
    corner = 2 * np.pi * 10.0
    for factor in (1.3, 3.0):
        k = factor * corner / 2
        found = margins(HERTZ, k * (S + corner) ** 2 / S**3)
        assert found.gain == pytest.approx(20 * np.log10(factor), abs=0.01)


def test_a_loop_that_never_reaches_one_has_no_margins_to_lose() -> None:
    found = margins(HERTZ, 0.1 / (1 + S / 100.0))
    assert (found.gain, found.phase, found.crossings) == (np.inf, np.inf, ())
    assert found.peak == pytest.approx(1.0, abs=1e-3)


# --- the disk margin of several loops -----------------------------------------------------------------------------


def test_loops_that_do_not_meet_have_the_disk_margin_of_the_worst() -> None:
    loops = [k * np.exp(-S * 1e-3) / S for k in (100.0, 400.0, 900.0, 700.0)]
    sensitivity = np.zeros((HERTZ.size, 4, 4), complex)
    for k, loop in enumerate(loops):
        sensitivity[:, k, k] = 1 / (1 + loop)
    assert disk_margin(sensitivity) == pytest.approx(min(margins(HERTZ, loop).disk for loop in loops), rel=1e-6)


@pytest.mark.parametrize("seed", range(4))
def test_the_disk_margin_is_python_control_s(seed: int) -> None:
    draw = np.random.default_rng(seed).normal
    A = draw(size=(5, 5)) - 3.0 * np.eye(5)
    loop = control.ss(A, draw(size=(5, 3)), draw(size=(3, 5)), np.zeros((3, 3)))
    closed = control.feedback(loop, np.eye(3))
    scale = 1.0
    while np.linalg.eigvals(closed.A).real.max() >= 0:
        scale /= 2
        closed = control.feedback(loop * scale, np.eye(3))
    omega = np.geomspace(0.01, 1000.0, 400)
    opened = np.linalg.inv(np.eye(3) + (scale * loop)(1j * omega).transpose(2, 0, 1))
    expected = control.disk_margins(loop * scale, omega, skew=0.0)[0]
    # Both bound µ of the same matrices from above; SLICOT's two routines differ in the last digits.
    assert disk_margin(opened) == pytest.approx(float(expected), rel=1e-3)


def test_one_loop_at_a_time_misleads() -> None:
    # Doyle's spinning satellite: each loop alone has an infinite gain margin and 90°, both together almost nothing.
    a, s = 10.0, 1j * np.geomspace(0.01, 1000.0, 800)
    sensitivity = np.array([np.linalg.inv(np.eye(2) + satellite(a, one)) for one in s])
    alone = [margins(s.imag / (2 * np.pi), 1 / sensitivity[:, k, k] - 1) for k in range(2)]
    assert min(one.phase for one in alone) == pytest.approx(90.0, abs=0.1)
    assert disk_margin(sensitivity) < 0.21


def satellite(a: float, s: complex) -> NDArray[np.complex128]:
    return np.array([[s - a**2, a * (s + 1)], [-a * (s + 1), s - a**2]]) / (s**2 + a**2)


# --- the machine's loop -------------------------------------------------------------------------------------------

SENSORS = {"ground": {"kind": "geophone"}, "inertial": {"kind": "geophone"}, "stroke": {}, "pressure": {}}


@pytest.fixture(scope="module")
def machine() -> Scenario:
    return parse_scenario({"plates": "tied", "sensors": SENSORS})


@pytest.fixture(scope="module")
def model(machine: Scenario) -> LinearModel:
    return linear_model(machine.plant)


def law_of(settings: ModalSettings | CombinedSettings, machine: Scenario) -> Controller:
    law = settings.controller(machine.plant, machine.sensors)
    assert isinstance(law, Controller)
    return law


@pytest.fixture(scope="module")
def combined(machine: Scenario) -> Controller:
    return law_of(CombinedSettings(delay=1.5e-4), machine)


@pytest.fixture(scope="module")
def heave_alone(machine: Scenario) -> Controller:
    """Of modal control only the loop of heave, at which all margins are those of one number."""
    standard = ModalSettings(delay=1.5e-4)
    still = {"crossing": 0.0}
    parts = {name: getattr(standard, name).model_copy(update=still) for name in ("roll", "pitch", "warp")}
    sway = {name: getattr(standard, name).model_copy(update={"gain": 0.0}) for name in ("sway_x", "sway_y")}
    return law_of(standard.model_copy(update=parts | sway), machine)


@pytest.fixture(scope="module")
def reported(model: LinearModel, combined: Controller, machine: Scenario) -> LoopReport:
    return report(model, Loop.of(machine, combined))


@pytest.fixture(scope="module")
def sampled(model: LinearModel, combined: Controller, machine: Scenario) -> control.StateSpace:
    return sampled_machine(model, Loop.of(machine, combined))


def test_behind_valves_of_another_gain_the_loop_is_that_of_the_law_of_that_gain(
    model: LinearModel, combined: Controller, machine: Scenario
) -> None:
    """And a phase of the valves is taken from what it has in hand, but for that of one loop changing the others."""
    found = margins_behind(model, Loop.of(machine, combined), [1.0, 1.5, 0.7])
    for factor, own in zip([1.0, 1.5, 0.7], found, strict=True):
        law = replace(combined, C=factor * combined.C, D=factor * combined.D)
        whole = report(model, Loop.of(machine, law))
        each = [*whole.valves.values(), *whole.motions.values()]
        expected = [min(getattr(m, name) for m in each) for name in ("gain", "phase", "disk")]
        np.testing.assert_allclose(own, expected, rtol=1e-9)
    late = margins_behind(model, Loop.of(machine, combined), [np.exp(-0.2j)])[0]
    assert late[1] < found[0, 1] - 5.0


@pytest.mark.parametrize("hertz", [0.3, 5.0, 40.0, 70.5, 300.0, 900.0])
def test_the_loop_gain_is_that_from_sample_to_sample(
    hertz: float, model: LinearModel, combined: Controller, machine: Scenario, sampled: control.StateSpace
) -> None:
    z = np.exp(2j * np.pi * hertz * combined.period)
    plant = sampled(z)
    law = combined.C @ np.linalg.solve(z * np.eye(combined.states) - combined.A, combined.B) + combined.D
    expected = -law @ plant
    found = opened(model, Loop.of(machine, combined), hertz).gain[0]
    # Images around the rate are left out: at 900 Hz the first lies at 9.1 kHz, where the oil lets (900/9100)³ through.
    np.testing.assert_allclose(found, expected, rtol=0, atol=5e-3 * np.abs(expected).max())


def test_the_default_law_keeps_what_practitioners_ask_for(reported: LoopReport) -> None:
    gain, phase, disk = reported.worst
    assert reported.stable
    assert gain >= 6.0
    assert phase >= 45.0
    assert disk >= 0.5


def test_a_report_is_plain_data(reported: LoopReport, combined: Controller) -> None:
    table = json.loads(json.dumps(reported.to_dict(), allow_nan=False))
    assert table["stable"] is True
    assert set(table["valves"]) == set(MOUNTS)
    assert set(table["motions"]) == {"heave", "roll", "pitch", "warp"}
    assert set(table["readings"]) == {name for name in combined.inputs if not name.startswith("ground")}
    assert table["gain_db"] == min(reported.worst[0], np.inf)


def test_two_mounts_that_mirror_each_other_have_one_margin(reported: LoopReport) -> None:
    left, right = reported.valves["front-left"], reported.valves["front-right"]
    assert (left.gain, left.phase, left.disk) == pytest.approx((right.gain, right.phase, right.disk), rel=1e-5)


def radius(model: LinearModel, law: Controller, machine: Scenario) -> float:
    return spectral_radius(model, Loop.of(machine, law))


def stable_within(model: LinearModel, machine: Scenario, scaled: list[Controller]) -> list[bool]:
    return [radius(model, law, machine) < STABLE for law in scaled]


def test_the_gain_margin_of_heave_is_where_the_sampled_loop_becomes_unstable(
    model: LinearModel, heave_alone: Controller, machine: Scenario
) -> None:
    found = report(model, Loop.of(machine, heave_alone)).motions["heave"]
    factor = 10 ** (found.gain / 20)
    # 2 %: the grid's steps about the crossing of −180°, and images of the machine, together 0.2 dB.
    laws = [heave_alone.scaled(factor * part) for part in (0.98, 1.02)]
    assert stable_within(model, machine, laws) == [True, False]


def test_the_phase_margin_of_heave_is_the_delay_that_makes_it_unstable(
    model: LinearModel, heave_alone: Controller, machine: Scenario
) -> None:
    found = report(model, Loop.of(machine, heave_alone)).motions["heave"]
    (crossing,) = found.crossings
    delay = found.phase / 360.0 / crossing
    laws = [replace(heave_alone, delay=round((1.5e-4 + part * delay) / 1e-5) * 1e-5) for part in (0.97, 1.03)]
    assert stable_within(model, machine, laws) == [True, False]


def test_the_gain_margin_of_a_valve_is_where_that_valve_alone_makes_it_unstable(
    model: LinearModel, combined: Controller, machine: Scenario, reported: LoopReport
) -> None:
    factor = 10 ** (reported.valves["front-left"].gain / 20)

    def changed(by: float) -> Controller:
        C, D = combined.C.copy(), combined.D.copy()
        C[0] *= by
        D[0] *= by
        return replace(combined, C=C, D=D, anti_windup=None)

    assert stable_within(model, machine, [changed(0.98 * factor), changed(1.02 * factor)]) == [True, False]


def test_the_disk_margin_holds_for_gains_that_change_independently(
    model: LinearModel, combined: Controller, machine: Scenario, reported: LoopReport
) -> None:
    # Within the balanced disk α every valve's gain may change by up to (2 + α)/(2 − α), each as it likes.
    most = (2 + reported.disk) / (2 - reported.disk)
    for seed in range(2):
        factors = most ** np.random.default_rng(seed).choice([-1.0, 1.0], len(MOUNTS))
        law = replace(combined, C=factors[:, None] * combined.C, D=factors[:, None] * combined.D, anti_windup=None)
        assert radius(model, law, machine) < STABLE, factors


def test_a_law_of_the_ground_alone_has_no_loop(model: LinearModel) -> None:
    law = parse_scenario({"control": {"kind": "feedforward"}}).controller()
    assert isinstance(law, Controller)
    assert not feeds_back(law)
    assert not feeds_back(None)
    with pytest.raises(ValueError, match="there is no loop"):
        report(model, Loop(law, IDEAL, 0))


def test_the_grid_ends_below_half_the_rate_and_is_dense_at_resonances(model: LinearModel, combined: Controller) -> None:
    f = grid(combined, model)
    assert f[0] == pytest.approx(0.02)
    assert f[-1] < 5000.0
    assert np.all(np.diff(f) > 0)
    assert np.diff(f[(f > 69.5) & (f < 71.2)]).max() < 0.5  # sway-rocking: 70 Hz, of 2ζf = 4.4 Hz half width


def test_a_resonator_of_a_law_is_seen_however_narrow_it_is(model: LinearModel) -> None:
    settings = ResonantSettings(lines=(24.5,), gain=30.0, bandwidth=5e-4)
    found = report(model, Loop(settings.controller(model.plant, IDEAL), IDEAL, 0)).motions["heave"]
    # |L| = 1 where x = f/f₀ − f₀/f is ± 2ζ√(g² − 1); beyond g 1 % of the oil's phase counts.
    x = 2 * 5e-4 * np.sqrt(30.0**2 - 1.0)
    wanted = 24.5 * (np.sqrt(1.0 + 0.25 * x**2) + 0.5 * x * np.array([-1.0, 1.0]))
    np.testing.assert_allclose(found.crossings, wanted, rtol=1e-3)


def test_a_loop_without_any_sensitivity_has_margins_that_are_numbers() -> None:
    """As where a law's reading is multiplied by whatever its file says."""
    loop = loop_of(np.array([0.5 + 0j, 0.0, 0.0, 1e-3]))
    np.testing.assert_allclose(loop[[0, 3]], [1.0, 999.0])
    assert np.isfinite(loop).all()
    found = margins(np.arange(1.0, 5.0), loop)
    assert np.isfinite([found.disk, found.peak]).all()
