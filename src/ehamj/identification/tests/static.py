"""Strokes and pressures under loads that stay, beside the machine's equilibrium under them."""

from collections.abc import Mapping, Sequence
from typing import Any, Literal, Self

import numpy as np
from pydantic import Field, model_validator

from ehamj.arrays import Array
from ehamj.control.channels import STATIC, quantity_of
from ehamj.errors import InputError
from ehamj.identification.channels import check_seen
from ehamj.identification.machine import with_values
from ehamj.identification.residual import Compared, Failed
from ehamj.identification.tests.test import Context, TestSettings
from ehamj.identification.unknowns import Unknown, Values
from ehamj.linear.machine import linear_model
from ehamj.measured.channels import unit_of
from ehamj.plant.levers import lever
from ehamj.scenario.model import Scenario
from ehamj.settings import NotNegative, Settings, Vector3


class StaticLoad(Settings):
    """A load that stays, beside the weight: a force at a point, and held commands."""

    force: Vector3 = Field((0.0, 0.0, 0.0), description="force on the machine [N]")
    point: str | Vector3 = Field(
        "cg", description="where it acts: a name in [points], 'cg', or a place from the mount plane's centre [m]"
    )
    commands: dict[str, float] = Field(default_factory=dict, description="held command of each valve, by mount [V]")


class StaticTest(TestSettings):
    """Readings at rest, under one load after the other."""

    kind: Literal["static"]
    load: tuple[StaticLoad, ...] = Field(description="loads, one for each reading of a channel", min_length=2)
    reading: dict[str, tuple[float, ...]] = Field(
        description="readings by channel of ehamj ('stroke front-left'), one for each load, in SI [SI of quantity]",
        min_length=1,
    )
    deviation: dict[str, NotNegative] = Field(
        default_factory=dict,
        description="standard deviation of readings, by channel; without: estimated [SI of quantity]",
    )
    zero: Literal["free", "exact"] = Field(
        "free", description="free: readings count from an unknown zero, as those of a dial gauge; exact: from ehamj's"
    )

    @model_validator(mode="after")
    def _agree(self) -> Self:
        for name, values in self.reading.items():
            if len(values) != len(self.load):
                raise ValueError(f"reading: {name!r} has {len(values)} values; it must have one for each of the "
                                 f"{len(self.load)} loads")  # fmt: skip
        for name in self.deviation:
            if name not in self.reading:
                raise ValueError(f"deviation: {name!r} must be one of {', '.join(self.reading)}")
        return self

    def residuals(self, context: Context) -> "StaticResiduals":
        """See `TestSettings.residuals`."""
        scenario, said = self.scenario(context), f"test {self.name!r}: reading"
        for name in self.reading:
            check_seen(name, scenario.plant, said)
            if name != "load_pressure" and quantity_of(name.split(" ")[0]) not in STATIC:
                raise InputError(f"{said}: {name!r} is zero at rest; strokes, displacements and pressures are not")
        for one in self.load:
            unknown = next((mount for mount in one.commands if mount not in scenario.plant.mounts), None)
            if unknown is not None:
                raise InputError(
                    f"test {self.name!r}: load.commands: {unknown!r} must be one of {', '.join(scenario.plant.mounts)}"
                )
            if isinstance(one.point, str) and one.point != "cg" and one.point not in scenario.points:
                known = ", ".join(map(repr, (*scenario.points, "cg")))
                raise InputError(f"test {self.name!r}: load.point = {one.point!r}: must be one of {known}, or a place")
        return StaticResiduals(self, scenario, context.keys)


class StaticResiduals:
    """See `ehamj.identification.residual.Residuals`."""

    def __init__(self, test: StaticTest, scenario: Scenario, keys: Sequence[str]) -> None:
        self.name, self.held_out = test.name, test.hold_out
        self._test, self._scenario, self._keys = test, scenario, keys
        self.unknowns = tuple(
            Unknown(self._zero(name), unit_of(name).text, 0.0, -np.inf, np.inf, test=test.name,
                    size=float(np.ptp(values)) or 1.0, closed=True)
            for name, values in test.reading.items()
            if test.zero == "free"
        )  # fmt: skip

    def compared(self, batch: Sequence[Values]) -> list[tuple[Compared, ...] | Failed]:
        """See `Residuals.compared`."""
        return [self._at(values) for values in batch]

    def rough(self, batch: Sequence[Values], share: float = 1.0) -> list[tuple[Compared, ...] | Failed]:
        """The same."""
        return self.compared(batch)

    def found(self, values: Values) -> Mapping[str, Any]:
        """Nothing else."""
        return {}

    def _at(self, values: Values) -> tuple[Compared, ...] | Failed:
        try:
            scenario = with_values(self._scenario, {key: values[key] for key in self._keys})
            predicted = np.array([self._readings(scenario, one) for one in self._test.load])
        except InputError as error:
            return Failed(str(error))
        found = []
        for k, (name, measured) in enumerate(self._test.reading.items()):
            size, zero = len(measured), self._zero(name)
            free = self._test.zero == "free"
            found.append(
                Compared(
                    name,
                    unit_of(name).text,
                    "number",
                    np.arange(1.0, size + 1.0),
                    np.array(measured),
                    predicted[:, k] + (values[zero] if free else 0.0),
                    np.full(size, self._test.deviation.get(name, np.nan)),
                    {zero: np.ones(size)} if free else {},
                )
            )
        return tuple(found)

    def _readings(self, scenario: Scenario, load: StaticLoad) -> Array:
        """Each channel at rest under a load."""
        plant = scenario.plant
        at = plant.machine.cg if load.point == "cg" else load.point
        place = scenario.points[at] if isinstance(at, str) else at
        arm = lever(np.array(place) - np.array(plant.machine.cg))
        commands = [load.commands.get(mount, 0.0) for mount in plant.mounts]
        model = linear_model(plant, commands, arm.T @ np.array(load.force))
        return np.asarray(model.rows(list(self._test.reading))[0] @ model.equilibrium)

    def _zero(self, name: str) -> str:
        return f"{self.name}.{name}.offset"
