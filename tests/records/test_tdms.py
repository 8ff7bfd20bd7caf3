"""TDMS files: written by npTDMS as LabVIEW does, read back, refused by name."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from nptdms import ChannelObject, GroupObject, RootObject, TdmsWriter
from oracles.records import NOISE, RATE, TIMES, by_axis, motion, read

WAVEFORM = {"wf_increment": 1 / RATE, "wf_start_offset": 0.0}


def channel(name: str, data: Any, group: str = "Floor", **properties: Any) -> ChannelObject:
    return ChannelObject(group, name, data, properties=properties)


def tdms(folder: Path, *channels: ChannelObject, segments: int = 1) -> Path:
    """A file of one or more segments with the same channels."""
    with TdmsWriter(folder / "a.tdms") as writer:
        for _ in range(segments):
            writer.write_segment([RootObject({"name": "made up"}), GroupObject("Floor"), *channels])
    return folder / "a.tdms"


def test_waveforms_are_components_of_their_unit(tmp_path: Path) -> None:
    path = tdms(
        tmp_path,
        channel("X", NOISE[0], unit_string="g", **WAVEFORM),
        channel("Acceleration z", NOISE[2], unit_string="mm/s^2", **WAVEFORM),
    )
    record = read(path)
    np.testing.assert_allclose(by_axis(record)["x"], 9.80665 * NOISE[0], rtol=1e-14)
    np.testing.assert_allclose(by_axis(record)["z"], 1e-3 * NOISE[2], rtol=1e-14)
    assert [c.name for c in record.channels] == ["Floor/X", "Floor/Acceleration z"]
    assert {c.rate for c in record.channels} == {RATE}


UNITS = {"g": 9.80665, "G": 9.80665, "m/s^2": 1.0, "m/s²": 1.0, "M/S**2": 1.0, "mm/s^2": 1e-3, "mg": 9.80665e-3}
UNITS |= {"in/s^2": 0.0254, "Gal": 1e-2, "um/s^2": 1e-6, "(m/s^2)": 1.0, "[g]": 9.80665}
SECONDS = {"s": 1.0, "S": 1.0, "sec": 1.0, "ms": 1e-3, "us": 1e-6, "": 1.0}


@given(st.sampled_from(list(UNITS)), st.sampled_from(list(SECONDS)), st.floats(1.0, 1e5), st.sampled_from("dfhib"))
@settings(suppress_health_check=[HealthCheck.function_scoped_fixture], max_examples=40)
def test_every_unit_of_samples_and_steps(tmp_path: Path, unit: str, second: str, rate: float, kind: str) -> None:
    data = (100 * np.sin(np.arange(40))).astype(kind)
    properties = {"unit_string": unit, "wf_increment": 1 / rate / SECONDS[second], "wf_xunit_string": second}
    found = read(tdms(tmp_path, channel("z", data, **properties))).channels[0]
    assert found.rate == pytest.approx(rate, rel=1e-12)
    np.testing.assert_allclose(found.samples, UNITS[unit] * data.astype(float), rtol=1e-12)


def test_scaling_is_applied(tmp_path: Path) -> None:
    scaling = {"NI_Number_Of_Scales": 1, "NI_Scale[0]_Scale_Type": "Linear", "NI_Scale[0]_Linear_Slope": 2e-6}
    scaling |= {"NI_Scale[0]_Linear_Y_Intercept": 1e-3, "NI_Scaling_Status": "unscaled"}
    counts = np.arange(5000, dtype=np.int16)
    path = tdms(tmp_path, channel("z", counts, unit_string="m/s", **WAVEFORM, **scaling))
    np.testing.assert_allclose(by_axis(read(path))["z"], 1e-3 + 2e-6 * counts, rtol=1e-12)


def test_segments_follow_each_other(tmp_path: Path) -> None:
    path = tdms(tmp_path, channel("z", NOISE[0], unit_string="m/s", **WAVEFORM), segments=3)
    np.testing.assert_array_equal(by_axis(read(path))["z"], np.tile(NOISE[0], 3))


def test_a_channel_of_times_is_a_clock(tmp_path: Path) -> None:
    path = tdms(tmp_path, channel("Time", 1e3 * TIMES, unit_string="ms"), channel("z", NOISE[0], unit_string="m/s"))
    found = read(path).channels[0]
    assert found.rate == pytest.approx(RATE, rel=1e-9)
    np.testing.assert_array_equal(found.samples, NOISE[0])


def test_waveforms_that_start_apart_are_put_on_one_clock(tmp_path: Path) -> None:
    start = np.datetime64("2026-01-05T08:00:00", "us")
    late = {**WAVEFORM, "wf_start_time": start + np.timedelta64(1500, "ms"), "wf_start_offset": 0.5}
    path = tdms(
        tmp_path,
        channel("x", NOISE[0], unit_string="m/s", wf_start_time=start, **WAVEFORM),
        channel("z", NOISE[1], unit_string="m/s", **late),
    )
    assert {c.axis: c.time for c in read(path).channels} == {"x": pytest.approx(-2.0), "z": 0.0}


def test_channels_are_picked_by_group_by_name_and_by_number_and_judged_then(tmp_path: Path) -> None:
    path = tdms(
        tmp_path,
        channel("z", np.full(5000, np.nan), unit_string="furlong"),
        channel("z", NOISE[0], group="Second", unit_string="m/s", **WAVEFORM),
        channel("note", ["loud"] * 3),
    )
    for name in ("Second/z", "2"):
        np.testing.assert_array_equal(by_axis(read(path, axes={name: "z"}))["z"], NOISE[0])
    assert "channels without numbers are passed over: Floor/note" in read(path, axes={"2": "z"}).notes


FAULTS: dict[str, tuple[list[ChannelObject], dict[str, Any], str]] = {
    "no clock": (
        [channel("z", NOISE[0], unit_string="m/s")],
        {},
        r"z states no wf_increment, and no channel .*set its property wf_inc",
    ),
    "no step": (
        [channel("z", NOISE[0], unit_string="m/s", wf_increment=0.0)],
        {},
        r"wf_increment = 0; the step of its samples must be positive",
    ),
    "spectrum": (
        [channel("z", NOISE[0], unit_string="m/s", wf_xunit_string="Hz", **WAVEFORM)],
        {},
        r"unit of its abscissa \(wf_xunit_string\): 'Hz' is of frequency",
    ),
    "volts": (
        [channel("z", NOISE[0], unit_string="V", **WAVEFORM)],
        {},
        r"'V' is of a sensor's voltage",
    ),
    "no unit": ([channel("z", NOISE[0], **WAVEFORM)], {}, r"does not say what 'Floor/z' holds; set ground\.unit"),
    "words": ([channel("z", ["a", "b"])], {}, r"'a\.tdms' holds no channel of numbers"),
    "times of another length": (
        [channel("Time", TIMES[:-1]), channel("z", NOISE[0], unit_string="m/s")],
        {},
        r"z has 5000 values, and the channel Time has 4999",
    ),
    "no axis": (
        [channel("T1", NOISE[0], unit_string="m/s", **WAVEFORM)],
        {},
        r"ground\.axes does not say which axis 'Floor/T1' is",
    ),
}


@pytest.mark.parametrize("fault", FAULTS)
def test_faults_are_named(tmp_path: Path, fault: str) -> None:
    channels, options, message = FAULTS[fault]
    tdms(tmp_path, *channels)
    with pytest.raises(ValueError, match=message):
        motion(tmp_path, "a.tdms", **options)


@pytest.mark.parametrize("cut", [1, 8, 1000])
def test_a_truncated_file_is_refused(tmp_path: Path, cut: int) -> None:
    path = tdms(tmp_path, channel("z", NOISE[0], unit_string="m/s", **WAVEFORM))
    path.write_bytes(path.read_bytes()[:-cut])
    with pytest.raises(ValueError, match=r"ground\.file = 'a\.tdms' cannot be read as TDMS: .*"):
        read(path)


def test_values_that_a_header_only_claims_are_refused(tmp_path: Path) -> None:
    path = tdms(tmp_path, channel("z", NOISE[0], unit_string="m/s", **WAVEFORM))
    content = path.read_bytes()
    count = (5000).to_bytes(8, "little")
    assert content.count(count) == 1
    path.write_bytes(content.replace(count, (2**40).to_bytes(8, "little")))
    with pytest.raises(ValueError, match=r"ground\.file = 'a\.tdms' cannot be read as TDMS"):
        read(path)
