"""Spool feedback: against plain Python written from its equations, against closed forms, and on machines."""

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from oracles.stage import in_python
from oracles.stepped import STEP, run, together

from ehamj.arrays import Array
from ehamj.control import Controller, ControllerBank, PythonController, blocks
from ehamj.control.instruments import SpoolSensor
from ehamj.control.linearisation import Linearisation
from ehamj.control.loop import make_loop, stacked
from ehamj.control.sensors import IDEAL, Sensors
from ehamj.control.spool_feedback import SpoolFeedback
from ehamj.control.spools import KnownSpool, followed, opened
from ehamj.errors import InputError
from ehamj.judge.brief import brief
from ehamj.linear.loop import linear_under
from ehamj.linear.machine import linear_model
from ehamj.plant.plant import Plant
from ehamj.run.simulate import simulate
from ehamj.scenario.load import parse_scenario

ENGINES = ("mujoco", "small-motion")
REAL: dict[str, Any] = {"hysteresis": 0.1, "threshold": 0.04}
WIDTH = 8


def plant_of(**valve: Any) -> Plant:
    return parse_scenario({"actuators": {"isolator": valve}}).plant


def law_of(spools: tuple[KnownSpool, ...], seed: int = 0, *, gain: float = 1.0, **own: Any) -> Controller:
    """A law of one state from the ground's velocities to some volts."""
    draw = np.random.default_rng(seed).uniform
    inputs = tuple(f"ground_velocity {mount} z" for mount in plant_of().mounts)
    kept = {"bits": None, "voltage_limit": 8.0, **own, "spools": spools}
    B, C, D = draw(0.1, 0.4, (1, 4)), draw(-0.1, 0.1, (4, 1)), gain * draw(0.2, 1.0, (4, 4))
    return Controller(np.diag([0.98]), B, C, D, inputs, STEP, **kept).with_anti_windup(0.01)


def signals_of(law: Any, plant: Plant, seed: int, steps: int) -> tuple[Array, Array]:
    """Signals in which all that is read moves, and the readings of them."""
    draw = np.random.default_rng(seed).uniform
    sensing = make_loop(law, plant, STEP).sensing
    signals = np.zeros((steps, sensing.layout.size))
    for row, name in zip(sensing.terms[:, 0], law.reads, strict=True):
        middle, size = (3.5e6, 1e6) if "pressure" in name else (0.0, 1.0)
        signals[:, row] = middle + size * np.sin(draw(0.05, 0.4) * np.arange(steps) + draw(0, 6))
    return signals, signals[:, sensing.terms[:, 0]]


def both(law: Any, plant: Plant, seed: int, steps: int = 40) -> tuple[Array, Array]:
    """Native commands at the start of every step (step, valve), and those of plain Python."""
    signals, readings = signals_of(law, plant, seed, steps)
    native = run(make_loop(law, plant, STEP), signals, np.zeros((steps, readings.shape[1])))[:, :4]
    return native, in_python(law, readings)


loops = st.fixed_dictionaries(
    {
        "rate": st.sampled_from([10_000.0, 5_000.0, 2_500.0]), "delay": st.sampled_from([0.0, 1e-4, 1.5e-4, None]),
        "crossing": st.floats(5, 40), "rolloff": st.floats(2e-4, 1e-3), "limit": st.floats(0.05, 2.0),
        "position": st.sampled_from(["edges", "spool"]),
    }
)  # fmt: skip


@settings(max_examples=12, deadline=None)
@given(loops, st.floats(0.3, 1.2), st.sampled_from([1e6, 5.42e6]), st.floats(0.5, 8), st.integers(0, 1000))
def test_commands_are_those_of_plain_python(own: Any, damping: float, drive: float, gain: float, seed: int) -> None:
    """Within their ranges and at them: of the loop, the converter and the spool's drive."""
    plant = plant_of(valve_damping=damping, spool_drive_limit=drive)
    native, python = both(
        law_of(SpoolFeedback(**own).known(plant, Sensors(spool=SpoolSensor())), seed, gain=gain), plant, seed
    )
    np.testing.assert_allclose(native, python, rtol=0, atol=1e-12)


def test_they_are_so_of_two_laws_and_a_stage_that_fade_in() -> None:
    plant = plant_of(overlap=(0.4, 0.3, 0.5, 0.2), **REAL)
    common = {"switch_on": 5e-4, "fade": 2e-3, "valves": Linearisation().known(plant)}
    spools = SpoolFeedback(rate=5_000.0, crossing=20.0).known(plant, IDEAL)
    fast = law_of(spools, 1, **common)
    slow = replace(law_of(spools, 2, **common), period=4 * STEP, delay=2.5e-4)
    native, python = both(ControllerBank.combine([fast, slow]), plant, 3, 60)
    assert abs(native).max() > 0.1
    np.testing.assert_allclose(native, python, rtol=0, atol=1e-12)


def test_lanes_are_each_machine_alone_bit_for_bit() -> None:
    plants = [plant_of(valve_damping=0.4 + 0.1 * k) for k in range(WIDTH)]
    laws = [law_of(SpoolFeedback(rate=5_000.0, crossing=10.0 + k).known(p, IDEAL), 7) for k, p in enumerate(plants)]
    given_ = [signals_of(law, plant, k, 40)[0] for k, (law, plant) in enumerate(zip(laws, plants, strict=True))]
    each = [make_loop(law, plant, STEP) for law, plant in zip(laws, plants, strict=True)]
    nothing = np.zeros((40, len(laws[0].reads)))
    found = run(stacked(each), together(given_), np.zeros((40, len(laws[0].reads) * WIDTH)), WIDTH)
    for lane, loop in enumerate(each):
        np.testing.assert_array_equal(found.reshape(40, 16, WIDTH)[:, :, lane], run(loop, given_[lane], nothing))


# --- the loop ---------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("delay", [0.0, 2e-5, 5e-5, 8e-5])
def test_the_loop_crosses_where_it_says(delay: float) -> None:
    """L = ω_c/s with the delays of hold, roll-off, sensor and computation; exact but for terms in (f/2 kHz)²: 4 %."""
    (own, *_) = SpoolFeedback(crossing=100.0, delay=delay).known(plant_of(), Sensors(spool=SpoolSensor()))
    hertz = np.array([20.0, 50.0, 100.0])
    loop = blocks.response(np.exp(2j * np.pi * hertz * own.period), *opened(own, SpoolSensor()))[:, 0, 0]
    q = np.exp(-own.period / own.rolloff)
    # The sampled valve is 1.5 samples late behind its inverse; a sum that has its newest term is half a sample early.
    late = delay + own.lag + own.period * (1.5 - 0.5 + 2 * q / (1 - q))
    np.testing.assert_allclose(loop, 100.0 / (1j * hertz) * np.exp(-2j * np.pi * hertz * late), rtol=0.04)


def test_a_loop_that_swings_up_is_refused_with_what_helps() -> None:
    with pytest.raises(InputError, match=r"spool_feedback.crossing = 2000 Hz.*unstable.*lower it, shorten rolloff"):
        SpoolFeedback(crossing=2000.0).known(plant_of(), Sensors(spool=SpoolSensor()))


# --- machines -------------------------------------------------------------------------------------------------------


BELIEVED = {"actuators": {"isolator": {"valve_gain": 2.0, "valve_damping": 0.65, "threshold": 0.0, "hysteresis": 0.0}}}


def flow_under(valve: dict[str, Any], control: dict[str, Any], **own: Any) -> Array:
    """Flow into chamber 1 of every mount over the second half of 0.2 s [m³/s], of valves whose law believes them ideal
    and feeds the floor's 10 Hz forward: it commands the same whatever the machine does."""
    table = {
        "duration": 0.2, "engine": "small-motion", "timestep": 5e-5, "record_rate": 5000, "plates": "tied",
        "ground": {"kind": "sine", "frequency": 10.0, "amplitude": 1e-6}, "sensors": {"spool": {}},
        "control": {"kind": "feedforward", "bits": 40, "fade": 0.05, "designed_for": BELIEVED, **control},
        "actuators": {"isolator": valve}, **own,
    }  # fmt: skip
    flow = simulate(parse_scenario(table)).dataset["chamber_flow"].values[..., 0]
    return np.asarray(flow[len(flow) // 2 :])


@pytest.fixture(scope="module")
def ideal() -> Array:
    return flow_under({}, {})


def off(flow: Array, ideal: Array) -> float:
    """RMS of what differs, over that of an ideal valve's flow, both about their means: leakage flows always."""
    return float(np.std(flow - ideal) / np.std(ideal))


WRONG: dict[str, dict[str, Any]] = {
    "threshold": {"threshold": 0.04},
    "hysteresis": {"hysteresis": 0.1},
    "gain": {"valve_gain": 1.8},
    "damping": {"valve_damping": 1.2},
}


@pytest.mark.parametrize("valve", WRONG.values(), ids=WRONG)
def test_what_the_law_does_not_know_of_the_spool_is_taken_back(valve: dict[str, Any], ideal: Array) -> None:
    without, fed = (off(flow_under(valve, {"spool_feedback": on}), ideal) for on in (False, True))
    assert without > 0.03
    assert fed < 0.25 * without  # at 10 Hz a loop that crosses at 300 Hz leaves 1/30; play is all harmonics


def test_play_behind_what_the_sensor_shows_is_not(ideal: Array) -> None:
    control = {"spool_feedback": {"position": "spool"}}
    assert off(flow_under(WRONG["hysteresis"], control), ideal) > 0.8 * off(flow_under(WRONG["hysteresis"], {}), ideal)
    assert off(flow_under(WRONG["threshold"], control), ideal) < 0.25 * off(flow_under(WRONG["threshold"], {}), ideal)


def test_an_ideal_valve_that_is_measured_exactly_is_left_alone(ideal: Array) -> None:
    """The reference is exact for what is held; what is left is the integrator's error of the fourth order."""
    assert off(flow_under({}, {"spool_feedback": True}, sensors={}), ideal) < 1e-6


def test_a_sensor_with_a_lag_and_noise_moves_a_good_valve_little(ideal: Array) -> None:
    assert 1e-7 < off(flow_under({}, {"spool_feedback": True}), ideal) < 0.01


def test_switched_off_the_law_is_that_without() -> None:
    laws = [
        parse_scenario({"control": {"kind": "combined", **own}}).controller() for own in ({}, {"spool_feedback": False})
    ]
    assert laws[0].to_dict() == laws[1].to_dict()
    assert laws[0].reads == laws[0].inputs


@pytest.mark.parametrize("plates", ["sliding", "tied"])
def test_both_engines_agree(plates: str) -> None:
    """As far as small motion goes: of noise and play too."""
    own = {"duration": 0.02, "plates": plates, "sensors": {"spool": {}}}
    table = {"control": {"kind": "combined", "spool_feedback": True}, "actuators": {"isolator": REAL}, **own}
    table |= {"ground": {"kind": "sine", "frequency": 20.0, "amplitude": 1e-6}, "compare": []}
    found = [simulate(parse_scenario({**table, "engine": engine})).dataset["spool"].values for engine in ENGINES]
    np.testing.assert_allclose(found[0], found[1], rtol=0, atol=1e-3 * abs(found[0]).max())


@pytest.mark.parametrize("engine", ENGINES)
def test_the_edges_that_are_read_trail_the_spool_by_its_play(engine: str) -> None:
    """As read in every step, of which each is where the edges stood before, moved no more than the play pushes them."""
    seen: list[Array] = []

    def law(_time: float, readings: Array, _lost: Array) -> Array:
        seen.append(readings.copy())
        return np.full(4, 0.3 * np.sin(0.05 * len(seen)))

    inputs = ("spool front-left", "edges front-left", "spool rear-right", "edges rear-right")
    table = {"duration": 0.03, "timestep": STEP, "plates": "tied", "engine": engine, "record_rate": 1000}
    scenario = parse_scenario({**table, "actuators": {"isolator": {"hysteresis": 0.2}}})
    simulate(scenario, controller=PythonController(law, inputs, STEP))
    for spool, edges in (np.transpose(seen)[:2], np.transpose(seen)[2:]):
        before = np.concatenate([[edges[0]], edges[:-1]])
        np.testing.assert_allclose(edges, np.clip(before, spool - 0.1, spool + 0.1), rtol=0, atol=1e-12)
        assert np.ptp(edges) > 0.5


def test_a_run_says_what_the_loops_have_in_hand() -> None:
    """Of the valve as it is: 1.25 times the gain that the law believes is 1.94 dB less in hand."""
    found = []
    for gain in (2.0, 2.5):
        table = {
            "duration": 0.01, "record_rate": 1000, "engine": "small-motion", "plates": "tied", "sensors": {"spool": {}},
            "control": {"kind": "feedforward", "spool_feedback": True, "designed_for": BELIEVED},
            "actuators": {"isolator": {"valve_gain": gain}},
        }  # fmt: skip
        summary = simulate(parse_scenario(table)).summary
        assert summary.spools is not None
        assert summary.spools.gain_db is not None
        assert f"gain {summary.spools.gain_db:.1f} dB" in brief(summary)["spool feedback"]
        found.append(summary.spools.gain_db)
    assert found[0] - found[1] == pytest.approx(20.0 * np.log10(1.25), abs=1e-3)  # interpolated over 400 frequencies
    assert found[0] > 10.0


def test_a_run_says_that_a_loop_is_unstable_with_the_valves_as_they_are() -> None:
    table = {
        "duration": 0.01, "record_rate": 1000, "engine": "small-motion", "plates": "tied", "sensors": {"spool": {}},
        "control": {"kind": "feedforward", "spool_feedback": True, "designed_for": BELIEVED},
        "actuators": {"isolator": {"valve_gain": 12.0}},
    }  # fmt: skip
    summary = simulate(parse_scenario(table)).summary
    assert summary.spools is None
    assert any("the loop about the spool is unstable with the valves of front-left" in one for one in summary.warnings)


@pytest.mark.parametrize(("position", "play"), [("edges", 0.0), ("spool", 0.05)])
def test_linearisation_leaves_to_it_what_it_takes_back(position: str, play: float) -> None:
    control = {"kind": "combined", "linearisation": True, "spool_feedback": {"position": position}}
    scenario = parse_scenario({"control": control, "actuators": {"isolator": REAL}})
    assert scenario.controller().converter.valves[0].numbers.play == pytest.approx(play)


def test_the_linear_machine_is_that_of_valves_that_follow() -> None:
    """Stronger, sticking valves, whose play takes away any slope."""
    known = SpoolFeedback().known(plant_of(), IDEAL)
    plant = plant_of(valve_gain=2.4, **REAL)
    found, ideal = linear_under(plant, law_of(known)), linear_model(plant_of())
    np.testing.assert_array_equal(found.A, ideal.A)
    np.testing.assert_array_equal(found.B, ideal.B)


def test_a_mount_that_does_not_obey_is_not_fed_back() -> None:
    plant = plant_of()
    plant = replace(plant, actuators=(plant.actuators[0].with_values({"passive": True}), *plant.actuators[1:]))
    known = SpoolFeedback().known(plant, IDEAL)
    assert [spool.crossing > 0.0 for spool in known] == [False, True, True, True]
    assert followed(plant, known) == plant


def test_a_law_keeps_in_its_file_how_spools_are_fed_back(tmp_path: Path) -> None:
    law = law_of(SpoolFeedback(delay=2e-5).known(plant_of(), Sensors(spool=SpoolSensor())))
    law.save(tmp_path / "law.json")
    assert Controller.load(tmp_path / "law.json").spools == law.spools


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"limit": 0.0}, "limit = 0 must be finite and positive"),
        ({"delay": -1.0}, "delay = -1 must be finite and zero or positive"),
        ({"crossing": float("nan")}, "crossing = nan must be finite"),
        ({"period": "soon"}, "must be a number"),
        ({"more": 1.0}, "each must be a table of valve_gain"),
    ],
)
def test_what_is_known_of_a_spool_is_whole_or_refused(change: dict[str, Any], message: str) -> None:
    own = SpoolFeedback().known(plant_of(), IDEAL)[0].to_dict()
    with pytest.raises(InputError, match=rf"controller\.spools.*{message}"):
        KnownSpool.from_dict({**own, **change})


def test_spools_of_two_clocks_are_refused() -> None:
    known = SpoolFeedback().known(plant_of(), IDEAL)
    with pytest.raises(InputError, match=r"controller.spools: period or delay differs"):
        law_of((*known[:3], known[3]._replace(period=1e-4)))


def test_a_step_that_does_not_divide_its_period_is_refused() -> None:
    table = {"timestep": 1e-4, "duration": 0.01, "control": {"kind": "combined", "spool_feedback": True}}
    with pytest.raises(InputError, match=r"must divide the period of control.spool_feedback = 5e-05 s"):
        simulate(parse_scenario(table))
