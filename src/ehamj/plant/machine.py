"""The rigid machine."""

from collections.abc import Mapping
from typing import Any, Self

import numpy as np
from pydantic import model_validator

from ehamj.settings import Parameters, Vector3, quantity


def box_inertia(mass: float, size: Vector3) -> Vector3:
    """Principal inertia of a homogeneous box about its centre [kg m²]: m/12 times the other two sides' squares."""
    a, b, c = (side**2 for side in size)
    return (mass / 12 * (b + c), mass / 12 * (a + c), mass / 12 * (a + b))


class Machine(Parameters):
    """The rigid machine: mass properties and outline; the origin is the mount plane's centre, z up."""

    mass: float = quantity(4000.0, "kg", "m", "mass without the plates", "assumed", gt=0)
    inertia: Vector3 = quantity(
        (2000.0, 3000.0, 4000.0),
        "kg m²",
        "J",
        "principal inertia about the CG, x, y, z; left out of another mass or size: that of a homogeneous box",
        "assumed",
    )
    cg: Vector3 = quantity((0.0, 0.0, 0.75), "m", "r_CG", "centre of gravity from the mount plane's centre", "assumed")
    size: Vector3 = quantity((2.2, 1.6, 1.9), "m", "l", "outline: length in x, width in y, height", "assumed")

    @model_validator(mode="before")
    @classmethod
    def _who_gave_it(cls, table: Any) -> Any:
        if not isinstance(table, Mapping) or "inertia" not in table:
            return table
        sources = table.get("sources", {})
        return {**table, "sources": {"inertia": "given", **sources}} if isinstance(sources, Mapping) else table

    @model_validator(mode="after")
    def _as_a_box(self) -> Self:
        whole = all(getattr(self, name) == type(self).model_fields[name].default for name in ("mass", "size"))
        if "inertia" not in self.model_fields_set and not whole and min(self.size) > 0:
            object.__setattr__(self, "inertia", box_inertia(self.mass, self.size))
        return self

    @property
    def assumptions(self) -> tuple[str, ...]:
        """What a reader must know that was assumed since nobody gave it."""
        box = box_inertia(self.mass, self.size)
        if self.sources["inertia"] != "assumed" or not np.allclose(self.inertia, box, rtol=1e-9):
            return ()
        values = ", ".join(f"{entry:.4g}" for entry in self.inertia)
        size = " × ".join(f"{side:g}" for side in self.size)
        of = f"that of a homogeneous box of {self.mass:g} kg, {size} m"
        return (f"machine.inertia was not given: [{values}] kg m² is assumed, {of}",)

    @model_validator(mode="after")
    def _physical(self) -> Self:
        for name in ("inertia", "size"):
            if min(getattr(self, name)) <= 0:
                raise ValueError(f"{name} = {list(getattr(self, name))} must be positive in each entry")
        a, b, c = self.inertia
        if a + b < c or b + c < a or c + a < b:  # as the engine has it, to the last bit
            raise ValueError(
                f"inertia = {[a, b, c]} is of no rigid body: each entry is at most the sum of the other two"
            )
        half_x, half_y = self.size[0] / 2, self.size[1] / 2
        if abs(self.cg[0]) > half_x or abs(self.cg[1]) > half_y or not 0 <= self.cg[2] <= self.size[2]:
            raise ValueError(f"cg = {list(self.cg)} lies outside the machine's outline, size = {list(self.size)}")
        return self
