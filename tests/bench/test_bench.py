"""The timings run, and what is timed is the same motion."""

from ehamj.bench.case import benchmark_case
from ehamj.bench.mounts import COUNTS, cost_over_mounts
from ehamj.bench.steps import additions, step_times, thread_scaling

from ehamj.scenario.load import load_scenario


def test_the_benchmark_case_is_the_same_motion_with_and_without_the_engine() -> None:
    case = benchmark_case(load_scenario("benchmark", ["duration=0.1"]), 1e-4, 1)
    # 9.8e-7 at this step over the whole case; the first tenth of a second peaks lower.
    assert case["error"] < 1e-4
    assert case["ceiling_error"] < 1e-4


def test_each_step_that_is_timed_takes_time() -> None:
    scenario = load_scenario("benchmark", ["duration=0.02"])
    times = step_times(scenario.plant, 1e-4, 1, steps=10)
    assert set(times) == {"bare", "bare_without_timer", "hydraulics"}
    assert min(times.values()) > 0.0
    assert thread_scaling(scenario, 1, batch=2) > 0.0
    assert set(additions(scenario, 1, steps=20)) == {"controller", "controller_and_sensors", "force"}


def test_cost_is_told_for_each_number_of_mounts_upright_and_skew() -> None:
    costs = cost_over_mounts(1, steps=10)
    assert set(costs) == {"upright", "skew"}
    for each in costs.values():
        assert set(each) == {str(mounts) for mounts in COUNTS}
        assert min(each.values()) > 0.0
