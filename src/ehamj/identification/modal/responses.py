"""Modes in measured responses of a machine: poles by pLSCF, fitted to every line, as many as the responses justify.

Fits of falling order are made until two end at the same modes; of all the one counts that Schwarz's criterion has.
What is left of the responses beside the fit says how well each mode is known: as errors of the same colour, and as
alike among the sensors, would move it (surrogates of random phases; Prichard and Theiler, Phys. Rev. Lett. 73, 1994).
"""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Final

import numpy as np

from ehamj.arrays import Array, ComplexArray
from ehamj.errors import InputError
from ehamj.estimate.identification import oscillating, polyreference
from ehamj.estimate.modal_fit import STEPS, ModalFit, modal_fit
from ehamj.measured.modes import ModeTable
from ehamj.measured.sensors import Place

POLES: Final = range(96, 23, -18)
"""Numbers of poles that fits begin with."""
SAME: Final = 1e-3
"""Distance of two poles over themselves within which they are one."""
HIGHEST_DAMPING: Final = 0.3
"""Damping ratio above which a pole is none of a mode that can be told from the rest."""
FEWEST_LINES: Final = 3.0
"""Lines per pole at least."""
VAGUE: Final = 0.3
"""Deviation of a shape, over its largest, above which it is noise that was taken for a mode."""
DRAWS: Final = 60
"""Of errors as those that are left."""
LEAST: Final = 1e-4
"""Deviation of a frequency over itself, and of a damping ratio [-], at least: what clocks and filters are known to."""


@dataclass(frozen=True)
class Mobilities:
    """Velocities of a machine's places over forces, as measured; ``places`` of outputs that the file itself tells."""

    components: tuple[str, ...]
    hertz: Array = field(repr=False)
    """Lines (f,) [Hz]."""
    values: ComplexArray = field(repr=False)
    """(f, output, input) [m/(N s)], or in any unit that all have."""
    deviation: Array = field(repr=False)
    """√E|error|² of each over that of the others, (f, output, input): the fit finds the size."""
    words: str
    """Where they come from."""
    places: Mapping[str, Place] = field(default_factory=dict)


def modes_in(measured: Mobilities) -> ModeTable:
    """Modes in responses, each with its standard deviations.

    Raises:
        InputError: if there is none.
    """
    known = np.isfinite(measured.values).all(axis=(1, 2)) & (measured.hertz > 0.0)
    hertz, values, deviation = measured.hertz[known], measured.values[known], measured.deviation[known]
    fits = _fits(hertz, values, deviation) if hertz.size else []
    if not fits:
        span = f"{measured.hertz[0]:.3g} to {measured.hertz[-1]:.3g} Hz" if measured.hertz.size else "no line"
        raise InputError(f"{measured.words}: no mode shows in {span}; state another band, or measure with more lines")
    best = min(fits, key=_criterion)
    alike = sum(_alike(best.poles, one.poles) for one in fits)
    words = f"{measured.words}; pLSCF from {hertz[0]:.3g} to {hertz[-1]:.3g} Hz, {alike} of {len(fits)} fits alike"
    table = _table(_weighed(hertz, values, deviation, best), measured, words)
    inside = (table.frequency >= hertz[0]) & (table.frequency <= hertz[-1])  # what lies beyond only helps the fit
    if not (clear := inside & (best.worth.max() > _price(best)) & (table.shape_deviation < VAGUE)).any():
        raise InputError(f"{measured.words}: no mode stands out of the noise; measure with more blows or averages")
    return table.of(clear)


@dataclass(frozen=True)
class _Weighed:
    fit: ModalFit
    moved: list[tuple[ComplexArray, ComplexArray]]
    """Poles and residues with errors as those that are left."""


def _weighed(hertz: Array, values: ComplexArray, deviation: Array, fit: ModalFit) -> _Weighed:
    """The best fit, each response by what is left of it."""
    deviation = deviation * np.maximum(fit.left, 1e-12)
    fit = modal_fit(hertz, values, deviation, fit.poles)
    lost = 2.0 * hertz.size / max(2.0 * hertz.size - 2.0 * fit.poles.size - 4.0, 1.0)
    left = np.sqrt(lost) * np.fft.fft(fit.error, axis=0)
    random = np.random.default_rng(0)
    turns = np.exp(2j * np.pi * random.uniform(size=(DRAWS, hertz.size, 1, 1)))
    return _Weighed(fit, [fit.moved(deviation * np.fft.ifft(left * turn, axis=0)) for turn in turns])


def _fits(hertz: Array, response: ComplexArray, deviation: Array) -> list[ModalFit]:
    """The best fits near what pLSCF finds with falling order, until two are alike."""
    fits: list[ModalFit] = []
    for count in POLES:
        order = count // response.shape[2]
        if order < 1 or hertz.size < FEWEST_LINES * order:
            continue
        poles = polyreference(hertz, response, order)
        found = oscillating(poles, np.zeros((1, poles.size), complex), least=2.0 * np.pi * hertz[0]).poles
        size = np.abs(found)
        kept = (size < 2.0 * np.pi * hertz[-1]) & (-found.real < HIGHEST_DAMPING * size)
        if kept.any():
            fits.append(_justified(hertz, response, deviation, found[kept]))
            if len(fits) > 1 and _alike(fits[-1].poles, fits[-2].poles):
                break
    return fits


def _justified(hertz: Array, response: ComplexArray, deviation: Array, poles: ComplexArray) -> ModalFit:
    """The best fit near some poles, without those that the responses do not justify."""
    for steps in (0, STEPS):  # most are told from modes before anything is fitted
        fit = modal_fit(hertz, response, deviation, poles, steps)
        while fit.poles.size > 1 and (poor := int((fit.worth < _price(fit)).sum())):
            least = np.argsort(fit.worth)[: min((poor + 1) // 2, fit.poles.size - 1)]  # of two alike one is worth more
            fit = modal_fit(hertz, response, deviation, np.delete(fit.poles, least), steps)
        poles = fit.poles
    return fit


def _price(fit: ModalFit) -> float:
    """Of a mode by Schwarz's criterion: a pole, and a residue of rank one."""
    lines, outputs, inputs = fit.error.shape
    return float(2 * (outputs + inputs) * np.log(2.0 * lines * outputs * inputs))


def _criterion(fit: ModalFit) -> float:
    """Schwarz's, of responses whose errors have a size each."""
    likelihood = 2.0 * len(fit.error) * 2.0 * np.log(np.maximum(fit.left, 1e-12)).sum()
    return float(likelihood + fit.poles.size * _price(fit))


def _alike(poles: ComplexArray, others: ComplexArray) -> bool:
    """Whether they are the same."""
    if poles.size != others.size:
        return False
    order, other = np.argsort(np.abs(poles)), np.argsort(np.abs(others))
    return bool((np.abs(poles[order] - others[other]) < SAME * np.abs(poles[order])).all())


def _table(found: _Weighed, measured: Mobilities, words: str) -> ModeTable:
    poles = found.fit.poles
    size, shapes = np.abs(poles), _shapes(found.fit.residues)
    hertz, ratio = size / (2.0 * np.pi), -poles.real / size
    others = np.array([moved for moved, _ in found.moved])
    frequency = np.std(np.abs(others), axis=0) / (2.0 * np.pi)
    damping = np.std(-others.real / np.abs(others), axis=0)
    apart = [_apart(_shapes(moved), shapes) for _, moved in found.moved]
    return ModeTable(
        measured.components,
        hertz,
        ratio,
        np.hypot(frequency, LEAST * hertz),
        np.hypot(damping, LEAST),
        shapes,
        np.hypot(np.sqrt(np.mean(apart, axis=0)), LEAST),
        False,
        words,
        measured.places,
    )


def _shapes(residues: ComplexArray) -> ComplexArray:
    """Of residues (k, output, input) the shapes at the outputs, (k, output), the largest part of each one."""
    left = np.linalg.svd(residues, full_matrices=False)[0][:, :, 0]
    return np.asarray(left / left[np.arange(len(left)), np.abs(left).argmax(axis=1)][:, None])


def _apart(shapes: ComplexArray, others: ComplexArray) -> Array:
    """Mean square of what shapes differ by from others, each as large and turned as is nearest, (k,)."""
    share = np.sum(shapes.conj() * others, axis=1) / np.sum(np.abs(shapes) ** 2, axis=1)
    return np.asarray(np.mean(np.abs(shapes * share[:, None] - others) ** 2, axis=1))
