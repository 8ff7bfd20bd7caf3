"""Files of settings, as scenarios are: those that ship, by name, and any other by its path, as the tables they hold."""

from collections.abc import Mapping
from importlib import resources
from pathlib import Path
from typing import Any

from ehamj.errors import InputError, did_you_mean
from ehamj.plain.text import text_of, toml_of

LARGEST = 2**20
"""Most that a file may have [B]: ten thousand numbers are a fifth of it, and a megabyte takes a second to read."""


def shipped_scenarios() -> dict[str, Path]:
    """Scenarios that come with ehamj, by name."""
    return shipped_files("scenarios")


def shipped_studies() -> dict[str, Path]:
    """Studies of many designs that come with ehamj, by name."""
    return shipped_files("study_files")


def shipped_identifications() -> dict[str, Path]:
    """Identifications that come with ehamj, their records beside them, by name."""
    return shipped_files("identification_files")


def is_study_file(word: str) -> bool:
    """Whether a word means a study file: a shipped one's name, one that ends as such, or the folder of a study."""
    return word in shipped_studies() or word.endswith(".toml") or (Path(word) / "study.toml").is_file()


def shipped_files(folder: str) -> dict[str, Path]:
    """TOML files of one of the package's folders, by name."""
    return {path.stem: path for path in sorted((Path(str(resources.files("ehamj"))) / folder).glob("*.toml"))}


def scenario_path(source: str | Path) -> Path:
    """The file of a shipped name, of a path, or in a folder.

    Raises:
        InputError: if there is none.
    """
    return path_of(source, shipped_scenarios(), "scenario")


def path_of(source: str | Path, shipped: Mapping[str, Path], kind: str) -> Path:
    """The file of a shipped name, of a path, or ``KIND.toml`` in a folder.

    Raises:
        InputError: if there is none.
    """
    if str(source) in shipped:
        return shipped[str(source)]
    path = Path(source)
    if path.is_dir() and (path / f"{kind}.toml").is_file():
        return path / f"{kind}.toml"
    if not path.is_file():
        near = did_you_mean(str(source), shipped)
        raise InputError(f"{kind} {str(source)!r}: no such file; {near}the shipped ones are {', '.join(shipped)}")
    return path


def scenario_table(path: Path) -> dict[str, Any]:
    """What a scenario file says.

    Raises:
        InputError: if it cannot be read, or is no TOML.
    """
    return table_of(path, "scenario")


def table_of(path: Path, kind: str) -> dict[str, Any]:
    """What a file of a kind says.

    Raises:
        InputError: if it cannot be read, or is no TOML.
    """
    try:
        text = text_of(path, LARGEST)
    except (OSError, UnicodeDecodeError) as error:
        raise InputError(f"{kind} {path}: cannot be read ({error})") from error
    except ValueError as error:
        raise InputError(f"{kind} {path}: {error}; long series belong into files of their own") from error
    try:
        return toml_of(text)
    except ValueError as error:
        raise InputError(f"{kind} {path}: not valid TOML: {error}") from error
