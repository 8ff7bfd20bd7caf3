"""Shared fixtures; the rules that linear algebra takes one thread, and that no test leaves a callback in MuJoCo."""

import os
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest
from harness import Cli, Said
from hypothesis import settings

# Tests run side by side, one process a core. BLAS, read at numpy's import, would start a thread a core in each, and
# threads that wait for each other by spinning slow large decompositions down tenfold.
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

from ehamj.mujoco.hold import installed

# A change is judged by the examples that the one before it was judged by; `--hypothesis-profile hunt` looks for new
# ones. No example has a deadline: machines stall.
settings.register_profile("same", deadline=None, derandomize=True)
settings.register_profile("hunt", deadline=None, print_blob=True)
settings.load_profile("same")


@pytest.fixture(autouse=True)
def _no_callback_left_behind() -> Iterator[None]:
    yield
    assert not any(installed().values()), "a MuJoCo callback was left installed"


@pytest.fixture
def empty_folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """The test stands in an empty folder, before a wide terminal without colours or a screen."""
    from ehamj.cli.frame import out

    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("COLUMNS", "200")  # what is printed for people does not break in the middle of a word
    monkeypatch.setenv("NO_COLOR", "1")
    monkeypatch.delenv("DISPLAY", raising=False)  # no viewer opens
    monkeypatch.delenv("WAYLAND_DISPLAY", raising=False)
    monkeypatch.setattr(out, "_width", 200)


@pytest.fixture
def cli(empty_folder: None, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> Cli:
    """The one harness of the command line: it runs inside this process (one of its own costs seconds)."""
    from ehamj.cli import main

    def call(*arguments: str) -> Said:
        monkeypatch.setattr(sys, "argv", ["ehamj", *arguments])
        with pytest.raises(SystemExit) as stop:
            main()
        return Said(int(stop.value.code or 0), *capsys.readouterr())

    return call
