"""From recorded rows to the labelled channels of a result: one function per family of channels."""

import platform
from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from functools import cache, cached_property, partial
from importlib.metadata import version
from typing import Any

import numpy as np
import xarray as xr

from ehamj.arrays import Array
from ehamj.belonging import identity_of
from ehamj.control import AnyController
from ehamj.control.learners import Learnt
from ehamj.ground.motion import GroundSample
from ehamj.isolator.chambers import Held, held
from ehamj.memory import LEDGER, activations
from ehamj.mujoco.rows import Rows
from ehamj.mujoco.slides import FIRST
from ehamj.plant.axes import DOF_OF_JOINT
from ehamj.plant.kinematics import points_moved
from ehamj.result import make_dataset
from ehamj.run.faults import Struck
from ehamj.run.prepare import Prepared
from ehamj.variables import MOTIONS, labels_of

Channels = dict[str, Array]

REPORTED_VERSIONS = ("ehamj", "mujoco", "numpy", "scipy", "numba", "control", "rerun-sdk", "xarray", "obspy")


def observe(
    prepared: Prepared,
    rows: Rows,
    struck: Sequence[Struck] = (),
    first: int = 0,
    wanted: Collection[str] | None = None,
) -> xr.Dataset:
    """What a result holds, from recorded rows: whatever of a run is observed at once, rows are the same to the bit.

    Args:
        prepared: what was simulated.
        rows: recorded, all or some that follow each other.
        struck: faults of the run until then.
        first: number of the first of these rows.
        wanted: channels of those that there are; by default all.
    """
    made = Observing(prepared, rows, struck, first)
    names = [name for name in made if wanted is None or name in wanted]
    found = {name: made[name] for name in reversed(names)}  # accelerations come with what they are made of
    channels = {name: found[name] for name in names}
    made.release()
    return make_dataset(
        made.times,
        channels,
        {"title": prepared.scenario.name},
        labels_of(prepared.scenario, prepared.controller),
    )


def identity(prepared: Prepared, dataset: xr.Dataset) -> str:
    """What a run and its files are told by (`ehamj.belonging`): all of its scenario but the law, which shows in how it
    ends, and may come from elsewhere."""
    return identity_of(prepared.scenario.model_dump_json(exclude={"control"}), versions(), dataset)


@cache
def versions() -> dict[str, str]:
    """Of Python and of the packages whose versions a summary reports."""
    return {"python": platform.python_version(), **{name: version(name) for name in REPORTED_VERSIONS}}


class Observing(Mapping[str, Array]):
    """Channels of some rows, in a result's order; each is made when it is asked for."""

    def __init__(self, prepared: Prepared, rows: Rows, struck: Sequence[Struck] = (), first: int = 0) -> None:
        """Arguments as of `observe`."""
        self._prepared, self._rows, self._struck = prepared, rows, struck
        self._scenario, self._plant = prepared.scenario, prepared.plant
        self.times = np.arange(first, first + len(rows.qpos), dtype=np.float64) / prepared.scenario.record_rate
        self._made: Channels = {}
        self._makers = dict(self._families())

    def __getitem__(self, name: str) -> Array:
        if name not in self._made:
            found = self._makers[name]()
            self._made |= found if isinstance(found, dict) else {name: found}
        return self._made[name]

    def release(self) -> None:
        """Forget how channels are made, which holds what it is held by: rows would wait for a collection."""
        self._makers.clear()

    def __iter__(self) -> Iterator[str]:
        return iter(self._makers)

    def __len__(self) -> int:
        return len(self._makers)

    def _families(self) -> Iterator[tuple[str, Callable[[], Array | Channels]]]:
        """What makes each channel, or all of its family."""
        rows, scenario, plant, law = self._rows, self._scenario, self._plant, self._prepared.controller
        yield "machine_displacement", lambda: self._machine(0)
        yield "machine_velocity", lambda: self._machine(1)
        for order, motion in enumerate(MOTIONS):
            yield f"ground_{motion}", partial(self._ground, motion)
            for name in self._places:
                yield f"{name}_{motion}", partial(self._moved, order, name)
        yield "stroke", lambda: self._strokes("displacement", rows.qpos) - np.array(plant.heights)
        yield "stroke_velocity", lambda: self._strokes("velocity", rows.qvel)
        yield "spool", lambda: self._parts.isolators["spool"]
        yield "valve_command", lambda: rows.command
        yield "actuator_force", lambda: self._chambers.force
        yield "chamber_pressure", lambda: self._chambers.pressure
        yield "chamber_void", lambda: self._chambers.void
        yield "chamber_flow", lambda: rows.flow
        yield "supply_pressure", self._supply
        if plant.bookkeeping:
            for name in LEDGER.names or ():
                yield name, partial(lambda own: self._parts.ledger[own][:, 0], name)
            yield "oil_in", lambda: np.stack([self._parts.oil[f"oil_in_{k}"] for k in (1, 2)], axis=-1)
            yield "oil_held", lambda: self._chambers.mass
            yield "oil_energy", lambda: self._chambers.energy.sum(axis=(1, 2))
        for motion in MOTIONS[:2] if scenario.relative else ():
            yield f"relative_{motion}", partial(self._relative, motion)
        if self._pushed:
            yield "external_force", self._load
        if plant.slides:
            begins = [slide.begins for slide in plant.slides]
            yield "slide", lambda: rows.qpos[:, FIRST : FIRST + len(begins)] + begins
        if self._prepared.loop.sensing.channels:
            yield "measured", lambda: rows.readings
        if law is not None:
            yield from ((name, partial(_of_the_law, law, rows)) for name in _names_of(law, rows))

    @property
    def _pushed(self) -> bool:
        """Whether forces act on the machine itself."""
        return bool(self._scenario.force)

    def _load(self) -> Array:
        return self._scenario.load().sample(self.times)[0]

    def _machine(self, order: int) -> Array:
        """The machine's motion or a derivative of it, (time, dof)."""
        rows = self._rows
        return (rows.qpos, rows.qvel, rows.qacc)[order][:, list(DOF_OF_JOINT)]

    @cached_property
    def _places(self) -> dict[str, Sequence[Any]]:
        """Places of the machine by what they are called in channels, (point, 3) each [m]."""
        found: dict[str, Sequence[Any]] = {"foot": self._plant.positions, "cg": [self._plant.machine.cg]}
        return found | ({"point": list(self._scenario.points.values())} if self._scenario.points else {})

    def _moved(self, order: int, place: str) -> Channels:
        """A motion of places of the machine, and what it takes to know it."""
        motions = [self._machine(k) for k in range(order + 1)]
        return self._named(place, points_moved(motions, self._places[place]))

    def _named(self, place: str, moved: Sequence[Array]) -> Channels:
        """Motions of places as channels."""
        return {
            f"{place}_{motion}": found[0] if place == "cg" else np.ascontiguousarray(np.moveaxis(found, 0, 1))
            for motion, found in zip(MOTIONS, moved, strict=False)
        }

    @cached_property
    def _sampled(self) -> GroundSample:
        return self._prepared.motion.sample(self.times).below(len(self._plant.mounts))

    def _ground(self, motion: str) -> Array:
        sampled: Array = getattr(self._sampled, motion)
        return sampled

    def _strokes(self, motion: str, own: Array) -> Array:
        """Plates relative to the ground along their actions: joints of their own if they slide, the machine's feet if
        they are tied; where the machine's turns count, with what they add to the linear motion of a foot."""
        plant, model = self._plant, self._prepared.model
        along = np.array(plant.directions)
        plate = linear = self[f"machine_{motion}"] @ plant.layout.rows.T
        if plant.plates == "sliding":
            plate = own[:, [model.jnt_qposadr[model.joint(f"plate {mount}").id] for mount in plant.mounts]]
        if not plant.level_enough:
            plate = plate + ((self[f"foot_{motion}"] * along).sum(axis=2) - linear)
        return np.asarray(plate - (self[f"ground_{motion}"] * along).sum(axis=2))

    @cached_property
    def _parts(self) -> Any:
        return activations(self._prepared.model, self._rows.act)

    @cached_property
    def _chambers(self) -> Held:
        """What the chambers hold; with bookkeeping what crossed their borders stands beside it."""
        own = self._parts.isolators
        states = np.stack([own["pressure_1"], own["pressure_2"]], axis=-1)
        return held(self._plant.actuators, states, self["stroke"])

    def _supply(self) -> Array:
        plant = self._plant
        found = np.full(len(self.times), plant.supply.pressure)
        if plant.supply.dynamic:
            found = self._parts.supply["supply_pressure"][:, 0]
        for one in self._struck:
            if set(one.plant.cut_off) == set(plant.mounts):  # a constant supply that is lost
                found[self.times >= one.time - 1e-9] = plant.supply.tank_pressure
        return found

    def _relative(self, motion: str) -> Array:
        """Motion of places relative to each other, as the scenario names them."""
        mounts, points = self._plant.mounts, list(self._scenario.points)

        def motion_at(place: str) -> Array:
            if place in points:
                return self[f"point_{motion}"][:, points.index(place)]
            what, _, mount = place.partition(" ")
            values = self[f"{what}_{motion}"]
            return values[:, mounts.index(mount)] if mount else values

        return np.stack([motion_at(r.origin) - motion_at(r.to) for r in self._scenario.relative], axis=1)


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


def _names_of(law: AnyController, rows: Rows) -> Iterator[str]:
    """Channels of the laws."""
    if law.states:
        yield "controller_state"
    if law.lines:
        yield "line_frequency"
    if rows.states.shape[1] > law.states + len(law.lines):
        yield from (f"learnt_{name}" for name in Learnt._fields)
