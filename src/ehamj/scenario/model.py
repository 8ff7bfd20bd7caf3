"""What a user writes: a TOML file, validated, completed with defaults, and written back complete."""

from collections.abc import Mapping
from functools import cached_property
from typing import Any, Literal, Self

import numpy as np
import tomli_w
from pydantic import Field, model_validator

from ehamj.control import LinearController
from ehamj.control.commands import Passive
from ehamj.control.kinds import STANDARD, Control, VariantName
from ehamj.control.sensors import Sensors
from ehamj.criteria.response_spectrum import HIGHEST_SHARE
from ehamj.criteria.settings import CriteriaSettings
from ehamj.errors import InputError
from ehamj.faults.kinds import Fault, check_faults
from ehamj.forces.force import Load
from ehamj.forces.kinds import Force, check_forces, load_of
from ehamj.ground.kinds import Ground, RestGround
from ehamj.ground.motion import Motion, Start
from ehamj.isolator.actuator import Actuator
from ehamj.isolator.presets import ACTUATOR_PRESETS, OILS
from ehamj.isolator.supply import Supply
from ehamj.plant.machine import Machine
from ehamj.plant.mounts import DEFAULT_MOUNTS, MOUNTS, Mount
from ehamj.plant.plant import Plant
from ehamj.plant.points import Relative, check_points, check_relatives, default_points
from ehamj.settings import Positive, Settings, Vector3
from ehamj.signals import Signal


class Isolator(Actuator):
    """An actuator as a table [actuators.NAME]: a preset and what differs from it."""

    preset: Literal["first-generation", "recommended", "elastic-mount", "pneumatic-mount"] = Field(
        "first-generation", description="where values that are not given come from"
    )

    oil: Literal["paper", "mineral", "mineral-aerated", "water-glycol"] = Field(
        "paper", description="sets bulk_modulus, air_fraction and vapour_pressure where they are not given"
    )

    @model_validator(mode="before")
    @classmethod
    def _fill_from_preset(cls, table: Any) -> Any:
        name = table.get("preset", "first-generation") if isinstance(table, Mapping) else None
        if not isinstance(name, str) or name not in ACTUATOR_PRESETS:
            return table  # the field's own validation says what is allowed
        oil = table.get("oil", "paper")
        if not isinstance(oil, str) or oil not in OILS:
            return table
        preset = ACTUATOR_PRESETS[name]
        values = {**preset.model_dump(exclude={"sources"}), **OILS[oil]}
        assumed = dict.fromkeys(OILS[oil], "assumed")
        known = {**preset.sources, **assumed}
        sources = {k: v for k, v in known.items() if k not in table or table[k] == values[k]}
        own = table.get("sources", {})
        return {**values, **table, "sources": {**sources, **own} if isinstance(own, Mapping) else own}


class Output(Settings):
    """What is written beside the numbers."""

    replay: bool = Field(True, description="write replay.rrd")
    report: bool = Field(True, description="write report.html and figures/")
    bookkeeping: bool = Field(False, description="balance oil and energy in states of their own, and report them")
    exaggeration: Positive | Literal["auto"] = Field("auto", description="factor on the motions drawn in the replay")


class Scenario(Settings):
    """One simulation, completely described. All values in SI."""

    name: str = Field("unnamed", description="short name", min_length=1)
    description: str = Field("", description="what it is about, one line")
    duration: float = Field(10.0, gt=0, description="simulated time [s]")
    seed: int = Field(0, ge=0, description="seed of everything random")
    gravity: float = Field(9.80665, ge=0, description="gravitational acceleration, downwards [m/s²]")
    timestep: Positive | Literal["auto"] = Field(
        "auto", description="integration step [s]; auto resolves the fastest mode"
    )
    record_rate: float = Field(1000.0, gt=0, description="rows of the result per second [Hz]")
    plates: Literal["sliding", "tied"] = Field(
        "sliding", description="plates on joints of their own, or as inertia of the stroke coordinates (faster)"
    )
    compare: tuple[VariantName, ...] = Field((), description="variants to run beside it, into folders of their names")
    machine: Machine = Machine()
    mount: tuple[Mount, ...] = Field(DEFAULT_MOUNTS, description="the four mounts")
    actuators: dict[str, Isolator] = Field(
        default_factory=lambda: {"isolator": Isolator()}, description="actuators by name"
    )
    supply: Supply = Supply()
    ground: Ground = RestGround()
    control: Control = Passive()
    points: dict[str, Vector3] = Field(
        {},
        description="points of the machine that are reported, by name: from the mount plane's centre [m]; where the "
        "table is left out, the drawing's spindle nose (assumed)",
    )
    relative: tuple[Relative, ...] = Field((), description="motions of one place relative to another")
    criteria: CriteriaSettings = CriteriaSettings()
    sensors: Sensors = Sensors()
    force: tuple[Force, ...] = Field((), description="forces on the machine itself, which add up")
    fault: tuple[Fault, ...] = Field((), description="what fails in the course of the run; the law knows nothing of it")
    output: Output = Output()

    @model_validator(mode="after")
    def _observed(self) -> Self:
        if "points" not in self.model_fields_set:
            object.__setattr__(self, "points", default_points(self.machine))
        check_points(self.points, self.machine, MOUNTS)
        check_relatives(self.relative, self.points, MOUNTS)
        check_forces(self.force, self.points)
        check_faults(self.fault, MOUNTS, self.duration)
        spectrum = self.criteria.response_spectrum
        if spectrum is not None and spectrum.last > HIGHEST_SHARE * self.record_rate:
            raise ValueError(
                f"criteria.response_spectrum.last = {spectrum.last:g} Hz must be at most record_rate/10 = "
                f"{HIGHEST_SHARE * self.record_rate:g} Hz"
            )
        return self

    @model_validator(mode="after")
    def _consistent(self) -> Self:
        names = tuple(mount.name for mount in self.mount)
        if sorted(names) != sorted(MOUNTS):
            raise ValueError(f"mount names {list(names)} must be {', '.join(MOUNTS)}, each once")
        half_x, half_y = self.machine.size[0] / 2, self.machine.size[1] / 2
        for mount in self.mount:
            x, y = mount.position
            if abs(x) > half_x or abs(y) > half_y:
                raise ValueError(
                    f"mount {mount.name}: position = [{x:g}, {y:g}] lies outside the machine, "
                    f"which covers ±{half_x:g} by ±{half_y:g} m (machine.size)"
                )
            if mount.actuator not in self.actuators:
                raise ValueError(
                    f"mount {mount.name}: actuator = {mount.actuator!r} must be one of the tables "
                    f"[actuators.NAME]: {', '.join(self.actuators)}"
                )
        at = {mount.name: mount.position for mount in self.mount}
        if not (min(at["front-left"][0], at["front-right"][0]) > max(at["rear-left"][0], at["rear-right"][0])):
            raise ValueError("mount positions: x of the front mounts must be larger than x of the rear mounts")
        if not (min(at["front-left"][1], at["rear-left"][1]) > max(at["front-right"][1], at["rear-right"][1])):
            raise ValueError("mount positions: y of the left mounts must be larger than y of the right mounts")
        return self

    @cached_property
    def _mounts(self) -> tuple[Mount, ...]:
        return tuple(sorted(self.mount, key=lambda mount: MOUNTS.index(mount.name)))

    @property
    def running(self) -> dict[str, Actuator]:
        """The actuators with the values that they run with, which is what is to be shown of them."""
        return {name: actuator.running_on(self.supply) for name, actuator in self.actuators.items()}

    @property
    def plant(self) -> Plant:
        """The physical part, mounts in order."""
        return Plant(
            machine=self.machine,
            positions=tuple(mount.position for mount in self._mounts),
            actuators=tuple(self.actuators[mount.actuator].rated_at(self.supply) for mount in self._mounts),
            supply=self.supply,
            gravity=self.gravity,
            mounts=tuple(mount.name for mount in self._mounts),
            bookkeeping=self.output.bookkeeping,
            plates=self.plates,
        )

    def motion(self) -> Motion:
        """The ground's motion.

        Raises:
            InputError: if a record cannot be used.
        """
        plant = self.plant
        try:
            return self.ground.motion(Start(plant.mounts, np.array(plant.positions), self.duration, self.seed))
        except ValueError as error:
            raise InputError(str(error)) from error

    def commands(self) -> tuple[Signal, ...]:
        """The open-loop command of each mount [V]."""
        return self.control.commands(self.plant.mounts)

    def load(self) -> Load:
        """The forces on the machine itself."""
        return load_of(self.force, self.points, self.machine.cg, self.duration, self.seed)

    def controller(self) -> LinearController | None:
        """The digital controller, if there is one.

        Raises:
            InputError: if a law cannot be read or run.
        """
        return self.control.controller(self.plant, self.sensors)

    def variant(self, name: str) -> "Scenario":
        """The same scenario under another control, one of `ehamj.control.kinds.STANDARD`."""
        return self.model_copy(update={"control": STANDARD[name], "compare": (), "name": f"{self.name}, {name}"})

    def to_toml(self) -> str:
        """The complete scenario as TOML; it runs again to the same result."""
        return tomli_w.dumps(self.model_dump(mode="python", exclude_none=True), multiline_strings=False)
