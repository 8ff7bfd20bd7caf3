"""The results that a report shows, and what its sections ask of them more than once."""

from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

from ehamj import plots
from ehamj.criteria.curves import Norm
from ehamj.criteria.norms import NORMS
from ehamj.errors import InputError
from ehamj.evaluation import Evaluation, evaluate
from ehamj.pages.words import CRITERION_AXES
from ehamj.result import Result
from ehamj.scenario.model import Scenario
from ehamj.scenario.variants import known_variants

Results = Mapping[str, Result]
"""Results by label; the first is the one reported, the others are variants beside it."""


@dataclass(frozen=True)
class Shown:
    """What a section is made from."""

    results: Results
    evaluations: Mapping[str, Evaluation]

    @classmethod
    def of(cls, results: Results) -> "Shown":
        """Results and their evaluation.

        Raises:
            ValueError: if there is no result.
        """
        if not results:
            raise ValueError("results: a report needs at least one")
        return cls(results, evaluate(results))

    def only(self, label: str) -> "Shown":
        """One of the results by itself, with what is known of it already."""
        return Shown({label: self.results[label]}, {label: self.evaluations[label]})

    @property
    def label(self) -> str:
        """Of the result that is reported."""
        return next(iter(self.results))

    @property
    def first(self) -> Result:
        """The result that is reported."""
        return self.results[self.label]

    @property
    def scenario(self) -> Scenario:
        """That of the first result."""
        return self.first.scenario

    @cached_property
    def norms(self) -> dict[str, Norm]:
        """Those that judged the first result, by name; a user's own as the result holds it, not as its file is now.

        Raises:
            InputError: if the result does not hold limits of a file that it names.
        """
        criteria, found = self.scenario.criteria, {}
        for entry in criteria.norms:
            name = Path(entry).name
            own = self.first.summary.criteria[name].own_limits
            if own is None and entry not in NORMS:
                raise InputError(f"criteria.norms = {name!r}: the result does not hold the limits; run it again")
            found[name] = criteria.norm(entry) if own is None else own.norm()
        return found

    @property
    def alone(self) -> bool:
        """Whether there is one result only."""
        return len(self.results) == 1

    @property
    def together(self) -> bool:
        """Whether all results are of one scenario: itself and its variants, none of them twice."""
        found = [(result.scenario.name, result.scenario.control.kind) for result in self.results.values()]
        own = {self.scenario.name, *known_variants(self.scenario)}
        return len(set(found)) == len(found) and own.issuperset(name for name, _ in found)

    @cached_property
    def colors(self) -> dict[str, str]:
        """Colour of each result: the first passive one always has the same, the others follow in order."""
        found = {label: result.scenario.control.kind for label, result in self.results.items()}
        return plots.colors_of(found, next((label for label, kind in found.items() if kind == "passive"), None))

    def with_floors(self, places: Callable[[Result], Mapping[str, Any]]) -> Iterator[tuple[str, str, Any]]:
        """Name, colour and content of each floor, those that are alike once, and of each machine.

        ``places`` gives what a result has for ``floor`` and ``machine``.
        """
        floors: list[str] = []
        for label, result in self.results.items():
            found = places(result)
            floor = found.get("floor", {})
            if repr(floor) not in floors:  # two NaN are alike
                floors.append(repr(floor))
                yield "floor" if len(floors) == 1 else f"floor of {label}", plots.FLOOR_COLOR, floor
            yield label, self.colors[label], found.get("machine", {})

    @property
    def judged_axes(self) -> tuple[str, ...]:
        """Axes whose numbers stand in tables: the vertical, and all where any machine is actuated in six motions."""
        told = {motion for result in self.results.values() for motion in result.summary.attenuation_first()}
        return tuple(axis for axis in CRITERION_AXES if axis in told)


def ground_parts(scenario: Scenario) -> tuple[Any, ...]:
    """The grounds that a scenario's ground is the sum of."""
    return getattr(scenario.ground, "parts", None) or (scenario.ground,)


def floor_moves(result: Result) -> bool:
    """Whether the ground moves anywhere."""
    peak = result.summary.peak.get("ground_velocity", {})  # nothing peaks where nothing was recorded
    return any(value for axes in peak.values() for value in axes.values())


def known(tables: Iterable[Mapping[str, float | None]]) -> list[float]:
    """All values of several tables that are one."""
    return [value for table in tables for value in table.values() if value is not None]
