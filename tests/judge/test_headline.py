"""The headline: by the worst of the places, with margin, band and scatter; no class that undecided bands may undo."""

from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy import signal

from ehamj.criteria.settings import CriteriaSettings
from ehamj.criteria.vc import CLASSES, CLASSIC, FLAT
from ehamj.estimate.bands import bands
from ehamj.judge import isolation
from ehamj.judge.isolation import Isolation
from ehamj.judge.levels import levels_of
from ehamj.judge.scatter import scatter
from ehamj.plant.mounts import MOUNTS
from ehamj.result import make_dataset
from ehamj.scenario.load import parse_scenario

RATE = 500.0
TIMES = np.arange(10001) / RATE
PLANT = parse_scenario({}).plant
X, Y, Z = range(3)


def line(frequency: float, rms: float) -> Any:
    return rms * np.sqrt(2) * np.sin(2 * np.pi * frequency * TIMES)


class Moved:
    """Velocities of floor, feet, centre of gravity and a point: at rest, but for what a test fills in."""

    def __init__(self, rows: int = TIMES.size) -> None:
        self.rows = rows
        self.floor, self.feet = np.zeros((2, TIMES.size, 4, 3))
        self.cg, self.point = np.zeros((2, TIMES.size, 3))

    def dataset(self) -> Any:
        values = {"ground_velocity": self.floor, "foot_velocity": self.feet, "cg_velocity": self.cg}
        values |= {"machine_velocity": np.zeros((TIMES.size, 6)), "point_velocity": self.point[:, None]}
        labels = {"mount": list(MOUNTS), "point": ["nose"]}
        return make_dataset(TIMES[: self.rows], {k: v[: self.rows] for k, v in values.items()}, {}, labels)

    def judged(self, usable_to: float = np.inf, **criteria: Any) -> Isolation:
        norms = CriteriaSettings(norms=("vc",), **criteria).chosen()
        return isolation(self.dataset(), PLANT, RATE, usable_to, norms)[0]


def test_the_worst_place_gives_the_class_and_the_others_stand_beside() -> None:
    moved = Moved()
    moved.floor[:, :, Z] = line(20.0, 20e-6)[:, None]
    moved.cg[:, Z], moved.point[:, Z] = line(20.0, 1e-6), line(12.5, 3e-6)
    moved.feet[:, 2, Z] = line(16.0, 5e-6)  # VC-D is 6.25 µm/s, VC-E 3.12
    found = moved.judged().criterion
    assert found.decisive is not None
    vertical = found.decisive.vertical
    assert (vertical.worst.place, vertical.worst.mount, vertical.worst.verdict.met) == ("feet", MOUNTS[2], "VC-D")
    assert [(other.place, other.verdict.met) for other in vertical.others] == [("nose", "VC-E"), ("machine", "VC-F")]
    assert found.verdict.vertical == "floor VC-B, machine VC-D (passive)"
    said = found.lines()["vertical"]
    below, above = 20 * np.log10(6.25 / 5.0), 20 * np.log10(5.0 / 3.12)
    worst = f"worst at foot rear-left: 5 µm/s, {below:.1f} dB below its limit of 6.25 µm/s"
    assert f"{worst} and {above:.1f} dB above that of VC-E at 16 Hz" in said
    assert "nose VC-E (0.3 dB below, 12.5 Hz), centre of gravity VC-F (3.9 dB below, 20 Hz)" in said
    worst = "floor worst at mount front-left: 20 µm/s, 1.9 dB below its limit of 25 µm/s"
    assert f"{worst} and 4.1 dB above that of VC-C at 20 Hz" in said
    assert found.lines()["horizontal"] == "floor at rest, machine at rest (passive)"


@settings(max_examples=6)
@given(st.lists(st.floats(1e-7, 1e-3), min_size=3, max_size=3), st.sampled_from([X, Y, Z]))
def test_no_place_is_ever_worse_than_the_headline(levels: list[float], axis: int) -> None:
    moved = Moved()
    moved.floor[:, :, axis] = line(20.0, 1e-4)[:, None]
    moved.cg[:, axis], moved.point[:, axis], moved.feet[:, 1, axis] = (line(20.0, level) for level in levels)
    found = moved.judged().criterion
    assert found.decisive is not None
    named = found.decisive.vertical if axis == Z else found.decisive.horizontal
    order = list(CLASSES)
    expected = [name for name in order if max(levels) <= CLASSES[name] * (1 + 1e-6)]
    assert named.worst.verdict.met == (expected[-1] if expected else None)


def test_a_class_is_one_at_best_and_says_how_many_bands_are_left() -> None:
    """Known up to 4.5 Hz, where the band at 4 Hz ends, one of 14 is known; up to 60 Hz all but two."""
    moved = Moved()
    moved.floor[:, :, Z], moved.cg[:, Z] = line(5.0, 22e-6)[:, None], line(5.0, 2.2e-6)
    said = moved.judged(usable_to=4.5).criterion.lines()["vertical"]
    assert said.startswith("floor at rest as far as known, machine at rest as far as known (passive): 13 of 14 ")
    said = moved.judged(usable_to=60.0).criterion.lines()["vertical"]
    assert said.startswith("floor at best VC-B, machine at best VC-F (passive): 2 of 14 bands undecided (63, 80 Hz). ")
    nothing = moved.judged(usable_to=1.0).criterion
    assert nothing.lines()["vertical"] == "floor not judged, machine not judged (passive): 14 of 14 bands undecided"


def test_what_does_not_move_is_at_rest_and_has_no_margin() -> None:
    """At 63 Hz 1e-12 m/s are 82 dB below VC-M, 12 nm/s: the rounding of a simulation, and no vibration."""
    moved = Moved()
    for level, said in ((0.9e-12, "floor at rest, machine at rest (passive)"), (1.2e-9, "floor VC-M, machine at rest")):
        moved.floor[:, :, Z] = line(63.0, level)[:, None]
        assert moved.judged().criterion.lines()["vertical"].startswith(said)
    assert (
        "Floor worst at mount front-left: 0.0012 µm/s, 20.0 dB below its limit of 0.012 µm/s"
        in moved.judged().criterion.lines()["vertical"]
    )


def test_a_band_that_cannot_decide_leaves_no_class_open() -> None:
    """VC-A has no limit below 4 Hz by either practice, and VC-B is missed: what 1 Hz does matters no more."""
    moved = Moved(rows=4001)  # 7.2 s: too short for the bands below 2.5 Hz
    moved.floor[:, :, Z], moved.cg[:, Z] = line(20.0, 40e-6)[:, None], line(20.0, 10e-6)
    for practice, left in (("classic", []), ("flat", ["1", "1.25", "1.6", "2"])):
        found = moved.judged(low_frequency=practice).criterion
        assert found.decisive is not None
        assert (found.floor.z.met, found.floor.z.decided) == ("VC-A", True)
        assert (found.machine.z.met, list(found.decisive.vertical.undecided)) == ("VC-C", left)
        assert len(CLASSIC.could_decide("z", "VC-C")) == 14
    assert len(FLAT.could_decide("z", "VC-B")) == 14
    assert len(FLAT.could_decide("z", "VC-C")) == 20


@pytest.mark.parametrize("practice", ["classic", "flat"])
def test_the_rule_at_low_frequency_is_named(practice: str) -> None:
    rule = {"classic": "constant acceleration from 4 to 8 Hz", "flat": "VC-C and stricter from 1 Hz"}[practice]
    assert Moved().judged(low_frequency=practice).criterion.lines()["judged by"].startswith(f"VC curves, {rule}")


def test_the_scatter_is_that_of_noise_and_none_of_a_line() -> None:
    """Of Gaussian noise the mean square over B·T has the standard deviation 1/√(B·T); here two of them, in dB."""
    moved, rng = Moved(), np.random.default_rng(3)
    sos = signal.butter(4, (10.0, 100.0), "bandpass", fs=RATE, output="sos")
    moved.floor[:, :, Z] = signal.sosfilt(sos, rng.standard_normal((TIMES.size, 4)), axis=0) * 1e-5
    moved.cg[:, Z] = line(31.5, 1e-5)
    moved.point[:, Z] = line(31.5, 1e-5) * (TIMES > 15.0)
    levels = levels_of(moved.dataset(), PLANT, RATE, bands(1.0, 200.0))
    for band in bands(16.0, 80.0):
        expected = 2 * 10 / np.log(10) / np.sqrt(band.width * levels.seconds)
        found = [scatter(levels, "floor", mount, "z", band.name) or 0.0 for mount in range(4)]
        # From 19 windows the spread is known to a sixth or so, of four mounts to a twelfth; by deciles to less.
        assert np.mean(found) == pytest.approx(expected, rel=0.35)
    assert scatter(levels, "machine", None, "z", "31.5") == pytest.approx(0.0, abs=0.01)
    assert scatter(levels, "nose", None, "z", "31.5") is None  # a burst: no stationary noise, no line


def test_a_hundredth_of_a_decibel_of_scatter_is_called_that() -> None:
    """The class stays what the limit says; the words say that chance may have made it."""
    moved, rng = Moved(), np.random.default_rng(5)
    noise = signal.sosfilt(
        signal.butter(4, (14.2, 17.7), "bandpass", fs=RATE, output="sos"), rng.standard_normal(TIMES.size)
    )
    level = moved_level(noise)
    for factor, met, words in (
        (10 ** (0.02 / 20), "VC-B", "0.02 dB above that of VC-C at 16 Hz (within the scatter of the estimate, ±"),
        (
            10 ** (-0.02 / 20),
            "VC-C",
            "0.02 dB below its limit of 12.5 µm/s at 16 Hz (within the scatter of the estimate, ±",
        ),
        (10 ** (3.0 / 20), "VC-B", "3.0 dB above that of VC-C at 16 Hz"),
    ):
        moved.floor[:, :, Z] = (noise * factor * 12.5e-6 / level)[:, None]
        found = moved.judged().criterion
        assert found.floor.z.met == met
        assert words in found.lines()["vertical"]
    assert "scatter" not in moved.judged().criterion.lines()["vertical"]


def test_a_class_that_rests_on_little_of_what_varies_says_that_its_scatter_is_not_known() -> None:
    """A burst is neither noise nor a line: 0.03 dB below a limit may be chance, 3 dB are not asked about."""
    moved, burst = Moved(), line(16.0, 1.0) * (TIMES > 15.0)
    level = moved_level(burst)
    for below, told in ((0.03, True), (3.0, False)):
        moved.floor[:, :, Z] = (burst * 25e-6 * 10 ** (-below / 20) / level)[:, None]
        said = moved.judged().criterion.lines()["vertical"]
        assert f"{below:.{2 if told else 1}f} dB below its limit" in said
        assert ("scatter of the estimate not known: the motion varies" in said) == told


def moved_level(noise: Any) -> float:
    """What the judge reads in the band at 16 Hz."""
    moved = Moved()
    moved.floor[:, :, Z] = noise[:, None]
    level = moved.judged().third_octave_velocity["floor"]["z"]["16"]
    assert level is not None
    return level


def test_the_headline_stands_in_the_summary() -> None:
    moved = Moved()
    moved.floor[:, :, Z], moved.cg[:, Z] = line(20.0, 20e-6)[:, None], line(20.0, 1e-6)
    plain = moved.judged().to_dict()
    worst = plain["criterion"]["decisive"]["vertical"]["worst"]
    assert (worst["place"], worst["axis"], worst["verdict"]["class"], worst["verdict"]["deciding_band_hz"]) == (
        *("machine", "z"),
        *("VC-F", "20"),
    )
    assert Isolation.read(plain, "summary").criterion.lines() == moved.judged().criterion.lines()
