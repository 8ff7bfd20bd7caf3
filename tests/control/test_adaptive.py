"""Adaptive cancellation of lines: how far a line comes down, how fast, where it is followed, and when it is not."""

from dataclasses import replace
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from ehamj import Controller, PythonController, parse_scenario, simulate, simulate_many
from ehamj.control.architectures.adaptive import AdaptiveSettings
from ehamj.control.architectures.resonant import ResonantSettings
from ehamj.control.kinds import CombinedSettings
from ehamj.control.law import stack
from ehamj.control.lines import Line
from ehamj.errors import InputError
from ehamj.judge.brief import brief
from ehamj.linear.loop import Loop
from ehamj.linear.machine import linear_model
from ehamj.linear.margins import report
from ehamj.linear.response import rigid_floor
from ehamj.linear.sampled import spectral_radius
from ehamj.result import Result
from ehamj.scenario.model import Scenario

DELAY = 1.5e-4
LINES = (24.5, 49.0)
QUICK: dict[str, Any] = {"time": 0.08, "leak": 2.4, "pace": 0.3}
"""The line comes down to 1/31 = time/(time + leak)."""
GEOPHONE = {"kind": "geophone", "noise": 0.0}


def scenario(duration: float, lines: tuple[float, ...] = LINES, **table: Any) -> Scenario:
    floor = {"kind": "multisine", "frequencies": list(lines), "velocities": [1e-5], "fade_in": 0.02}
    given = {"plates": "tied", "engine": "small-motion", "duration": duration, "record_rate": 2000.0, "ground": floor}
    return parse_scenario(given | table)


def control(lines: tuple[float, ...] = LINES, **changes: Any) -> dict[str, Any]:
    return {"kind": "adaptive", "lines": list(lines), "delay": DELAY, "bits": 52} | QUICK | changes


def heave(run: Result, lines: tuple[float, ...], start: float, stop: float) -> np.ndarray:
    """Amplitude of the machine's heave at each line over a part of a run [m/s]."""
    part = run.dataset["cg_velocity"].sel(axis="z", time=slice(start, stop))
    times = part["time"].values
    waves = [trig(2 * np.pi * f * times) for f in lines for trig in (np.sin, np.cos)]
    basis = np.column_stack([*waves, np.vander(times - times.mean(), 3)])
    fitted = np.linalg.lstsq(basis, part.values, rcond=None)[0]
    return np.hypot(fitted[0 : 2 * len(lines) : 2], fitted[1 : 2 * len(lines) : 2])


@cache
def bare(lines: tuple[float, ...]) -> np.ndarray:
    """Amplitude of the passive machine's heave at each line, linear: the turbulent valve is within 1e-3 of it [m/s]."""
    model = linear_model(scenario(1.0).plant)
    found = [rigid_floor(model, f, None, ("cg_displacement z",), ("z",)).response.item() for f in lines]
    return np.sqrt(2.0) * 1e-5 * np.abs(found)


@cache
def followed(line: float, stop: float, drift: float) -> Result:
    """A run under a law for 24.5 Hz, where the line is another."""
    return simulate(scenario(stop, (line,), control=control(lines=(24.5,), drift=drift)))


def law_of(settings: Any) -> Controller:
    case = scenario(1.0)
    found = settings.controller(case.plant, case.sensors)
    assert isinstance(found, Controller)
    return found


def test_a_line_comes_down_to_what_the_leak_leaves() -> None:
    run = simulate(scenario(1.05, control=control()))
    ratio = heave(run, LINES, 0.8, 1.05) / bare(LINES)
    # 0.8 s, ten times TIME, leave e⁻¹⁰; the lines' skirts touch each other at TIME/(2π·24.5 Hz) of 31, 8e-2 of the
    # rest, in quadrature; the turbulent valve adds 1e-3.
    np.testing.assert_allclose(ratio * 31.0, 1.0, atol=0.05)
    # Where the line is where it is stated, it is not led away: what it is off in all costs less than the leak leaves.
    off = run.dataset["line_frequency"].sel(time=slice(0.8, 1.05)).values - LINES
    assert np.abs(2 * np.pi * off).max() * QUICK["leak"] < 0.3


def test_it_comes_down_by_e_in_its_time() -> None:
    run = simulate(scenario(0.7, control=control(time=0.5, leak=500.0, pace=1.5)))
    ratio = heave(run, LINES, 0.5, 0.7) / bare(LINES)
    # Mean of e^(−t/0.5) over the part; it began while the floor faded in, 0.02 s.
    np.testing.assert_allclose(ratio, 0.5 / 0.2 * (np.exp(-1.0) - np.exp(-1.4)), rtol=0.05)


def test_on_top_of_a_broadband_law_it_takes_that_law_into_account() -> None:
    sensors = {"ground": GEOPHONE, "inertial": GEOPHONE, "stroke": {"noise": 0.0}, "pressure": {"noise": 0.0}}
    own = {key: value for key, value in control().items() if key not in ("delay", "bits")}
    both = {"kind": "combined", "delay": DELAY, "bits": 52, "parts": [{"kind": "feedforward"}, {"kind": "modal"}]}
    runs = []
    for parts in (both["parts"], [*both["parts"], own]):
        runs.append(simulate(scenario(1.05, sensors=sensors, control=both | {"parts": parts})))
    ratio = heave(runs[1], LINES, 0.8, 1.05) / heave(runs[0], LINES, 0.8, 1.05)
    # The broadband law settles at the same time: its slow transients leave some of the line's fit.
    np.testing.assert_allclose(ratio * 31.0, 1.0, atol=0.15)


WRONG = (24.26,)
"""1 % below what is stated."""


def test_a_line_one_percent_off_is_found_and_cancelled_as_one_that_is_known() -> None:
    run, still = followed(WRONG[0], 2.6, 0.02), followed(WRONG[0], 1.6, 0.0)
    left = (heave(run, WRONG, 2.2, 2.6) / bare(WRONG)).item()
    assert left * 31.0 == pytest.approx(1.0, abs=0.05)
    # Six paces leave e⁻⁶ of 0.24 Hz, 6e-4 Hz.
    assert run.dataset["line_frequency"].values[-1].item() == pytest.approx(24.26, abs=3e-3)
    known = (heave(still, WRONG, 1.2, 1.6) / bare(WRONG)).item()
    # |1 + g/(1 + j 2πΔ·leak)|⁻¹, g = 30: what a resonator that stays does there.
    stays = 1.0 / abs(1.0 + 30.0 / (1.0 + 2j * np.pi * 0.24 * QUICK["leak"]))
    assert known == pytest.approx(stays, rel=0.05)
    assert left < 0.3 * known


def test_its_frequency_closes_in_by_e_in_its_pace() -> None:
    time, pace = 0.05, 1.0
    run = simulate(scenario(2.4, WRONG, control=control(lines=(24.5,), pace=pace, time=time)))
    off = run.dataset["line_frequency"].sel(line=24.5) - WRONG[0]
    early, late = (float(off.sel(time=t, method="nearest")) for t in (0.8, 2.3))
    # x, and z behind it, lag by a time each: slowest root of s (1 + time·s)² + 1/pace.
    slowest = max(np.roots([time**2, 2 * time, 1.0, 1.0 / pace]).real)
    assert late / early == pytest.approx(np.exp(1.5 * slowest), rel=0.03)


def test_a_line_outside_its_range_is_followed_to_its_end() -> None:
    run = followed(23.9, 1.2, 0.01)
    found = run.dataset["line_frequency"].values
    assert found[-1].item() == np.float32(24.5 * 0.99)
    assert found.min() == np.float32(24.5 * 0.99)
    assert run.summary.complete


def test_without_drift_it_is_the_resonator_of_that_gain_and_width() -> None:
    time, leak = 0.3, 15.0
    one = law_of(AdaptiveSettings(lines=(24.5,), time=time, leak=leak))
    other = law_of(ResonantSettings(lines=(24.5,), gain=leak / time, bandwidth=1 / (2 * np.pi * 24.5 * leak)))
    for name in "ABCD":
        np.testing.assert_array_equal(getattr(one, name), getattr(other, name))
    runs = [simulate(scenario(0.3), controller=law) for law in (replace(one, lines=()), other)]
    np.testing.assert_array_equal(*(run.dataset["valve_command"].values for run in runs))


def oracle(law: Controller) -> PythonController:
    """The law from its equations, with complex weights in the frame that turns; in Python."""
    T, pi = law.period, np.pi
    ways = [(slice(*line.states.indices(law.states)), line) for line in law.lines]

    class Law:
        def __init__(self) -> None:
            self.x = [np.zeros(line.pairs, complex) for _, line in ways]
            self.z = [np.zeros(line.pairs, complex) for _, line in ways]
            self.f = [line.nominal(law.A, T) for _, line in ways]
            self.wait = [0 for _ in ways]
            self.e: np.ndarray | None = None

        def learn(self, limited: np.ndarray) -> None:
            for k, (own, line) in enumerate(ways):
                rho = abs(complex(law.A[own.start, own.start], law.A[own.start + 1, own.start]))
                stated = line.nominal(law.A, T)
                turn = np.exp(2j * (pi * T * stated + np.arctan(pi * T * (self.f[k] - stated))))
                self.x[k], self.z[k] = rho * turn * self.x[k], turn * self.z[k]
                self.wait[k] = int(np.ceil(1 / (stated * T))) if np.any(limited) else max(self.wait[k] - 1, 0)
                if not self.wait[k]:
                    self.x[k] += (law.B[own][0::2] + 1j * law.B[own][1::2]) @ self.e
                    self.z[k] += (1 - np.exp(-T / line.time)) * (self.x[k] - self.z[k])
                    seen = max(np.sum(abs(self.x[k]) ** 2), 0.25 * np.sum(abs(self.z[k]) ** 2))
                    off = np.sum((self.x[k] * self.z[k].conj()).imag) / seen / line.time if seen else 0.0
                    self.f[k] = min(max(self.f[k] + T / line.pace * off / (2 * pi), line.low), line.high)

        def __call__(self, time: float, measured: np.ndarray, limited: np.ndarray) -> np.ndarray:
            if self.e is not None:
                self.learn(limited)
            self.e = measured.copy()
            state = np.concatenate([np.column_stack([x.real, x.imag]).ravel() for x in self.x])
            return np.asarray(law.C @ state + law.D @ measured)

    return PythonController(Law(), law.inputs, T, law.delay, **{"bits": None, "voltage_limit": law.voltage_limit})


@pytest.mark.parametrize("limit", [10.0, 0.1], ids=["free", "limited at times"])
def test_native_is_the_equations(limit: float) -> None:
    law = replace(law_of(AdaptiveSettings(lines=LINES, delay=DELAY, **QUICK)), bits=None, voltage_limit=limit)
    runs = [simulate(scenario(0.3, (24.3, 49.4)), controller=one) for one in (law, oracle(law))]
    one, other = (run.dataset["valve_command"].values for run in runs)
    assert np.abs(one).max() > 0.099
    # 3,000 samples of sums of a few terms, each rounded to 1e-16 of 1 V.
    np.testing.assert_allclose(one, other, rtol=0.0, atol=1e-12)


def test_on_a_floor_too_strong_for_the_valves_it_stands_still_and_does_not_wind_up() -> None:
    # The line asks for about twice the range; a resonator of the same gain and width asks for far more than it gets.
    limit, asked = 0.08, {}
    stays = {"kind": "resonant", "gain": 30.0, "bandwidth": 1 / (2 * np.pi * 24.5 * QUICK["leak"])}
    other = {"lines": [24.5], "delay": DELAY, "bits": 52} | stays
    for kind, law in (("adaptive", control(lines=(24.5,))), ("resonant", other)):
        case = scenario(1.5, (24.5,), control=law, actuators={"isolator": {"voltage_limit": limit}})
        own = case.control.controller(case.plant, case.sensors)
        run = simulate(case).dataset
        asked[kind] = np.abs(run["controller_state"].values @ own.C.T).max(axis=1)
    last = asked["adaptive"][-500:]
    assert last.max() == pytest.approx(limit, rel=0.1)
    assert asked["resonant"][-500:].max() > 5.0 * limit


def test_while_a_valve_is_limited_nothing_moves_but_what_is_forgotten() -> None:
    shock = {"kind": "shock", "velocity": 5e-3, "pulse_time": 0.2, "begin": 0.3}
    line = {"kind": "multisine", "frequencies": [24.3], "velocities": [1e-5], "fade_in": 0.02}
    parts = [{"kind": "feedforward"}, {k: v for k, v in control(lines=(24.5,)).items() if k not in ("delay", "bits")}]
    law = {"kind": "combined", "delay": DELAY, "bits": 52, "parts": parts}
    run = simulate(scenario(0.6, ground={"kind": "sum", "parts": [line, shock]}, control=law)).dataset
    states = run["controller_state"].values[:, -6:].reshape(-1, 3, 2)
    size, frequency = np.hypot(states[..., 0], states[..., 1])[:, 0], run["line_frequency"].values[:, 0]
    clipped = np.abs(run["valve_command"].values).max(axis=1) >= 10.0 - 1e-6
    steps = np.flatnonzero(clipped & np.roll(clipped, 1) & np.roll(clipped, -1) & np.roll(clipped, 2))
    assert steps.size > 20
    # From row to row, 5 samples: nothing but what is forgotten; rows are single precision.
    np.testing.assert_allclose(size[steps] / size[steps - 1], np.exp(-5e-4 / QUICK["leak"]), rtol=3e-7)
    np.testing.assert_array_equal(frequency[steps], frequency[steps - 1])


def test_while_commands_fade_in_nothing_is_learnt_and_none_jumps() -> None:
    run = simulate(scenario(0.5, control=control(switch_on=0.1, fade=0.1))).dataset
    states = run["controller_state"]
    assert not states.sel(time=slice(0.0, 0.199)).values.any()
    assert states.sel(time=slice(0.21, 0.5)).values.any()
    command = run["valve_command"].values
    # It grows as 1 − e^(−t/time) of an oscillation of at most 49 Hz.
    assert np.abs(np.diff(command, axis=0)).max() < 2 * np.pi * 49.0 * 5e-4 * np.abs(command).max()


def test_lanes_and_one_alone_are_bit_equal_and_engines_agree() -> None:
    cases = [scenario(0.15, (line, 49.0), control=control()) for line in (24.3, 24.5)]
    together = simulate_many(cases)
    for case, found in zip(cases, together, strict=True):
        alone = simulate(case).dataset
        for name in ("valve_command", "line_frequency", "controller_state"):
            np.testing.assert_array_equal(found.dataset[name].values, alone[name].values)
    mujoco = simulate(cases[0].model_copy(update={"engine": "mujoco"})).dataset
    ours = together[0].dataset
    for name in ("valve_command", "line_frequency"):
        np.testing.assert_allclose(
            ours[name].values, mujoco[name].values, atol=1e-4 * np.abs(mujoco[name].values).max()
        )


@pytest.mark.parametrize("mass", [0.7, 1.3])
@pytest.mark.parametrize("end", ["low", "high"])
def test_it_is_stable_at_both_ends_of_its_range_on_another_machine(end: str, mass: float) -> None:
    sensors = {"ground": GEOPHONE, "inertial": GEOPHONE, "stroke": {}, "pressure": {}}
    case = scenario(1.0, sensors=sensors)
    both = CombinedSettings.model_validate(
        {"parts": [{"kind": "modal"}, {"kind": "adaptive", "lines": LINES, "drift": 0.05}], "delay": DELAY}
    )
    law = both.controller(case.plant, case.sensors).turned(end)
    other = scenario(1.0, sensors=sensors, machine={"mass": mass * 4000.0})
    assert spectral_radius(linear_model(other.plant), Loop.of(other, law)) < 1.0


def test_a_file_holds_it_and_a_sum_moves_its_states(tmp_path: Path) -> None:
    law = law_of(AdaptiveSettings(lines=LINES, delay=DELAY))
    law.save(tmp_path / "law.json")
    read = Controller.load(tmp_path / "law.json")
    assert read.lines == law.lines
    assert law.lines[0] == Line(0, 3, 24.5, 24.5 * 0.98, 24.5 * 1.02, 0.3, 1.0)
    assert [line.first for line in stack([law, law]).lines] == [0, 6, 12, 18]


BROKEN = {
    "first": (100, "not among the law's 12"),
    "pairs": (6, "shares states with another line"),
    "low": (24.6, "must hold 24.5 Hz"),
    "high": (5e3, "must be below half the sampling rate, 5000 Hz"),
    "frequency": (24.7, "its states turn with 24.5 Hz"),
    "time": (1e-5, "must be at least a period"),
    "pace": (0.01, "at least that"),
}


@pytest.mark.parametrize("name", BROKEN)
def test_a_line_that_is_not_the_laws_is_refused(name: str) -> None:
    law = law_of(AdaptiveSettings(lines=LINES))
    value, said = BROKEN[name]
    with pytest.raises(InputError, match=said):
        replace(law, lines=(law.lines[1], law.lines[0]._replace(**{name: value})))


def test_states_that_do_not_turn_are_refused() -> None:
    law = law_of(AdaptiveSettings(lines=LINES))
    A = law.A.copy()
    A[0, 5] = 1e-3
    with pytest.raises(InputError, match="must turn in pairs"):
        replace(law, A=A)


REFUSED = {
    "control.lines: 6000 Hz must be below half of control.rate, 5000 Hz": {"lines": [6000.0]},
    "control.motions: the mounts do not drive surge; they drive heave, roll, pitch": {"motions": ["surge"]},
    "both followed where their ranges meet": {"lines": [24.5, 25.0]},
    "24.5 is there twice": {"lines": [24.5, 24.5]},
    "pace = 0.1 s must be at least 3 times time": {"pace": 0.1},
    "time = 0.02 s must be at least a period of each line": {"time": 0.02},
    "leak = 0.01 s must be at least time": {"leak": 0.01},
}


@pytest.mark.parametrize("said", REFUSED)
def test_what_cannot_be_is_refused(said: str) -> None:
    with pytest.raises(InputError, match=said):
        simulate(scenario(0.01, control=control() | REFUSED[said]))


def test_only_the_motions_that_are_named_are_held_still() -> None:
    law = law_of(AdaptiveSettings(lines=LINES, motions=("pitch",)))
    assert law.states == 4
    front, back = law.C[:2], law.C[2:]  # mounts in front, and behind
    np.testing.assert_allclose(front, -back, rtol=1e-12)


def test_margins_count_where_a_line_may_be() -> None:
    """Beside modal feedback a resonator costs phase, the more the nearer its line is to where that loop crosses."""
    case = scenario(1.0, sensors={"ground": GEOPHONE, "inertial": GEOPHONE, "stroke": {}, "pressure": {}})
    parts = [{"kind": "modal"}, {"kind": "adaptive", "lines": [40.0], "drift": 0.2, "time": 0.1, "leak": 1.0}]
    law = CombinedSettings.model_validate({"parts": parts, "delay": DELAY}).controller(case.plant, case.sensors)
    model = linear_model(case.plant)
    still = tuple(line._replace(low=line.frequency, high=line.frequency) for line in law.lines)
    places = [replace(law, lines=still), *(replace(law.turned(end), lines=()) for end in ("low", "high"))]
    disks = [report(model, Loop.of(case, one)).worst[2] for one in places]
    assert max(disks) - min(disks) > 0.02
    assert report(model, Loop.of(case, law)).worst[2] == min(disks)


def test_a_run_says_where_its_lines_ended_and_when_one_left_its_range() -> None:
    found = [followed(WRONG[0], 2.6, 0.02).summary, followed(23.9, 1.2, 0.01).summary]
    inside, outside = (one.followed[0] for one in found)
    assert (inside.stated, inside.low, inside.high) == (24.5, 24.5 * 0.98, 24.5 * 1.02)
    assert inside.found == pytest.approx(24.26, abs=3e-3)
    assert outside.found == pytest.approx(24.5 * 0.99, abs=1e-5)
    said = [[text for text in one.warnings if "end of its range" in text] for one in found]
    assert [len(texts) for texts in said] == [0, 1]
    assert brief(found[0])["lines"] == f"24.5 Hz at {inside.found:.5g} Hz"
