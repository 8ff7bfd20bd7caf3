"""Poles and residues that fit frequency responses best, and how errors of the responses move them.

H(ω) = Σ R/(jω − λ) + R̄/(jω − λ̄) + D/(jω) + E + F jω − G ω², which has room for the mass line and for stiffer modes of
an acceleration. Residues and rest are linear, so that least squares look for the poles alone (variable projection,
Golub and Pereyra, SIAM J. Numer. Anal. 10, 1973), from those that pLSCF found (`ehamj.estimate.identification`). At
the best fit both move linearly with the responses.
"""

from dataclasses import dataclass
from functools import cached_property
from typing import Final

import numpy as np

from ehamj.arrays import Array, ComplexArray

STEPS: Final = 8
"""In which the poles are looked for, at most."""
SETTLED: Final = 1e-6
"""Change of a pole over itself at which they stay."""


@dataclass(frozen=True)
class ModalFit:
    """Poles ``poles`` λ (k,) [1/s] and their residues ``residues`` (k, output, input) of the best fit."""

    poles: ComplexArray
    residues: ComplexArray
    error: ComplexArray
    """What is left of each response over its deviation, (f, output, input)."""
    _parts: tuple["_Part", ...]

    @cached_property
    def _information(self) -> Array:
        """On real and imaginary parts of the poles, (2k, 2k)."""
        return np.asarray(sum(part.own.T @ part.own for part in self._parts))

    @property
    def left(self) -> Array:
        """RMS of what is left of each response over its deviation, (output, input)."""
        return np.asarray(np.sqrt(np.mean(np.abs(self.error) ** 2, axis=0)))

    @property
    def worth(self) -> Array:
        """By how much −2·log likelihood of all responses, whose errors have a size each, rises without each pole, the
        others where they are, (k,)."""
        blocks: dict[int, Array] = {}
        for part in self._parts:
            if id(part.basis) not in blocks:
                blocks[id(part.basis)] = _blocks(part.basis[1], self.poles.size)
        return np.asarray(sum(part.worth(blocks[id(part.basis)]) for part in self._parts))

    def moved(self, errors: ComplexArray) -> tuple[ComplexArray, ComplexArray]:
        """What poles and residues would be with errors (f, output, input) on the responses."""
        _, outputs, inputs = errors.shape
        pairs = _pairs(outputs, inputs)
        known = [part.weighted(errors[:, o, i]) for part, (o, i) in zip(self._parts, pairs, strict=True)]
        known_of = sum(part.own.T @ one for part, one in zip(self._parts, known, strict=True))
        step = np.linalg.solve(self._information, known_of)
        count = self.poles.size
        residues = self.residues.copy()
        for part, one, (o, i) in zip(self._parts, known, pairs, strict=True):
            found = part.solve(one - part.slopes @ step)
            residues[:, o, i] += found[:count] + 1j * found[count : 2 * count]
        return self.poles + step[:count] + 1j * step[count:], residues


@dataclass(frozen=True)
class _Part:
    """One response with all poles: (2f, …) as real numbers over the deviation."""

    weight: Array
    size: float
    """Largest weight."""
    basis: tuple[Array, Array]
    """Q, R of what is linear, with weights over that."""
    coefficients: Array
    left: Array
    shares: tuple[ComplexArray, ComplexArray]
    """1/(jω − λ) and 1/(jω − λ̄), (f, k)."""

    @cached_property
    def slopes(self) -> Array:
        """In the poles' real and imaginary parts, (2f, 2k)."""
        one, two = self.shares
        count = one.shape[1]
        residue = self.coefficients[:count] + 1j * self.coefficients[count : 2 * count]
        first, second = residue * one**2, residue.conj() * two**2
        slopes = np.concatenate([first + second, 1j * (first - second)], axis=1)
        return np.concatenate([slopes.real, slopes.imag]) * self.weight[:, None]

    @cached_property
    def own(self) -> Array:
        """Of these what nothing linear does."""
        return np.asarray(self.slopes - self.basis[0] @ (self.basis[0].T @ self.slopes))

    def worth(self, blocks: Array) -> Array:
        """By how much −2·log likelihood rises without each pole, (k,); ``blocks`` see `_blocks`."""
        pair = self.coefficients[: 2 * len(blocks)].reshape(2, -1).T
        rise = np.einsum("ka,kab,kb->k", pair, blocks, pair) * self.size**2
        return np.asarray(self.left.size * np.log1p(rise / max(float(self.left @ self.left), 1e-300)))

    def weighted(self, values: ComplexArray) -> Array:
        return np.concatenate([values.real, values.imag]) * self.weight

    def solve(self, known: Array) -> Array:
        return np.asarray(np.linalg.solve(self.basis[1], self.basis[0].T @ known) / self.size)


def modal_fit(
    hertz: Array, response: ComplexArray, deviation: Array, poles: ComplexArray, steps: int = STEPS
) -> ModalFit:
    """The best fit near some poles.

    Args:
        hertz: lines [Hz], (f,).
        response: (f, output, input).
        deviation: √E|error|² of each value, in any unit, (f, output, input).
        poles: λ [1/s] where it begins, Im λ > 0, (k,).
        steps: in which poles are looked for, at most; 0: they stay.
    """
    now, parts = _at(hertz, response, deviation, poles)
    for _ in range(steps):
        information = sum(one.own.T @ one.own for one in parts)
        step = np.linalg.solve(information, sum(one.own.T @ one.left for one in parts))
        change = step[: poles.size] + 1j * step[poles.size :]
        for share in (1.0, 0.5, 0.25, 0.125):  # a full step may lead past the best
            tried = poles + share * change
            if (tried.real >= 0.0).any() or (tried.imag <= 0.0).any():
                continue
            cost, others = _at(hertz, response, deviation, tried)
            if cost <= now:
                break
        else:
            break
        poles, parts, now = tried, others, cost
        if (np.abs(share * change) < SETTLED * np.abs(poles)).all():
            break
    outputs, inputs = response.shape[1:]
    count = poles.size
    residues = np.array([one.coefficients[:count] + 1j * one.coefficients[count : 2 * count] for one in parts])
    left = np.array([one.left[: hertz.size] + 1j * one.left[hertz.size :] for one in parts])
    error = left.T.reshape(hertz.size, outputs, inputs)
    return ModalFit(poles, residues.T.reshape(count, outputs, inputs), error, tuple(parts))


def _at(hertz: Array, response: ComplexArray, deviation: Array, poles: ComplexArray) -> tuple[float, list[_Part]]:
    """Cost with some poles, and each response there."""
    s = 2j * np.pi * hertz
    one, two = 1.0 / (s[:, None] - poles), 1.0 / (s[:, None] - poles.conj())
    scale = float(np.abs(s).mean())
    rest = np.stack([scale / s, np.ones_like(s), s / scale, (s / scale) ** 2], axis=1)
    columns = np.concatenate([one + two, 1j * (one - two), rest], axis=1)
    system = np.concatenate([columns.real, columns.imag])
    parts, bases = [], {}
    for o, i in _pairs(*response.shape[1:]):
        weight = np.tile(1.0 / deviation[:, o, i], 2)
        size = float(weight.max())
        if (key := (weight / size).tobytes()) not in bases:  # responses known alike at all lines have one
            bases[key] = np.linalg.qr(system * (weight / size)[:, None])
        q = bases[key][0]
        known = np.concatenate([response[:, o, i].real, response[:, o, i].imag]) * weight
        share = q.T @ known
        found = np.linalg.solve(bases[key][1], share) / size
        parts.append(_Part(weight, size, bases[key], found, known - q @ share, (one, two)))
    return float(sum(part.left @ part.left for part in parts)), parts


def _blocks(triangle: Array, count: int) -> Array:
    """Information on real and imaginary parts of each of some residues when nothing is known of the others, (k, 2, 2);
    from R of what is linear."""
    inverse = np.linalg.inv(triangle)
    real, imaginary = inverse[:count], inverse[count : 2 * count]
    parts = [[real, real], [real, imaginary], [imaginary, real], [imaginary, imaginary]]
    covariance = np.array([np.sum(one * other, axis=1) for one, other in parts]).T.reshape(count, 2, 2)
    return np.asarray(np.linalg.inv(covariance))


def _pairs(outputs: int, inputs: int) -> list[tuple[int, int]]:
    return [(o, i) for o in range(outputs) for i in range(inputs)]
