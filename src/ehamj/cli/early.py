"""What a command line says of its scenario, understood before the command is imported, which takes seconds: whoever
mistyped a key learns it at once."""

from collections.abc import Sequence
from itertools import pairwise
from typing import Final

from ehamj.errors import InputError
from ehamj.scenario_files import is_study_file, scenario_path

TAKING: Final = ("run", "design", "modes", "statics", "transmissibility", "study", "export")
"""Commands that take a scenario, by default *recorded*, and ``--set``."""

FLAGS: Final = ("--json", "--overwrite", "--no-replay", "--no-report", "--sensitivity", "--all")
"""Options without a word of their own: what stands after one may be the scenario."""
NO_SCENARIO: Final = ("--set", "--out")
"""Options whose word may look like a scenario's name or folder, and is none."""


def check_early(command: str, words: Sequence[str]) -> None:
    """Refuse the scenario that some words after a command name, or what they set in it.

    What is not certain without the command's own options is left to the command, which reads the scenario anyway.

    Raises:
        InputError: as `ehamj.scenario.load.load_scenario`.
    """
    if command not in TAKING or "--help" in words:
        return
    pairs = list(pairwise(("", *words)))
    words_after = [(before, word) for before, word in pairs if not word.startswith("-") and before not in NO_SCENARIO]
    certain = [word for before, word in words_after if not before.startswith("-") or before in FLAGS]
    if command == "study" and any(map(is_study_file, certain[:1])):
        return  # what it sets is the study's
    free = certain[command == "study" :]
    if len(free) > 1 or (free and not _is_scenario(free[0])):
        return
    if len(certain) < len(words_after) and not free:
        return  # what stands after an option may be its word, or the scenario
    from ehamj.scenario.load import check_scenario

    stated = [word for before, word in pairs if before == "--set" or word.startswith("--set=")]
    overrides = [word.removeprefix("--set=") for word in stated]
    check_scenario(free[0] if free else "recorded", overrides)


def _is_scenario(word: str) -> bool:
    try:
        return scenario_path(word).is_file()
    except (InputError, OSError, ValueError):
        return False
