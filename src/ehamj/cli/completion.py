"""What a shell completes: names of scenarios and studies, options, keys after ``--set``; found in sources and schemas,
since to import a command takes seconds, and nobody waits for that at a key."""

import ast
from collections.abc import Iterator, Mapping
from importlib import resources
from typing import Any, Final

from typer._click.shell_completion import CompletionItem
from typer.core import TyperCommand

from ehamj.cli.early import TAKING
from ehamj.scenario_files import shipped_scenarios, shipped_studies

KEY: Final = "--set"
"""Option whose word is a key of the scenario."""


class Completing(TyperCommand):
    """A command of which only the words are known that stand so far."""

    def __init__(self, name: str, module: str) -> None:
        super().__init__(name, context_settings={"ignore_unknown_options": True, "allow_extra_args": True})
        self.module = module

    def shell_complete(self, ctx: Any, incomplete: str) -> list[Any]:
        """What the word that is begun may become; a shell adds its own files where nothing is offered."""
        words = self._words(ctx.args[-1] if ctx.args else "", ctx.args, incomplete)
        return [CompletionItem(word) for word in words if word.startswith(incomplete)]

    def _words(self, before: str, words: list[str], incomplete: str) -> Iterator[str]:
        name = str(self.name)
        if before == KEY:
            yield from keys(incomplete)
        elif incomplete.startswith("-"):
            yield from options(name, self.module)
        elif not before.startswith("-") or not words:
            if name == "study" and not words:
                yield from (*questions(), *shipped_studies())
            elif name in (*TAKING, "export"):
                yield from shipped_scenarios()


def keys(incomplete: str) -> Iterator[str]:
    """Keys of a scenario in the table that is begun, and one table further, each also with its default: of several
    words a shell writes what they share, and no blank after it."""
    from ehamj.scenario.model import Scenario

    schema = Scenario.model_json_schema()
    path = incomplete.split(".")[:-1]
    tables: list[Mapping[str, Any]] = [schema]
    for part in path:
        tables = [one for table in tables for one in _tables(_below(table, part), schema)]
    yield from dict.fromkeys(word for table in tables for word in _listed(table, schema, path, deeper=True))


def _listed(
    table: Mapping[str, Any], schema: Mapping[str, Any], path: list[str], deeper: bool = False
) -> Iterator[str]:
    for name, value in table.get("properties", {}).items():
        below, key = list(_tables(value, schema)), ".".join((*path, name))
        for one in below if deeper else ():
            yield from _listed(one, schema, [*path, name]) if "properties" in one else [f"{key}."]
        if not below:
            yield f"{key}="
            if isinstance(value.get("default"), bool | int | float | str):
                yield f"{key}={_written(value['default'])}"


def _written(value: bool | int | float | str) -> str:
    """A value as TOML has it, or a word."""
    return str(value).lower() if isinstance(value, bool) else str(value)


def _below(table: Mapping[str, Any], part: str) -> Mapping[str, Any]:
    """What a table holds under a key: of its own, or of any name that a user gives."""
    found: Any = table.get("properties", {}).get(part) or table.get("additionalProperties")
    return found if isinstance(found, Mapping) else {}


def _tables(value: Mapping[str, Any], schema: Mapping[str, Any]) -> Iterator[Mapping[str, Any]]:
    """The tables that a value may be, of all its kinds."""
    if "$ref" in value:
        value = schema["$defs"][value["$ref"].rpartition("/")[2]]
    for kind in ("anyOf", "oneOf", "allOf"):
        for one in value.get(kind, ()):
            yield from _tables(one, schema)
    if "properties" in value or isinstance(value.get("additionalProperties"), Mapping):
        yield value


def options(name: str, module: str) -> list[str]:
    """Options that a command's source writes, its own and those that commands share."""
    shared = {
        target.id: _flags(node.value)
        for node in (*_source("frame").body, *_source(module).body)
        if isinstance(node, ast.Assign)
        for target in node.targets
        if isinstance(target, ast.Name)
    }
    function = next(node for node in _source(module).body if isinstance(node, ast.FunctionDef) and node.name == name)
    found = ["--help"]
    if name == "export":  # an option of each format
        found += [
            flag
            for file in resources.files("ehamj.export").iterdir()
            if file.name.endswith(".py")
            for node in ast.walk(ast.parse(file.read_text(encoding="utf-8")))
            if isinstance(node, ast.Call) and isinstance(node.func, ast.Name) and node.func.id == "Format"
            for flag in _flags(node)
        ]
    for argument in (*function.args.args, *function.args.kwonlyargs):
        if argument.annotation is not None:
            own = [node.id for node in ast.walk(argument.annotation) if isinstance(node, ast.Name)]
            found += [*_flags(argument.annotation), *(flag for one in own for flag in shared.get(one, ()))]
    return sorted(dict.fromkeys(found))


def _flags(node: ast.AST) -> list[str]:
    """Options that a piece of source writes."""
    texts = [one.value for one in ast.walk(node) if isinstance(one, ast.Constant) and isinstance(one.value, str)]
    return [text for text in texts if text.startswith("--") and " " not in text]


def questions() -> Iterator[str]:
    """Names of the studies that answer one question, as each registers itself."""
    for file in resources.files("ehamj.studies").iterdir():
        if file.name.endswith(".py"):
            for node in ast.walk(ast.parse(file.read_text(encoding="utf-8"))):
                if isinstance(node, ast.Call) and isinstance(node.func, ast.Name) and node.func.id == "study":
                    yield from (str(one.value) for one in node.args[:1] if isinstance(one, ast.Constant))


def _source(module: str) -> ast.Module:
    return ast.parse(resources.files("ehamj.cli").joinpath(f"{module}.py").read_text(encoding="utf-8"))
