"""The stages that a study file asks for."""

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from ehamj.campaign.best import best_of
from ehamj.campaign.file import StudyFile
from ehamj.campaign.keys import unit_at
from ehamj.campaign.parameters import Space
from ehamj.campaign.rows import Column
from ehamj.campaign.stages import Again, Around, Parent, Search, Stage, Values, columns_of
from ehamj.campaign.studied import CONFIRM, NAMED, SEARCH, TOLERANCE, excess
from ehamj.errors import InputError
from ehamj.extras import check_extra
from ehamj.merits.applied import scenario_of
from ehamj.merits.merit import Machine
from ehamj.scenario.load import otherwise

if TYPE_CHECKING:
    from ehamj.campaign.store import Store


def stages_of(file: StudyFile) -> list[Stage]:
    """Named designs, search, tolerances and confirmation, those that the file has; designs have numbers in this order.

    Raises:
        InputError: if a value is none of the scenario's, the plan needs a package that is not installed, or there are
            more designs than the budget allows.
    """
    if file.plan.package:
        check_extra(file.plan.package, f"plan.kind = {file.plan.kind!r}")
    machine = file.machine
    space = file.space(machine)
    named: list[Values] = [{}, *file.values_of_named.values()]
    for name, values in file.values_of_named.items():
        _tried(machine, name, values)
    keys = _columns(machine, space, named)
    stages: list[Stage] = [
        Again(NAMED, machine, file.wanted, lambda store: [(None, values) for values in named], keys, len(named)),
        Search(SEARCH, machine, file.wanted, file.plan, space, file.goals),
    ]

    def chosen(store: "Store") -> Sequence[Parent]:
        return chosen_of(file, store)

    most = (file.best if file.objectives else 0) + max(len(file.named), 1)
    asked = tuple(dict.fromkeys((*file.objectives, *file.limits))) or file.wanted
    if (of := file.tolerances) is not None:
        within = tuple(dict.fromkeys((*file.limits, *(of.merits or asked))))  # which tell the yield
        stages.append(
            Around(
                TOLERANCE, machine, within, chosen, keys, most, of.plan,
                lambda values: Space.of(scenario_of(machine, values), of.vary, of.correlation),
            )
        )  # fmt: skip
    if file.confirm is not None:
        other = Machine(otherwise(machine.scenario, file.confirm.set, "confirm.set"), machine.law)
        stages.append(Again(CONFIRM, other, file.confirm.merits or asked, chosen, keys, most))
    _check_budget(file, stages)
    return stages


def chosen_of(file: StudyFile, store: "Store") -> list[Parent]:
    """The best designs of the search, the best first, and those with a name; without such, the scenario's own."""
    goals, searched = file.goals, store.numbers(SEARCH)
    objectives = store.merits(searched.start, searched.stop, list(file.objectives))
    kept = store.merits(searched.start, searched.stop, list(file.limits))
    misses = [excess(kept[:, k], limit) for k, limit in enumerate(file.limits.values())]
    good = np.all([miss <= 0.0 for miss in misses], axis=0) if misses else np.ones(len(objectives), bool)
    signs, own = [sign for _, sign in goals.objectives], range(1, 1 + len(file.named)) if file.named else range(1)
    named = store.merits(1, 1 + len(file.named), list(file.objectives))
    best = best_of(objectives * signs, good, file.best, named * signs)
    numbers = [*(searched.start + row for row in best), *own]
    return [(row.number, row.values) for number in numbers for row in store.rows(number, number + 1)]


def _columns(machine: Machine, space: Space, named: Sequence[Values]) -> list[Column]:
    """What designs of the plan and those with a name differ in."""
    columns = columns_of(space)
    known = {column.name for column in columns}
    others = dict.fromkeys(key for values in named for key in values if key not in known)
    return [*columns, *(Column(key, unit_at(machine.scenario, key), "value") for key in others)]


def _tried(machine: Machine, name: str, values: Values) -> None:
    """Refuse a named design that is impossible."""
    try:
        scenario_of(machine, values)
    except InputError as error:
        raise InputError(f"named.{name}: {error}") from None


def _check_budget(file: StudyFile, stages: Sequence[Stage]) -> None:
    """Refuse more designs than the budget allows, saying how many each stage makes."""
    counts = {stage.name: stage.count() for stage in stages}
    if sum(counts.values()) > file.budget.designs:
        said = ", ".join(f"{count:,} of stage {name}" for name, count in counts.items())
        raise InputError(
            f"budget.designs = {file.budget.designs}: the study makes {sum(counts.values()):,} designs ({said}); raise "
            "it, or ask for fewer"
        )
