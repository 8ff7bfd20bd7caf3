"""How many of the machines within tolerances keep their limits, and how sure that is."""

from dataclasses import dataclass
from typing import Final

import numpy as np

from ehamj.campaign.studied import TOLERANCE, DataFrame, Studied, meets

CONFIDENCE: Final = 0.95


@dataclass(frozen=True)
class Yield:
    """Of ``number`` machines, how many keep a limit or, where ``limit`` is "", all of them; one that failed keeps
    none. ``low`` and ``high`` bound the share with 95 % confidence (Clopper and Pearson)."""

    whose: str
    """Of the design that they are variations of: "design 12", a name, or "" where they are those of the study."""
    limit: str
    kept: int
    number: int
    low: float
    high: float

    @property
    def share(self) -> float:
        """Share that keeps it [-]."""
        return self.kept / self.number

    @property
    def said(self) -> str:
        """The share with its interval, in words."""
        return f"{100 * self.share:.1f} % ({100 * self.low:.1f} to {100 * self.high:.1f} %)"


def groups(studied: Studied) -> dict[str, DataFrame]:
    """Machines within tolerances, by whose variations they are; without such, those of a plan that draws its own."""
    parents = {f"design {number}": number for number in studied.search["number"].iloc[studied.best]}
    parents |= {name: int(row["number"]) for name, row in studied.named.items()}
    found = {whose: studied.children(number, TOLERANCE) for whose, number in parents.items()}
    found = {whose: machines for whose, machines in found.items() if len(machines)}
    if not found and studied.file.plan.drawn and not studied.file.objectives and len(studied.search):
        found = {"": studied.search}
    return found


def yields_of(studied: Studied) -> list[Yield]:
    """The yield of each group over all limits, and over each where there are several; none without limits."""
    found = []
    for whose, machines in groups(studied).items():
        done = np.asarray(machines["status"] == "done")
        each = {name: done & meets(machines[name], limit) for name, limit in studied.file.limits.items()}
        if each:
            found.append(_yield(whose, "", np.logical_and.reduce(list(each.values()))))
        if len(each) > 1:
            found += [_yield(whose, name, kept) for name, kept in each.items()]
    return found


def _yield(whose: str, limit: str, kept: "np.typing.NDArray[np.bool_]") -> Yield:
    from scipy.stats import binomtest

    count, number = int(kept.sum()), len(kept)
    interval = binomtest(count, number).proportion_ci(CONFIDENCE, "exact")
    return Yield(whose, limit, count, number, float(interval.low), float(interval.high))
