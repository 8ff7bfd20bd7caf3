"""What a virtual logger writes: each of its flaws by itself, against numbers that are known beforehand."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from ehamj.errors import InputError
from ehamj.records.choices import Choices
from ehamj.records.readers import READERS
from ehamj.rig.logger import Logged, Tap, logged
from ehamj.run.simulate import Observed, observed
from ehamj.scenario.load import parse_scenario

SINE = {"kind": "sine", "amplitude": 0.2, "frequency": 40.0}
BLOW = {"kind": "hammer", "peak": -1000.0, "pulse_time": 0.01, "begin": 0.02, "direction": [0.0, 3.0, 4.0]}


@pytest.fixture(scope="module")
def run() -> Observed:
    """Valves that swing, and a blow."""
    table = {"duration": 0.2, "record_rate": 4000.0, "force": [BLOW]}
    return observed(parse_scenario({**table, "control": {"kind": "open-loop", "signals": [SINE]}}))


def of(run: Observed, rate: float | None = None, seed: int = 1, **told: Any) -> Logged:
    return logged(run, [Tap(**({"channel": "valve_command front-left", "name": "U", "bits": None} | told))], rate, seed)


def exact(time: np.ndarray) -> np.ndarray:
    return np.asarray(0.2 * np.sin(2 * np.pi * 40.0 * time))


def test_without_flaws_it_is_what_was_commanded(run: Observed) -> None:
    found = of(run, 2000.0)
    assert found.rate == 2000.0
    assert found.samples.shape == (401, 1)
    assert found.units == ("V",)
    np.testing.assert_allclose(found["U"], exact(found.time), atol=1e-12)


def test_force_is_along_its_direction(run: Observed) -> None:
    blow = of(run, channel="force 0", unit="N")
    np.testing.assert_allclose(blow["U"][80:121], -1000.0 * np.sin(np.pi * np.arange(41) / 40), atol=1e-6)
    assert not blow["U"][:80].any()
    assert not blow["U"][122:].any()


def test_gain_offset_and_delay_of_a_sensor(run: Observed) -> None:
    found = of(run, gain=-1.1, offset=0.03, delay=0.00123)
    inside = slice(20, None)
    wanted = -1.1 * exact(found.time - 0.00123) + 0.03
    np.testing.assert_allclose(found["U"][inside], wanted[inside], atol=1e-6)
    late = of(run, drift=0.01)
    np.testing.assert_allclose(late["U"], exact(0.99 * late.time), atol=1e-6)


def test_noise_is_a_share_of_the_channels_swing_and_another_by_seed_and_name(run: Observed) -> None:
    noises = [of(run, noise=0.1, seed=seed, name=name)[name] for seed, name in ((1, "U"), (2, "U"), (1, "V"))]
    errors = np.array([noisy - exact(np.arange(801) / 4000.0) for noisy in noises])
    swing = 0.2 / np.sqrt(2)
    np.testing.assert_allclose(errors.std(axis=1), 0.1 * swing, rtol=0.1)  # of 801 samples ± 2.5 %
    assert np.abs(np.corrcoef(errors) - np.eye(3)).max() < 0.15
    again = of(run, noise=0.1, seed=1)["U"]
    assert again.tobytes() == noises[0].tobytes()


def test_a_converter_rounds_and_clips(run: Observed) -> None:
    found = of(run, bits=8, full_scale=0.15)["U"]
    steps = found / (0.15 / 128)
    np.testing.assert_allclose(steps, np.round(steps), atol=1e-9)
    assert found.max() == pytest.approx(127 / 128 * 0.15)
    assert found.min() == -0.15
    inside = np.abs(exact(np.arange(801) / 4000.0)) < 0.149
    assert np.abs(found - exact(np.arange(801) / 4000.0))[inside].max() <= 0.5 * 0.15 / 128 + 1e-12


def test_a_dead_wire_has_the_last_bit_alone(run: Observed) -> None:
    found = of(run, bits=16, full_scale=10.0, noise=0.1, dead=True)["U"]
    assert 0.0 < np.abs(found).max() <= 10.0 / 2**15


def test_what_it_writes_is_read_back_with_its_units(run: Observed, tmp_path: Path) -> None:
    taps = [
        Tap(channel="foot_velocity front-left z", name="V1", unit="mm/s", bits=None),
        Tap(channel="foot_velocity front-right z", name="V2", head="mm/s", bits=None),
    ]
    found = logged(run, taps)
    choices = Choices(axes={"V1": "x", "V2": "y"})
    record = READERS["table"].read(found.save(tmp_path / "floor.csv"), choices)
    own = run.dataset["foot_velocity"].sel(axis="z").values
    np.testing.assert_allclose(found["V1"], 1e3 * own[:, 0], rtol=1e-12)
    np.testing.assert_allclose(found["V2"], own[:, 1], rtol=1e-12)
    assert found.units == ("mm/s", "mm/s")
    by_axis = {one.axis: one for one in record.channels}
    np.testing.assert_allclose(by_axis["x"].samples, own[:, 0], rtol=1e-8, atol=1e-15)
    np.testing.assert_allclose(by_axis["y"].samples, 1e-3 * own[:, 1], rtol=1e-8, atol=1e-15)


@pytest.mark.parametrize(
    ("told", "said"),
    [
        ({"channel": "valve_comand front-left"}, "none that a run has"),
        ({"channel": "stroke middle"}, "'stroke middle' is none of this run"),
        ({"channel": "force 1"}, "the run has 1 forces"),
        ({"unit": "mm"}, "U: unit = 'mm' is none of what the channel is measured in, such as V"),
        ({"unit": "elephant"}, "'elephant' is not a unit"),
        ({"bits": 1}, "bits = 1 must be from 2 to 32"),
        ({"full_scale": 0.0}, "full_scale = 0 must be positive"),
        ({"rate": 3000.0}, "rate = 3000 Hz: must be record_rate = 4000 Hz over a whole number"),
    ],
)
def test_what_cannot_be_is_refused(run: Observed, told: dict[str, Any], said: str) -> None:
    with pytest.raises(InputError, match=said.replace("(", r"\(")):
        of(run, **told)
