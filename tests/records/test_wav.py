"""WAV files of every width and layout: written by SciPy and by hand, read back, refused by name."""

import struct
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from oracles.records import RATE, SINE, by_axis, motion, read
from scipy.io import wavfile

from ehamj.records.choices import Choices
from ehamj.records.wav import read_wav

Z = {"axes": {"1": "z"}, "quantity": "velocity", "full_scale": 1.0}


def wav(
    path: Path,
    samples: bytes,
    width: int,
    *,
    kind: int = 1,
    valid: int = 0,
    channels: int = 1,
    extra: bytes = b"",
    claim: int = 0,
    large: bool = False,
) -> Path:
    """A WAV file by the letter: extensible if ``valid`` bits are stated, RF64 if ``large``."""
    rate = int(RATE)
    form = struct.pack(
        "<HHIIHH", 0xFFFE if valid else kind, channels, rate, rate * width * channels, width * channels, 8 * width
    )
    if valid:
        guid = struct.pack("<I", kind) + bytes.fromhex("000010008000 00aa00389b71")
        form += struct.pack("<HHI", 22, valid, 0) + guid
    size = claim or len(samples)
    body = b"fmt " + struct.pack("<I", len(form)) + form + extra
    if large:
        body = b"ds64" + struct.pack("<IQQQI", 28, 4 + 36 + len(body) + 8 + size, size, len(samples) // width, 0) + body
    body += b"data" + struct.pack("<I", 0xFFFFFFFF if large else size) + samples
    path.write_bytes((b"RF64" + b"\xff" * 4 if large else b"RIFF" + struct.pack("<I", len(body) + 4)) + b"WAVE" + body)
    return path


def packed(samples: np.ndarray, width: int) -> bytes:
    """Whole numbers of so many bytes, little-endian."""
    return b"".join(int(v).to_bytes(width, "little", signed=True) for v in np.round(samples * 2 ** (8 * width - 1)))


@given(
    arrays(np.int16, st.tuples(st.integers(16, 60), st.integers(1, 3))),
    st.floats(1e-6, 1.0),
    st.integers(8, 48_000),
)
@settings(suppress_health_check=[HealthCheck.function_scoped_fixture])
def test_integers_are_shares_of_the_full_scale(tmp_path: Path, data: np.ndarray, full: float, rate: int) -> None:
    wavfile.write(tmp_path / "a.wav", rate, data)
    axes = {str(n + 1): "xyz"[n] for n in range(data.shape[1])}
    record = read(tmp_path / "a.wav", axes=axes, quantity="velocity", full_scale=full)
    for n, axis in enumerate("xyz"[: data.shape[1]]):
        np.testing.assert_allclose(by_axis(record)[axis], full * data[:, n] / 32768.0, rtol=1e-14)
    assert {channel.rate for channel in record.channels} == {float(rate)}


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
def test_any_width_is_the_same_motion(tmp_path: Path, data: np.ndarray, tolerance: float) -> None:
    wavfile.write(tmp_path / "a.wav", int(RATE), data)
    record = read(tmp_path / "a.wav", axes={"1": "z"}, unit="mm/s", full_scale=2.0)
    np.testing.assert_allclose(by_axis(record)["z"], 2e-3 * SINE, rtol=0, atol=2e-3 * tolerance + 1e-18)


@pytest.mark.parametrize(
    ("samples", "options", "tolerance"),
    [
        (packed(SINE, 3), {"width": 3}, 2**-23),
        (packed(SINE, 3), {"width": 3, "valid": 24}, 2**-23),
        (packed(SINE, 2), {"width": 2, "valid": 16}, 2**-15),
        (packed(np.round(SINE * 2**23) / 2**23, 4), {"width": 4, "valid": 24}, 2**-23),
        (SINE.astype("<f4").tobytes(), {"width": 4, "valid": 32, "kind": 3}, 1e-7),
        (packed(SINE, 3), {"width": 3, "large": True}, 2**-23),
        (packed(SINE, 2), {"width": 2, "extra": b"bext" + struct.pack("<I", 5) + b"abcde\0"}, 2**-15),
    ],
    ids=["24 bit", "extensible 24", "extensible 16", "24 in 32 bit", "extensible float", "RF64", "odd chunk before"],
)
def test_every_layout_is_the_same_motion(
    tmp_path: Path, samples: bytes, options: dict[str, Any], tolerance: float
) -> None:
    found = by_axis(read(wav(tmp_path / "a.wav", samples, **options), **Z))["z"]
    np.testing.assert_allclose(found, SINE, rtol=0, atol=tolerance)


def test_big_endian_is_read(tmp_path: Path) -> None:
    form = struct.pack(">HHIIHH", 1, 1, int(RATE), 2 * int(RATE), 2, 16)
    samples = np.round(SINE * 2**15).astype(">i2").tobytes()
    body = b"WAVEfmt " + struct.pack(">I", 16) + form + b"data" + struct.pack(">I", len(samples)) + samples
    (tmp_path / "a.wav").write_bytes(b"RIFX" + struct.pack(">I", len(body)) + body)
    np.testing.assert_allclose(by_axis(read(tmp_path / "a.wav", **Z))["z"], SINE, atol=2**-15)


def test_chunks_that_could_state_a_scale_are_said_not_to_be_read(tmp_path: Path) -> None:
    extra = b"bext" + struct.pack("<I", 4) + b"g=10" + b"iXML" + struct.pack("<I", 4) + b"<a/>"
    record = read(wav(tmp_path / "a.wav", packed(SINE, 2), 2, extra=extra), **Z)
    assert "chunks bext, iXML are not read: what they state of a scale is ground.full_scale's" in record.notes


def test_each_component_may_have_a_full_scale_of_its_own(tmp_path: Path) -> None:
    wavfile.write(tmp_path / "a.wav", int(RATE), np.stack([SINE, SINE], axis=1))
    choices = {"axes": {"1": "x", "2": "z"}, "unit": "mm/s"}
    found = by_axis(read(tmp_path / "a.wav", full_scale={"1": 2.0, "z": 3.0}, **choices))
    np.testing.assert_allclose(found["x"], 2e-3 * SINE, rtol=1e-14)
    np.testing.assert_allclose(found["z"], 3e-3 * SINE, rtol=1e-14)
    with pytest.raises(ValueError, match=r"ground\.full_scale names 1, but neither component 2 nor its axis"):
        read(tmp_path / "a.wav", full_scale={"1": 2.0}, **choices)


@pytest.mark.parametrize(
    ("scales", "message"),
    [
        ({"1": 2.0, "2": 3.0, "y": 3.0}, r"names 'y', which is no component in use; 'a\.wav' holds 1 \(x\), 2 \(z\)"),
        ({"1": 2.0, "x": 5.0, "z": 3.0}, r"names component 1 of 'a\.wav' twice, as '1' and as 'x'; leave one"),
        ({"1": 2.0, "z": 3.0, "7": 3.0}, r"names '7', which is no component in use"),
    ],
)
def test_full_scales_that_serve_nothing_are_refused(tmp_path: Path, scales: dict[str, float], message: str) -> None:
    wavfile.write(tmp_path / "a.wav", int(RATE), np.stack([SINE, SINE], axis=1))
    with pytest.raises(ValueError, match=r"ground\.full_scale " + message):
        read(tmp_path / "a.wav", axes={"1": "x", "2": "z"}, unit="mm/s", full_scale=scales)


def test_a_full_scale_of_a_direction_serves_every_mount(tmp_path: Path) -> None:
    wavfile.write(tmp_path / "a.wav", int(RATE), np.stack([SINE, SINE, SINE], axis=1))
    axes = {"1": "front-left z", "2": "front-right z"}
    record = read(tmp_path / "a.wav", axes=axes, unit="m/s", full_scale={"z": 2.0, "front-right z": 3.0, "3": 9.0})
    np.testing.assert_allclose(by_axis(record)["front-left z"], 2.0 * SINE, rtol=1e-14)
    np.testing.assert_allclose(by_axis(record)["front-right z"], 3.0 * SINE, rtol=1e-14)


def test_samples_at_the_full_scale_are_called_clipped(tmp_path: Path) -> None:
    wavfile.write(tmp_path / "a.wav", int(RATE), np.clip(4 * SINE, -1.0, 32767 / 32768))
    record = read(tmp_path / "a.wav", **{**Z, "full_scale": 1e-3})
    assert any("1 looks clipped: " in note and "at the WAV file's full scale" in note for note in record.notes)


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({}, r"ground\.full_scale is missing: a WAV file does not say what its samples mean"),
        ({"full_scale": 1.0, "axes": {"1": "z"}}, r"ground\.quantity = 'auto', .*'1' holds; set ground\.unit"),
        ({"full_scale": 1.0, "unit": "g"}, r"ground\.axes does not say which axis '1' is; name it"),
        ({"full_scale": 1.0, "unit": "g", "axes": {"2": "z"}}, r"ground\.axes names '2', .*it holds '1'"),
        ({"full_scale": 1.0, "inventory": "b.xml"}, r"ground\.inventory = 'b\.xml' is of use with .*is a WAV file"),
    ],
)
def test_faults_are_named(tmp_path: Path, options: dict[str, Any], message: str) -> None:
    wavfile.write(tmp_path / "a.wav", int(RATE), SINE)
    with pytest.raises(ValueError, match=message):
        motion(tmp_path, "a.wav", **options)


def test_a_truncated_file_is_refused(tmp_path: Path) -> None:
    wavfile.write(tmp_path / "a.wav", int(RATE), SINE)
    (tmp_path / "a.wav").write_bytes((tmp_path / "a.wav").read_bytes()[:-1000])
    with pytest.raises(ValueError, match=r"ground\.file = 'a\.wav' cannot be read as WAV: it is truncated: it states"):
        motion(tmp_path, "a.wav", full_scale=1.0, unit="g", axes={"1": "z"})


@pytest.mark.parametrize("large", [False, True])
def test_bytes_that_a_header_only_claims_are_refused(tmp_path: Path, large: bool) -> None:
    path = wav(tmp_path / "a.wav", packed(SINE, 2), 2, claim=2**42 if large else 2**32 - 2, large=large)
    with pytest.raises(ValueError, match=r"it states \d+ bytes of samples and holds 10000"):
        read(path, **Z)


def test_a_file_that_no_memory_holds_is_refused_before_it_is_read(tmp_path: Path) -> None:
    """All holes: it needs no disk, and would unfold to 25 TiB."""
    path, bytes_held = tmp_path / "long.wav", 2**40
    fmt = struct.pack("<IHHIIHH", 16, 1, 1, 48000, 96000, 2, 16)
    ds64 = struct.pack("<IQQQI", 28, bytes_held + 72, bytes_held, bytes_held // 2, 0)
    with path.open("wb") as file:
        file.write(b"RF64\xff\xff\xff\xffWAVEds64" + ds64 + b"fmt " + fmt + b"data\xff\xff\xff\xff")
        file.truncate(file.tell() + bytes_held)
    with pytest.raises(ValueError, match=r"of 5\.5e\+11 samples each component needs about 2\.56e\+04 GiB"):
        read_wav(path, Choices(full_scale=1.0, quantity="velocity", unit="m/s"))
