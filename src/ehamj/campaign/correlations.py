"""Parameters that go together: a Gaussian copula, whatever the parameters' own distributions are."""

from collections.abc import Sequence
from typing import TYPE_CHECKING, Final, Self

import numpy as np
from pydantic import Field, model_validator

from ehamj.arrays import Array
from ehamj.campaign.parameter import Parameter
from ehamj.errors import InputError, did_you_mean
from ehamj.settings import Settings

if TYPE_CHECKING:
    from ehamj.campaign.parameters import Space

LEAST_EIGENVALUE: Final = 1e-9
"""Of a correlation matrix: below it, one parameter would follow from the others."""


class Correlation(Settings):
    """Two parameters that go together. A key of which each isolator has a value of its own goes, with another such key,
    isolator by isolator; with itself, among the isolators."""

    between: tuple[str, str] = Field(description="keys of the two parameters")
    coefficient: float = Field(
        gt=-1, lt=1, description="correlation of their normal scores (Gaussian copula): of normal values their own [-]"
    )

    @model_validator(mode="after")
    def _any(self) -> Self:
        if self.coefficient == 0.0:
            raise ValueError("coefficient = 0.0: must not be 0; parameters that nothing is said of are independent")
        return self


def check_independent(space: "Space", plan: str) -> None:
    """Refuse correlated parameters for a plan that cannot have any.

    Raises:
        InputError: saying which plans can.
    """
    if space.correlated:
        raise InputError(
            f"plan.kind = {plan!r}: parameters must be independent here, and [[correlation]] says that some are not; "
            "leave it out, or take plan.kind = 'monte-carlo' ('latin-hypercube', 'sobol-sequence'), whose rank "
            "correlations and regression need no independence"
        )


def together(points: Array, factor: Array) -> Array:
    """Points whose normal scores are correlated: Φ(L Φ⁻¹(u)).

    Summed parameter by parameter: a product of matrices may round a design's row by how many stand beside it.
    """
    from scipy.special import ndtr, ndtri

    tiny = np.finfo(float).eps / 4
    scores = ndtri(np.clip(points, tiny, 1.0 - 2 * tiny))
    found = np.zeros_like(scores)
    for k, column in enumerate(factor.T):
        found += scores[:, k, None] * column
    return np.asarray(ndtr(found))


def factor_of(parameters: Sequence[Parameter], correlations: Sequence[Correlation]) -> Array | None:
    if not correlations:
        return None
    matrix, known = np.eye(len(parameters)), [one.stated for one in parameters]
    for number, one in enumerate(correlations):
        said = f"correlation.{number}.between = {list(one.between)}"
        for key in one.between:
            if key not in known:
                stated = tuple(dict.fromkeys(known))
                near = did_you_mean(key, stated)
                raise InputError(f"{said}: {key!r} does not vary; {near}must be one of {', '.join(stated)}")
        pairs = _pairs(parameters, *one.between)
        if not pairs:
            raise InputError(f"{said}: a parameter goes with itself; must be two, or one with each = true")
        for i, j in pairs:
            if parameters[i].unordered or parameters[j].unordered:
                key = parameters[i if parameters[i].unordered else j].key
                raise InputError(f"{said}: values of {key} have no order; must be numbers that rise")
            if matrix[i, j]:
                raise InputError(f"{said}: is said twice; leave out either")
            matrix[i, j] = matrix[j, i] = one.coefficient
    least = float(np.linalg.eigvalsh(matrix)[0])
    if least < LEAST_EIGENVALUE:
        most = int(1000.0 * (1.0 - LEAST_EIGENVALUE) / (1.0 - least)) / 1000.0
        raise InputError(
            f"correlation: the coefficients contradict each other (their matrix has the eigenvalue {least:.3g}, must "
            f"be above 0); {most - 0.001:.3f} times all of them would do"
        )
    return np.asarray(np.linalg.cholesky(matrix))


def _pairs(parameters: Sequence[Parameter], one: str, other: str) -> list[tuple[int, int]]:
    """Which parameters two stated keys mean."""
    first, second = ([k for k, p in enumerate(parameters) if p.stated == key] for key in (one, other))
    if one == other:
        return [(i, j) for i in first for j in first if i < j]
    own = [_mount(parameters[k].key) for k in (*first, *second)]
    both = all(parameters[k].spread.each for k in (first[0], second[0])) and len(set(own)) < len(own)
    return [(i, j) for i in first for j in second if not both or _mount(parameters[i].key) == _mount(parameters[j].key)]


def _mount(key: str) -> str:
    return key.split(".")[1] if key.startswith("mount.") else ""
