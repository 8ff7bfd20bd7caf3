"""A finished run is kept whatever fails after its last step, and what is wrong is known before its first one."""

import json
from pathlib import Path
from typing import Any

import pytest
import tomli_w

from ehamj import store
from ehamj.cli import main
from ehamj.errors import InputError, NotShown
from ehamj.result import load_result
from ehamj.run import drive, summarise
from ehamj.run.simulate import simulate
from ehamj.scenario.load import parse_scenario
from ehamj.store import check_shown

SHORT: dict[str, Any] = {
    "name": "short",
    "duration": 0.05,
    "plates": "tied",
    "ground": {"kind": "sine", "dof": "z", "amplitude": 2e-6, "frequency": 25.0},
    "output": {"replay": False, "report": False},
}


def fails(*of: Any, **more: Any) -> Any:
    raise ZeroDivisionError("nobody foresaw it")


def ended(capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch, *words: str) -> tuple[Any, str, str]:
    """Exit code of a command, and what it said on standard output and error, without line breaks."""
    monkeypatch.setattr("sys.argv", ["ehamj", *words])
    with pytest.raises(SystemExit) as caught:
        main()
    out, err = capsys.readouterr()
    return caught.value.code, " ".join(out.split()), " ".join(err.split())


@pytest.fixture
def file(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A short scenario; commands run beside it."""
    monkeypatch.chdir(tmp_path)
    path = tmp_path / "short.toml"
    path.write_text(tomli_w.dumps(SHORT))
    return path


@pytest.mark.parametrize(
    ("part", "function"), [("margins", "loop_margins"), ("isolation", "isolation"), ("peak, rms", "peak_and_rms")]
)
def test_what_cannot_be_judged_is_named_and_all_else_is_kept(
    part: str, function: str, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    scenario = parse_scenario(SHORT)
    whole = simulate(scenario)
    real = getattr(summarise, function)
    calls = iter((fails, *[real] * 9))  # the judgement of nothing, which stands there instead, works
    monkeypatch.setattr(summarise, function, lambda *of, **more: next(calls)(*of, **more))
    result = simulate(scenario)
    assert result.complete
    assert result.summary.unjudged == {part: "ZeroDivisionError: nobody foresaw it"}
    assert result.summary.warnings[0] == f"not judged: {part} (ZeroDivisionError: nobody foresaw it)"
    assert result.dataset.identical(whole.dataset)
    assert result.summary.oil == whole.summary.oil
    with pytest.raises(NotShown, match=rf"{part} of 'short' could not be judged.*kept in"):
        result.save(tmp_path / "kept")
    assert load_result(tmp_path / "kept").summary == result.summary


@pytest.mark.parametrize("shown", ["report", "replay"])
def test_a_page_that_fails_takes_no_result_with_it(
    shown: str, file: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr("ehamj.store.write_report" if shown == "report" else "ehamj.store._write_replay", fails)
    words = ("run", str(file), "--set", f"output.{shown}=true", "--out", "kept", "--json")
    code, out, err = ended(capsys, monkeypatch, *words)
    assert code == 3
    assert f"`ehamj {shown} kept` makes it" in err
    assert "ZeroDivisionError: nobody foresaw it" in err
    assert json.loads(out)["summary"] == load_result(Path("kept")).summary


def test_a_failed_page_of_a_variant_leaves_the_other_pages(file: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    real = store.write_report
    monkeypatch.setattr(
        store, "write_report", lambda folder, shown: (fails if folder.name == "passive" else real)(folder, shown)
    )
    scenario = parse_scenario({**SHORT, "compare": ["passive"], "output": {"replay": False}})
    with pytest.raises(NotShown, match=r"report of .*passive could not be made.*`ehamj report kept/passive`"):
        simulate(scenario).save("kept", variants=[simulate(scenario.variant("passive"))])
    assert Path("kept/report.html").is_file()
    assert not Path("kept/passive/report.html").exists()
    load_result("kept/passive")


# --- before the first step ----------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("sets", "said"),
    [
        (["compare=['passive', 'passive']"], "compare.1 = 'passive': stands there twice"),
        (
            ["criteria.response_spectrum={first=1.05, last=1.05}"],
            "no natural frequency lies from first = 1.05 Hz to last = 1.05 Hz",
        ),
        (
            ["compare=['other']", "variants.other.control={kind='law', file='nowhere.json'}"],
            "nowhere.json': cannot be read",
        ),
        (
            ["compare=['other']", "variants.other.criteria={norms=['nowhere.csv']}"],
            "nowhere.csv",
        ),
        ([f"variants.{'a' * 65}.seed=1"], "(64 at most)"),
    ],
)
def test_what_is_wrong_is_refused_before_any_step(
    sets: list[str], said: str, file: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(drive, "advance", fails)
    words = [word for one in sets for word in ("--set", one)]
    code, _, err = ended(capsys, monkeypatch, "run", str(file), *words)
    assert said in err
    assert code == 2
    assert not Path("runs").exists() or not list(Path("runs").iterdir())


@pytest.mark.parametrize("name", ["a" * 230, "b" * 300, "/".join(["c" * 150] * 27)])
@pytest.mark.parametrize("command", ["run", "study", "design", "transmissibility", "paper"])
def test_a_name_that_is_too_long_is_refused_before_any_work(
    command: str, name: str, file: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    words = {"study": ["study", "rocking", str(file)], "paper": ["paper"]}.get(command, [command, str(file)])
    code, _, err = ended(capsys, monkeypatch, *words, "--out", name)
    assert code == 2
    assert "--out" in err
    assert "are possible" in err


def test_one_natural_frequency_is_enough(file: Path) -> None:
    spectrum = {"first": 10.0, "last": 10.0}
    result = simulate(parse_scenario({**SHORT, "criteria": {"response_spectrum": spectrum}}))
    assert result.summary.response_spectrum is not None
    assert result.summary.response_spectrum.frequency_hz == pytest.approx([10.0])


def test_a_scenario_s_own_response_spectrum_needs_a_frequency() -> None:
    with pytest.raises(InputError, match="no natural frequency"):
        parse_scenario({**SHORT, "criteria": {"response_spectrum": {"first": 1.05, "last": 1.1}}})


def test_all_that_is_lost_is_said(tmp_path: Path) -> None:
    lost = {"report of a": (Path(), OSError("full")), "replay of b": (Path("b"), ValueError("odd"))}
    with pytest.raises(
        NotShown, match=r"report of a could not .*`ehamj report .*replay of b could not .*`ehamj replay"
    ):
        check_shown(tmp_path, lost, [])
