"""All parameters of a study together: from points of the unit cube to the values of designs."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from ehamj.arrays import Array
from ehamj.campaign.correlations import Correlation, factor_of, together
from ehamj.campaign.parameter import Parameter, parameters_of
from ehamj.campaign.spread import SpreadSettings
from ehamj.errors import InputError
from ehamj.scenario.model import Scenario


@dataclass(frozen=True)
class Space:
    """The parameters of a study, and how they go together: ``factor`` L of the correlations R = L Lᵀ of their normal
    scores (parameter, parameter), None where they are independent."""

    parameters: tuple[Parameter, ...]
    factor: Array | None = None

    @classmethod
    def of(
        cls, scenario: Scenario, vary: Mapping[str, SpreadSettings], correlations: Sequence[Correlation] = ()
    ) -> "Space":
        """Parameters of a scenario.

        Args:
            scenario: what designs differ from.
            vary: spreads by key as ``--set`` has them, or ``footprint.x``, ``footprint.y``.
            correlations: which of them go together.

        Raises:
            InputError: if a key is none of the scenario's, or its values are impossible there, or correlations
                contradict each other.
        """
        if not vary:
            raise InputError("vary: is empty; must have at least one parameter, such as machine.mass")
        found = [one for key, spread in vary.items() for one in parameters_of(scenario, key, spread)]
        keys = [one.key for one in found]
        for k, key in enumerate(keys):
            for other in keys[:k] + keys[k + 1 :]:
                if f"{key}.".startswith(f"{other}."):
                    raise InputError(f"vary: {other} and {key} state one value twice; leave out either")
        return cls(tuple(found), factor_of(found, correlations))

    @property
    def keys(self) -> tuple[str, ...]:
        """Keys of all parameters, in order."""
        return tuple(one.key for one in self.parameters)

    @property
    def units(self) -> tuple[str, ...]:
        """Their units."""
        return tuple(one.unit for one in self.parameters)

    @cached_property
    def nominal(self) -> dict[str, Any]:
        """The scenario's own values; a key that it leaves out is left out."""
        return {one.key: one.own for one in self.parameters if one.own is not None}

    @property
    def correlated(self) -> bool:
        """Whether any parameters go together."""
        return self.factor is not None

    def values(self, points: Array) -> list[dict[str, Any]]:
        """Values of designs by key.

        Args:
            points: (design, parameter) of [0, 1]; NaN stands for the scenario's own value. Correlated ones are taken
                as independent draws.
        """
        points = np.asarray(points, float)
        if self.factor is not None:
            points = together(points, self.factor)
        columns = [one.values(points[:, k]) for k, one in enumerate(self.parameters)]
        rows = (zip(self.keys, row, strict=True) for row in zip(*columns, strict=True))
        return [{key: value for key, value in row if value is not None} for row in rows]
