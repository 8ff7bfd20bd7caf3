"""IDE files of enDAQ loggers: written element by element with ebmlite, read back, refused by name."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from ebmlite import loadSchema
from oracles.records import NOISE, RATE, by_axis, motion, read

SCHEMA = loadSchema("mide_ide.xml")
COUNTS = np.round(NOISE * 1e8).astype("<i2")
"""Of a converter; calibrated below by 1e-3 g a count, about 0.1."""


def part(name: str, unit: str, number: int, calibration: int | None = 1) -> dict[str, Any]:
    """A subchannel."""
    found: dict[str, Any] = {"SubChannelID": number, "SubChannelName": name, "SubChannelLabel": "Acceleration"}
    found |= {"SubChannelUnits": unit, "SubChannelSensorRef": 0}
    return found if calibration is None else {**found, "SubChannelCalibrationIDRef": calibration}


def ide(
    path: Path,
    parts: list[dict[str, Any]],
    *,
    rate: str = "500",
    scale: str = "1/1000000",
    listed: bool = True,
    pause: float = 0.0,
) -> Path:
    """A recording in ten blocks, with a ``pause`` [s] before the last."""
    data = COUNTS[: len(parts)].T
    channel = {"ChannelID": 8, "ChannelName": "Main", "ChannelFormat": "<" + "h" * len(parts), "SampleRate": rate}
    channel |= {"TimeCodeScale": scale, "TimeCodeModulus": 2**40, "SubChannel": parts}
    head: list[tuple[str, Any]] = [
        ("EBML", {"DocType": "mide", "DocTypeVersion": 2, "DocTypeReadVersion": 2, "EBMLVersion": 1}),
        (
            "CalibrationList",
            {"UnivariatePolynomial": [{"CalID": 1, "CalReferenceValue": 0.0, "PolynomialCoef": [1e-3, 0.5]}]},
        ),
        (
            "RecordingProperties",
            {
                "RecorderInfo": {"RecorderTypeUID": 256, "RecorderSerial": 7},
                "SensorList": {"Sensor": [{"SensorID": 0, "SensorName": "made up"}]},
                **({"ChannelList": {"Channel": [channel]}} if listed else {}),
            },
        ),
    ]
    for k in range(0, 5000, 500):
        late = pause if k == 4500 else 0.0
        times = {
            "StartTimeCodeAbs": round((k / RATE + late) * 1e6),
            "EndTimeCodeAbs": round(((k + 499) / RATE + late) * 1e6),
        }
        head.append(
            ("ChannelDataBlock", {"ChannelIDRef": 8, **times, "ChannelDataPayload": data[k : k + 500].tobytes()})
        )
    path.write_bytes(b"".join(bytes(SCHEMA[name].encode(value)) for name, value in head))
    return path


@pytest.mark.parametrize(("unit", "size"), [("g", 9.80665), ("m/s^2", 1.0), ("m/s²", 1.0), ("mg", 9.80665e-3)])
def test_calibrated_channels_are_components_of_their_unit(tmp_path: Path, unit: str, size: float) -> None:
    path = ide(tmp_path / "a.ide", [part("X (40g)", unit, 0), part("Z (40g)", unit, 1)])
    record = read(path)
    assert [(c.name, c.axis, c.quantity) for c in record.channels] == [
        ("Main/X (40g)", "x", "acceleration"),
        ("Main/Z (40g)", "z", "acceleration"),
    ]
    for k, axis in enumerate("xz"):
        np.testing.assert_allclose(by_axis(record)[axis], size * (1e-3 * COUNTS[k] + 0.5), rtol=1e-12)
    assert record.channels[0].rate == pytest.approx(RATE, rel=1e-9)


def test_what_is_no_motion_is_passed_over_and_named(tmp_path: Path) -> None:
    path = ide(tmp_path / "a.ide", [part("Temperature", "°C", 0), part("Z", "g", 1)])
    record = read(path)
    assert [c.name for c in record.channels] == ["Main/Z"]
    assert "channels that hold no motion are passed over: Main/Temperature [°C]" in record.notes


def test_channels_are_picked_by_name_and_by_number(tmp_path: Path) -> None:
    path = ide(tmp_path / "a.ide", [part("A", "g", 0), part("B", "g", 1)])
    for name in ("B", "Main/B", "2"):
        np.testing.assert_allclose(by_axis(read(path, axes={name: "z"}))["z"], 9.80665 * (1e-3 * COUNTS[1] + 0.5))


BOMB = "9**9**9**9"
FAULTS: dict[str, tuple[list[dict[str, Any]], dict[str, Any], str]] = {
    "an expression for a rate": (
        [part("Z", "g", 0)],
        {"rate": BOMB},
        r"its SampleRate is '9\*\*9.*', which is no plain",
    ),
    "an expression for a scale": (
        [part("Z", "g", 0)],
        {"scale": BOMB},
        r"its TimeCodeScale is '9\*\*9.*', which is no",
    ),
    "no list of channels": ([part("Z", "g", 0)], {"listed": False}, r"it lists no channels before its data, so that"),
    "calibration that is not there": (
        [part("Z", "g", 0, 5)],
        {},
        r"the file has no calibration that makes its numbers",
    ),
    "no calibration": ([part("Z", "g", 0, None)], {}, r"it states 'g', and the file has no calibration"),
    "no motion": ([part("Z", "Pa", 0)], {}, r"holds no channel of motion; it holds Main/Z \[Pa\]"),
    "pause": ([part("Z", "g", 0)], {"pause": 0.5}, r"1 gap, 0\.5 s in total; set ground\.gaps"),
    "no axis": ([part("A", "g", 0)], {}, r"ground\.axes does not say which axis 'Main/A' is"),
}


@pytest.mark.parametrize("fault", FAULTS)
def test_faults_are_named(tmp_path: Path, fault: str) -> None:
    parts, options, message = FAULTS[fault]
    ide(tmp_path / "a.ide", parts, **options)
    with pytest.raises(ValueError, match=message):
        motion(tmp_path, "a.ide")


def test_a_truncated_file_is_refused(tmp_path: Path) -> None:
    path = ide(tmp_path / "a.ide", [part("Z", "g", 0)])
    path.write_bytes(path.read_bytes()[:-300])
    with pytest.raises(ValueError, match=r"ground\.file = 'a\.ide' cannot be read as an IDE file: it breaks off"):
        read(path)
