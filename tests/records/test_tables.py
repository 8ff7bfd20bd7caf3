"""Tables of text as loggers write them: however a table is written, the same record comes out, or a refusal."""

import re
from pathlib import Path
from time import process_time
from typing import Any

import numpy as np
import pytest
from hypothesis import HealthCheck, assume, given, settings
from hypothesis import strategies as st
from oracles.records import read
from oracles.tables import CLOCKS, FIELD, HEADERS, RATE, TIME_UNITS, UNITS, Written, sines

from ehamj.records.channel import Record
from ehamj.records.choices import Choices
from ehamj.records.readers import reader_of
from ehamj.records.tables import read_table


def read_text(folder: Path, text: str | bytes, name: str = "a.csv", **choices: Any) -> Record:
    path = folder / name
    path.write_bytes(text if isinstance(text, bytes) else text.encode())
    return read(path, **choices)


def agrees(record: Record, samples: np.ndarray, unit: str, rate: float = RATE) -> None:
    """Whether a record holds rows of samples, written with nine digits."""
    quantity, size = UNITS[unit]
    assert len(record.channels) == len(samples)
    for channel, expected in zip(record.channels, samples, strict=True):
        assert (channel.rate, channel.quantity, channel.time) == (rate, quantity, 0.0)
        np.testing.assert_allclose(channel.samples, size * expected, rtol=2e-8, atol=1e-9 * size)


T = "".join(f"{k / 100:.2f},{k % 7}.5\n" for k in range(30))


# --- ways to write ------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", FIELD)
def test_files_of_the_field_give_their_record(tmp_path: Path, name: str) -> None:
    way, samples = FIELD[name], sines(1, 2000)
    record = read_text(tmp_path, way.bytes(samples), name)
    agrees(record, samples, way.unit)
    (note,) = [note for note in record.notes if note.startswith("table ")]
    assert note.startswith(f"table {name}: ")
    assert "2000 rows from line " in note
    assert ("passed over: 'note' (words)" in note) == way.words
    assert ("decimal comma" in note) == (way.decimal == ",")


ways = st.builds(
    Written,
    delimiter=st.sampled_from([",", ";", "\t", "|", " "]),
    decimal=st.sampled_from([".", ","]),
    header=st.sampled_from(HEADERS),
    clock=st.sampled_from(CLOCKS),
    time_unit=st.sampled_from(sorted(TIME_UNITS)),
    unit=st.sampled_from(sorted(UNITS)),
    names=st.sampled_from([("z",), ("x", "y", "z"), ("acc_x", "acc_y", "acc_z"), ("X", "Z")]),
    quotes=st.booleans(),
    preamble=st.sampled_from(
        [(), ("Logger 7", "Serial,0000", ""), ("# made up", "# 2026-01-05"), ("Anlage; Halle 3",)]
    ),
    footer=st.sampled_from([(), ("End of data",), ("", "mean;none"), ("# end",)]),
    trailing=st.booleans(),
    words=st.booleans(),
    end=st.sampled_from(["\n", "\r\n", "\r"]),
    encoding=st.sampled_from(["utf-8", "utf-8-sig", "latin-1", "cp1252", "utf-16", "utf-16-le", "utf-32"]),
)


@given(ways, st.sampled_from(["csv", "txt", "dat", "asc", "prn", "log", ""]))
@settings(suppress_health_check=[HealthCheck.function_scoped_fixture], max_examples=300)
def test_a_table_is_the_same_record_however_it_is_written(tmp_path: Path, way: Written, ending: str) -> None:
    assume(way.possible)
    samples = sines(len(way.names), 30)
    record = read_text(tmp_path, way.bytes(samples), f"a.{ending}".rstrip("."))
    agrees(record, samples, way.unit)


@given(ways)
@settings(suppress_health_check=[HealthCheck.function_scoped_fixture], max_examples=60)
def test_missing_rows_are_a_gap_however_the_table_is_written(tmp_path: Path, way: Written) -> None:
    assume(way.possible and not way.stated)
    keep = np.ones(40, bool)
    keep[20:25] = False
    samples = sines(len(way.names), 40)
    content = way.bytes(samples, keep)
    with pytest.raises(ValueError, match=r"has 1 gap, 0\.01 s in total; set ground\.gaps .*before line \d+\)"):
        read_text(tmp_path, content)
    record = read_text(tmp_path, content, gaps="interpolate")
    size = UNITS[way.unit][1]
    for channel, expected in zip(record.channels, samples, strict=True):
        assert channel.rate == RATE
        np.testing.assert_allclose(channel.samples[keep], size * expected[keep], rtol=2e-8, atol=1e-9 * size)
        # A straight line from sample 19 to sample 25; nine digits are written.
        line = np.linspace(expected[19], expected[25], 7)
        np.testing.assert_allclose(channel.samples[19:26], size * line, rtol=2e-8, atol=1e-8 * size)


def test_times_that_are_rounded_to_a_third_of_a_step_are_even(tmp_path: Path) -> None:
    time = np.arange(12800) / 3200.0
    rows = "".join(f"{t:.4f},{np.sin(63 * t):.9g}\n" for t in time)
    record = read_text(tmp_path, "time [s],z [m/s^2]\n" + rows)
    agrees(record, np.sin(63 * time)[None], "m/s^2", 3200.0)
    assert any("times are rounded to 0.0001 s; 3200 Hz explains all of them" in note for note in record.notes)


def test_a_wandering_clock_is_said(tmp_path: Path) -> None:
    time = np.cumsum(1 / 400.0 * (1 + 0.02 * np.sin(np.arange(1600) / 300.0)))
    rows = "".join(f"{t:.7f},{np.sin(20 * np.pi * t):.9g}\n" for t in time - time[0])
    (channel,) = (record := read_text(tmp_path, "time [s],z [m/s^2]\n" + rows)).channels
    assert channel.rate == pytest.approx(400, rel=0.005)
    even = 20 * np.pi * np.arange(channel.samples.size) / channel.rate
    basis = np.stack([np.sin(even), np.cos(even)], axis=1)
    # Nine digits of samples and seven decimals of times; the spline itself loses 1e-8.
    assert np.hypot(*np.linalg.lstsq(basis, channel.samples, rcond=None)[0]) == pytest.approx(1.0, abs=1e-5)
    assert any("the clock wanders: times lie up to 0.026" in note for note in record.notes)


# --- columns ------------------------------------------------------------------------------------------------------

ROWS = "".join(f"{k / 100:.2f},{k},{10 * k},ok,{100 * k}\n" for k in range(1, 21))


def test_only_the_columns_that_are_picked_are_judged(tmp_path: Path) -> None:
    text = "time [s],x [mm],y [furlong],note,z [mm]\n" + ROWS.replace("7,70,ok,700", "7,OVERLOAD,ok,700")
    record = read_text(tmp_path, text, axes={"x": "x", "column 5": "z"})
    np.testing.assert_allclose([c.samples[6] for c in record.channels], [7e-3, 0.7], rtol=1e-12)
    with pytest.raises(
        ValueError, match=r"line 8 holds 'OVERLOAD' in column 'y', which is not a number; .*missing = \["
    ):
        read_text(tmp_path, text, axes={"y": "y"})
    with pytest.raises(ValueError, match=r"line 2 holds 'ok' in column 'note', which is not a number"):
        read_text(tmp_path, text, axes={"note": "y"})
    with pytest.raises(ValueError, match=r"names 'up', which the record does not hold; it holds 'x', 'y', 'note', 'z'"):
        read_text(tmp_path, text, axes={"up": "z"})


def test_columns_that_are_no_motion_are_passed_over_and_named(tmp_path: Path) -> None:
    rows = "".join(f"{k},{k / 100:.2f},21.5,ok,,{k * k}\n" for k in range(1, 21))
    record = read_text(tmp_path, "No,time [s],Temperature [°C],note,spare,z [mm]\n" + rows)
    assert [channel.name for channel in record.channels] == ["z"]
    told = "passed over: 'note' (words), 'spare' (empty), 'No' (counts rows), 'Temperature' (°C)"
    assert any(told in note for note in record.notes), record.notes


def test_columns_of_one_name_are_told_apart_by_their_place(tmp_path: Path) -> None:
    text = "time [s],z [m],z [mm],note,z [m]\n" + ROWS
    with pytest.raises(ValueError, match=r"'z \(column 2\)', 'z \(column 3\)', 'z \(column 5\)' are all z"):
        read_text(tmp_path, text)
    (channel,) = read_text(tmp_path, text, axes={"column 3": "z"}).channels
    np.testing.assert_allclose(channel.samples[:2], [0.01, 0.02], rtol=1e-12)


@pytest.mark.parametrize("word", ["", "nan", "NaN", "n/a", "#N/A", "---", "NULL", "-", "1.#QNAN"])
def test_empty_cells_are_a_gap_of_their_column(tmp_path: Path, word: str) -> None:
    rows = [f"{k / 100:.2f},{k},{word if 10 <= k < 13 else 2 * k}\n" for k in range(40)]
    text = "time [s],x [m],z [m]\n" + "".join(rows)
    with pytest.raises(
        ValueError, match=r"1 gap, 0\.03 s .*\(empty cells of column 'z', the first in line 12 at 0\.1 s"
    ):
        read_text(tmp_path, text)
    record = read_text(tmp_path, text, gaps="interpolate")
    # A straight line over a straight line.
    np.testing.assert_allclose(record.channels[1].samples, 2.0 * np.arange(40), rtol=1e-12)
    assert read_text(tmp_path, text, axes={"x": "z"}).channels[0].samples.size == 40  # z was not asked for


def test_a_column_that_starts_late_and_ends_early_is_no_gap(tmp_path: Path) -> None:
    rows = [f"{k / 100:.2f},{k},{2 * k if 5 <= k < 33 else ''}\n" for k in range(40)]
    record = read_text(tmp_path, "time [s],x [m],z [m]\n" + "".join(rows))
    x, z = record.channels
    assert (x.samples.size, z.samples.size) == (40, 28)
    assert x.time == pytest.approx(-0.05)
    assert z.time == 0.0
    assert z.samples[0] == 10.0
    assert any("'z' of a.csv is empty in its first 5 rows and its last 7 rows" in note for note in record.notes)


def test_a_sentinel_is_a_doubt_and_a_word_a_choice(tmp_path: Path) -> None:
    text = "time [s],z [m]\n" + "".join(f"{k / 100:.2f},{-9999 if k in (7, 8) else k % 5}\n" for k in range(40))
    record = read_text(tmp_path, text)
    assert any("holds -9999 2 times, far from all else: if it stands for no value, state" in n for n in record.notes)
    record = read_text(tmp_path, text, gaps="interpolate", table={"missing": ["-9999"]})
    assert record.channels[0].samples.min() == 0.0
    loud = text.replace("-9999", "OVERLOAD")
    with pytest.raises(ValueError, match=r'line 9 holds \'OVERLOAD\' .* state ground\.table\.missing = \["OVERLOAD"\]'):
        read_text(tmp_path, loud)
    assert read_text(tmp_path, loud, gaps="interpolate", table={"missing": ["OVERLOAD"]}).channels[0].samples.max() == 4


# --- what the user says -------------------------------------------------------------------------------------------

VALUES = 1.0 + np.arange(20)
BARE = "".join(f"{2 * k},{k + 1}\n" for k in range(20))


@pytest.mark.parametrize(
    ("text", "choices", "size"),
    [
        (BARE, {"columns": ["time", "z"], "units": {"time": "ms", "z": "mm"}}, 1e-3),
        (BARE, {"columns": ["clock", "z"], "time": "1", "time_unit": "ms", "units": {"2": "g"}}, 9.80665),
        (f"time,z\n{BARE}", {"time_unit": "ms", "units": {"z": "mm"}}, 1e-3),
        (f"a,z [mm]\n{BARE}", {"rate": 500.0}, 1e-3),
        (f"a,z [mm]\n{BARE}", {"time": "a", "time_unit": "ms"}, 1e-3),
        (f"t [ms],z [mm]\nms,V\n{BARE}", {"header": 1, "first_row": 3}, 1e-3),
        (f"1,1\n2,2\n3,3\nt [ms],z [mm]\n{BARE}5\n", {"header": 4, "last_row": 24}, 1e-3),
        (f"t,z\nms,mm\nfree words,here\n{BARE}", {"header": 1, "unit_line": 2}, 1e-3),
        (f"@ what\nt [ms],z [mm]\n{BARE.replace('6,4', '@ here, 1')}6,4\n", {"comment": "@", "rate": 500.0}, None),
        ("t [ms];z [mm]\n" + "".join(f"{2 * k};{k + 1},000\n" for k in range(20)), {"decimal": ","}, 1e-3),
        (
            "t [ms];z [mm]\n" + "".join(f"{2 * k};{k + 1},000\n" for k in range(20)),
            {"decimal": ".", "thousands": ","},
            1.0,
        ),
        ("t [ms];z [mm]\n" + "".join(f"{2 * k};{k + 1}.000,0\n" for k in range(20)), {"thousands": "."}, 1.0),
        ("".join(f"{k + 1},0\n" for k in range(20)), {"delimiter": ";", "columns": ["z"], "rate": 500.0}, 1.0),
    ],
)
def test_what_the_user_says_resolves_what_the_file_leaves_open(
    tmp_path: Path, text: str, choices: dict[str, Any], size: float | None
) -> None:
    unit = {} if "m" in text or "units" in choices else {"unit": "m"}
    (channel,) = read_text(tmp_path, text, table=choices, axes={"z": "z"}, **unit).channels
    assert channel.rate == 500.0
    assert channel.samples.size == 20
    if size is not None:
        np.testing.assert_allclose(channel.samples, size * VALUES, rtol=1e-12)


def test_a_unit_that_the_user_overrules_is_said(tmp_path: Path) -> None:
    record = read_text(tmp_path, f"t [ms],z [m]\n{BARE}", table={"units": {"z": "mm"}})
    assert record.channels[0].samples[0] == 1e-3
    assert any("states m, but ground.table.units says mm, which holds" in note for note in record.notes)


def test_a_rate_that_the_user_overrules_is_said(tmp_path: Path) -> None:
    record = read_text(tmp_path, f"# rate: 200 Hz\nt [ms],z [m]\n{BARE}", table={"rate": 1000.0})
    assert record.channels[0].rate == 1000.0
    for said in ("line 1 says 200 Hz", "column 't' says 500 Hz"):
        assert any(f"{said}, but ground.table.rate = 1000 holds" in note for note in record.notes)


def test_units_that_differ_from_place_to_place_are_asked_for(tmp_path: Path) -> None:
    text = "# units: s, mm/s\ntime [s],z [m/s^2]\n" + T
    with pytest.raises(ValueError, match=r"column 'z' is in 'm/s\^2' and in 'mm/s'; state ground\.table\.units"):
        read_text(tmp_path, text)
    record = read_text(tmp_path, text, table={"units": {"z": "mm/s"}})
    assert record.channels[0].quantity == "velocity"
    assert read_text(tmp_path, text.replace("mm/s", "m/s²")).channels[0].quantity == "acceleration"  # two spellings


def test_a_column_of_comments_that_no_row_has_may_be_named(tmp_path: Path) -> None:
    record = read_text(tmp_path, "time [s],z [m/s],Comment\n" + T)
    assert [channel.name for channel in record.channels] == ["z"]
    with pytest.raises(ValueError, match="line 1 has 3 cells where the rows from line 2 have 2"):
        read_text(tmp_path, "time [s],x [m/s],z [m/s]\n" + T)


def test_dates_whose_order_matters_are_asked_for(tmp_path: Path) -> None:
    days = [f"{d:02d}/01/2026 {h:02d}:00:00" for d in (5, 6) for h in range(24)]
    text = "time,z [m]\n" + "".join(f"{day},{k}\n" for k, day in enumerate(days))
    with pytest.raises(ValueError, match=r"'05/01/2026', whose day and month cannot be told apart.*table\.date_order"):
        read_text(tmp_path, text)
    (channel,) = read_text(tmp_path, text, table={"date_order": "day-month-year"}).channels
    assert channel.rate == pytest.approx(1 / 3600)
    late = text.replace("05/01", "15/01").replace("06/01", "16/01")  # there is no fifteenth month
    assert read_text(tmp_path, late).channels[0].rate == pytest.approx(1 / 3600)


def test_times_of_day_go_on_after_midnight(tmp_path: Path) -> None:
    clocks = [f"{'23:59:59' if k < 10 else f'00:00:0{k // 10 - 1}'}.{k % 10}" for k in range(40)]
    (channel,) = read_text(tmp_path, "time,z [m]\n" + "".join(f"{c},{k}\n" for k, c in enumerate(clocks))).channels
    assert (channel.rate, channel.samples.size) == (10.0, 40)


@pytest.mark.parametrize(
    ("choices", "message"),
    [
        ({"encoding": "rot13"}, "encoding = 'rot13' is not that of a text"),
        ({"encoding": "klingon"}, "encoding = 'klingon' is not that of a text"),
        ({"decimal": ",", "thousands": ","}, "decimal and thousands are both ','"),
        ({"rate": 5.0, "time": "t"}, "rate and time state two clocks"),
        ({"first_row": 9, "last_row": 3}, "first_row = 9 must be at most last_row = 3"),
        ({"rate": 0.0}, "greater than 0"),
        ({"header": 0}, "greater than or equal to 1"),
    ],
)
def test_what_the_user_says_is_checked_before_any_file_is_read(choices: dict[str, Any], message: str) -> None:
    with pytest.raises(ValueError, match=message):
        Choices.model_validate({"table": choices})


@pytest.mark.parametrize(
    ("head", "unit"),
    [
        ("time [s],z [mm]\n-------,------\n", "mm"),
        ('time,z\n"(s)","(mm)"\n', "mm"),
        ("Units: mm\ntime [s],z\n", "mm"),
        ("time_s,acc_z_g\n", "g"),
        ("Zeit in s,Beschleunigung z in m/s²\n", "m/s²"),
        ("sep=,\nt/s,a_z/(m/s^2)\n", "m/s^2"),
        ("Sampling interval: 2\ntime [s],z [mm]\n", "mm"),  # of what unit does not matter beside times
        ("Seconds,z [mm]\n", "mm"),
    ],
)
def test_headers_of_other_forms(tmp_path: Path, head: str, unit: str) -> None:
    (channel,) = read_text(tmp_path, head + "".join(f"{k / 100:.2f},{k}.5\n" for k in range(20))).channels
    quantity, size = UNITS[unit]
    assert (channel.axis, channel.quantity, channel.rate) == ("z", quantity, 100.0)
    assert channel.samples[0] == pytest.approx(0.5 * size)


@pytest.mark.parametrize("name", ["z_m", "z_in", "Station G", "z_G", "level (dB) z"])
def test_a_last_word_that_may_be_none_is_no_unit(tmp_path: Path, name: str) -> None:
    with pytest.raises(ValueError, match=r"does not say what '.*' holds"):
        read_text(tmp_path, f"time [s],{name}\n{T}", axes={name: "z"})


@pytest.mark.parametrize("mark", ["9", "1,", "a ", '"', "(", "# rate ", "1.", "-", "12:", "a:", "\n", ";"])
def test_long_lines_do_not_take_long(tmp_path: Path, mark: str) -> None:
    begin = process_time()
    with pytest.raises(ValueError, match=r"^ground\.file = 'a\.csv'"):
        read_text(tmp_path, 20_000 * mark + "x\n0,1\n0,2\n")
    assert process_time() - begin < 5.0  # what searches over and over takes minutes


FACTORS = ["z 0.01 mm", "z 1E-3 m/s²", "z in 1/1000 mm", "z: 1e-6 m/s²", "z 1/100 mm/s", "z_10^-3_m/s", "z 10⁻³ m/s"]


@pytest.mark.parametrize("cell", [*FACTORS, "z x1000 mm/s", "z [1e-3 m/s]", "z 1e-3 [m/s]"])
@pytest.mark.parametrize("row", ["", "s,mm\n"])
def test_a_factor_before_a_unit_is_never_left_out(tmp_path: Path, cell: str, row: str) -> None:
    with pytest.raises(ValueError, match=r"column 'z' states '.*may be a factor.* state ground\.table\.units .*scale"):
        read_text(tmp_path, f"time [s],{cell}\n{row}{T}")
    assert read_text(tmp_path, f"time [s],{cell}\n{T}", table={"units": {"z": "mm"}}).channels[0].axis == "z"


@pytest.mark.parametrize("cell", ["z Ch 3 mm/s", "z_2_mm/s", "Channel z 1 mm/s", "z 1 (mm/s)", "CH12 z [mm/s]"])
def test_numbers_of_channels_are_no_factors(tmp_path: Path, cell: str) -> None:
    (channel,) = read_text(tmp_path, f"time [s],{cell}\n{T}", axes={"column 2": "z"}).channels
    assert channel.samples[1] == pytest.approx(1.5e-3)


@pytest.mark.parametrize("cell", ["z mm/s", "z_mm/s", "z mm / s", "z / mm/s", "z/mm/s", "z mm s-1"])
def test_a_unit_with_a_stroke_needs_no_brackets_and_is_no_clock(tmp_path: Path, cell: str) -> None:
    rows = "".join(f"{k}.5\n" for k in range(30))
    (channel,) = read_text(tmp_path, f"Sample rate: 200 Hz\n{cell}\n{rows}").channels
    assert (channel.rate, channel.quantity, channel.samples[1]) == (200.0, "velocity", pytest.approx(1.5e-3))


@pytest.mark.parametrize("line", ["# scale factor: 0.001", "# scale: 10", "Sensitivity [V/g]: 5,5", "Gain = 2"])
def test_factors_that_lines_state_are_said_to_be_left_out(tmp_path: Path, line: str) -> None:
    said = r"line 1 states '.*', which is not applied; ground\.scale can"
    record = read_text(tmp_path, f"{line}\ntime [s],z [m/s]\n{T}")
    assert any(re.fullmatch(said, note) for note in record.notes)
    record = read_text(tmp_path, f"# scale: 1.0\n# calibration: 2026-01-05\ntime [s],z [m/s]\n{T}")
    assert not any("not applied" in note for note in record.notes)


@pytest.mark.parametrize("rate", ["51.200 Hz", "1.000 Hz"])
def test_a_rate_whose_mark_may_part_thousands_needs_rows_that_tell(tmp_path: Path, rate: str) -> None:
    head, value = f"Sample rate: {rate}\n", float(rate.split()[0])
    rows = "".join(f"{k}\n" for k in range(30))
    with pytest.raises(ValueError, match=r"line 1: .* may have marks of thousands; state ground\.table\.rate"):
        read_text(tmp_path, f"{head}z [m/s]\n{rows}")
    told = read_text(tmp_path, f"{head}z [m/s]\n{rows.replace(chr(10), '.5' + chr(10))}")
    stated = read_text(tmp_path, f"{head}z [m/s]\n{rows}", table={"decimal": "."})
    assert told.channels[0].rate == stated.channels[0].rate == value


def test_times_of_day_in_two_parts_are_asked_for(tmp_path: Path) -> None:
    rows = "".join(f"05:{k + 20}{{}},{k}\n" for k in range(30))
    text = "Time,z [m/s]\n" + rows.replace("{}", "")
    with pytest.raises(ValueError, match=r"'05:20', which may be minutes and seconds or hours .*table\.time_unit"):
        read_text(tmp_path, text)
    for head, choices, rate in (
        ("Time [mm:ss]", {}, 1.0),
        ("Time [hh:mm]", {}, 1 / 60),
        ("Time", {"time_unit": "mm:ss"}, 1.0),
        ("Time", {"time_unit": "hh:mm"}, 1 / 60),
    ):
        (channel,) = read_text(tmp_path, text.replace("Time", head), table=choices).channels
        assert channel.rate == pytest.approx(rate)
    with pytest.raises(ValueError, match=r"table\.time_unit = 'ms', but column 'Time' holds dates or times of day"):
        read_text(tmp_path, "Time,z [m/s]\n" + rows.replace("{}", ":00"), table={"time_unit": "ms"})


def test_an_interval_without_a_unit_is_said_to_be_taken_as_seconds(tmp_path: Path) -> None:
    record = read_text(tmp_path, "dt: 5\nz [m]\n" + "".join(f"{k}.5\n" for k in range(30)))
    assert any("0.2 Hz from line 1 (dt = 5 states no unit and is taken as 5 s)" in note for note in record.notes)


@pytest.mark.parametrize("name", ["-z", "z down", "z_neg"])
def test_a_sign_in_a_name_is_said_to_be_left_out(tmp_path: Path, name: str) -> None:
    record = read_text(tmp_path, f"time [s],{name} [m/s]\n{T}", axes={name: "z"})
    assert any("may count the other way round" in note and "ground.scale with -1" in note for note in record.notes)
    record = read_text(tmp_path, f"time [s],z [m/s]\n{T}")
    assert not any("other way round" in note for note in record.notes)


def test_a_first_row_amid_rows_keeps_the_header(tmp_path: Path) -> None:
    record = read_text(tmp_path, f"time [s],z [m/s]\n{T}", table={"first_row": 8})
    (channel,) = record.channels
    assert (channel.name, channel.samples.size, channel.samples[0]) == ("z", 24, 6.5)


def test_a_row_of_empty_cells_is_no_header(tmp_path: Path) -> None:
    assert read_text(tmp_path, f"Time,z\ns,mm/s\n,\n{T}").channels[0].name == "z"


def test_a_line_that_names_no_columns_is_shown(tmp_path: Path) -> None:
    with pytest.raises(ValueError, match=r"line 3, 'max,0\.06', names no columns of the rows .* state .*table\.header"):
        read_text(tmp_path, f"time,z\ns,mm/s\nmax,0.06\n{T}")
    record = read_text(tmp_path, f"time,z\ns,mm/s\nmax,0.06\n{T}", table={"header": 1, "unit_line": 2, "first_row": 4})
    assert record.channels[0].samples[1] == pytest.approx(1.5e-3)


@pytest.mark.parametrize(("mark", "stated", "decimal"), [(".", ".", ","), ("'", "'", "."), ("’", "'", ".")])
def test_times_with_marks_of_thousands_are_rounded_as_others_are(
    tmp_path: Path, mark: str, stated: str, decimal: str
) -> None:
    # Steps of 1.95 ms, printed to 1 ms: no rate explains them but with that rounding.
    times = (f"{round(k / 0.512):,}".replace(",", mark) for k in range(1500))
    text = "Zeit [ms];z [m/s]\n" + "".join(f"{t};{k % 7}{decimal}25\n" for k, t in enumerate(times))
    (channel,) = read_text(tmp_path, text, table={"thousands": stated, "decimal": decimal}).channels
    assert channel.rate == 512.0


def test_columns_of_one_name_are_told_apart_by_number(tmp_path: Path) -> None:
    text = "Time [s],x [m],Time [s],z [m]\n" + "".join(f"{k}.5,{k},{2 * k}.5,{k}\n" for k in range(20))
    with pytest.raises(ValueError, match=r"state ground\.table\.time = '1' or '3'"):
        read_text(tmp_path, text)
    with pytest.raises(ValueError, match=r"time = 'Time' names several columns of a\.csv; state '1' or '3'"):
        read_text(tmp_path, text, table={"time": "Time"})
    assert read_text(tmp_path, text, table={"time": "3"}).channels[0].rate == 0.5


def test_milliseconds_that_start_again_contradict_no_rate(tmp_path: Path) -> None:
    rows = "".join(f"10:00:0{k // 200},{5 * (k % 200)},{k}\n" for k in range(600))
    record = read_text(tmp_path, "Time,Milliseconds,z [m]\n" + rows, table={"rate": 200.0})
    assert not any("Milliseconds' says" in note for note in record.notes)


# --- refusals -----------------------------------------------------------------------------------------------------


FAULTS: dict[str, tuple[str, dict[str, Any], str]] = {
    "cell": (
        "time [s], z [m]\n0, 1\n0.01, two\n",
        {},
        r"line 3 holds 'two' in column 'z', which is not a number; if it",
    ),
    "row cut short": (
        "time [s], z [m]\n0, 1\n0.01, 2\n0.0",
        {},
        r"line 4 has 1 cells .* 2 columns.*truncated.*damaged",
    ),
    "row cut in a cell": (f"time [s],z [m]\n{T}0.30,1", {}, r"line 32 ends without a line break, .*truncated"),
    "row too long": (f"time [s],z [m]\n{T}0.30,1.5,2\n{T}", {}, r"line 32 has 3 cells where the table has 2 columns"),
    "words amid rows": (f"time [s],z [m]\n{T}-- restart --\n{T}", {}, r"line 32 has 1 cells .* correct it, or state"),
    "two tables": (
        f"time [s],z [m]\n{T}time [s],z [m]\n{T}",
        {},
        r"line 32 .* holds several tables; .*table\.last_row",
    ),
    "no rows": ("time [s], z [m]\n", {}, r"'a\.csv': no row of numbers was found \(line 'time \[s\], z \[m\]' is none"),
    "empty": ("", {}, r"no row of numbers was found; it is empty"),
    "header below the rows": (
        f"time [s],z [m]\n{T}end,here\n",
        {"table": {"header": 32}},
        r"'a\.csv': there is no row of numbers after line 32; correct ground\.table\.header or",
    ),
    "binary": ("time [s],z [m]\n\x00\x01\n", {}, r"is no text: it holds the control character 0x00 in line 2"),
    "no header": (
        T,
        {},
        r"no column of times .* are 'column 1', 'column 2', and no header was found; state ground\.table",
    ),
    "header too short": (f"time [s]\n{T}", {}, r"no column of times .* no header was found"),
    "header too long": (
        f"time [s],y [m],z [m]\n{T}",
        {},
        r"line 1 has 3 cells where the rows from line 2 have 2 \(commas",
    ),
    "comma is both": (
        "time [s],z [m]\n0,00,1,5\n0,01,2,5\n",
        {},
        r"line 1 has 2 cells where .* have 4 .*nobody can tell",
    ),
    "one column or two": (
        "1,5\n2,5\n",
        {},
        r"'1,5' may be read in two ways: commas \(2 cells: 1, 5\), or .*: 1\.5\); state",
    ),
    "unknown unit": (
        f"time [s],z [lb/s]\n{T}",
        {},
        r"the unit of 'z': 'lb/s' is not a unit that is known .*; known are m",
    ),
    "no unit": (
        f"time [s],z\n{T}",
        {},
        r"ground\.quantity = 'auto', but the file does not say what 'z' holds; .*table\.un",
    ),
    "other unit": (
        f"time [s],z [m/s]\n{T}",
        {"quantity": "acceleration"},
        r"ground\.quantity = 'acceleration', but .* vel",
    ),
    "unknown column": (f"time [s],up [m]\n{T}", {}, r"ground\.axes does not say which axis 'up' is"),
    "axis not there": (f"time [s],z [m]\n{T}", {"axes": {"up": "z"}}, r"ground\.axes names 'up', .* it holds 'z'"),
    "unit of time": (
        f"time [m],z [m]\n{T}",
        {},
        r"column 'time' is in 'm', which is no unit of time; state ground\.table",
    ),
    "time without unit": (f"time,z [m]\n{T}", {}, r"column of times 'time' states no unit; .*ground\.table\.time_unit"),
    "time is infinite": (
        "time [s], z [m]\n0, 1\ninf, 2\n",
        {},
        r"time must rise from row to row; it does not at line 3",
    ),
    "time stands": (
        "time [s], z [m]\n0, 1\n0, 2\n1, 3\n",
        {},
        r"time must rise from row to row; it does not at line 3",
    ),
    "no clock": (
        "z [m]\n1\n2\n",
        {},
        r"no column of times .* and no line that states the sampling rate; .*table\.rate",
    ),
    "rate against times": (
        f"# rate_hz = 9\ntime [s],z [m]\n{T}",
        {},
        r"line 1 of a\.csv states 9 Hz, but its times say 100",
    ),
    "two rates": (
        f"# rate: 9 Hz\n# fs = 8\nz [m]\n{T}",
        {},
        r"line 1 states 9 Hz, and line 2 8 Hz; state ground\.table\.rate",
    ),
    "two clocks": (
        "t [s],time [ms],z [m]\n0,0,1\n1,100,1\n2,200,1\n",
        {},
        r"two clocks, 'time' \[ms\] and 't' \[s\], which differ",
    ),
    "negative rate": ("# rate_hz = -9\nz [m]\n0\n1\n", {}, r"line 1: rate hz = -9 must be a positive number"),
    "rate that is no number": ("# rate_hz = fast\nz [m]\n1\n", {}, r"line 1: rate hz = fast must be a positive number"),
    "rate with thousands": (
        "# rate: 51,200 Hz\nz [m]\n1\n",
        {},
        r"'51,200' may have marks of thousands; state .*table\.rate",
    ),
    "interval without unit": (
        "Sampling interval: 2\nz [m]\n1\n",
        {},
        r"sampling interval = 2 has no unit; state .*rate",
    ),
    "infinite": (
        "# rate_hz = 9\nz [m]\n" + "1\n" * 20 + "inf\n",
        {},
        r"channel z holds 1 values .* sample 21 .* = inf",
    ),
    "mostly gap": (
        "time [s],z [m]\n0.0,1\n1.0,2\n2.0,3\n9.0,1\n",
        {"gaps": "interpolate"},
        r"6 s in total, more than it",
    ),
    "few samples": ("# rate_hz = 9\nz [m]\n1\n2\n", {}, r"channel z holds 2 samples; at least 16"),
    "line beyond the end": (T, {"table": {"header": 99}}, r"ground\.table\.header = 99, but .* has 30 lines"),
    "names too many": (T, {"table": {"columns": ["a", "b", "c"]}}, r"table\.columns has 3 names; .* has 2 columns"),
    "units of none": (f"t [s],z [m]\n{T}", {"table": {"units": {"y": "m"}}}, r"table\.units names 'y'; .* has t, z"),
    "time of none": (
        f"t [s],z [m]\n{T}",
        {"table": {"time": "u"}},
        r"table\.time = 'u' is no column of a\.csv; it has 't'",
    ),
    "other encoding": (
        "t [s],z [µm]\n0,1\n",
        {"table": {"encoding": "ascii"}},
        r"not in the encoding 'ascii' that is stated",
    ),
}


@pytest.mark.parametrize("fault", FAULTS)
def test_faults_are_named_with_the_way_out(tmp_path: Path, fault: str) -> None:
    text, choices, message = FAULTS[fault]
    with pytest.raises(ValueError, match=message) as caught:
        read_text(tmp_path, text, **choices)
    assert "\n" not in str(caught.value)  # one message, one line


@pytest.mark.parametrize(
    "form", ["1,234", "-9,800", "1,234.5", "1.234,5", "1.234.567", "1 234,5", "1'234.5", "12,34,56"]
)
@pytest.mark.parametrize("delimiter", [";", "\t"])
def test_marks_of_thousands_are_never_taken_for_decimals(tmp_path: Path, form: str, delimiter: str) -> None:
    # Whole times, so that nothing else in the file tells the decimal mark.
    rows = "".join(f"{k}{delimiter}{form}\n" for k in range(30))
    with pytest.raises(ValueError, match=r"ground\.table\.(decimal|thousands)"):
        read_text(tmp_path, f"t [s]{delimiter}z [m]\n{rows}")


def test_damaged_rows_are_passed_over_where_the_user_says_so(tmp_path: Path) -> None:
    text = "time [s],z [m]\n" + "".join("0.10,1,2\n" if k == 10 else f"{k / 100:.2f},{k}\n" for k in range(40)) + "0.4"
    with pytest.raises(ValueError, match=r'line 12 has 3 cells .* set ground\.damaged = "skip" to pass over it'):
        read_text(tmp_path, text, gaps="interpolate")
    record = read_text(tmp_path, text, gaps="interpolate", damaged="skip")
    np.testing.assert_allclose(record.channels[0].samples, np.arange(40.0), rtol=1e-12)
    assert any("2 damaged rows were passed over" in note for note in record.notes)


def test_other_readers_keep_their_texts(tmp_path: Path) -> None:
    for first in ("TIMESERIES XX_ONE__HHZ_R, 2 samples", "WID2 2024/05/01", "DELTA: 1.0", "-12345.00 -12345.00"):
        (tmp_path / "a.txt").write_text(f"{first}\n1 2\n3 4\n")
        assert reader_of(tmp_path / "a.txt").title != "text table"


def test_any_table_is_columns_with_names_units_and_numbers(tmp_path: Path) -> None:
    path = tmp_path / "curve.txt"
    path.write_bytes("Grenzkurve; Halle\nBand (Hz);Pegel (µm/s)\n8;0,5\n10;1,25\n".encode("cp1252"))
    table = read_table(path, "criteria.curve.file")
    assert [(column.name, column.unit) for column in table.columns] == [("Band", "Hz"), ("Pegel", "µm/s")]
    np.testing.assert_array_equal([table.numbers(column) for column in table.columns], [[8, 10], [0.5, 1.25]])
    path.write_text("Band (Hz);Pegel (µm/s)\n8;\n10;1,25\n")
    with pytest.raises(
        ValueError, match=r"^criteria\.curve\.file = 'curve\.txt': the cell of column 'Pegel' in line 2 is e"
    ):
        (table := read_table(path, "criteria.curve.file")).numbers(table.columns[1])
    path.write_text("1;2,345\n2;3,456\n")
    with pytest.raises(ValueError, match=r"state criteria\.curve\.table\.decimal"):
        read_table(path, "criteria.curve.file")
