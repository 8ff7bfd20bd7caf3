"""Modes that fit frequency responses best, and how errors of the responses move them.

H(ω) = Σ φ lᵀ/(jω − λ) + φ̄ l̄ᵀ/(jω − λ̄) + D/(jω) + E + F jω − G ω², with a pole λ, a shape φ at the outputs and a
participation l of the inputs per mode; the rest has room for the mass line and for stiffer modes of an acceleration.
Shapes and rest are linear, so that least squares look for poles and participations alone (variable projection, Golub
and Pereyra, SIAM J. Numer. Anal. 10, 1973), from those of pLSCF (`ehamj.estimate.identification`). At the best fit all
move linearly with the responses.
"""

from dataclasses import dataclass
from functools import cached_property
from typing import Final

import numpy as np

from ehamj.arrays import Array, ComplexArray

STEPS: Final = 10
"""In which the poles are looked for, at most."""
SETTLED: Final = 1e-6
"""Change of a pole over itself at which they stay."""
RELAXED: Final = (0.5, 1.6, 5.0)
"""Overdamped poles over the first line."""
WIDE: Final = 10.0
"""Last line over the first, from which a band has room for them."""
NOTHING: Final = 1e-10
"""Information in a direction over the most from which it counts: how large a shape and its participation are each,
nothing tells."""


@dataclass(frozen=True)
class ModalFit:
    """Modes of the best fit: ``poles`` λ (k,) [1/s], ``participations`` (k, input), ``shapes`` (k, output)."""

    poles: ComplexArray
    participations: ComplexArray
    shapes: ComplexArray
    error: ComplexArray
    """What is left of each response over its deviation, (f, output, input)."""
    _parts: tuple["_Part", ...]

    @property
    def left(self) -> Array:
        """RMS of what is left of each response over its deviation, (output, input)."""
        return np.asarray(np.sqrt(np.mean(np.abs(self.error) ** 2, axis=0)))

    @property
    def worth(self) -> Array:
        """By how much −2·log likelihood, errors of each output of a size of their own, rises without each mode, the
        others' poles where they are, (k,)."""
        return np.asarray(sum(part.worth(self.poles.size) for part in self._parts))

    @cached_property
    def _inverse(self) -> Array:
        """Of the information on poles and participations."""
        information = np.asarray(sum(part.own.T @ part.own for part in self._parts))
        scale = 1.0 / np.sqrt(np.maximum(np.diag(information), 1e-300))
        inverse = np.linalg.pinv(information * np.outer(scale, scale), rcond=NOTHING, hermitian=True)
        return np.asarray(inverse * np.outer(scale, scale))

    def step(self) -> tuple[ComplexArray, ComplexArray]:
        """By how much poles and participations are to change (Gauss and Newton)."""
        return self._split(self._inverse @ np.asarray(sum(part.own.T @ part.left for part in self._parts)))

    def moved(self, errors: ComplexArray) -> tuple[ComplexArray, ComplexArray]:
        """What poles and shapes would be with errors (f, output, input) on the responses."""
        known = [part.weighted(errors[:, o]) for o, part in enumerate(self._parts)]
        step = self._inverse @ np.asarray(sum(p.own.T @ one for p, one in zip(self._parts, known, strict=True)))
        count, shapes = self.poles.size, self.shapes.copy()
        for o, (part, one) in enumerate(zip(self._parts, known, strict=True)):
            found = part.solve(one - part.slopes @ step)
            shapes[:, o] += found[:count] + 1j * found[count : 2 * count]
        return self.poles + self._split(step)[0], shapes

    def _split(self, step: Array) -> tuple[ComplexArray, ComplexArray]:
        """Real unknowns as changes of poles (k,) and participations (k, input)."""
        real, imaginary = step.reshape(2, -1)
        whole = (real + 1j * imaginary).reshape(1 + self.participations.shape[1], -1)
        return whole[0], whole[1:].T


@dataclass(frozen=True)
class _Part:
    """One output's responses, (2·f·input, …) as real numbers over their deviations."""

    weight: Array
    basis: tuple[Array, Array]
    """Q, R of what is linear."""
    coefficients: Array
    left: Array
    shares: ComplexArray
    """1/(jω − λ), and 1/(jω − λ̄), (2, f, k)."""
    participations: ComplexArray

    @cached_property
    def slopes(self) -> Array:
        """In poles and participations, their real parts, then their imaginary ones."""
        (one, two), of, count = self.shares, self.participations, len(self.participations)
        shape = self.coefficients[:count] + 1j * self.coefficients[count : 2 * count]
        inputs = np.eye(of.shape[1])
        # (unknown, f, input, mode): of the pole, then of the participation of each input
        first = np.concatenate(
            [[(shape * one**2)[:, None] * of.T], (shape * one)[None, :, None] * inputs[:, None, :, None]]
        )
        second = np.concatenate(
            [[(shape.conj() * two**2)[:, None] * of.conj().T],
             (shape.conj() * two)[None, :, None] * inputs[:, None, :, None]]
        )  # fmt: skip
        parts = np.stack([first + second, 1j * (first - second)])
        return self._real(parts.transpose(2, 3, 0, 1, 4).reshape(len(one) * of.shape[1], -1))

    @cached_property
    def own(self) -> Array:
        """Of these what nothing linear does."""
        return np.asarray(self.slopes - self.basis[0] @ (self.basis[0].T @ self.slopes))

    def worth(self, count: int) -> Array:
        """See `ModalFit.worth`."""
        inverse = np.linalg.inv(self.basis[1])
        real, imaginary = inverse[:count], inverse[count : 2 * count]
        parts = [[real, real], [real, imaginary], [imaginary, real], [imaginary, imaginary]]
        covariance = np.array([np.sum(one * other, axis=1) for one, other in parts]).T.reshape(count, 2, 2)
        pair = self.coefficients[: 2 * count].reshape(2, -1).T
        rise = np.einsum("ka,kab,kb->k", pair, np.linalg.inv(covariance), pair)
        return np.asarray(self.left.size * np.log1p(rise / max(float(self.left @ self.left), 1e-300)))

    def weighted(self, values: ComplexArray) -> Array:
        """Responses (f, input) as real numbers over deviations."""
        return self._real(values.reshape(-1, 1))[:, 0]

    def solve(self, known: Array) -> Array:
        """What is linear, by least squares."""
        return np.asarray(np.linalg.solve(self.basis[1], self.basis[0].T @ known))

    def _real(self, columns: ComplexArray) -> Array:
        return np.concatenate([columns.real, columns.imag]) * self.weight[:, None]


def modal_fit(
    hertz: Array,
    response: ComplexArray,
    deviation: Array,
    begin: tuple[ComplexArray, ComplexArray],
    steps: int = STEPS,
) -> ModalFit:
    """The best fit near some modes.

    Args:
        hertz: lines [Hz], (f,).
        response: (f, output, input).
        deviation: √E|error|² of each value, in any unit, (f, output, input).
        begin: poles λ [1/s], Im λ > 0, (k,), and participations (k, input) where it begins.
        steps: in which these are looked for, at most; 0: they stay.
    """
    fit = _at(hertz, response, deviation, *begin)
    for _ in range(steps):
        poles, of = fit.step()
        now = float(np.sum(np.abs(fit.error) ** 2))
        for share in (1.0, 0.5, 0.25, 0.125):  # a full step may lead past the best
            tried = fit.poles + share * poles
            if (tried.real >= 0.0).any() or (tried.imag <= 0.0).any():
                continue
            other = _at(hertz, response, deviation, tried, fit.participations + share * of)
            if float(np.sum(np.abs(other.error) ** 2)) <= now:
                break
        else:
            break
        fit = other
        if (np.abs(share * poles) < SETTLED * np.abs(fit.poles)).all():
            break
    return fit


def _relaxed(s: ComplexArray, scale: float) -> list[ComplexArray]:
    """What a wide band has at its low end that does not swing: overdamped poles there, as of oil that leaks past a
    piston, which a few near them stand in for."""
    low, high = float(np.abs(s[0])), float(np.abs(s[-1]))
    return [scale / (s + low * share) for share in RELAXED] if high > WIDE * low else []


def _at(hertz: Array, response: ComplexArray, deviation: Array, poles: ComplexArray, of: ComplexArray) -> ModalFit:
    """Shapes and rest that fit best with some poles and participations."""
    of = of / np.linalg.norm(of, axis=1)[:, None]
    s = np.asarray(2j * np.pi * hertz, np.complex128)
    count, inputs = of.shape
    shares = np.array([1.0 / (s[:, None] - poles), 1.0 / (s[:, None] - poles.conj())])
    first, second = shares[0][:, None] * of.T, shares[1][:, None] * of.conj().T
    scale = float(np.abs(s).mean())
    rest = np.stack([scale / s, np.ones_like(s), s / scale, (s / scale) ** 2, *_relaxed(s, scale)], axis=1)
    alone = (rest[:, None, None] * np.eye(inputs)[None, :, :, None]).reshape(len(s), inputs, -1)
    columns = np.concatenate([first + second, 1j * (first - second), alone], axis=2).reshape(len(s) * inputs, -1)
    system = np.concatenate([columns.real, columns.imag])
    parts, errors, shapes = [], [], []
    for o in range(response.shape[1]):
        weight = np.tile(1.0 / deviation[:, o].ravel(), 2)
        q, r = np.linalg.qr(system * weight[:, None])
        known = np.concatenate([response[:, o].real.ravel(), response[:, o].imag.ravel()]) * weight
        share = q.T @ known
        found, left = np.linalg.solve(r, share), known - q @ share
        parts.append(_Part(weight, (q, r), found, left, shares, of))
        errors.append((left[: len(columns)] + 1j * left[len(columns) :]).reshape(len(s), inputs))
        shapes.append(found[:count] + 1j * found[count : 2 * count])
    return ModalFit(poles, of, np.array(shapes).T, np.stack(errors, axis=1), tuple(parts))
