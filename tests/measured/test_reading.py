"""A test's file as channels: each component in SI under its name, what contradicts is refused by its key."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest
import scipy.io

from ehamj.errors import InputError
from ehamj.measured.measured import Measured
from ehamj.measured.reading import read_measured
from ehamj.measured.settings import MeasuredComponent
from ehamj.plant.mounts import MOUNTS
from ehamj.records.choices import Reading

TIME = np.arange(0.0, 2.0, 1e-3)
WAVE = np.sin(2 * np.pi * 7.0 * TIME) + np.random.default_rng(5).normal(0.0, 0.01, TIME.size)


def written(path: Path, *heads: str) -> Path:
    rows = (f"{time:.4f}" + f",{value:.7g}" * len(heads) for time, value in zip(TIME, WAVE, strict=True))
    path.write_text("\n".join([",".join(["time [s]", *heads]), *rows, ""]))
    return path


def read(path: Path, measurement: dict[str, Any], **reading: Any) -> Measured:
    parts = {name: MeasuredComponent.model_validate(one) for name, one in measurement.items()}
    return read_measured(path, parts, MOUNTS, Reading(**reading), "test.0")


SIZES = {
    ("valve_command front-left", "mV"): 1e-3,
    ("chamber_pressure rear-left 2", "bar"): 1e5,
    ("supply_pressure", "MPa"): 1e6,
    ("load_pressure front-right", "psi"): 6894.757293168361,
    ("spool front-left", "A"): 1e3,  # spools are in mA
    ("spool rear-left", "mA"): 1.0,
    ("stroke front-left", "µm"): 1e-6,
    ("foot_velocity rear-right z", "in/s"): 0.0254,
    ("ground_acceleration front-left along", "g"): 9.80665,
    ("machine_velocity rx", "deg/s"): np.pi / 180.0,
    ("cg_acceleration z", "m/s²"): 1.0,
}


def test_each_unit_arrives_in_the_channels_own(tmp_path: Path) -> None:
    path = written(tmp_path / "a.csv", *(f"c{k} [{unit}]" for k, (_, unit) in enumerate(SIZES)), "F [kN]", "g [lbf]")
    table: dict[str, Any] = {f"c{k}": {"channel": channel} for k, (channel, _) in enumerate(SIZES)}
    table |= {"F": {"force": {"point": [0.5, 0.4, 0.9]}}, "g": {"force": {"direction": [0, 3, 0]}, "scale": -2.0}}
    found = read(path, table)
    assert (found.rate, found.begin, found.duration) == (1000.0, 0.0, 2.0)
    for (channel, _), size in SIZES.items():
        np.testing.assert_allclose(found[channel].samples, size * WAVE, rtol=1e-6)
    np.testing.assert_allclose(found["force F"].samples, 1e3 * WAVE, rtol=1e-6)
    np.testing.assert_allclose(found["force g"].samples, -2.0 * 4.4482216152605 * WAVE, rtol=1e-6)
    assert found["force g"].place is not None
    assert found["force g"].place.direction == (0.0, 1.0, 0.0)
    driving = {one.name for one in found.inputs}
    assert driving == {"valve_command front-left", "ground_acceleration front-left along", "force F", "force g"}


REFUSED: dict[str, tuple[dict[str, Any], tuple[str, ...]]] = {
    "another kind": ({"P": {"channel": "stroke front-left"}}, ("test.0.measurement.P: ", "'bar'", "pressure", "mm")),
    "unit of another kind": (
        {"bare": {"channel": "stroke front-left", "unit": "bar"}},
        ("test.0.measurement.bare.unit = 'bar' is of pressure", "mm"),
    ),
    "no unit": ({"bare": {"channel": "stroke front-left"}}, ("bare.unit is missing", "mm", "'SI'")),
    "two units": (
        {"P": {"channel": "supply_pressure", "unit": "psi"}},
        ("measurement.P.unit = 'psi'", "'bar'", "leave unit out"),
    ),
    "volts": ({"u": {"channel": "supply_pressure"}}, ("measurement.u.unit is missing", "volts", "scale")),
    "not there": ({"Q": {"channel": "supply_pressure"}}, ("measurement.Q.component = 'Q'", "'bare'")),
    "no channel": ({"P": {"channel": "supply_presure"}}, ("test.0.measurement.P.channel", "'supply_pressure'")),
    "no mount": ({"u": {"channel": "valve_command left"}}, ("test.0.measurement.u.channel", "front-left")),
    "no input": ({"P": {"channel": "supply_pressure", "role": "input"}}, ("measurement.P.role = 'input'",)),
    "twice": (
        {"P": {"channel": "supply_pressure"}, "q": {"channel": "supply_pressure", "component": "P"}},
        ("test.0.measurement.q.channel", "P is supply_pressure already"),
    ),
    "no file": ({}, ("test.0.measurement is empty",)),
}


@pytest.mark.parametrize("what", REFUSED)
def test_what_contradicts_is_refused_by_its_key(what: str, tmp_path: Path) -> None:
    table, told = REFUSED[what]
    path = written(tmp_path / "a.csv", "P [bar]", "u [V]", "bare")
    with pytest.raises(InputError) as error:
        read(path, table)
    for part in told:
        assert part in str(error.value)
    assert "ground." not in str(error.value)
    assert "\n" not in str(error.value)


def test_what_a_reader_refuses_names_the_tests_keys(tmp_path: Path) -> None:
    (tmp_path / "a.csv").write_text(
        "time [s],P [bar]\n" + "".join(f"{k / 100},{k % 7}\n" for k in range(90) if k != 50)
    )
    with pytest.raises(InputError, match=r"test\.0\.gaps = 'interpolate'|test\.0\.gaps"):
        read(tmp_path / "a.csv", {"P": {"channel": "supply_pressure"}})
    assert read(tmp_path / "a.csv", {"P": {"channel": "supply_pressure", "accept": ["coarse"]}}, gaps="interpolate")
    with pytest.raises(InputError, match=r"test\.0\.file = 'b\.csv'"):
        read(tmp_path / "b.csv", {"P": {"channel": "supply_pressure"}})


def test_volts_and_counts_are_what_the_user_says(tmp_path: Path) -> None:
    path = written(tmp_path / "a.csv", "u [mV]", "n [counts]")
    table = {"u": {"channel": "supply_pressure", "unit": "bar", "scale": 40.0}}
    table["n"] = {"channel": "stroke front-left", "unit": "mm", "scale": 1e-3}
    found = read(path, table)
    np.testing.assert_allclose(found["supply_pressure"].samples, 40.0 * 1e5 * 1e-3 * WAVE, rtol=1e-6)
    np.testing.assert_allclose(found["stroke front-left"].samples, 1e-6 * WAVE, rtol=1e-6)


def test_rates_and_beginnings_that_differ_come_onto_one_clock(tmp_path: Path) -> None:
    """A MATLAB file whose arrays have times of their own: 10 kHz, 2 kHz from 0.1 s on, 1 kHz half a sample late."""

    def part(rate: float, begin: float, seconds: float) -> dict[str, Any]:
        time = begin + np.arange(round(seconds * rate)) / rate
        return {"time": time, "y": 3.0 + np.sin(2 * np.pi * 160.0 * time + 1.0), "unit": "bar"}

    parts = {"a": part(10e3, 0.0, 1.5), "b": part(2e3, 0.1, 1.0), "c": part(1e3, 0.0505, 2.0)}
    scipy.io.savemat(tmp_path / "m.mat", parts)
    channels = {"a": "supply_pressure", "b": "load_pressure front-left", "c": "load_pressure rear-left"}
    found = read(tmp_path / "m.mat", {f"{name}.y": {"channel": one, "unit": "bar"} for name, one in channels.items()})
    assert (found.rate, found.begin, found.time.size) == (1000.0, 0.1, 1000)
    exact = 1e5 * (3.0 + np.sin(2 * np.pi * 160.0 * (0.1 + found.time) + 1.0))
    inner = slice(40, -40)
    for name in channels.values():
        np.testing.assert_allclose(found[name].samples[inner], exact[inner], atol=20.0)  # 2e-4 of the wave
    assert sum("resampled" in note for note in found.notes) == 3


def test_what_has_no_time_in_common_is_refused(tmp_path: Path) -> None:
    early, late = ({"time": begin + TIME, "y": WAVE} for begin in (0.0, 5.0))
    scipy.io.savemat(tmp_path / "m.mat", {"a": early, "b": late})
    table = {"a.y": {"channel": "supply_pressure", "unit": "bar"}}
    table["b.y"] = {"channel": "stroke front-left", "unit": "mm"}
    with pytest.raises(InputError, match=r"test\.0\.file = 'm\.mat': a\.y ends at 2 s, and b\.y begins at 5 s"):
        read(tmp_path / "m.mat", table)
