"""What summary.json holds: every key, with what is said of it where it is declared."""

import ast
import inspect
import re
import textwrap
from collections.abc import Iterator
from typing import Any, get_args

from ehamj.findings import Finding
from ehamj.judge.summary import Summary


def summary_pages() -> dict[str, str]:
    """Markdown by path within the site."""
    met: dict[type[Finding], None] = {Summary: None}
    queue: list[type[Finding]] = [Summary]
    while queue:
        one = queue.pop(0)
        for kind in _findings(one):
            if kind not in met:
                met[kind] = None
                queue.append(kind)
    intro = (
        "`summary.json`, and `Result.summary` in Python: the numbers that a person asks for first. Units stand in the "
        "names (`_db`, `_hz`, `_s`, `_m3_s`) or beside them; a number that is not finite is null. The key `belongs` "
        "holds the run's identity and a digest of every file.\n"
    )
    parts = ["# Summary\n", intro]
    for kind in met:
        title = "Keys" if kind is Summary else kind.__name__
        said = "" if kind is Summary else f"{_plain(kind.__doc__ or '')}\n"
        rows = [
            f"| `{field.alias or name}` | {_meaning(kind, name)} | {_kind(field.annotation)} |"
            for name, field in kind.model_fields.items()
        ]
        parts += [
            f"## {title} {{ #{title.lower()} }}\n",
            said,
            "| key | what it is | holds |",
            "|---|---|---|",
            *rows,
            "",
        ]
    return {"reference/results/summary.md": "\n".join(parts)}


def _findings(kind: type[Finding]) -> Iterator[type[Finding]]:
    """Findings that a finding's keys hold."""
    for field in kind.model_fields.values():
        yield from _within(field.annotation)


def _within(annotation: Any) -> Iterator[type[Finding]]:
    if isinstance(annotation, type) and issubclass(annotation, Finding):
        yield annotation
    for part in get_args(annotation):
        yield from _within(part)


def _documented(kind: type) -> dict[str, str]:
    """What stands below each field in the source, of the class and of those that it inherits from."""
    found: dict[str, str] = {}
    for one in reversed(kind.__mro__):
        if issubclass(one, Finding) and one is not Finding:
            body = ast.parse(textwrap.dedent(inspect.getsource(one))).body[0]
            assert isinstance(body, ast.ClassDef)
            for field, text in zip(body.body, body.body[1:], strict=False):
                if (
                    isinstance(field, ast.AnnAssign)
                    and isinstance(text, ast.Expr)
                    and isinstance(field.target, ast.Name)
                ):
                    found[field.target.id] = str(ast.literal_eval(text.value))
    return found


def _meaning(kind: type[Finding], name: str) -> str:
    """What is said of a key; where nothing is, what is said of that which it holds."""
    own = _documented(kind).get(name, "")
    held = next(_within(kind.model_fields[name].annotation), None)
    return _plain(own or (held.__doc__ or "" if held is not None else ""))


def _kind(annotation: Any) -> str:
    """A type in words, findings as links."""
    if isinstance(annotation, type) and issubclass(annotation, Finding):
        return f"[{annotation.__name__}](#{annotation.__name__.lower()})"
    parts = get_args(annotation)
    if not parts:
        words = {"str": "text", "float": "number", "int": "whole number", "bool": "true or false", "Any": "…"}
        name = getattr(annotation, "__name__", str(annotation))
        return "null" if annotation is type(None) else words.get(name, name)
    if getattr(annotation, "__origin__", None) is dict:
        return f"{_kind(parts[1])}, by name"
    if getattr(annotation, "__origin__", None) in (list, tuple):
        return f"list of {_kind(parts[0])}"
    if all(isinstance(part, str) for part in parts):
        return ", ".join(f"`{part}`" for part in parts)
    return " or ".join(dict.fromkeys(_kind(part) for part in parts if not isinstance(part, str | bytes)))


def _plain(text: str) -> str:
    """One line of a docstring."""
    first = text.strip().split("\n\n")[0].replace("\n", " ")
    return re.sub(r"\s+", " ", re.sub(r"([|$*])", r"\\\1", first))
