"""Measured modes beside computed ones: pairs by likeness, and what differs, smooth where modes are close.

Measured modes that follow each other within `CLOSE` are taken together: shapes of neighbours mix with the least change
of the machine, and which of them is which means little. Let Φ be the computed shapes of such a group at the
sensors, and Φ' the measured ones. With Φ' ≈ Φ T, the unitary part U of T turns the computed eigenvalues Λ into the
measured shapes, G = Uᴴ Λ U: its diagonal is compared with the measured eigenvalues, its other elements (the *coupling*)
with zero, and Φ T with Φ'. All of these are smooth in the machine's parameters even where its modes cross; of a mode by
itself they are its eigenvalue, and its shape at the modal scale factor.
"""

from itertools import combinations
from typing import Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ehamj.arrays import Array, ComplexArray
from ehamj.identification.modal.computed import Computed
from ehamj.linear.eigen import mac
from ehamj.linear.pairing import best_pairs, likeness
from ehamj.measured.modes import MeasuredModes

CLOSE: Final = 0.1
"""Relative distance of two frequencies, one after the other, within which both modes are taken together."""
NEAR: Final = 0.35
"""Relative distance in frequency at which a computed mode becomes unlikely to be a measured one: values looked for may
be off by half."""

UNKNOWN_DAMPING: Final = 0.02
"""Standard deviation of a damping ratio that was not measured [-]."""

Numbers = NDArray[np.int64]
Pairs = dict[int, int]
"""Computed mode of each measured one."""


class Seen(NamedTuple):
    """What a computed machine gives in place of each measured mode (k,); where a mode has no pair, what was measured.

    ``shape`` is (k, n); ``coupling`` (c,) [Hz] of each two in a group (`coupled`), zero where one has no pair.
    """

    frequency: Array
    damping_ratio: Array
    shape: ComplexArray
    coupling: ComplexArray


def at_sensors(measured: MeasuredModes, computed: Computed) -> ComplexArray:
    """Computed shapes at the sensors, (n, m); of shapes that were measured without phase, the part in step."""
    shapes = measured.sensors.rows(computed.positions) @ computed.shapes.T
    if measured.real and shapes.size:
        square = np.sum(shapes**2, axis=0)
        return np.asarray((shapes * np.exp(-0.5j * np.angle(square))).real.astype(complex))
    return np.asarray(shapes)


def alike(measured: MeasuredModes, computed: Computed) -> Array:
    """MAC of shapes at the sensors, (k, m); one where there are no sensors, since nothing tells them apart."""
    if not measured.sensors.names:
        return np.ones((measured.frequency.size, computed.poles.size))
    return mac(measured.shape.T, at_sensors(measured, computed))


def likely(measured: MeasuredModes, computed: Computed) -> Array:
    """How likely each measured mode is each computed one (k, m)."""
    return likeness(alike(measured, computed), measured.frequency, computed.frequency, NEAR)


def groups(measured: MeasuredModes) -> tuple[tuple[int, ...], ...]:
    """Measured modes that are taken together, by frequency; without shapes each by itself."""
    found: list[list[int]] = []
    for k, hertz in enumerate(measured.frequency):
        together = bool(found) and bool(measured.sensors.names)
        if together and hertz <= measured.frequency[found[-1][-1]] * (1.0 + CLOSE):
            found[-1].append(k)
        else:
            found.append([k])
    return tuple(map(tuple, found))


def pairs_of(measured: MeasuredModes, computed: Computed, count: int) -> Pairs:
    """The most likely ``count`` pairs."""
    return best_pairs(likely(measured, computed), count)


def seen(measured: MeasuredModes, computed: Computed, pairs: Pairs) -> Seen:
    """What a computed machine shows in place of the measured modes."""
    frequency, ratio = measured.frequency.copy(), measured.damping_ratio.copy()
    shape, both = measured.shape.copy(), np.zeros((len(frequency), len(frequency)), complex)
    shapes = at_sensors(measured, computed)
    for group in groups(measured):
        own = [k for k in group if k in pairs]
        if not own:
            continue
        columns = [pairs[k] for k in own]
        values, basis, target = computed.poles[columns], shapes[:, columns], measured.shape[own].T
        turned = np.diag(values)
        if measured.sensors.names:
            turned, nearest = turned_into(values, basis, target)
            shape[own] = nearest.T
        eigen = np.diag(turned)
        frequency[own] = np.abs(eigen) / (2.0 * np.pi)
        ratio[own] = np.where(np.isnan(ratio[own]), np.nan, -eigen.real / np.abs(eigen))
        both[np.ix_(own, own)] = turned / (2.0 * np.pi)
    first, second = coupled(measured)
    return Seen(frequency, ratio, shape, both[first, second])


def turned_into(values: ComplexArray, basis: ComplexArray, target: ComplexArray) -> tuple[ComplexArray, ComplexArray]:
    """Eigenvalues (k,) with shapes ``basis`` (n, k) as others' shapes (n, k) have them: the matrix G (k, k), whose
    diagonal goes with theirs, and what of these shapes the basis has (n, k)."""
    turn = np.linalg.lstsq(basis, target, rcond=None)[0]
    if len(values) == 1:
        return np.diag(values), basis @ turn
    unitary = _unitary(turn * np.linalg.norm(basis, axis=0)[:, None] / np.linalg.norm(target, axis=0))
    return unitary.conj().T @ np.diag(values) @ unitary, basis @ turn


def _unitary(matrix: ComplexArray) -> ComplexArray:
    """The unitary matrix nearest to a square one (its polar factor)."""
    left, _, right = np.linalg.svd(matrix)
    return np.asarray(left @ right)


def coupled(measured: MeasuredModes) -> tuple[Numbers, Numbers]:
    """Each two measured modes of a group, the first and the second of them, (c,) each."""
    both = [two for group in groups(measured) for two in combinations(group, 2)]
    first, second = np.array(both, int).reshape(-1, 2).T
    return first, second


def coupling_deviation(measured: MeasuredModes) -> Array:
    """Standard deviation of a coupling, √E|error|², (c,) [Hz].

    A shape that has ε of its neighbour couples both by half of ε times the distance of their eigenvalues.
    """
    found = []
    if measured.mixing is not None:
        first, second = coupled(measured)
        return np.asarray(measured.mixing[first, second])
    hertz = measured.frequency
    ratio = np.where(np.isnan(measured.damping_ratio), 0.0, measured.damping_ratio)
    unsure = np.where(np.isnan(measured.damping_ratio), UNKNOWN_DAMPING, measured.damping_deviation)
    spread = np.hypot(measured.frequency_deviation, unsure * hertz)
    values = hertz * (1j - ratio)
    for first, second in zip(*coupled(measured), strict=True):
        group = next(group for group in groups(measured) if first in group)
        # By what the shapes of a group are told apart, and how much of one another their errors seem to be.
        apart = np.linalg.norm(np.linalg.pinv(measured.shape[list(group)].T), axis=1)
        one, other = group.index(first), group.index(second)
        size = np.linalg.norm(measured.shape[list(group)], axis=1)
        mixed = (
            apart[one] * size[one] * measured.shape_deviation[second] / size[other],
            apart[other] * size[other] * measured.shape_deviation[first] / size[one],
        )
        distance = np.sqrt(abs(values[second] - values[first]) ** 2 + spread[first] ** 2 + spread[second] ** 2)
        found.append(0.5 * np.hypot(*mixed) * distance)
    return np.array(found)
