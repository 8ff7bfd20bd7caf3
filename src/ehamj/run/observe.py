"""From recorded rows to the labelled channels of a result: one function per family of channels."""

import platform
from collections.abc import Sequence
from functools import cache
from importlib.metadata import version
from typing import Any

import numpy as np
import xarray as xr

from ehamj.arrays import Array
from ehamj.belonging import identity_of
from ehamj.control import AnyController
from ehamj.control.learners import Learnt
from ehamj.isolator.chambers import held
from ehamj.memory import LEDGER, activations
from ehamj.mujoco.rows import Rows
from ehamj.mujoco.slides import FIRST
from ehamj.plant.axes import DOF_OF_JOINT
from ehamj.plant.kinematics import points_motion
from ehamj.result import make_dataset
from ehamj.run.faults import Struck
from ehamj.run.prepare import Prepared
from ehamj.scenario.model import Scenario
from ehamj.variables import MOTIONS, labels_of

Channels = dict[str, Array]

REPORTED_VERSIONS = ("ehamj", "mujoco", "numpy", "scipy", "numba", "control", "rerun-sdk", "xarray", "obspy")


def observe(prepared: Prepared, rows: Rows, struck: Sequence[Struck] = (), first: int = 0) -> xr.Dataset:
    """Everything that a result holds, from recorded rows: whatever of a run is observed at once, rows are the same.

    Args:
        prepared: what was simulated.
        rows: recorded, all or some that follow each other.
        struck: faults of the run until then.
        first: number of the first of these rows.
    """
    scenario, plant = prepared.scenario, prepared.scenario.plant
    times = np.arange(first, first + len(rows.qpos), dtype=np.float64) / scenario.record_rate
    displacement, velocity, acceleration = (part[:, list(DOF_OF_JOINT)] for part in (rows.qpos, rows.qvel, rows.qacc))
    mounts = len(plant.mounts)
    ground = prepared.motion.sample(times).below(mounts)
    places = [*plant.positions, plant.machine.cg, *scenario.points.values()]
    moved = zip(*points_motion(displacement, velocity, acceleration, places), strict=True)
    channels = {"machine_displacement": displacement, "machine_velocity": velocity}
    for motion, each in zip(MOTIONS, moved, strict=True):
        channels |= {f"ground_{motion}": getattr(ground, motion), f"foot_{motion}": np.stack(each[:mounts], axis=1)}
        channels[f"cg_{motion}"] = each[mounts]
        if scenario.points:
            channels[f"point_{motion}"] = np.stack(each[mounts + 1 :], axis=1)
    channels |= _strokes(prepared, rows, channels)
    channels |= _oil(prepared, rows, channels["stroke"])
    for one in struck:
        if set(one.plant.cut_off) == set(plant.mounts):  # a constant supply that is lost
            channels["supply_pressure"][times >= one.time - 1e-9] = plant.supply.tank_pressure
    channels |= _relative(scenario, channels)
    if scenario.force:
        channels["external_force"] = scenario.load().sample(times)[0]
    if plant.slides:
        begins = [slide.begins for slide in plant.slides]
        channels["slide"] = rows.qpos[:, FIRST : FIRST + len(begins)] + begins
    if prepared.loop.sensing.channels:
        channels["measured"] = rows.readings
    law = prepared.controller
    if law is not None:
        channels |= _of_the_law(law, rows)
    return make_dataset(times, channels, {"title": scenario.name}, labels_of(scenario, law))


def identity(prepared: Prepared, dataset: xr.Dataset) -> str:
    """What a run and its files are told by (`ehamj.belonging`): all of its scenario but the law, which shows in how it
    ends, and may come from elsewhere."""
    return identity_of(prepared.scenario.model_dump_json(exclude={"control"}), versions(), dataset)


@cache
def versions() -> dict[str, str]:
    """Of Python and of the packages whose versions a summary reports."""
    return {"python": platform.python_version(), **{name: version(name) for name in REPORTED_VERSIONS}}


def _of_the_law(law: AnyController, rows: Rows) -> Channels:
    """States of the laws, frequencies that they follow, and what they have learnt. Single precision: they are looked
    at, not calculated with, and may be many."""
    own = law.states, law.states + len(law.lines)
    states, frequencies, learnt = np.split(rows.states.astype(np.float32), own, axis=1)
    found: dict[str, Any] = {"controller_state": states} if states.size else {}
    if frequencies.size:
        found["line_frequency"] = frequencies
    if learnt.size:
        parts = learnt.reshape(len(learnt), -1, len(Learnt._fields))
        found |= {f"learnt_{name}": parts[:, :, k] for k, name in enumerate(Learnt._fields)}
    return found


def _strokes(prepared: Prepared, rows: Rows, channels: Channels) -> Channels:
    """Plates relative to the ground along their actions: joints of their own if they slide, the machine's feet if they
    are tied; where the machine's turns count, with what they add to the linear motion of a foot."""
    plant, model = prepared.scenario.plant, prepared.model
    J, along = plant.layout.rows, np.array(plant.directions)
    found: Channels = {}
    for name, motion, own in (("stroke", "displacement", rows.qpos), ("stroke_velocity", "velocity", rows.qvel)):
        plate = linear = channels[f"machine_{motion}"] @ J.T
        if plant.plates == "sliding":
            plate = own[:, [model.jnt_qposadr[model.joint(f"plate {mount}").id] for mount in plant.mounts]]
        if not plant.level_enough:
            plate = plate + ((channels[f"foot_{motion}"] * along).sum(axis=2) - linear)
        found[name] = plate - (channels[f"ground_{motion}"] * along).sum(axis=2)
    found["stroke"] -= np.array(plant.heights)
    return found


def _oil(prepared: Prepared, rows: Rows, stroke: Array) -> Channels:
    """Valves, chambers and supply; with bookkeeping what crossed the chambers' borders, and what they hold."""
    plant = prepared.scenario.plant
    parts = activations(prepared.model, rows.act)
    states = np.stack([parts.isolators["pressure_1"], parts.isolators["pressure_2"]], axis=-1)
    chambers = held(plant.actuators, states, stroke)
    supply = np.full(stroke.shape[0], plant.supply.pressure)
    if plant.supply.dynamic:
        supply = parts.supply["supply_pressure"][:, 0]
    channels = {
        "spool": parts.isolators["spool"],
        "valve_command": rows.command,
        "actuator_force": chambers.force,
        "chamber_pressure": chambers.pressure,
        "chamber_void": chambers.void,
        "chamber_flow": rows.flow,
        "supply_pressure": supply,
    }
    if plant.bookkeeping:
        channels |= {name: parts.ledger[name][:, 0] for name in LEDGER.names or ()}
        channels["oil_in"] = np.stack([parts.oil["oil_in_1"], parts.oil["oil_in_2"]], axis=-1)
        channels |= {"oil_held": chambers.mass, "oil_energy": chambers.energy.sum(axis=(1, 2))}
    return channels


def _relative(scenario: Scenario, channels: Channels) -> Channels:
    """Motion of places relative to each other, as the scenario names them."""
    mounts, points = scenario.plant.mounts, list(scenario.points)

    def motion_at(place: str, motion: str) -> Array:
        if place in points:
            return channels[f"point_{motion}"][:, points.index(place)]
        what, _, mount = place.partition(" ")
        values = channels[f"{what}_{motion}"]
        return values[:, mounts.index(mount)] if mount else values

    found = {}
    for motion in MOTIONS[:2] if scenario.relative else ():
        between = [motion_at(r.origin, motion) - motion_at(r.to, motion) for r in scenario.relative]
        found[f"relative_{motion}"] = np.stack(between, axis=1)
    return found
