"""What a run says of loads at rest, supply, strokes and pressures: said where it is so, and nowhere else."""

import re
from typing import Any

import numpy as np
import pytest

from ehamj.result import Result
from ehamj.run.reserves import support
from ehamj.run.simulate import simulate
from ehamj.scenario.load import parse_scenario

PUMPED = {"kind": "open-loop", "signals": [{"kind": "sine", "amplitude": 5.0, "frequency": 5.0}]}
TIGHT = {"flow_pressure": 1e-12, "edge_leakage_share": 0.01}
"""A valve that leaks next to nothing, so that an open one drives the chambers to supply and tank."""


def run(**table: Any) -> Result:
    return simulate(parse_scenario({"duration": 0.5, "plates": "tied", "timestep": 2.5e-4, **table}))


def pushed(amplitude: float) -> dict[str, Any]:
    return {"kind": "open-loop", "signals": [{"kind": "step", "amplitude": amplitude, "start": 0.0}]}


def said(result: Result, words: str) -> str:
    """The one warning that has these words, or nothing."""
    found = [text for text in result.summary.warnings if words in text]
    assert len(found) < 2
    return found[0] if found else ""


@pytest.mark.parametrize("plates", ["tied", "sliding"])
def test_mounts_carry_what_statics_asks_for(plates: str) -> None:
    """Feet at x = ±0.9 m, ±0.6 m under a machine of 4 t with its centre of gravity aside; plates of 14 kg each."""
    result = run(machine={"cg": [0.3, -0.1, 0.7]}, plates=plates, duration=0.01)
    plant = result.scenario.plant
    x, y, _ = np.array(plant.positions).T
    share = 0.25 + 0.3 * x / (x**2).sum() - 0.1 * y / (y**2).sum()
    weights = 9.80665 * (plant.machine.mass * share + 14.0)
    # A ten-thousandth: with sliding plates the feet are tied by a constraint that gives a little.
    np.testing.assert_allclose(support(result.dataset, plant), weights, rtol=1e-4)


def test_a_pulled_mount_is_named_with_its_force() -> None:
    told = said(run(machine={"cg": [0.95, 0.0, 0.7]}), "pulled at rest")
    force = 9.80665 * (4000.0 * (0.25 - 0.25 * 0.95 / 0.9) + 14.0)  # statics; negative: pulled
    assert re.findall(r"(rear-\w+) with (\S+) N", told) == [
        (f"rear-{side}", f"{-force:.3g}") for side in ("left", "right")
    ]
    assert "front" not in told
    assert "9.94 kN on the mean" in told


def test_a_mount_that_carries_little_is_named_too() -> None:
    result = run(machine={"cg": [0.85, 0.0, 0.7]}, duration=0.01)
    told = said(result, "less than 10 % of the mean")
    assert "rear-left with 682 N, rear-right with 682 N" in told  # 9.80665·(4000·(0.25 − 0.25·0.85/0.9) + 14)
    assert not said(result, "pulled at rest")


@pytest.mark.parametrize(
    "table", [{"machine": {"cg": [0.5, 0.2, 0.7]}}, {"machine": {"cg": [0.95, 0, 0.7]}, "gravity": 0.0}]
)
def test_loads_that_need_no_word(table: dict[str, Any]) -> None:
    result = run(**table, duration=0.01)
    assert not said(result, "at rest, ")


def test_a_pump_that_is_too_small_starves_the_supply() -> None:
    result = run(supply={"dynamic": True, "pump_flow": 2e-5}, control=PUMPED)
    told = said(result, "supply is starved")
    pressure = result.dataset["supply_pressure"].values
    mean, least, when = (
        float(text) for text in re.findall(r"keeps (\S+) bar .* and (\S+) bar at least, at (\S+) s", told)[0]
    )
    assert float(mean) == pytest.approx(pressure.mean() / 1e5, abs=0.01)
    assert float(least) == pytest.approx(pressure.min() / 1e5, abs=0.01)
    assert float(when) == pytest.approx(float(result.dataset.time[pressure.argmin()]))
    assert "of 70 bar set" in told


@pytest.mark.parametrize("supply", [{"dynamic": True}, {"pump_flow": 2e-5}])
def test_a_pump_that_suffices_or_is_not_modelled_starves_nothing(supply: dict[str, Any]) -> None:
    assert not said(run(supply=supply, control=PUMPED), "starved")


def test_a_stroke_near_its_end_is_named() -> None:
    soft = {"membrane_stiffness": 1.25e6}
    told = said(run(actuators={"isolator": soft}, duration=0.01), "of their range")
    # m g/ΣK_L of the end V_t/2/A_p.
    share = 4056 * 9.80665 / (4 * 1.25e6) / (0.5 * 5.39e-4 / 3.18e-2)
    assert f"up to {100 * share:.3g} %" in told
    assert "mm from unloaded membranes" in told
    assert not said(run(actuators={"isolator": {"membrane_stiffness": 1.5e6}}, duration=0.01), "of their range")
    assert not said(run(actuators={"isolator": {**soft, "moving_volume": False}}, duration=0.01), "of their range")


def test_chambers_near_supply_and_tank_are_named() -> None:
    result = run(actuators={"isolator": TIGHT}, control=pushed(9.0), duration=1.0)
    told = said(result, "chamber pressures used")
    pressure = result.dataset["chamber_pressure"].values
    used = 100 * np.abs(pressure / 35e5 - 1.0).max()
    assert f"up to {used:.3g} %" in told
    assert "of 0 to 70 bar" in told
    assert not said(run(actuators={"isolator": TIGHT}, control=pushed(1.0)), "chamber pressures used")
