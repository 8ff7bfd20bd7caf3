"""What people read fits their terminal: no line is longer than it is wide, and no word is cut."""

import re
from collections.abc import Callable
from types import SimpleNamespace

import pytest
from harness import Cli, Said

import ehamj.bench.bench
from ehamj.cli.folding import folded, hung, laid_out
from ehamj.cli.frame import log, out
from ehamj.cli.printing import print_table
from ehamj.verify import CASES

QUICK = ("--set", "plates='tied'", "--set", "duration=0.1")
PRINTED: dict[str, tuple[str, ...]] = {
    "run": ("workshop", *QUICK, "--no-replay", "--no-report", "--out", "made"),
    "a run that fails": (
        *("run", "benchmark", "--no-replay", "--no-report", "--set", "compare=[]", "--set", "timestep=0.005"),
        *("--set", "record_rate=200", "--set", "actuators.isolator.moving_volume=true", "--set", "duration=1"),
        *("--set", "control.signals=[{kind='step', amplitude=5.0, mounts=['rear-left']}]"),
    ),
    "scenarios": (),
    "study": (),
    "a study": ("study", "lateral", *QUICK, "--points", "3"),
    "design": ("benchmark", "--architecture", "feedforward", *QUICK),
    "modes": ("workshop",),
    "modes that are moved": ("modes", "benchmark", *QUICK, "--sensitivity"),
    "modes that are measured": ("modes", "benchmark", *QUICK, "--measured", "ring-down"),
    "statics": ("workshop", "--shims", "level"),
    "transmissibility": ("benchmark", *QUICK, "--dofs", "z", "--lines", "2", "--from", "20", "--to", "50"),
    "export": ("benchmark", "--mjcf", "model.xml"),
    "paper": (),
    "bench": (),
    "the parts of a bench": ("bench", "--list"),
    "verify": (),
    "a refusal": ("run", "workshop", "--set", "machine.mas=4000", "--set", "machine.height=2"),
}
"""Words of each command that prints for people; keys that are no command say what is tried."""
FAILING = ("a run that fails", "a refusal")
NARROW = ("scenarios", "study", "modes", "statics", "paper", "bench", "verify", "a refusal")
"""What is tried before a terminal of 60 columns too."""


@pytest.fixture
def terminal(cli: Cli, monkeypatch: pytest.MonkeyPatch) -> Callable[..., Said]:
    """A command line before a terminal of so many columns, which says what it printed without control characters."""

    def call(width: int, *words: str) -> Said:
        for console in (out, log):
            monkeypatch.setattr(console, "_width", width)
            monkeypatch.setattr(console, "_force_terminal", True)
        said = cli(*words)
        return said._replace(out=plain(said.out), err=plain(said.err))

    return call


def plain(text: str) -> str:
    """Without what moves and colours."""
    return re.sub(r"\x1b\[[0-9;?]*[A-Za-z]", "", text)


@pytest.fixture
def _found_at_once(monkeypatch: pytest.MonkeyPatch) -> None:
    """What takes a minute has tests of its own; its tables are here at once."""
    row = SimpleNamespace(
        name="hydro-mechanical frequency, chamber volume ÷ 2",
        stated="363 Hz",
        computed="362.3 Hz",
        deviation="−0.7 Hz (−0.2 %)",
        comment="agrees within the rounding of Table I; 256.7 Hz initially would give all six",
    )
    monkeypatch.setattr("ehamj.paper.reproduction.reproduce", lambda: SimpleNamespace(to_dict=dict, table=(row,)))
    for name in ("page.write_paper", "amplitude.amplitude_response", "amplitude.write_amplitude"):
        monkeypatch.setattr(f"ehamj.paper.{name}", lambda *_: None)
    checked = tuple(SimpleNamespace(case=case, error=1.234e-5, passed=True) for case in CASES.values())
    monkeypatch.setattr("ehamj.verify.verify", lambda **_: checked)
    timed = SimpleNamespace(
        title="A step of the benchmark case",
        words="time per step over that of the bare engine without hydraulics; less is better",
        heads=("engine", "ratio", "what it does"),
        rows=[("small-motion, eight side by side", "0.12", "matrices about the equilibrium, in lanes")],
    )
    monkeypatch.setattr(ehamj.bench.bench, "measured", lambda *_: {})
    monkeypatch.setattr(ehamj.bench.bench, "bench_tables", lambda _: [timed])


@pytest.mark.usefixtures("_found_at_once")
@pytest.mark.parametrize(("what", "width"), [*((what, 80) for what in PRINTED), *((what, 60) for what in NARROW)])
def test_no_line_is_longer_than_the_terminal_and_no_word_is_cut(
    terminal: Callable[..., Said], what: str, width: int
) -> None:
    words = PRINTED[what]
    said = terminal(width, *(words if " " in what else (what, *words)))
    if what in FAILING:
        assert said.code in (2, 3)
    else:
        assert said.code == 0, said.err
    last = said.err.split("ehamj: ")[-1] if what in FAILING else ""
    for line in (said.out + last).splitlines():
        assert len(line.rstrip()) <= width, line
        assert "…" not in line


def test_elsewhere_a_message_is_one_line(cli: Cli) -> None:
    said = cli("scenarios")
    assert max(map(len, said.out.splitlines())) > 100


def test_a_line_breaks_between_words_and_not_before_a_unit() -> None:
    assert hung("a level of 12 µm/s at 31.5 Hz", 16) == "a level of\n  12 µm/s at\n  31.5 Hz"
    assert hung("  indented text here", 12) == "  indented\n  text here"
    assert folded("a-path-without-an-end", 5) == "a-path-without-an-end"


def test_a_table_takes_its_least_before_it_breaks_its_words() -> None:
    assert laid_out(["a", "b"], [["one two", "12.5"]], [False, True], 12) == [7, 4]
    assert laid_out(["a", "b"], [["one two", "12.5"]], [False, True], 8) == [4, 4]
    assert laid_out(["a", "b"], [["one two", "12.5"]], [False, True], 6) is None


def test_a_table_without_room_is_a_block_of_lines_per_row(
    empty_folder: None, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(out, "_width", 20)
    print_table("", ("what", "how many"), [("hydromechanical-frequency", "12.5")])
    assert capsys.readouterr().out == "hydromechanical-frequency\n  how many: 12.5\n\n"
