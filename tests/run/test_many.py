"""Many runs: taken as threads get free, reduced as they come, each failure with its name."""

import gc
import warnings
import weakref
from collections.abc import Iterator
from pathlib import Path

import pytest

from ehamj.errors import DerivedAnew, InputError
from ehamj.result import Result
from ehamj.run.failures import Incomplete
from ehamj.run.many import simulate_many
from ehamj.run.workers import worked_through
from ehamj.scenario.load import parse_scenario
from ehamj.scenario.model import Scenario

SHORT = parse_scenario({"name": "short", "duration": 0.02, "plates": "tied", "control": {"kind": "feedforward"}})
FLOW = "actuators.isolator.flow_gain"


def test_a_generator_is_never_ahead_and_order_is_kept() -> None:
    taken, done = [0], [0]

    def machines() -> Iterator[Scenario]:
        for k in range(9):
            taken[0] += 1
            assert taken[0] - done[0] <= 2  # as many as threads
            yield SHORT.varied({"name": f"machine {k}"})

    def name(result: Result) -> str:
        done[0] += 1
        return result.scenario.name

    assert simulate_many(machines(), threads=2, reduce=name) == [f"machine {k}" for k in range(9)]


def test_a_reduced_result_is_forgotten() -> None:
    alive: list[weakref.ref[Result]] = []

    def keep_nothing(result: Result) -> int:
        gc.collect()
        left = sum(one() is not None for one in alive)
        alive.append(weakref.ref(result))
        return left

    assert max(simulate_many([SHORT] * 6, threads=1, reduce=keep_nothing)) <= 1


def test_a_failure_says_which_and_no_further_one_begins() -> None:
    begun: list[int] = []

    def machines() -> Iterator[Scenario]:
        for k in range(20):
            begun.append(k)
            yield SHORT.varied({"name": f"machine {k}"}) if k != 3 else SHORT.varied({"name": "torn", "timestep": 0.01})

    with pytest.raises((InputError, Incomplete), match=r"^scenario 3 \(torn\): "):
        simulate_many(machines(), threads=1)
    assert begun[-1] <= 4
    with pytest.raises(InputError, match="scenario 1: scenario 'nowhere': no such file"):
        simulate_many([SHORT, "nowhere"])


def test_an_error_of_the_reduction_says_where() -> None:
    with pytest.raises(ZeroDivisionError) as caught:
        simulate_many([SHORT], reduce=lambda result: 1 / 0)
    assert caught.value.__notes__ == ["in scenario 0 (short)"]


def test_an_iterator_that_fails_is_not_swallowed() -> None:
    def broken() -> Iterator[int]:
        yield 1
        raise RuntimeError("no more machines")

    with pytest.raises(RuntimeError, match="no more machines"):
        worked_through(broken(), lambda number, item: item, threads=2)


def test_laws_that_changed_with_their_machines_are_told_once() -> None:
    off = [SHORT.varied({"name": f"machine {k}", FLOW: (1.9 + 0.01 * k) * 1e-6}) for k in range(3)]
    anew = [one.model_copy(update={"control": SHORT.control}) for one in off]
    with pytest.warns(DerivedAnew, match="flow_gain") as told:
        simulate_many(anew, reduce=repr)
    assert len(told) == 1
    assert told[0].filename == __file__
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        simulate_many(off, reduce=repr)


def test_paths_and_tables_serve(tmp_path: Path) -> None:
    SHORT.save(tmp_path / "short.toml")
    names = simulate_many(
        [str(tmp_path / "short.toml"), tmp_path / "short.toml", {"duration": 0.01, "name": "table"}],
        reduce=lambda result: result.scenario.name,
    )
    assert names == ["short", "short", "table"]


def test_no_thread_is_refused() -> None:
    with pytest.raises(InputError, match="threads = 0: must be at least 1"):
        simulate_many([SHORT], threads=0)


def test_failures_stop_nothing_where_something_stands_for_them() -> None:
    """One that is no scenario, one that cannot be prepared, one that stops, one whose reduction fails."""
    torn = {"ground": {"kind": "sine", "dof": "ry", "amplitude": 20.0, "frequency": 30.0}}
    small = SHORT.varied({"engine": "small-motion"})
    for base in (SHORT, small):
        given = [base, "nowhere", base.varied({"timestep": 0.01}), base.varied(torn), base.varied({"name": "x"})]

        def name(result: Result) -> str:
            if result.scenario.name == "x":
                raise ZeroDivisionError("no name")
            return result.scenario.name

        found = simulate_many(given, threads=2, reduce=name, on_failure=lambda number, error: f"{number}: {error}")
        assert found[0] == "short"
        assert found[1].startswith("1: scenario 'nowhere': no such file")
        assert found[2].startswith("2: timestep = 0.01")
        assert found[3].startswith("3: simulation failed at ")
        assert found[4] == "4: no name"
