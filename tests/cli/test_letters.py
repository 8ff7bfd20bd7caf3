"""Terminals without our letters: every text is written, in the letters that they have."""

import io
import os
import subprocess
import sys

import pytest

from ehamj.cli.letters import PLAIN, write_any_letter


@pytest.mark.parametrize(
    ("text", "written"), [("3 µm/s²", "3 um/s^2"), ("ä é ﬁ", "a e fi"), ("振", "?"), ("−1 ± 2", "-1 +/- 2")]
)
def test_a_letter_is_spelled(text: str, written: str, monkeypatch: pytest.MonkeyPatch) -> None:
    for name in ("stdout", "stderr"):
        monkeypatch.setattr(sys, name, io.TextIOWrapper(io.BytesIO(), encoding="ascii"))
    write_any_letter()
    for stream in (sys.stdout, sys.stderr):
        stream.write(text)
        stream.flush()
        assert stream.buffer.getvalue() == written.encode()  # type: ignore[attr-defined]


def test_every_spelling_is_ascii() -> None:
    assert all(written.isascii() for written in PLAIN.values())


def test_an_encoding_with_the_letters_keeps_them(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(sys, "stdout", io.TextIOWrapper(io.BytesIO(), encoding="utf-8"))
    write_any_letter()
    sys.stdout.write("µ")
    sys.stdout.flush()
    assert sys.stdout.buffer.getvalue() == "µ".encode()  # type: ignore[attr-defined]


@pytest.mark.parametrize("words", [("scenarios",), ("run", "benchmark", "--set", "machine.mass='µ'")])
def test_a_terminal_of_c_is_one(words: tuple[str, ...]) -> None:
    command = [sys.executable, "-c", "from ehamj.cli import main; main()", *words]
    told = subprocess.run(command, env={**os.environ, "PYTHONIOENCODING": "ascii"}, capture_output=True, check=False)
    assert told.returncode == (0 if words == ("scenarios",) else 2)
    assert b"should not happen" not in told.stderr
    (told.stdout + told.stderr).decode("ascii")
