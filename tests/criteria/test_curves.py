"""Decisions by every norm: exactly at the limits, in the norm's own quantity, and what is not known."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from pydantic import ValidationError

from ehamj.criteria import iso2631, nist, vc
from ehamj.criteria.curves import CANDIDATES, Limit, Norm, rounded
from ehamj.criteria.norms import NORMS as REGISTERED
from ehamj.criteria.settings import CriteriaSettings
from ehamj.criteria.verdict import WHOLE
from ehamj.errors import InputError
from ehamj.estimate.bands import bands
from ehamj.estimate.reading import band_rms

NORMS = (vc.CLASSIC, vc.FLAT, nist.NIST_A, iso2631.ISO_2631_2)
QUANTITIES = ("displacement", "velocity", "acceleration")
norms = st.sampled_from(NORMS)
axes = st.sampled_from("xyz")


def at_rest() -> dict:
    return {(quantity, "rms"): np.zeros(len(CANDIDATES)) for quantity in QUANTITIES}


def limited(norm: Norm, name: str, axis: str) -> list[int]:
    return [row for row, band in enumerate(CANDIDATES) if norm.limit(name, axis, band)]


def coarser(norm: Norm, name: str) -> str | None:
    place = norm.classes.index(name)
    return norm.classes[place - 1] if place else None


@given(norms, axes, st.data())
def test_a_level_exactly_at_a_limit_meets_the_class_and_the_next_double_does_not(
    norm: Norm, axis: str, data: st.DataObject
) -> None:
    name = data.draw(st.sampled_from(norm.classes))
    row = data.draw(st.sampled_from(limited(norm, name, axis)))
    limit = norm.limit(name, axis, CANDIDATES[row])
    assert limit is not None
    levels = at_rest()
    levels[limit.kind][row] = limit.value
    at = norm.judge(axis, levels, CANDIDATES)
    assert (at.met, at.margin_db) == (name, 0.0)
    levels[limit.kind][row] = np.nextafter(limit.value, np.inf)
    above = norm.judge(axis, levels, CANDIDATES)
    assert above.met == coarser(norm, name)
    assert (above.next_class, above.next_band) == (name, CANDIDATES[row].name)


@given(norms, axes, st.floats(-30.0, 30.0), st.data())
def test_margin_and_excess_are_the_distances_to_the_two_nearest_limits(
    norm: Norm, axis: str, off: float, data: st.DataObject
) -> None:
    name = data.draw(st.sampled_from(norm.classes))
    row = data.draw(st.sampled_from(limited(norm, name, axis)))
    limit = norm.limit(name, axis, CANDIDATES[row])
    assert limit is not None
    levels = at_rest()
    level = limit.value * 10 ** (off / 20)
    levels[limit.kind][row] = level
    found = norm.judge(axis, levels, CANDIDATES)
    if found.met is not None:
        own = norm.limit(found.met, axis, CANDIDATES[row])
        if own is not None:  # by the flat practice a stricter class may have a limit where a coarser one has none
            assert found.deciding_band == CANDIDATES[row].name
            assert found.margin_db == pytest.approx(20 * np.log10(own.value / level), abs=1e-9)
    if found.next_class is not None:
        stricter = norm.limit(found.next_class, axis, CANDIDATES[row])
        assert stricter is not None
        assert found.excess_db == pytest.approx(20 * np.log10(level / stricter.value), abs=1e-9)


@pytest.mark.parametrize("norm", NORMS, ids=lambda norm: norm.title)
def test_a_class_that_no_stricter_one_follows_has_no_excess(norm: Norm) -> None:
    found = norm.judge("z", at_rest(), CANDIDATES)
    assert (found.met, found.next_class, found.excess_db) == (norm.classes[-1], None, None)


@given(norms, axes, st.sets(st.sampled_from(CANDIDATES)))
def test_bands_that_are_not_known_are_named_if_the_norm_needs_them(norm: Norm, axis: str, unknown: set) -> None:
    levels = at_rest()
    for table in levels.values():
        table[[CANDIDATES.index(band) for band in unknown]] = np.nan
    found = norm.judge(axis, levels, CANDIDATES)
    assert set(found.undecided) == {band.name for band in unknown & set(norm.needed(axis))}


@pytest.mark.parametrize(
    ("norm", "first", "last"),
    [(NORMS[0], "4", "80"), (NORMS[1], "1", "80"), (NORMS[2], "1", "100"), (NORMS[3], "1", "80")],
    ids=lambda value: getattr(value, "title", value),
)
def test_the_bands_that_a_norm_needs(norm: Norm, first: str, last: str) -> None:
    for axis in "xyz":
        assert norm.needed(axis) == bands(float(first), float(last))


def test_limits_are_the_decimals_that_people_write() -> None:
    assert rounded(50e-6 * 8.0 / 5.0) == 80e-6
    assert vc.limit("VC-E", bands(5.0, 5.0)[0]) == 4.992e-6


def test_the_first_norm_chosen_comes_first() -> None:
    chosen = CriteriaSettings(norms=("iso-2631-2", "vc"), low_frequency="flat").chosen()
    assert list(chosen.values()) == [iso2631.ISO_2631_2, vc.FLAT]


# --- NIST-A -------------------------------------------------------------------------------------------------------


def test_nist_a_limits_displacement_to_20_hz_and_velocity_to_100_hz() -> None:
    found = {
        band.name: None if (limit := nist.NIST_A.limit("NIST-A", "x", band)) is None else (limit.quantity, limit.value)
        for band in CANDIDATES
    }
    slow = dict.fromkeys((band.name for band in bands(1.0, 20.0)), ("displacement", 25e-9))
    fast = dict.fromkeys((band.name for band in bands(25.0, 100.0)), ("velocity", 3.12e-6))
    beyond = dict.fromkeys(("0.5", "0.63", "0.8", "125", "160", "200", "250", "315"))
    assert found == slow | fast | beyond


def test_both_limits_of_nist_a_meet_at_20_hz() -> None:
    band = bands(20.0, 20.0)[0]
    limit = nist.NIST_A.limit("NIST-A", "z", band)
    assert limit is not None
    # 2π·20 Hz·25 nm = 3.14 µm/s, which the field rounds to VC-E's 3.12.
    assert limit.as_velocity(band) == pytest.approx(nist.VELOCITY, rel=0.01)


@pytest.mark.parametrize("frequency", [14.3, 17.6])
def test_below_20_hz_a_line_counts_by_its_own_displacement(frequency: float) -> None:
    # Both lie in the band of 16 Hz, near its edges, where a limit of velocity at its centre errs by 10 %.
    wave = np.sin(2 * np.pi * frequency * np.arange(30000) / 500.0)
    for share, met in ((0.98, "NIST-A"), (1.02, None)):
        velocity = wave * np.sqrt(2) * share * 25e-9 * 2 * np.pi * frequency
        measured = bands(1.0, 100.0)
        levels = {
            (q, "rms"): band_rms(velocity, 500.0, measured, order)
            for q, order in zip(QUANTITIES, (-1, 0, 1), strict=True)
        }
        found = nist.NIST_A.judge("z", levels, measured)
        assert (found.met, found.deciding_band) == (met, "16")


# --- ISO 2631-2 ---------------------------------------------------------------------------------------------------

VERTICAL = {
    **{"1": 10.0, "1.25": 8.94, "1.6": 7.91, "2": 7.07, "2.5": 6.32, "3.15": 5.63, "4": 5.0, "5": 5.0, "6.3": 5.0},
    **{"8": 5.0, "10": 6.25, "12.5": 7.81, "16": 10.0, "20": 12.5, "25": 15.6, "31.5": 19.7, "40": 25.0, "50": 31.25},
    **{"63": 39.4, "80": 50.0},
}
HORIZONTAL = {
    **{"1": 3.6, "1.25": 3.6, "1.6": 3.6, "2": 3.6, "2.5": 4.5, "3.15": 5.67, "4": 7.2, "5": 9.0, "6.3": 11.3},
    **{"8": 14.4, "10": 18.0, "12.5": 22.5, "16": 28.8, "20": 36.0, "25": 45.0, "31.5": 56.7, "40": 72.0, "50": 90.0},
    **{"63": 113.0, "80": 144.0},
}
"""Base curves as handbooks tabulate them [mm/s²]."""


@pytest.mark.parametrize(("axis", "table"), [("x", HORIZONTAL), ("y", HORIZONTAL), ("z", VERTICAL)])
def test_base_curves_are_the_tabulated_ones(axis: str, table: dict[str, float]) -> None:
    found = {band.name: 1e3 * a for band in CANDIDATES if (a := iso2631.base_curve(axis, band)) is not None}
    assert found == pytest.approx(table, rel=5e-3)  # half of the third digit


def test_coarse_vc_classes_are_multiples_of_the_vertical_base_curve_above_8_hz() -> None:
    pairs = {"workshop": "workshop", "office": "office", "residential by day": "residential"}
    pairs["critical working area"] = "operating theatre"
    for band in bands(8.0, 80.0):
        for iso, generic in pairs.items():
            limit = iso2631.ISO_2631_2.limit(iso, "z", band)
            assert limit is not None
            assert limit.as_velocity(band) == pytest.approx(vc.CLASSES[generic], rel=0.01)


def test_the_factor_is_the_multiple_of_the_base_curve() -> None:
    levels = at_rest()
    levels["acceleration", "rms"][CANDIDATES.index(bands(5.0, 5.0)[0])] = 3.3 * 5e-3
    found = iso2631.ISO_2631_2.judge("z", levels, CANDIDATES)
    assert (found.met, found.deciding_band) == ("office", "5")
    assert found.factor == pytest.approx(3.3, rel=1e-12)
    assert vc.CLASSIC.judge("z", levels, CANDIDATES).factor is None


# --- peaks of the whole history -------------------------------------------------------------------------------------

FLOORS = Norm("floors", ("line 1", "line 3"), whole=lambda name, axis: Limit(LINES[name], statistic="peak"))
LINES = {"line 1": 20e-3, "line 3": 10e-3}


def test_a_limit_of_the_peak_is_held_against_the_peak() -> None:
    levels = at_rest() | {("velocity", "rms"): np.full(len(CANDIDATES), 1e-3)}
    found = FLOORS.judge("z", levels | {("velocity", "peak"): np.array([12.2e-3])}, CANDIDATES)
    assert (found.met, found.next_class, found.deciding_band, found.decided) == ("line 1", "line 3", WHOLE, True)
    assert found.margin_db == pytest.approx(20 * np.log10(20 / 12.2), abs=1e-9)
    assert found.excess_db == pytest.approx(20 * np.log10(12.2 / 10), abs=1e-9)


@pytest.mark.parametrize(("norm", "given"), [(FLOORS, ("velocity", "rms")), (vc.CLASSIC, ("velocity", "peak"))])
def test_levels_of_another_kind_are_refused(norm: Norm, given: tuple) -> None:
    wanted = "peak" if given[1] == "rms" else "rms"
    with pytest.raises(InputError, match=f"limits {wanted} of velocity; the levels are {given[1]} of velocity"):
        norm.judge("z", {given: np.ones(len(CANDIDATES))}, CANDIDATES)


@pytest.mark.parametrize("statistic", ["rms", "max_1s", "l10"])
def test_limits_in_bands_are_held_against_the_statistic_that_is_chosen(statistic: str) -> None:
    """At the limit the class is met, exactly; the level of another statistic does not count."""
    (norm,) = CriteriaSettings(norms=("nist-a",), statistic=statistic).chosen().values()
    assert norm.kinds == {("displacement", statistic), ("velocity", statistic)}
    loud = {(q, s): np.full(len(CANDIDATES), 1.0) for q in QUANTITIES for s in ("rms", "max_1s", "l10")}
    levels = loud | {kind: np.zeros(len(CANDIDATES)) for kind in norm.kinds}
    levels["velocity", statistic][CANDIDATES.index(bands(63.0, 63.0)[0])] = 3.12e-6
    found = norm.judge("z", levels, CANDIDATES)
    assert (found.met, found.deciding_band, found.margin_db, found.statistic) == ("NIST-A", "63", 0.0, statistic)


def test_a_limit_of_the_peak_stays_one_whatever_is_chosen_for_bands() -> None:
    norm = FLOORS.by("slow")
    assert norm.kinds == {("velocity", "peak")}
    found = norm.judge("z", {("velocity", "peak"): np.array([12.2e-3])}, CANDIDATES)
    assert (found.met, found.statistic) == ("line 1", "peak")


def test_a_band_known_by_another_statistic_only_is_undecided() -> None:
    levels = at_rest() | {("velocity", "max_1s"): np.where(np.arange(len(CANDIDATES)) < 14, np.nan, 0.0)}
    found = vc.CLASSIC.by("max_1s").judge("z", levels, CANDIDATES)
    unknown = tuple(band.name for band in CANDIDATES[:14] if band in vc.CLASSIC.needed("z"))
    assert (found.undecided, found.decided) == (unknown, False)


def test_a_peak_that_is_not_known_decides_nothing() -> None:
    found = FLOORS.judge("z", {("velocity", "peak"): np.array([np.nan])}, CANDIDATES)
    assert (found.met, found.deciding_band, found.undecided, found.decided) == (None, None, (WHOLE,), False)


def test_a_limit_of_the_peak_in_a_band_is_refused() -> None:
    norm = Norm("odd", ("all",), lambda name, axis, band: Limit(1.0, statistic="peak"))
    with pytest.raises(ValueError, match="a limit of the peak is one of the whole history"):
        norm.needed("z")


@pytest.mark.parametrize("name", REGISTERED)
def test_every_registered_norm_judges(name: str) -> None:
    """What rests meets its strictest class along every axis, and a hundred times its coarsest limits not even that."""
    (norm,) = CriteriaSettings(norms=(name,)).chosen().values()
    for axis in "xyz":
        quiet, loud = {}, {}
        for quantity, statistic in norm.kinds:
            places = (None,) if statistic == "peak" else CANDIDATES
            limits = [norm.limit(norm.classes[0], axis, band) for band in places]
            quiet[quantity, statistic] = np.zeros(len(places))
            loud[quantity, statistic] = np.array([100.0 * limit.value if limit else 0.0 for limit in limits])
        assert norm.judge(axis, quiet, CANDIDATES).met == norm.classes[-1]
        assert norm.judge(axis, loud, CANDIDATES).met is None


def test_a_norm_that_is_not_registered_cannot_be_chosen() -> None:
    with pytest.raises(ValidationError) as refused:
        CriteriaSettings(norms=("no-such-norm",))
    assert all(repr(name) in str(refused.value) for name in REGISTERED)


def test_a_statistic_chosen_replaces_rms_alone() -> None:
    slow = Norm("slow", ("a",), lambda name, axis, band: Limit(1e-5, statistic="slow" if band.nominal < 10 else "rms"))
    chosen = slow.by("max_1s")
    assert chosen.kinds == {("velocity", "slow"), ("velocity", "max_1s")}
