"""Frequency responses of a hammer test, as pyuff writes them: the modes of the machine that made them."""

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import pyuff
from harness import Cli

from ehamj.errors import InputError
from ehamj.identification.modal.computed import computed_modes
from ehamj.identification.modal.files import modes_of_file
from ehamj.identification.modal.told import pairing
from ehamj.linear.machine import FORCES, linear_model
from ehamj.measured.modes import MeasuredModes
from ehamj.plant.axes import DOFS
from ehamj.scenario.load import parse_scenario

SCENARIO = parse_scenario({})
AT = {11: (1.0, 0.7, 1.8), 12: (-1.0, 0.7, 1.8), 13: (1.0, -0.7, 1.8), 14: (0.9, 0.6, 0.0)}
"""Upper corners, and the front left foot [m]."""
HIT = ((11, 1), (12, -2))
"""Nodes that are hit, and along what: x, −y."""
HERTZ = np.arange(40.0, 120.0, 0.5)
NOISE = 0.05
TRUE = computed_modes(SCENARIO)
LOW = TRUE.frequency < HERTZ[-1]


def moved(place: tuple[float, float, float]) -> np.ndarray:
    """Translation of a place per motion of the mount plane's centre, (3, 6): u + θ × p."""
    x, y, z = place
    return np.hstack([np.eye(3), [[0.0, z, -y], [-z, 0.0, x], [y, -x, 0.0]]])


def responses() -> dict[tuple[int, int, int, int], np.ndarray]:
    """Accelerations of all nodes over the forces, by node and direction of both, by levers alone."""
    model = linear_model(SCENARIO.plant)
    found = model.response(HERTZ, [f"machine_acceleration {dof}" for dof in DOFS], model.inputs)
    columns = found[:, :, [model.inputs.index(name) for name in FORCES]]  # at the centre of gravity
    about = np.array(SCENARIO.plant.machine.cg)
    table = {}
    for hit, side in HIT:
        lever = moved(tuple(np.array(AT[hit]) - about))[abs(side) - 1] * np.sign(side)
        for node, place in AT.items():
            motion = np.einsum("ai,fij,j->fa", moved(place), columns, lever)
            table |= {(node, axis + 1, hit, side): motion[:, axis] for axis in range(3)}
    return table


MADE = responses()


def dataset(places: tuple[int, int, int, int], values: np.ndarray, **more: Any) -> dict[str, Any]:
    rsp_node, rsp_dir, ref_node, ref_dir = places
    return {
        "type": 58, "binary": 0, "func_type": 4, "rsp_node": rsp_node, "rsp_dir": rsp_dir, "ref_node": ref_node,
        "ref_dir": ref_dir, "data": values, "x": HERTZ, "num_pts": HERTZ.size, "abscissa_spacing": 1,
        "abscissa_min": HERTZ[0], "abscissa_inc": HERTZ[1] - HERTZ[0], "ord_data_type": 5,
        "abscissa_spec_data_type": 18, "ordinate_spec_data_type": 12, "orddenom_spec_data_type": 13,
        "ordinate_axis_units_lab": "m/s^2",
        "orddenom_axis_units_lab": "N", "abscissa_axis_units_lab": "Hz", "id1": "made", **more,
    }  # fmt: skip


def nodes() -> dict[str, Any]:
    x, y, z = np.array(list(AT.values())).T
    none = np.zeros(len(AT), int)
    return {"type": 2411, "node_nums": list(AT), "def_cs": none, "disp_cs": none, "color": none, "x": x, "y": y, "z": z}


def noisy(seed: int, noise: float = NOISE) -> dict[tuple[int, int, int, int], np.ndarray]:
    random = np.random.default_rng(seed)
    return {
        places: values
        + noise * np.sqrt(0.5 * np.mean(np.abs(values) ** 2)) * (random.normal(size=(2, HERTZ.size)).T @ [1.0, 1j])
        for places, values in MADE.items()
    }


def written(path: Path, *sets: dict[str, Any]) -> Path:
    pyuff.UFF(str(path)).write_sets(list(sets), "overwrite")
    return path


def read(path: Path, *sets: dict[str, Any]) -> MeasuredModes:
    return modes_of_file(written(path, nodes(), *sets), SCENARIO, {})


def test_modes_are_those_of_the_machine_within_their_deviations(tmp_path: Path) -> None:
    """Two sways that are 0.6 Hz apart, and yaw."""
    apart = []
    for seed in range(3):
        found = read(tmp_path / "a.uff", *(dataset(*one) for one in noisy(seed).items()))
        assert found.frequency.size == 3
        paired = pairing(found, TRUE)
        assert [pair.name for pair in paired.pairs] == [name for name, low in zip(TRUE.names, LOW, strict=True) if low]
        assert min(pair.together for pair in paired.pairs) > 0.995
        apart.append((found.frequency - TRUE.frequency[LOW]) / found.frequency_deviation)
        apart.append((found.damping_ratio - TRUE.damping_ratio[LOW]) / found.damping_deviation)
        assert (found.frequency_deviation < 2e-3 * found.frequency).all()
        assert (found.damping_deviation < 0.1 * found.damping_ratio).all()
    assert 0.55 < np.sqrt(np.mean(np.square(apart))) < 1.35  # of 18 numbers
    assert np.abs(apart).max() < 3.5


def test_a_hammer_that_goes_round_one_sensor_tells_the_same_shapes(tmp_path: Path) -> None:
    """Its places are those that were hit, by reciprocity; a velocity is one by its data type."""
    made = noisy(1, 1e-3)
    turned = [
        dataset((hit, side, node, axis), values / (2j * np.pi * HERTZ), ordinate_axis_units_lab="NONE",
                orddenom_axis_units_lab="NONE", ordinate_spec_data_type=11)
        for (node, axis, hit, side), values in made.items()
    ]  # fmt: skip
    one = read(tmp_path / "a.uff", *(dataset(*one) for one in made.items()))
    other = read(tmp_path / "b.uff", *turned)
    assert "at the places that were hit" in other.words
    assert other.sensors.names == one.sensors.names
    np.testing.assert_allclose(other.frequency, one.frequency, rtol=1e-4)
    np.testing.assert_allclose(np.abs(other.shape), np.abs(one.shape), atol=0.02)


def test_what_is_wrong_is_named(tmp_path: Path) -> None:
    made = noisy(2, 1e-3)
    turned = {place: -values if place[:2] == (13, 2) else values for place, values in made.items()}
    found = read(tmp_path / "a.uff", *(dataset(*one) for one in turned.items()))
    with pytest.raises(InputError, match=r"13:\+Y is the wrong way round"):
        pairing(found, TRUE)
    sets, random = [dataset(*one) for one in made.items()], np.random.default_rng(5)
    for changed, said in (
        ([{**one, "ordinate_axis_units_lab": "NONE", "ordinate_spec_data_type": 1} for one in sets], "nothing says"),
        ([{**one, "ordinate_axis_units_lab": "Pa"} for one in sets], "no motion over a force"),
        (sets[:-1], r"14:\+Z to 12:-Y is missing"),
        ([*sets, sets[0]], "twice"),
        (
            [{**one, "data": one["data"][0] * random.normal(size=(2, HERTZ.size)).T @ [1.0, 1j]} for one in sets],
            "no mode s",
        ),
    ):
        with pytest.raises(InputError, match=said):
            read(tmp_path / "b.uff", *changed)


def test_the_command_says_what_it_read_and_where_nodes_stood(cli: Cli, tmp_path: Path) -> None:
    written(tmp_path / "hammer.uff", *(dataset(*one) for one in noisy(3, 1e-3).items()))
    places = {str(node): list(place) for node, place in AT.items()} | {"14": "front-left"}
    said_of = 'file = "hammer.uff"\n{}\n[nodes]\n' + "\n".join(f"{k} = {json.dumps(v)}" for k, v in places.items())
    (tmp_path / "test.toml").write_text(said_of.format("band = [50, 110]"))
    code, said, error = cli("modes", "benchmark", "--measured", str(tmp_path / "test.toml"))
    assert code == 0, error
    assert "frequency responses of hammer.uff, 12 motions to 2 forces" in said
    assert "heave (528 Hz) was not measured" in said
    for content, wrong in (
        ('file = "hammer.uff"', "measurement.11:+X"),
        (said_of.format("band = [700, 800]"), "from 40 to 119.5 Hz"),
        (said_of.format("band = [9, 8]"), "band"),
        ("band = [8, 9]\n[[mode]]\nfrequency = 9", "band: says something of a universal file"),
        ('file = "other.toml"', "not TOML as well"),
    ):
        (tmp_path / "test.toml").write_text(content)
        code, said, error = cli("modes", "benchmark", "--measured", str(tmp_path / "test.toml"))
        assert (code, said) == (2, "")
        assert wrong in error
