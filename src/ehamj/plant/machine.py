"""The rigid machine."""

import math
from collections.abc import Mapping, Sequence
from typing import Any, Self

import numpy as np
from pydantic import model_validator

from ehamj.arrays import Array
from ehamj.plant.bodies import Body, Inertia, check_inertia, joined, tensor_of, written_inertia
from ehamj.settings import Parameters, Vector3, quantity

MASS, SIZE = 4000.0, (2.2, 1.6, 1.9)
"""Of the default machine [kg], [m]."""
AIR = 1.2
"""Density of air [kg/m³]: a machine that is lighter is a slip of the unit."""
SPREAD = (0.625, 0.375, 0.125)
"""Its squared distances from the CG along x, y, z, on the average over its mass [m²]."""


def scaled_inertia(mass: float, size: Vector3) -> Vector3:
    """Principal inertia of the default machine, its mass scaled and its shape stretched along each side [kg m²].

    As for any body, J_x = m (⟨y²⟩ + ⟨z²⟩) and so on; the averages go with the squares of the sides, so that what comes
    out is the inertia of a body for every mass and size, and continuous in both.
    """
    x, y, z = (spread * (side / usual) ** 2 for spread, side, usual in zip(SPREAD, size, SIZE, strict=True))
    return (mass * (y + z), mass * (x + z), mass * (x + y))


class Machine(Parameters):
    """The rigid machine: mass properties and outline; the origin is the mount plane's centre, z up.

    As a scenario's table it is the machine's frame, to which parts and slides add.
    """

    mass: float = quantity(MASS, "kg", "m", "mass without the plates, parts and slides", "assumed", gt=0)
    inertia: Inertia = quantity(
        (2000.0, 3000.0, 4000.0),
        "kg m²",
        "J",
        "inertia about the CG: moments about x, y, z, or the tensor, row by row, products as −∫xy dm; left out: "
        "the default machine's, scaled with the mass and with the squares of the sides in size",
        "assumed",
    )
    cg: Vector3 = quantity((0.0, 0.0, 0.75), "m", "r_CG", "centre of gravity from the mount plane's centre", "assumed")
    size: Vector3 = quantity(SIZE, "m", "l", "outline: length in x, width in y, height", "assumed")

    @model_validator(mode="before")
    @classmethod
    def _who_gave_it(cls, table: Any) -> Any:
        if not isinstance(table, Mapping) or "inertia" not in table:
            return table
        sources = table.get("sources", {})
        return {**table, "sources": {"inertia": "given", **sources}} if isinstance(sources, Mapping) else table

    @model_validator(mode="after")
    def _scaled(self) -> Self:
        if "inertia" not in self.model_fields_set and min(self.size) > 0:
            object.__setattr__(self, "inertia", scaled_inertia(self.mass, self.size))
        return self

    @property
    def assumptions(self) -> tuple[str, ...]:
        """What a reader must know that was assumed since nobody gave it."""
        size = " × ".join(f"{side:g}" for side in self.size)
        light = AIR * math.prod(self.size)
        slip = (
            f"machine.mass = {self.mass:g} kg is less than the air in its outline of {size} m weighs ({light:.2g} kg): "
            f"masses are in kg, {self.mass:g} t are {1000 * self.mass:g}"
        )
        found = (slip,) if self.mass < light else ()
        usual = (self.mass, self.size) == (MASS, SIZE)
        if usual or self.sources["inertia"] != "assumed" or self.inertia != scaled_inertia(self.mass, self.size):
            return found
        values = ", ".join(f"{entry:.4g}" for entry in np.diag(self.tensor))
        of = f"the default machine's, scaled to {self.mass:g} kg and {size} m"
        return (*found, f"machine.inertia was not given: [{values}] kg m² is assumed, {of}")

    @model_validator(mode="after")
    def _physical(self) -> Self:
        if min(self.size) <= 0:
            raise ValueError(f"size = {list(self.size)} must be positive in each entry")
        check_inertia("inertia", self.inertia)
        half_x, half_y = self.size[0] / 2, self.size[1] / 2
        if abs(self.cg[0]) > half_x or abs(self.cg[1]) > half_y or not 0 <= self.cg[2] <= self.size[2]:
            raise ValueError(f"cg = {list(self.cg)} lies outside the machine's outline, size = {list(self.size)}")
        return self

    @property
    def tensor(self) -> Array:
        """The tensor of inertia about the centre of gravity (3, 3) [kg m²]."""
        return tensor_of(self.inertia)

    @property
    def body(self) -> Body:
        """Its mass properties."""
        return Body.of(self.mass, self.cg, self.inertia)

    def with_bodies(self, others: Sequence[Body]) -> Self:
        """The machine with other rigid bodies on it, as one."""
        if not others:
            return self
        mass, cg, tensor = joined([self.body, *others])
        whole = {"mass": float(mass), "cg": tuple(map(float, cg)), "inertia": written_inertia(tensor)}
        return self.model_copy(update=whole)
