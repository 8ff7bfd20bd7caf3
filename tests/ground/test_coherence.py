"""Partial coherence between mounts: the factor of the matrix, averages over realisations, delays, consistency."""

from itertools import combinations
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from ehamj.errors import InputError
from ehamj.ground import Motion
from ehamj.ground.waves import Coherence
from ehamj.scenario.load import parse_scenario

MOUNTS = np.array([(0.9, 0.6), (0.9, -0.6), (-0.9, 0.6), (-0.9, -0.6)])
REALISATIONS = 20
DURATION, RATE = 10.0, 250.0
NODES, WEIGHTS = np.polynomial.legendre.leggauss(4)


def floor(seed: int = 0, duration: float = DURATION, **ground: Any) -> Motion:
    table = {"kind": "broadband", "level": 20e-6, "last": 100.0, "highest": 124.0, "fade_in": 0.0, **ground}
    return parse_scenario({"duration": duration, "seed": seed, "ground": table}).motion()


def luco_wong(frequency: np.ndarray, distance: float, gamma: float, speed: float) -> np.ndarray:
    return np.exp(-((gamma * 2 * np.pi * frequency * distance / speed) ** 2))


# --- the factor ---------------------------------------------------------------------------------------------------

places = st.tuples(*(st.tuples(st.floats(-2.0, 2.0), st.floats(-2.0, 2.0)) for _ in range(4))).map(np.array)


@given(places, st.floats(0.0, 5.0), st.floats(20.0, 5000.0), st.floats(0.0, 500.0))
def test_the_factor_squared_is_the_coherency_matrix(
    positions: np.ndarray, gamma: float, speed: float, frequency: float
) -> None:
    factor = Coherence(gamma=gamma, shear_speed=speed).factor(np.array([frequency]), positions)[0]
    distance = np.hypot(*(positions[:, None] - positions).transpose(2, 0, 1))
    # Rounding of four unit eigenvalues; also where the matrix is singular, as with mounts in one place.
    np.testing.assert_allclose(factor @ factor.T, luco_wong(frequency, distance, gamma, speed), rtol=0, atol=1e-14)


def test_mounts_that_are_fully_coherent_take_one_set_of_lines() -> None:
    factor = Coherence(gamma=0.0).factor(np.array([50.0]), MOUNTS)[0]
    np.testing.assert_allclose(factor, [[0.0, 0.0, 0.0, 1.0]] * 4, rtol=0, atol=1e-7)  # roots of rounding


# --- floors -------------------------------------------------------------------------------------------------------


def cross_spectra(axis: int, **ground: Any) -> tuple[np.ndarray, np.ndarray]:
    """Frequencies [Hz] and the mounts' spectra over the floor's period, (realisation, mount, frequency)."""
    n = round(DURATION * RATE)
    times = np.arange(n) / RATE
    spectra = [
        np.fft.rfft(floor(seed, **ground).sample(times).displacement[:, :, axis], axis=0).T
        for seed in range(REALISATIONS)
    ]
    return np.arange(n // 2 + 1) / DURATION, np.array(spectra)


@pytest.mark.parametrize(("axis", "gamma", "speed"), [(2, 0.2, 200.0), (0, 0.5, 150.0)])
def test_coherency_averaged_over_realisations_is_luco_wongs_with_the_waves_delay(
    axis: int, gamma: float, speed: float
) -> None:
    ground = {"axes": ["xyz"[axis]], "coherence": {"gamma": gamma, "shear_speed": speed}}
    wave = {"speed": 220.0, "direction": 20.0}
    frequency, spectra = cross_spectra(axis, wave=wave, **ground)
    delays = MOUNTS @ [np.cos(np.radians(20.0)), np.sin(np.radians(20.0))] / 220.0
    for low in range(5, 105, 10):
        part = (frequency >= low) & (frequency < low + 10)
        for i, j in combinations(range(4), 2):
            turned = np.exp(2j * np.pi * frequency * (delays[i] - delays[j]))  # undoes the wave's phase
            cross = (spectra[:, i] * spectra[:, j].conj() * turned)[:, part].sum()
            powers = [(np.abs(spectra[:, k, part]) ** 2).sum() for k in (i, j)]
            found = cross / np.sqrt(powers[0] * powers[1])
            distance = np.hypot(*(MOUNTS[i] - MOUNTS[j]))
            weight = (np.abs(spectra[:, i, part]) ** 2).mean(axis=0)
            wanted = np.average(luco_wong(frequency[part], distance, gamma, speed), weights=weight)
            # 20 realisations of 100 lines: 1/√4000 of scatter per part, of which there are 60 pairs and bands.
            assert abs(found) == pytest.approx(wanted, abs=0.05)
            assert found.real == pytest.approx(wanted, abs=0.05)  # so the phase is the wave's
            assert found.imag == pytest.approx(0.0, abs=0.05)


def test_the_stated_defaults_are_luco_wongs_and_the_soil_of_the_documents() -> None:
    stated = Coherence()
    assert (stated.gamma, stated.shear_speed) == (0.2, 200.0)
    # 2 m at 80 Hz: (0.2 · 2π · 80 · 2/200)² = 1.0106.
    assert stated.magnitude(np.array(80.0), np.array(2.0)) == pytest.approx(np.exp(-1.01065), rel=1e-4)


@pytest.mark.parametrize("coherence", [None, {}])
@pytest.mark.parametrize("speed", [100.0, 200.0, 450.0])
def test_the_waves_delay_is_met_to_a_sample(coherence: dict[str, Any] | None, speed: float) -> None:
    options = {} if coherence is None else {"coherence": coherence}
    rate = 1000.0
    motion = floor(duration=20.0, wave={"speed": speed}, **options)
    rear, front = motion.sample(np.arange(20_000) / rate).velocity[:, [2, 0], 2].T
    likeness = np.fft.irfft(np.fft.rfft(front) * np.fft.rfft(rear).conj())
    found = (int(np.argmax(likeness)) + 10_000) % 20_000 - 10_000
    # The nearest sample to the delay; partly incoherent mounts may be most alike one sample beside it.
    assert abs(found - 1.8 / speed * rate) <= (0.5 + 1e-9 if coherence is None else 1.0)


def test_mounts_differ_and_axes_are_independent() -> None:
    velocity = floor(axes=["x", "y", "z"], coherence={"gamma": 0.5}).sample(np.arange(5000) / 500.0).velocity
    alike = np.corrcoef(velocity.reshape(5000, 12).T)
    mounts, axes = np.divmod(np.arange(12), 3)
    same_axis = axes[:, None] == axes
    assert alike[same_axis & (mounts[:, None] != mounts)].max() < 0.95
    assert np.abs(alike[~same_axis]).max() < 0.3  # chance in the few lines at 1 Hz, as for a slab


def test_without_incoherence_the_floor_is_the_one_without_the_key() -> None:
    times = np.arange(1000) / 100.0
    wave = {"wave": {"speed": 200.0}}
    one = floor(**wave).sample(times).velocity
    other = floor(coherence={"gamma": 0.0}, **wave).sample(times).velocity
    # Eigenvalues of 1e-16 leave 1e-8 of the other sets of lines.
    np.testing.assert_allclose(other, one, rtol=0, atol=1e-6 * np.abs(one).max())


@pytest.mark.parametrize("begin", [0.0, 0.3, 4.1])
def test_displacement_velocity_and_acceleration_belong_together(begin: float) -> None:
    motion = floor(axes=["x", "y", "z"], coherence={}, wave={"direction": 40.0}, fade_in=0.5)
    cells, width = 10_000, 1e-4
    edges = begin + np.arange(cells + 1) * width
    inside = (edges[:-1, None] + 0.5 * width * (1 + NODES)).ravel()
    ends, between = motion.sample(edges), motion.sample(inside)
    for value, slope in zip(ends[:2], between[1:], strict=True):
        each = 0.5 * width * np.einsum("k,ck...->c...", WEIGHTS, slope.reshape(cells, NODES.size, 4, 3))
        moved = value - value[0]
        # Over a second; what is left is Gauss over the knots of the quintics between samples.
        assert np.abs(np.cumsum(each, axis=0) - moved[1:]).max() <= 1e-6 * np.abs(moved).max()


def test_the_floor_says_what_its_coherence_is() -> None:
    note = next(note for note in floor(coherence={}).notes if "Luco-Wong" in note)
    assert "γ = 0.2, V_s = 200 m/s" in note
    assert "2.16 m, it is 0.98 at 10 Hz, 0.63 at 50 Hz, 0.31 at 80 Hz" in note


@pytest.mark.parametrize(
    ("coherence", "message"),
    [
        ({"gamma": -0.1}, r"ground\.coherence\.gamma = -0\.1: must be greater than or equal to 0"),
        ({"shear_speed": 0.0}, r"ground\.coherence\.shear_speed = 0\.0: must be greater than 0"),
        ({"gama": 0.2}, r"ground\.coherence\.gama = 0\.2: unknown key; did you mean 'gamma'\? allowed: gamma, shear_"),
        (True, r"ground\.coherence = True: must be a table"),
    ],
)
def test_bad_input_is_named(coherence: Any, message: str) -> None:
    with pytest.raises(InputError, match=f"^{message}"):
        parse_scenario({"ground": {"kind": "broadband", "coherence": coherence}})
