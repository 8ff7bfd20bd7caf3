"""A user's own limits from a file: what they limit, and what is refused."""

import re
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from ehamj.criteria.curves import Limit, Norm
from ehamj.criteria.own import own_norm
from ehamj.criteria.settings import CriteriaSettings
from ehamj.errors import InputError
from ehamj.estimate.bands import bands

UNITS = [
    ("um/s", "velocity", 1e-6),
    ("mm/s", "velocity", 1e-3),
    ("m/s^2", "acceleration", 1.0),
    ("mg", "acceleration", 9.80665e-3),
    ("nm", "displacement", 1e-9),
]
CURVE = "frequency [Hz],maker [um/s]\n5,40\n20,10\n80,10\n"


def norm_of(folder: Path, text: str, name: str = "limits.csv", **settings: str) -> Norm:
    (folder / name).write_text(text, encoding="utf-8")
    (norm,) = CriteriaSettings.model_validate({"norms": [str(folder / name)], **settings}).chosen().values()
    return norm


def limited(norm: Norm, name: str) -> dict[str, float]:
    """Limits of a class by band; along every axis the same."""
    found = [
        {band.name: limit.value for band in bands(0.5, 315.0) if (limit := norm.limit(name, axis, band)) is not None}
        for axis in "xyz"
    ]
    assert found[0] == found[1] == found[2]
    return found[0]


@pytest.mark.parametrize(("unit", "quantity", "size"), UNITS)
def test_limits_of_bands_are_the_rows(tmp_path: Path, unit: str, quantity: str, size: float) -> None:
    norm = norm_of(tmp_path, f"band [Hz],coarse [{unit}],fine [{unit}]\n12.5,3.0,1.5\n63,4.0,2\n")
    assert norm.classes == ("coarse", "fine")
    assert norm.kinds == {(quantity, "rms")}
    assert limited(norm, "coarse") == {"12.5": pytest.approx(3.0 * size), "63": pytest.approx(4.0 * size)}
    assert limited(norm, "fine") == {"12.5": pytest.approx(1.5 * size), "63": pytest.approx(2.0 * size)}


def test_a_curve_is_straight_on_double_logarithmic_paper(tmp_path: Path) -> None:
    """From 40 µm/s at 5 Hz to 10 at 20 Hz: constant acceleration, 200/f; every band from 5 to 80 Hz has a limit."""
    found = limited(norm_of(tmp_path, CURVE), "maker")
    assert list(found) == [band.name for band in bands(5.0, 80.0)]
    for name, value in found.items():
        expected = 200.0 / float(name) if float(name) < 20.0 else 10.0
        assert value == pytest.approx(expected * 1e-6, rel=1e-12)
    assert found["5"] == pytest.approx(40e-6, rel=1e-15)  # a point of the curve is met exactly


@pytest.mark.parametrize("statistic", ["max_1s", "slow", "fast", "l10", "l50", "l90"])
def test_the_file_or_the_scenario_says_which_levels_count(tmp_path: Path, statistic: str) -> None:
    assert norm_of(tmp_path, f"# Statistic = {statistic}\n{CURVE}").kinds == {("velocity", statistic)}
    assert norm_of(tmp_path, CURVE, statistic=statistic).kinds == {("velocity", statistic)}
    assert norm_of(tmp_path, f"# statistic: rms\n{CURVE}", statistic=statistic).kinds == {("velocity", "rms")}


def test_a_peak_goes_with_the_frequency_of_its_swing(tmp_path: Path) -> None:
    limit = norm_of(tmp_path, f"# statistic: peak\n{CURVE}").limit("maker", "z", None)
    assert limit is not None
    assert limit.kind == ("velocity", "peak")
    # Beyond the curve, and where a frequency is not clear, the strictest value counts.
    found = limit.over(np.array([5.0, 10.0, 20.0, 50.0, 200.0, 1.0, np.nan]))
    np.testing.assert_allclose(found, np.array([40, 20, 10, 10, 10, 10, 10]) * 1e-6, rtol=1e-12)


@pytest.mark.parametrize(("unit", "quantity", "size"), UNITS)
def test_one_row_of_a_peak_holds_at_all_frequencies(tmp_path: Path, unit: str, quantity: str, size: float) -> None:
    limit = norm_of(tmp_path, f"# statistic: peak\nfrequency [Hz],any [{unit}]\n1,2.5\n").limit("any", "x", None)
    assert limit == Limit(pytest.approx(2.5 * size), quantity, "peak")


def test_classes_are_sorted_from_coarse_to_strict(tmp_path: Path) -> None:
    """Also of different quantities: 1 µm at 16 Hz are 100 µm/s."""
    norm = norm_of(tmp_path, "band [Hz],fine [um/s],coarse [um],middle [um/s]\n16,10,1,50\n")
    assert norm.classes == ("coarse", "middle", "fine")


@given(st.lists(st.floats(1e-3, 1e3), min_size=3, max_size=3, unique=True))
def test_a_level_meets_the_strictest_column_that_it_does_not_exceed(values: list[float]) -> None:
    import tempfile

    with tempfile.TemporaryDirectory() as folder:
        text = "band [Hz]," + ",".join(f"c{k} [um/s]" for k in range(3)) + "\n20," + ",".join(map(repr, values)) + "\n"
        norm = norm_of(Path(folder), text)
    (twenty,) = bands(20.0, 20.0)
    for level in (*values, 0.0, 1e4):
        found = norm.judge("y", {("velocity", "rms"): np.array([level * 1e-6])}, (twenty,))
        kept = [value for value in values if level <= value]
        assert found.met == (f"c{values.index(min(kept))}" if kept else None)


@pytest.mark.parametrize("encoding", ["utf-8-sig", "latin-1", "utf-16"])
def test_a_spreadsheets_file_is_read_too(tmp_path: Path, encoding: str) -> None:
    """Decimal commas, semicolons, µ, CRLF, an unnamed last column, and the statement in a row of its own."""
    text = "# statistic: max_1s;;\r\nband [Hz];grob [µm/s];\r\n12,5;3,25;\r\n16;4,5;\r\n"
    (tmp_path / "a.csv").write_bytes(text.encode(encoding))
    norm = own_norm(str(tmp_path / "a.csv"))
    assert norm.kinds == {("velocity", "max_1s")}
    assert limited(norm, "grob") == {"12.5": pytest.approx(3.25e-6), "16": pytest.approx(4.5e-6)}


def test_title_and_name(tmp_path: Path) -> None:
    assert norm_of(tmp_path, CURVE, "my limits, v2.csv").title == "my limits, v2"
    assert norm_of(tmp_path, f"# title: Spindle maker's\n{CURVE}").title == "Spindle maker's"
    chosen = CriteriaSettings(norms=("vc", str(tmp_path / "my limits, v2.csv"))).chosen()
    assert list(chosen) == ["vc", "my limits, v2.csv"]


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("time [s],z [um/s]\n1,2\n", r"the first column must be 'band \[Hz\]' or 'frequency \[Hz\]', not 'time \[s\]'"),
        ("band,z [um/s]\n1,2\n", r"must be 'band \[Hz\]' or 'frequency \[Hz\]', not 'band'"),
        ("band [Hz],z [kg]\n16,2\n", r"column 'z': 'kg' is not a unit.*known are"),
        ("band [Hz],z\n16,2\n", r"column 'z'.*known are"),
        ("band [Hz],z [um/s]\n16,-2\n", r"row 1: z = -2 must be positive and finite"),
        ("band [Hz],z [um/s]\n16,2\n10,3\n", r"row 2: band = 10 Hz must be above the row before"),
        ("band [Hz],z [um/s]\n17.5,2\n", r"17.5 Hz is not the centre of a third-octave band"),
        ("band [Hz],z [um/s]\n16,2\n400,3\n", r"row 2: band 400 Hz; levels are known from 1 to 315 Hz"),
        ("frequency [Hz],z [um/s]\n16,2\n", r"needs at least 2 rows.*'band \[Hz\]'"),
        ("frequency [Hz],z [um/s]\n16.5,2\n17,2\n", r"16.5 to 17 Hz hold no centre of a band"),
        ("band [Hz],a [um/s],b [um/s]\n16,2,1\n20,2,2.5\n", r"row 2 \(20 Hz\): 'b' is above 'a'"),
        ("% Statistics = mean\nband [Hz],a [um/s]\n16,2\n", r"'statistic: mean'; that must be one of rms, .*peak"),
        ("# statistic: rms\n# statistic: peak\nband [Hz],a [um/s]\n16,2\n", r"line 2 states a statistic again"),
        ("# statistic: peak\nband [Hz],a [um/s]\n16,2\n", r"not of a band: its column is 'frequency \[Hz\]'"),
        ("band [Hz]\n16\n20\n", r"a column with limits must follow"),
        ("band [Hz],a [um/s],a [um/s]\n16,2,1\n", r"two columns are called 'a'"),
        ("band [Hz],a [um/s]\n16,x\n", r"line 2"),
    ],
)  # fmt: skip
def test_what_is_wrong_is_refused_with_its_place(tmp_path: Path, text: str, said: str) -> None:
    with pytest.raises(InputError) as caught:
        norm_of(tmp_path, text)
    message = str(caught.value)
    assert message.startswith("criteria.norms = 'limits.csv': ")
    assert re.search(said, message), message
    assert message.count("limits.csv") == 1


def test_a_file_that_is_not_there_is_refused(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"criteria.norms = 'gone.csv'.* cannot be read"):
        own_norm(str(tmp_path / "gone.csv"))
