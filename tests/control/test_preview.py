"""A sensor upstream: what it reads, what the machine follows with it, what that saves, and what is refused."""

from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from ehamj.control import Controller
from ehamj.control.blocks import response
from ehamj.control.channels import is_upstream
from ehamj.control.inverse import Inverse
from ehamj.control.preview import followed
from ehamj.control.upstream import Upstream
from ehamj.errors import InputError
from ehamj.estimate.bands import bands
from ehamj.ground.broadband import BroadbandGround
from ehamj.linear.loop import Loop, linear_under
from ehamj.linear.response import ground_response
from ehamj.plant.axes import AXES
from ehamj.run.many import simulate_many
from ehamj.run.simulate import simulate
from ehamj.scenario.load import changed, parse_scenario
from ehamj.scenario.model import Scenario

Floats = NDArray[np.float64]

ENGINES = ("mujoco", "small-motion")
SPEED, METRES = 200.0, 20.0
SENSORS = {
    "ground": {"kind": "geophone"},
    "inertial": {"kind": "geophone"},
    "stroke": {},
    "pressure": {},
    "upstream": {"position": [-METRES, 0.0, 0.0], "wave": {"speed": SPEED}},
}
EXACT = {"upstream": SENSORS["upstream"]}


def scenario(**table: Any) -> Scenario:
    ground = {"kind": "sine", "amplitude": 1e-6, "frequency": 8.0, "fade_in": 0.05, "wave": {"speed": SPEED}}
    return parse_scenario({"plates": "tied", "duration": 0.1, "ground": ground, "sensors": SENSORS, **table})


def isolating(kind: str = "combined", begin: float = 5.0) -> dict[str, Any]:
    parts = {"parts": [{"kind": "feedforward", "isolate_from": begin}, {"kind": "modal", "isolate_from": begin}]}
    return {"kind": kind, "delay": 1.5e-4, **(parts if kind == "combined" else {"isolate_from": begin})}


def reading(*channels: str) -> Controller:
    """A law that reads and commands nothing."""
    p = len(channels)
    return Controller(np.zeros((0, 0)), np.zeros((0, p)), np.zeros((4, 0)), np.zeros((4, p)), channels, bits=None)


# --- what it reads ---------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("engine", ENGINES)
@pytest.mark.parametrize("order", [0, 1, 2])
def test_it_reads_the_floor_there_whatever_is_believed(engine: str, order: int) -> None:
    """A sine that passes at 45°, in closed form; what is believed of the wave is another one."""
    way, place = np.array([1.0, 1.0]) / np.sqrt(2.0), np.array([-9.0, -4.0, 0.0])
    wave = {"speed": 150.0, "direction": 45.0}
    ground = {"kind": "sine", "amplitude": 1e-6, "frequency": 8.0, "fade_in": 0.0, "wave": wave}
    sensors = {"upstream": {"position": place.tolist(), "wave": {"speed": 170.0, "direction": 30.0}}}
    name = f"ground_{('displacement', 'velocity', 'acceleration')[order]} upstream z"
    made = scenario(ground=ground, sensors=sensors, engine=engine, record_rate=2000.0)
    law = reading(name)
    run = simulate(made, controller=Controller.from_dict(law.to_dict() | {"from_rest": False}))
    t, omega = run.dataset.time.values, 16.0 * np.pi
    phase = omega * (t - place[:2] @ way / 150.0) + 0.5 * np.pi * order
    expected = 1e-6 * omega**order * np.sin(phase)
    found = run.dataset["measured"].values[:, 0]
    np.testing.assert_allclose(found, expected, rtol=0, atol=1e-12 * 1e-6 * omega**order)


def test_lanes_are_the_machines_alone() -> None:
    """Two floors beside each other, and one floor with sensors at two distances, bit for bit."""
    control = isolating("feedforward")
    wanted = [scenario(control=control, duration=0.03, seed=seed, engine="small-motion") for seed in (0, 1)]
    floors = [{"kind": "broadband", "level": "VC-C", "fade_in": 0.0, "wave": {"speed": speed}} for speed in (200, 190)]
    wanted = [
        parse_scenario(one.model_dump(exclude_none=True) | {"ground": floor})
        for one, floor in zip(wanted, floors, strict=True)
    ]
    wanted.append(changed(wanted[0], {"sensors.upstream.position": [-30.0, 0.0, 0.0]}))
    beside = simulate_many(wanted, threads=1)
    for one, run in zip(wanted, beside, strict=True):
        alone = simulate(one)
        for name in ("valve_command", "measured", "cg_velocity"):
            np.testing.assert_array_equal(run.dataset[name].values, alone.dataset[name].values, err_msg=name)


# --- what the machine follows ----------------------------------------------------------------------------------------


def of_the_floor(metres: float, hertz: Floats, begin: float = 5.0) -> NDArray[np.complex128]:
    """N: what the machine follows below its middle over the floor there."""
    plant = parse_scenario({}).plant
    sensor = Upstream(position=(-metres, 0.0, 0.0), wave={"speed": SPEED})
    weights = np.zeros((1, 4, 3))
    weights[0, :, AXES.index("z")] = 0.25
    names, block = followed(plant, sensor, begin, weights)
    assert names == ("ground_velocity upstream z",)
    s = 2j * np.pi * hertz
    return np.asarray(response(s, *block)[:, 0, 0] * np.exp(s * metres / SPEED))


def volts(metres: float, share: Any = None) -> float:
    """RMS command on a VC-A floor, of what W = 1 − N asks for, or a ``share`` of the floor [V]."""
    f = np.geomspace(0.05, 500.0, 4000)
    inverse = Inverse.of(parse_scenario({}).plant.actuators[0])
    power = np.abs(inverse.volts * (1 + inverse.creep / (2j * np.pi * f))) ** 2
    power = power * BroadbandGround(kind="broadband", level="VC-A").spectrum(f)
    wanted = 1.0 - of_the_floor(metres, f) if share is None else share(f)
    return float(np.sqrt(np.trapezoid(power * np.abs(wanted) ** 2, f)))


@pytest.mark.parametrize("begin", [2.0, 5.0, 12.0])
def test_a_period_ahead_is_enough_for_26_db_and_no_phase(begin: float) -> None:
    """In each third octave from there on; far below all is followed, with little phase (`yielding` has 54°)."""
    metres = 1.0 * SPEED / begin
    for band in bands(begin, 100.0):
        inside = np.geomspace(*band.edges, 50)
        left = np.mean(np.abs(of_the_floor(metres, inside, begin)) ** 2)
        assert 10 * np.log10(left) < -26.0, band.name
    low = of_the_floor(metres, begin * np.geomspace(0.2, 0.4, 20), begin)
    assert np.abs(np.angle(low, deg=True)).max() < 10.0
    np.testing.assert_allclose(np.abs(low), 1.0, rtol=0, atol=0.15)


def test_no_band_is_amplified() -> None:
    for band in bands(0.1, 400.0):
        inside = np.geomspace(*band.edges, 50)
        assert np.mean(np.abs(of_the_floor(METRES, inside)) ** 2) < 1.1, band.name  # 0.4 dB


def test_metres_save_voltage_down_to_what_no_filter_can_save() -> None:
    """With a whole second ahead it would be a filter without causality's bounds: all below the band, nothing above."""
    found = [volts(metres) for metres in (5.0, 10.0, 20.0, 40.0)]
    assert np.all(np.diff(found) < 0.0)
    unlimited = volts(0.0, lambda f: f >= 5.0 * 10**-0.05)
    assert 1.0 < found[-1] / unlimited < 1.15
    assert found[2] < 2.6  # of 10 V: the README's 20 m


@pytest.mark.parametrize("kind", ["combined", "feedforward", "skyhook"])
def test_each_law_follows_the_wave_below_and_holds_still_above(kind: str) -> None:
    """The linear machine under each law in the wave that is believed."""
    made = scenario(control=isolating(kind))
    law = made.controller()
    assert law is not None
    hertz = np.array([1.5, 6.0, 10.0, 16.0])
    moved = ground_response(linear_under(made.plant, law), hertz, ["cg_displacement z"], Loop.of(made, law))[:, 0]
    late = np.exp(-2j * np.pi * hertz[:, None] * np.array(made.plant.positions)[:, 0] / SPEED)
    found = (moved.reshape(len(hertz), -1, 3)[:, :, 2] * late).sum(axis=1)
    assert abs(found[0] - 1.0) < 0.25
    isolated = found[1:2] if kind == "skyhook" else found[1:]  # which by itself reaches little above
    assert np.abs(isolated).max() < 10 ** (-25 / 20)


def test_a_run_is_what_the_linear_machine_says() -> None:
    """Amplitude and phase at 4 Hz of the nonlinear machine: what is taken of the floor upstream is what comes."""
    ground = {"kind": "sine", "amplitude": 1e-7, "frequency": 4.0, "fade_in": 0.2, "wave": {"speed": SPEED}}
    sensors = SENSORS | {"ground": None, "inertial": None}
    quiet = {name: value for name, value in sensors.items() if value is not None} | {
        "stroke": {"noise": 0.0},
        "pressure": {"noise": 0.0},
    }
    control = isolating() | {"bits": 40}
    made = scenario(ground=ground, control=control, sensors=quiet, duration=1.5, engine="small-motion")
    run, law = simulate(made).dataset, made.controller()
    late = run.sel(time=slice(1.0 + 1e-9, 1.5))
    line = np.exp(-8j * np.pi * late.time.values)
    found = 2.0 * np.mean(late["cg_displacement"].values[:, 2] * line)
    places = np.array(made.plant.positions)[:, 0]
    floor = -1j * 1e-7 * np.exp(-8j * np.pi * places / SPEED)
    moved = ground_response(linear_under(made.plant, law), np.array([4.0]), ["cg_displacement z"], Loop.of(made, law))
    expected = moved[0, 0].reshape(-1, 3)[:, 2] @ floor
    assert abs(found - expected) < 0.02 * 1e-7  # what has not yet died away after a second


def test_without_isolate_from_it_is_not_read() -> None:
    alone = {name: value for name, value in SENSORS.items() if name != "upstream"}
    one = scenario(control={"kind": "combined"}).controller()
    other = scenario(control={"kind": "combined"}, sensors=alone).controller()
    assert one is not None
    assert other is not None
    assert one.to_dict() == other.to_dict()


def test_mounts_in_all_directions_follow_in_all_of_them() -> None:
    made = parse_scenario(
        {
            "sensors": SENSORS,
            "control": isolating(),
            "mount": [
                *({"name": f"up-{k}", "position": [x, y]} for k, (x, y) in enumerate([(1, 0.5), (1, -0.5), (-1, 0.0)])),
                *(
                    {"name": f"level-{k}", "position": [x, y, 0.7], "direction": way}
                    for k, (x, y, way) in enumerate([(0.5, 0, [1, 0, 0]), (0.9, 0, [0, 1, 0]), (-0.9, 0, [0, 1, 0])])
                ),
            ],
        }
    )
    law = made.controller()
    assert law is not None
    assert {name for name in law.inputs if is_upstream(name)} == {f"ground_velocity upstream {axis}" for axis in AXES}


# --- what is refused -------------------------------------------------------------------------------------------------


def refused(match: str, **table: Any) -> None:
    with pytest.raises(InputError, match=match):
        scenario(**table).motion()


def test_a_floor_that_comes_from_no_side_is_refused() -> None:
    refused(r"sensors\.upstream: this floor comes from no known side.*ground\.wave", ground={"kind": "sine"})
    refused("no known side", ground={"kind": "broadband", "level": "VC-C", "coherence": {}})


def test_a_resting_floor_has_no_side_to_be_wrong_about() -> None:
    assert scenario(ground={"kind": "rest"}).motion().at_rest


def test_it_must_stand_where_the_wave_comes_from() -> None:
    downstream = {"position": [20.0, 0.0, 0.0], "wave": {"speed": SPEED}}
    refused(r"sensors\.upstream\.position = \[20.*ms after mount rear", sensors={"upstream": downstream})
    between = {"position": [0.0, 0.0, 0.0], "wave": {"speed": SPEED}}
    refused("where the wave comes from", sensors={"upstream": between})


def test_no_mount_may_bear_its_name() -> None:
    mounts = [
        {"name": "upstream" if k == 0 else f"m{k}", "position": [x, y]}
        for k, (x, y) in enumerate([(1.0, 0.5), (1.0, -0.5), (-1.0, 0.0)])
    ]
    refused("mount upstream: bears the name", mount=mounts)


def test_a_law_that_reads_it_needs_one() -> None:
    made = scenario(sensors={}, ground={"kind": "rest"})
    with pytest.raises(InputError, match=r"no sensor stands upstream; state sensors\.upstream"):
        simulate(made, controller=reading("ground_velocity upstream z"))


def test_faults_may_strike_it() -> None:
    made = scenario(
        fault=[{"kind": "sensor-dead", "sensor": "ground_velocity upstream z", "time": 0.05}],
        control=isolating("feedforward"),
        engine="small-motion",
    )
    found = simulate(made).dataset["measured"].sel(sensor="ground_velocity upstream z")
    assert np.any(found.sel(time=slice(0.03, 0.049)).values)
    assert not np.any(found.sel(time=slice(0.051, None)).values)


def test_where_it_stands_and_what_is_believed_in_words() -> None:
    sensor = scenario().sensors.upstream
    assert sensor is not None
    assert sensor.said == "at -20, 0, 0 m, for a wave towards 0° at 200 m/s"
