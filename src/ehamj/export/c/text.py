"""Texts of C: numbers, names and comments."""

import ast
import inspect
import math
import re
import textwrap
from collections.abc import Iterable, Sequence
from typing import Any, Final

import numpy as np

WIDTH: Final = 118
"""Of a line of a table."""
LARGEST: Final = float(np.finfo(np.float32).max)
"""Number beyond which single precision has none."""


def number(value: float) -> str:
    """A number as C takes it in double and in single precision, the very one in double.

    Raises:
        ValueError: if it is not finite, or none in single precision.
    """
    if not math.isfinite(value) or abs(value) > LARGEST:
        raise ValueError(f"{value} is no number that C can be given")
    return repr(float(value))


def comment(text: str) -> str:
    """A text that stands in a comment and does not end it, without three-letter signs of old."""
    return " ".join(text.split()).replace("*/", "* /").replace("/*", "/ *").replace("??", "? ?")


def beside(text: str) -> str:
    """A comment behind what it is about, if there is any."""
    return f" /* {comment(text)} */" if text else ""


def enumerators(names: Iterable[str]) -> list[str]:
    """A name of C's for each of some names, all different."""
    found: list[str] = []
    for name in names:
        plain = re.sub(r"[^A-Z0-9]+", "_", name.upper().encode("ascii", "replace").decode()).strip("_")
        tried, again = plain, 1
        while tried in found:
            again += 1
            tried = f"{plain}_{again}"
        found.append(tried)
    return found


def table(values: Sequence[float] | np.ndarray[Any, Any], whole: bool = False) -> str:
    """The entries of a table, in lines."""
    return filled([str(int(value)) if whole else f"R({number(float(value))})" for value in values])


def filled(entries: Sequence[str]) -> str:
    """Entries in lines."""
    return textwrap.fill(
        ", ".join(entry.replace(" ", "\0") for entry in entries),
        WIDTH, initial_indent="    ", subsequent_indent="    ", break_on_hyphens=False,
    ).replace("\0", " ")  # fmt: skip


def fields_of(kind: Any) -> list[tuple[str, str]]:
    """The fields of a named tuple, each with what stands below it in its source."""
    body = ast.parse(textwrap.dedent(inspect.getsource(kind))).body[0]
    assert isinstance(body, ast.ClassDef)
    said, last = dict.fromkeys(kind._fields, ""), ""
    for statement in body.body:
        if isinstance(statement, ast.AnnAssign) and isinstance(statement.target, ast.Name):
            last = statement.target.id
        elif isinstance(statement, ast.Expr) and isinstance(statement.value, ast.Constant) and last:
            said[last], last = str(statement.value.value), ""
        else:
            last = ""
    return [(name, said[name]) for name in kind._fields]


def used_in(sources: str, fields: Sequence[tuple[str, str]]) -> list[int]:
    """Numbers of those fields of a structure that some C asks for."""
    return [k for k, (name, _) in enumerate(fields) if re.search(rf"(->|\.){name}\b", sources)]
