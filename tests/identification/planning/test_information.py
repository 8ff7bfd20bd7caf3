"""Fisher information against closed forms, against the scatter of fits, and against the nonlinear engine."""

from typing import Any

import numpy as np
import pytest
from scipy.optimize import least_squares

from ehamj.identification.planning.excitation import excitation_of
from ehamj.identification.planning.forecast import told_by
from ehamj.identification.planning.information import Knowledge, best_sequence, without
from ehamj.identification.planning.instruments import Instruments
from ehamj.identification.planning.lanes import run_of
from ehamj.identification.planning.linear import Linear
from ehamj.identification.planning.trial import Trial
from ehamj.identification.unknowns import Unknown
from ehamj.rig.low_peak import low_peak
from ehamj.scenario.load import parse_scenario

VALVE = "actuators.isolator.valve_frequency"
DAMPING = "actuators.isolator.valve_damping"
SPOOL = "spool front-left"
RATE = 4000.0
NOISE = 0.01


def unknown(key: str, value: float) -> Unknown:
    return Unknown(key, "", value, 0.5 * value, 2.0 * value)


@pytest.fixture(scope="module")
def spool_test() -> Trial:
    """Twenty lines at one valve, one period to settle and two compared."""
    played = low_peak(0.25, np.arange(5, 65, 3)).scaled(0.05)
    table: dict[str, Any] = {
        "duration": 0.75,
        "control": {"kind": "open-loop", "signals": [played.command(["front-left"])]},
    }
    return Trial("spool", "valves", "", parse_scenario(table), "periodic", 0.25, {"valve_command front-left": played})


UNKNOWNS = (unknown(VALVE, 1571.0), unknown(DAMPING, 0.65))
AT = {VALVE: 1571.0, DAMPING: 0.65}


def spool_lines(trial: Trial, frequency: float, damping: float) -> np.ndarray:
    """x = K_v ω²/(ω² − Ω² + 2jζωΩ) v of eq. 1 of the paper, at the trial's lines [mA]."""
    played = trial.played["valve_command front-left"]
    s = 2j * np.pi * played.frequencies
    command = -1j * played.amplitudes * np.exp(1j * played.phases)
    return 2.0 * frequency**2 / (s**2 + 2 * damping * frequency * s + frequency**2) * command


def test_information_on_a_spool_is_that_of_the_closed_form(spool_test: Trial) -> None:
    """Of sines with derivatives dx in white noise σ: Σ N/2σ²·|dx|², N samples; logarithms of both values."""
    frequency, damping, s = 1571.0, 0.65, 2j * np.pi * spool_test.played["valve_command front-left"].frequencies
    lines = spool_lines(spool_test, frequency, damping)
    denominator = s**2 + 2 * damping * frequency * s + frequency**2
    slopes = np.array(
        [lines * (2.0 - frequency * (2 * damping * s + 2 * frequency) / denominator),
         lines * (-2 * damping * frequency * s / denominator)]
    )  # fmt: skip
    expected = 0.5 * 0.5 * RATE / NOISE**2 * (slopes.conj() @ slopes.T).real
    instruments = Instruments.of(spool_test.scenario, RATE, (SPOOL,), {"spool": NOISE})
    linear = Linear(spool_test.scenario, UNKNOWNS, AT)
    found = told_by(linear.lines(spool_test, (SPOOL,), RATE), instruments, spool_test.compared)
    np.testing.assert_allclose(found, expected, rtol=2e-3)


def test_predicted_deviations_are_the_scatter_of_fits(spool_test: Trial) -> None:
    """A hundred and fifty fits of the closed form to noisy samples, with an unknown gain of the sensor beside."""
    instruments = Instruments.of(spool_test.scenario, RATE, (SPOOL,), {SPOOL: NOISE})
    linear = Linear(spool_test.scenario, UNKNOWNS, AT)
    information = told_by(linear.lines(spool_test, (SPOOL,), RATE), instruments, spool_test.compared, ("gain",))
    predicted = Knowledge(information).deviations
    time = np.arange(0.25, 0.75, 1 / RATE)
    turning = np.exp(2j * np.pi * np.outer(time, spool_test.played["valve_command front-left"].frequencies))

    def samples(logs: np.ndarray) -> np.ndarray:
        lines = spool_lines(spool_test, 1571.0 * np.exp(logs[0]), 0.65 * np.exp(logs[1]))
        return np.asarray(np.exp(logs[2]) * (turning @ lines).real)

    random, truth = np.random.default_rng(5), samples(np.zeros(3))
    noisy = truth + NOISE * random.normal(size=(150, time.size))
    fits = [least_squares(lambda logs, y=y: samples(logs) - y, np.zeros(3)).x for y in noisy]
    scatter = np.std(fits, axis=0)[:2]
    np.testing.assert_allclose(predicted, scatter, rtol=0.17)  # of 150 draws: 6 % at one sigma
    alone = Knowledge(told_by(linear.lines(spool_test, (SPOOL,), RATE), instruments, spool_test.compared)).deviations
    assert predicted[0] > 1.1 * alone[0]


def test_the_nonlinear_engine_says_the_same_of_a_small_test() -> None:
    scenario = parse_scenario(
        {
            "duration": 1.0,
            "timestep": 1e-4,
            "control": {
                "kind": "open-loop",
                "signals": [low_peak(0.5, np.arange(5, 40, 4)).scaled(0.02).command(["front-left"])],
            },
        }
    )
    trial = Trial("v", "valves", "", scenario, "periodic", 0.5)
    unknowns = (unknown("machine.mass", 4000.0), unknown("actuators.isolator.flow_gain", 1.94e-6))
    at = {one.name: one.start for one in unknowns}
    channels = ("stroke front-left", "chamber_pressure rear-right 1", "foot_velocity front-left z")
    noise = {"stroke": 1e-9, "chamber_pressure": 100.0, "foot_velocity": 1e-7}
    instruments = Instruments.of(scenario, 1000.0, channels, noise)
    linear = Linear(scenario, unknowns, at).lines(trial, channels, 1000.0)
    nonlinear = run_of(trial, unknowns, at, channels, 1000.0)
    expected = told_by(nonlinear, instruments, trial.compared)
    np.testing.assert_allclose(told_by(linear, instruments, trial.compared), expected, rtol=0.03)


def test_a_floor_is_taken_together_in_bands_and_keeps_its_power() -> None:
    table = {"duration": 8.0, "ground": {"kind": "broadband", "level": "VC-C", "wave": {"speed": 200.0}}}
    found = excitation_of(Trial("floor", "floor", "", parse_scenario(table), "random"), 1000.0)
    assert found.frequency.size <= 300
    motion = parse_scenario(table).motion().sample(np.arange(8000) / 1000.0).velocity
    rows = [found.inputs.index(f"ground_displacement {place}") for place in ("front-left z", "rear-right z")]
    for row, (mount, axis) in zip(rows, ((0, 2), (3, 2)), strict=True):
        power = 0.5 * (np.abs(found.amplitudes[:, row]) ** 2).sum(axis=1) * (2 * np.pi * found.frequency) ** 2
        assert power.sum() == pytest.approx(np.var(motion[:, mount, axis]), rel=0.2)  # a tenth fades at each end


def test_what_is_fitted_beside_takes_its_share() -> None:
    """Regression on x with a constant beside: Σ(x − mean)²; and one that repeats x leaves nothing."""
    x = np.array([1.0, 2.0, 4.0, 9.0])
    slopes = np.column_stack([x, np.ones(4)])
    assert without(slopes.T @ slopes, 1)[0, 0] == pytest.approx(np.sum((x - 4.0) ** 2))
    twice = np.column_stack([x, 3.0 * x])
    assert without(twice.T @ twice, 1)[0, 0] == pytest.approx(0.0, abs=1e-9)


def test_the_sequence_complements_what_is_known() -> None:
    """Two tests of one direction each and a weaker one of both: by hand."""
    tests = [np.diag([99.0, 0.0]), np.diag([0.0, 80.0]), np.diag([8.0, 8.0])]
    known = Knowledge.before(np.ones(2))

    def volume(one: Knowledge) -> float:
        return one.cost("d", [0, 1], np.ones(2))

    assert volume(known.after(tests[0])) == pytest.approx(-0.5 * np.log(100.0) / 2)
    assert best_sequence(known, tests, volume, 2, 0.05) == [0, 1]
    assert best_sequence(known, tests, lambda one: one.cost("a", [1], np.ones(2)), 5, 0.05) == [1]
    assert known.after(tests[0], tests[2]).deviations == pytest.approx([108**-0.5, 9**-0.5])
