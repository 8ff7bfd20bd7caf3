"""What a shell is told that asks: names, options and keys; nothing slow is imported for it."""

import os
import subprocess
import sys
from importlib import import_module

import pytest
import typer

from ehamj.cli.completion import options
from ehamj.scenario_files import shipped_scenarios

CODE = (
    "import atexit, sys; slow = {'mujoco', 'numba', 'xarray', 'rerun', 'matplotlib', 'scipy.signal'}; "
    "atexit.register(lambda: print('SLOW', *(slow & set(sys.modules)), file=sys.stderr)); "
    "from ehamj.cli import main; main()"
)


def offered(words: str) -> set[str]:
    """What is offered for the last of some words, or for one not yet begun after a blank."""
    asked = {"COMP_WORDS": words, "COMP_CWORD": str(len(words.split(" ")) - 1), "_EHAMJ_COMPLETE": "complete_bash"}
    done = subprocess.run(
        [sys.executable, "-c", CODE], env=os.environ | asked, capture_output=True, text=True, check=True
    )
    assert done.stderr.split() == ["SLOW"]
    return set(done.stdout.split())


@pytest.mark.parametrize(
    ("words", "some", "others"),
    [
        ("ehamj st", {"study", "statics"}, {"run"}),
        ("ehamj study w", {"waves"}, {"failed"}),
        ("ehamj run recorded --no", {"--no-report", "--no-replay"}, {"--set"}),
        ("ehamj export --m", {"--mjcf"}, {"--set"}),
        ("ehamj run --set actuators.isolator.bulk", {"actuators.isolator.bulk_modulus="}, {"machine.mass="}),
    ],
)
def test_words_that_are_begun(words: str, some: set[str], others: set[str]) -> None:
    found = offered(words)
    assert some <= found
    assert not others & found


def test_a_scenario_is_offered_where_one_is_named() -> None:
    assert offered("ehamj run ") == set(shipped_scenarios())
    assert offered("ehamj run --no-report ") == set(shipped_scenarios())


def test_options_are_all_that_help_lists() -> None:
    """Of each command, of a study's question, and of a study file; only hidden ones and the negations are left out."""
    from ehamj.cli.frame import COMMANDS, app
    from ehamj.cli.study import FILE, studies

    for module in set(COMMANDS.values()):
        import_module(f"ehamj.cli.{module}")
    for name, command in typer.main.get_group(app).commands.items():
        if name != "study" and command is not None:
            told = {option for one in command.params if not one.hidden for option in one.opts if option.startswith("-")}
            assert told <= set(options(name, COMMANDS[name])), name
    for name, command in typer.main.get_group(studies).commands.items():
        word = "footprint" if name == FILE else name
        told = {option for one in command.params for option in one.opts if option.startswith("-")}
        assert told <= set(options("study", "study", word)), name
