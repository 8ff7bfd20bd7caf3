"""The one harness of the command line: it runs inside this process, in an empty folder."""

import json
import re
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any, NamedTuple

import pytest

from ehamj.cli import main
from ehamj.cli.frame import out


class Said(NamedTuple):
    """Exit code, standard output, standard error."""

    code: int
    out: str
    err: str

    @property
    def json(self) -> dict[str, Any]:
        """The single JSON object that is all of standard output."""

        def refuse(constant: str) -> None:
            raise AssertionError(f"{constant} is no JSON")

        found = json.loads(self.out, parse_constant=refuse)  # fails on anything after the object
        assert isinstance(found, dict)
        return found

    @property
    def message(self) -> str:
        """The one message of a refusal: nothing on standard output, no traceback."""
        assert (self.code, self.out) == (2, "")
        assert "Traceback" not in self.err
        (found,) = re.findall(r"^ehamj: (.*)$", self.err, re.MULTILINE)
        return str(found)


Cli = Callable[..., Said]


@pytest.fixture(autouse=True)
def _in_an_empty_folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("COLUMNS", "200")  # what is printed for people does not break in the middle of a word
    monkeypatch.setenv("NO_COLOR", "1")
    monkeypatch.delenv("DISPLAY", raising=False)  # no viewer opens
    monkeypatch.delenv("WAYLAND_DISPLAY", raising=False)
    monkeypatch.setattr(out, "_width", 200)


@pytest.fixture
def cli(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> Cli:
    """The command line inside this process (a process of its own costs seconds)."""

    def call(*arguments: str) -> Said:
        monkeypatch.setattr(sys, "argv", ["ehamj", *arguments])
        with pytest.raises(SystemExit) as stop:
            main()
        return Said(int(stop.value.code or 0), *capsys.readouterr())

    return call
