"""The matrices of small motions: against the engine's own accelerations, closed forms, and each other."""

from dataclasses import dataclass, replace
from typing import Any

import mujoco
import numpy as np
import pytest
from harness import SKEW_MOUNTS

from ehamj.arrays import Array
from ehamj.isolator.cylinder import oil_force
from ehamj.linear.elements import Elements
from ehamj.linear.values import Values
from ehamj.memory import MACHINE_BODY, SLIDE, activations, exchange, isolators, size
from ehamj.mujoco import hydraulics
from ehamj.mujoco.equilibrium import Inputs, equilibrium
from ehamj.mujoco.model import build_model
from ehamj.mujoco.slides import FIRST, drives
from ehamj.plant.axes import DOFS, JOINTS
from ehamj.plant.levers import lever
from ehamj.plant.plant import Plant
from ehamj.scenario.load import parse_scenario
from ehamj.smallmotion.cubics import acting, staged, weights
from ehamj.smallmotion.machine import SmallMachine, small_machine

STEP = 1e-4
CORNERS = [("a", [0.9, 0.6]), ("b", [0.9, -0.6]), ("c", [-0.9, 0.6]), ("d", [-0.8, -0.6])]
TIED: dict[str, Any] = {"plates": "tied"}
SOFT: dict[str, Any] = {"foot_stiffness": 1e9, "foot_damping": 1e4}
ELASTIC: dict[str, Any] = {"plates": "sliding", "actuators": {"isolator": SOFT}}
MIXED: dict[str, Any] = {
    "plates": "sliding",
    "mount": [
        {"name": name, "position": at, "actuator": "soft" if name in "bd" else "isolator"} for name, at in CORNERS
    ],
    "actuators": {"isolator": {"lateral_damping": 1e4}, "soft": {**SOFT, "plate_mass": 20.0}},
}
UNEQUAL: dict[str, Any] = {
    **TIED,
    "mount": [
        {"name": name, "position": at, "actuator": name, "height": 1e-5 * k} for k, (name, at) in enumerate(CORNERS)
    ],
    "actuators": {
        name: {"membrane_stiffness": 3e8 * k, "plate_mass": 5.0 * k, "piston_area": 1e-2 * k, "area_ratio": 0.9}
        for k, name in enumerate("abcd", start=1)
    },
    "machine": {"cg": [0.2, -0.1, 1.0]},
    "part": [{"name": "magazine", "mass": 400.0, "position": [0.6, 0.7, 1.2]}],
}
LONG: dict[str, Any] = {"chamber_volume": 5e-3}
SKEW: dict[str, Any] = {
    **TIED,
    "mount": SKEW_MOUNTS,
    "actuators": {"isolator": LONG},
    "machine": {"cg": [0.1, -0.05, 0.8]},
}
SKEW_ELASTIC: dict[str, Any] = {**SKEW, "plates": "sliding", "actuators": {"isolator": {**LONG, **SOFT}}}
RAILS = {"t": (1000.0, [1.0, 0.3, 0.2], 0.4), "u": (300.0, [0.0, 1.0, 0.0], -0.4)}
PACE = {"speed": 0.3, "acceleration": 2.0, "jerk": 20.0}
MOVING: dict[str, Any] = {
    "slide": [
        {
            "name": name, "mass": mass, "position": [0.1, 0.05, 0.9], "rail": rail, "travel": [-0.5, 0.5], "start": 0.1,
            "profile": {"kind": "moves", "moves": [{"time": 0.1, "to": to, **PACE}]},
        }
        for name, (mass, rail, to) in RAILS.items()
    ]
}  # fmt: skip
MACHINES: dict[str, dict[str, Any]] = {
    "tied": TIED,
    "elastic": ELASTIC,
    "unequal": UNEQUAL,
    "slides": {**TIED, **MOVING, "gravity": 0.0},
    "skew": SKEW,
    "skew elastic": SKEW_ELASTIC,
    "skew slides": {**SKEW, **MOVING, "gravity": 0.0},
}
"""Slides here are weightless: the machine's acceleration where they went, times its turn, is of second order."""


@dataclass(frozen=True)
class Standing:
    """A machine at its equilibrium over ground that is not level."""

    plant: Plant
    model: mujoco.MjModel
    data: mujoco.MjData
    small: SmallMachine

    @classmethod
    def of(cls, table: dict[str, Any], ground: float = 1e-6) -> "Standing":
        return cls.of_plant(parse_scenario(table).plant, ground)

    @classmethod
    def of_plant(cls, plant: Plant, ground: float) -> "Standing":
        model = build_model(plant, STEP)
        data = mujoco.MjData(model)
        held = Inputs.rest(model)
        held.displacement[:] = ground * np.random.default_rng(5).normal(size=held.displacement.shape)
        with hydraulics():
            equilibrium(model, data, held)
        return cls(plant, model, data, small_machine(model, data, plant))


@dataclass(frozen=True)
class Moved:
    """A small motion: of the free coordinates and their rates, ground and its velocity, load, pressures."""

    q: Array
    v: Array
    ground: Array
    ground_rate: Array
    load: Array
    pressures: Array

    @classmethod
    def drawn(cls, standing: Standing, size: float) -> "Moved":
        """At a size of 1: 1 µm and 0.1 mm/s, 10 nrad and 1 µrad/s, 10 N, 10 kPa."""
        draw, mounts = np.random.default_rng(1), len(standing.plant.mounts)
        n = standing.small.mass.shape[0]
        unit = np.full(n, 1e-6)
        unit[3:6] = 1e-8
        return cls(
            size * unit * draw.normal(size=n),
            size * 100.0 * unit * draw.normal(size=n),
            size * 1e-6 * draw.normal(size=(mounts, 3)),
            size * 1e-4 * draw.normal(size=(mounts, 3)),
            size * 10.0 * draw.normal(size=6),
            size * 1e4 * draw.normal(size=(2, mounts)),
        )


def engine(standing: Standing, moved: Moved, first: int) -> tuple[Array, Array, Array]:
    """The engine's accelerations of the free coordinates, its strokes and their rates, at the start of a step."""
    model, small, mounts = standing.model, standing.small, len(standing.plant.mounts)
    data = mujoco.MjData(model)
    data.act[:] = standing.data.act
    oil = activations(model, data.act).isolators
    oil["pressure_1"] += moved.pressures[0]
    oil["pressure_2"] += moved.pressures[1]
    qpos, qvel, _ = small.in_model(np.array([first * STEP]), moved.q[None], moved.v[None], 0.0 * moved.q[None])
    data.qpos[:], data.qvel[:] = qpos[0], qvel[0]
    Inputs(small.ground_at_rest + moved.ground, moved.ground_rate, np.zeros(mounts)).write(data)
    data.xfrc_applied[MACHINE_BODY] = moved.load
    if slides := standing.plant.slides:
        driven = drives(standing.plant, [slide.course() for slide in slides], first, 1, STEP)
        data.userdata[-size(SLIDE) * len(slides) :] = driven.ravel()
    with hydraulics():
        mujoco.mj_forward(model, data)
    free = np.delete(np.arange(model.nv), FIRST + np.arange(len(standing.plant.slides)))
    found = np.linalg.lstsq(small.coordinates[free], data.qacc[free])[0]
    given = exchange(data, mounts)
    return (
        found,
        data.actuator_length[:mounts] - given["ground"],
        data.actuator_velocity[:mounts] - given["ground_rate"],
    )


def equation(standing: Standing, moved: Moved, first: int) -> tuple[Array, Array, Array, Array]:
    """P z + pushed, strokes and their rates; and the largest term of each acceleration."""
    small, model = standing.small, standing.model
    displaced, effects = small.ground_at_rest + moved.ground, small.effects
    load = np.stack([moved.load, np.zeros(6)], axis=1)[None]
    coefficients = small.in_time(first, 1, STEP, (load, load))
    ridden = effects.always + effects.by_value @ displaced.ravel() + effects.by_rate @ moved.ground_rate.ravel()
    if coefficients.inverse is not None:
        ridden = coefficients.inverse[0, 0] @ ridden
    assert coefficients.pushed is not None
    pushed = ridden + coefficients.pushed[0, 0]
    own = isolators(model).view(np.recarray)
    force = oil_force.py_func(*moved.pressures, own)
    z, matrix = np.concatenate([moved.q, moved.v, force]), coefficients.matrix[0, 0]
    largest = np.maximum(np.abs(matrix * z).max(axis=1), np.abs(pushed))
    strokes = effects.stroke + small.levers @ moved.q - np.sum(effects.along * displaced, axis=1)
    rates = small.levers @ moved.v - np.sum(effects.along * moved.ground_rate, axis=1)
    return matrix @ z + pushed, strokes, rates, largest


STEPS = {False: (0,), True: (0, 5000)}
"""Steps at which slides stand, and go at constant speed."""


@pytest.mark.parametrize("name", MACHINES)
def test_accelerations_and_strokes_are_the_engines_to_first_order(name: str) -> None:
    """Half the difference of a motion and its opposite has nothing of second order: 1e-9 is what a slide's armature
    gives way, and far above the rounding of the membranes' forces."""
    standing = Standing.of(MACHINES[name])
    for first in STEPS[bool(standing.plant.slides)]:
        there, back = (Moved.drawn(standing, size) for size in (1.0, -1.0))
        *_, largest = equation(standing, there, first)
        ours, theirs = (
            [0.5 * (a - b) for a, b in zip(of(standing, there, first), of(standing, back, first), strict=True)][:3]
            for of in (equation, engine)
        )
        assert np.abs((ours[0] - theirs[0]) / largest).max() < 1e-9
        for stroke, of_engine in zip(ours[1:], theirs[1:], strict=True):
            assert np.abs(stroke - of_engine).max() < 1e-9 * np.abs(stroke).max()


@pytest.mark.parametrize("name", ["tied", "skew", "elastic", "skew elastic"])
def test_what_is_left_out_grows_with_the_square_of_the_motion(name: str) -> None:
    standing = Standing.of(MACHINES[name])
    sizes, errors = np.array([1.0, 10.0, 100.0]), []
    for factor in sizes:
        moved = Moved.drawn(standing, factor)
        found, *_, largest = equation(standing, moved, 0)
        errors.append(np.abs((engine(standing, moved, 0)[0] - found) / (largest / factor)).max())
    slope = np.polyfit(np.log(sizes), np.log(errors), 1)[0]
    assert abs(slope - 2.0) < 0.02
    assert errors[0] < 20 * 1e-8  # of the largest term, at angles of 1e-8 rad


@pytest.mark.parametrize("first", [0, 1500, 2800, 5000, 20000])
def test_slides_that_move_push_the_machine_as_the_engines_do(first: int) -> None:
    """Weight and reaction of slides on the machine where it stood before: 1e-9 is what their armature gives way."""
    standing = Standing.of({**TIED, **MOVING})
    still = Moved.drawn(standing, 0.0)
    found = equation(standing, still, first)[0]
    theirs = engine(standing, still, first)[0]
    assert first == 0 or np.abs(theirs).max() > 0.1
    assert np.abs(found - theirs).max() < 3e-9 * max(np.abs(theirs).max(), 1.0)


def test_slides_weigh_and_push_where_their_rails_lead() -> None:
    """m g x on the tilts, −m ẍ d at the rail; the reaction turns with the machine. Tilts at rest of 2e-6 rad are in
    the engine's."""
    standing = Standing.of({**TIED, **MOVING}, ground=0.0)
    tables = standing.small.slides
    assert tables is not None
    order = [JOINTS.index(dof) for dof in DOFS]
    for k, slide in enumerate(standing.plant.slides):
        along, down = np.array(slide.along), np.array([0.0, 0.0, -slide.mass * 9.80665])
        weight = np.concatenate([np.zeros(3), np.cross(along, down)])
        assert np.abs(tables.weight[k][order] - weight).max() < 1e-5 * np.abs(weight).max()
        reaction = -slide.mass * lever(slide.place(slide.begins)).T @ along
        assert np.abs(tables.reaction[k][order] - reaction).max() < 1e-5 * np.abs(reaction).max()
        turned = slide.mass * np.cross(np.eye(3), along).T
        assert np.abs(tables.stiffness_driven[k][:3][:, order[3:]] - turned).max() < 1e-5 * slide.mass


def test_where_slides_stand_they_are_parts_of_the_machine() -> None:
    """The tables at any place have the mass of the machine with the slides locked there."""
    standing = Standing.of({**TIED, **MOVING}, ground=0.0)
    tables = standing.small.slides
    assert tables is not None
    places = {"t": -0.3, "u": 0.5}
    moved = np.array([[places[slide.name] - slide.begins for slide in standing.plant.slides]])
    mass, *_ = tables.added(moved, 0.0 * moved, 0.0 * moved)
    locked = Elements.of(Values.of(standing.plant.locked(places)))  # level: the tilt's share is 2e-6
    assert np.abs(standing.small.mass + mass[0] - locked.mass).max() < 1e-5 * locked.mass.max()


@pytest.mark.parametrize("table", [TIED, ELASTIC, MIXED, UNEQUAL, SKEW, SKEW_ELASTIC], ids=range(6))
def test_matrices_are_those_of_the_closed_forms(table: dict[str, Any]) -> None:
    """Written from the equations, with rotation matrices (`Elements`); 1e-9 of the largest is a tenth of gravity's
    millionth."""
    standing = Standing.of(table, ground=0.0)
    small, closed = standing.small, Elements.at_rest(Values.of(standing.plant))
    for found, expected in (
        (small.mass, closed.mass), (small.stiffness, closed.stiffness), (small.damping, closed.damping)
    ):  # fmt: skip
        assert np.abs(found - expected).max() < 1e-9 * np.abs(expected).max()
        assert np.abs(found - found.T).max() < 1e-14 * np.abs(found).max()
    assert np.abs(small.levers - closed.plate).max() < 1e-9
    np.testing.assert_allclose(small.stroke_at_rest, closed.stroke, rtol=0.0, atol=1e-12)


def test_sliding_plates_on_rigid_feet_are_tied() -> None:
    """Two models, one machine: their equilibria differ by what the engine's constraint gives way, 1e-9 m."""
    tied, sliding = (Standing.of({**SKEW, "plates": plates}).small for plates in ("tied", "sliding"))
    for name in ("mass", "stiffness", "damping", "levers", "ground_stiffness", "ground_damping", "load"):
        there, here = getattr(tied, name), getattr(sliding, name)
        assert here.shape == there.shape
        assert np.abs(here - there).max() < 1e-8 * np.abs(there).max(), name
    assert sliding.coordinates.shape == (11, 6)
    np.testing.assert_allclose(sliding.coordinates[6:], parse_scenario(SKEW).plant.layout.rows[:, [0, 1, 2, 5, 3, 4]])


def test_gravity_tilts_the_default_machine_by_m_g_h() -> None:
    """Plates weigh on their own joints; their levers are constant on level mounts."""
    heavy, weightless = (Standing.of({**TIED, "gravity": g}, ground=0.0).small.stiffness for g in (9.80665, 0.0))
    machine = parse_scenario({}).plant.machine
    toppling = np.zeros((6, 6))
    for dof in ("rx", "ry"):
        k = JOINTS.index(dof)
        toppling[k, k] = machine.mass * 9.80665 * machine.cg[2]
    np.testing.assert_allclose(weightless - heavy, toppling, rtol=0.0, atol=1e-7 * toppling.max())


def test_where_nothing_holds_there_are_six_zero_rows() -> None:
    """No membrane, no gravity: neither ground nor place matters, and only the oil pushes."""
    plant = parse_scenario({**TIED, "gravity": 0.0}).plant
    nothing = dict.fromkeys(("membrane_stiffness", "membrane_damping", "lateral_stiffness", "lateral_damping"), 0.0)
    plant = replace(plant, actuators=tuple(actuator.with_values(nothing) for actuator in plant.actuators))
    small = Standing.of_plant(plant, 0.0).small
    for name in ("stiffness", "damping", "ground_stiffness", "ground_damping"):
        assert not getattr(small, name).any(), name
    assert np.linalg.matrix_rank(small.levers) == 3


def test_the_equilibrium_is_left_as_it_was() -> None:
    standing = Standing.of(SKEW)
    before = [standing.data.qpos.copy(), standing.data.act.copy(), standing.data.userdata.copy()]
    small_machine(standing.model, standing.data, standing.plant)
    for was, now in zip(before, (standing.data.qpos, standing.data.act, standing.data.userdata), strict=True):
        np.testing.assert_array_equal(now, was)
    mounts = exchange(standing.data, 5)
    for k, axis in enumerate("xyz"):
        np.testing.assert_array_equal(standing.small.ground_at_rest[:, k], mounts[f"ground_{axis}"]["value"])


def test_effects_inside_a_step_are_those_of_the_cubics_of_both_ends() -> None:
    """3 t³ + 2 d(t³)/dt in steps of 0.5 s from 1 s on, and its rate apart."""
    times, step = np.array([1.0, 1.5, 2.0]), 0.5
    ends = np.stack([times**3, step * 3.0 * times**2], axis=-1)[:, None]
    found = acting(ends[:-1], ends[1:], weights(np.array([[3.0, 0.0]]), np.array([[2.0, 1.0]]) / step, 2))
    stages = np.array([[1.0, 1.25, 1.5], [1.5, 1.75, 2.0]])
    np.testing.assert_allclose(found[..., 0], 3.0 * stages**3 + 6.0 * stages**2, rtol=1e-14)
    np.testing.assert_allclose(found[..., 1], 3.0 * stages**2, rtol=1e-14)
    value, slope = staged(ends[:-1], ends[1:])
    np.testing.assert_allclose(value[..., 0], stages**3, rtol=1e-14)
    np.testing.assert_allclose(slope[..., 0] / step, 3.0 * stages**2, rtol=1e-14)
