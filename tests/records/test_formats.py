"""Records in UFF, WAV and MATLAB files: written by other libraries, read back, refused by name."""

import struct
from pathlib import Path
from typing import Any

import h5py
import numpy as np
import pytest
import pyuff
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from pydantic import ValidationError
from scipy.io import savemat, wavfile

from ehamj.ground import Motion, Start
from ehamj.ground.records import RecordGround
from ehamj.plant.mounts import MOUNTS
from ehamj.records.channel import Record
from ehamj.records.choices import Choices
from ehamj.records.matlab import read_matlab
from ehamj.records.uff import read_uff
from ehamj.records.wav import read_wav
from ehamj.scenario.load import anchored

settings.register_profile("untimed", deadline=None)  # machines stall
settings.load_profile("untimed")

POSITIONS = np.array([[0.9, 0.6], [0.9, -0.6], [-0.9, 0.6], [-0.9, -0.6]])
RATE = 500.0
NOISE = np.random.default_rng(3).standard_normal((3, 5000)) * 1e-5
TIMES = np.arange(5000) / RATE
VELOCITY = Choices(quantity="velocity")


def motion(folder: Path, file: str, **settings: Any) -> Motion:
    table = anchored({"kind": "record", "file": file, **settings}, RecordGround, folder)
    return RecordGround(**table).motion(Start(MOUNTS, POSITIONS, 5.0, 1))


def by_axis(record: Record) -> dict[str, np.ndarray]:
    return {channel.axis: channel.samples for channel in record.channels}


# --- UFF ----------------------------------------------------------------------------------------------------------


def response(samples: np.ndarray, direction: int, label: str = "m/s", node: int = 1, **other: Any) -> dict[str, Any]:
    """Dataset 58 of a time response."""
    content: dict[str, Any] = {
        **{"binary": 1, "func_type": 1, "rsp_node": node, "rsp_dir": direction, "ref_node": 0, "ref_dir": 0},
        **{"ord_data_type": 4, "abscissa_spacing": 1, "abscissa_min": 0.0, "abscissa_inc": 1 / RATE},
        **{"ordinate_spec_data_type": 11, "ordinate_axis_units_lab": label, "abscissa_spec_data_type": 17},
        **{"orddenom_spec_data_type": 0, "z_axis_spec_data_type": 0},
        **{"num_pts": samples.size, "data": samples, "x": TIMES[: samples.size], **other},
    }
    return pyuff.prepare_58(**content)


def uff(folder: Path, *sets: dict[str, Any], name: str = "a.uff") -> Path:
    file = pyuff.UFF(str(folder / name))
    for content in sets:
        file.write_sets(content, "add")
    return folder / name


@pytest.mark.parametrize("binary", [0, 1])
def test_uff_directions_are_axes_and_signs(tmp_path: Path, binary: int) -> None:
    sets = [response(NOISE[k], way, binary=binary) for k, way in enumerate((1, -2, 3))]
    found = by_axis(read_uff(uff(tmp_path, *sets)))
    # ASCII holds 12 digits.
    for axis, sign, samples in zip("xyz", (1, -1, 1), NOISE, strict=True):
        np.testing.assert_allclose(found[axis], sign * samples, rtol=1e-11 if binary == 0 else 0, atol=0)


@pytest.mark.parametrize(("label", "kind", "size"), [("mm/s^2", 12, 1e-3), ("g", 12, 9.80665), ("µm", 8, 1e-6)])
def test_uff_units_are_those_of_the_label(tmp_path: Path, label: str, kind: int, size: float) -> None:
    path = uff(tmp_path, response(NOISE[0], 3, label, ordinate_spec_data_type=kind))
    channel = read_uff(path).channels[0]
    assert channel.quantity == {8: "displacement", 12: "acceleration"}[kind]
    np.testing.assert_allclose(channel.samples, size * NOISE[0], rtol=1e-12)
    assert channel.rate == pytest.approx(RATE, rel=1e-9)


def test_uff_without_label_is_si_by_its_data_type_and_says_so(tmp_path: Path) -> None:
    record = read_uff(uff(tmp_path, response(NOISE[0], 3, "NONE", ordinate_spec_data_type=12)))
    assert record.channels[0].quantity == "acceleration"
    assert any("1:+Z has no unit label: taken as SI" in note for note in record.notes)


def test_uff_of_several_nodes_takes_the_one_that_is_named(tmp_path: Path) -> None:
    path = uff(tmp_path, response(NOISE[0], 3, node=1), response(NOISE[1], 3, node=7))
    record = read_uff(path, Choices(axes={"7:+Z": "z"}))
    np.testing.assert_array_equal(by_axis(record)["z"], NOISE[1])


def test_uff_becomes_motion(tmp_path: Path) -> None:
    uff(tmp_path, response(1e-4 * np.sin(2 * np.pi * 20 * TIMES), 3))
    velocity = motion(tmp_path, "a.uff").sample(np.linspace(2.0, 4.0, 400)).velocity[:, 0, 2]
    # 20 Hz is 200 corners of the high-pass away; 1e-3 is the spline's share (see the record's tests).
    assert np.abs(velocity).max() == pytest.approx(1e-4, rel=2e-3)


UNITS_164 = {"type": 164, "units_code": 9, "units_description": "mm", "temp_mode": 1}
UNITS_164 |= {"length": 1000.0, "force": 1.0, "temp": 1.0, "temp_offset": 273.15}
UFF_FAULTS = {
    "spectrum": ([response(NOISE[0], 3, func_type=9)], {}, r"holds no time response \(dataset 58, function type 1\)"),
    "two nodes": (
        [response(NOISE[0], 3, node=1), response(NOISE[1], 3, node=7)],
        {},
        r"ground\.axes: '1:\+Z', '7:\+Z' are all z; each axis takes one component",
    ),
    "twice": ([response(NOISE[0], 3), response(NOISE[1], 3)], {}, r"several time responses of one node and direction"),
    "scalar": ([response(NOISE[0], 0)], {}, r"ground\.axes does not say which axis '1:0' is"),
    "unknown unit": (
        [response(NOISE[0], 3, "furlong")],
        {},
        r"the unit of UFF component '1:\+Z': 'furlong' is not a unit that is known",
    ),
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
    "not SI": ([UNITS_164, response(NOISE[0], 3, "NONE")], {}, r"dataset 164 says that the file is not in SI"),
    "unit twice": (
        [response(NOISE[0], 3)],
        {"unit": "mm/s"},
        r"ground\.unit = 'mm/s', but the file states another unit of",
    ),
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
    "inventory": (
        [response(NOISE[0], 3)],
        {"inventory": "b.xml"},
        r"ground\.inventory = 'b\.xml': a universal file",
    ),
}


@pytest.mark.parametrize("fault", UFF_FAULTS)
def test_uff_faults_are_named(tmp_path: Path, fault: str) -> None:
    sets, options, message = UFF_FAULTS[fault]
    uff(tmp_path, *sets)
    with pytest.raises(ValueError, match=message):
        motion(tmp_path, "a.uff", **options)


def test_a_truncated_uff_is_refused(tmp_path: Path) -> None:
    path = uff(tmp_path, response(NOISE[0], 3))
    path.write_bytes(path.read_bytes()[:-10_000])
    with pytest.raises(ValueError, match=r"ground\.file = 'a\.uff'.*(truncated|cannot be read|holds no time response)"):
        read_uff(path)


# --- WAV ----------------------------------------------------------------------------------------------------------


@given(
    arrays(np.int16, st.tuples(st.integers(16, 60), st.integers(1, 3))),
    st.floats(1e-6, 1.0),
    st.integers(8, 48_000),
)
@settings(suppress_health_check=[HealthCheck.function_scoped_fixture])
def test_wav_integers_are_shares_of_the_full_scale(tmp_path: Path, data: np.ndarray, full: float, rate: int) -> None:
    wavfile.write(tmp_path / "a.wav", rate, data)
    axes = {str(n + 1): "xyz"[n] for n in range(data.shape[1])}
    record = read_wav(tmp_path / "a.wav", Choices(axes=axes, quantity="velocity", full_scale=full))  # type: ignore[arg-type]
    for n, axis in enumerate("xyz"[: data.shape[1]]):
        np.testing.assert_allclose(by_axis(record)[axis], full * data[:, n] / 32768.0, rtol=1e-14)
    assert {channel.rate for channel in record.channels} == {float(rate)}


SINE = 0.5 * np.sin(2 * np.pi * 20 * TIMES)


@pytest.mark.parametrize(
    ("data", "tolerance"),
    [
        (np.round(128 + 128 * SINE).astype(np.uint8), 0.5 / 128),
        (np.round(2**31 * SINE).astype(np.int32), 1e-9),
        (SINE.astype(np.float32), 1e-7),
        (SINE, 0.0),
    ],
    ids=["8 bit", "32 bit", "float", "double"],
)
def test_wav_of_any_width_is_the_same_motion(tmp_path: Path, data: np.ndarray, tolerance: float) -> None:
    wavfile.write(tmp_path / "a.wav", int(RATE), data)
    record = read_wav(tmp_path / "a.wav", Choices(axes={"1": "z"}, unit="mm/s", full_scale=2.0))
    np.testing.assert_allclose(by_axis(record)["z"], 2e-3 * SINE, rtol=0, atol=2e-3 * tolerance + 1e-18)


def test_wav_of_24_bit_is_the_same_motion(tmp_path: Path) -> None:
    samples = b"".join(int(v).to_bytes(3, "little", signed=True) for v in np.round(2**23 * SINE))
    form = struct.pack("<HHIIHH", 1, 1, int(RATE), int(RATE) * 3, 3, 24)
    body = b"WAVEfmt " + struct.pack("<I", 16) + form + b"data" + struct.pack("<I", len(samples)) + samples
    (tmp_path / "a.wav").write_bytes(b"RIFF" + struct.pack("<I", len(body)) + body)
    record = read_wav(tmp_path / "a.wav", Choices(axes={"1": "z"}, quantity="velocity", full_scale=1.0))
    np.testing.assert_allclose(by_axis(record)["z"], SINE, rtol=0, atol=1e-7)


def test_wav_at_its_full_scale_is_called_clipped(tmp_path: Path) -> None:
    wavfile.write(tmp_path / "a.wav", int(RATE), np.clip(4 * SINE, -1.0, 32767 / 32768))
    record = read_wav(tmp_path / "a.wav", Choices(axes={"1": "z"}, quantity="velocity", full_scale=1e-3))
    assert any("1 looks clipped: " in note and "at the WAV file's full scale" in note for note in record.notes)


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({}, r"ground\.full_scale is missing: a WAV file does not say what its samples mean"),
        ({"full_scale": 1.0, "axes": {"1": "z"}}, r"ground\.quantity = 'auto', .*'1' holds.*set ground\.unit"),
        ({"full_scale": 1.0, "unit": "g"}, r"ground\.axes does not say which axis '1' is; name it"),
        ({"full_scale": 1.0, "unit": "g", "axes": {"2": "z"}}, r"ground\.axes names '2', .*it holds '1'"),
        ({"full_scale": 1.0, "inventory": "b.xml"}, r"ground\.inventory = 'b\.xml': a WAV file has units"),
    ],
)
def test_wav_faults_are_named(tmp_path: Path, options: dict[str, Any], message: str) -> None:
    wavfile.write(tmp_path / "a.wav", int(RATE), SINE)
    with pytest.raises(ValueError, match=message):
        motion(tmp_path, "a.wav", **options)


def test_a_truncated_wav_is_refused(tmp_path: Path) -> None:
    wavfile.write(tmp_path / "a.wav", int(RATE), SINE)
    (tmp_path / "a.wav").write_bytes((tmp_path / "a.wav").read_bytes()[:-1000])
    with pytest.raises(ValueError, match=r"ground\.file = 'a\.wav' is truncated|cannot be read as WAV"):
        motion(tmp_path, "a.wav", full_scale=1.0, unit="g", axes={"1": "z"})


# --- MATLAB -------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("clock", [{"t": TIMES}, {"time": TIMES[:, None]}, {"fs": RATE}, {"Fs": RATE}])
@pytest.mark.parametrize("version", ["5", "4", "7.3"])
def test_matlab_vectors_of_any_version_are_components(tmp_path: Path, clock: dict[str, Any], version: str) -> None:
    variables = {"x": NOISE[0], "z": NOISE[2][:, None], "note": "a floor", **clock}
    if version == "7.3":
        with h5py.File(tmp_path / "a.mat", "w", userblock_size=512) as file:
            for name, value in variables.items():
                # MATLAB stores arrays by columns, so that HDF5 sees them transposed, and text as numbers of its own.
                file[name] = np.atleast_2d(value).T if not isinstance(value, str) else value
        content = (tmp_path / "a.mat").read_bytes()
        header = b"MATLAB 7.3 MAT-file".ljust(124) + struct.pack("<H", 0x0200) + b"IM"
        (tmp_path / "a.mat").write_bytes(header + content[128:])
    else:
        savemat(tmp_path / "a.mat", variables, format=version)
    record = read_matlab(tmp_path / "a.mat", VELOCITY)
    np.testing.assert_array_equal(by_axis(record)["x"], NOISE[0])
    np.testing.assert_array_equal(by_axis(record)["z"], NOISE[2])
    assert record.channels[0].rate == pytest.approx(RATE, rel=1e-12)


@pytest.mark.parametrize("matrix", [NOISE, NOISE.T], ids=["rows", "columns"])
def test_matlab_matrices_are_columns(tmp_path: Path, matrix: np.ndarray) -> None:
    savemat(tmp_path / "a.mat", {"data": matrix, "fs": RATE})
    choices = Choices(axes={"data(1)": "x", "data(3)": "z"}, unit="um/s")
    found = by_axis(read_matlab(tmp_path / "a.mat", choices))
    np.testing.assert_allclose(found["x"], 1e-6 * NOISE[0], rtol=1e-14)
    np.testing.assert_allclose(found["z"], 1e-6 * NOISE[2], rtol=1e-14)


MATLAB_FAULTS = {
    "no clock": ({"z": NOISE[0]}, VELOCITY, r"give a vector time or t \[s\] or a number .*; there is none"),
    "two clocks": ({"z": NOISE[0], "t": TIMES, "fs": RATE}, VELOCITY, r"there is t, fs"),
    "no component": ({"t": TIMES}, VELOCITY, r"holds no vector of numbers that could be a component"),
    "no quantity": ({"z": NOISE[0], "fs": RATE}, Choices(), r"does not say what 'z' holds"),
    "other length": ({"z": NOISE[0], "t": TIMES[:-1]}, VELOCITY, r"t has 4999 values and the components have 5000"),
    "rate": ({"z": NOISE[0], "fs": -1.0}, VELOCITY, r"fs = -1 must be a positive number, in Hz"),
    "uneven": ({"z": NOISE[0], "t": TIMES**1.01}, VELOCITY, r"sampling is not uniform"),
    "text": ({"z": "loud", "fs": RATE}, VELOCITY, r"holds no vector of numbers"),
    "nan": (
        {"z": np.where(TIMES == 1.0, np.nan, NOISE[0]), "fs": RATE},
        VELOCITY,
        r"channel z holds 1 values that are n",
    ),
}


@pytest.mark.parametrize("fault", MATLAB_FAULTS)
def test_matlab_faults_are_named(tmp_path: Path, fault: str) -> None:
    variables, choices, message = MATLAB_FAULTS[fault]
    savemat(tmp_path / "a.mat", variables)
    with pytest.raises(ValueError, match=message):
        read_matlab(tmp_path / "a.mat", choices)


def test_a_gap_in_matlab_times_is_filled_where_it_may_be(tmp_path: Path) -> None:
    kept = (TIMES < 3.0) | (TIMES >= 3.5)
    savemat(tmp_path / "a.mat", {"z": NOISE[0][kept], "t": TIMES[kept]})
    with pytest.raises(ValueError, match=r"1 gap, 0\.5 s in total"):
        read_matlab(tmp_path / "a.mat", VELOCITY)
    record = read_matlab(tmp_path / "a.mat", Choices(quantity="velocity", gaps="interpolate"))
    np.testing.assert_allclose(by_axis(record)["z"][kept], NOISE[0][kept], rtol=1e-12)


# --- all of them --------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("ending", ["uff", "unv", "wav", "mat"])
@given(st.binary(max_size=400))
@settings(suppress_health_check=[HealthCheck.function_scoped_fixture], max_examples=60)
def test_any_bytes_are_refused_by_name(tmp_path: Path, ending: str, content: bytes) -> None:
    (tmp_path / f"a.{ending}").write_bytes(content)
    with pytest.raises(ValueError, match=r"^ground\.file = 'a\."):
        motion(tmp_path, f"a.{ending}", quantity="velocity", **({"full_scale": 1.0} if ending == "wav" else {}))


@pytest.mark.parametrize("ending", ["uff", "wav", "mat"])
def test_files_that_are_missing_are_named(tmp_path: Path, ending: str) -> None:
    with pytest.raises(ValueError, match=rf"^ground\.file = 'no\.{ending}'.*(no such file|No such file)"):
        motion(tmp_path, f"no.{ending}", quantity="velocity", **({"full_scale": 1.0} if ending == "wav" else {}))


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"file": "a.mat", "unit": "lb"}, r"unit = 'lb' is not a unit that is known"),
        ({"file": "a.mat", "unit": "g", "quantity": "velocity"}, r"quantity = 'velocity' is not what unit = 'g' is of"),
        ({"file": "a.mat", "full_scale": 1.0}, r"full_scale = 1 is for \*\.wav files only"),
        ({"file": "a.wav", "full_scale": 0.0}, r"full_scale"),
    ],
)
def test_settings_are_checked_before_any_file_is_read(options: dict[str, Any], message: str) -> None:
    with pytest.raises(ValidationError, match=message):
        RecordGround(kind="record", **options)
