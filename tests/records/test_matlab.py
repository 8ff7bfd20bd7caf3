"""MATLAB files of every version, as people and loggers' programs store records: read back, refused by name.

Files up to version 7 are written by SciPy; version 7.3 is HDF5 as MATLAB lays it out: arrays transposed, text as
numbers, structs as groups, cells and struct arrays as references into ``#refs#``.
"""

import struct
from collections.abc import Callable
from pathlib import Path
from typing import Any

import h5py
import numpy as np
import pytest
from oracles.matlab import save_hdf5, save_plain
from oracles.records import NOISE, RATE, TIMES, by_axis, motion, read
from scipy.io import savemat
from scipy.sparse import csc_matrix

VELOCITY = {"quantity": "velocity"}


WRITERS: dict[str, Callable[..., None]] = {
    "5": save_plain,
    "7": lambda path, variables: save_plain(path, variables, do_compression=True),
    "7.3": save_hdf5,
}


@pytest.mark.parametrize(
    "clock",
    [
        *({"t": TIMES}, {"Time": TIMES[:, None]}, {"tm": TIMES}, {"t_ms": 1e3 * TIMES}),
        *({"t": 1e3 * TIMES, "t_unit": "ms"}, {"fs": RATE}, {"Fs": RATE}, {"SampleRate": RATE}, {"fs_kHz": RATE / 1e3}),
        *({"rate_hz": RATE}, {"Sampling_Frequency": f"{RATE}"}, {"dt": 1 / RATE}, {"Ts": 1 / RATE}),
        *({"dt_ms": 1e3 / RATE}, {"info": {"fs": RATE}}, {"Fs": RATE, "dt": 1 / RATE, "time": TIMES}),
    ],
    ids=lambda clock: "+".join(clock),
)
@pytest.mark.parametrize("version", WRITERS)
def test_times_are_found_by_any_usual_name(tmp_path: Path, clock: dict[str, Any], version: str) -> None:
    variables = {"x": NOISE[0], "z": NOISE[2][:, None], "note": "a floor", **clock}
    WRITERS[version](tmp_path / "a.mat", variables)
    record = read(tmp_path / "a.mat", **VELOCITY)
    np.testing.assert_array_equal(by_axis(record)["x"], NOISE[0])
    np.testing.assert_array_equal(by_axis(record)["z"], NOISE[2])
    assert record.channels[0].rate == pytest.approx(RATE, rel=1e-9)


@pytest.mark.parametrize("kind", ["f8", "f4", "i4", "i2", "u1"])
def test_version_4_is_read(tmp_path: Path, kind: str) -> None:
    stored = (NOISE[0] * 1e6 + 50).astype(kind)
    savemat(tmp_path / "a.mat", {"z": stored, "m": np.stack([stored, stored]), "fs": RATE, "a": "text"}, format="4")
    found = by_axis(read(tmp_path / "a.mat", axes={"z": "z", "m(2)": "x"}, **VELOCITY))
    np.testing.assert_array_equal(found["z"], stored)
    np.testing.assert_array_equal(found["x"], stored)


STRUCTS: dict[str, tuple[dict[str, Any], dict[str, str], str]] = {
    "struct": ({"data": {"z": NOISE[0], "fs": RATE, "units": "mm/s"}}, {}, "data.z"),
    "clock outside": ({"data": {"z": NOISE[0], "units": "mm/s"}, "fs": RATE}, {"data.z": "z"}, "data.z"),
    "nested": ({"a": {"b": {"c": {"acc": NOISE[0], "unit": "mm/s"}}, "dt": 1 / RATE}}, {"a.b.c.acc": "z"}, "a.b.c.acc"),
    "Simulink": (
        {
            "s": {
                "time": TIMES,
                "signals": [
                    {"values": NOISE[1], "label": "floor x", "unit": "m/s"},
                    {"values": NOISE[0], "label": "floor z", "unit": "mm/s"},
                ],
            }
        },
        {"floor z": "z"},
        "s.signals(2).values",
    ),
    "by path": (
        {"s": [{"z": NOISE[1], "fs": RATE, "units": "m/s"}, {"z": NOISE[0], "fs": RATE, "units": "mm/s"}]},
        {"s(2).z": "z"},
        "s(2).z",
    ),
    "B&K PULSE": (
        {
            "File_Header": {"SampleFrequency": "500", "NumberOfChannels": "1"},
            "Channel_1_Header": {"SignalName": "Vertical", "Unit": "mm/s"},
            "Channel_1_Data": NOISE[0],
        },
        {"Vertical": "z"},
        "Channel_1_Data",
    ),
    "Testlab": (
        {
            "Signal_0": {
                "x_values": {"start_value": 0.0, "increment": 1 / RATE, "quantity": {"label": "s"}},
                "y_values": {"values": NOISE[0] * 1e-3, "quantity": {"label": "m/s"}},
            }
        },
        {"Signal_0": "z"},
        "Signal_0.y_values.values",
    ),
    "Dewesoft": (
        {"Data1_AI_1": NOISE[0], "Data1_time_AI_1": TIMES, "Sample_rate": RATE, "Data1_AI_1_unit": "mm/s"},
        {"Data1_AI_1": "z"},
        "Data1_AI_1",
    ),
    "cell labels": (
        {"data": np.stack([NOISE[1], NOISE[0]], 1), "fs": RATE, "labels": ["N", "Z"], "units": ["m/s", "mm/s"]},
        {"Z": "z"},
        "data(2)",
    ),
    "units by name": ({"z": NOISE[0], "fs": RATE, "units": {"t": "s", "z": "mm/s"}}, {}, "z"),
}


@pytest.mark.parametrize("case", STRUCTS)
@pytest.mark.parametrize("version", WRITERS)
def test_structs_and_what_programs_export(tmp_path: Path, case: str, version: str) -> None:
    variables, axes, name = STRUCTS[case]
    WRITERS[version](tmp_path / "a.mat", variables)
    (channel,) = read(tmp_path / "a.mat", **({"axes": axes} if axes else {})).channels
    assert (channel.name, channel.axis, channel.quantity) == (name, "z", "velocity")
    assert channel.rate == pytest.approx(RATE, rel=1e-9)
    np.testing.assert_allclose(channel.samples, 1e-3 * NOISE[0], rtol=1e-14)


@pytest.mark.parametrize("matrix", [NOISE, NOISE.T], ids=["rows", "columns"])
def test_matrices_are_columns(tmp_path: Path, matrix: np.ndarray) -> None:
    savemat(tmp_path / "a.mat", {"data": matrix, "fs": RATE})
    found = by_axis(read(tmp_path / "a.mat", axes={"data(1)": "x", "data(3)": "z"}, unit="um/s"))
    np.testing.assert_allclose(found["x"], 1e-6 * NOISE[0], rtol=1e-14)
    np.testing.assert_allclose(found["z"], 1e-6 * NOISE[2], rtol=1e-14)


@pytest.mark.parametrize(
    ("stored", "tolerance"),
    [
        (np.round(NOISE[0] * 1e9).astype(np.int32), 0.5e-9),
        (np.float32(NOISE[0] * 1e9), 1e-11),
        (csc_matrix((NOISE[0] * 1e9)[:, None]), 1e-17),
    ],
    ids=["int32", "single", "sparse"],
)
def test_integers_singles_and_sparse_arrays_are_numbers_too(tmp_path: Path, stored: Any, tolerance: float) -> None:
    savemat(tmp_path / "a.mat", {"z": stored, "fs": RATE})
    found = by_axis(read(tmp_path / "a.mat", unit="nm/s"))["z"]
    np.testing.assert_allclose(found, NOISE[0], rtol=0, atol=tolerance)


@pytest.mark.parametrize("beside", [{}, {"fs": 25_600.0}])
def test_times_in_single_precision_are_rounded_and_not_uneven(tmp_path: Path, beside: dict[str, float]) -> None:
    # At 10 s single precision is 1e-6 s: a fortieth of a step.
    times = np.float32(9.9 + np.arange(5000) / 25_600.0)
    savemat(tmp_path / "a.mat", {"z": NOISE[0], "t": times, **beside})
    channel = read(tmp_path / "a.mat", **VELOCITY).channels[0]
    assert channel.rate == pytest.approx(25_600.0, rel=1e-6)
    np.testing.assert_array_equal(channel.samples, NOISE[0])


def test_unrelated_arrays_are_passed_over_and_named(tmp_path: Path) -> None:
    savemat(tmp_path / "a.mat", {"z": NOISE[0], "window": np.hanning(1024), "fs": RATE})
    record = read(tmp_path / "a.mat", **VELOCITY)
    np.testing.assert_array_equal(by_axis(record)["z"], NOISE[0])
    assert any("arrays that do not fit are passed over: window (1024 × 1)" in note for note in record.notes)


def test_only_what_is_picked_is_judged(tmp_path: Path) -> None:
    bad = {"z": np.full(5000, np.nan), "z_units": "furlong", "c": NOISE[1] + 1j, "short": NOISE[1][:90]}
    savemat(tmp_path / "a.mat", {**bad, "good": NOISE[0], "t": TIMES})
    np.testing.assert_array_equal(by_axis(read(tmp_path / "a.mat", axes={"good": "z"}, **VELOCITY))["z"], NOISE[0])


def test_signals_of_two_clocks_begin_where_the_later_does(tmp_path: Path) -> None:
    signals = {
        name: {
            "x_values": {"start_value": begin / unit, "increment": 1 / rate / unit, "quantity": {"label": label}},
            "y_values": {"values": NOISE[0], "quantity": {"label": "m/s"}},
        }
        for name, begin, rate, label, unit in (("a", 0.0, 500.0, "s", 1.0), ("b", 2.0, 1000.0, "ms", 1e-3))
    }
    savemat(tmp_path / "a.mat", signals)
    record = read(tmp_path / "a.mat", axes={"a": "x", "b": "z"})
    assert [(c.axis, c.rate, c.time) for c in record.channels] == [("x", 500.0, -2.0), ("z", 1000.0, 0.0)]


def test_a_gap_in_times_is_filled_where_it_may_be(tmp_path: Path) -> None:
    kept = (TIMES < 3.0) | (TIMES >= 3.5)
    savemat(tmp_path / "a.mat", {"z": NOISE[0][kept], "t": TIMES[kept]})
    with pytest.raises(ValueError, match=r"1 gap, 0\.5 s in total"):
        read(tmp_path / "a.mat", **VELOCITY)
    record = read(tmp_path / "a.mat", gaps="interpolate", **VELOCITY)
    np.testing.assert_allclose(by_axis(record)["z"][kept], NOISE[0][kept], rtol=1e-12)


TESTLAB_G = {"Signal": {"x_values": {"increment": 1e-3}, "y_values": {"values": NOISE[0], "quantity": {"label": "g"}}}}
FAULTS: dict[str, tuple[dict[str, Any], dict[str, Any], str]] = {
    "no clock": (
        {"z": NOISE[0]},
        VELOCITY,
        r"has no times for z: give a vector time or t \[s\], a number fs or SampleRate \[Hz\], or a step dt \[s\]",
    ),
    "clocks that differ": ({"z": NOISE[0], "t": TIMES, "fs": 501.0}, VELOCITY, r"t has 500 Hz, and 501 Hz is stated"),
    "rates that differ": ({"z": NOISE[0], "dt": 1e-3, "fs": 500.0}, VELOCITY, r"dt = 0\.001, fs = 500 contradict"),
    "no component": ({"t": TIMES}, VELOCITY, r"holds no vector of numbers that could be a component"),
    "no quantity": ({"z": NOISE[0], "fs": RATE}, {}, r"does not say what 'z' holds; set ground\.unit"),
    "other length": ({"z": NOISE[0], "t": TIMES[:-1]}, VELOCITY, r"z has 5000 values and t has 4999"),
    "rate": ({"z": NOISE[0], "fs": -1.0}, VELOCITY, r"fs = -1 must be a positive number, in Hz"),
    "rate in words": ({"z": NOISE[0], "fs": "fast"}, VELOCITY, r"fs = nan must be a positive number"),
    "rate in seconds": (
        {"z": NOISE[0], "fs": 500.0, "fs_unit": "s"},
        VELOCITY,
        r"fs is in 's', which is a unit of time, not of frequency",
    ),
    "days": ({"z": NOISE[0], "t": 738000 + TIMES / 86400}, VELOCITY, r"begins at 738000, as MATLAB's day numbers do"),
    "text": ({"z": "loud", "fs": RATE}, VELOCITY, r"holds no vector of numbers"),
    "unknown unit": ({"z": NOISE[0], "fs": RATE, "z_unit": "furlong"}, {}, r"unit of 'z': 'furlong' is not a unit"),
    "complex": ({"z": NOISE[0] + 1j, "fs": RATE}, VELOCITY, r"z is complex; a time history must be real"),
    "nan": (
        {"z": np.where(TIMES == 1.0, np.nan, NOISE[0]), "fs": RATE},
        VELOCITY,
        r"channel z holds 1 values that are n",
    ),
    "Testlab in g": (
        TESTLAB_G,
        {"axes": {"Signal": "z"}},
        r"states the unit 'g', but not whether its numbers are in it or in SI; say which with ground\.unit",
    ),
}


@pytest.mark.parametrize("fault", FAULTS)
def test_faults_are_named(tmp_path: Path, fault: str) -> None:
    variables, choices, message = FAULTS[fault]
    savemat(tmp_path / "a.mat", variables)
    with pytest.raises(ValueError, match=message):
        motion(tmp_path, "a.mat", **choices)


def test_the_user_says_what_testlab_leaves_open(tmp_path: Path) -> None:
    savemat(tmp_path / "a.mat", TESTLAB_G)
    found = by_axis(read(tmp_path / "a.mat", axes={"Signal": "z"}, unit="g"))["z"]
    np.testing.assert_allclose(found, 9.80665 * NOISE[0], rtol=1e-14)


# --- what only MATLAB can read, and what MATLAB never writes -------------------------------------------------------


def hdf5(folder: Path, build: Callable[[h5py.File], None]) -> Path:
    """A file of version 7.3 with a good vector, a rate, and what ``build`` adds."""
    save_hdf5(folder / "a.mat", {"z": NOISE[0], "fs": RATE})
    with h5py.File(folder / "a.mat", "r+") as file:
        build(file)
    return folder / "a.mat"


def timetable(file: h5py.File) -> None:
    del file["fs"]
    file["tt"] = np.array([[1, 2, 3]], np.uint32)
    file["tt"].attrs["MATLAB_class"] = np.bytes_("timetable")
    file["tt"].attrs["MATLAB_object_decode"] = np.int32(3)


def external(file: h5py.File) -> None:
    file["y"] = h5py.ExternalLink("/etc/hostname", "/")


def soft(file: h5py.File) -> None:
    file["y"] = h5py.SoftLink("/z")


def elsewhere(file: h5py.File) -> None:
    file.create_dataset("y", shape=(1, 5000), dtype=float, external=[("/etc/passwd", 0, 40_000)])


def virtual(file: h5py.File) -> None:
    layout = h5py.VirtualLayout((5000,), float)
    layout[:] = h5py.VirtualSource("other.h5", "z", shape=(5000,))
    file.create_virtual_dataset("y", layout)


def plugin(file: h5py.File) -> None:
    file.create_dataset("y", data=NOISE[0], chunks=(5000,), compression="lzf")


def huge(file: h5py.File) -> None:
    file.create_dataset("y", shape=(2**29 - 2**14,), dtype="i1", chunks=(1024,))


def circle(file: h5py.File) -> None:
    group = file.create_group("s")
    group["s"], group["r"] = group, group


@pytest.mark.parametrize(
    ("build", "message"),
    [
        (timetable, r"only MATLAB can read tt \(timetable\): save numbers or a struct instead"),
        (external, r"/y is a link into another file"),
        (soft, r"y is a link to '/z'; only what is in the file itself is read"),
        (elsewhere, r"/y keeps its values in another file"),
        (virtual, r"/y keeps its values in another file"),
        (plugin, r"y is stored with the filter 32000 lzf; known are deflate, shuffle"),
        (huge, r"y states 5\.37e\+08 numbers; 2\.68e\+08 are allowed; cut the record"),
        (circle, r"structs deep, or holds itself"),
    ],
)
def test_what_is_not_a_number_in_the_file_is_refused(
    tmp_path: Path, build: Callable[[h5py.File], None], message: str
) -> None:
    with pytest.raises(ValueError, match=r"ground\.file = 'a\.mat'.*" + message):
        read(hdf5(tmp_path, build), axes={"y": "x", "z": "z"} if build is not timetable else None, **VELOCITY)


@pytest.mark.parametrize("build", [plugin, huge])
def test_what_is_not_picked_is_not_read(tmp_path: Path, build: Callable[[h5py.File], None]) -> None:
    record = read(hdf5(tmp_path, build), axes={"z": "z"}, **VELOCITY)
    np.testing.assert_array_equal(by_axis(record)["z"], NOISE[0])


def test_sizes_that_a_header_only_claims_are_refused(tmp_path: Path) -> None:
    savemat(tmp_path / "a.mat", {"z": NOISE[0], "fs": RATE})
    content = (tmp_path / "a.mat").read_bytes()
    dimensions = struct.pack("<ii", 1, 5000)
    assert dimensions in content
    (tmp_path / "a.mat").write_bytes(content.replace(dimensions, struct.pack("<ii", 2**15, 2**30)))
    with pytest.raises(ValueError, match=r"z states 32768 × 1073741824 parts in 40048 bytes"):
        read(tmp_path / "a.mat", **VELOCITY)


def element(order: str, kind: int, data: bytes) -> bytes:
    """An element of a file of version 5, in its short form where it has one."""
    if 0 < len(data) <= 4 and kind != 14:
        return struct.pack(f"{order}I", len(data) << 16 | kind) + data.ljust(4, b"\0")
    return struct.pack(f"{order}II", kind, len(data)) + data + b"\0" * (-len(data) % 8)


def by_hand(path: Path, order: str, *matrices: bytes) -> None:
    """A file of version 5 of one byte order."""
    mark = struct.pack(f"{order}HH", 0x0100, 0x4D49)
    path.write_bytes(b"MATLAB 5.0 MAT-file".ljust(124) + mark + b"".join(element(order, 14, m) for m in matrices))


def array(order: str, name: str, code: str, kind: int, values: np.ndarray) -> bytes:
    """A column of doubles, stored as numbers of another kind, as MATLAB does where they fit."""
    flags = element(order, 6, struct.pack(f"{order}II", 6, 0))
    shape = element(order, 5, struct.pack(f"{order}ii", values.size, 1))
    stored = values.astype(np.dtype(code).newbyteorder(order)).tobytes()
    return flags + shape + element(order, 1, name.encode()) + element(order, kind, stored)


@pytest.mark.parametrize("order", "<>")
@pytest.mark.parametrize(
    ("code", "kind"),
    [("i1", 1), ("u1", 2), ("i2", 3), ("u2", 4), ("i4", 5), ("u4", 6), ("f4", 7), ("f8", 9), ("i8", 12), ("u8", 13)],
)
def test_doubles_that_are_stored_as_anything_are_read(tmp_path: Path, order: str, code: str, kind: int) -> None:
    values = np.round(50 + 40 * np.sin(TIMES * 7.0))
    rate = array(order, "fs", "u2", 4, np.array([500.0]))
    by_hand(tmp_path / "a.mat", order, array(order, "z", code, kind, values), rate)
    channel = read(tmp_path / "a.mat", **VELOCITY).channels[0]
    np.testing.assert_array_equal(channel.samples, values)
    assert channel.rate == RATE


@pytest.mark.parametrize("order", "<>")
def test_a_timetable_is_refused_with_the_way_out(tmp_path: Path, order: str) -> None:
    words = [element(order, 1, text.encode()) for text in ("tt", "MCOS", "timetable")]
    inner = array(order, "", "u4", 6, np.arange(6.0))
    opaque = element(order, 6, struct.pack(f"{order}II", 17, 0)) + b"".join(words) + element(order, 14, inner)
    by_hand(tmp_path / "a.mat", order, opaque)
    with pytest.raises(ValueError, match=r"only MATLAB can read tt \(timetable\): save numbers or a struct instead"):
        read(tmp_path / "a.mat", **VELOCITY)
