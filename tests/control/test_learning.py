"""Learning of isolators, compiled, against its equations in NumPy and isolators that are integrated exactly."""

import math
from typing import Any, NamedTuple

import numpy as np
import pytest
import scipy.linalg

from ehamj.arrays import Array
from ehamj.compiled.kept import compiled
from ehamj.control.compiled.learning import LEARNS, USED, Paced
from ehamj.control.compiled.stage import linearised
from ehamj.control.law import Controller
from ehamj.control.learners import STATED, Learner, Learnt
from ehamj.control.learning import Learning
from ehamj.control.linearisation import NOTHING, Linearisation
from ehamj.control.loop import DigitalLoop, make_loop
from ehamj.control.sensors import IDEAL, Sensors
from ehamj.control.stage import Stage, paces_of
from ehamj.control.valves import Known
from ehamj.errors import InputError
from ehamj.plant.plant import Plant
from ehamj.scenario.load import parse_scenario

PERIOD = 1e-4
LAG = 2.0**0.5 / (2.0 * np.pi * 5000.0)  # of the sensors, low-passes of second order [s]
DELAY = 2.0 * PERIOD - LAG  # a command shows two samples later
SENSORS = Sensors.model_validate({"stroke": {}, "pressure": {}})
SUBSTEPS = 10
EDGES = Linearisation(pressure_drop=False, supply="stated")


def plant_of(**isolator: Any) -> Plant:
    return parse_scenario({"actuators": {"isolator": isolator}}).plant


def learners_of(
    learning: Learning, linear: Linearisation | None = None, sensors: Sensors = SENSORS, **isolator: Any
) -> tuple[Learner, ...]:
    """What is known of isolators before anything is learnt."""
    plant = plant_of(**isolator)
    return learning.learners(plant, (linear or NOTHING).known(plant), sensors)


def loop_of(
    learning: Learning, linear: Linearisation | None = None, sensors: Sensors = SENSORS, **isolator: Any
) -> DigitalLoop:
    """A law that wants nothing by itself, with a stage that learns; what is believed of the isolators."""
    plant = plant_of(**isolator)
    learners = learners_of(learning, linear, sensors, **isolator)
    law = Controller(
        np.zeros((0, 0)), np.zeros((0, 0)), np.zeros((4, 0)), np.zeros((4, 0)), (), PERIOD, DELAY,
        valves=(linear or NOTHING).known(plant), learners=learners,
    )  # fmt: skip
    return make_loop(law, plant, PERIOD, sensors)


class Truth(NamedTuple):
    """An isolator under a machine at rest, whose piston moves against the membrane alone; linear but for its edges."""

    spool: tuple[float, ...]
    """The valve's states after a substep, of its states and target."""
    gain: float
    offset: float
    lap: float
    play: float
    leak: float
    """What is left of a stroke after a substep with closed edges."""
    travel: float
    """Stroke that an opening leads to in the end [m/mA]."""
    stiff: float
    """Load pressure per stroke [Pa/m]."""

    @classmethod
    def of(cls, **isolator: Any) -> "Truth":
        """Of an isolator as it is."""
        own = plant_of(**isolator).actuators[0]
        w, step, stiff = own.valve_frequency, PERIOD / SUBSTEPS, own.membrane_stiffness / own.piston_area
        A = np.array([[0.0, 1.0, 0.0], [-(w**2), -2.0 * own.valve_damping * w, w**2], [0.0, 0.0, 0.0]])
        displaced = own.piston_area + own.chamber_volume / (4.0 * own.bulk_modulus) * stiff
        return cls(
            tuple(scipy.linalg.expm(A * step)[:2].ravel()), own.valve_gain, own.null_offset, own.overlap[0],
            own.threshold + 0.5 * own.hysteresis, math.exp(-own.flow_pressure * stiff / displaced * step),
            own.flow_gain / (own.flow_pressure * stiff), stiff,
        )  # fmt: skip


@compiled
def live(totals, shares, noise, truth, laws, memory, readings, found, learnt, lanes):  # type: ignore[no-untyped-def]
    """Isolators whose valves are told what a law wants and its stage adds: readings and what the stage adds at each
    sample, and what it uses after it."""
    place, first = laws.table[-1].held, laws.table[-1].states_at
    spool, rate, edge, stroke = np.zeros(4), np.zeros(4), np.zeros(4), np.zeros(4)
    on_its_way = np.zeros((2, 4))
    for k in range(totals.shape[0]):
        for i in range(4):
            pressure = truth.stiff * stroke[i]
            readings[k, laws.strokes[i]] = stroke[i] + noise[k, i]
            readings[k, laws.pressures[2 * i]] = 3.5e6 + 0.5 * pressure
            readings[k, laws.pressures[2 * i + 1]] = 3.5e6 - 0.5 * pressure
            memory.totals[i] = totals[k, i]
        linearised(shares[k], readings[k], laws, memory, place, lanes)
        for i in range(4):
            found[k, i] = memory.values[place + i]
            target = truth.gain * on_its_way[k % 2, i]
            on_its_way[k % 2, i] = min(max(shares[k] * totals[k, i] + found[k, i], -10.0), 10.0)
            for _ in range(SUBSTEPS):
                before = edge[i]
                x, v, m = spool[i], rate[i], truth.spool
                spool[i], rate[i] = m[0] * x + m[1] * v + m[2] * target, m[3] * x + m[4] * v + m[5] * target
                edge[i] = min(max(edge[i], spool[i] - truth.play), spool[i] + truth.play)
                z = 0.5 * (before + edge[i]) + truth.offset
                opening = math.copysign(max(abs(z) - truth.lap, 0.0), z)
                stroke[i] = truth.leak * stroke[i] + truth.travel * opening * (1.0 - truth.leak)
        for i in range(learnt.shape[1]):
            learnt[k, i] = memory.values[first + i]


class Run(NamedTuple):
    """Of each sample: readings, what the stage adds [V], and what is learnt (mount, `Learnt`)."""

    readings: Array
    added: Array
    learnt: Array


def run(loop: DigitalLoop, truth: Truth, totals: Array, shares: Array | None = None, noise: float = 0.0) -> Run:
    """The isolators' life with a law."""
    count = len(totals)
    readings, added, learnt = (np.zeros((count, n)) for n in (loop.sensing.channels, 4, 4 * USED))
    shares = np.ones(count) if shares is None else shares
    noises = noise * np.random.default_rng(5).normal(size=(count, 4))
    live(totals, shares, noises, truth, loop.laws, loop.law_memory, readings, added, learnt, (0.0,))
    return Run(readings, added, learnt.reshape(count, 4, USED))


def multisine(seconds: float, rms: float = 0.2) -> Array:
    """Lines between 4 and 45 Hz, of other phases for each mount [V], (sample, mount)."""
    draw, hertz = np.random.default_rng(2), np.geomspace(4.0, 45.0, 17)
    time = PERIOD * np.arange(round(seconds / PERIOD))
    phases = draw.uniform(0.0, 2.0 * np.pi, (17, 4))
    lines = np.sin(2.0 * np.pi * hertz[None, :, None] * time[:, None, None] + phases)
    return np.asarray(rms * (2.0 / 17) ** 0.5 * lines.sum(axis=1))


QUICK = Learning(pace=0.1, memory=1.0, prior=1e-6)
OFF = {
    "flow_gain": ({}, {"flow_gain": 1.2 * 1.94e-6}, None, 1.2, 2e-3),
    "compliance": ({}, {"bulk_modulus": 1.4e9 / 1.25}, None, 1.25, 1e-2),
    "null_offset": ({}, {"null_offset": 0.1}, None, 0.1, 2e-3),
    "overlap": ({"overlap": [0.4] * 4}, {"overlap": [0.5] * 4}, EDGES, 0.1, 0.015),
    "play": ({"hysteresis": 0.1}, {"hysteresis": 0.2}, EDGES, 0.05, 0.015),
}
"""What is believed, what is true beside it, what is made good, and what is to be learnt, how well: edges that jump look
as if they had more overlap and play to a law that spreads both over a band and a reversal."""


@pytest.mark.parametrize("name", OFF)
def test_what_is_off_is_learnt(name: str) -> None:
    believed, true, linear, expected, tolerance = OFF[name]
    got = run(loop_of(QUICK, linear, **believed), Truth.of(**{**believed, **true}), multisine(6.0)).learnt[-1]
    k = Learnt._fields.index(name)
    assert abs(expected - STATED[k]) > 3.0 * tolerance
    np.testing.assert_allclose(got[:, k], expected, rtol=0.0, atol=tolerance)


def test_what_is_right_stays() -> None:
    got = run(loop_of(QUICK), Truth.of(), multisine(3.0), noise=1e-10).learnt
    np.testing.assert_allclose(got, np.broadcast_to(STATED, got.shape), rtol=0.0, atol=0.02)
    np.testing.assert_allclose(got[:, :, 0], 1.0, rtol=0.0, atol=1e-3)


def test_pistons_do_what_the_law_wants_once_it_has_learnt() -> None:
    """All off by a fifth: what is left of the error of the strokes is less than a tenth of what it is unlearnt."""
    true = {"overlap": [0.4] * 4, "hysteresis": 0.1, "threshold": 0.04}
    off = {"overlap": [0.32] * 4, "hysteresis": 0.08, "threshold": 0.04, "flow_gain": 1.2 * 1.94e-6}
    off |= {"bulk_modulus": 1.2 * 1.4e9}
    wanted, nothing = multisine(5.0), Learning(flow_gain=0, compliance=0, overlap=0, play=0, null_offset=0)
    cases = ((nothing, off), (nothing, true), (QUICK, true))
    found = [run(loop_of(how, EDGES, **off), Truth.of(**isolator), wanted) for how, isolator in cases]
    ideal, unlearnt, learnt = (one.readings[-10_000:, 0:4] for one in found)
    assert np.abs(found[1].learnt - STATED).max() == 0.0
    assert np.std(learnt - ideal) < 0.1 * np.std(unlearnt - ideal)


def test_nothing_is_learnt_from_noise_whatever_it_starts_with() -> None:
    loop = loop_of(QUICK, flow_gain=1.5 * 1.94e-6)
    loop.law_memory.values[: 4 * USED] = begin = np.tile([1.4, 0.6, 0.0, 0.0, 0.2], 4)
    got = run(loop, Truth.of(), multisine(2.0, rms=1e-4), noise=1e-10).learnt
    np.testing.assert_array_equal(got.reshape(len(got), -1), np.tile(begin, (len(got), 1)))


def test_nothing_is_learnt_within_the_band_of_edges() -> None:
    """Whatever moves there, as a hunt about overlap that is overdone, is no measure of the valve."""
    wanted = multisine(2.0, rms=0.03)  # 0.06 mA
    got = run(loop_of(QUICK, EDGES, overlap=[0.48] * 4), Truth.of(overlap=[0.4] * 4), wanted).learnt
    np.testing.assert_array_equal(got, np.broadcast_to(STATED, got.shape))


def test_nothing_is_learnt_while_commands_are_limited_or_fade() -> None:
    off, wanted = Truth.of(flow_gain=1.3 * 1.94e-6), multisine(3.0)
    shares = np.ones(len(wanted))
    shares[15_000:20_000] = 0.9
    got = run(loop_of(QUICK), off, wanted, shares).learnt[:, :, 0]
    assert np.abs(got[14_999] - 1.3).max() < 0.1  # it had begun
    np.testing.assert_array_equal(got[15_010:29_000], np.tile(got[15_010], (13_990, 1)))  # and until filters settle
    wanted[15_000:15_005] = 25.0
    got = run(loop_of(QUICK), off, wanted).learnt[:, :, 0]
    np.testing.assert_array_equal(got[15_010:24_000], np.tile(got[15_010], (8_990, 1)))


def test_a_dead_valve_leaves_what_is_used_in_its_range_and_without_a_jump() -> None:
    learning = QUICK.model_copy(update={"flow_gain": 0.25})
    got = run(loop_of(learning), Truth.of()._replace(gain=0.0), multisine(3.0), noise=1e-10).learnt
    assert got[-1, :, 0] == pytest.approx(1.0 / 1.25, rel=1e-6)
    assert got[:, :, 0].min() >= 1.0 / 1.25
    assert got[:, :, 1].min() >= 0.5
    assert got[:, :, 1].max() <= 2.0
    assert np.abs(np.diff(got[:, :, 0], axis=0)).max() <= 0.2 * (1.0 - math.exp(-1e-3 / 0.1)) * (1.0 + 1e-9)


class InNumpy:
    """The stage and what it learns, written from the equations: equal overlaps, rated pressure drops."""

    def __init__(self, own: Learner, valve: Known, lags: tuple[float, float]) -> None:
        self.own, self.valve, self.lags = own, valve, lags
        w, tau = valve.valve_frequency, valve.rolloff
        A = np.array([[0.0, 1.0, 0.0], [-(w**2), -2.0 * valve.valve_damping * w, w**2], [0.0, 0.0, 0.0]])
        B = np.array([[0.0, 1.0, 0.0], [-1.0 / tau**2, -2.0 / tau, 1.0 / tau**2], [0.0, 0.0, 0.0]])
        self.spool_step, self.lag_step = (scipy.linalg.expm(M * PERIOD)[:2] for M in (A, B))
        self.spool, self.lag = np.zeros((2, 4)), np.zeros((2, 4))
        self.edge, self.lean, self.slow = np.zeros(4), np.zeros(4), np.zeros(4)
        self.used = np.tile(STATED, (4, 1)).T
        self.every = round(1.0 / (own.rate * PERIOD))
        self.late = round((DELAY + lags[0]) / PERIOD)
        self.rest = DELAY + lags[0] - self.late * PERIOD
        self.histories: list[list[Array]] = [[np.zeros(4)] for _ in range(5)]
        self.bands = np.zeros((5, 4, 4))
        self.power, self.R, self.r = np.zeros(4), np.zeros((4, 4, 4)), np.zeros((4, 4))
        self.frozen = np.full(4, math.ceil(3.0 / (own.low * self.every * PERIOD)))

    def sample(self, total: Array, share: float, strokes: Array, force: Array) -> Array:
        """What it adds to what the law wants [V]."""
        own, valve, tau = self.own, self.valve, self.valve.rolloff
        gain, compliance, overlap, play, offset = self.used
        stiffer = own.stretch * (compliance - 1.0) / (1.0 + own.stretch)
        asked = (total + stiffer * (total - self.slow)) / gain
        lap, lead, null = valve.supply_1 + overlap, valve.play + play, valve.offset + offset
        far = valve.reach - lead
        high, low = ((far + null) - lap) / valve.valve_gain, ((-far + null) + lap) / valve.valve_gain
        applied = np.clip(share * asked, low, high)
        wanted = self.spool[0] + 2.0 * tau * self.spool[1]
        t = np.clip(wanted / valve.band, -1.0, 1.0)
        edge = wanted + lap * 0.5 * t * (3.0 - t**2)
        self.lean = np.clip(self.lean + (edge - self.edge) / valve.reversal, -1.0, 1.0)
        self.edge = edge
        more = share * (edge + lead * self.lean - null - wanted)
        w = valve.valve_frequency
        rate = (more - self.lag[0] - 2.0 * tau * self.lag[1]) / tau**2
        led = self.lag[0] + 2.0 * valve.valve_damping / w * self.lag[1] + rate / w**2
        self._learn(total + (applied - asked) * gain, asked != applied, strokes, force, lap)
        self.spool = self.spool_step @ np.array([*self.spool, valve.valve_gain * applied])
        self.lag = self.lag_step @ np.array([*self.lag, more])
        return np.asarray(led / valve.valve_gain + share * (asked - total))

    def _learn(self, got: Array, limited: Array, strokes: Array, force: Array, lap: Array) -> None:
        y = self.spool[0]
        t = np.clip(y / self.valve.band, -1.0, 1.0)
        slopes = -0.5 * t * (3.0 - t**2), -self.lean / (1.0 + 1.5 * lap * (1.0 - t**2) / self.valve.band)
        for history, now in zip(self.histories, (y, *slopes, force, strokes), strict=True):
            history.append(now)
        self.slow = self.slow + (1.0 - math.exp(-self.own.creep * PERIOD)) * (got - self.slow)
        self.frozen = np.where(limited, math.ceil(3.0 / (self.own.low * self.every * PERIOD)), self.frozen)
        if (len(self.histories[0]) - 1) % self.every == 0:
            self._block()

    def _mean(self, history: list[Array], back: int, early: float) -> Array:
        """Trapezoidal mean over a block that ends some samples ago, and ends earlier still by a time [s]."""
        ends = len(history) - back
        part = np.array([np.zeros(4)] * self.every + history)[ends - 1 : ends + self.every]
        rise = (part[-1] - part[0]) / (self.every * PERIOD)
        return np.asarray((part[:-1] + part[1:]).sum(axis=0) / (2.0 * self.every) - early * rise)

    def _block(self) -> None:
        own, T = self.own, self.every * PERIOD
        gain, compliance, overlap, play, _ = self.used
        y, by_overlap, by_play, force, strokes = self.histories
        early = (self.rest, self.rest, self.rest + 2.0 * self.valve.rolloff)
        flow, o, p = (self._mean(one, self.late, by) for one, by in zip((y, by_overlap, by_play), early, strict=True))
        early_force = self.lags[0] - self.lags[1]
        ends = ([np.zeros(4)] * self.every + force)[-1 :: -self.every][:3]  # now, a block ago, and two
        rises = np.array([ends[1] - ends[2], ends[0] - ends[1]])
        pressed = own.oil * (rises[1] + (rises[0] - rises[1]) * early_force / T) / T / own.flow
        moved = own.area * (strokes[-1] - strokes[-1 - self.every]) / T / own.flow
        taken = moved + pressed + own.leak * self._mean(force, 0, early_force) / own.flow
        phi = []
        for k, now in enumerate((flow - o * overlap - p * play, o, p, -pressed, taken)):
            for j in range(4):
                share = 1.0 - math.exp(-2.0 * math.pi * (own.low if j < 2 else own.high) * T)
                self.bands[k, j] += share * (now - self.bands[k, j])
                now = now - self.bands[k, j] if j < 2 else self.bands[k, j]
            phi.append(now)
        self.power += (1.0 - math.exp(-T)) * (phi[0] ** 2 - self.power)
        learns = (self.frozen <= 0) & (self.power >= own.least**2)
        self.frozen = self.frozen - (self.frozen > 0)
        left = taken - gain * flow + (compliance - 1.0) * pressed
        for i in np.flatnonzero(learns):
            self._observe(i, np.array(phi)[:, i], left[i])

    def _observe(self, i: int, phi: Array, left: float) -> None:
        own, T = self.own, self.every * PERIOD
        m = T / (self.power[i] + own.least**2)
        self.R[i] = math.exp(-T / own.memory) * self.R[i] + m * np.outer(phi[:4], phi[:4])
        self.r[i] = math.exp(-T / own.memory) * self.r[i] + m * phi[:4] * phi[4]
        ranges = np.array([own.most_gain - 1.0, own.most_overlap, own.most_play, own.most_compliance - 1.0])
        prior = own.prior / ranges**2
        theta = np.linalg.solve(self.R[i] + np.diag(prior), self.r[i] + prior * [1.0, 0.0, 0.0, 0.0])
        gain = np.clip(theta[0], own.least_gain, own.most_gain)
        found = np.array([gain, 1.0 + theta[3], theta[1] / gain, theta[2] / gain])
        found = np.clip(found, own.ranges[0:8:2], own.ranges[1:8:2])
        follow = 1.0 - math.exp(-T / own.pace)
        before = self.used[0, i]
        self.used[:4, i] += follow * (found - self.used[:4, i])
        self.used[4, i] = np.clip(self.used[4, i] + 0.1 * follow * left / before, own.least_offset, own.most_offset)


@pytest.mark.parametrize("corner", [5000.0, 500.0])
def test_compiled_learning_is_that_of_its_equations(corner: float) -> None:
    """In 1e-12 of a volt per sample: the sums of blocks and the elimination are done in another order."""
    belief = {"overlap": [0.3] * 4, "hysteresis": 0.1, "null_offset": 0.02}
    learning = Learning(band=(20.0, 200.0), pace=0.1, memory=0.2)
    sensors = Sensors.model_validate({"stroke": {"high": corner}, "pressure": {}})
    loop = loop_of(learning, EDGES, sensors, **belief)
    truth = Truth.of(**{**belief, "overlap": [0.36] * 4, "flow_gain": 2.2e-6, "null_offset": 0.05})
    wanted = multisine(0.4, rms=0.5)
    wanted[1000:1003] = 30.0
    shares = np.minimum(np.arange(len(wanted)) / 500.0, 1.0)
    got = run(loop, truth, wanted, shares, noise=1e-10)
    plant = plant_of(**belief)
    lags = LAG * 5000.0 / corner, LAG
    twin = InNumpy(learners_of(learning, EDGES, sensors, **belief)[0], EDGES.known(plant)[0].numbers, lags)
    area, laws = plant.actuators[0].piston_area, loop.laws
    at = got.readings
    force = area * (at[:, laws.pressures[0:8:2]] - at[:, laws.pressures[1:8:2]])
    worst = np.zeros(2)
    for k in range(len(wanted)):
        added = twin.sample(wanted[k], shares[k], at[k, laws.strokes], force[k])
        worst = np.maximum(worst, [np.abs(added - got.added[k]).max(), np.abs(twin.used.T - got.learnt[k]).max()])
    assert np.abs(got.learnt[-1] - STATED).max(axis=0).min() > 1e-3  # all were learnt
    assert worst[0] < 1e-12


SHARES = {"overlap": [0.4] * 4, "hysteresis": 0.1, "threshold": 0.04}


def test_what_is_known_of_edges_is_what_may_be_unlearnt() -> None:
    """A share of the overlap may go to zero, and what is not known is not learnt: the range is that of what changes."""
    half = Linearisation(pressure_drop=False, supply="stated", overlap=0.5, hysteresis=0.0, threshold=0.0)
    learning = Learning(overlap=0.3, play=0.1, least=2e-3)
    got = learners_of(learning, half, **SHARES)[0]
    assert (got.least_overlap, got.most_overlap) == (-0.2, 0.3)
    assert (got.least_play, got.most_play) == (0.0, 0.0)
    assert got.least == half.band


def test_edges_that_are_not_made_good_are_not_learnt() -> None:
    none = Linearisation(pressure_drop=False, supply="stated", overlap=0.0, hysteresis=0.0, threshold=0.0)
    got = learners_of(Learning(least=2e-3), none, **SHARES)[0]
    assert got.ranges[4:8] == (0.0, 0.0, 0.0, 0.0)
    assert got.least == 2e-3
    play = none.model_copy(update={"hysteresis": 1.0})
    got = learners_of(Learning(least=2e-3), play, **SHARES)[0]
    assert got.ranges[4:8] == (0.0, 0.0, -0.05, 0.1)
    assert got.least == play.band


def paces(period: float, sensors: Sensors = SENSORS) -> Paced:
    """How a law of a period learns that waits one."""
    numbers = paces_of(learners_of(Learning(), None, sensors), NOTHING.known(plant_of()), Stage(period, period))
    return Paced._make(numbers.reshape(4, -1)[0, LEARNS:])


def test_a_block_holds_what_the_valve_was_told_for_it_however_slowly_a_law_samples() -> None:
    """A tone at the end of the band, told at 1000 Hz: the mean over the block that shows it, within 3 %."""
    pace, hertz, period = paces(1e-3), 60.0, 1e-3
    T, ahead = pace.block, 1e-3 + LAG
    ends = np.arange(200) * T

    def tone(time: Array) -> Array:
        return np.asarray(np.exp(2j * np.pi * hertz * time))

    at = ends[:, None] - (pace.late + np.arange(pace.every + 1.0)) * period
    told = tone(at)
    mean = 0.5 * (told[:, 1:] + told[:, :-1]).mean(axis=1) - pace.rest / T * (told[:, 0] - told[:, -1])
    exact = (tone(ends - ahead) - tone(ends - ahead - T)) / (2j * np.pi * hertz * T)
    assert np.abs(mean / exact - 1.0).max() < 0.03
    assert pace.late < pace.every


def test_a_band_beyond_what_a_slow_law_can_balance_is_refused() -> None:
    control = {"rate": 400.0, "learning": {"band": [3.0, 60.0]}}
    with pytest.raises(InputError, match=r"control\.learning\.band.*60 Hz.*control\.rate = 400 Hz"):
        parse_scenario({"control": {"kind": "feedforward", **control}}).controller()
    control["learning"] = {"band": [3.0, 30.0]}
    assert parse_scenario({"control": {"kind": "feedforward", **control}}).controller() is not None


@pytest.mark.parametrize(
    ("wrong", "said"),
    [
        ({"low": 60.0, "high": 3.0}, r"low = 60 Hz and high = 3 Hz must rise"),
        ({"high": 250.0}, r"high = 250 Hz.*a quarter of rate = 1000 Hz"),
        ({"creep": -1.0}, r"creep = -1 must be zero or positive"),
        ({"leak": -1e-12}, r"leak = -1e-12 must be zero or positive"),
        ({"stretch": -0.1}, r"stretch = -0.1 must be zero or positive"),
        ({"stroke_lag": -1e-3}, r"stroke_lag = -0.001 must be zero or positive"),
    ],
)
def test_a_law_s_file_that_cannot_learn_is_refused_by_name(wrong: dict[str, float], said: str) -> None:
    good = learners_of(Learning())[0]
    assert Learner.from_dict(good.to_dict()) == good
    with pytest.raises(InputError, match=said):
        Learner.from_dict({**good.to_dict(), **wrong})


def test_a_law_learns_with_the_lags_of_the_sensors_that_it_is_held_for() -> None:
    held = {"sensors": {"stroke": {"high": 500.0}, "pressure": {"high": 1000.0}}}
    control = {"kind": "feedforward", "learning": {}, "designed_for": held}
    scenario = parse_scenario({"sensors": {"stroke": {}, "pressure": {}}, "control": control})
    law = scenario.controller()
    assert isinstance(law, Controller)
    for one in Controller.from_dict(law.to_dict()).learners:
        assert one.stroke_lag == pytest.approx(2.0**0.5 / (2.0 * np.pi * 500.0))
        assert one.pressure_lag == pytest.approx(2.0**0.5 / (2.0 * np.pi * 1000.0))
    loops = [make_loop(law, scenario.plant, PERIOD, sensors) for sensors in (scenario.sensors, IDEAL)]
    np.testing.assert_array_equal(loops[0].laws.learners, loops[1].laws.learners)


def test_nothing_is_learnt_while_the_lead_of_what_is_added_is_limited() -> None:
    """A step across the overlap whose lead goes beyond the converter, though what the law itself wants never does: of
    the mounts whose edges it takes across, and of no other."""
    wanted, edges = multisine(3.0), {"overlap": [0.4] * 4}
    wanted[15_000:15_005] = 8.5
    got = run(loop_of(QUICK, EDGES, **edges), Truth.of(**edges, flow_gain=0.9 * 1.94e-6), wanted)
    beyond = np.abs(wanted + got.added) > 10.0
    assert not beyond[:15_000].any()
    limited, gain = beyond.any(axis=0), got.learnt[:, :, 0]
    assert limited.any()
    assert not limited.all()
    assert np.abs(gain[14_999] - 0.9).max() < 0.02
    still = (gain[15_020:24_000] == gain[15_020]).all(axis=0)
    np.testing.assert_array_equal(still, limited)


@pytest.mark.parametrize(("key", "most"), [("flow_gain", 4), ("compliance", 9)])
def test_what_may_be_learnt_is_of_the_same_order(key: str, most: int) -> None:
    Learning(**{key: float(most)})
    with pytest.raises(ValueError, match=f"less than or equal to {most}"):
        Learning(**{key: 50.0})
