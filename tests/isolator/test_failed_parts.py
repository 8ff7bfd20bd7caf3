"""A stuck spool, a null that drifts, leaks to outside and a check valve, each against its own equation."""

import mujoco
import numpy as np
import pytest

from ehamj.memory import activations, exchange
from ehamj.mujoco import hydraulics
from ehamj.mujoco.equilibrium import Inputs, equilibrium, rates
from ehamj.mujoco.model import build_model
from ehamj.result import Result
from ehamj.run.simulate import simulate
from ehamj.scenario.load import parse_scenario

STEP = {"kind": "open-loop", "signals": ({"kind": "step", "amplitude": 3.0, "start": 0.01},)}


def flows(pressure: float, spool: float, supply: float = 70e5, **isolator: object) -> tuple[float, float]:
    """Into chamber 1, and drawn, of the first isolator with both chambers at a pressure [m³/s]."""
    scenario = parse_scenario({"actuators": {"isolator": isolator}, "supply": {"pressure": supply}})
    model = build_model(scenario.plant, 1e-4)
    data = mujoco.MjData(model)
    with hydraulics():
        state = equilibrium(model, data, Inputs.rest(model))
        own = activations(model, state[-model.na :]).isolators
        own["spool"], own["pressure_1"], own["pressure_2"] = spool, pressure, pressure
        rates(model, data, state, Inputs.rest(model))
    return float(exchange(data, 4)["into_1"][0]), float(exchange(data, 4)["drawn"][0])


def run(**isolator: object) -> Result:
    return simulate(
        parse_scenario(
            {"duration": 0.3, "control": STEP, "actuators": {"isolator": isolator}, "plates": "tied", "timestep": 1e-4}
        )
    )


@pytest.mark.parametrize("overlap", [[0.0] * 4, [-0.01] * 4], ids=["plain", "lapped"])
def test_oil_that_leaks_to_outside_is_missing_in_its_chamber(overlap: list[float]) -> None:
    """g_1 (P_1 − P_t), by definition."""
    at = 30e5
    tight, _ = flows(at, 2.0, overlap=overlap)
    leaking, _ = flows(at, 2.0, overlap=overlap, outside_leakage_1=1e-12)
    assert tight - leaking == pytest.approx(1e-12 * at, rel=1e-6)  # of 1e-5, subtracted
    assert flows(at, 2.0, overlap=overlap, outside_leakage_2=1e-12)[0] == tight


@pytest.mark.parametrize("overlap", [[0.0] * 4, [-0.01] * 4], ids=["plain", "lapped"])
def test_a_check_valve_lets_nothing_back(overlap: list[float]) -> None:
    """Chambers above the supply push oil back through an open edge; behind a check valve they keep it."""
    above = 90e5
    back, drawn = flows(above, 5.0, overlap=overlap)
    kept, none = flows(above, 5.0, overlap=overlap, check_valve=True)
    assert max(back, drawn) < 0.0
    assert none == 0.0
    assert back < kept <= 0.0  # edges to the tank still leak
    assert flows(30e5, 5.0, overlap=overlap, check_valve=True) == flows(30e5, 5.0, overlap=overlap)


def test_a_stuck_spool_stands_where_it_stuck() -> None:
    stuck = run(spool_stuck=True, spool_stuck_at=-0.25).dataset
    np.testing.assert_array_equal(stuck["spool"].values, -5.0)
    assert np.any(stuck["valve_command"].values)


def test_a_null_drifts_as_an_offset_that_grows() -> None:
    """Settled on its bound the valve is one with a null offset; before, nothing has happened."""
    drift = run(null_drift=5.0, null_drift_from=0.05, null_drift_limit=0.2).dataset
    offset, none = run(null_offset=0.2).dataset, run().dataset
    early = {"time": slice(0.0, 0.05)}
    np.testing.assert_array_equal(drift["stroke"].sel(early), none["stroke"].sel(early))
    moved = [float(one["stroke"][-1, 0] - none["stroke"][-1, 0]) for one in (drift, offset)]
    # The chambers' slowest motion is gone by e^(−0.2 s · 44 1/s).
    assert moved[0] == pytest.approx(moved[1], rel=1e-2)
    assert abs(moved[1]) > 1e-7
