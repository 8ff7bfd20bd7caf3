"""What every reader shares: components by name, number and axis; units that only the user can say."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from oracles.records import by_axis

from ehamj.ground.records import RecordGround
from ehamj.records.components import answers_of

ROWS = "".join(f"{k / 100:.2f},{k % 7}.5,{k % 5}.25\n" for k in range(600))


def ground(folder: Path, head: str, **settings: Any) -> RecordGround:
    (folder / "a.csv").write_text(head + "\n" + ROWS)
    return RecordGround(kind="record", file=str(folder / "a.csv"), **settings)


@pytest.mark.parametrize(("unit", "volts"), [("V", 1.0), ("mV", 1e-3), ("µV", 1e-6)])
def test_what_the_user_says_of_a_voltage_is_of_one_volt(tmp_path: Path, unit: str, volts: float) -> None:
    """A geophone of 28.8 V per m/s, whose samples are in any of the units: 1 V stands for 1/28.8 m/s."""
    record = ground(tmp_path, f"time [s],x [{unit}],z [V]", unit="m/s").read()
    found = by_axis(record)
    assert {channel.quantity for channel in record.channels} == {"velocity"}
    np.testing.assert_allclose(found["x"], volts * np.array([k % 7 + 0.5 for k in range(600)]), rtol=1e-12)
    np.testing.assert_allclose(found["z"], [k % 5 + 0.25 for k in range(600)], rtol=1e-12)
    assert "x: 1 V is taken as ground.unit = 'm/s', times ground.scale" in record.notes


def test_a_factor_is_of_an_axis_where_a_component_bears_its_name(tmp_path: Path) -> None:
    crossed = ground(tmp_path, "time [s],x [m/s],z [m/s]", axes={"z": "x", "x": "z"}, scale={"z": 10.0})
    assert crossed._scales(crossed.read()) == {"x": 1.0, "z": 10.0}
    named = ground(tmp_path, "time [s],a [m/s],b [m/s]", axes={"a": "x", "b": "z"}, scale={"a": 2.0, "z": -1.0})
    assert named._scales(named.read()) == {"x": 2.0, "z": -1.0}


def test_numbers_of_a_table_are_those_of_its_columns(tmp_path: Path) -> None:
    found = by_axis(ground(tmp_path, "time [s],a [m/s],b [m/s]", axes={"2": "x", "3": "z"}).read())
    assert found["x"][1] == 1.5
    assert found["z"][1] == 1.25
    with pytest.raises(ValueError, match="names '1', which the record does not hold; it holds 'a', 'b'"):
        ground(tmp_path, "time [s],a [m/s],b [m/s]", axes={"1": "x"}).read()


@pytest.mark.parametrize("name", ["z", "Acceleration z", "ACC_Z", "Z-axis", "accZ", "Kanal Z", "Ch3 (z)", "v_z", "Z1"])
def test_an_axis_in_a_name_is_that_axis(name: str) -> None:
    assert answers_of(name) == ("z",)


@pytest.mark.parametrize(
    "name", ["max_z", "Z_Value", "z offset", "GPS z", "z down", "-z", "- Z", "acc -z", "x-z", "note"]
)
def test_a_name_that_may_be_something_else_is_no_axis(name: str) -> None:
    assert answers_of(name) == ()
