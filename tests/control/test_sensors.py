"""Sensors: their spectra, filters, grids and axes, and that the compiled ones do what SciPy's do."""

import math
from typing import Any

import numpy as np
import pytest
from scipy import signal
from scipy.interpolate import BarycentricInterpolator
from scipy.linalg import expm

from ehamj.control import Controller, PythonController
from ehamj.control.instruments import NOISE, Accelerometer, Geophone, PressureSensor, discretise, randomness
from ehamj.control.noise import Heard, ReadingNoise
from ehamj.control.sensors import Sensors
from ehamj.errors import InputError
from ehamj.run.simulate import simulate
from ehamj.scenario.load import parse_scenario
from ehamj.scenario.model import Scenario

RATE = 10_000.0
GEOPHONE = {"kind": "geophone"}
FLOOR = {"kind": "multisine", "frequencies": [7.0, 31.0, 83.0], "velocities": [2e-5], "wave": {"speed": 150.0}}


def reads(*channels: str, **settings: Any) -> Controller:
    """A law that reads channels and commands nothing."""
    p = len(channels)
    return Controller(np.zeros((0, 0)), np.zeros((0, p)), np.zeros((4, 0)), np.zeros((4, p)), channels, **settings)


def scenario(**table: Any) -> Scenario:
    return parse_scenario({"plates": "tied", "duration": 0.2, "record_rate": 1e4, "ground": FLOOR, **table})


# --- noise --------------------------------------------------------------------------------------------------------


def noise_of(sensor: Geophone, seconds: float, channel: str = "cg_velocity z", seed: int = 0) -> np.ndarray:
    made = ReadingNoise((channel,), Sensors(inertial=sensor), seed, 1.0 / RATE)
    return made.take(round(seconds * RATE))[:, 0]


def test_the_noise_has_its_density_above_the_corner_and_rises_as_one_over_f_below() -> None:
    # 3 nm/s/√Hz above 1 Hz, rising as 1/f below; typed from the benchmark, with the corner rounded as √(1 + 1/f²).
    found = noise_of(Geophone(kind="geophone", low=0.01, high=np.inf), 400.0)
    hertz, power = signal.welch(found, RATE, nperseg=2**19, detrend="linear")
    for low, high in ((0.08, 0.25), (0.25, 0.7), (0.7, 1.5), (1.5, 5.0), (5.0, 50.0), (50.0, 4900.0)):
        band = (hertz >= low) & (hertz < high)
        expected = 9e-18 * (1.0 + 1.0 / hertz[band] ** 2)
        averages = 14 * band.sum() / 2  # segments of half overlap times lines, of which a Hann window binds two
        # Four standard deviations of the mean ratio.
        assert np.mean(power[band] / expected) == pytest.approx(1.0, abs=4.0 / np.sqrt(averages)), (low, high)


def test_the_noise_leaves_through_the_low_pass() -> None:
    sensor = Geophone(kind="geophone", low=0.01)
    hertz, power = signal.welch(noise_of(sensor, 60.0), RATE, nperseg=2**12)
    for low, high in ((50.0, 200.0), (450.0, 550.0), (970.0, 1030.0)):
        band = (hertz >= low) & (hertz < high)
        # Half the power at 1 kHz; the bilinear low-pass is steeper beyond. 290 averages of at least 24 lines.
        expected = 9e-18 / (1.0 + (hertz[band] / 1000.0) ** 4)
        assert np.mean(power[band] / expected) == pytest.approx(1.0, abs=0.06), (low, high)
        np.testing.assert_allclose(sensor.noise_density(hertz[band]) ** 2, expected, rtol=1e-3)
    beyond = (hertz > 2900.0) & (hertz < 3100.0)
    assert np.mean(power[beyond]) < 9e-18 / (1.0 + 3.0**4)


def test_below_the_pass_band_the_noise_stays_bounded() -> None:
    sensor = Geophone(kind="geophone", noise=1.0, noise_corner=100.0, low=10.0, high=np.inf)
    # White to 5 kHz, and 1/f noise that ends at 10 Hz: n²·f_n²·π/(2·f_l); correlated over 16 ms, so 3 % in 30 s.
    assert np.var(noise_of(sensor, 30.0)) == pytest.approx(5000.0 + 100.0**2 * np.pi / 20.0, rel=0.1)


def test_noise_does_not_depend_on_the_lengths_in_which_it_is_taken() -> None:
    sensors = Sensors(inertial=Geophone(kind="geophone", random_walk=1e-6, drift=1e-5))
    channels = ("cg_velocity z", "foot_velocity rear-left z")
    whole = ReadingNoise(channels, sensors, 3, 1e-4).take(1000)
    made = ReadingNoise(channels, sensors, 3, 1e-4)
    np.testing.assert_array_equal(np.vstack([made.take(n) for n in (1, 0, 399, 600)]), whole)


def test_noise_that_was_heard_before_is_the_noise_itself(monkeypatch: pytest.MonkeyPatch) -> None:
    """Of three runs one after the other: the last one hears what there was no room for, behind what there was."""
    channels = ("cg_velocity x", "cg_velocity z")
    sensors = Sensors(inertial=Geophone(kind="geophone", random_walk=1e-6))
    whole = ReadingNoise(channels, sensors, 3, 1e-4).take(5000)
    monkeypatch.setattr("ehamj.control.noise.ROOM", 16 * 3100)
    heard = Heard()
    for _ in range(3):
        noise = ReadingNoise(channels, sensors, 3, 1e-4)
        parts = [heard.take(noise, *part) for part in ((0, 1000), (1000, 2000), (3000, 1500), (4500, 500))]
        np.testing.assert_array_equal(np.concatenate(parts), whole)
    other = ReadingNoise(channels, sensors, 4, 1e-4)
    assert not np.array_equal(heard.take(other, 0, 1000), whole[:1000])


def test_the_noise_is_what_scipys_filters_make_of_the_channels_random_numbers() -> None:
    """To the bit: a seed promises its numbers. White and rising noise through the low-pass, walk and drift beside;
    one channel is silent."""
    period, name = 1e-4, "ground_velocity rear-left z"
    noisy = Geophone(
        kind="geophone", noise=2e-9, noise_corner=3.0, low=0.4, high=800.0, order=3, drift=1e-7, random_walk=1e-8
    )
    silent = Geophone(kind="geophone", noise=0.0)
    made = ReadingNoise(("cg_velocity z", name), Sensors(inertial=silent, ground=noisy), 5, period)
    found = np.vstack([made.take(n) for n in (700, 300)])
    random = randomness(5, name, NOISE)
    sign, decay = float(random.choice((-1.0, 1.0))), math.exp(-2.0 * np.pi * 0.4 * period)
    kick = 2e-9 * 3.0 * 2.0 * np.pi * math.sqrt(0.5 * period)
    slow = kick / math.sqrt(1.0 - decay**2) * random.standard_normal()
    white, rising, steps = random.standard_normal((1000, 3)).T
    rising, _ = signal.lfilter([1.0], [1.0, -decay], kick * rising, zi=[decay * slow])
    sections = signal.butter(3, 2.0 * 800.0 * period, output="sos")
    electronic = signal.sosfilt(sections, 2e-9 * math.sqrt(0.5 / period) * white + rising)
    walk = np.cumsum(1e-8 * math.sqrt(period) * steps)
    np.testing.assert_array_equal(found[:, 1], electronic + walk + sign * 1e-7 * (np.arange(1000) * period))
    assert not found[:, 0].any()


def test_channels_are_independent_and_seeds_differ_and_repeat() -> None:
    sensor = Geophone(kind="geophone", noise_corner=0.0)
    one = noise_of(sensor, 10.0)
    others = [noise_of(sensor, 10.0, "cg_velocity x"), noise_of(sensor, 10.0, seed=1)]
    for other in others:
        assert abs(np.corrcoef(one, other)[0, 1]) < 4.0 / np.sqrt(one.size)
    np.testing.assert_array_equal(noise_of(sensor, 10.0), one)


def test_the_noise_of_a_channel_does_not_depend_on_its_neighbours() -> None:
    sensors = Sensors(inertial=Geophone(kind="geophone"))
    both = ReadingNoise(("cg_velocity x", "cg_velocity z"), sensors, 0, 1e-4).take(100)
    np.testing.assert_array_equal(both[:, 1], ReadingNoise(("cg_velocity z",), sensors, 0, 1e-4).take(100)[:, 0])


def test_a_drift_is_steady_and_a_walk_spreads_with_the_root_of_time() -> None:
    quiet = {"kind": "geophone", "noise": 0.0}
    drift = noise_of(Geophone(**quiet, drift=1e-6), 2.0)
    np.testing.assert_allclose(np.abs(drift), 1e-6 * np.arange(drift.size) / RATE, rtol=1e-12, atol=1e-20)
    names = tuple(f"ground_velocity {m} {a}" for m in ("front-left", "rear-right") for a in "xyz")
    walks = [
        ReadingNoise(names, Sensors(ground=Geophone(**quiet, random_walk=1e-6)), seed, 1e-4).take(10_000)[[99, 9999]]
        for seed in range(40)
    ]
    spread = np.std(np.concatenate(walks, axis=1), axis=1)
    # 240 walks: the spread is known to 4.6 %; three of these.
    np.testing.assert_allclose(spread, [1e-7, 1e-6], rtol=0.15)


# --- filters ------------------------------------------------------------------------------------------------------


def test_the_response_is_butterworths() -> None:
    sensor = Geophone(kind="geophone", low=0.1, high=1000.0)
    f = np.array([0.02, 0.1, 1.0, 100.0, 1000.0, 3000.0])
    size = (f / 0.1) ** 2 / np.sqrt(1 + (f / 0.1) ** 4) / np.sqrt(1 + (f / 1000.0) ** 4)
    np.testing.assert_allclose(np.abs(sensor.response(f)), size, rtol=1e-12)
    # Second order, ζ = 1/√2: −90° at the upper corner, +90° at the lower.
    assert np.degrees(np.angle(sensor.response(0.1))) == pytest.approx(90.0, abs=0.01)
    assert np.degrees(np.angle(sensor.response(1000.0))) == pytest.approx(-90.0, abs=0.02)


@pytest.mark.parametrize("settings", [{}, {"order": 1}, {"order": 4, "low": 0.02}, {"low": 0.0}, {"high": np.inf}])
def test_the_state_space_has_the_response(settings: dict[str, Any]) -> None:
    sensor = Geophone(kind="geophone", **settings)
    A, B, C, D = sensor.block()
    for f in (0.01, 0.3, 100.0, 2500.0):
        found = C @ np.linalg.solve(2j * np.pi * f * np.eye(A.shape[0]) - A, B) + D
        assert found.item() == pytest.approx(complex(sensor.response(f)), rel=1e-9)


@pytest.mark.parametrize("step", [1e-4, 5e-5, 1 / 3000])
def test_between_steps_its_response_is_right_to_fourth_order(step: float) -> None:
    sensor = Geophone(kind="geophone")
    A, B, C, D, _ = discretise(sensor, step)
    for f in (1.0, 10.0, 100.0, 200.0):
        z = np.exp(2j * np.pi * f * step)
        ratio = (C @ np.linalg.solve(z * np.eye(A.shape[0]) - A, B) + D) / sensor.response(f)
        # The cubic through the last four values misses the integral over a step by 19/720 of the fourth difference, as
        # Adams's and Moulton's formula; a corner at a third of the rate makes it a twelfth more, and the next term is
        # smaller by 2πf·step. 1e-10: the solution near z = 1.
        turn = 2.0 * np.pi * f * step
        assert abs(ratio - 1.0) < 19.0 / 720.0 * turn**4 * (1.1 + 1.5 * turn) + 1e-10


def test_a_pass_band_of_nothing_is_refused() -> None:
    with pytest.raises(InputError, match=r"^sensors\.ground.*low = 10 Hz must be below high = 5 Hz"):
        parse_scenario({"sensors": {"ground": {"kind": "geophone", "low": 10.0, "high": 5.0}}})


# --- in a simulation ----------------------------------------------------------------------------------------------

CHANNELS = (
    *("ground_velocity front-left z", "foot_velocity rear-right x", "cg_velocity z"),
    *("stroke front-right", "chamber_pressure rear-left 1", "load_pressure front-left", "spool rear-left"),
)
TABLE: dict[str, Any] = {
    "ground": {**GEOPHONE, "noise": 0.0},
    "inertial": {**GEOPHONE, "low": 0.5, "order": 3, "noise": 0.0},
    "stroke": {"low": 0.2, "high": 800.0, "noise": 0.0},
    "pressure": {"high": 500.0, "order": 1, "noise": 0.0},
}


def through_cubics(sensor: Any, u: np.ndarray, before: float, step: float) -> np.ndarray:
    """What SciPy's analog filter makes of an input that stood before and is in each step the cubic through the last
    four values: by Gauss's quadrature of the convolution."""
    zeros, poles, gain = np.zeros(0), np.zeros(0), 1.0
    for kind, corner in (("highpass", sensor.low), ("lowpass", sensor.high)):
        if corner > 0:
            own = signal.butter(sensor.order, 2 * np.pi * corner, kind, analog=True, output="zpk")
            zeros, poles, gain = np.append(zeros, own[0]), np.append(poles, own[1]), gain * own[2]
    A, B, C, D = signal.zpk2ss(zeros, poles, gain)
    places, weights = np.polynomial.legendre.leggauss(16)
    past = np.concatenate([np.full(3, before), u])
    x, found = np.zeros(len(A)), [float(D[0, 0]) * u[0]]
    passed = [expm(A * step * (1.0 - place) / 2.0) @ B[:, 0] * step / 2.0 for place in places] * weights[:, None]
    lastly = np.lib.stride_tricks.sliding_window_view(past[1:], 4)
    within = BarycentricInterpolator([-2.0, -1.0, 0.0, 1.0], lastly.T)
    cubics = within((1.0 + places) / 2.0)
    over = expm(A * step)
    for k in range(1, u.size):
        x = over @ x + np.transpose(passed) @ cubics[:, k - 1]
        found.append(float(C[0] @ x + D[0, 0] * u[k]))
    return np.array(found)


@pytest.mark.parametrize("plates", ["tied", "sliding"])
def test_compiled_filters_do_what_scipy_does_with_cubics_through_the_last_four_values(plates: str) -> None:
    case = scenario(plates=plates, sensors=TABLE)
    found = simulate(case, controller=reads(*CHANNELS)).dataset
    time = found.time.values
    pressure = found["chamber_pressure"]
    exact = {
        CHANNELS[0]: found["ground_velocity"].sel(mount="front-left", axis="z"),
        CHANNELS[3]: found["stroke"].sel(mount="front-right"),
        CHANNELS[4]: pressure.sel(mount="rear-left", chamber=1),
        CHANNELS[5]: pressure.sel(mount="front-left", chamber=1) - pressure.sel(mount="front-left", chamber=2),
        CHANNELS[6]: found["spool"].sel(mount="rear-left"),
    }
    for name, channel in exact.items():
        u, sensor = channel.values, case.sensors.of(name)
        expected = u
        if sensor is not None:
            rest = u[0] if sensor.measures != "velocity" else 0.0
            expected = through_cubics(sensor, u - rest, u[0] - rest, time[1]) + rest * (sensor.low == 0.0)
        # SciPy's companion form of corners 5000 apart is good to some 1e-9.
        np.testing.assert_allclose(
            found["measured"].sel(sensor=name), expected, rtol=0, atol=1e-8 * np.abs(u).max(), err_msg=name
        )


def test_readings_are_limited_and_rounded() -> None:
    table = {"ground": {**GEOPHONE, "range": 1e-5, "resolution": 1e-6}}
    read = simulate(scenario(sensors=table), controller=reads("ground_velocity rear-left z")).dataset["measured"].values
    np.testing.assert_allclose((read.min(), read.max()), (-1e-5, 1e-5), rtol=1e-15)
    np.testing.assert_allclose(read / 1e-6, np.round(read / 1e-6), rtol=0, atol=1e-9)
    assert np.unique(np.round(read / 1e-6)).size == 21


def test_noise_reaches_the_readings_sample_by_sample() -> None:
    name = "ground_velocity rear-left z"
    table = {"ground": {**GEOPHONE, "low": 0.0, "high": np.inf}}
    case = scenario(sensors=table, ground={"kind": "rest"}, seed=5, record_rate=5e3)
    read = simulate(case, controller=reads(name, period=2e-4)).dataset["measured"].values[:, 0]
    expected = ReadingNoise((name,), case.sensors, 5, 2e-4).take(read.size)[:, 0]
    np.testing.assert_array_equal(read, expected)
    assert np.std(read) > 0


def test_a_function_and_the_law_read_the_same_noisy_limited_tilted_sensors() -> None:
    names = ("ground_velocity front-left z", "stroke rear-right", "load_pressure front-right", "cg_velocity x")
    table = {
        "ground": {**GEOPHONE, "misalignment": 3.0, "resolution": 1e-8},
        "inertial": {**GEOPHONE, "range": 1e-5, "drift": 1e-7},
        "stroke": {"noise": 1e-9},
        "pressure": {"random_walk": 1e3},
    }
    D = np.random.default_rng(0).normal(size=(4, 4)) * [3e3, 1e4, 1e-7, 1e3]
    law = Controller(np.zeros((0, 0)), np.zeros((0, 4)), np.zeros((4, 0)), D, names, bits=None)
    function = PythonController(lambda time, measured, limited: D @ measured, names, bits=None)
    native, python = (
        simulate(scenario(sensors=table, seed=9), controller=one).dataset["valve_command"].values
        for one in (law, function)
    )
    assert np.abs(native).max() > 0.05
    np.testing.assert_allclose(python, native, rtol=0, atol=1e-12)


def test_a_tilted_sensor_reads_the_other_axes_by_the_sine_of_its_angle() -> None:
    def shares(channel: str, misalignment: float) -> np.ndarray:
        table = {"ground": {**GEOPHONE, "misalignment": misalignment, "noise": 0.0, "low": 0.0, "high": np.inf}}
        found = []
        for dof in "xyz":
            floor = {"kind": "sine", "dof": dof, "amplitude": 1e-6, "frequency": 40.0}
            run = simulate(scenario(duration=0.05, sensors=table, ground=floor), controller=reads(channel)).dataset
            moved = run["ground_velocity"].sel(mount="front-left", axis=dof).values
            found.append(float(run["measured"].values[:, 0] @ moved / (moved @ moved)))
        return np.array(found)

    x, y, z = shares("ground_velocity front-left z", 2.0)
    assert z == pytest.approx(np.cos(np.radians(2.0)), rel=1e-12)
    assert np.hypot(x, y) == pytest.approx(np.sin(np.radians(2.0)), rel=1e-12)
    np.testing.assert_allclose(shares("ground_velocity front-left z", 0.0), [0.0, 0.0, 1.0], rtol=0, atol=1e-15)


@pytest.mark.parametrize(
    ("table", "channel", "message"),
    [
        (
            {"inertial": GEOPHONE},
            "foot_displacement front-left z",
            r"channel 'foot_displacement front-left z': \[sensors\.inertial\] is of kind 'geophone' and measures "
            r"velocity; read 'foot_velocity front-left z' instead",
        ),
        (
            {"ground": {"kind": "accelerometer"}},
            "ground_velocity rear-left z",
            "read 'ground_acceleration rear-left z'",
        ),
        ({"inertial": {"kind": "displacement"}}, "cg_acceleration z", "read 'cg_displacement z' instead"),
        ({"inertial": GEOPHONE}, "machine_displacement rx", "read 'machine_velocity rx' instead"),
        ({"stroke": {}}, "stroke_velocity rear-left", r"measures displacement; read 'stroke rear-left' instead"),
    ],
)
def test_another_quantity_than_the_sensor_measures_is_refused(table: Any, channel: str, message: str) -> None:
    with pytest.raises(InputError, match=message):
        simulate(scenario(sensors=table), controller=reads(channel))


@pytest.mark.parametrize(
    ("table", "message"),
    [
        ({"ground": {"kind": "seismometer"}}, r"^sensors\.ground\.kind = 'seismometer': must be one of 'geophone'"),
        ({"ground": {"noise": 1e-9}}, r"^sensors\.ground\.kind: is missing"),
        ({"pressure": {"misalignment": 1.0}}, r"^sensors\.pressure\.misalignment = 1\.0: unknown key"),
        ({"stroke": {"noise": -1.0}}, r"^sensors\.stroke\.noise = -1\.0: "),
        ({"inertial": {**GEOPHONE, "range": 1e-6, "resolution": 1e-3}}, "resolution = 0.001 must not be larger than"),
        ({"feet": GEOPHONE}, r"^sensors\.feet = .*unknown key; .*allowed: ground, inertial, stroke, pressure"),
    ],
)
def test_a_bad_table_is_refused(table: Any, message: str) -> None:
    with pytest.raises(InputError, match=message):
        parse_scenario({"sensors": table})


def test_a_resolved_scenario_with_sensors_runs_again_to_the_last_bit() -> None:
    import tomllib

    case = scenario(sensors={"ground": GEOPHONE, "pressure": {"resolution": 100.0}, "stroke": {}}, seed=4)
    again = parse_scenario(tomllib.loads(case.to_toml()))
    law = reads("ground_velocity front-left z", "chamber_pressure front-left 2", "stroke rear-left")
    assert simulate(again, controller=law).dataset.equals(simulate(case, controller=law).dataset)


def test_every_kind_measures_its_own_quantity() -> None:
    assert [kind.measures for kind in (Geophone, Accelerometer, PressureSensor)] == [
        "velocity",
        "acceleration",
        "pressure",
    ]
