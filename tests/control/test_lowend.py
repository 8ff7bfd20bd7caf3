"""Where isolation begins: how much of the floor the machine follows, and what that saves."""

import numpy as np
import pytest
from numpy.typing import NDArray

from ehamj.control.blocks import Block
from ehamj.control.inverse import Inverse
from ehamj.control.lowend import isolating, yielding
from ehamj.estimate.bands import bands
from ehamj.ground.broadband import BroadbandGround
from ehamj.scenario.load import parse_scenario

Complex = NDArray[np.complex128]

FROM = (0.5, 5.0, 12.0)


def response(block: Block, hertz: NDArray[np.float64]) -> Complex:
    A, B, C, D = block
    return np.array([(C @ np.linalg.solve(2j * np.pi * f * np.eye(A.shape[0]) - A, B) + D)[0, 0] for f in hertz])


@pytest.mark.parametrize("begin", FROM)
def test_what_is_followed_and_what_is_isolated_are_the_whole(begin: float) -> None:
    hertz = begin * np.geomspace(0.01, 100.0, 50)
    total = response(yielding(begin), hertz) + response(isolating(begin), hertz)
    np.testing.assert_allclose(total, 1.0, rtol=0, atol=1e-12)


@pytest.mark.parametrize("begin", FROM)
def test_the_curve_moves_with_the_frequency_asked_for(begin: float) -> None:
    share = np.geomspace(0.01, 100.0, 50)
    np.testing.assert_allclose(
        response(yielding(begin), begin * share), response(yielding(1.0), share), rtol=0, atol=1e-11
    )


@pytest.mark.parametrize("begin", FROM)
def test_from_there_on_the_machine_follows_by_at_most_27_db(begin: float) -> None:
    followed = np.abs(response(yielding(begin), begin * np.geomspace(1.0, 200.0, 2000)))
    assert 20 * np.log10(followed.max()) < -26.8  # stated as 27


def test_no_band_is_amplified() -> None:
    for band in bands(0.1, 400.0):
        inside = np.geomspace(*band.edges, 100)
        assert np.mean(np.abs(response(yielding(5.0), inside)) ** 2) <= 1.0, band.name


def test_far_below_the_command_asked_for_is_at_most_four_fifths() -> None:
    wanted = np.abs(response(isolating(5.0), np.geomspace(0.01, 0.9, 300)))
    assert wanted.max() <= 0.8


def test_it_saves_more_than_a_third_of_the_voltage_on_a_vc_a_floor() -> None:
    f = np.geomspace(0.05, 500.0, 2000)
    inverse = Inverse.of(parse_scenario({}).plant.actuators[0])
    volts = np.abs(inverse.volts * (1 + inverse.creep / (2j * np.pi * f))) ** 2
    floor = BroadbandGround(kind="broadband", level="VC-A").spectrum(f)
    share = np.abs(response(isolating(5.0), f)) ** 2
    full, saved = (float(np.sqrt(np.trapezoid(volts * floor * part, f))) for part in (1.0, share))
    assert (full, saved) == pytest.approx((5.9, 3.7), abs=0.06)  # as the module states them
