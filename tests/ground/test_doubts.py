"""Bad records are named as such: clipped, counted, in the wrong unit, too slow; good ones are left alone."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from ehamj.ground import Start
from ehamj.ground.doubts import too_slow
from ehamj.ground.records import RecordGround
from ehamj.plant.mounts import MOUNTS
from ehamj.scenario.load import parse_scenario

POSITIONS = np.array([[0.9, 0.6], [0.9, -0.6], [-0.9, 0.6], [-0.9, -0.6]])
RATE = 400.0
NOISE = np.random.default_rng(2).standard_normal(6000)


def notes(folder: Path, samples: Any, unit: str, rate: float = RATE, **options: Any) -> list[str]:
    rows = "\n".join(repr(float(value)) for value in samples)
    (folder / "a.csv").write_text(f"# rate_hz = {rate!r}\nz [{unit}]\n{rows}\n", encoding="utf-8")
    ground = RecordGround(kind="record", file=str(folder / "a.csv"), **options)
    return list(ground.motion(Start(MOUNTS, POSITIONS, 5.0, 0)).notes)


def said(found: list[str], *texts: str) -> bool:
    return any(all(text in note for text in texts) for note in found)


DOUBTS = (
    "clipped",
    "which no floor does",
    "quieter than any site",
    "as gravity",
    "senses gravity",
    "too slowly",
    "gap",
)


@pytest.mark.parametrize(("unit", "size"), [("um/s", 20.0), ("mm/s^2", 3.0), ("um", 0.3), ("m/s", 1e-5), ("g", 3e-4)])
def test_a_plausible_record_raises_no_doubt(tmp_path: Path, unit: str, size: float) -> None:
    found = notes(tmp_path, size * NOISE, unit, highpass=1.0)
    assert not [note for note in found if any(doubt in note for doubt in DOUBTS)]


def test_micrometres_read_as_metres_are_no_floor(tmp_path: Path) -> None:
    found = notes(tmp_path, 20.0 * NOISE, "m/s")
    assert said(found, "z moves with 18", "m/s RMS, which no floor does", "really velocity in the unit stated?")
    assert not said(found, "counts")


def test_counts_read_as_metres_look_like_counts(tmp_path: Path) -> None:
    assert said(
        notes(tmp_path, np.rint(3000 * NOISE), "m/s^2"), "which no floor does", "look like counts of a converter"
    )


def test_metres_read_as_nanometres_are_quieter_than_any_site(tmp_path: Path) -> None:
    assert said(notes(tmp_path, 1e-5 * NOISE, "nm/s"), "quieter than any site on earth", "really velocity in the unit")


def test_scaling_on_purpose_is_no_matter_of_units(tmp_path: Path) -> None:
    assert not said(notes(tmp_path, 20.0 * NOISE, "um/s", scale=1e4), "which no floor does")


def test_a_doubt_that_the_scale_resolves_is_not_raised(tmp_path: Path) -> None:
    counts = np.rint(3000 * NOISE)
    assert not said(notes(tmp_path, counts, "m/s", scale=2.5e-9), "which no floor does", "counts")
    assert not said(notes(tmp_path, 1.0 + 3e-4 * NOISE, "m/s^2", scale=9.80665), "as gravity in g")


def test_a_doubt_that_the_scale_leaves_is_raised_once_and_of_what_is_used(tmp_path: Path) -> None:
    found = [
        note for note in notes(tmp_path, np.rint(3000 * NOISE), "m/s", scale=1e-3) if "which no floor does" in note
    ]
    assert len(found) == 1
    # 2.7 m/s: the noise, less what the high-pass and the fade take.
    assert "z moves with 2." in found[0]
    assert "in the unit stated, and is the scale right?" in found[0]
    assert said(notes(tmp_path, np.rint(3000 * NOISE), "m/s", scale=1e-14), "quieter than any site on earth")


def test_gravity_is_seen_behind_a_scale_too(tmp_path: Path) -> None:
    counts = np.rint(16384 + 5 * NOISE)
    assert said(notes(tmp_path, counts, "m/s^2", scale=9.80665 / 16384), "it senses gravity, which is taken off")
    assert said(notes(tmp_path, counts, "m/s^2", scale=1 / 16384), "as gravity in g: is its unit g?")


def test_an_acceleration_around_one_reads_like_g(tmp_path: Path) -> None:
    found = notes(tmp_path, 1.0 + 3e-4 * NOISE, "m/s^2")
    assert said(found, "z has a mean of 1 m/s², as gravity in g: is its unit g?")


def test_an_accelerometer_that_senses_gravity_is_understood(tmp_path: Path) -> None:
    found = notes(tmp_path, 9.81 + 3e-3 * NOISE, "m/s^2")
    assert said(found, "z has a mean of 9.81 m/s²: it senses gravity, which is taken off")
    assert not said(found, "is its unit g?")


def test_clipped_samples_are_counted(tmp_path: Path) -> None:
    found = notes(tmp_path, np.clip(20.0 * np.sin(np.arange(6000) / 20), -15.0, 15.0), "um/s")
    assert said(found, "z looks clipped: ", "samples stand at its extreme value")


def test_a_gap_that_was_filled_is_named(tmp_path: Path) -> None:
    times = np.arange(6000) / RATE
    kept = (times < 3) | (times > 3.2)
    rows = "\n".join(f"{t!r}, {v!r}" for t, v in zip(times[kept].tolist(), (20 * NOISE[kept]).tolist(), strict=True))
    (tmp_path / "a.csv").write_text(f"time [s], z [um/s]\n{rows}\n")
    ground = RecordGround(kind="record", file=str(tmp_path / "a.csv"), gaps="interpolate")
    assert said(list(ground.motion(Start(MOUNTS, POSITIONS, 5.0, 0)).notes), "1 gap, 0.2", "filled with straight lines")


@pytest.mark.parametrize(("rate", "slow"), [(100.0, True), (222.0, True), (223.0, False), (400.0, False)])
def test_a_rate_too_low_for_the_criteria_is_named(tmp_path: Path, rate: float, slow: bool) -> None:
    # 2.5 times the upper edge of the 80 Hz band, 79.4 · 10^0.05 = 89.1 Hz, is 222.8 Hz.
    found = notes(tmp_path, 20.0 * NOISE, "um/s", rate)
    wanted = (
        f"record a.csv is sampled at {rate:g} Hz, too slowly for the vibration criteria: their 80 Hz band needs 223"
    )
    assert said(found, wanted) is slow
    assert (too_slow("a.csv", rate) is not None) is slow


def test_doubts_reach_the_warnings_of_a_run(tmp_path: Path) -> None:
    import ehamj

    rows = "\n".join(repr(float(value)) for value in np.clip(20.0 * NOISE[:2000], -25.0, 25.0))
    (tmp_path / "a.csv").write_text(f"# rate_hz = 150\nz [um/s]\n{rows}\n")
    ground = {"kind": "record", "file": str(tmp_path / "a.csv"), "highpass": 1.0}
    warnings = ehamj.simulate(parse_scenario({"duration": 0.5, "plates": "tied", "ground": ground})).summary["warnings"]
    assert said(warnings, "looks clipped")
    assert said(warnings, "too slowly for the vibration criteria")
