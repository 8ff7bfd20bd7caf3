"""The blended measurement returns the true displacement, and the loop is the one that is stated."""

import numpy as np
import pytest
from numpy.typing import NDArray

from ehamj.control.blocks import Block
from ehamj.control.inertial import LEAK, Blend, MotionLoop
from ehamj.control.instruments import Geophone
from ehamj.control.lowend import yielding
from ehamj.errors import InputError

Complex = NDArray[np.complex128]

HERTZ = np.array([0.01, 0.05, 0.15, 1.0, 8.0, 60.0, 300.0])
GEOPHONE = Geophone(kind="geophone", low=0.1, high=1000.0)
SHARP = Geophone(kind="geophone", low=0.3, high=np.inf)


def response(block: Block, f: float) -> Complex:
    A, B, C, D = block
    return np.asarray(C @ np.linalg.solve(2j * np.pi * f * np.eye(A.shape[0]) - A, B) + D)


def blended(blend: Blend, f: float, foot: Geophone | None, ground: Geophone | None, x: complex, floor: complex,
            isolate_from: float = 0.0) -> complex:  # fmt: skip
    """What the blend makes of a machine that moves by x over a floor that moves by ``floor``, as instruments see it."""
    s = 2j * np.pi * f
    seen = [one.response(np.array([f]))[0] if one else 1.0 for one in (foot, ground)]
    readings = np.array([s * x * seen[0], x - floor, s * floor * seen[1]])
    return complex((response(blend.block(foot, ground, isolate_from), f) @ readings)[0])


@pytest.mark.parametrize("f", HERTZ)
@pytest.mark.parametrize("foot", [None, SHARP], ids=["ideal", "geophone"])
def test_over_a_floor_at_rest_the_blend_is_the_true_displacement(f: float, foot: Geophone | None) -> None:
    # An instrument's high-pass is taken back exactly: inertial share s³/(…) and stroke share add up to one.
    assert blended(Blend(), f, foot, None, 1.0, 0.0) == pytest.approx(1.0, abs=1e-11)


@pytest.mark.parametrize("f", HERTZ)
@pytest.mark.parametrize("corner", [0.08, 0.15, 1.0])
@pytest.mark.parametrize("ground", [None, GEOPHONE, SHARP], ids=["ideal", "geophone", "without low-pass"])
def test_over_a_moving_floor_only_what_the_ground_s_instrument_does_not_see_is_wrong(
    f: float, corner: float, ground: Geophone | None
) -> None:
    blend = Blend(corner=corner, restore=0.05)
    wrong = abs(blended(blend, f, None, ground, 0.7, 1.0) - 0.7)
    s = 1j * f
    stroke_share = 1 - s**3 / (s**3 + 2 * corner * s**2 + 2 * corner**2 * s + corner**3)
    seen = s / (s + 0.05)
    if ground is not None:  # its high-pass of second order moved to 0.05 Hz, its low-pass as it is
        below = np.array([0.05 * np.exp(1j * np.radians(angle)) for angle in (135.0, -135.0)])
        seen *= s**2 / np.prod(s - below)
        seen *= Geophone(kind="geophone", low=0.0, high=ground.high).response(np.array([f]))[0]
    assert wrong == pytest.approx(abs(stroke_share * (seen - 1)), abs=1e-9)


@pytest.mark.parametrize("f", [0.05, 1.0, 5.0, 30.0])
def test_isolation_from_a_frequency_on_counts_from_where_the_machine_is_to_follow(f: float) -> None:
    blend = Blend()
    whole, shifted = (blended(blend, f, None, None, 0.3, 1.0, begin) for begin in (0.0, 5.0))
    seen = 1j * f / (1j * f + blend.restore)
    assert whole - shifted == pytest.approx(complex(response(yielding(5.0), f)[0, 0]) * seen, abs=1e-10)


def test_an_inertial_instrument_of_a_high_order_is_refused() -> None:
    steep = Geophone(kind="geophone", order=3)
    with pytest.raises(InputError, match=r"sensors\.inertial\.order = 3: must be at most 2 for feedback"):
        Blend().block(steep, None)


# --- the loop -----------------------------------------------------------------------------------------------------

CREEP = 40.0


def loop(**given: float) -> MotionLoop:
    plain = {"crossing": 60.0, "integral": 0.0, "notch_depth": 1.0, "rolloff": 1e6}
    return MotionLoop.model_validate(plain | given)


@pytest.mark.parametrize("f", [1.0, 20.0, 300.0])
def test_a_bare_loop_is_a_gain_with_the_isolator_s_creep_taken_back(f: float) -> None:
    s, leak = 2j * np.pi * f, 2 * np.pi * LEAK
    # The roll-off at a megahertz turns 300 Hz by 3e-4.
    expected = -2 * np.pi * 60.0 * (s + CREEP) / (s + leak)
    assert response(loop().block(CREEP), f)[0, 0] == pytest.approx(expected, rel=5e-4)


@pytest.mark.parametrize("f", [1.0, 20.0, 300.0])
def test_each_element_multiplies_the_bare_loop(f: float) -> None:
    bare = response(loop().block(CREEP), f)[0, 0]
    s = 1j * f
    elements = {
        "integral": (loop(integral=12.0), (s + 12.0) / (s + LEAK)),
        "lead": (loop(lead=90.0), (1 + s / 90.0) / (1 + s / 720.0)),
        "notch": (
            loop(notch=200.0, notch_depth=0.3, notch_width=0.8),
            (s**2 + 2 * 0.24 * 200.0 * s + 200.0**2) / (s**2 + 2 * 0.8 * 200.0 * s + 200.0**2),
        ),
        "rolloff": (loop(rolloff=2000.0), (1 + s / 1e6) / (1 + s / 2000.0)),
        "crossing": (loop(crossing=120.0), 2.0),
    }
    for name, (other, factor) in elements.items():
        assert response(other.block(CREEP), f)[0, 0] / bare == pytest.approx(factor, rel=1e-9), name


def test_a_notch_is_as_deep_as_stated_in_its_centre() -> None:
    bare, notched = (response(loop(notch=200.0, notch_depth=d).block(CREEP), 200.0)[0, 0] for d in (1.0, 0.25))
    assert notched / bare == pytest.approx(0.25, rel=1e-9)
