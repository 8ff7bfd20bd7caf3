"""What is wrong with a channel by itself is found, and what is only slow, noisy or quantised is not."""

import numpy as np
import pytest

from ehamj.arrays import Array
from ehamj.measured.alike import likeness
from ehamj.measured.doubts import clipped_share, faults, hum, resolution

RATE = 1000.0
TIME = np.arange(0.0, 8.0, 1.0 / RATE)
RANDOM = np.random.default_rng(11)
NOISE = RANDOM.standard_normal(TIME.size)
BIT = 1.0 / 32768


def bits(samples: Array) -> Array:
    return np.round(samples / BIT) * BIT


def swing(frequency: float, phase: float, noise: float) -> Array:
    return bits(0.7 * np.sin(2 * np.pi * frequency * TIME + phase) + noise * NOISE)


SOUND = {
    **{f"{f:g} Hz, {p:g}, {n:g}": swing(f, p, n) for f in (0.13, 1.0, 7.3) for p in (0.0, 0.4) for n in (0.0, 0.002)},
    "step": bits(1.0 - np.exp(-TIME * 40.0)),
    "noise": NOISE,
    "exact sine": np.sin(2 * np.pi * 0.1 * TIME),
}


@pytest.mark.parametrize("what", SOUND)
def test_a_sound_channel_is_sound(what: str) -> None:
    found = [fault.word for fault in faults(SOUND[what])]
    assert found == (["clipped"] if what == "step" else [])  # which stands at its end: that must be accepted


def test_what_is_wrong_is_named() -> None:
    sine = np.sin(2 * np.pi * 1.0 * TIME)
    cut = np.clip(1.1 * sine + 0.01 * NOISE, -1.0, 1.0)
    for clipped in (cut, bits(cut), np.minimum(bits(0.8 * sine + 0.02 * NOISE), 0.8)):
        assert [fault.word for fault in faults(clipped)] == ["clipped"]
    few = np.round(20.0 * (sine + 0.4 * np.sin(2 * np.pi * 3.7 * TIME + 1.0)) + 0.3 * NOISE)
    assert faults(few) == []
    assert [fault.word for fault in faults(np.minimum(few, 22.0))] == ["clipped"]
    exact = np.mean(np.abs(cut) == 1.0)
    assert clipped_share(cut) == pytest.approx(exact)
    assert [fault.word for fault in faults(np.full(TIME.size, 0.3))] == ["dead"]
    assert [fault.word for fault in faults(bits(0.4 * BIT * NOISE))] == ["coarse"]


def test_the_converters_step_is_found() -> None:
    assert resolution(bits(0.5 * NOISE)) == pytest.approx(BIT, rel=1e-9)
    assert resolution(1e5 * np.array([float(f"{one:.8g}") for one in bits(0.2 * NOISE)])) == pytest.approx(
        1e5 * BIT, rel=1e-5
    )
    assert resolution(NOISE) is None


def test_hum_is_a_line_of_the_mains_alone() -> None:
    for mains in (50.0, 60.0):
        assert hum(NOISE + 0.3 * np.sin(2 * np.pi * (mains + 0.03) * TIME), RATE) == mains
    assert hum(NOISE, RATE) is None
    assert hum(NOISE + np.sin(2 * np.pi * 53.0 * TIME), RATE) is None


@pytest.mark.parametrize(("gain", "delay"), [(1.0, 0.0), (-9.81, 0.0123), (1e-3, -0.0308)])
def test_what_leads_from_one_signal_to_another_is_found(gain: float, delay: float) -> None:
    """Band-limited noise, delayed by a fraction of a sample by its Fourier transform."""
    spectrum = np.fft.rfft(NOISE) * (np.fft.rfftfreq(NOISE.size, 1 / RATE) < 60.0)
    turn = np.exp(-2j * np.pi * np.fft.rfftfreq(NOISE.size, 1 / RATE) * delay)
    one, other = np.fft.irfft(spectrum), gain * np.fft.irfft(spectrum * turn) + 4.0
    other = other + 0.1 * other.std() * RANDOM.standard_normal(other.size)
    found = likeness(one, other, RATE, 0.05)
    assert found.gain == pytest.approx(gain, rel=0.02)
    assert found.delay == pytest.approx(delay, abs=2e-4)
    assert 0.97 < found.correlation <= 1.0
    assert likeness(one, np.full(one.size, 2.0), RATE, 0.05).correlation == 0.0
