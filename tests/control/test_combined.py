"""Feedforward and modal feedback together in the nonlinear machine: the acceptance case, limits, shocks, one clock."""

import re
import tomllib
from typing import Any

import numpy as np
import pytest
from oracles import linear

from ehamj.control import Controller
from ehamj.control.kinds import CombinedSettings
from ehamj.control.sensors import IDEAL
from ehamj.errors import InputError
from ehamj.plant.mounts import MOUNTS
from ehamj.result import Result
from ehamj.run.simulate import simulate
from ehamj.scenario.load import load_scenario, parse_scenario
from ehamj.scenario.model import Scenario

SENSORS = {"ground": {"kind": "geophone"}, "inertial": {"kind": "geophone"}}
COMBINED: dict[str, Any] = {"kind": "combined", "delay": 1.5e-4}
FROM_FIVE = {
    **COMBINED,
    "parts": [{"kind": "feedforward", "isolate_from": 5.0}, {"kind": "modal", "isolate_from": 5.0}],
}
SUPPLY = 70e5


def floor(level: str | float = "VC-C") -> dict[str, Any]:
    return {"kind": "broadband", "level": level, "wave": {"speed": 200.0, "direction": 0.0}}


def scenario(ground: dict[str, Any], control: dict[str, Any], duration: float = 12.0, **table: Any) -> Scenario:
    # Motion above half the record's rate would fold into the bands: instruments' noise moves the machine at 1 kHz.
    plain = {"plates": "tied", "record_rate": 4000.0, "sensors": SENSORS, "duration": duration}
    return parse_scenario({**plain, "ground": ground, "control": control, **table})


def attenuation(run: Result, dof: str, band: str) -> float:
    value = run.summary["attenuation_db"][dof][band]
    assert value is not None
    return float(value)


def warp_share(run: Result) -> float:
    """Largest load pressure in warp about equilibrium, over the supply's."""
    pressure = run.dataset["chamber_pressure"].values
    load = (pressure[:, :, 0] - pressure[:, :, 1]) @ np.array([1.0, -1.0, -1.0, 1.0]) / 4
    return float(np.abs(load - load[0]).max() / SUPPLY)


# --- the acceptance case ------------------------------------------------------------------------------------------

LEAST = {"5": 56.0, "10": 52.0, "20": 42.0, "50": 26.0, "100": 14.0}
LEAST_WRONG = {"5": 46.0, "10": 42.0, "20": 35.0, "50": 24.0, "100": 12.0}


@pytest.fixture(scope="module")
def accepted() -> Result:
    return simulate(scenario(floor(), COMBINED))


@pytest.fixture(scope="module")
def mismatched() -> Result:
    """The law for the machine as stated on one whose flow gain and oil are both 5 % less (of eight, the worst)."""
    stated = scenario(floor(), COMBINED)
    isolator = stated.actuators["isolator"]
    weak = {name: 0.95 * getattr(isolator, name) for name in ("flow_gain", "bulk_modulus")}
    return simulate(stated.varied({f"actuators.isolator.{name}": value for name, value in weak.items()}))


@pytest.mark.parametrize("band", LEAST)
def test_on_a_vc_c_floor_the_machine_is_quieter_by(band: str, accepted: Result) -> None:
    assert attenuation(accepted, "z", band) >= LEAST[band]
    assert attenuation(accepted, "ry", band) >= LEAST[band] - 3.0


@pytest.mark.parametrize("dof", ["z", "ry"])
def test_no_band_up_to_250_hz_is_amplified_by_3_db(dof: str, accepted: Result) -> None:
    found = {band: v for band, v in accepted.summary["attenuation_db"][dof].items() if v is not None}
    assert min(value for band, value in found.items() if float(band) <= 250.0) >= -3.0


@pytest.mark.parametrize("band", LEAST_WRONG)
def test_with_flow_gain_and_oil_5_percent_wrong_it_is_quieter_by(band: str, mismatched: Result) -> None:
    assert attenuation(mismatched, "z", band) >= LEAST_WRONG[band]


def test_neither_limits_nor_warp_play_a_part_on_a_vc_c_floor(accepted: Result) -> None:
    assert max(accepted.summary["saturation"]["command"].values()) == 0.0
    assert warp_share(accepted) < 0.001


def test_a_run_s_summary_holds_the_margins_of_its_loop(accepted: Result) -> None:
    margins = accepted.summary["margins"]
    assert margins["stable"]
    assert margins["gain_db"] >= 6.0
    assert margins["phase_deg"] >= 45.0
    assert margins["disk"] >= 0.5
    assert set(margins["motions"]) == {"heave", "roll", "pitch", "warp"}


# --- linear theory ------------------------------------------------------------------------------------------------

LINES = (5.0, 20.0, 50.0, 100.0)


def predicted(law: Controller, hertz: float) -> float:
    """Attenuation of heave [dB] by the oracle's linear machine under a law that measures velocities and strokes."""
    s = 2j * np.pi * hertz
    a, b, c, d = linear.state_space(linear.LinearMachine())
    mounts = {name: np.array(at) for name, at in zip(MOUNTS, linear.LinearMachine().mounts, strict=True)}
    inverse = np.linalg.inv(s * np.eye(linear.STATES) - a)
    slab = np.zeros(linear.INPUTS, complex)
    slab[6:16:3], slab[18:28:3] = 1.0, s
    voltage, passive = c @ inverse @ b[:, :4] + d[:, :4], (c @ inverse @ b + d) @ slab

    def reading(name: str, outputs: Any, ground: float) -> Any:
        variable, mount, *axis = name.split(" ")
        if variable == "ground_velocity":
            return ground * s * np.ones(outputs.shape[1:])
        x, y = mounts[mount]
        if variable == "stroke":
            return outputs[16 + MOUNTS.index(mount)]
        if variable == "load_pressure":
            return outputs[12 + MOUNTS.index(mount)]
        rows = {"x": outputs[0] - y * outputs[5], "y": outputs[1] + x * outputs[5],
                "z": outputs[2] + y * outputs[3] - x * outputs[4]}  # fmt: skip
        return s * rows[axis[0]]

    seen = np.array([reading(name, passive, 1.0) for name in law.inputs])
    answers = np.array([reading(name, voltage, 0.0) for name in law.inputs])
    gain = law.response(hertz)[0]
    commands = np.linalg.solve(np.eye(4) - gain @ answers, gain @ seen)
    return float(-20 * np.log10(abs(passive[2] + voltage[2] @ commands)))


@pytest.fixture(scope="module", params=["combined", "modal"])
def tiny(request: pytest.FixtureRequest) -> tuple[Controller, dict[float, float]]:
    """Law and measured attenuation [dB] on a slab that moves by 0.3 µm/s at each of some lines."""
    ground = {"kind": "multisine", "frequencies": LINES, "velocities": [3e-7], "fade_in": 0.5}
    # A finer converter: half a step of 16 bits moves the machine as much as this floor does.
    control = {"kind": request.param, "delay": 1.5e-4, "bits": 48}
    stated = scenario(ground, control, 3.0, sensors={}, record_rate=1000.0)
    law = stated.controller()
    assert isinstance(law, Controller)
    part = simulate(stated).dataset.sel(time=slice(2.0 - 1e-9, None))
    times = part["time"].values
    waves = [trig(2 * np.pi * f * times) for f in LINES for trig in (np.sin, np.cos)]
    basis = np.column_stack([*waves, np.vander(times - 2.5, 4)])  # what the fade left decays slowly
    sizes = []
    for motion in (part["ground_displacement"].values[:, 0, 2], part["cg_displacement"].values[:, 2]):
        found = np.linalg.lstsq(basis, motion - motion.mean(), rcond=None)[0][: 2 * len(LINES)]
        sizes.append(np.hypot(found[::2], found[1::2]))
    return law, dict(zip(LINES, 20 * np.log10(sizes[0] / sizes[1]), strict=True))


@pytest.mark.parametrize("hertz", LINES)
def test_on_a_tiny_floor_linear_theory_is_met(hertz: float, tiny: tuple[Controller, dict[float, float]]) -> None:
    law, measured = tiny
    assert measured[hertz] == pytest.approx(predicted(law, hertz), abs=1.0)


# --- beyond the limits --------------------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def clipped() -> Result:
    return simulate(scenario(floor("VC-A"), COMBINED, 8.0))


@pytest.fixture(scope="module")
def shaped() -> Result:
    return simulate(scenario(floor("VC-A"), FROM_FIVE, 8.0))


def test_a_vc_a_floor_is_clipped_and_still_isolated(clipped: Result) -> None:
    assert 0.01 < max(clipped.summary["saturation"]["command"].values()) < 0.1
    # Measured: 10.9, 13.9 and 16.2 dB; a law that wound up would amplify.
    assert min(attenuation(clipped, "z", band) for band in ("5", "10", "20")) >= 8.0


@pytest.mark.parametrize("band", ["5", "6.3", "8", "10", "12.5", "16", "20"])
def test_isolation_from_5_hz_on_keeps_24_db_on_a_vc_a_floor(band: str, shaped: Result) -> None:
    # Measured from 8 s: 24.5 dB in the lowest band, which begins at 4.5 Hz, and 27 to 28 dB above.
    assert attenuation(shaped, "z", band) >= 24.0
    assert attenuation(shaped, "ry", band) >= 24.0


def test_clipping_makes_no_limit_cycle(clipped: Result, shaped: Result) -> None:
    # The floor asks for 5.9 V RMS without limits, and 3.7 V from 5 Hz on (`ehamj.control.lowend`).
    for run, most in ((clipped, 5.9), (shaped, 4.1)):
        assert float(run.dataset["valve_command"].std("time").max()) < most
        assert warp_share(run) < 0.001


def test_a_shock_is_forgotten_within_half_a_second() -> None:
    """Against the same law on a hundredth of the shock, which nothing limits, a hundred times as large."""
    left = {}
    for peak in (3e-3, 3e-5):
        ground = {"kind": "shock", "velocity": peak, "begin": 0.3, "dof": "z", "return_time": 0.1}
        run = simulate(scenario(ground, {**COMBINED, "bits": 48}, 1.6, sensors={}, record_rate=1000.0))
        if peak == 3e-3:
            assert max(run.summary["saturation"]["command"].values()) > 0.005
            assert warp_share(run) < 0.02
        after = run.dataset["cg_velocity"].sel(axis="z", time=slice(0.82, None))  # the pulse ends at 0.32 s
        left[peak] = float(np.sqrt((after**2).mean())) / peak
    # What was lost decays over 0.15 s: of 3 % e^(−0.5/0.15) is 1e-3, of which the recovery is half.
    assert left[3e-3] < left[3e-5] + 1e-3


# --- one clock ----------------------------------------------------------------------------------------------------


def test_parts_have_the_clock_of_the_whole() -> None:
    settings = CombinedSettings.model_validate({"kind": "combined", "rate": 8000.0, "delay": 2e-4, "bits": 12})
    assert {(part.rate, part.delay, part.bits) for part in settings.members} == {(8000.0, 2e-4, 12)}
    law = settings.controller(parse_scenario({}).plant, IDEAL)
    assert (law.period, law.delay, law.bits) == (1.25e-4, 2e-4, 12)


@pytest.mark.parametrize(
    ("key", "value"), [("rate", 5000.0), ("delay", 3e-4), ("bits", 12), ("switch_on", 0.5), ("fade", 0.1),
                       ("recovery", 0.3)]
)  # fmt: skip
def test_a_part_with_another_clock_is_refused(key: str, value: float) -> None:
    control = {"kind": "combined", "parts": [{"kind": "feedforward", key: value}, {"kind": "modal"}]}
    with pytest.raises(InputError, match=rf"parts\.0\.{key} = {re.escape(str(value))}: must be that of the whole"):
        parse_scenario({"control": control})


def test_parts_that_state_the_clock_of_the_whole_are_fine() -> None:
    control = {"kind": "combined", "rate": 5000.0, "parts": [{"kind": "modal", "rate": 5000.0}]}
    assert parse_scenario({"control": control}).controller() is not None


def test_another_clock_of_the_whole_reaches_its_parts() -> None:
    stated = parse_scenario({})
    whole = CombinedSettings(delay=1e-4)
    later = whole.model_copy(update={"delay": 3e-4}).controller(stated.plant, stated.sensors)
    # The feedforward leads by the delay: another delay is another law, not only a later one.
    direct = CombinedSettings(delay=3e-4).controller(stated.plant, stated.sensors)
    np.testing.assert_array_equal(later.D, direct.D)
    assert later.delay == 3e-4
    assert np.abs(later.D - whole.controller(stated.plant, stated.sensors).D).max() > 0.01 * np.abs(later.D).max()


def test_a_resolved_scenario_takes_another_delay(tmp_path: Any) -> None:
    stated = parse_scenario({"control": {**COMBINED, "parts": [{"kind": "feedforward"}, {"kind": "modal"}]}})
    path = tmp_path / "scenario.toml"
    path.write_text(stated.to_toml(), encoding="utf-8")
    for part in tomllib.loads(path.read_text(encoding="utf-8"))["control"]["parts"]:
        assert not {"rate", "delay", "bits", "switch_on", "fade", "recovery"} & set(part)
    changed = load_scenario(path, ["control.delay=3e-4"])
    assert changed.control == CombinedSettings(delay=3e-4)
    law = changed.controller()
    assert law is not None
    assert law.parts[0].delay == 3e-4


def test_the_commands_of_the_parts_add_up() -> None:
    stated = parse_scenario({"sensors": SENSORS})
    whole = CombinedSettings(delay=1.5e-4)
    law, parts = whole.controller(stated.plant, stated.sensors), whole.members
    found = law.response(17.0)[0]
    total = np.zeros_like(found)
    for part in parts:
        own = part.controller(stated.plant, stated.sensors)
        total[:, [law.inputs.index(name) for name in own.inputs]] += own.response(17.0)[0]
    np.testing.assert_allclose(found, total, rtol=0, atol=1e-9 * np.abs(found).max())


def test_the_resolved_scenario_runs_again_to_the_same_result(tmp_path: Any) -> None:
    stated = scenario(floor(), FROM_FIVE, 0.2)
    path = tmp_path / "scenario.toml"
    path.write_text(stated.to_toml(), encoding="utf-8")
    again = load_scenario(path)
    assert again.control == stated.control
    first, second = (simulate(one).dataset["valve_command"].values for one in (stated, again))
    np.testing.assert_array_equal(first, second)
