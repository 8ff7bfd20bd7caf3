"""Universal files: written by pyuff and by hand to the letter of the format, read back, refused by name."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest
import pyuff
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from oracles.records import NOISE, RATE, TIMES, by_axis, motion, read


def response(samples: np.ndarray, direction: int, label: str = "m/s", node: int = 1, **other: Any) -> dict[str, Any]:
    """Dataset 58 of a time response."""
    content: dict[str, Any] = {
        **{"binary": 1, "func_type": 1, "rsp_node": node, "rsp_dir": direction, "ref_node": 0, "ref_dir": 0},
        **{"ord_data_type": 4, "abscissa_spacing": 1, "abscissa_min": 0.0, "abscissa_inc": 1 / RATE},
        **{"ordinate_spec_data_type": 11, "ordinate_axis_units_lab": label, "abscissa_spec_data_type": 17},
        **{"abscissa_axis_units_lab": "s", "orddenom_spec_data_type": 0, "z_axis_spec_data_type": 0},
        **{"num_pts": samples.size, "data": samples, "x": TIMES[: samples.size], **other},
    }
    return pyuff.prepare_58(**content)


def uff(folder: Path, *sets: dict[str, Any], name: str = "a.uff") -> Path:
    file = pyuff.UFF(str(folder / name))
    for content in sets:
        file.write_sets(content, "add")
    return folder / name


def written(
    samples: np.ndarray,
    step: float,
    unit: str = "m/s^2",
    time_unit: str = "s",
    *,
    kind: int = 12,
    time_kind: int = 17,
    label: str = "Acceleration",
    mark: str = "E",
    point: str = "         1   3",
) -> str:
    """Dataset 58 of 12-digit numbers by the format's own columns, without a library."""
    head = ["    -1", "    58", *["NONE"] * 5]
    head.append(f"{1:5d}{0:10d}{1:5d}{0:10d} {'NONE':10s}{point} {'NONE':10s}{0:10d}{0:4d}")
    head.append(f"{4:10d}{samples.size:10d}{1:10d}{0.0:13.5e}{step:13.5e}{0.0:13.5e}")
    head.append(f"{time_kind:10d}{0:5d}{0:5d}{0:5d} {'Time':20s} {time_unit:20s}")
    head.append(f"{kind:10d}{0:5d}{0:5d}{0:5d} {label:20s} {unit:20s}")
    head += [f"{0:10d}{0:5d}{0:5d}{0:5d} {'NONE':20s} {'NONE':20s}"] * 2
    body = ["".join(f"{v:20.11e}" for v in samples[k : k + 4]) for k in range(0, samples.size, 4)]
    return "\n".join([*head, *body, "    -1", ""]).replace("e+", f"{mark}+").replace("e-", f"{mark}-")


def units_164(code: int, words: str, factor: float) -> dict[str, Any]:
    return {
        **{"type": 164, "units_code": code, "units_description": words, "temp_mode": 1},
        **{"length": factor, "force": 1.0, "temp": 1.0, "temp_offset": 273.15},
    }


@pytest.mark.parametrize("binary", [0, 1])
def test_directions_are_axes_and_signs(tmp_path: Path, binary: int) -> None:
    sets = [response(NOISE[k], way, binary=binary) for k, way in enumerate((1, -2, 3))]
    found = by_axis(read(uff(tmp_path, *sets)))
    # ASCII holds 12 digits.
    for axis, sign, samples in zip("xyz", (1, -1, 1), NOISE, strict=True):
        np.testing.assert_allclose(found[axis], sign * samples, rtol=1e-11 if binary == 0 else 0, atol=0)


@pytest.mark.parametrize(("label", "kind", "size"), [("mm/s^2", 12, 1e-3), ("g", 12, 9.80665), ("µm", 8, 1e-6)])
def test_units_are_those_of_the_label(tmp_path: Path, label: str, kind: int, size: float) -> None:
    path = uff(tmp_path, response(NOISE[0], 3, label, ordinate_spec_data_type=kind))
    channel = read(path).channels[0]
    assert channel.quantity == {8: "displacement", 12: "acceleration"}[kind]
    np.testing.assert_allclose(channel.samples, size * NOISE[0], rtol=1e-12)
    assert channel.rate == RATE


SIZES = {"m/s^2": 1.0, "mm/s^2": 1e-3, "g": 9.80665, "Gal": 1e-2, "in/s^2": 0.0254}
SPELLINGS = {
    "m/s^2": ("m/s^2", "M/S**2", "m/s2", "M/SEC/SEC", "(m/s²)", "[m/s^2]", "m s-2"),
    **{"mm/s^2": ("mm/s^2", "MM/S2", "mm/s²"), "g": ("g", "G", "[g]"), "Gal": ("Gal", "gal", "cm/s^2")},
    "in/s^2": ("in/s^2", "IN/SEC^2"),
}
SECONDS = {"s": 1.0, "S": 1.0, "sec": 1.0, "ms": 1e-3, "[ms]": 1e-3, "us": 1e-6, "µs": 1e-6, "min": 60.0}


@given(
    st.sampled_from([(text, SIZES[unit]) for unit, texts in SPELLINGS.items() for text in texts]),
    st.sampled_from(list(SECONDS)),
    st.integers(1, 100_000),
    st.booleans(),
)
@settings(suppress_health_check=[HealthCheck.function_scoped_fixture], max_examples=60)
def test_every_unit_of_ordinate_and_abscissa(
    tmp_path: Path, unit: tuple[str, float], second: str, rate: int, in_brackets: bool
) -> None:
    label = {"label": f"Acc. [{unit[0].strip('[]()')}]", "unit": "NONE"} if in_brackets else {"unit": unit[0]}
    content = written(NOISE[0, :20], 1 / (rate * SECONDS[second]), time_unit=second, **label)
    (tmp_path / "a.uff").write_text(content, encoding="utf-8")
    channel = read(tmp_path / "a.uff").channels[0]
    assert channel.rate == rate  # the step has six digits, which stand for a whole number of Hz
    np.testing.assert_allclose(channel.samples, unit[1] * NOISE[0, :20], rtol=1e-11)


@pytest.mark.parametrize(("label", "step"), [("ms", 1.0), ("s", 1e-3)])
def test_milliseconds_are_a_thousand_hertz_and_not_one(tmp_path: Path, label: str, step: float) -> None:
    samples = 3.9478e-3 * np.sin(20 * np.pi * np.arange(0, 4, 1e-3))
    (tmp_path / "a.uff").write_text(written(samples, step, time_unit=label))
    (channel,) = read(tmp_path / "a.uff").channels
    assert (channel.rate, channel.samples.size, channel.quantity, channel.axis) == (1000.0, 4000, "acceleration", "z")
    assert np.abs(channel.samples).max() == pytest.approx(3.9478e-3, rel=1e-9)


def test_a_rate_that_is_no_whole_number_stays_what_the_step_says(tmp_path: Path) -> None:
    (tmp_path / "a.uff").write_text(written(NOISE[0], 3.14159e-3))
    assert read(tmp_path / "a.uff").channels[0].rate == pytest.approx(1 / 3.14159e-3, rel=1e-12)


def test_fortran_doubles_with_d_as_exponent_are_read(tmp_path: Path) -> None:
    (tmp_path / "a.uff").write_text(written(NOISE[0], 1 / RATE, mark="D"))
    np.testing.assert_allclose(by_axis(read(tmp_path / "a.uff"))["z"], NOISE[0], rtol=1e-11)


def test_what_is_not_labelled_is_of_the_data_type_and_in_seconds_and_says_so(tmp_path: Path) -> None:
    content = response(NOISE[0], 3, "NONE", ordinate_spec_data_type=12, abscissa_axis_units_lab="NONE")
    record = read(uff(tmp_path, content))
    assert record.channels[0].quantity == "acceleration"
    assert any("1:+Z has no unit label: taken as its data type (acceleration) has it, in SI" in n for n in record.notes)
    assert any("1:+Z has no unit on its abscissa: taken as s" in note for note in record.notes)


@pytest.mark.parametrize(
    ("code", "words", "factor", "size"),
    [
        (5, "mm", 1000.0, 1e-3),
        (9, "mm", 1000.0, 1e-3),
        (7, "Inch", 1 / 0.0254, 0.0254),
        (2, "Foot", 3.280839895, 0.3048),
    ],
)
def test_dataset_164_says_by_what_lengths_are_divided(
    tmp_path: Path, code: int, words: str, factor: float, size: float
) -> None:
    path = uff(tmp_path, units_164(code, words, factor), response(NOISE[0], 3, "NONE"))
    record = read(path)
    np.testing.assert_allclose(by_axis(record)["z"], size * NOISE[0], rtol=1e-6)  # the digits of the factor
    assert any(f"the length of {size:g} m that dataset 164 states" in note for note in record.notes)


def test_a_label_comes_before_dataset_164(tmp_path: Path) -> None:
    path = uff(tmp_path, units_164(5, "mm", 1000.0), response(NOISE[0], 3, "m/s"))
    np.testing.assert_array_equal(by_axis(read(path))["z"], NOISE[0])


def test_a_unit_that_is_not_known_is_what_the_user_says(tmp_path: Path) -> None:
    record = read(uff(tmp_path, response(NOISE[0], 3, "furlong")), unit="um/s")
    np.testing.assert_allclose(by_axis(record)["z"], 1e-6 * NOISE[0], rtol=1e-14)
    assert "1:+Z: its unit 'furlong' is taken as ground.unit = 'um/s', times ground.scale" in record.notes


def test_several_nodes_and_repeated_responses_are_picked_by_name_and_by_number(tmp_path: Path) -> None:
    path = uff(tmp_path, response(NOISE[0], 3), response(NOISE[1], 3, node=7), response(NOISE[2], 3))
    np.testing.assert_array_equal(by_axis(read(path, axes={"7:+Z": "z"}))["z"], NOISE[1])
    np.testing.assert_array_equal(by_axis(read(path, axes={"3": "z"}))["z"], NOISE[2])


def test_only_what_is_picked_is_judged(tmp_path: Path) -> None:
    bad = response(np.full(5000, np.nan), 1, "furlong", abscissa_spec_data_type=18)
    path = uff(tmp_path, bad, response(NOISE[0], 3))
    np.testing.assert_array_equal(by_axis(read(path, axes={"z": "z"}))["z"], NOISE[0])


@pytest.mark.parametrize("binary", [0, 1])
def test_uneven_times_have_a_unit_too(tmp_path: Path, binary: int) -> None:
    content = response(
        NOISE[0], 3, binary=binary, abscissa_spacing=0, x=2000 + 1e3 * TIMES, abscissa_axis_units_lab="ms"
    )
    channel = read(uff(tmp_path, content)).channels[0]
    assert channel.rate == pytest.approx(RATE, rel=1e-9)
    np.testing.assert_allclose(channel.samples, NOISE[0], rtol=1e-11)


def test_uneven_times_of_six_digits_are_rounded_and_not_uneven(tmp_path: Path) -> None:
    times = np.arange(5000) / 3200.0  # 1.56219 s at the end: rounded to a thirtieth of a step
    content = response(NOISE[0], 3, binary=0, abscissa_spacing=0, x=times)
    channel = read(uff(tmp_path, content)).channels[0]
    assert channel.rate == pytest.approx(3200.0, rel=1e-6)
    np.testing.assert_allclose(channel.samples, NOISE[0], rtol=1e-11)


def test_channels_that_begin_apart_are_put_on_one_clock(tmp_path: Path) -> None:
    late = response(NOISE[1], 1, x=TIMES + 3.0)
    record = read(uff(tmp_path, response(NOISE[0], 3), late))
    assert {channel.axis: channel.time for channel in record.channels} == {"z": -3.0, "x": 0.0}


def test_it_becomes_motion(tmp_path: Path) -> None:
    uff(tmp_path, response(1e-4 * np.sin(2 * np.pi * 20 * TIMES), 3))
    velocity = motion(tmp_path, "a.uff").sample(np.linspace(2.0, 4.0, 400)).velocity[:, 0, 2]
    # 20 Hz is 200 corners of the high-pass away; 1e-3 is the spline's share (see the record's tests).
    assert np.abs(velocity).max() == pytest.approx(1e-4, rel=2e-3)


FAULTS: dict[str, tuple[list[dict[str, Any]] | str, dict[str, Any], str]] = {
    "spectrum": ([response(NOISE[0], 3, func_type=9)], {}, r"holds no time response \(dataset 58, function type 1\)"),
    "two nodes": (
        [response(NOISE[0], 3, node=1), response(NOISE[1], 3, node=7)],
        {},
        r"ground\.axes: '1:\+Z', '7:\+Z' are all z; each axis takes one component",
    ),
    "twice": (
        [response(NOISE[0], 3), response(NOISE[1], 3)],
        {},
        r"number 1 \('1:\+Z'\), number 2 \('1:\+Z'\) are all z; .*by name or by number",
    ),
    "scalar": ([response(NOISE[0], 0)], {}, r"ground\.axes does not say which axis '1:0' is"),
    "rotation": ([response(NOISE[0], 4)], {"axes": {"1": "z"}}, r"1:4 is a rotation \(direction 4\); leave it out"),
    "unknown unit": ([response(NOISE[0], 3, "furlong")], {}, r"unit of '1:\+Z': 'furlong' is not .*; ground\.unit can"),
    "contradiction": (
        [response(NOISE[0], 3, "g")],
        {},
        r"UFF component 1:\+Z is velocity by its data type, but in 'g'",
    ),
    "no type": (
        [response(NOISE[0], 3, "NONE", ordinate_spec_data_type=0)],
        {},
        r"does not say what '1:\+Z' holds; set ground\.unit",
    ),
    "164 against itself": (
        [units_164(1, "SI", 1000.0), response(NOISE[0], 3, "NONE")],
        {},
        r"dataset 164 contradicts itself: units code 1 \(SI\), length factor 1000; say which with ground\.unit",
    ),
    "164 the other way round": (
        [units_164(5, "mm", 1e-3), response(NOISE[0], 3, "NONE")],
        {},
        r"dataset 164 contradicts itself: units code 5 \(mm\), length factor 0\.001",
    ),
    "unit twice": ([response(NOISE[0], 3)], {"unit": "mm/s"}, r"ground\.unit = 'mm/s', but the file states another"),
    "complex": (
        [response(NOISE[0] + 0j, 3, ord_data_type=6)],
        {},
        r"1:\+Z is complex; a time response must be real",
    ),
    "gap": (
        [response(NOISE[0], 3, abscissa_spacing=0, x=np.where(TIMES < 5, TIMES, TIMES + 1))],
        {},
        r"'a\.uff' has 1 gap, 1 s in total; set ground\.gaps",
    ),
    "unit of time": (
        [response(NOISE[0], 3, abscissa_axis_units_lab="rev")],
        {},
        r"1:\+Z: the unit of its abscissa: 'rev' is not a unit that is known .*label it s or ms",
    ),
    "over frequency": (
        [response(NOISE[0], 3, abscissa_spec_data_type=18)],
        {},
        r"1:\+Z: its abscissa is of data type 18, not of time \(17\)",
    ),
    "backwards": (written(NOISE[0], -1e-3), {}, r"steps of -0\.001; times must rise"),
    "no step": (written(NOISE[0], 0.0), {}, r"steps of 0; times must rise"),
    "inventory": (
        [response(NOISE[0], 3)],
        {"inventory": "b.xml"},
        r"ground\.inventory = 'b\.xml' is of use with .*is a universal",
    ),
    "fewer than stated": (
        written(NOISE[0], 1e-3).replace("      5000", "      6000"),
        {},
        r"holds 5000 of 6000 samples; the file may be truncated",
    ),
}


@pytest.mark.parametrize("fault", FAULTS)
def test_faults_are_named(tmp_path: Path, fault: str) -> None:
    content, options, message = FAULTS[fault]
    if isinstance(content, str):
        (tmp_path / "a.uff").write_text(content)
    else:
        uff(tmp_path, *content)
    with pytest.raises(ValueError, match=message):
        motion(tmp_path, "a.uff", **options)


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        (b"58b     1     2", b"58b     1     1", r"floating-point format 1; only IEEE 754 \(2\) is read"),
        (
            b"         4      5000",
            b"         2      5000",
            r"holds 10000 samples where it states 5000; export",
        ),
    ],
    ids=["VAX", "declared as singles"],
)
def test_binary_numbers_are_what_they_are_declared_to_be(tmp_path: Path, old: bytes, new: bytes, message: str) -> None:
    path = uff(tmp_path, response(NOISE[0], 3))
    content = path.read_bytes()
    assert old in content
    path.write_bytes(content.replace(old, new))
    with pytest.raises(ValueError, match=message):
        read(path)


@pytest.mark.parametrize("cut", [7, 500, 10_000])
def test_a_truncated_file_is_refused(tmp_path: Path, cut: int) -> None:
    path = uff(tmp_path, response(NOISE[1], 1), response(NOISE[0], 3))
    path.write_bytes(path.read_bytes()[:-cut])
    with pytest.raises(ValueError, match=r"ground\.file = 'a\.uff'.*may be truncated"):
        read(path)
