"""Every page of the documentation does what it shows: its blocks run in order, in one folder, as a reader types them.

`python` runs in one namespace; `sh` are commands of ehamj; a block with `title="file"` is that file; `toml` without one
is a part of a scenario, and must be one; `text` is what the block before it printed. `console` is for what is outside
of ehamj, and does not run.
"""

import shlex
import tomllib
from pathlib import Path
from typing import Any

import pytest
from blocks import Block, blocks, commands, missing
from harness import Cli

from ehamj.scenario.load import parse_scenario

DOCS = Path(__file__).parents[2] / "docs"
PAGES = sorted(page for page in DOCS.rglob("*.md") if "_build" not in page.parts)
NOT_RUN = {"console", "c"}


def test_there_are_pages() -> None:
    assert {"index.md", "physics.md"} <= {page.name for page in PAGES}


@pytest.mark.parametrize("page", PAGES, ids=lambda page: str(page.relative_to(DOCS)))
def test_page_does_what_it_shows(page: Path, cli: Cli, capsys: pytest.CaptureFixture[str]) -> None:
    left: dict[str, Any] = {"__name__": "reader"}
    printed = ""
    for block in blocks(page.read_text("utf-8")):
        where = f"{page.relative_to(DOCS)}, line {block.line}"
        if block.title:
            Path(block.title).write_text(block.body, encoding="utf-8")
        elif block.language == "python":
            exec(compile(block.body, where, "exec"), left)
            printed = capsys.readouterr().out
        elif block.language == "sh":
            printed = typed(block, where, cli)
        elif block.language == "toml":
            scenario = parse_scenario(tomllib.loads(block.body))
            if scenario.ground.kind == "record":
                scenario.motion()  # reads its file
        elif block.language == "text":
            assert missing(block.body, printed) == [], f"{where} shows what was not printed:\n{printed}"
        else:
            assert block.language in NOT_RUN, f"{where}: who runs {block.language}?"


def typed(block: Block, where: str, cli: Cli) -> str:
    """What the commands of a block print, on both streams; each must succeed."""
    printed = ""
    for command in commands(block):
        program, *arguments = shlex.split(command)
        assert program == "ehamj", f"{where}: {command} is no command of ehamj"
        said = cli(*arguments)
        assert said.code == 0, f"{where}: {command}\n{said.err}"
        printed += said.out + said.err
    return printed


@pytest.mark.parametrize(
    ("shown", "printed", "found"),
    [
        ("margins: gain 9.8 dB", "  margins:  gain\n9.8 dB, phase", []),
        ("gain 9.8 dB\n…\nphase 47°", "gain 9.7 dB and phase 48° it has", []),
        ("gain 9.8 dB", "gain 9.4 dB", ["gain 9.8 dB"]),
        ("a ─── 100", "a 102", []),
    ],
)
def test_what_is_shown_is_compared(shown: str, printed: str, found: list[str]) -> None:
    assert missing(shown, printed) == found
