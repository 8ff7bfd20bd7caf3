"""What chambers hold over time: the compiled kernels over arrays, down to a chamber that is all but empty."""

import numpy as np
import pytest

from ehamj.isolator.actuator import Actuator
from ehamj.isolator.chambers import held
from ehamj.isolator.fluid import ATMOSPHERE

V = 5.39e-4 / 2


def test_a_void_leaves_a_thousandth_of_the_oil() -> None:
    # −20 GPa of a state: e^(−20e9/1.4e9) = 6e-7 would be left without the floor of `filled_share`.
    found = held([Actuator()], np.full((1, 1, 2), -20e9), np.zeros((1, 1)))
    np.testing.assert_allclose(found.void, 0.999 * V, rtol=1e-12)
    np.testing.assert_allclose(found.mass, 1e-3 * V / np.exp(ATMOSPHERE / 1.4e9), rtol=1e-12)


def test_without_void_the_chambers_hold_what_their_volumes_hold() -> None:
    actuators = [Actuator(), Actuator(bulk_modulus=1e9, volume_share=0.6, area_ratio=0.9)]
    pressure, stroke = np.array([[[20e5, 50e5], [30e5, 40e5]]] * 3), np.array([[0.0, 0.0], [1e-3, 1e-3], [-1e-3, 2e-3]])
    found = held(actuators, pressure, stroke)
    assert np.all(found.void == 0.0)
    for mount, (beta, first, second, ratio) in enumerate([(1.4e9, V, V, 1.0), (1e9, 1.2 * V, 0.8 * V, 0.9)]):
        volumes = np.stack([first + 3.18e-2 * stroke[:, mount], second - ratio * 3.18e-2 * stroke[:, mount]], axis=-1)
        expected = volumes * np.exp((pressure[:, mount] - ATMOSPHERE) / beta)
        np.testing.assert_allclose(found.mass[:, mount], expected, rtol=1e-12)


@pytest.mark.parametrize("air", [0.0, 0.02])
def test_the_energy_is_what_compression_took(air: float) -> None:
    # dE = −p dV of a fixed mass, from atmosphere to 50 bar: by a fine sum over the mass's own volume.
    p = np.linspace(ATMOSPHERE, 50e5, 40001)
    one = held([Actuator(air_fraction=air)], np.repeat(p, 2).reshape(-1, 1, 2), np.zeros((p.size, 1)))
    mass = one.mass[:, 0, 0]
    volume = V / mass  # of a unit of mass, over that at atmosphere
    middle = 0.5 * (p[1:] + p[:-1])
    expected = -np.sum(middle * np.diff(volume))
    assert one.energy[-1, 0, 0] / mass[-1] == pytest.approx(expected, rel=1e-6)
