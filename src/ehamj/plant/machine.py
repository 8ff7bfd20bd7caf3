"""The rigid machine."""

from typing import Self

from pydantic import model_validator

from ehamj.settings import Parameters, Vector3, quantity


class Machine(Parameters):
    """The rigid machine: mass properties and outline; the origin is the mount plane's centre, z up."""

    mass: float = quantity(4000.0, "kg", "m", "mass without the plates", "assumed", gt=0)
    inertia: Vector3 = quantity(
        (2000.0, 3000.0, 4000.0), "kg m²", "J", "principal inertia about the CG, x, y, z", "assumed"
    )
    cg: Vector3 = quantity((0.0, 0.0, 0.75), "m", "r_CG", "centre of gravity from the mount plane's centre", "assumed")
    size: Vector3 = quantity((2.2, 1.6, 1.9), "m", "l", "outline: length in x, width in y, height", "assumed")

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
