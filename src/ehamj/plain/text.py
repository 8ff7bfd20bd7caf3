"""JSON and TOML from files of bounded size and depth."""

import json
import re
import tomllib
from pathlib import Path
from typing import Any

LARGEST_TEXT = 64 * 2**20
"""Most that is read of a file of settings, laws or results in text [byte]."""
LONGEST_KEY = 50
"""Most dots in one dotted key: Python's reader of TOML takes memory with the square of them."""
_LONG_KEY = re.compile(rf"(?:\.[ \t]*[\w\"'-]*[ \t]*){{{LONGEST_KEY}}}")


def text_of(path: Path, most: int = LARGEST_TEXT) -> str:
    """The text of a file in UTF-8, of at most so many bytes.

    Raises:
        OSError: if it cannot be read, or is no file (a device or a pipe would never end).
        ValueError: if it is too large, or no UTF-8.
    """
    if not path.is_file():
        raise FileNotFoundError("there is no such file")
    if path.stat().st_size > most:
        raise ValueError(f"it has {path.stat().st_size} bytes, {most} are allowed")
    return path.read_text(encoding="utf-8")


def json_of(path: Path) -> Any:
    """What a JSON file holds.

    Raises:
        OSError, ValueError: as `text_of`, and if it is no JSON; JSON knows no NaN and no infinity.
    """
    try:
        return json.loads(text_of(path), parse_constant=_no_constant)
    except RecursionError:
        raise ValueError("it is nested too deeply") from None


def toml_of(text: str) -> dict[str, Any]:
    """What a text in TOML says.

    Raises:
        ValueError: if it is no TOML.
    """
    long = _LONG_KEY.search(text)
    if long:
        line = text.count("\n", 0, long.start()) + 1
        raise ValueError(f"a key with more than {LONGEST_KEY} dots (at line {line})")
    try:
        return tomllib.loads(text)
    except RecursionError:
        raise ValueError("it is nested too deeply") from None


def _no_constant(name: str) -> None:
    raise ValueError(f"{name} is no JSON")
