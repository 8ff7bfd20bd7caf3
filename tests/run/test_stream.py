"""Runs whose rows go to a file as they come: to the bit those that stay in memory, and gone with who holds them."""

import gc
import itertools
import os
import pickle
import shutil
import subprocess
import sys
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import psutil
import pytest
import xarray as xr

from ehamj import columns, growing
from ehamj.control import PythonController
from ehamj.errors import InputError, SimulationFailed
from ehamj.mujoco import hydraulics
from ehamj.result import Result, load_result
from ehamj.run import budget, side_by_side
from ehamj.run.failures import Incomplete
from ehamj.run.many import observe_many
from ehamj.run.simulate import Observed, driven_alone, ready, seen, simulate
from ehamj.run.stream import Stream
from ehamj.scenario.load import load_scenario, parse_scenario
from ehamj.scenario.model import ENGINES, Scenario

ROWS = 300
"""Of a block, so that short runs have several; no number of steps between two returns to Python has it."""

SLIDE = ["slide.0.start=-0.1", "slide.0.profile.moves=[{time=0.2,to=0.0,speed=1.0,acceleration=9.0,jerk=200.0}]"]
FAULT = ["fault=[{kind='valve-stuck',mount='front-left',time=0.3,settling=0.1}]"]
SETS = [*SLIDE, *FAULT, "duration=0.46", "compare=[]"]


@pytest.fixture
def short_blocks(monkeypatch: pytest.MonkeyPatch) -> None:
    """Blocks of few rows, in memory and in files."""
    monkeypatch.setattr(columns, "ROWS", ROWS)


@pytest.fixture
def streamed(short_blocks: None, monkeypatch: pytest.MonkeyPatch) -> None:
    """Whatever runs is too long for memory."""
    monkeypatch.setattr(growing, "IN_MEMORY", 0)


@pytest.fixture(scope="module")
def kept(tmp_path_factory: pytest.TempPathFactory) -> Result:
    """One whose channels are in a file, and that nothing shows."""
    sets = ["duration=0.4", "compare=[]", "output.replay=false", "output.report=false"]
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(columns, "ROWS", ROWS)
        patch.setattr(growing, "IN_MEMORY", 0)
        return simulate(load_scenario("benchmark", sets), within=tmp_path_factory.mktemp("kept") / "rows")


def same(one: xr.Dataset, other: xr.Dataset) -> None:
    """Every channel and label, to the bit."""
    assert list(one.variables) == list(other.variables)
    for name in one.variables:
        assert one[name].dims == other[name].dims
        assert one[name].attrs == other[name].attrs
        np.testing.assert_array_equal(one[name].values, other[name].values, err_msg=str(name))
    assert one.attrs == other.attrs


def unjudged(scenario: Scenario, *, within: Path | None = None) -> Observed:
    """A run's channels."""
    with hydraulics():
        prepared = ready(scenario, within=within).prepared
        return seen(prepared, driven_alone(prepared))


def numbers(result: Result) -> dict[str, Any]:
    """The summary but for how long it took."""
    found = result.summary.to_dict()
    found["timing"] = {name: found["timing"][name] for name in ("simulated_s", "steps", "timestep_s", "engine")}
    return found


@pytest.mark.parametrize("engine", ENGINES)
def test_a_run_in_a_file_is_to_the_bit_the_one_in_memory(
    engine: str, short_blocks: None, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    """Under a law, with a slide that moves and a valve that sticks meanwhile; what one engine's channels say is judged
    too."""
    scenario = load_scenario("moving-slide", [*SETS, f"engine={engine}"])
    run = simulate if engine == "small-motion" else unjudged
    held = run(scenario)
    monkeypatch.setattr(growing, "IN_MEMORY", 0)
    kept = run(scenario, within=tmp_path)
    assert held.kept is None
    assert kept.kept is not None
    assert kept.kept.path.is_relative_to(tmp_path)
    assert held.dataset.sizes["time"] > 1.5 * ROWS
    same(kept.dataset, held.dataset)
    if isinstance(kept, Result) and isinstance(held, Result):
        assert numbers(kept) == numbers(held)


def test_runs_side_by_side_have_a_file_each(streamed: None) -> None:
    scenario = load_scenario("benchmark", ["duration=0.4", "compare=[]", "engine=small-motion"])
    two = observe_many([scenario, scenario.varied({"machine.mass": 4400.0})], lambda run: run, threads=1)
    alone = unjudged(scenario)
    assert two[0].kept is not None
    assert two[1].kept is not None
    assert two[0].kept.path != two[1].kept.path
    same(two[0].dataset, alone.dataset)
    assert not np.array_equal(two[1].dataset["stroke"].values, alone.dataset["stroke"].values)


SHORT = {"duration": 0.1, "engine": "small-motion"}


def test_runs_that_are_too_long_together_are_refused_where_the_disk_is_full(monkeypatch: pytest.MonkeyPatch) -> None:
    scenario = parse_scenario(SHORT)
    monkeypatch.setattr(growing, "IN_MEMORY", int(1.5 * budget.size_of(scenario)))
    monkeypatch.setattr(budget.psutil, "disk_usage", lambda _: type("Free", (), {"free": 1e3}))
    observe_many([scenario], lambda run: run, threads=1)
    with pytest.raises(InputError, match=r"scenarios 0, 1, .*: .*, 2 runs together: 200 rows need about .* on disk"):
        observe_many([scenario, scenario], lambda run: run, threads=1)


def test_the_run_is_named_whose_last_rows_cannot_be_written(streamed: None, monkeypatch: pytest.MonkeyPatch) -> None:
    numbers = itertools.count()

    class Full(Stream):
        def __init__(self, *given: Any) -> None:
            super().__init__(*given)
            self.number = next(numbers)

        def add(self, *given: Any) -> None:
            if self.number == 1:
                raise OSError("no room")
            super().add(*given)

    monkeypatch.setattr(side_by_side, "Stream", Full)
    with pytest.raises(OSError, match="no room") as failed:
        observe_many([parse_scenario(SHORT)] * 2, lambda run: run, threads=1)
    assert any(note.startswith("in scenario 1 (") for note in failed.value.__notes__)


def breaks(time: float, measured: np.ndarray, limited: np.ndarray) -> np.ndarray:
    if time > 0.2:
        raise ZeroDivisionError("by nothing")
    return np.zeros(4)


@pytest.mark.parametrize("engine", ENGINES)
def test_what_was_written_until_a_failure_is_kept(
    engine: str, short_blocks: None, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    scenario = load_scenario("benchmark", ["duration=0.4", "record_rate=3000", "compare=[]", f"engine={engine}"])
    law = PythonController(breaks, ("stroke front-left",))
    with pytest.raises(SimulationFailed) as held:
        simulate(scenario, controller=law)
    monkeypatch.setattr(growing, "IN_MEMORY", 0)
    with pytest.raises(SimulationFailed) as kept:
        simulate(scenario, controller=law, within=tmp_path)
    assert isinstance(held.value, Incomplete)
    assert isinstance(kept.value, Incomplete)
    assert str(kept.value) == str(held.value)
    same(kept.value.result.dataset, held.value.result.dataset)
    assert kept.value.result.dataset.attrs["complete"] == 0


def test_a_file_goes_with_the_last_who_holds_one_of_its_channels(streamed: None, tmp_path: Path) -> None:
    stroke = unjudged(load_scenario("benchmark", ["duration=0.4", "compare=[]"]), within=tmp_path).dataset["stroke"]
    gc.collect()
    assert len(list(tmp_path.iterdir())) == 1
    assert np.isfinite(stroke[:, 1].values).all()
    del stroke
    gc.collect()
    assert not list(tmp_path.iterdir())


def test_a_file_goes_where_a_run_breaks_off(streamed: None, tmp_path: Path) -> None:
    def stop(done: float) -> None:
        if done > 0.5:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        simulate(load_scenario("benchmark", ["record_rate=3000"]), stop, within=tmp_path)
    gc.collect()
    assert not list(tmp_path.iterdir())


def test_a_saved_result_is_the_file_itself_and_opens_as_one(streamed: None, kept: Result, tmp_path: Path) -> None:
    folder = tmp_path / "saved"
    kept.save(folder)
    assert kept.kept is not None
    assert (folder / "result.nc").samefile(kept.kept.path)
    read = load_result(folder)
    assert read.kept is not None
    assert read.kept.dataset["stroke"].variable._data is not None
    same(read.dataset, kept.dataset)
    kept.save(folder, overwrite=True)
    same(load_result(folder).dataset, read.dataset)


def test_a_result_is_saved_as_it_is_read_whatever_stands_in_its_file_s_place(
    streamed: None, kept: Result, tmp_path: Path
) -> None:
    kept.save(tmp_path / "a")
    read = load_result(tmp_path / "a")
    replace(kept, dataset=kept.dataset.load().isel(time=slice(200)), kept=None).write(tmp_path / "a")
    read.save(tmp_path / "b")
    same(load_result(tmp_path / "b").dataset, kept.dataset)
    shutil.rmtree(tmp_path / "a")
    read.save(tmp_path / "c")
    same(load_result(tmp_path / "c").dataset, kept.dataset)


def test_a_result_is_saved_from_wherever_one_stands_by_then(
    streamed: None, kept: Result, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    monkeypatch.chdir(tmp_path)
    kept.save("a")
    read = load_result("a")
    Path("below").mkdir()
    os.chdir("below")
    read.save("b")
    assert not Path("b/result.nc").samefile(tmp_path / "a" / "result.nc")  # who edits one does not edit the other
    assert Path("b/result.nc").read_bytes() == (tmp_path / "a" / "result.nc").read_bytes()


def test_a_result_in_a_file_is_pickled(streamed: None, kept: Result, tmp_path: Path) -> None:
    kept.save(tmp_path / "a")
    found = pickle.loads(pickle.dumps(load_result(tmp_path / "a")))
    same(found.dataset, kept.dataset)


def test_what_shows_all_of_a_run_is_left_out_where_it_does_not_fit(
    streamed: None, kept: Result, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    shown = kept.scenario.output.model_copy(update={"report": True, "replay": True})
    result = replace(kept, scenario=kept.scenario.model_copy(update={"output": shown}))
    free = type("Free", (), {"available": result.dataset.nbytes})
    monkeypatch.setattr(psutil, "virtual_memory", lambda: free)
    with pytest.warns(UserWarning, match=r"report and replay need all \d+ rows in memory, about .* GiB are free"):
        result.save(tmp_path / "saved")
    assert {"result.nc", "summary.json", "scenario.toml"} <= {path.name for path in (tmp_path / "saved").iterdir()}
    assert not (tmp_path / "saved" / "report.html").exists()
    with pytest.raises(InputError, match="report and replay need all"):
        load_result(tmp_path / "saved").in_memory()
    free.available = 2 * result.dataset.nbytes
    held = result.in_memory()
    assert held.kept is None
    same(held.dataset, result.dataset)


@pytest.mark.parametrize("in_file", [True, False])
def test_a_file_holds_the_channels_that_are_asked_for(
    kept: Result, in_file: bool, short_blocks: None, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    """As they are, whether all are in memory or in a file; whoever asks for another is told which key left it out."""
    asked = kept.scenario.model_copy(
        update={"output": kept.scenario.output.model_copy(update={"channels": ("cg_*", "stroke")})}
    )
    whole = replace(kept, scenario=asked)
    if in_file:
        monkeypatch.setattr(growing, "IN_MEMORY", 0)
    (whole if in_file else whole.in_memory()).save(tmp_path / "a")
    assert [path.name for path in tmp_path.iterdir()] == ["a"]
    read = load_result(tmp_path / "a")
    assert set(read.dataset.data_vars) == {"cg_displacement", "cg_velocity", "cg_acceleration", "stroke"}
    assert (read.kept is not None) == in_file
    assert whole.dataset.drop_vars(set(whole.dataset.data_vars) - set(read.dataset.data_vars)).identical(read.dataset)
    read.save(tmp_path / "b")
    assert load_result(tmp_path / "b").identity == read.identity == whole.identity
    for ask in (lambda: read.dataset.isel(time=slice(9))["spool"], lambda: read.in_memory().plot.histories()):
        with pytest.raises(InputError, match=r"output\.channels: \w+ was not stored with this result; name it there"):
            ask()


def test_a_channel_that_no_run_has_is_refused_before_it_runs() -> None:
    said = r"output\.channels\.1 = 'strok': did you mean 'stroke'\? must be a channel of this run, .*: .*cg_velocity, "
    with pytest.raises(InputError, match=said):
        unjudged(parse_scenario({"output": {"channels": ["cg_*", "strok"]}}))
    with pytest.raises(InputError, match=r"output\.channels\.0 = 'slide': must be a channel|did you mean"):
        unjudged(parse_scenario({"output": {"channels": ["slide"]}}))


MEASURED = """
import resource
from ehamj import columns, growing
from ehamj.run.simulate import observed
from ehamj.scenario.load import parse_scenario

columns.ROWS, growing.IN_MEMORY = 2048, 0

def peak(duration):
    run = observed(parse_scenario({"duration": duration, "record_rate": 2000.0, "engine": "small-motion",
                                   "ground": {"kind": "sine", "dof": "z", "frequency": 10.0, "amplitude": 1e-6}}))
    return run.dataset.nbytes, resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * 1024

(small, before), (large, after) = peak(6.0), peak(24.0)
print(large - small, after - before)
"""


def test_memory_does_not_grow_with_the_duration() -> None:
    """A run four times as long, 40 MB more in its file: what is read of it to say whether it failed is a column."""
    said = subprocess.run([sys.executable, "-c", MEASURED], capture_output=True, text=True, check=True).stdout
    more, grown = map(int, said.split())
    assert more > 3.5e7
    assert grown < 0.2 * more
