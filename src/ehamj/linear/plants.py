"""Linear plants as python-control has them, with states that survive its tools. Imports python-control."""

from typing import Any, Self

import control
import numpy as np

from ehamj.arrays import Array, ComplexArray
from ehamj.linear.refined import refined_response


class Accurate(control.StateSpace):
    """A ``control.StateSpace`` whose responses hold to all digits in every channel (`ehamj.linear.refined`).

    python-control's own go through a Hessenberg form, which errs relative to a system's largest channels. Picked
    channels, multiples, series and feedback of an accurate system are accurate too.
    """

    def horner(self, x: Any, warn_infinite: bool = True) -> ComplexArray:
        """Response at s or z, (outputs, inputs, points); inf + nan j at a pole that a channel shows."""
        found = refined_response(np.atleast_1d(x), self.A, self.B, self.C, self.D)
        return np.asarray(found.transpose(1, 2, 0))

    def __getitem__(self, key: Any) -> Any:
        found = super().__getitem__(key)
        names = {"states": self.state_labels, "inputs": found.input_labels, "outputs": found.output_labels}
        return type(self)(found, name=found.name, **names)

    def __mul__(self, other: Any) -> Any:
        return _accurate(super().__mul__(other))

    def __rmul__(self, other: Any) -> Any:
        both = isinstance(other, control.StateSpace)
        return _accurate(control.StateSpace.__mul__(other, self) if both else super().__rmul__(other))

    def __neg__(self) -> Any:
        return _accurate(super().__neg__())

    def feedback(self, other: Any = 1, sign: int = -1) -> Any:
        """The loop that it makes with another system, as ``control.StateSpace.feedback``."""
        return _accurate(super().feedback(other, sign))


def _accurate(found: Any) -> Any:
    return Accurate(found) if isinstance(found, control.StateSpace) else found


class LinearPlant(Accurate):
    """A plant whose states are deviations from ``operating_point``, each over its ``scales``.

    What states, inputs and outputs are called, and the units of inputs and outputs (SI, commands in V, spools in mA),
    do not change. A state in SI is ``operating_point + scales·x``, in ``state_units``; the matrices in SI are
    ``scales[:, None]·A/scales``, ``scales[:, None]·B`` and ``C/scales``, to the last digit, since scales are powers of
    two (`ehamj.linear.scales`). A state feedback K of this plant is ``K/scales`` of states in SI, and a weight Q of
    those is ``Q * scales[:, None] * scales`` here. Picked channels keep their scales; what else python-control makes of
    the plant (`c2d`, `feedback`, `append`, …) has these states, and does not know of them.
    """

    scales: Array
    """Size of each state's unit, (state,)."""
    state_units: tuple[str, ...]
    """Units of the operating point and of scaled-back states; '' for an instrument's own."""
    operating_point: Array
    """State of rest that the states deviate from, (state,)."""

    @classmethod
    def scaled(
        cls, matrices: tuple[Array, Array, Array, Array], scales: Array, operating_point: Array,
        state_units: tuple[str, ...], *timebase: float, **names: Any,
    ) -> Self:  # fmt: skip
        """A plant of matrices in SI; ``names`` as of ``control.ss``, ``timebase`` its period of samples [s], if any."""
        A, B, C, D = matrices
        plant = cls(A * scales / scales[:, None], B / scales[:, None], C * scales, D, *timebase, **names)
        plant.scales, plant.operating_point, plant.state_units = scales, operating_point, state_units
        return plant

    def __getitem__(self, key: Any) -> Any:
        picked = super().__getitem__(key)
        picked.scales, picked.operating_point, picked.state_units = self.scales, self.operating_point, self.state_units
        return picked
