"""Loops of a block of machines, in lanes, against each loop alone: bit for bit the same."""

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from oracles.stepped import STEP, run, together

from ehamj.control import Controller, ControllerBank, PythonController
from ehamj.control.learning import Learning
from ehamj.control.linearisation import Linearisation
from ehamj.control.loop import DigitalLoop, make_loop, stacked, structure
from ehamj.control.sensors import Sensors
from ehamj.scenario.load import parse_scenario

PLANT = parse_scenario({}).plant
WIDTH = 8
INPUTS = (*(f"ground_velocity {mount} z" for mount in PLANT.mounts), f"stroke {PLANT.mounts[1]}")
SENSORS = Sensors.model_validate({"ground": {"kind": "geophone"}, "stroke": {}})


def law(seed: int, states: int, **settings: Any) -> Controller:
    draw = np.random.default_rng(seed).normal
    A = draw(size=(states, states))
    A *= 0.9 / np.abs(np.linalg.eigvals(A)).max()
    B, C, D = (draw(size=shape) for shape in ((states, len(INPUTS)), (4, states), (4, len(INPUTS))))
    return Controller(A, B, C, D, INPUTS, voltage_limit=3.0, **settings).with_anti_windup(0.01)


def bank(seed: int) -> ControllerBank:
    """Laws of several rates and delays, of which two switch within steps, of states that are no multiple of four."""
    laws = (
        law(seed, 7, period=2e-4, delay=3e-4),
        law(seed + 100, 2, period=1e-4, delay=0.0),
        law(seed + 200, 3, period=2e-4, delay=2.3e-4),
        law(seed + 300, 1, period=1e-4, delay=4e-5),
    )
    found = ControllerBank.combine(laws)
    assert isinstance(found, ControllerBank)
    return found


def learning(seed: int) -> ControllerBank:
    """The same with a stage beside them, which learns from the first samples on: of little, that is not limited."""
    settings = Learning(rate=1e4, band=(2000.0, 2400.0), pace=1e-3, least=1e-9)
    valves = Linearisation().known(PLANT)
    known = {"valves": valves, "learners": settings.learners(PLANT, valves, SENSORS)}
    return ControllerBank(tuple(replace(part, **known) for part in bank(seed).scaled(0.01).parts))


def loop(seed: int, make: Callable[[int], Any] = bank) -> DigitalLoop:
    return make_loop(make(seed), PLANT, STEP, SENSORS, seed)


@pytest.mark.parametrize("make", [bank, learning])
def test_each_lane_is_the_same_loop_alone_and_goes_on_where_that_stood(make: Callable[[int], Any]) -> None:
    draw = np.random.default_rng(1)
    signals = [draw.normal(size=(60, loop(0).sensing.layout.size)) for _ in range(WIDTH)]
    noise = [1e-3 * draw.normal(size=(60, loop(0, make).sensing.channels)) for _ in range(WIDTH)]
    alone, begun = [loop(k, make) for k in range(WIDTH)], [loop(k, make) for k in range(WIDTH)]
    for k in range(WIDTH):
        run(begun[k], signals[k][:20], noise[k])
        run(alone[k], signals[k][:20], noise[k])
    expected = [run(alone[k], signals[k][20:], noise[k]) for k in range(WIDTH)]
    found = run(stacked(begun), together([each[20:] for each in signals]), together(noise), WIDTH)
    assert np.abs(found).max() > 1.0
    assert make is bank or not np.array_equal(alone[0].law_memory.known, alone[0].laws.valves)  # something was learnt
    np.testing.assert_array_equal(found, together(expected))


@pytest.mark.parametrize(
    "other",
    [
        pytest.param(lambda seed: law(seed, 7), id="one law instead of two"),
        pytest.param(lambda seed: ControllerBank((law(seed, 7, delay=2e-4), law(seed, 2))), id="another delay"),
    ],
)
def test_loops_of_different_structure_do_not_run_in_one_block(other: Callable[[int], Any]) -> None:
    assert structure(loop(0)) == structure(loop(1))
    assert structure(loop(0)) != structure(loop(0, other))
    with pytest.raises(ValueError, match="structure"):
        stacked([loop(0), loop(0, other)])


def test_python_functions_do_not_run_in_one_block() -> None:
    def python(_: int) -> PythonController:
        return PythonController(lambda time, measured, taken: np.zeros(4), INPUTS)

    assert stacked([loop(0, python)]).functions
    with pytest.raises(ValueError, match="Python function"):
        stacked([loop(0, python), loop(0, python)])
