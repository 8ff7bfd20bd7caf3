"""What standard error says while a command works: words for a person, plain lines for a file."""

import io

import numba
import pytest
from rich.console import Console

from ehamj.cli import progress


@pytest.fixture
def heard(monkeypatch: pytest.MonkeyPatch) -> io.StringIO:
    """Standard error that is no terminal."""
    stream = io.StringIO()
    monkeypatch.setattr(progress, "log", Console(file=stream, force_terminal=False))
    return stream


def test_elsewhere_than_on_a_terminal_it_is_plain_lines(heard: io.StringIO, monkeypatch: pytest.MonkeyPatch) -> None:
    now = iter([0.0, 0.0, 1.0, 6.0, 6.0])
    monkeypatch.setattr("time.monotonic", lambda: next(now))
    with progress.doing("writing [all]") as step:
        step("too soon after the title")
        step("report of [b]one[/b]")
    assert heard.getvalue() == "writing [all]\nwriting [all]: report of [b]one[/b]\n"


def test_on_a_terminal_words_stand_behind_a_spinner(monkeypatch: pytest.MonkeyPatch) -> None:
    stream = io.StringIO()
    monkeypatch.setattr(progress, "log", Console(file=stream, force_terminal=True, width=80))
    with progress.doing("writing") as step:
        step("report of [one]")
    assert "writing: report of [one]" in stream.getvalue()


def test_what_is_compiled_on_the_way_is_said(heard: io.StringIO, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(progress, "EVERY", 0.0)

    def doubled(x: float) -> float:
        return 2.0 * x

    with progress.doing("identify", steps=True):
        assert numba.njit(doubled)(1.5) == 3.0
    assert "identify: compiling doubled, once, 0 of 1\n" in heard.getvalue()
