"""A command that is clipped in the second that decides is told of, and one that is clipped elsewhere is not."""

from typing import Any

import numpy as np
import pytest

from ehamj.result import Result
from ehamj.run.deciding import deciding
from ehamj.run.limits import binding
from ehamj.run.simulate import simulate
from ehamj.scenario.load import parse_scenario

RATE = 1000.0


def struck(strike: float, clipped: tuple[float, float]) -> Result:
    """A floor that shakes at 16 Hz and is struck once; a command at its limit at one mount for part of the time.

    The valve passes next to no oil, so that the command decides nothing itself.
    """
    pulse = {"kind": "shock", "dof": "z", "velocity": 2e-3, "pulse_time": 0.02, "begin": strike}
    hum = {"kind": "sine", "dof": "z", "amplitude": 1e-8, "frequency": 16.0}
    first, last = clipped
    full = [
        {"kind": "step", "mounts": ["rear-left"], "amplitude": sign * 12.0, "start": at}
        for sign, at in ((1.0, first), (-1.0, last))
    ]
    table: dict[str, Any] = {
        "ground": {"kind": "sum", "parts": [hum, pulse]},
        "control": {"kind": "open-loop", "signals": full},
        "criteria": {"norms": ["vc"]},
        "actuators": {"isolator": {"flow_gain": 1e-12}},
    }
    return simulate(parse_scenario({"duration": 8.0, "plates": "tied", **table}))


def told(result: Result) -> list[str]:
    return [text for text in result.summary.warnings if "clipped when it counted" in text]


def test_clipping_in_the_deciding_second_is_named_with_mount_share_and_time() -> None:
    result = struck(5.0, (4.5, 5.3))
    (text,) = told(result)
    band = result.summary.criterion.machine.z.deciding_band
    assert band is not None
    window = deciding(result.dataset["cg_velocity"].values[:, 2], RATE, band)
    assert window is not None
    assert window.begin < 5.1 < window.end  # the strike lasts until 5.02 s
    held = min(5.3, window.end) - max(4.5, window.begin)
    share = float(text.split(" for ")[1].split(" %")[0])
    assert share == pytest.approx(100 * held / (window.end - window.begin), abs=0.5)
    assert "at rear-left for" in text
    assert f"the band at {band} Hz" in text
    assert "±10 V" in text


def test_clipping_at_another_time_is_not() -> None:
    result = struck(5.0, (1.0, 2.0))
    assert any("the command was at its limit" in text for text in result.summary.warnings)
    limits = binding(result.summary, result.scenario.plant)
    assert limits.startswith("voltage (the command was at its limit for 12.5 % of the time, rear-left)")
    assert told(result) == []


@pytest.mark.parametrize("when", [3.0, 6.2])
def test_the_second_is_that_of_the_largest_level(when: float) -> None:
    """A burst of 20 Hz that lasts a second: the window of one second that holds it all."""
    time = np.arange(int(8 * RATE)) / RATE
    burst = np.sin(2 * np.pi * 20.0 * time) * ((time >= when) & (time < when + 1.0))
    found = deciding(1e-5 * burst + 1e-7 * np.sin(2 * np.pi * 25.0 * time), RATE, "20")
    assert found is not None
    # The filter of 4.6 Hz takes about 0.1 s to fill and to empty; windows are 0.05 s apart.
    assert found.end == pytest.approx(when + 1.0, abs=0.2)
    assert found.end - found.begin == pytest.approx(1.0)


def test_about_a_peak_the_second_around_it() -> None:
    velocity = np.zeros(5000)
    velocity[1700] = -1e-3
    found = deciding(velocity, RATE, "all")
    assert found is not None
    assert (found.begin, found.end) == pytest.approx((1.2, 2.2))
