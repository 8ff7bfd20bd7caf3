"""What a user writes: a TOML file, validated, completed with defaults, and written back complete."""

from collections.abc import Mapping
from dataclasses import replace
from functools import cached_property
from pathlib import Path
from typing import Any, Final, Literal, Self, get_args

import numpy as np
import tomli_w
from pydantic import Field, model_validator

from ehamj.control import LinearController
from ehamj.control.commands import Passive
from ehamj.control.installation import PARTS, Installation
from ehamj.control.settings import DigitalSettings
from ehamj.criteria.response_spectrum import HIGHEST_SHARE
from ehamj.criteria.settings import CriteriaSettings
from ehamj.errors import InputError
from ehamj.faults.kinds import Fault, check_faults
from ehamj.forces.force import Load
from ehamj.forces.kinds import Force, check_forces, load_of
from ehamj.ground.kinds import Ground, RestGround
from ehamj.ground.motion import Motion, Start
from ehamj.ground.shared import Floors
from ehamj.notebook import html_table
from ehamj.plant.plant import Plant
from ehamj.plant.points import Relative, check_points, check_relatives, default_points
from ehamj.scenario import brief
from ehamj.scenario.keys import merge, plain
from ehamj.scenario.named import check_named
from ehamj.scenario.variants import Variants, check_variants, variant
from ehamj.scenario.variation import LawChoice, varied
from ehamj.settings import Positive, Settings, Vector3
from ehamj.signals import Signal
from ehamj.synthesis.kinds import Control


class Output(Settings):
    """What is written beside the numbers."""

    replay: bool = Field(True, description="write replay.rrd")
    report: bool = Field(True, description="write report.html and figures/")
    channels: tuple[str, ...] = Field(
        ("*",),
        description="channels of result.nc by name; * and ? stand for any letters, as in foot_*. Verdict, report and "
        "replay of the run are of all channels, whatever is stored",
        min_length=1,
    )
    nichols: bool = Field(False, description="show loop gains as Nichols plots too, in reports and designs")
    bookkeeping: bool = Field(False, description="balance oil and energy in states of their own, and report them")
    exaggeration: Positive | Literal["auto"] = Field("auto", description="factor on the motions drawn in the replay")


Engine = Literal["mujoco", "small-motion"]
ENGINES: Final[tuple[str, ...]] = get_args(Engine)
"""What can step a machine."""


class Course(Settings):
    """What a simulation is called, and how long and how finely it runs."""

    name: str = Field("unnamed", description="short name", min_length=1)
    description: str = Field("", description="what it is about, one line")
    duration: float = Field(10.0, gt=0, description="simulated time [s]")
    seed: int = Field(0, ge=0, description="seed of everything random")
    engine: Engine = Field(
        "mujoco",
        description="mujoco: the multibody engine; small-motion: its matrices about the equilibrium, many times "
        "faster, for turns up to 1 mrad, plates on rigid feet tied",
    )
    timestep: Positive | Literal["auto"] = Field(
        "auto", description="integration step [s]; auto resolves the fastest mode"
    )
    record_rate: float = Field(1000.0, gt=0, description="rows of the result per second [Hz]")
    may_fall: bool = Field(
        False, description="simulate a machine that its mounts do not hold against gravity, to see how it falls"
    )
    compare: tuple[str, ...] = Field(
        (), description="variants to run beside it, into folders of their names: [variants.NAME], or a standard control"
    )
    variants: Variants = Field(
        {},
        description="by name, what of the scenario is otherwise in a variant; a table with a kind replaces the one "
        "that is there, any other adds to it. The law is derived for what comes out, unless designed_for holds it",
    )


class Scenario(Installation, Course):
    """One simulation, completely described. All values in SI."""

    ground: Ground = RestGround.stated()
    control: Control = Passive.stated()
    points: dict[str, Vector3] = Field(
        {},
        description="points of the machine that are reported, by name: from the mount plane's centre [m]; where the "
        "table is left out, the drawing's spindle nose (assumed)",
    )
    relative: tuple[Relative, ...] = Field((), description="motions of one place relative to another")
    criteria: CriteriaSettings = CriteriaSettings.stated()
    force: tuple[Force, ...] = Field((), description="forces on the machine itself, which add up")
    fault: tuple[Fault, ...] = Field((), description="what fails in the course of the run; the law knows nothing of it")
    output: Output = Output.stated()

    @model_validator(mode="after")
    def _observed(self) -> Self:
        if "points" not in self.model_fields_set:
            object.__setattr__(self, "points", default_points(self.machine))
        mounts = tuple(mount.name for mount in self._mounts)
        held = tuple(mount.name for mount in self.nominal._mounts)
        if held != mounts:
            raise ValueError(
                f"control.designed_for: the law is held for a machine on {', '.join(held)}, and this one stands on "
                f"{', '.join(mounts)}; a law commands the mounts that it was derived for, in the same order"
            )
        check_named(self, mounts)
        check_points(self.points, self.machine, mounts)
        check_relatives(self.relative, self.points, mounts)
        check_forces(self.force, self.points)
        check_faults(self.fault, mounts, self.duration)
        check_variants(self)
        spectrum = self.criteria.response_spectrum
        if spectrum is not None and spectrum.last > HIGHEST_SHARE * self.record_rate:
            raise ValueError(
                f"criteria.response_spectrum.last = {spectrum.last:g} Hz must be at most record_rate/10 = "
                f"{HIGHEST_SHARE * self.record_rate:g} Hz"
            )
        return self

    @model_validator(mode="before")
    @classmethod
    def _held(cls, table: Any) -> Any:
        """The machine that a law is held for, where a table says what differs from the scenario's own."""
        control = table.get("control") if isinstance(table, Mapping) else None
        other = control.get("designed_for") if isinstance(control, Mapping) else None
        if control is None or not isinstance(other, Mapping) or other.keys() >= set(PARTS):
            return table
        own = plain({name: table[name] for name in PARTS if name in table})
        merge(own, plain(other), "control.designed_for")
        return {**table, "control": {**control, "designed_for": own}}

    @cached_property
    def table(self) -> Mapping[str, Any]:
        """The scenario as nested tables and lists, to be read only."""
        found: dict[str, Any] = plain(self)
        return found

    @cached_property
    def plant(self) -> Plant:
        """The physical part, mounts in order."""
        return replace(self._standing(), bookkeeping=self.output.bookkeeping)

    @property
    def nominal(self) -> Installation:
        """The machine that the law is derived from: the scenario's own, unless ``control.designed_for`` holds it."""
        held = self.control.designed_for if isinstance(self.control, DigitalSettings) else None
        return self.installation if held is None else held

    def motion(self, floors: Floors | None = None) -> Motion:
        """The ground's motion, of ``floors`` where variants share theirs.

        Raises:
            InputError: if a record cannot be used, or the floor has no side that a sensor may stand upstream on.
        """
        plant, upstream = self.plant, self.sensors.upstream
        places = np.array([*plant.positions, *([] if upstream is None else [upstream.position])])
        start = Start(plant.mounts, places, self.duration, self.seed, upstream is not None)
        try:
            return self.ground.motion(start) if floors is None else floors.motion(self.ground, start)
        except ValueError as error:
            raise InputError(str(error)) from error

    def _repr_html_(self) -> str:
        """What it is, and what it states, as a notebook shows it."""
        return html_table(brief.rows(self))

    def commands(self) -> tuple[Signal, ...]:
        """The open-loop command of each mount [V].

        Raises:
            InputError: if a record cannot be used.
        """
        return self.control.commands(self.plant.mounts, self.duration)

    def load(self) -> Load:
        """The forces on the machine itself, about its centre of gravity with its slides where they start."""
        return load_of(self.force, self.points, self.plant.machine.cg, self.duration, self.seed)

    def pushed(self) -> Load:
        """The same forces about the centre of gravity of the machine without its slides."""
        plant = self.plant
        about = (plant.carrier or plant.machine).cg
        return load_of(self.force, self.points, plant.machine.cg, self.duration, self.seed, about)

    def as_designed(self) -> Self:
        """The scenario on the very machine that its law is derived from."""
        if not isinstance(self.control, DigitalSettings) or self.control.designed_for is None:
            return self
        control = self.control.model_copy(update={"designed_for": None})
        return self.model_copy(update={**{name: getattr(self.nominal, name) for name in PARTS}, "control": control})

    def controller(self) -> LinearController | None:
        """The digital controller, if there is one.

        Raises:
            InputError: if a law cannot be read or run.
        """
        nominal = self.nominal
        return self.control.controller(nominal.plant, nominal.sensors)

    def variant(self, name: str) -> "Scenario":
        """The same scenario as one of its ``variants``, or under one of `ehamj.synthesis.kinds.STANDARD`.

        Raises:
            InputError: if there is no such variant.
        """
        return variant(self, name)

    def varied(self, values: Mapping[str, Any], law: LawChoice = "held") -> "Scenario":
        """The same scenario on another machine, or otherwise changed, by dotted keys as ``--set`` has them:
        ``scenario.varied({"machine.mass": 4400.0, "actuators.isolator.flow_gain": 2.1e-6})``.

        Args:
            values: by dotted key; a whole table replaces the one that is there.
            law: ``held``: as it was derived before, which ``control.designed_for`` then states; ``derived``: anew from
                what came out.

        Warns:
            DerivedAnew: if the law changed together with its machine.

        Raises:
            InputError: with one message that names the key, the value and what is allowed.
        """
        return varied(self, values, law)

    def save(self, path: str | Path) -> None:
        """Write the complete scenario as a TOML file, which runs again to the same result."""
        Path(path).write_text(self.to_toml(), encoding="utf-8")

    def to_toml(self) -> str:
        """The complete scenario as TOML; it runs again to the same result."""
        return tomli_w.dumps(self.model_dump(mode="python", exclude_none=True), multiline_strings=False)
