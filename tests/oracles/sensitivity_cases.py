"""Functions of the unit cube whose sensitivities and fronts are known in closed form, and spaces to put them in."""

import numpy as np
from numpy.typing import NDArray

from ehamj.campaign.parameter import Parameter
from ehamj.campaign.parameters import Space
from ehamj.campaign.spread import SpreadSettings
from ehamj.campaign.spreads import Between

Array = NDArray[np.float64]
EVEN = Between(low=0.0, high=1.0)


def cube(count: int, *more: tuple[SpreadSettings, object]) -> Space:
    """So many parameters from 0 to 1 named x0, x1, …, and others by spread and own value."""
    kinds = [(EVEN, 0.5)] * count + list(more)
    return Space(tuple(Parameter(f"x{k}", f"x{k}", "1", spread, own) for k, (spread, own) in enumerate(kinds)))


def ishigami(points: Array, a: float = 7.0, b: float = 0.1) -> Array:
    """sin x₁ + a sin² x₂ + b x₃⁴ sin x₁ with x from −π to π (Ishigami and Homma, 1990)."""
    x = np.pi * (2.0 * points - 1.0)
    return np.asarray(np.sin(x[:, 0]) + a * np.sin(x[:, 1]) ** 2 + b * x[:, 2] ** 4 * np.sin(x[:, 0]))


def ishigami_indices(a: float = 7.0, b: float = 0.1) -> tuple[Array, Array, Array]:
    """First, total, and second order (above the diagonal)."""
    first = np.array([0.5 * (1.0 + b * np.pi**4 / 5.0) ** 2, a**2 / 8.0, 0.0])
    both = b**2 * np.pi**8 * (1.0 / 18.0 - 1.0 / 50.0)
    variance = first.sum() + both
    second = np.zeros((3, 3))
    second[0, 2] = both
    return first / variance, (first + np.array([both, 0.0, both])) / variance, second / variance


def g_function(points: Array, a: Array) -> Array:
    """Π (|4 x − 2| + a)/(1 + a) (Sobol, 1993)."""
    return np.asarray(((np.abs(4.0 * points - 2.0) + a) / (1.0 + a)).prod(axis=1))


def g_indices(a: Array) -> tuple[Array, Array]:
    """First and total order."""
    own = 1.0 / (3.0 * (1.0 + a) ** 2)
    whole = np.prod(1.0 + own) - 1.0
    return own / whole, own * np.array([np.prod(np.delete(1.0 + own, k)) for k in range(len(a))]) / whole


def zdt1(points: Array) -> Array:
    """Two objectives (Zitzler, Deb and Thiele, 2000); on the front f₂ = 1 − √f₁, where all but the first are 0."""
    g = 1.0 + 9.0 * points[:, 1:].mean(axis=1)
    return np.column_stack([points[:, 0], g * (1.0 - np.sqrt(points[:, 0] / g))])


def hypervolume(objectives: Array, corner: tuple[float, float]) -> float:
    """Area that two objectives leave behind them before a corner."""
    volume, best = 0.0, corner[1]
    for one, other in sorted(map(tuple, objectives)):
        if one < corner[0] and other < best:
            volume += (corner[0] - one) * (best - other)
            best = other
    return volume
