"""The parts of the bench run, what is timed is the same motion, and what cannot be timed is refused."""

import re
from collections.abc import Iterator
from typing import Any

import numpy as np
import pytest
from harness import Cli

from ehamj.bench.bench import PARTS, bench, bench_chart, bench_tables, chosen, measured, together
from ehamj.bench.ceiling import Ceiling, System
from ehamj.bench.engines import benchmark_case
from ehamj.bench.exudyn_case import ExudynCase
from ehamj.bench.lane_ceiling import LaneCeiling
from ehamj.bench.lanes import machines
from ehamj.bench.parts import Part
from ehamj.errors import InputError
from ehamj.isolator.edges import Edges, chamber_flows
from ehamj.isolator.fluid import Fluid, pressure_rate
from ehamj.isolator.spool import Command, Spool, spool_acceleration, spool_target
from ehamj.isolator.supply import Feed
from ehamj.scenario.load import load_scenario

STEP = 1e-4
KEYS = {
    "engines": {
        "step_us", "hydraulics_over_bare_engine", "hydraulics_over_bare_engine_without_timer", "benchmark_case",
        "recorded_over_bare_engine",
    },
    "lanes": {
        "lanes", "two_threads_over_one", "small_motion_two_threads_over_one", "small_motion_runs_two_threads_over_one",
    },
    "controller": {"controlled", "linearised_over_without", "step_over_step_without"},
    "growth": {"growth", "step_over_four_upright_mounts"},
    "stages": {"stages"},
    "studies": {"studies"},
    "designs": {"linear_designs"},
}  # fmt: skip
"""What each part measures; other programs read these names."""


def test_the_parts_are_listed(cli: Cli) -> None:
    assert [one["name"] for one in cli("bench", "--list", "--json").json["parts"]] == list(PARTS)


def numbers(figures: dict[str, Any]) -> Iterator[float]:
    for value in figures.values():
        yield from numbers(value) if isinstance(value, dict) else (value,)


def test_all_parts_but_the_peer_are_measured_without_being_asked() -> None:
    assert {one.name for one in chosen()} == set(PARTS) - {"peer"} >= set(KEYS)
    assert [one.name for one in chosen(["stages", "engines"])] == ["engines", "stages"]
    assert [one.name for one in chosen(["stages"], ["peer"])] == ["stages", "peer"]


@pytest.mark.parametrize("name", [one.name for one in chosen()])
def test_each_part_finds_times_and_draws_them(name: str) -> None:
    parts = [PARTS[name]]
    by_part = measured(1, parts, share=0.005)
    figures = together(by_part)
    assert set(figures) == KEYS.get(name, set(figures))
    found = np.array(list(numbers(figures)))
    assert np.all(np.isfinite(found))
    assert np.all(found > 0.0)
    assert len(bench_chart(figures, parts).axes) >= 1
    for table in bench_tables(by_part):
        assert re.match(r"A row is .*(higher|lower) is better", table.words), table.title
        assert all(re.search(r"\[(-|s|µs)\]$", head) for head in table.heads[1:]), table.heads
        assert all(len(row) == len(table.heads) and any(row[1:]) for row in table.rows), table.rows


def test_a_part_without_tables_of_its_own_is_listed_by_its_keys() -> None:
    part = Part("one", "what is asked", lambda _: {}, lambda _: ())
    (table,) = part.tables({"times_s": {"first": 1.0, "second": 2.5}, "ratio": 0.5})
    assert table.title == "What is asked"
    assert list(table.rows) == [("times_s.first", "1"), ("times_s.second", "2.5"), ("ratio", "0.5")]


def test_the_benchmark_case_is_the_same_motion_with_and_without_the_engine() -> None:
    case = benchmark_case(load_scenario("benchmark", ["duration=0.1"]), STEP, 1)
    # 9.8e-7 at this step over the whole case; the first tenth of a second peaks lower.
    assert case["error"] < 1e-4
    assert case["ceiling_error"] < 1e-4


@pytest.mark.parametrize("number", [1, 3, 16])
def test_a_machine_moves_in_lanes_as_it_does_alone(number: int) -> None:
    many = machines(number, 0.05)
    together = LaneCeiling(many, STEP).channels()
    alone = np.stack([Ceiling(one, STEP).channels() for one in many])
    # The same operations in the same order: what is left is room for another compiler.
    np.testing.assert_allclose(together, alone, rtol=0.0, atol=1e-12 * np.abs(alone).max())
    assert number == 1 or np.ptp(together[:, -1, 2]) > 1e-6 * np.abs(together[:, -1, 2]).max()


def test_without_exudyn_the_peer_is_refused_before_anything_is_timed(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(__import__("sys").modules, "exudyn", None)  # as if it were not installed
    said: list[str] = []
    with pytest.raises(InputError, match=r"peer: needs Exudyn.*pip install 'ehamj\[peer\]'"):
        bench(1, chosen(["engines", "peer"]), said.append)
    assert not said


def test_the_peers_own_equations_are_those_of_the_valve() -> None:
    """What is written anew for the peer, NumPy in place of its symbols, against the kernels; the machine at rest."""
    scenario = load_scenario("benchmark")
    case: Any = object.__new__(ExudynCase)
    case._system = System.of(scenario, 1.0 / 3000.0)
    for mount, time, state in ((0, 0.0, (105e5, 105e5, 0.3, -2.0)), (2, 0.013, (90e5, 120e5, -0.2, 5.0))):
        actuator, supply = scenario.plant.actuators[mount], scenario.plant.supply
        setting: Any = scenario.control.signals[mount]  # type: ignore[union-attr]
        feed = Feed(supply.pressure, supply.tank_pressure, supply.rating_pressure)
        own, valve, oil = Edges.values_of(actuator), Spool.values_of(actuator), Fluid.values_of(actuator)
        flows = chamber_flows(state[2], state[0], state[1], feed, own)
        command = setting.amplitude * np.sin(2.0 * np.pi * setting.frequency * time)
        target = spool_target(Command(command, 0.0), valve)
        rises = [
            pressure_rate(flow, 0.0, pressure, volume, oil.bulk_modulus, oil.wall_compliance)
            for flow, pressure, volume in zip(flows[:2], state[:2], (actuator.volume_1, actuator.volume_2), strict=True)
        ]
        expected = [*rises, state[3], spool_acceleration(target - state[2], state[3], valve)]
        # The flows are those of a plain root: 1e-300 in the kernel's, and sums in another order.
        np.testing.assert_allclose(case._rates(np, mount, time, np.array(state)), expected, rtol=1e-12)


def test_with_exudyn_the_peer_moves_as_the_bare_loop_does() -> None:
    pytest.importorskip("exudyn")
    errors = bench(1, [PARTS["peer"]], share=0.05)["peer"]["error"]
    assert errors["Exudyn"] == pytest.approx(errors["bare scalar loop"], rel=0.01)
