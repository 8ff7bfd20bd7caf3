"""A stored result is read as its run wrote it, or refused in one line: damage, files of other runs, edits by hand."""

import hashlib
import json
import re
import shutil
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import h5py
import numpy as np
import pytest
import xarray as xr
from harness import sealed_anew
from oracles.damage import damaged

import ehamj
from ehamj import belonging
from ehamj.belonging import KEY, check_result, digest_of, told
from ehamj.cli import main
from ehamj.errors import InputError
from ehamj.interruption import Interrupted
from ehamj.replay import write_replay
from ehamj.report import write_report
from ehamj.result import Result, load_result
from ehamj.run.simulate import simulate
from ehamj.scenario.load import parse_scenario
from ehamj.variables import variables_of

SHORT = {
    "name": "short",
    "duration": 0.06,
    "plates": "tied",
    "ground": {"kind": "sine", "dof": "z", "amplitude": 2e-6, "frequency": 25.0},
    "control": {"kind": "feedforward"},
    "compare": ["passive"],
    "output": {"report": False, "replay": False},
}
FILES = ("summary.json", "scenario.toml", "model.xml", "controller.json", "result.nc")


def saved(folder: Path, **changes: Any) -> Path:
    scenario = parse_scenario({**SHORT, **changes})
    simulate(scenario).save(folder, variants=[simulate(scenario.variant("passive"))])
    return folder


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return saved(tmp_path_factory.mktemp("one") / "result")


@pytest.fixture(scope="module")
def other(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Of a heavier machine, with a law of its own."""
    return saved(tmp_path_factory.mktemp("other") / "result", machine={"mass": 4100.0})


@pytest.fixture(scope="module")
def loaded(folder: Path) -> Result:
    return load_result(folder)


@pytest.fixture
def copy(folder: Path, tmp_path: Path) -> Path:
    return Path(shutil.copytree(folder, tmp_path / "copy"))


def same(one: Result, other: Result) -> bool:
    laws = [None if result.controller is None else result.controller.to_dict() for result in (one, other)]
    return (
        one.dataset.identical(other.dataset)
        and (one.scenario.to_toml(), one.model_xml) == (other.scenario.to_toml(), other.model_xml)
        and one.summary == other.summary
        and laws[0] == laws[1]
    )


def refused_or_same(copy: Path, loaded: Result) -> bool:
    """Whether it is refused, in one line; else it must be the same."""
    try:
        found = load_result(copy)
    except InputError as error:
        said = str(error)
        assert "\n" not in said
        assert said.startswith(f"result {str(copy)!r}: ")
        return True
    # Where its folder is is part of a law's name in a scenario, and the copy has another.
    assert same(found, loaded)
    return False


# --- damage -------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", FILES)
def test_a_damaged_file_is_refused_in_one_line_or_read_the_same(copy: Path, loaded: Result, name: str) -> None:
    random, content = np.random.default_rng(7), (copy / name).read_bytes()
    refused = 0
    for _ in range(16):
        (copy / name).write_bytes(damaged(content, random, 4000, texts=True))
        refused += refused_or_same(copy, loaded)
    assert refused >= 14  # a byte may be replaced by itself


@pytest.mark.parametrize("name", FILES)
def test_a_file_that_ends_early_is_refused(copy: Path, loaded: Result, name: str) -> None:
    content = (copy / name).read_bytes()
    for share in np.linspace(0.0, 1.0, 6)[:-1]:
        (copy / name).write_bytes(content[: int(share * len(content))])
        assert refused_or_same(copy, loaded)


def test_a_bit_that_turned_in_any_history_is_refused(copy: Path, loaded: Result) -> None:
    content, random = (copy / "result.nc").read_bytes(), np.random.default_rng(3)
    for at in random.integers(0, len(content), 6):
        turned = bytearray(content)
        turned[at] ^= 1 << int(random.integers(8))
        (copy / "result.nc").write_bytes(turned)
        assert refused_or_same(copy, loaded)


def places(node: Any) -> Iterator[tuple[Any, Any]]:
    """Every entry of a JSON value: what holds it, and its key or number."""
    for key, value in list(node.items() if isinstance(node, dict) else enumerate(node)):
        yield node, key
        if isinstance(value, dict | list):
            yield from places(value)


EDITS: dict[str, Callable[[Any, Any], Any]] = {
    "text": lambda value, random: str(value),
    "null": lambda value, random: None if value is not None else 0,
    "larger": lambda value, random: value + 1 if isinstance(value, int | float) else [value],
    "table": lambda value, random: {"of": value},
    "number": lambda value, random: 1e300 if value != 1e300 else 0.0,
}


@pytest.mark.parametrize("edit", EDITS)
@pytest.mark.parametrize("name", ["summary.json", "controller.json"])
def test_an_edit_of_any_entry_is_refused(copy: Path, loaded: Result, name: str, edit: str) -> None:
    text, random = (copy / name).read_text(), np.random.default_rng(11)
    count = sum(1 for _ in places(json.loads(text)))
    for number in random.choice(count, 8, replace=False):
        table = json.loads(text)
        node, key = list(places(table))[number]
        before, node[key] = node[key], EDITS[edit](node[key], random)
        (copy / name).write_text(json.dumps(table))
        if node[key] != before or isinstance(node[key], str):
            refused_or_same(copy, loaded)  # a text may have been one before


def test_blanks_in_a_summary_change_nothing(copy: Path, loaded: Result) -> None:
    table = json.loads((copy / "summary.json").read_text())
    (copy / "summary.json").write_text(json.dumps(dict(reversed(table.items()))))
    assert not refused_or_same(copy, loaded)


# --- files of another run -----------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", FILES)
def test_a_file_of_another_run_is_refused_by_its_name(copy: Path, other: Path, name: str) -> None:
    shutil.copy(other / name, copy / name)
    with pytest.raises(InputError, match=rf"copy': {name} is of another run"):
        load_result(copy)
    with pytest.raises(InputError, match=rf"copy': {name} is of another run"):
        check_result(copy)


def test_a_page_and_a_recording_of_another_run_are_refused_by_their_names(
    copy: Path, other: Path, loaded: Result, tmp_path: Path
) -> None:
    write_report(tmp_path, {"short": loaded})
    write_replay(tmp_path / "replay.rrd", {"short": loaded})
    foreign = Path(shutil.copytree(other, tmp_path / "foreign"))
    for name, command in (("report.html", "report"), ("replay.rrd", "replay")):
        shutil.copy(tmp_path / name, copy)
        assert same(load_result(copy), loaded)
        shutil.move(tmp_path / name, foreign)
        way = f"take it away, and `ehamj {command} {foreign}` makes one of this run"
        with pytest.raises(InputError, match=rf"{name} shows another run \({loaded.identity}, .*; {re.escape(way)}"):
            load_result(foreign)
        (foreign / name).unlink()


def test_a_variant_of_another_run_is_refused(
    copy: Path, other: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    shutil.rmtree(copy / "passive")
    shutil.copytree(other / "passive", copy / "passive")
    load_result(copy / "passive")  # by itself it is whole
    for command in ("report", "replay"):
        assert said(capsys, monkeypatch, command, str(copy)).startswith(
            f"ehamj: result {str(copy)!r}: variant 'passive': holds another run"
        )


def said(capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch, *words: str) -> str:
    """What a command says that is refused."""
    monkeypatch.setattr("sys.argv", ["ehamj", *words])
    with pytest.raises(SystemExit) as ended:
        main()
    assert ended.value.code == 2
    text = capsys.readouterr().err
    return " ".join(text.split())


@pytest.mark.parametrize("command", ["report", "replay", "compare"])
def test_commands_refuse_a_mixed_result_in_one_line(
    copy: Path,
    folder: Path,
    other: Path,
    command: str,
    capsys: pytest.CaptureFixture[str],
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    shutil.copy(other / "scenario.toml", copy)
    (copy / "replay.rrd").write_bytes(b"is opened as it is")
    words = ("report", str(folder), "--compare", str(copy)) if command == "compare" else (command, str(copy))
    assert "scenario.toml is of another run" in said(capsys, monkeypatch, *words)


def test_the_same_run_again_has_the_same_identity_and_files(folder: Path, tmp_path: Path) -> None:
    again = saved(tmp_path / "again")
    for name in FILES[1:]:
        assert (again / name).read_bytes() == (folder / name).read_bytes()
    assert told(again).belongs.run == told(folder).belongs.run
    assert told(again).belongs.variants == told(folder).belongs.variants


def test_runs_that_differ_in_a_law_of_python_alone_have_identities_of_their_own() -> None:
    scenario = parse_scenario({**SHORT, "duration": 0.01, "compare": []})
    found = set()
    for gain in (0.0, 1e3, 1.1e3):

        def law(time: float, measured: Any, limited: Any, gain: float = gain) -> Any:
            return gain * measured.repeat(4)

        python = ehamj.PythonController(law, ["ground_velocity front-left z"])
        found.add(simulate(scenario, controller=python).identity)
    assert len(found) == 3


# --- edits by hand ------------------------------------------------------------------------------------------------


def test_an_edited_scenario_is_refused_by_its_name(copy: Path) -> None:
    text = (copy / "scenario.toml").read_text()
    (copy / "scenario.toml").write_text(text.replace("duration = 0.06", "duration = 0.07"))
    with pytest.raises(InputError, match=r"scenario\.toml is not as its run wrote it.*runs what it says now"):
        load_result(copy)


def test_a_result_that_says_not_what_belongs_to_it_is_refused_with_the_way_out(copy: Path) -> None:
    table = json.loads((copy / "summary.json").read_text())
    del table[KEY]
    (copy / "summary.json").write_text(json.dumps(table))
    with pytest.raises(InputError, match=rf"an older ehamj wrote it\); `ehamj run {copy}/scenario\.toml` makes"):
        load_result(copy)


@pytest.mark.parametrize("name", ["../other/result.nc", "/etc/hostname", "n" * 5000])
def test_a_summary_that_names_files_which_no_run_writes_is_refused(copy: Path, name: str) -> None:
    table = json.loads((copy / "summary.json").read_text())
    table[KEY]["files"][name] = "0" * 64
    (copy / "summary.json").write_text(json.dumps(table))
    for read in (load_result, check_result):
        with pytest.raises(InputError, match=r"copy': summary\.json: belongs\.files names '.{1,60}', and a run writes"):
            read(copy)


@pytest.mark.parametrize("name", ["model.xml", "result.nc"])
def test_a_file_that_cannot_be_read_is_named(copy: Path, name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    def denied(path: Path) -> str:
        if path.name == name:
            raise PermissionError(13, "Permission denied", str(path))
        return digest_of(path)

    monkeypatch.setattr(belonging, "digest_of", denied)
    with pytest.raises(InputError, match=rf"copy': {name} cannot be read: Permission denied"):
        load_result(copy)


def test_a_digest_is_that_of_the_whole_file_and_can_be_interrupted(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(belonging, "PIECE", 7)
    (tmp_path / "file").write_bytes(bytes(range(100)))
    assert digest_of(tmp_path / "file") == hashlib.sha256(bytes(range(100))).hexdigest()

    def asked() -> None:
        raise Interrupted

    monkeypatch.setattr(belonging, "check", asked)
    with pytest.raises(Interrupted):
        digest_of(tmp_path / "file")


def test_a_law_beside_a_run_that_had_none_is_refused(copy: Path, other: Path) -> None:
    shutil.copy(copy / "controller.json", copy / "passive")
    with pytest.raises(InputError, match=r"controller\.json is of another run"):
        load_result(copy / "passive")


def reordered(data: xr.Dataset) -> xr.Dataset:
    return data.assign_coords(mount=data["mount"].values[::-1])


def with_nan(data: xr.Dataset) -> xr.Dataset:
    data["stroke"][7, 2] = np.nan
    return data


SPOILED: dict[str, tuple[Callable[[xr.Dataset], xr.Dataset], str]] = {
    "zeros": (
        lambda data: data.assign_coords(time=("time", data["time"].values * 0.0, data["time"].attrs)),
        r"time is 0 s in row 1; it must run from 0 in steps of 1/record_rate = 0\.001 s",
    ),
    "nameless": (
        lambda data: data.assign_coords(time=("time", data["time"].values)),
        "time must be numbers in s along itself",
    ),
    "backwards": (
        lambda data: data.assign_coords(time=("time", data["time"].values[::-1], data["time"].attrs)),
        r"time is 0\.06 s in row 0",
    ),
    "slower": (
        lambda data: data.assign_coords(time=("time", data["time"].values * 2.0, data["time"].attrs)),
        r"time is 0\.002 s in row 1",
    ),
    "short": (lambda data: data.isel(time=slice(40)), r"time has 40 rows; a complete run of 0\.06 s .* has 61"),
    "renamed": (
        lambda data: data.assign_coords(mount=["a", "b", "c", "d"]),
        "mount holds a, b, c, d; of this run it must hold front-left",
    ),
    "reordered": (reordered, "mount holds rear-right"),
    "fewer": (lambda data: data.isel(mount=slice(3)), "mount holds front-left"),
    "missing": (lambda data: data.drop_vars("stroke"), "stroke is missing"),
    "extra": (lambda data: data.assign(mine=data["stroke"]), "mine is no variable of this run"),
    "turned": (lambda data: data.assign(stroke=data["stroke"].T), "stroke lies along mount, time"),
    "millimetres": (
        lambda data: data.assign(stroke=data["stroke"].assign_attrs(units="mm")),
        "stroke is in 'mm'; it must be in 'm'",
    ),
    "whole": (
        lambda data: data.assign(spool=data["spool"].astype(int).assign_attrs(data["spool"].attrs)),
        "spool holds int64; it must hold floating-point numbers",
    ),
    "lost": (with_nan, r"stroke is not finite at 0\.007 s, and the run is said to be complete"),
}


@pytest.mark.parametrize("how", SPOILED)
def test_histories_that_are_not_this_run_s_are_refused_with_the_reason(copy: Path, how: str) -> None:
    """Even where whoever changed them made the summary's digest fit; else they are refused for that (next test)."""
    spoil, said = SPOILED[how]
    with xr.open_dataset(copy / "result.nc", engine="h5netcdf") as opened:
        data = opened.load()
    spoil(data).to_netcdf(copy / "result.nc", engine="h5netcdf")
    sealed_anew(copy)
    with pytest.raises(InputError, match=rf"result '.*/copy': result\.nc: {said}"):
        load_result(copy)


def test_a_value_that_was_changed_in_place_is_refused(copy: Path) -> None:
    with h5py.File(copy / "result.nc", "r+") as file:
        file["stroke"][5, 1] *= 1.01
    with pytest.raises(InputError, match=r"result\.nc is not as its run wrote it"):
        load_result(copy)


@pytest.mark.parametrize(
    ("change", "said"),
    [
        (lambda summary: summary["timing"].update(steps="600"), r"timing\.steps: .*integer"),
        (lambda summary: summary["rms"]["stroke"].update({"rear-left": "1e-6"}), "rms: .*rear-left is '1e-6'"),
        (lambda summary: summary.update(complete="yes"), "complete: .*boolean"),
        (lambda summary: summary.update(mine=1.0), "mine: is no key of it"),
    ],
)
def test_a_text_where_a_number_stands_is_refused(copy: Path, change: Any, said: str) -> None:
    sealed_anew(copy, change)
    with pytest.raises(InputError, match=rf"summary\.json: {said}"):
        load_result(copy)


def test_a_law_for_other_mounts_is_refused(copy: Path) -> None:
    table = json.loads((copy / "controller.json").read_text())
    text = json.dumps(table).replace("rear-left", "behind")
    (copy / "controller.json").write_text(text)
    sealed_anew(copy)
    with pytest.raises(InputError, match=r"controller\.json: controller\.outputs: the law commands .*behind"):
        load_result(copy)


@pytest.mark.parametrize("name", FILES[1:])
def test_a_file_that_is_gone_is_missed(copy: Path, name: str) -> None:
    (copy / name).unlink()
    with pytest.raises(InputError, match=rf"{name} is missing"):
        load_result(copy)


# --- what a run has ------------------------------------------------------------------------------------------------

PARTS = [{"kind": "feedforward"}, {"kind": "modal"}]
MANY: dict[str, dict[str, Any]] = {
    "balanced": {"control": {"kind": "passive"}, "output": {"bookkeeping": True}, "points": {}},
    "pushed": {
        "control": {"kind": "passive"},
        "force": [{"kind": "sine", "amplitude": 5.0, "frequency": 20.0}],
        "relative": [{"name": "tool", "from": "spindle-nose", "to": "foot front-left"}],
    },
    "following": {"control": {"kind": "combined", "parts": [*PARTS, {"kind": "adaptive", "lines": [24.5]}]}},
    "learning": {"control": {"kind": "combined", "linearisation": True, "learning": True, "parts": PARTS}},
}


@pytest.mark.parametrize("name", MANY)
def test_what_a_run_must_have_is_what_it_has(name: str, tmp_path: Path) -> None:
    scenario = parse_scenario({**SHORT, **MANY[name], "duration": 0.01, "compare": []})
    result = simulate(scenario)
    assert variables_of(scenario, result.controller) == set(result.dataset.data_vars)
    result.write(tmp_path)
    assert same(load_result(tmp_path), result)


def test_a_run_of_a_python_function_is_read_again(tmp_path: Path) -> None:
    python = ehamj.PythonController(lambda time, measured, limited: np.zeros(4), ["stroke front-left"])
    result = simulate(parse_scenario({**SHORT, "duration": 0.01, "compare": []}), controller=python)
    result.write(tmp_path)
    assert same(load_result(tmp_path), result)


def test_a_force_that_never_comes_is_a_channel_of_zeros(tmp_path: Path) -> None:
    """Its first move begins after the run: the scenario has a force, and its result says how strong it was."""
    jerk = {"kind": "axis-jerk", "moving_mass": 210.0, "begin": 1.0}
    found = simulate(parse_scenario({"duration": 0.01, "plates": "tied", "force": [jerk]}))
    found.save(tmp_path / "found")
    read = load_result(tmp_path / "found")
    np.testing.assert_array_equal(read.dataset["external_force"], np.zeros((read.dataset.sizes["time"], 6)))
