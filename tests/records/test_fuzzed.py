"""Damaged files of every format end in a refusal or a record: no traceback, no hang, no memory for empty claims."""

import time
import tracemalloc
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import pyuff
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from nptdms import ChannelObject, TdmsWriter
from oracles.damage import damaged
from oracles.records import motion, read
from pydantic import ValidationError
from scipy.io import savemat, wavfile

from ehamj.ground.records import RecordGround

SAMPLES = np.random.default_rng(7).standard_normal(64)
MANY = 160
"""Damaged files of each format."""

LONGEST = 5.0
"""Longest time that one of them may take [s]: they take milliseconds, the machine may stall."""

MOST = 100e6
"""Memory that one of them may ask for [bytes]: none holds more than a few kB."""


def uff(path: Path, binary: int) -> None:
    for direction in (1, 3):
        content = pyuff.prepare_58(
            binary=binary,
            func_type=1,
            rsp_node=1,
            rsp_dir=direction,
            ref_dir=0,
            ref_node=0,
            data=SAMPLES,
            x=np.arange(64) / 500,
            num_pts=64,
            abscissa_spacing=1,
            abscissa_inc=2e-3,
            abscissa_min=0.0,
            ord_data_type=4,
            abscissa_spec_data_type=17,
            ordinate_spec_data_type=11,
            orddenom_spec_data_type=0,
            z_axis_spec_data_type=0,
            ordinate_axis_units_lab="mm/s",
            abscissa_axis_units_lab="s",
        )
        pyuff.UFF(str(path)).write_sets(content, "add")


def matlab(path: Path, compressed: bool) -> None:
    savemat(path, {"z": SAMPLES, "s": {"x": SAMPLES, "fs": 500.0}, "t": np.arange(64) / 500}, do_compression=compressed)


def hdf5(path: Path) -> None:
    import h5py

    with h5py.File(path, "w") as file:
        file["z"], file["fs"] = SAMPLES[None], np.array([[500.0]])
        file["s/x"], file["s/units"] = SAMPLES[None], np.array([[109], [47], [115]], np.uint16)


def tdms(path: Path) -> None:
    with TdmsWriter(path) as writer:
        for _ in range(2):
            properties = {"wf_increment": 2e-3, "wf_start_offset": 0.0, "unit_string": "mm/s"}
            writer.write_segment([ChannelObject("a", name, SAMPLES, properties) for name in ("x", "z")])


def wav(path: Path) -> None:
    wavfile.write(path, 500, np.stack([SAMPLES, SAMPLES], 1).astype(np.float32) * 0.1)


def peer(path: Path) -> None:
    head = "PEER NGA\nMade up, 1/5/2026, here, UP\nACCELERATION TIME SERIES IN UNITS OF G\nNPTS=  64, DT= .0050 SEC\n"
    path.write_text(head + "\n".join("".join(f"{v:15.7E}" for v in SAMPLES[k : k + 5]) for k in range(0, 64, 5)))


def esm(path: Path) -> None:
    header = {"EVENT_NAME": "A", "STREAM": "HNZ", "SAMPLING_INTERVAL_S": "0.005", "NDATA": "64", "UNITS": "cm/s^2"}
    lines = [f"{key}: {value}" for key, value in {**header, "DATA_TYPE": "ACCELERATION"}.items()]
    path.write_text("\n".join([*lines, *(f"{v:.6e}" for v in SAMPLES)]))


def ide(path: Path) -> None:
    from ebmlite import loadSchema

    sub = {"SubChannelID": 0, "SubChannelName": "Z", "SubChannelUnits": "g", "SubChannelCalibrationIDRef": 1}
    channel = {"ChannelID": 8, "ChannelName": "a", "ChannelFormat": "<h", "TimeCodeScale": "1/1000000"}
    channel |= {"SampleRate": "500", "SubChannel": [sub]}
    head = {
        "EBML": {"DocType": "mide", "DocTypeVersion": 2, "DocTypeReadVersion": 2},
        "CalibrationList": {"UnivariatePolynomial": [{"CalID": 1, "PolynomialCoef": [1e-3, 0.5]}]},
        "RecordingProperties": {
            "SensorList": {"Sensor": [{"SensorID": 0, "SensorName": "a"}]},
            "ChannelList": {"Channel": [channel]},
        },
    }
    payload = (1000 * SAMPLES).astype("<i2").tobytes()
    block = {"ChannelIDRef": 8, "StartTimeCodeAbs": 0, "EndTimeCodeAbs": 126_000, "ChannelDataPayload": payload}
    schema = loadSchema("mide_ide.xml")
    path.write_bytes(
        b"".join(bytes(schema[name].encode(value)) for name, value in (*head.items(), ("ChannelDataBlock", block)))
    )


FORMATS: dict[str, tuple[str, Callable[[Path], None]]] = {
    "UFF": ("a.uff", lambda path: uff(path, 0)),
    "binary UFF": ("a.unv", lambda path: uff(path, 1)),
    "MATLAB": ("a.mat", lambda path: matlab(path, False)),
    "compressed MATLAB": ("a.mat", lambda path: matlab(path, True)),
    "MATLAB 7.3": ("a.mat", hdf5),
    "TDMS": ("a.tdms", tdms),
    "WAV": ("a.wav", wav),
    "IDE": ("a.ide", ide),
    "PEER": ("a.at2", peer),
    "ESM": ("a.asc", esm),
}


def outcome(path: Path, **options: Any) -> str:
    """What becomes of a file: empty for a record, else the refusal."""
    try:
        record = read(path, **options)
    except ValueError as error:
        return str(error)
    assert all(channel.rate > 0 for channel in record.channels)
    return ""


@pytest.mark.parametrize("name", FORMATS)
def test_damaged_files_are_refused_or_read(tmp_path: Path, name: str) -> None:
    file, write = FORMATS[name]
    options: dict[str, Any] = {"quantity": "velocity"} if file in ("a.mat", "a.wav") else {}
    options |= {"full_scale": 1.0, "axes": {"1": "x", "2": "z"}} if file == "a.wav" else {}
    write(tmp_path / file)
    intact = (tmp_path / file).read_bytes()
    assert not outcome(tmp_path / file, **options)
    random = np.random.default_rng(11)
    refused = 0
    tracemalloc.start()
    try:
        for _ in range(MANY):
            (tmp_path / file).write_bytes(damaged(intact, random, 400, texts=True))
            tracemalloc.reset_peak()
            begin = time.process_time()
            said = outcome(tmp_path / file, **options)
            assert time.process_time() - begin < LONGEST
            assert tracemalloc.get_traced_memory()[1] < MOST
            assert not said or said.startswith("ground.")
            assert "\n" not in said
            refused += bool(said)
    finally:
        tracemalloc.stop()
    assert refused > MANY / 10  # the damage does some


@pytest.mark.parametrize("ending", ["uff", "unv", "wav", "mat", "tdms", "ide", "at2", "asc"])
@given(st.binary(max_size=400))
@settings(suppress_health_check=[HealthCheck.function_scoped_fixture], max_examples=40)
def test_any_bytes_are_refused_by_name(tmp_path: Path, ending: str, content: bytes) -> None:
    (tmp_path / f"a.{ending}").write_bytes(content)
    with pytest.raises(ValueError, match=r"^ground\.(file = 'a\.|axes does not say which axis 'a\.)"):
        motion(tmp_path, f"a.{ending}", quantity="velocity", **({"full_scale": 1.0} if ending == "wav" else {}))


@pytest.mark.parametrize("ending", ["uff", "wav", "mat", "tdms", "ide", "at2", "asc"])
def test_files_that_are_missing_are_named(tmp_path: Path, ending: str) -> None:
    with pytest.raises(ValueError, match=rf"^ground\.file = 'no\.{ending}'.*(no such file|No such file)"):
        motion(tmp_path, f"no.{ending}", quantity="velocity", **({"full_scale": 1.0} if ending == "wav" else {}))


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"file": "a.mat", "unit": "lb"}, r"unit = 'lb' is not a unit that is known"),
        ({"file": "a.mat", "unit": "g", "quantity": "velocity"}, r"quantity = 'velocity' is not what unit = 'g' is of"),
        ({"file": "a.mat", "full_scale": 1.0}, r"full_scale = 1\.0 is for \*\.wav files only"),
        ({"file": "a.wav", "full_scale": 0.0}, r"full_scale"),
        ({"file": "a.wav", "full_scale": {"1": -1.0}}, r"full_scale"),
    ],
)
def test_settings_are_checked_before_any_file_is_read(options: dict[str, Any], message: str) -> None:
    with pytest.raises(ValidationError, match=message):
        RecordGround(kind="record", **options)
