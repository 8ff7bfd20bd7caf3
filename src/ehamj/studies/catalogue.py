"""The studies that `ehamj study` runs: each registers itself where it stands; they are listed in this order."""

from typing import Any

from ehamj.studies import (  # noqa: F401  # isort: skip
    rocking,
    lateral,
    unequal,
    valve_oil,
    valves,
    gains,
    failed,
    levels,
    preview,
    tolerances,
    soft_mounts,
    waves,
)
from ehamj.scenario.load import Given, as_scenario
from ehamj.studies.outcome import Outcome, Progress, silent
from ehamj.studies.study import STUDIES

__all__ = ["STUDIES", "study"]


def study(name: str, scenario: Given = "recorded", progress: Progress = silent, **settings: Any) -> Outcome:
    """Ask a registered study, as ``ehamj study`` does: ``ehamj.study("tolerances", "vc-c-floor", number=100)``.

    Args:
        name: one of `STUDIES`.
        scenario: as `ehamj.simulate` takes it.
        progress: called with what is being done.
        settings: the study's own, by name (``ehamj study NAME --help``); by default its defaults.

    Raises:
        InputError: if there is no such study, a setting is not allowed, or the scenario does not allow the study.
    """
    found = STUDIES.find(name)
    return found(as_scenario(scenario), found.with_settings(settings), progress)
