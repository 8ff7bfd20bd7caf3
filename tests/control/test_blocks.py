"""Linear blocks: against the zeros and poles that they are made of, SciPy's discretisations, and their own algebra."""

from decimal import Decimal, localcontext

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import ArrayLike, NDArray
from scipy import signal

from ehamj.control.blocks import Block, added, beside, joined, pair

Array = NDArray[np.float64]
ComplexArray = NDArray[np.complex128]

POINTS = (0.0, 0.3j, 5j, 40.0 + 300j, 2e4j)
"""Places of the Laplace variable at which blocks are compared [rad/s]."""


def at(block: Block, s: complex) -> ComplexArray:
    """C (s − A)⁻¹ B + D."""
    A, B, C, D = block
    return np.asarray(C @ np.linalg.solve(s * np.eye(A.shape[0]) - A, B.astype(complex)) + D)


def in_many_digits(block: Block, omega: float) -> complex:
    """The response of one input and output at jω [rad/s], solved in sixty digits: what the matrices hold themselves."""
    n = block.A.shape[0]
    with localcontext(prec=60):
        A, B, C, D = (np.frompyfunc(Decimal, 1, 1)(part) for part in block)
        turn = Decimal(omega) * np.frompyfunc(Decimal, 1, 1)(np.eye(n))
        # (jω − A)(x + jy) = B in real numbers, by elimination.
        system = np.block([[-A, -turn, B], [turn, -A, 0 * B]])
        for k in range(2 * n):
            pivot = k + int(np.argmax(np.abs(system[k:, k])))
            system[[k, pivot]] = system[[pivot, k]]
            system[k] = system[k] / system[k, k]
            others = np.arange(2 * n) != k
            system[others] = system[others] - np.outer(system[others, k], system[k])
        real, imaginary = (C @ part for part in np.split(system[:, -1], 2)) if n else (0 * D[0], 0 * D[0])
    return complex(float(real[0] + D[0, 0]), float(imaginary[0]))


def direct(zeros: ArrayLike, poles: ArrayLike, gain: float, s: complex) -> complex:
    return complex(gain * np.prod(s - np.asarray(zeros, complex)) / np.prod(s - np.asarray(poles, complex)))


def random_block(seed: int, inputs: int = 2, outputs: int = 3, states: int = 4) -> Block:
    draw = np.random.default_rng(seed).normal
    A = draw(size=(states, states)) - 4.0 * np.eye(states)
    return Block(A, draw(size=(states, inputs)), draw(size=(outputs, states)), draw(size=(outputs, inputs)))


# --- filters ------------------------------------------------------------------------------------------------------

CORNERS = st.floats(0.02, 3000.0).map(lambda hertz: 2 * np.pi * hertz)
REAL = CORNERS.map(lambda corner: [complex(-corner)])
COMPLEX = st.tuples(CORNERS, st.floats(0.05, 0.99)).map(lambda both: list(pair(both[0] / (2 * np.pi), both[1])))
ROOTS = st.lists(st.one_of(REAL, COMPLEX), max_size=5).map(lambda groups: [root for group in groups for root in group])


@settings(max_examples=150)
@given(ROOTS, ROOTS, st.floats(-1e3, 1e3).filter(lambda gain: abs(gain) > 1e-3), CORNERS)
def test_a_filter_is_the_product_of_its_zeros_and_poles(
    zeros: list[complex], poles: list[complex], gain: float, omega: float
) -> None:
    if len(zeros) > len(poles):
        zeros, poles = poles, zeros
    block = Block.filter(zeros, poles, gain)
    found, expected = in_many_digits(block, omega), direct(zeros, poles, gain, 1j * omega)
    # Every entry is rounded: what that does to the response, to first order and at worst.
    A, B, C, D = (np.abs(part) for part in block)
    inverse = np.abs(np.linalg.inv(1j * omega * np.eye(A.shape[0]) - block.A))
    rounded = (C @ inverse @ (2.0 * B + A @ inverse @ B) + D)[0, 0]
    assert abs(found - expected) <= 1e-14 * (rounded + abs(expected))


def test_a_long_filter_from_millihertz_to_kilohertz_keeps_its_digits() -> None:
    corners = 2 * np.pi * np.geomspace(0.001, 5000.0, 14)
    zeros, poles = -corners[::2], -corners[1::2]
    block = Block.filter(zeros, poles, 2.0)
    for omega in 2 * np.pi * np.geomspace(0.0005, 1e4, 30):
        assert at(block, 1j * omega)[0, 0] == pytest.approx(direct(zeros, poles, 2.0, 1j * omega), rel=1e-9)
    # As one polynomial the coefficients span 26 decades; in sections no entry exceeds the fastest corner twice over.
    assert max(np.abs(part).max() for part in block[:3]) <= 2 * corners.max()


@pytest.mark.parametrize("poles", [[0.0], [0.0, -3.0], [0.0, 0.0, -1e3]])
def test_a_filter_may_integrate(poles: list[float]) -> None:
    block = Block.filter([], poles, 7.0)
    assert np.abs(at(block, 2j)[0, 0] - direct([], poles, 7.0, 2j)) < 1e-12


def test_a_filter_without_roots_is_its_gain() -> None:
    assert np.array_equal(Block.filter([], [], -3.0).D, [[-3.0]])
    assert Block.filter([], [], -3.0).A.shape == (0, 0)


def test_more_zeros_than_poles_are_refused() -> None:
    with pytest.raises(ValueError, match=r"2 zeros and 1 poles; it must have at most as many zeros"):
        Block.filter([-1.0, -2.0], [-3.0], 1.0)


@pytest.mark.parametrize("which", ["zeros", "poles"])
def test_a_complex_root_without_its_conjugate_is_refused(which: str) -> None:
    roots = {"zeros": [-1.0, -2.0], "poles": [-3.0, -4.0], which: [-1.0 + 1j, -2.0]}
    with pytest.raises(ValueError, match="with their conjugates"):
        Block.filter(roots["zeros"], roots["poles"], 1.0)


def test_a_pair_has_the_frequency_and_damping_asked_for() -> None:
    roots = pair(50.0, 0.2)
    np.testing.assert_allclose(np.abs(roots), 2 * np.pi * 50.0, rtol=1e-13)
    np.testing.assert_allclose(-roots.real / np.abs(roots), 0.2, rtol=1e-13)


# --- algebra ------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("s", POINTS)
def test_blocks_join_as_their_responses_do(s: complex) -> None:
    one, other = random_block(1, 2, 3), random_block(2, 3, 2)
    same = random_block(3, 2, 3, states=2)
    draw = np.random.default_rng(4).normal
    before, after = draw(size=(2, 5)), draw(size=(4, 3))
    g, h, k = at(one, s), at(other, s), at(same, s)
    zeros = np.zeros((3, 4))
    expected = {
        "then": (one.then(other), h @ g),
        "times": (one.times(-0.3), -0.3 * g),
        "between": (one.between(before, after), after @ g @ before),
        "padded": (one.padded(1, 3), np.hstack([zeros[:, :1], g, zeros[:, :3]])),
        "inserted": (one.inserted(1, 4), np.hstack([g[:, :1], zeros, g[:, 1:]])),
        "inserted at the end": (one.inserted(2, 4), np.hstack([g, zeros])),
        "beside": (
            beside([one, other]),
            np.block([[g, np.zeros((3, 3))], [np.zeros((2, 2)), h]]),
        ),
        "added": (added([one, same]), g + k),
        "joined": (joined([one, same]), np.hstack([g, k])),
    }
    for name, (block, response) in expected.items():
        np.testing.assert_allclose(at(block, s), response, rtol=0, atol=1e-12 * np.abs(response).max(), err_msg=name)


def test_gains_join_without_states() -> None:
    gain = Block.gain([[1.0, 2.0]])
    assert gain.then(Block.gain([[3.0]])).D.tolist() == [[3.0, 6.0]]
    assert joined([gain, Block.gain([[5.0]])]).D.tolist() == [[1.0, 2.0, 5.0]]
    assert beside([gain, gain]).D.tolist() == [[1.0, 2.0, 0.0, 0.0], [0.0, 0.0, 1.0, 2.0]]
    assert gain.sampled(1e-3).D.tolist() == gain.held(1e-3).D.tolist() == [[1.0, 2.0]]


# --- sampling -----------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("hertz", [1.0, 80.0, 400.0])
def test_sampling_is_the_bilinear_transform(hertz: float) -> None:
    period, block = 1e-3, random_block(5).times(0.5)
    z = np.exp(2j * np.pi * hertz * period)
    expected = at(block, 2.0 / period * (z - 1.0) / (z + 1.0))
    np.testing.assert_allclose(at(block.sampled(period), z), expected, rtol=1e-12)


def test_sampling_and_joining_may_change_places() -> None:
    one, other, period = random_block(6, 2, 3), random_block(7, 3, 2), 1e-3
    z = np.exp(0.4j)
    first, last = one.then(other).sampled(period), one.sampled(period).then(other.sampled(period))
    np.testing.assert_allclose(at(first, z), at(last, z), rtol=1e-11)


def test_a_held_input_is_scipys_zero_order_hold() -> None:
    block = random_block(8)
    found = block.held(0.05)
    expected = signal.cont2discrete(tuple(block), 0.05, "zoh")
    for own, theirs in zip(found, expected, strict=False):
        np.testing.assert_allclose(own, theirs, rtol=0, atol=1e-13)


def test_what_does_not_answer_at_once_still_does_not_when_held() -> None:
    assert not np.any(Block.filter([], [-3.0, -5.0], 15.0).held(0.1).D)
