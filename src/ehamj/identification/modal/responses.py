"""Modes in measured responses of a machine: poles by pLSCF, fitted to every line, as many as the responses justify.

Fits of falling order are made until two end at the same modes; of all the one counts that Schwarz's criterion has.
What is left of the responses beside the fit says how well each mode is known: as errors of the same colour, and as
alike among the sensors, would move it (surrogates of random phases; Prichard and Theiler, Phys. Rev. Lett. 73, 1994).
"""

from collections.abc import Mapping
from dataclasses import dataclass, field
from itertools import combinations
from typing import Final

import numpy as np

from ehamj.arrays import Array, ComplexArray
from ehamj.errors import InputError
from ehamj.estimate.identification import oscillating, polyreference_modes
from ehamj.estimate.modal_fit import STEPS, ModalFit, modal_fit
from ehamj.identification.modal.compared import CLOSE, turned_into
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
    errors: ComplexArray | None = field(default=None, repr=False)
    """Parts of an error of the values, (n, f, output, input), whose squares sum to its; None: not known."""
    freedom: int = 0
    """Degrees of freedom of these."""


def modes_in(measured: Mobilities) -> ModeTable:
    """Modes in responses, each with its standard deviations.

    Raises:
        InputError: if there is none.
    """
    both = np.isfinite(measured.values) & np.isfinite(measured.deviation)
    known = both.all(axis=(1, 2)) & (measured.hertz > 0.0)
    hertz, values, deviation = measured.hertz[known], measured.values[known], measured.deviation[known]
    fits = _fits(hertz, values, deviation) if hertz.size else []
    if not fits:
        span = f"{measured.hertz[0]:.3g} to {measured.hertz[-1]:.3g} Hz" if measured.hertz.size else "no line"
        raise InputError(f"{measured.words}: no mode shows in {span}; state another band, or measure with more lines")
    best = min(fits, key=_criterion)
    alike = sum(_alike(best.poles, one.poles) for one in fits)
    words = f"{measured.words}; pLSCF from {hertz[0]:.3g} to {hertz[-1]:.3g} Hz, {alike} of {len(fits)} fits alike"
    errors = None if measured.errors is None else measured.errors[:, known]
    table = _table(_weighed(hertz, values, deviation, best, errors), measured, words)
    inside = (table.frequency >= hertz[0]) & (table.frequency <= hertz[-1])  # what lies beyond only helps the fit
    if not (clear := inside & (best.worth.max() > _price(best)) & (table.shape_deviation < VAGUE)).any():
        raise InputError(f"{measured.words}: no mode stands out of the noise; measure with more blows or averages")
    return table.of(clear)


Moved = list[tuple[ComplexArray, ComplexArray]]
"""Poles and shapes with errors."""


@dataclass(frozen=True)
class _Weighed:
    fit: ModalFit
    moved: Moved
    """With errors as those that are left."""
    parts: Moved
    """With parts of an error that is known otherwise."""


def _weighed(
    hertz: Array, values: ComplexArray, deviation: Array, fit: ModalFit, errors: ComplexArray | None
) -> _Weighed:
    """The best fit, each response by what is left of it."""
    deviation = deviation * np.maximum(fit.left, 1e-12)
    fit = modal_fit(hertz, values, deviation, (fit.poles, fit.participations))
    lost = 2.0 * hertz.size / max(2.0 * hertz.size - 2.0 * fit.poles.size - 4.0, 1.0)
    left = np.sqrt(lost) * np.fft.fft(fit.error, axis=0)
    random = np.random.default_rng(0)
    turns = np.exp(2j * np.pi * random.uniform(size=(DRAWS, hertz.size, 1, 1)))
    moved = [fit.moved(deviation * np.fft.ifft(left * turn, axis=0)) for turn in turns]
    return _Weighed(fit, moved, [] if errors is None else [fit.moved(one) for one in errors])


def _fits(hertz: Array, response: ComplexArray, deviation: Array) -> list[ModalFit]:
    """The best fits near what pLSCF finds with falling order, until two are alike."""
    fits: list[ModalFit] = []
    for count in POLES:
        order = count // response.shape[2]
        if order < 1 or hertz.size < FEWEST_LINES * order:
            continue
        poles, of = polyreference_modes(hertz, response, order)
        found = oscillating(poles, of.T, least=2.0 * np.pi * hertz[0])
        size = np.abs(found.poles)
        kept = (size < 2.0 * np.pi * hertz[-1]) & (-found.poles.real < HIGHEST_DAMPING * size)
        if kept.any():
            fits.append(_justified(hertz, response, deviation, (found.poles[kept], found.shapes[:, kept].T)))
            if len(fits) > 1 and _alike(fits[-1].poles, fits[-2].poles):
                break
    return fits


def _justified(
    hertz: Array, response: ComplexArray, deviation: Array, begin: tuple[ComplexArray, ComplexArray]
) -> ModalFit:
    """The best fit near some poles and participations, without modes that the responses do not justify."""
    for steps in (0, STEPS):  # most are told from modes before anything is fitted
        fit = modal_fit(hertz, response, deviation, begin, steps)
        while fit.poles.size > 1 and (poor := int((fit.worth < _price(fit)).sum())):
            least = np.argsort(fit.worth)[: min((poor + 1) // 2, fit.poles.size - 1)]  # of two alike one is worth more
            others = np.delete(fit.poles, least), np.delete(fit.participations, least, axis=0)
            fit = modal_fit(hertz, response, deviation, others, steps)
        begin = fit.poles, fit.participations
    return fit


def _price(fit: ModalFit) -> float:
    """Of a mode by Schwarz's criterion: pole, shape and participations."""
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
    """Modes with the larger of both deviations: what moves a fit unseen, as the force's noise does, is in the blows'
    own differences only; and these are few."""
    poles = found.fit.poles
    spread = np.sqrt(np.mean(_squares(found.moved, found.fit), axis=0))
    if found.parts:
        few = measured.freedom / max(measured.freedom - 2.0, 0.5)  # as the variance of Student's t is wider
        spread = np.maximum(spread, np.sqrt(few * np.sum(_squares(found.parts, found.fit), axis=0)))
    frequency, damping, shape, mixing = spread[:, 0], spread[:, 1], spread[:, 2], spread[:, 3:]
    size = np.abs(poles)
    hertz, ratio = size / (2.0 * np.pi), -poles.real / size
    return ModeTable(
        measured.components,
        hertz,
        ratio,
        np.hypot(frequency, LEAST * hertz),
        np.hypot(damping, LEAST),
        _largest_one(found.fit.shapes),
        np.hypot(shape, LEAST),
        False,
        words,
        measured.places,
        np.hypot(mixing, LEAST * hertz),
    )


def _squares(moved: Moved, fit: ModalFit) -> Array:
    """Of what moved modes differ by from the fit's: frequency [Hz], damping ratio, shape over its largest, and coupling
    with each mode [Hz], (n, k, 3 + k); of close modes as they are compared with a model's, so that what only mixes
    them is the coupling's."""
    size, shapes = np.abs(fit.poles), _largest_one(fit.shapes)
    count = size.size
    rows = np.zeros((len(moved), count, 3 + count))
    for row, (poles, others) in zip(rows, moved, strict=True):
        row[:, 0] = ((np.abs(poles) - size) / (2.0 * np.pi)) ** 2
        row[:, 1] = (fit.poles.real / size - poles.real / np.abs(poles)) ** 2
        row[:, 2] = _apart(others, shapes)
        for one, two in combinations(range(count), 2):
            if abs(size[one] - size[two]) < CLOSE * min(size[one], size[two]):
                pair = [one, two]
                turned, _ = turned_into(fit.poles[pair], shapes[pair].T, others[pair].T)
                row[pair, [3 + two, 3 + one]] = np.abs(turned[[0, 1], [1, 0]] / (2.0 * np.pi)) ** 2
    return rows


def _largest_one(shapes: ComplexArray) -> ComplexArray:
    """Shapes (k, output) with one as the largest part."""
    return np.asarray(shapes / shapes[np.arange(len(shapes)), np.abs(shapes).argmax(axis=1)][:, None])


def _apart(shapes: ComplexArray, others: ComplexArray) -> Array:
    """Mean square of what shapes differ by from others, each as large and turned as is nearest, (k,)."""
    share = np.sum(shapes.conj() * others, axis=1) / np.sum(np.abs(shapes) ** 2, axis=1)
    return np.asarray(np.mean(np.abs(shapes * share[:, None] - others) ** 2, axis=1))
