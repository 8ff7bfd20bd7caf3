"""A search for the best designs, generation by generation (pymoo).

pymoo and not Optuna: it asks for a whole generation and is told of it at once, so that a search is the same however its
designs are split among workers; constraints are part of every algorithm, and no penalty that the user has to weigh; and
NSGA-II and NSGA-III are its own. Optuna's strength, one trial after the other as workers come free, would cost that.
Differential evolution and not CMA-ES, which has no constraints there.
"""

from functools import partial
from math import comb
from typing import TYPE_CHECKING, Any, ClassVar, Final, Literal

import numpy as np
from pydantic import Field

from ehamj.arrays import Array
from ehamj.campaign.best import ENDLESS
from ehamj.campaign.correlations import check_independent
from ehamj.campaign.plans.coding import Coding
from ehamj.campaign.plans.plan import Batches, Goals, Plan, Told
from ehamj.errors import InputError

if TYPE_CHECKING:
    from ehamj.campaign.parameters import Space

FAILED: Final = 1e30
"""Violation of a design that failed: worse than any other, and still a number that can be compared."""
CROWDED: Final = 3
"""Objectives up to which the crowding of NSGA-II tells designs of a front apart."""


class Optimise(Plan):
    """A search for the best designs: for one objective by differential evolution, or a genetic algorithm where a
    parameter is a list or an integer; for two or three by NSGA-II, for more by NSGA-III."""

    kind: Literal["optimise"]
    package: ClassVar[str] = "pymoo"
    population: int = Field(64, ge=8, le=100_000, description="designs of a generation")
    generations: int = Field(50, ge=1, le=100_000, description="generations, the first, random one among them")
    seed: int = Field(0, ge=0, description="seed of all draws")

    def count(self, space: "Space") -> int:
        """At most: a small space may leave a generation fewer designs that differ."""
        return self.population * self.generations

    def batches(self, space: "Space", goals: Goals) -> Batches:
        """Generation by generation."""
        check_independent(space, self.kind)
        coding = Coding(space.parameters)
        search = self._search(coding, goals)
        for _ in range(self.generations):
            asked = search.ask()
            if asked is None or not len(asked):
                return
            told = yield coding.points(asked.get("X"))
            objectives, violations = as_numbers(told, goals)
            asked.set("F", objectives, "G", violations)
            search.tell(infills=asked)

    def _search(self, coding: Coding, goals: Goals) -> Any:
        """The algorithm, seeded and set up.

        Raises:
            InputError: if there is nothing to look for, or the population is too small for so many objectives.
        """
        from pymoo.config import Config
        from pymoo.core.termination import NoTermination

        objectives = len(goals.objectives)
        if not objectives:
            raise InputError("plan.kind = 'optimise': needs [objectives], merits that are to be 'highest' or 'lowest'")
        if objectives > self.population:
            raise InputError(f"plan.population = {self.population}: must be at least the {objectives} objectives")
        Config.warnings["not_compiled"] = False  # which it would print
        search = self._algorithm(objectives, coding)(pop_size=self.population, **coding.operators(objectives))
        search.setup(
            coding.problem(objectives, len(goals.constraints) + 1), termination=NoTermination(), seed=self.seed
        )
        return search

    def _algorithm(self, objectives: int, coding: Coding) -> Any:
        from pymoo.algorithms.moo.nsga2 import NSGA2
        from pymoo.algorithms.moo.nsga3 import NSGA3
        from pymoo.algorithms.soo.nonconvex.de import DE
        from pymoo.algorithms.soo.nonconvex.ga import GA

        if objectives == 1:
            return GA if coding.mixed else DE
        return NSGA2 if objectives <= CROWDED else partial(NSGA3, directions(objectives, self.population))


def directions(objectives: int, most: int) -> Array:
    """Directions from the best of all objectives into their space, as many as even steps give within ``most`` (Das and
    Dennis), (direction, objective)."""
    from pymoo.util.ref_dirs import get_reference_directions

    steps = 1
    while comb(steps + objectives, objectives - 1) <= most:
        steps += 1
    return np.asarray(get_reference_directions("das-dennis", objectives, n_partitions=steps))


def as_numbers(told: Told, goals: Goals) -> tuple[Array, Array]:
    """Objectives, and violations with one more column: of designs that failed, whose objectives are 0.

    Each violation counts in shares of its bound, as they are added up.
    """
    objectives, violations = np.clip(told.objectives, -ENDLESS, ENDLESS), np.array(told.violations, float)
    failed = np.isnan(objectives).any(axis=1) | np.isnan(violations).any(axis=1)
    for k, (_, low, high) in enumerate(goals.constraints):
        violations[:, k] /= max(abs(low or 0.0), abs(high or 0.0)) or 1.0
    objectives[failed], violations[failed] = 0.0, 0.0
    violations = np.clip(violations, 0.0, FAILED / 1e3)
    return objectives, np.column_stack([violations, np.where(failed, FAILED, 0.0)])
