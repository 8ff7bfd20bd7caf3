"""Modes in tables of text, as they are written, and what is refused."""

from pathlib import Path

import numpy as np
import pytest

from ehamj.errors import InputError
from ehamj.identification.modal.files import modes_of_file
from ehamj.measured.sensors import Place
from ehamj.scenario.load import parse_scenario

TABLE = """name;frequency [Hz];frequency deviation [Hz];damping [%];foot_velocity front-left x re;foot_velocity front-left x im;S2 magnitude;S2 phase [deg]
second;80,5;0,2;3;0,5;0,5;0,25;180
first;70;;2,5;-2;0;1;90
"""  # noqa: E501


def test_a_table_is_read_in_si_by_frequency_with_sensors_where_they_stood(tmp_path: Path) -> None:
    path = tmp_path / "modes.csv"
    path.write_text(TABLE)
    places = {"S2": Place(point=(0.9, 0.6, 1.5), direction=(0.0, 2.0, 0.0), scale=-1.0)}
    found = modes_of_file(path, parse_scenario({}), places)
    assert found.frequency.tolist() == [70.0, 80.5]
    assert found.damping_ratio.tolist() == [0.025, 0.03]
    np.testing.assert_allclose(found.frequency_deviation, [0.35, 0.2])  # the assumed half per cent; as stated
    np.testing.assert_allclose(found.shape, [[1.0, 0.5j], [1.0, 0.25 - 0.25j]], atol=1e-12)
    assert "0.005 of each frequency" in found.notes[0]
    # θ about x moves what stands at z by −z along y; about z by x.
    rows = found.sensors.rows(np.array(parse_scenario({}).plant.positions))
    np.testing.assert_allclose(rows, [[1, 0, 0, 0, 0, -0.6], [0, 1, 0, -1.5, 0, 0.9]], atol=1e-12)


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("frequency [Hz];S1\n70.5;1.5\n80.5;1.5\n", "measurement.S1: 'S1' is no place of a sensor"),
        ("frequency [Hz],damping\n70,3.1\n80,2\n", "between -1 and 1; per cent have %"),
        ("frequency [mm],machine_velocity x\n70,1\n80,1\n", "'mm'; it must be in one of Hz"),
        ("hertz,machine_velocity x\n70,1\n80,1\n", "no column is called 'frequency [Hz]'"),
        ("frequency [Hz],machine_velocity x re\n70,1\n80,1\n", "it must have one column, or 're' and 'im'"),
        ("frequency [Hz],machine_velocity x\n70,0\n80,1\n", "the mode at 70 Hz is zero everywhere"),
        ("frequency [Hz],machine_velocity x\n-70,1\n80,1\n", "is -70; it must be above 0 Hz"),
    ],
)
def test_what_is_no_mode_is_refused_by_name(text: str, said: str, tmp_path: Path) -> None:
    path = tmp_path / "modes.csv"
    path.write_text(text)
    with pytest.raises(InputError, match=said.replace("[", r"\[").replace("]", r"\]")):
        modes_of_file(path, parse_scenario({}), {})


def test_a_file_of_its_own_says_where_sensors_stood(tmp_path: Path) -> None:
    path = tmp_path / "modes.toml"
    path.write_text(
        "[sensors]\nS1 = { channel = 'foot_acceleration rear-left z' }\n"
        "[[mode]]\nfrequency = 70.0\nshape = { S1 = -2.0, 'machine_displacement ry' = 0.5 }\nshape_deviation = 0.02\n"
    )
    found = modes_of_file(path, parse_scenario({}), {})
    assert found.real
    assert found.shape.tolist() == [[1.0, -0.25]]
    assert found.shape_deviation.tolist() == [0.02]
    assert np.isnan(found.damping_ratio).all()
    rows = found.sensors.rows(np.array(parse_scenario({}).plant.positions))
    np.testing.assert_allclose(rows, [[0, 0, 1, 0.6, 0.9, 0], [0, 0, 0, 0, 1, 0]], atol=1e-12)
