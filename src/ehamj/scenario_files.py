"""Scenario files: those that ship, by name, and any other by its path, as the tables that they hold."""

from importlib import resources
from pathlib import Path
from typing import Any

from ehamj.errors import InputError, did_you_mean
from ehamj.plain.text import text_of, toml_of

LARGEST = 2**20
"""Most that a scenario may have [B]: ten thousand numbers are a fifth of it, and a megabyte takes a second to read."""


def shipped_scenarios() -> dict[str, Path]:
    """Scenarios that come with ehamj, by name."""
    folder = Path(str(resources.files("ehamj"))) / "scenarios"
    return {path.stem: path for path in sorted(folder.glob("*.toml"))}


def scenario_path(source: str | Path) -> Path:
    """The file of a shipped name or of a path.

    Raises:
        InputError: if there is none.
    """
    shipped = shipped_scenarios()
    if str(source) in shipped:
        return shipped[str(source)]
    path = Path(source)
    if path.is_dir() and (path / "scenario.toml").is_file():
        return path / "scenario.toml"
    if not path.is_file():
        near = did_you_mean(str(source), shipped)
        raise InputError(f"scenario {str(source)!r}: no such file; {near}the shipped ones are {', '.join(shipped)}")
    return path


def scenario_table(path: Path) -> dict[str, Any]:
    """What a scenario file says.

    Raises:
        InputError: if it cannot be read, or is no TOML.
    """
    try:
        text = text_of(path, LARGEST)
    except (OSError, UnicodeDecodeError) as error:
        raise InputError(f"scenario {path}: cannot be read ({error})") from error
    except ValueError as error:
        raise InputError(f"scenario {path}: {error}; long series belong into files of their own") from error
    try:
        return toml_of(text)
    except ValueError as error:
        raise InputError(f"scenario {path}: not valid TOML: {error}") from error
