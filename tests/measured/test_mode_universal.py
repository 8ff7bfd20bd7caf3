"""Mode shapes of universal files as pyuff writes them: frequencies, damping, shapes, and where nodes stood."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest
import pyuff

from ehamj.errors import InputError
from ehamj.identification.modal.computed import computed_modes
from ehamj.identification.modal.files import WITHIN, modes_of_file
from ehamj.identification.modal.told import pairing
from ehamj.linear.machine import linear_model
from ehamj.linear.modes import modes
from ehamj.measured.modes import MeasuredModes
from ehamj.measured.nodes import Frame, Nodes
from ehamj.measured.sensors import Place
from ehamj.scenario.load import parse_scenario

SCENARIO = parse_scenario({})
AT = {11: (1.0, 0.7, 1.8), 12: (-1.0, 0.7, 1.8), 13: (1.0, -0.7, 1.8), 14: (0.9, 0.6, 0.0)}
"""Upper corners, and the front left foot [m]."""
FOUND = [
    mode
    for mode in modes(linear_model(SCENARIO.plant), points={str(node): place for node, place in AT.items()})
    if mode.machine_moves
]


def shape(k: int, **more: Any) -> dict[str, Any]:
    """Dataset 55 of a computed mode: node 13 measured along x and y only."""
    mode = FOUND[k]
    parts = np.array([mode.points[str(node)] for node in AT])
    real = more.get("analysis_type", 2) == 2
    parts = parts.real.copy() if real else parts * np.exp(0.7j)
    parts[2, 2] = 0.0
    value = 2.0 * np.pi * mode.frequency * complex(-mode.damping_ratio, np.sqrt(1.0 - mode.damping_ratio**2))
    return {
        "type": 55, "analysis_type": 2, "data_ch": 2, "spec_data_type": 12, "load_case": 1, "mode_n": k + 1,
        "freq": mode.frequency, "modal_damp_vis": mode.damping_ratio, "node_nums": list(AT), "eig": value,
        **{f"r{axis + 1}": parts[:, axis] for axis in range(3)}, **more,
    }  # fmt: skip


def nodes(kind: int, scale: float = 1.0, turned: bool = False, system: int = 0) -> dict[str, Any]:
    """Where they stood, from the mount plane's centre; ``turned``: from (1, 0, 0), the file's x along y."""
    x, y, z = np.array(list(AT.values())).T * scale
    if turned:
        x, y = y, -(x - scale)
    one = np.full(len(AT), system)
    return {"type": kind, "node_nums": list(AT), "def_cs": one, "disp_cs": one, "color": one, "x": x, "y": y, "z": z}


def written(path: Path, *sets: dict[str, Any]) -> Path:
    pyuff.UFF(str(path)).write_sets(list(sets), "overwrite")
    return path


def read(path: Path, frame: Frame = WITHIN, told: Nodes | None = None, **places: Place) -> MeasuredModes:
    return modes_of_file(path, SCENARIO, places, None, frame, told)


MILLIMETRES = {"type": 164, "units_code": 5, "length": 1000.0, "force": 1000.0, "temp": 1.0, "temp_offset": 273.15,
               "temp_mode": 1}  # fmt: skip


@pytest.mark.parametrize("analysis", [2, 3, 7])
def test_shapes_frequencies_and_ratios_are_the_files(analysis: int, tmp_path: Path) -> None:
    """Zeros that stand in for what was not measured are no sensors; places come from the file, in its unit."""
    sets = [shape(k, analysis_type=analysis) for k in (2, 0, 5)]
    found = read(written(tmp_path / "a.uff", MILLIMETRES, nodes(2411, 1e3, system=1), *sets))
    assert found.real == (analysis == 2)
    assert len(found.sensors.names) == 11
    assert "13:+Z" not in found.sensors.names
    chosen = [FOUND[k] for k in (0, 2, 5)]
    np.testing.assert_allclose(found.frequency, [mode.frequency for mode in chosen], rtol=1e-5)
    np.testing.assert_allclose(found.damping_ratio, [mode.damping_ratio for mode in chosen], rtol=1e-4)
    assert [pair.name for pair in pairing(found, computed_modes(SCENARIO)).pairs] == [mode.name for mode in chosen]
    assert min(pair.mac for pair in pairing(found, computed_modes(SCENARIO)).pairs) > 0.999
    assert "0.005 of each frequency" in found.notes[0]


def test_a_files_frame_is_turned_and_nodes_are_named(tmp_path: Path) -> None:
    straight = read(written(tmp_path / "a.uff", nodes(15), shape(0)))
    turned = shape(0)
    turned["r1"], turned["r2"] = turned["r2"], -turned["r1"]
    frame = Frame(origin=(1.0, 0.0, 0.0), axes=("y", "-x", "z"))
    found = read(written(tmp_path / "b.unv", nodes(15, turned=True), turned), frame)
    feet = np.array(SCENARIO.plant.positions)
    rows = dict(zip(straight.sensors.names, straight.sensors.rows(feet), strict=True))
    others = found.sensors.rows(feet)[found.sensors.names.index("11:+X")]  # the machine's y, upwards from there
    np.testing.assert_allclose(others, rows["11:+Y"], atol=1e-12)
    told: Nodes = {"11": (1.0, 0.7, 1.8), "12": (-1.0, 0.7, 1.8), "13": (1.0, -0.7, 1.8), "14": "front-left"}
    bare = read(written(tmp_path / "c.uff", shape(0)), told=told)
    np.testing.assert_allclose(bare.sensors.rows(feet), straight.sensors.rows(feet), atol=1e-12)


def test_what_is_not_told_or_contradicts_is_refused(tmp_path: Path) -> None:
    bare = written(tmp_path / "a.uff", shape(0))
    for told, said in (
        ({}, "measurement.11:.X: '11:.X' is no place"),
        ({"21": "front-left"}, "nodes.21: .*the file has 11, 12"),
        ({"11": "front-let"}, "nodes.11 = 'front-let': .*front-left"),
    ):
        with pytest.raises(InputError, match=said):
            read(bare, told=told)
    with pytest.raises(InputError, match="holds no modes"):
        read(written(tmp_path / "b.uff", nodes(15)))
    turning = shape(0, r4=np.ones(4), r5=np.zeros(4), r6=np.zeros(4))
    with pytest.raises(InputError, match="mode 1 has rotations"):
        read(written(tmp_path / "c.uff", nodes(15), turning))
    with pytest.raises(InputError, match="dataset 164 contradicts itself"):
        read(written(tmp_path / "d.uff", MILLIMETRES | {"length": 1.0}, nodes(15), shape(0)))
    with pytest.raises(ValueError, match="right-handed"):
        Frame(axes=("y", "x", "z"))
