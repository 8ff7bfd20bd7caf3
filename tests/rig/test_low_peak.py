"""Multisines of low peak against numbers of the literature, and signals that share no line."""

from typing import get_args

import numpy as np
import pytest

from ehamj.errors import InputError
from ehamj.rig.low_peak import LowPeak, Spacing, low_peak, zippered
from ehamj.scenario.load import parse_scenario


def peak_over_rms(signal: LowPeak) -> float:
    """From the definition: 50 samples to a period of the highest line, one by one."""
    time = np.linspace(0.0, signal.period, 50 * int(signal.harmonics[-1]), endpoint=False)
    values = sum(
        a * np.sin(2.0 * np.pi * f * time + p)
        for a, f, p in zip(signal.amplitudes, signal.frequencies, signal.phases, strict=True)
    )
    return float(np.abs(values).max() / np.sqrt(np.mean(values**2)))


@pytest.mark.parametrize("first", [1, 10])
def test_thirty_lines_have_a_crest_factor_below_one_and_a_half(first: int) -> None:
    """Van der Ouderaa, Schoukens & Renneboog (1988) come to 1.4 to 1.5; Schroeder's phases have 1.7 and more."""
    found = low_peak(2.0, np.arange(first, first + 30))
    assert peak_over_rms(found) < 1.5
    assert found.crest_factor == pytest.approx(peak_over_rms(found), rel=3e-3)
    schroeder = LowPeak(2.0, found.harmonics, found.amplitudes, -np.pi * np.arange(30) * np.arange(1, 31) / 30)
    assert peak_over_rms(schroeder) > 1.65


def test_stated_amplitudes_stay_and_the_peak_is_their_sum_s() -> None:
    amplitudes = np.array([3.0, 1.0, 0.5, 2.0])
    found = low_peak(1.0, [2, 3, 5, 9], amplitudes)
    np.testing.assert_array_equal(found.amplitudes, amplitudes)
    assert found.scaled(2.0).peak == pytest.approx(2.0 * found.peak)
    assert low_peak(1.0, [4]).crest_factor == pytest.approx(np.sqrt(2.0), rel=1e-2)


@pytest.mark.parametrize("spacing", get_args(Spacing))
def test_zippered_signals_are_orthogonal_over_a_period_and_fill_the_band(spacing: Spacing) -> None:
    dealt = zippered(2.0, 40.0, 1.5, 10, 3, spacing)
    time = np.arange(3000) / 2000.0
    signals = np.array([low_peak(1.5, own, seed=k).signal().sample(time).value for k, own in enumerate(dealt)])
    products = signals @ signals.T / time.size
    np.testing.assert_allclose(products, np.diag(np.diagonal(products)), atol=1e-9)
    lines = np.concatenate(dealt) / 1.5
    assert len(set(lines)) == lines.size
    assert 2.0 <= lines.min() < lines.max() <= 40.0
    assert min(np.ptp(own) for own in dealt) > 0.7 * 38.0 * 1.5  # each of them reaches from end to end


def test_a_scenario_plays_the_designed_signal() -> None:
    found = low_peak(1.0, np.arange(3, 20)).scaled(0.3)
    table = {"control": {"kind": "open-loop", "signals": [found.command(["front-left"])]}}
    played, other = parse_scenario(table).commands()[:2]
    time = np.linspace(0.0, 2.0, 777)
    np.testing.assert_allclose(played.sample(time).value, found.signal().sample(time).value, atol=1e-5)
    assert not other.sample(time).value.any()


def test_a_band_that_is_too_narrow_and_lines_that_are_none_are_refused() -> None:
    with pytest.raises(InputError, match=r"band = \[10, 11\] Hz: has 2 lines .* 4 signals need one each"):
        zippered(10.0, 11.0, 1.0, 5, 4)
    with pytest.raises(InputError, match="harmonics"):
        low_peak(1.0, [3, 3])
