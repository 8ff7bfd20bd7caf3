"""Vibration criteria: the published table, decisions exactly at its limits, and what is not known."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from ehamj.criteria.vc import CLASSES, CLASSIC, FLAT, limit
from ehamj.criteria.verdict import Verdict
from ehamj.estimate.bands import bands

TABLE = {
    "workshop": 800.0,
    "office": 400.0,
    "residential": 200.0,
    "operating theatre": 100.0,
    "VC-A": 50.0,
    "VC-B": 25.0,
    "VC-C": 12.5,
    "VC-D": 6.25,
    "VC-E": 3.12,
    "VC-F": 1.56,
    "VC-G": 0.78,
    "VC-H": 0.39,
    "VC-I": 0.195,
    "VC-J": 0.097,
    "VC-K": 0.048,
    "VC-L": 0.024,
    "VC-M": 0.012,
}
"""IEST-RP-CC012 and Amick et al. 2005 [µm/s]; from VC-H on the extensions, half of the one above each."""
NAMES = tuple(TABLE)
MEASURED = bands(1.0, 100.0)
NAMED = {band.name: band for band in MEASURED}
INSIDE = tuple(band for band in MEASURED if 4.0 <= float(band.name) <= 80.0)
ABOVE_8_HZ = tuple(band for band in MEASURED if 8.0 <= float(band.name) <= 80.0)


def levels(everywhere: float, **bands_at: float) -> np.ndarray:
    """RMS velocity per band: one everywhere, others in bands named as ``at_12_5``."""
    named = {name.removeprefix("at_").replace("_", "."): value for name, value in bands_at.items()}
    return np.array([named.get(band.name, everywhere) for band in MEASURED])


def judge(velocity: np.ndarray, measured: tuple, flat_from_1_hz: bool = False) -> Verdict:
    return (FLAT if flat_from_1_hz else CLASSIC).judge("z", {("velocity", "rms"): velocity}, measured)


def just_above(value: float) -> float:
    return float(np.nextafter(value, np.inf))


# --- limits -------------------------------------------------------------------------------------------------------


def test_the_classes_are_the_published_ones_coarsest_first() -> None:
    assert {name: pytest.approx(level * 1e6, rel=1e-12) for name, level in CLASSES.items()} == TABLE
    assert tuple(CLASSES) == NAMES


@pytest.mark.parametrize("name", NAMES)
@pytest.mark.parametrize("band", ABOVE_8_HZ, ids=lambda band: band.name)
def test_a_class_is_flat_from_8_to_80_hz(name: str, band: object) -> None:
    assert limit(name, band) == pytest.approx(TABLE[name] * 1e-6, rel=1e-12)


@pytest.mark.parametrize(("band", "factor"), [("4", 2.0), ("5", 1.6), ("6.3", 8 / 6.3), ("8", 1.0)])
def test_from_4_to_8_hz_a_class_has_constant_acceleration(band: str, factor: float) -> None:
    assert limit("VC-A", NAMED[band]) == pytest.approx(50e-6 * factor, rel=1e-12)


@pytest.mark.parametrize("band", ["1", "2", "3.15", "100"])
def test_outside_4_to_80_hz_a_class_says_nothing(band: str) -> None:
    assert [limit(name, NAMED[band]) for name in NAMES] == [None] * len(NAMES)


@pytest.mark.parametrize("name", ["VC-C", "VC-D", "VC-E", "VC-F", "VC-G", "VC-H", "VC-M"])
def test_by_newer_practice_strict_classes_are_flat_from_1_to_80_hz(name: str) -> None:
    found = [limit(name, band, flat_from_1_hz=True) for band in (*MEASURED, *bands(0.5, 0.8))]
    inside = [float(band.name) <= 80.0 for band in MEASURED]
    assert found == [CLASSES[name] if flat else None for flat in inside] + [None] * 3


@pytest.mark.parametrize("name", ["workshop", "operating theatre", "VC-A", "VC-B"])
def test_newer_practice_leaves_coarse_classes_as_they_are(name: str) -> None:
    assert [limit(name, band, True) for band in MEASURED] == [limit(name, band) for band in MEASURED]


# --- decisions ----------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", NAMES)
@pytest.mark.parametrize("band", INSIDE, ids=lambda band: band.name)
def test_a_level_exactly_at_the_limit_meets_the_class(name: str, band: object) -> None:
    at_limit = np.array([limit(name, band) if b == band else 0.0 for b in MEASURED])
    assert judge(at_limit, MEASURED).met == name


@pytest.mark.parametrize("name", NAMES)
@pytest.mark.parametrize("band", INSIDE, ids=lambda band: band.name)
def test_a_level_the_least_above_the_limit_does_not(name: str, band: object) -> None:
    above = np.array([just_above(limit(name, band)) if b == band else 0.0 for b in MEASURED])
    place = NAMES.index(name)
    assert judge(above, MEASURED).met == (NAMES[place - 1] if place else None)


def test_bands_outside_the_criterion_do_not_count() -> None:
    assert judge(levels(1e-6, at_3_15=1.0, at_100=1.0), MEASURED).met == "VC-F"


def test_the_worst_band_decides_and_is_named() -> None:
    # 20 µm/s at 5 Hz, where 1.6 times as much is allowed, are less than 14 µm/s at 25 Hz.
    verdict = judge(levels(1e-6, at_5=20e-6, at_25=14e-6), MEASURED)
    assert (verdict.met, verdict.deciding_band) == ("VC-B", "25")


def test_the_margin_is_the_distance_to_the_limit_of_the_class_met() -> None:
    verdict = judge(levels(1e-6, at_16=20e-6), MEASURED)
    assert verdict.margin_db == pytest.approx(20 * np.log10(25 / 20), rel=1e-12)


def test_worse_than_a_workshop_is_no_class() -> None:
    verdict = judge(levels(1e-6, at_16=900e-6), MEASURED)
    assert (verdict.met, verdict.deciding_band, verdict.margin_db) == (None, "16", None)


def test_nothing_that_moves_meets_the_strictest_class_without_a_margin() -> None:
    verdict = judge(levels(0.0), MEASURED)
    assert (verdict.met, verdict.margin_db) == ("VC-M", None)


def test_newer_practice_counts_what_lies_below_4_hz() -> None:
    slow = levels(1e-6, at_2=20e-6)
    assert (judge(slow, MEASURED).met, judge(slow, MEASURED, flat_from_1_hz=True).met) == ("VC-F", "VC-B")


def test_newer_practice_takes_away_the_double_at_4_hz() -> None:
    slow = levels(1e-6, at_4=20e-6)
    assert (judge(slow, MEASURED).met, judge(slow, MEASURED, flat_from_1_hz=True).met) == ("VC-C", "VC-B")


@given(st.lists(st.floats(1e-8, 1e-3), min_size=len(MEASURED), max_size=len(MEASURED)), st.booleans())
def test_the_class_met_is_the_strictest_whose_every_limit_is_kept(values: list[float], newer: bool) -> None:
    kept = [
        name
        for name in NAMES
        if all(value <= (limit(name, band, newer) or np.inf) for value, band in zip(values, MEASURED, strict=True))
    ]
    assert judge(np.array(values), MEASURED, newer).met == (kept[-1] if kept else None)


@given(st.lists(st.floats(1e-8, 1e-3), min_size=len(MEASURED), max_size=len(MEASURED)), st.floats(1.0, 10.0))
def test_more_vibration_never_meets_a_stricter_class(values: list[float], factor: float) -> None:
    order = [None, *NAMES]
    quiet, loud = (order.index(judge(np.array(values) * f, MEASURED).met) for f in (1.0, factor))
    assert loud <= quiet


# --- what is not known --------------------------------------------------------------------------------------------


def test_bands_that_are_not_known_are_named_and_do_not_decide() -> None:
    verdict = judge(levels(1e-6, at_4=np.nan, at_5=np.nan, at_80=np.nan), MEASURED)
    assert (verdict.met, verdict.undecided) == ("VC-F", ("4", "5", "80"))


def test_bands_that_were_not_measured_are_not_known() -> None:
    verdict = judge(np.full(11, 1e-6), bands(4.0, 40.0))
    assert verdict.undecided == ("50", "63", "80")


def test_by_newer_practice_bands_from_1_hz_must_be_known() -> None:
    verdict = judge(np.full(14, 1e-6), bands(4.0, 80.0), flat_from_1_hz=True)
    assert verdict.undecided == ("1", "1.25", "1.6", "2", "2.5", "3.15")


def test_without_any_level_nothing_is_said() -> None:
    verdict = judge(np.full(len(MEASURED), np.nan), MEASURED)
    assert (verdict.met, verdict.deciding_band, verdict.margin_db) == (None, None, None)
