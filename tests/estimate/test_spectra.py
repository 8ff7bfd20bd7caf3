"""Estimators, coherence and confidence against SciPy, closed forms and the coverage of their own circles."""

import numpy as np
import pytest
from scipy import signal

from ehamj.errors import InputError
from ehamj.estimate.spectra import ESTIMATORS, Spectra, estimate, independent_averages

RATE = 1000.0
FILTERS = (np.array([0.5, 0.3, -0.2, 0.1]), np.array([0.0, 1.0]), np.array([2.0]))


def plant(noise: float, n: int = 60_000) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Inputs (time, 2), outputs (time, 2) of a known filter with noise added to the outputs, and white inputs."""
    random = np.random.default_rng(5)
    x = random.standard_normal((n, 2))
    first = signal.lfilter(FILTERS[0], 1, x[:, 0]) + signal.lfilter(FILTERS[1], 1, x[:, 1])
    y = np.column_stack([first, signal.lfilter(FILTERS[2], 1, x[:, 1])])
    return x, y + noise * random.standard_normal(y.shape), random.standard_normal((n, 2))


def truth(frequency: np.ndarray) -> np.ndarray:
    """The filter's response (f, 2, 2)."""
    (_, a), (_, b), (_, c) = (signal.freqz(taps, worN=frequency, fs=RATE) for taps in FILTERS)
    return np.array([[a, b], [np.zeros_like(c), c]]).transpose(2, 0, 1)


def test_one_input_is_scipys_csd_and_coherence() -> None:
    x, y, _ = plant(0.3)
    found = estimate(Spectra.welch(x[:, :1], y[:, :1], RATE, 0.5))
    settings = {"nperseg": 500, "detrend": "constant"}
    f, cross = signal.csd(x[:, 0], y[:, 0], RATE, **settings)
    _, own = signal.welch(x[:, 0], RATE, **settings)
    _, coherence = signal.coherence(x[:, 0], y[:, 0], RATE, **settings)
    np.testing.assert_allclose(found.frequency, f[1:])
    np.testing.assert_allclose(found.response[:, 0, 0], (cross / own)[1:], rtol=1e-9)
    np.testing.assert_allclose(found.ordinary[:, 0, 0], coherence[1:], rtol=1e-9)
    np.testing.assert_allclose(found.multiple[:, 0], coherence[1:], rtol=1e-9)


@pytest.mark.parametrize("estimator", ESTIMATORS)
def test_without_noise_every_estimator_finds_the_matrix(estimator: str) -> None:
    # Exact lines of an exact matrix: 1e-6 is the rounding that Hv's null vector takes the root of.
    random = np.random.default_rng(1)
    x = random.standard_normal((9, 40, 2)) + 1j * random.standard_normal((9, 40, 2))
    matrix = random.standard_normal((40, 2, 2)) + 1j * random.standard_normal((40, 2, 2))
    found = estimate(Spectra.of_lines(np.arange(1.0, 41.0), x, np.einsum("fpq,nfq->nfp", matrix, x)), estimator)  # type: ignore[arg-type]
    np.testing.assert_allclose(found.response, matrix, atol=1e-6)
    np.testing.assert_allclose(found.multiple, 1.0, rtol=1e-12)


def test_units_of_the_channels_play_no_part() -> None:
    x, y, _ = plant(0.3, 8000)
    units = np.array([1e-9, 1e3])
    for name in ESTIMATORS:
        plain = estimate(Spectra.welch(x, y, RATE, 0.5), name)  # type: ignore[arg-type]
        scaled = estimate(Spectra.welch(x, units * y, RATE, 0.5), name)  # type: ignore[arg-type]
        np.testing.assert_allclose(scaled.response, units[:, None] * plain.response, rtol=1e-6)
        np.testing.assert_allclose(scaled.radius, units[:, None] * plain.radius, rtol=1e-6)


def test_each_estimator_is_for_its_noise() -> None:
    """Noise of half the signal's power: on the output it biases H2 by 3/2, on the input H1 by 2/3; Hv = √(H1 H2)."""
    random = np.random.default_rng(2)
    n, half = 100_000, np.sqrt(0.5)
    x = random.standard_normal((n, 1))
    noise = half * random.standard_normal((n, 1))
    level = {}
    for where, (a, b) in {"output": (x, x + noise), "input": (x + noise, x)}.items():
        for name in ESTIMATORS:
            found = estimate(Spectra.welch(a, b, RATE, 0.1), name)  # type: ignore[arg-type]
            level[where, name] = float(np.abs(found.response).mean())
    # 2000 averages of 50 lines: the mean is certain to about 3e-3.
    assert level["output", "h1"] == pytest.approx(1.0, abs=0.01)
    assert level["output", "h2"] == pytest.approx(1.5, abs=0.01)
    assert level["input", "h1"] == pytest.approx(2 / 3, abs=0.01)
    assert level["input", "h2"] == pytest.approx(1.0, abs=0.01)
    for where in ("output", "input"):
        assert level[where, "hv"] == pytest.approx(np.sqrt(level[where, "h1"] * level[where, "h2"]), rel=1e-4)


@pytest.mark.parametrize("confidence", [0.5, 0.95])
def test_circles_cover_the_truth_as_often_as_they_say(confidence: float) -> None:
    x, y, _ = plant(0.5)
    found = estimate(Spectra.welch(x, y, RATE, 0.25), confidence=confidence)
    inside = np.abs(found.response - truth(found.frequency)) < found.radius
    # 500 nearly independent circles: three deviations of a share of one half are 0.07.
    assert inside.mean() == pytest.approx(confidence, abs=0.05)


def test_circles_of_merged_lines_cover_too() -> None:
    x, y, _ = plant(0.5, 240_000)
    merged = Spectra.welch(x, y, RATE, 1.0).merged(24.0)
    assert (np.diff(merged.averages) > -1e-9).all() or merged.averages[-1] > 5 * merged.averages[0]
    found = estimate(merged)
    inside = np.abs(found.response - truth(found.frequency)) < found.radius
    assert inside[:, 1].mean() == pytest.approx(0.95, abs=0.05)  # constant over frequency, so that bins have no bias


def test_the_radius_is_bendat_and_piersols_random_error() -> None:
    """Many averages, one input: r/|H| = √(2 · 2.996) ε with ε² = (1 − γ²)/(2 γ² n), their eq. 9.90."""
    x, y, _ = plant(0.3, 400_000)
    spectra = Spectra.welch(x[:, 1:], y[:, 1:], RATE, 0.1)
    found = estimate(spectra)
    coherence = found.multiple[:, 0]
    error = np.sqrt((1 - coherence) / (2 * coherence * spectra.averages))
    expected = np.sqrt(-2 * np.log(0.05)) * error
    # Fisher's distribution with 15000 degrees of freedom: within 1e-3 of its limit.
    np.testing.assert_allclose(found.radius[:, 0, 0] / np.abs(found.response[:, 0, 0]), expected, rtol=2e-3)


def test_overlapping_segments_count_less() -> None:
    """Hann at half overlap: neighbours share (1/6)² of their power, so that many are worth 1/(1 + 2/36) each."""
    window = signal.get_window("hann", 1000)
    assert independent_averages(window, 500, 1) == 1.0
    assert independent_averages(window, 500, 100_000) == pytest.approx(100_000 / (1 + 2 / 36), rel=1e-4)
    assert independent_averages(window, 1000, 30) == 30.0


def test_inputs_that_cannot_be_told_apart_give_nothing() -> None:
    x, y, _ = plant(0.1, 8000)
    copied = np.column_stack([x[:, 0], 3.0 * x[:, 0]])
    for name in ESTIMATORS:
        found = estimate(Spectra.welch(copied, y, RATE, 0.5), name)  # type: ignore[arg-type]
        assert np.isnan(found.response).all()
        assert np.isnan(found.multiple).all()
    resting = estimate(Spectra.welch(np.column_stack([x[:, 0], 0.0 * x[:, 0]]), y, RATE, 0.5))
    assert np.isnan(resting.response).all()


def test_what_cannot_be_estimated_is_refused() -> None:
    x, y, _ = plant(0.1, 2000)
    with pytest.raises(
        InputError, match=r"segment = 1\.5 s: must be at least 0.016 s .* at most half of the record, 1 s"
    ):
        Spectra.welch(x, y, RATE, 1.5)
    spectra = Spectra.welch(x, y, RATE, 0.5)
    with pytest.raises(InputError, match="estimator = 'h3': must be one of h1, h2, hv"):
        estimate(spectra, "h3")  # type: ignore[arg-type]
    with pytest.raises(InputError, match="as many outputs as inputs; these are 1 and 2"):
        estimate(Spectra.welch(x, y[:, :1], RATE, 0.5), "h2")
