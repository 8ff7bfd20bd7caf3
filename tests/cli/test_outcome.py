"""How a command ends, whatever goes wrong: one message and an exit code."""

import errno
import re
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from ehamj.cli import outcome
from ehamj.cli.outcome import exit_code


@pytest.fixture
def failing(monkeypatch: pytest.MonkeyPatch) -> Any:
    """A command line that ends with an error."""

    def fail(error: BaseException) -> int:
        def app(**_: Any) -> None:
            raise error

        monkeypatch.setattr(outcome, "app", app)
        return exit_code()

    return fail


def test_an_error_that_nobody_foresaw_is_one_line_and_a_file_to_report(
    failing: Any, capsys: pytest.CaptureFixture[str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("tempfile.tempdir", str(tmp_path))
    monkeypatch.setattr(sys, "argv", ["ehamj", "run", "workshop"])
    assert failing(OverflowError("too large\nby far")) == 3
    said = capsys.readouterr().err.strip()
    assert said.startswith("ehamj: OverflowError: too large: this should not happen")
    assert "\n" not in said
    (report,) = tmp_path.iterdir()
    assert str(report) in said
    text = report.read_text()
    assert "run workshop" in text
    assert "by far" in text
    assert "Traceback" in text


@pytest.mark.parametrize(
    ("error", "code", "said"),
    [
        (
            OSError(errno.ENOSPC, "No space left on device", "/a/b"),
            3,
            "'/a/b': No space left on device; what could",
        ),
        (MemoryError(), 2, "this does not fit in memory"),
        (
            FileNotFoundError(errno.ENOENT, "No such file", "/a"),
            3,
            "FileNotFoundError: [Errno 2] No such file: '/a': this",
        ),
        (SystemExit(2), 2, ""),
    ],
)
def test_what_the_system_refuses_is_one_line(
    failing: Any, capsys: pytest.CaptureFixture[str], error: BaseException, code: int, said: str
) -> None:
    assert failing(error) == code
    assert said in capsys.readouterr().err


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="no device here that is always full")
def test_standard_output_that_is_full_is_told() -> None:
    import subprocess

    with Path("/dev/full").open("w") as full:
        command = [sys.executable, "-c", "from ehamj.cli import main; main()", "scenarios", "--json"]
        done = subprocess.run(command, stdout=full, stderr=subprocess.PIPE, text=True, check=False)
    assert done.returncode == 3
    assert "No space left on device" in done.stderr
    assert "Traceback" not in done.stderr


def test_numbers_beyond_computing_are_a_note_and_not_pythons_own_words(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    def app(**_: Any) -> None:
        assert np.isinf(np.float64(1e300) * np.float64(1e300))

    monkeypatch.setattr(outcome, "app", app)
    assert exit_code() == 0
    said = capsys.readouterr().err
    assert re.fullmatch(r"note: .*too large or too small .*\(overflow encountered in .*\)\n", said)
