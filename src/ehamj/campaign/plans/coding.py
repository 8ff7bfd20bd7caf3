"""What a search changes: numbers between 0 and 1, and entries of lists and integers by number."""

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from ehamj.arrays import Array

if TYPE_CHECKING:
    from ehamj.campaign.parameter import Parameter


ATTEMPTS: Final = 20
"""Times that a generation is mated until enough of it are new; with none, the search has come to its end."""


class Coding:
    """Parameters as pymoo has them: a vector of the unit cube, or a table of mixed variables where some have so few
    values that they are counted: integers with an order, and lists of what has none."""

    def __init__(self, parameters: "Sequence[Parameter]") -> None:
        self.parameters = tuple(parameters)
        self.mixed = any(one.cells is not None for one in self.parameters)
        self._asked: set[frozenset[Any]] = set()

    def problem(self, objectives: int, constraints: int) -> Any:
        """What is searched, without anything that could evaluate it."""
        from pymoo.core.problem import Problem
        from pymoo.core.variable import Choice, Integer, Real

        sizes = {"n_obj": objectives, "n_ieq_constr": constraints}
        if not self.mixed:
            return Problem(n_var=len(self.parameters), xl=0.0, xu=1.0, **sizes)
        variables: dict[str, Any] = {}
        for one in self.parameters:
            if one.cells is None:
                variables[one.key] = Real(bounds=(0.0, 1.0))
            elif one.unordered:
                variables[one.key] = Choice(options=list(range(one.cells)))
            else:
                variables[one.key] = Integer(bounds=(0, one.cells - 1))
        return Problem(vars=variables, **sizes)

    def operators(self, objectives: int) -> dict[str, Any]:
        """How designs are drawn, mated and told apart where variables are mixed; else as the algorithm has it."""
        if not self.mixed:
            return {}
        from pymoo.algorithms.moo.nsga2 import binary_tournament
        from pymoo.algorithms.moo.nsga3 import comp_by_cv_then_random
        from pymoo.algorithms.soo.nonconvex.ga import comp_by_cv_and_fitness
        from pymoo.core.mixed import MixedVariableMating, MixedVariableSampling
        from pymoo.operators.selection.tournament import TournamentSelection

        compare = {1: comp_by_cv_and_fitness, 2: binary_tournament, 3: binary_tournament}
        chosen = TournamentSelection(func_comp=compare.get(objectives, comp_by_cv_then_random))
        apart = _never_twice(self._asked)
        return {
            "sampling": MixedVariableSampling(),
            "mating": MixedVariableMating(selection=chosen, eliminate_duplicates=apart, n_max_iterations=ATTEMPTS),
            "eliminate_duplicates": apart,
        }

    def points(self, asked: Sequence[Any]) -> Array:
        """Points (design, parameter) of the unit cube of what pymoo asks for; of an entry the middle of its cell."""
        if not self.mixed:
            return np.array([np.asarray(one, float) for one in asked])
        self._asked.update(frozenset(one.items()) for one in asked)
        cells = {one.key: one.cells for one in self.parameters}
        return np.array([[_point(one[key], number) for key, number in cells.items()] for one in asked])


def _never_twice(asked: set[frozenset[Any]]) -> Any:
    """Refuses designs that were asked for before: where there are few values, a search would come back to them, and
    have them computed again."""
    from pymoo.core.duplicate import DuplicateElimination

    class NeverTwice(DuplicateElimination):
        def do(self, pop: Any, *others: Any, **how: Any) -> Any:
            seen, new = {frozenset(one.X.items()) for other in others for one in other}, []
            for k, one in enumerate(pop):
                design = frozenset(one.X.items())
                if design not in asked and design not in seen:
                    seen.add(design)
                    new.append(k)
            return pop[new]

    return NeverTwice()


def _point(value: Any, cells: int | None) -> float:
    return float(value) if cells is None else (round(value) + 0.5) / cells
