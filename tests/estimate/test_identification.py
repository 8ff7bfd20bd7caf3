"""Identification: from signals and responses whose poles are known, with and without noise."""

import numpy as np
import pytest
from oracles import linear

from ehamj.estimate.identification import Estimates, agreed, oscillating, polyreference, realise, residues

HERTZ = np.arange(5.0, 120.0, 0.5)


def pole_of(frequency: float, damping: float) -> complex:
    return 2 * np.pi * frequency * complex(-damping, np.sqrt(1 - damping**2))


POLES = np.array([pole_of(20.0, 0.02), pole_of(21.0, 0.03), pole_of(75.0, 0.1)])


def system(seed: int = 0) -> tuple[np.ndarray, np.ndarray]:
    """Complex shapes (5, 3), and responses (f, 5, 2) of rank-one residues with a constant."""
    random = np.random.default_rng(seed)
    shapes, factors = (random.normal(size=(n, 3)) + 0.3j * random.normal(size=(n, 3)) for n in (5, 2))
    s = 2j * np.pi * HERTZ[:, None]
    one, two = 1.0 / (s - POLES), 1.0 / (s - POLES.conj())
    response = np.einsum("fk,ok,ik->foi", one, shapes, factors)
    response += np.einsum("fk,ok,ik->foi", two, shapes.conj(), factors.conj())
    return shapes, 10.0 * response + 0.1


def nearest(found: np.ndarray, pole: complex) -> complex:
    return complex(found[np.argmin(np.abs(found - pole))])


@pytest.mark.parametrize("order", [3, 5])
def test_poles_of_sampled_responses_are_found_exactly(order: int) -> None:
    # Σ R/(1 − p/z), which is a fraction of polynomials in z: 2 × 3 poles of two inputs from order 3 on.
    random = np.random.default_rng(2)
    discrete = np.exp(POLES * 0.5 / HERTZ[-1])
    discrete = np.concatenate([discrete, discrete.conj()])
    shapes, factors = (random.normal(size=(n, 3)) + 1j * random.normal(size=(n, 3)) for n in (5, 2))
    shapes, factors = (np.hstack([part, part.conj()]) for part in (shapes, factors))
    z = np.exp(2j * np.pi * HERTZ[:, None] * 0.5 / HERTZ[-1])
    found = polyreference(HERTZ, np.einsum("fk,ok,ik->foi", 1.0 / (1.0 - discrete / z), shapes, factors), order)
    for pole in POLES:
        # Normal equations square the condition of the problem.
        assert abs(nearest(found, pole) - pole) <= 1e-6 * abs(pole)


def test_poles_of_continuous_responses_come_nearer_with_the_order() -> None:
    response = system()[1]
    errors = [
        max(abs(nearest(polyreference(HERTZ, response, order), pole) / pole - 1) for pole in POLES)
        for order in (4, 8, 12)
    ]
    assert errors[1] < 0.1 * errors[0]
    assert errors[2] < 0.1 * errors[1]
    assert errors[2] < 1e-4


def test_shapes_of_known_poles_are_found() -> None:
    shapes, response = system()
    found = residues(HERTZ, response, POLES)
    likeness = np.abs(np.sum(found.conj() * shapes, axis=0)) / (
        np.linalg.norm(found, axis=0) * np.linalg.norm(shapes, axis=0)
    )
    np.testing.assert_allclose(likeness, 1.0, rtol=1e-10)


def test_responses_of_the_machine_give_its_modes() -> None:
    machine = linear.LinearMachine()
    hertz = np.arange(30.0, 800.0, 5.0)
    response = np.array([[linear.transmissibility(machine, dof, f) for dof in linear.DOFS] for f in hertz])
    found = polyreference(hertz, response.transpose(0, 2, 1), 10)
    for frequency, damping in linear.oscillators(linear.passive_modes(machine)):
        if damping > 0.5:
            continue  # the valves, which the floor does not move
        pole = pole_of(frequency, damping)
        assert abs(nearest(found, pole) - pole) <= 1e-4 * abs(pole)


def test_what_fits_agree_on_is_kept_and_its_spread_told() -> None:
    random = np.random.default_rng(1)
    shapes = system()[0]
    fits = []
    for k in range(20):
        poles = POLES * (1 + 1e-3 * random.normal(size=3))
        stray = pole_of(random.uniform(30.0, 60.0), 0.05)
        extra = random.normal(size=(5, 1)) + 0j
        if k % 4 == 0:  # the last one is not always found
            poles = poles[:2]
        fits.append(Estimates(np.append(poles, stray), np.hstack([shapes[:, : poles.size], extra])))
    found = agreed(fits)
    assert [mode.count for mode in found] == [20, 20, 15]
    for mode, pole in zip(found, POLES, strict=True):
        # Twenty normal deviates of 1e-3: median and standard deviation are within a few tenths of theirs.
        assert abs(mode.pole) == pytest.approx(abs(pole), rel=1e-3)
        assert mode.frequency_spread == pytest.approx(1e-3 * abs(pole) / (2 * np.pi), rel=0.5)
        assert mode.damping_spread <= 1e-12


def test_close_modes_of_other_shapes_are_told_apart() -> None:
    one, other = np.array([[1.0], [0.0]]) + 0j, np.array([[0.0], [1.0]]) + 0j
    poles = np.array([pole_of(20.0, 0.02), pole_of(20.01, 0.02)])
    assert len(agreed([Estimates(poles, np.hstack([one, other]))] * 3)) == 2


def test_only_what_swings_and_decays_is_kept() -> None:
    poles = np.array([-1 + 5j, -1 - 5j, 1 + 5j, -3 + 0j, -1 + 0.5j])
    np.testing.assert_array_equal(oscillating(poles, np.eye(5) + 0j, least=1.0).poles, [-1 + 5j])


def test_decays_of_a_repeated_eigenvalue_need_as_many_experiments() -> None:
    # Two equal oscillators at right angles: each decay holds one of them.
    times = np.arange(120) / 400.0
    signal = np.exp(-5 * times) * np.cos(2 * np.pi * 30 * times)
    decays = np.zeros((2, times.size, 2))
    decays[0, :, 0], decays[1, :, 1] = signal, 0.5 * signal
    ((values, shapes),) = realise(decays, 400.0, [4])
    upper = values.imag > 0
    np.testing.assert_allclose(values[upper], complex(-5, 2 * np.pi * 30), rtol=1e-9)
    assert np.linalg.matrix_rank(shapes[:, upper]) == 2
