"""Poles and shapes from signals: of free decays, and of frequency responses. Textbook methods, and nothing of machines.

Free decays: eigensystem realisation (Juang and Pappa, J. Guidance 8, 1985). Frequency responses: polyreference
least-squares complex frequency domain (Guillaume et al., ISMA 2002; Peeters et al., Shock and Vibration 11, 2004), then
residues by linear least squares. What stays as the model order grows is a mode; its spread over orders and records says
how sure it is.
"""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import ArrayLike

from ehamj.arrays import Array, ComplexArray

SAME_FREQUENCY: Final = 0.01
"""Relative distance of two estimates of |λ| that may belong to one mode."""
SAME_DAMPING: Final = 0.02
"""Distance of their damping ratios."""
SAME_SHAPE: Final = 0.8
"""Least MAC of their shapes."""
MOST_ROWS: Final = 120
"""Samples by which the decays are shifted against themselves at most."""


@dataclass(frozen=True)
class Estimates:
    """Oscillations found by one fit: ``poles`` λ (k,) [1/s] with Im λ > 0, and their ``shapes`` (channel, k)."""

    poles: ComplexArray
    shapes: ComplexArray


@dataclass(frozen=True)
class Stable:
    """A mode that several fits agree on."""

    pole: complex
    """Mean of λ [1/s]."""
    shape: ComplexArray
    """Of the fit nearest to the mean, (channel,)."""
    frequency_spread: float
    """Standard deviation of |λ|/2π over the fits [Hz]."""
    damping_spread: float
    """Standard deviation of the damping ratio."""
    count: int
    """Fits that have it."""


def realise(decays: ArrayLike, rate: float, orders: Sequence[int]) -> list[tuple[ComplexArray, ComplexArray]]:
    """Eigensystem realisation of free decays of one system, to several orders.

    Args:
        decays: signals (n, channels) of one decay, or (decay, n, channels) of several, scaled to about one.
        rate: sampling rate [Hz].
        orders: numbers of eigenvalues looked for.

    Returns:
        For each order continuous eigenvalues λ [1/s] by magnitude, (order,), and the shapes in the channels, (channels,
        order), as large as the mode is at the beginning of the decay that has most of it.
    """
    array = np.asarray(decays, float)
    array = array[None] if array.ndim == 2 else array
    _, n, channels = array.shape
    rows = min(n // 2, MOST_ROWS)
    columns = n - rows
    blocks = [array[:, k : k + columns].transpose(2, 0, 1).reshape(channels, -1) for k in range(rows)]
    hankel = np.concatenate(blocks, axis=0)
    left, singular, right = np.linalg.svd(hankel, full_matrices=False)
    found = []
    for order in orders:
        root = np.sqrt(singular[:order])
        observed = left[:, :order] * root
        shift = np.linalg.lstsq(observed[:-channels], observed[channels:], rcond=None)[0]
        discrete, vectors = np.linalg.eig(shift)
        values = np.log(discrete.astype(complex)) * rate
        begins = np.linalg.solve(vectors, root[:, None] * right[:order, ::columns])  # modal coordinates, per decay
        shapes = observed[:channels] @ vectors * np.abs(begins).max(axis=1)
        by_size = np.argsort(np.abs(values))
        found.append((values[by_size], shapes[:, by_size]))
    return found


def oscillating(poles: ComplexArray, shapes: ComplexArray, least: float = 0.0) -> Estimates:
    """Those of a fit that swing and decay: Im λ > ``least`` [rad/s], Re λ < 0."""
    kept = (poles.imag > max(least, 0.0)) & (poles.real < 0.0)
    return Estimates(poles[kept], shapes[:, kept])


def polyreference(hertz: Array, response: ComplexArray, order: int) -> ComplexArray:
    """Poles of frequency responses by pLSCF: H(ω) = B(z) A(z)⁻¹ with z = exp(jωT), T half the period of the last line.

    Args:
        hertz: lines [Hz], rising, (f,).
        response: (f, outputs, inputs).
        order: of the polynomials; there are order × inputs poles.

    Returns:
        λ [1/s], (order · inputs,).
    """
    return polyreference_modes(hertz, response, order)[0]


def polyreference_modes(hertz: Array, response: ComplexArray, order: int) -> tuple[ComplexArray, ComplexArray]:
    """Poles as `polyreference` has them (k,), and the inputs' participations in each (k, inputs)."""
    _, outputs, inputs = response.shape
    period = 0.5 / float(hertz[-1])
    powers = np.exp(2j * np.pi * np.outer(hertz * period, np.arange(order + 1)))
    inner = np.linalg.inv((powers.conj().T @ powers).real)
    size = (order + 1) * inputs
    normal = np.zeros((size, size))
    for output in range(outputs):
        row = response[:, output, :] / max(float(np.sqrt(np.mean(np.abs(response[:, output, :]) ** 2))), 1e-300)
        product = -(powers[:, :, None] * row[:, None, :]).reshape(hertz.size, size)
        mixed = (powers.conj().T @ product).real
        normal += (product.conj().T @ product).real - mixed.T @ inner @ mixed
    # A(z) with its constant coefficient one, which leaves the poles of mere noise outside the unit circle.
    free = slice(inputs, size)
    found = -np.linalg.lstsq(normal[free, free], normal[free, :inputs], rcond=None)[0]
    coefficients = np.concatenate([np.eye(inputs), found]).reshape(order + 1, inputs, inputs).transpose(0, 2, 1)
    # 1 + A₁ᵀ z + … = 0 in w = 1/z: wⁿ + A₁ᵀ wⁿ⁻¹ + …
    companion = np.zeros((order * inputs, order * inputs))
    companion[inputs:, :-inputs] = np.eye((order - 1) * inputs)
    companion[:inputs] = -np.concatenate(list(coefficients[1:]), axis=1)
    inverse, vectors = (part.astype(complex) for part in np.linalg.eig(companion))
    kept = np.abs(inverse) > 1e-12
    return -np.log(inverse[kept]) / period, vectors[-inputs:, kept].T


def residues(hertz: Array, response: ComplexArray, poles: ComplexArray) -> ComplexArray:
    """Shapes of given oscillations in frequency responses, (outputs, k), by linear least squares.

    H(ω) = Σ R/(jω − λ) + R̄/(jω − λ̄) + E/(jω) + F + G jω; each residue R is of rank one, its left factor the shape.
    """
    s = 2j * np.pi * hertz
    count, outputs, inputs = poles.size, response.shape[1], response.shape[2]
    one, two = 1.0 / (s[:, None] - poles), 1.0 / (s[:, None] - poles.conj())
    scale = float(np.abs(s).mean())
    rest = np.stack([scale / s, np.ones_like(s), s / scale], axis=1)
    # Real unknowns: Re R, Im R, and the real rest.
    columns = np.concatenate([one + two, 1j * (one - two), rest], axis=1)
    system = np.concatenate([columns.real, columns.imag])
    known = response.reshape(hertz.size, -1)
    found = np.linalg.lstsq(system, np.concatenate([known.real, known.imag]), rcond=None)[0]
    complex_residues = (found[:count] + 1j * found[count : 2 * count]).reshape(count, outputs, inputs)
    return np.array([np.linalg.svd(residue)[0][:, 0] for residue in complex_residues]).T.reshape(outputs, count)


def agreed(fits: Iterable[Estimates], share: float = 0.6) -> list[Stable]:
    """Modes that at least a ``share`` of the fits have, by frequency.

    Estimates belong together where |λ|, damping ratio and shape are alike (`SAME_FREQUENCY`, `SAME_DAMPING`,
    `SAME_SHAPE`); each fit gives at most one to a mode.
    """
    taken = list(fits)
    groups: list[list[tuple[complex, ComplexArray]]] = []
    for fit in taken:
        free = set(range(len(groups)))
        for k in np.argsort(np.abs(fit.poles)):
            pole, shape = complex(fit.poles[k]), fit.shapes[:, k]
            near = [(_distance(pole, shape, groups[g]), g) for g in free]
            distance, best = min(near, default=(np.inf, -1))
            if distance <= 1.0:
                groups[best].append((pole, shape))
                free.discard(best)
            else:
                groups.append([(pole, shape)])
    least = max(2, int(np.ceil(share * len(taken)))) if len(taken) > 1 else 1
    found = [_stable(group) for group in groups if len(group) >= least]
    return sorted(found, key=lambda mode: abs(mode.pole))


def _distance(pole: complex, shape: ComplexArray, group: Sequence[tuple[complex, ComplexArray]]) -> float:
    """How far an estimate is from a group's mean, 1 at the limit."""
    mean = complex(np.mean([member[0] for member in group]))
    other = group[-1][1]
    likeness = abs(np.vdot(shape, other)) ** 2 / max(
        float(np.vdot(shape, shape).real * np.vdot(other, other).real), 1e-300
    )
    if likeness < SAME_SHAPE:
        return np.inf
    damping = abs(pole.real / abs(pole) - mean.real / abs(mean))
    return float(max(abs(abs(pole) / abs(mean) - 1.0) / SAME_FREQUENCY, damping / SAME_DAMPING))


def _stable(group: Sequence[tuple[complex, ComplexArray]]) -> Stable:
    poles = np.array([pole for pole, _ in group])
    middle = complex(np.median(poles.real) + 1j * np.median(poles.imag))
    shape = group[int(np.argmin(np.abs(poles - middle)))][1]
    freedom = 1 if len(group) > 1 else 0
    return Stable(
        middle,
        shape,
        float(np.std(np.abs(poles), ddof=freedom) / (2 * np.pi)),
        float(np.std(-poles.real / np.abs(poles), ddof=freedom)),
        len(group),
    )
