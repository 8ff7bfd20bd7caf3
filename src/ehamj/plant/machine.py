"""The rigid machine."""

from collections.abc import Mapping, Sequence
from typing import Any, Self

import numpy as np
from pydantic import model_validator

from ehamj.arrays import Array
from ehamj.plant.bodies import Body, Inertia, check_inertia, joined, tensor_of, written_inertia
from ehamj.settings import Parameters, Vector3, quantity


def box_inertia(mass: float, size: Vector3) -> Vector3:
    """Principal inertia of a homogeneous box about its centre [kg m²]: m/12 times the other two sides' squares."""
    a, b, c = (side**2 for side in size)
    return (mass / 12 * (b + c), mass / 12 * (a + c), mass / 12 * (a + b))


class Machine(Parameters):
    """The rigid machine: mass properties and outline; the origin is the mount plane's centre, z up.

    As a scenario's table it is the machine's frame, to which parts and slides add.
    """

    mass: float = quantity(4000.0, "kg", "m", "mass without the plates, parts and slides", "assumed", gt=0)
    inertia: Inertia = quantity(
        (2000.0, 3000.0, 4000.0),
        "kg m²",
        "J",
        "inertia about the CG: moments about x, y, z, or the tensor, row by row, products as −∫xy dm; left out of "
        "another mass or size: that of a homogeneous box",
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
        if self.sources["inertia"] != "assumed" or not np.allclose(self.tensor, np.diag(box), rtol=1e-9):
            return ()
        values = ", ".join(f"{entry:.4g}" for entry in np.diag(self.tensor))
        size = " × ".join(f"{side:g}" for side in self.size)
        of = f"that of a homogeneous box of {self.mass:g} kg, {size} m"
        return (f"machine.inertia was not given: [{values}] kg m² is assumed, {of}",)

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
