"""A scenario is refused before its command is imported, and only where it is certain which one is meant."""

from pathlib import Path

import pytest

from ehamj.cli.early import check_early
from ehamj.errors import InputError

WRONG = ["--set", "machine.mas=1"]


@pytest.mark.parametrize(
    "words",
    [
        ["modes", *WRONG],
        ["modes", "vc-c-floor", "--sensitivity", *WRONG],
        ["modes", "--sensitivity", "vc-c-floor", *WRONG],
        ["design", "--set=machine.mas=1", "--out", "runs/0001"],
        ["study", "gains", *WRONG],
        ["study", "--json", "gains", "benchmark", *WRONG],
        ["transmissibility", "benchmark", "--set", "machine.mass=heavy"],
        ["run", "recorded", "--set=machine.mas=1", "--set", "machine.mas=2"],
    ],
)
def test_what_is_wrong_is_said(words: list[str]) -> None:
    with pytest.raises(InputError, match=r"^machine\.mas"):
        check_early(words[0], words[1:])


@pytest.mark.parametrize(
    "words",
    [
        ["modes", "--help", *WRONG],
        ["modes", "no-such-scenario", *WRONG],
        ["modes", "vc-c-floor", "benchmark", *WRONG],
        ["study", "gains", "no-such-scenario", *WRONG],
        ["replay", "vc-c-floor", *WRONG],
        ["study", "gains", "--settings", "benchmark", *WRONG],
        ["run", "--set"],
        ["run", "vc-c-floor", "--out", "benchmark", "--set", "machine.mass=4100"],
    ],
)
def test_what_is_not_certain_is_left_to_the_command(words: list[str]) -> None:
    check_early(words[0], words[1:])


def test_a_key_in_a_file_of_ones_own(tmp_path: Path) -> None:
    path = tmp_path / "own.toml"
    path.write_text("[control]\nkind = 'modal'\nratee = 1e4\n", encoding="utf-8")
    with pytest.raises(InputError, match=r"^control\.ratee = 10000\.0: unknown key; did you mean 'rate'\?"):
        check_early("modes", [str(path)])


def test_a_study_of_ones_name_is_not_the_folder_of_that_name(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "waves").mkdir()
    (tmp_path / "waves" / "scenario.toml").write_text("[machine]\nmas = 1\n", encoding="utf-8")
    check_early("study", ["waves", "--set", "machine.mass=4100"])


def test_settings_count_in_the_order_in_which_they_stand() -> None:
    places = '{name="a",position=[0.6,0.4]},{name="b",position=[0.6,-0.4]},{name="c",position=[-0.6,0]}'
    check_early("modes", ["metrology-room", f"--set=mount=[{places}]", "--set", "mount.a.height=1e-5"])
