"""What is exported: a scenario with its machine, its law and its step, wherever it was found."""

import re
from collections.abc import Iterable
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Final

from ehamj.belonging import HISTORIES, SUMMARY, check_own, check_unchanged, told
from ehamj.control import LinearController, load_controller
from ehamj.control.architectures.file import Law
from ehamj.control.converter import check_mounts
from ehamj.errors import InputError
from ehamj.mujoco import hydraulics
from ehamj.result import CONTROLLER_FILE
from ehamj.run.timestep import OF_FILE, OF_SCENARIO, choose_timestep
from ehamj.scenario.load import load_scenario
from ehamj.scenario.model import Scenario
from ehamj.scenario_files import shipped_scenarios

DESIGN: Final = "design.json"
"""File without which a folder is no design's."""


@dataclass(frozen=True)
class Subject:
    """What is exported."""

    scenario: Scenario
    folder: Path | None = None
    """Of the result or design that it came from; None of a scenario."""

    @property
    def name(self) -> str:
        """The scenario's, of letters, digits, ``_`` and single ``-`` only, so that a file may be called so."""
        return re.sub(r"[^A-Za-z0-9_]+", "-", self.scenario.name).strip("-") or "machine"

    @cached_property
    def controller(self) -> LinearController | None:
        """The law: the one beside a result or a design, else as a run would have it; None where there is none.

        Raises:
            InputError: if it cannot be read, or derived.
        """
        path = None if self.folder is None else self.folder / CONTROLLER_FILE
        if path is None or not path.is_file():
            return self.scenario.controller()
        law = load_controller(path)
        check_mounts(law.converter, self.scenario.plant.mounts)
        return law

    @cached_property
    def timestep(self) -> float:
        """Integration step that a run would choose [s].

        Raises:
            InputError: if a stated one does not fit, or no reasonable one does.
        """
        of_file = isinstance(self.scenario.control, Law)
        with hydraulics():
            return choose_timestep(self.scenario, self.controller, OF_FILE if of_file else OF_SCENARIO)


def subject_of(source: str | Path, changes: Iterable[str] = ()) -> Subject:
    """What a user names: a shipped scenario, a TOML file, or the folder of a result or a design, with its own law.

    Args:
        source: as he wrote it.
        changes: ``a.b=value`` each, of a scenario.

    Raises:
        InputError: as `load_scenario`; if a result is not as its run wrote it, or ran under a Python function; if a
            result or design is to be changed.
    """
    folder, changes = Path(source), list(changes)
    kind = None if str(source) in shipped_scenarios() else _kind(folder)
    if kind is None:
        return Subject(load_scenario(source, changes))
    if changes:
        raise InputError(
            f"--set {changes[0]}: a {kind} is exported as it is, with its own law; name "
            f"{str(folder / 'scenario.toml')!r} for its scenario, of which keys may be changed"
        )
    if kind == "result":
        _check_result(folder)
    return Subject(load_scenario(folder / "scenario.toml"), folder)


def _kind(folder: Path) -> str | None:
    """Whether a folder is a result's or a design's; None of what is neither."""
    if not (folder / "scenario.toml").is_file():
        return None
    return next((kind for kind, name in (("result", SUMMARY), ("design", DESIGN)) if (folder / name).is_file()), None)


def _check_result(folder: Path) -> None:
    """Raise InputError unless what is read of a result is as its run wrote it, its histories left aside."""
    found = told(folder)
    check_own(found)
    check_unchanged(found, [name for name in found.belongs.files if name != HISTORIES])
    if found.summary.get("python_law"):
        raise InputError(
            f"result {str(folder)!r}: its commands came from a Python function, which no file holds; "
            f"{str(folder / 'scenario.toml')!r} is its machine under its scenario's own control"
        )
