"""One parameter of a study: its values at points between 0 and 1, tried on the scenario."""

from dataclasses import dataclass
from typing import Any, Final

import numpy as np

from ehamj.arrays import Array
from ehamj.campaign.keys import check_known, own_value, unit_at
from ehamj.campaign.spread import SpreadSettings
from ehamj.campaign.spreads import Listed
from ehamj.designs.parameters import changes_of
from ehamj.errors import InputError
from ehamj.scenario.load import changed
from ehamj.scenario.model import Scenario

TRIED: Final = 40
"""Values of a list that are tried on the scenario before a study begins."""


@dataclass(frozen=True)
class Parameter:
    """One parameter: its ``key``, the key as ``stated`` (another one where each isolator has its own), its ``unit``,
    its ``spread``, and the scenario's ``own`` value, None where it is left out."""

    key: str
    stated: str
    unit: str
    spread: SpreadSettings
    own: Any

    @property
    def whole(self) -> bool:
        """Whether it is an integer."""
        return isinstance(self.own, int) and not isinstance(self.own, bool)

    @property
    def cells(self) -> int | None:
        """How many values it has; None where they are too many to count."""
        return self.spread.cells(self.own)

    @property
    def unordered(self) -> bool:
        """Whether its values are no numbers, or in no order."""
        return isinstance(self.spread, Listed) and not self.spread.ordered

    def values(self, points: Array) -> list[Any]:
        """Values at points (design,) of [0, 1], as TOML has them; the scenario's own where a point is NaN."""
        spread, own = self.spread, np.isnan(points)
        inner = np.where(own, 0.5, points)
        if isinstance(spread, Listed):
            found = [spread.values[int(number)] for number in spread.quantiles(inner, self.own)]
        elif self.whole:
            found = [int(value) for value in spread.whole(inner, self.own)]
        else:
            found = spread.quantiles(inner, self.own).tolist()
        return [self.own if is_own else value for is_own, value in zip(own, found, strict=True)]

    def levels(self, number: int) -> Array:
        """Points of so many values from end to end, or of all values where there are fewer, or a list has them."""
        cells, (low, high) = self.cells, self.spread.edges()
        if cells is None:
            return np.linspace(low, high, number)
        taken = np.arange(cells) if isinstance(self.spread, Listed) else np.linspace(0, cells - 1, min(number, cells))
        return (np.rint(taken) + 0.5) / cells


def parameters_of(scenario: Scenario, key: str, spread: SpreadSettings) -> list[Parameter]:
    """What a stated key means, each value tried on the scenario."""
    own = own_value(scenario, key)
    try:
        spread.check(own)
    except ValueError as error:
        if own is None:  # has no value to spread about either
            check_known(scenario, key)
        raise InputError(f"vary: {key}: {error}") from None
    numbers = not (isinstance(spread, Listed) and not spread.numbers)
    stated = Parameter(key, key, unit_at(scenario, key) if numbers else "1", spread, own)
    _try(scenario, stated)
    if not spread.each:
        return [stated]
    parts = key.split(".")
    mounts = [m for m in scenario.mount if parts[:1] == ["actuators"] and len(parts) == 3 and m.actuator == parts[1]]
    if not mounts:
        raise InputError(
            f"vary: {key}: each = true is for values of isolators that mounts have: must be "
            f"actuators.({', '.join(dict.fromkeys(m.actuator for m in scenario.mount))}).QUANTITY"
        )
    return [Parameter(f"mount.{m.name}.actuator.{parts[2]}", key, stated.unit, spread, own) for m in mounts]


def _try(scenario: Scenario, one: Parameter) -> None:
    """Refuse a key that is none and values that it never has; those that fail beside other values, designs tell."""
    points = one.levels(3)
    points = points[np.unique(np.linspace(0, len(points) - 1, min(len(points), TRIED)).astype(int))]
    failed: list[str] = []
    for value in one.values(points):
        try:
            changed(scenario, changes_of(scenario, {one.key: value}))
        except InputError as error:
            failed.append(str(error))
            if isinstance(value, str) or failed[-1].startswith(f"{one.key} = "):
                break
    if failed and (len(failed) == len(points) or isinstance(value, str) or failed[-1].startswith(f"{one.key} = ")):
        raise InputError(f"vary: {failed[-1]}")
