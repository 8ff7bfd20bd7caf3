"""Attenuation of roll, pitch and yaw: of the slab whose six motions fit the mounts' ground, for mounts anywhere."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from scipy.optimize import least_squares

from ehamj.judge import isolation
from ehamj.judge.levels import SLAB, floor_as_whole
from ehamj.plant.plant import Plant
from ehamj.result import make_dataset
from ehamj.scenario.load import parse_scenario

RATE = 500.0
TIMES = np.arange(3001) / RATE
FLAT = {"a": (1.0, 0.5), "b": (0.8, -0.7), "c": (-0.6, 0.3)}
SPACE = {**{name: (*at, 0.0) for name, at in FLAT.items()}, "d": (0.3, 0.6, 0.45), "e": (-0.9, 0.2, -0.3)}


def plant_of(places: dict[str, Any], lifted: float = 0.0) -> Plant:
    mounts = [{"name": name, "position": list(at)} for name, at in places.items()]
    plant = parse_scenario({"mount": mounts}).plant
    return replace(plant, positions=tuple((x, y, z + lifted) for x, y, z in plant.positions))


def noise(*shape: int) -> np.ndarray:
    return 1e-5 * np.random.default_rng(len(shape)).standard_normal((TIMES.size, *shape))


def attenuation(plant: Plant, ground: np.ndarray, machine: np.ndarray) -> dict[str, dict[str, float]]:
    """Of each motion, the bands that are decided."""
    n = len(plant.mounts)
    values = {"ground_velocity": ground, "foot_velocity": np.zeros((TIMES.size, n, 3))}
    values |= {"cg_velocity": machine[:, :3], "machine_velocity": machine}
    dataset = make_dataset(TIMES, values, {}, {"mount": plant.mounts})
    found = isolation(dataset, plant, RATE)[0].attenuation_db
    return {motion: {band: v for band, v in of.items() if v is not None} for motion, of in found.items()}


def test_the_floor_turns_as_the_slab_that_fits_best() -> None:
    """The oracle moves a slab and lets SciPy find what is nearest to mounts that each move on their own."""
    plant, row = plant_of(SPACE), noise(5, 3)[7]

    def misfit(motion: np.ndarray) -> np.ndarray:
        moved = [motion[:3] + np.cross(motion[3:], at) for at in plant.positions]
        return (1e5 * (np.array(moved) - row)).ravel()

    best = least_squares(misfit, np.zeros(6), xtol=1e-15, ftol=1e-15, gtol=1e-15).x
    found = floor_as_whole(row[None], plant)[0]
    np.testing.assert_allclose(found[3:], best[3:], rtol=1e-6)
    np.testing.assert_allclose(found[:3], row.mean(axis=0), rtol=1e-12)  # translation is the mounts' mean


@pytest.mark.parametrize("height", [0.0, 0.7])
def test_where_all_stand_at_one_height_roll_and_pitch_are_those_of_the_plane(height: float) -> None:
    plant, ground = plant_of({**FLAT, "d": (-1.0, -0.1)}, height), noise(4, 3)
    x, y, _ = np.array(plant.positions).T
    plane = np.linalg.lstsq(np.column_stack([np.ones(4), y, -x]), ground[:, :, 2].T, rcond=None)[0]
    found = floor_as_whole(ground, plant)
    np.testing.assert_allclose(found[:, [3, 4]], plane[1:].T, rtol=0, atol=1e-13 * np.abs(plane).max())
    turned = ground.copy()
    turned[:, :, 2] += noise(4)  # yaw comes from x and y alone
    np.testing.assert_allclose(floor_as_whole(turned, plant)[:, 5], found[:, 5], rtol=0, atol=1e-18)


@pytest.mark.parametrize("places", [FLAT, SPACE], ids=["three, flat", "five, in space"])
@pytest.mark.parametrize("dof", ["rx", "ry", "rz"])
def test_a_machine_that_turns_by_a_tenth_is_20_db_quieter(places: dict[str, Any], dof: str) -> None:
    plant, turn, k = plant_of(places), noise(), SLAB.index(dof)
    spin = np.zeros((TIMES.size, 1, 3))
    spin[:, 0, k - 3] = turn
    machine = np.zeros((TIMES.size, 6))
    machine[:, k] = 0.1 * turn
    found = attenuation(plant, np.cross(spin, np.array(plant.positions)[None]), machine)
    np.testing.assert_allclose(list(found[dof].values()), 20.0, atol=1e-9)
    assert len(found[dof]) > 12
    assert all(not found[other] for other in ("rx", "ry", "rz") if other != dof)


@pytest.mark.parametrize(("share", "said"), [(0.095, False), (0.105, True)])
def test_a_yaw_below_a_tenth_of_a_single_mounts_motion_says_nothing(share: float, said: bool) -> None:
    """Four mounts on a circle: by yaw each moves tangentially, by what strains the floor radially."""
    angle = np.array([0.25, 0.75, 1.25, 1.75]) * np.pi
    plant, floor = plant_of({f"m{k}": (0.7 * np.cos(a), 0.7 * np.sin(a)) for k, a in enumerate(angle)}), noise()
    ground, machine = np.zeros((TIMES.size, 4, 3)), np.zeros((TIMES.size, 6))
    tangent, outward = np.array([-np.sin(angle), np.cos(angle)]), np.array([np.cos(angle), np.sin(angle)])
    both = share * tangent + np.sqrt(1.0 - share**2) * outward
    ground[:, :, :2] = floor[:, None, None] * both.T
    machine[:, 5] = 0.01 * floor
    assert bool(attenuation(plant, ground, machine)["rz"]) is said
    machine[:, 5] = share * 0.01 * floor / 0.7
    if said:
        np.testing.assert_allclose(list(attenuation(plant, ground, machine)["rz"].values()), 40.0, atol=1e-6)
