"""What a shell completes: names of scenarios and studies, options, keys after ``--set``; found in sources and schemas,
since to import a command takes seconds, and nobody waits for that at a key."""

import ast
from collections.abc import Iterator, Mapping, Sequence
from importlib import resources
from typing import Any, Final

from typer._click.shell_completion import CompletionItem
from typer.core import TyperCommand

from ehamj.cli.early import FLAGS, TAKING
from ehamj.scenario_files import shipped_identifications, shipped_scenarios, shipped_studies

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
            yield from options(name, self.module, words[0] if words else "")
        elif not words or not before.startswith("-") or before in FLAGS:
            if name == "study" and not words:
                yield from (*_questions(), *shipped_studies())
            elif name == "identify":
                yield from shipped_identifications()
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


def options(name: str, module: str, first: str = "") -> list[str]:
    """Options of a command, as its source writes them or as they follow from its parameters; ``first`` is the first
    word behind it."""
    asked = {**_questions(), **dict.fromkeys(shipped_studies(), ("", ""))} if name == "study" and first else {}
    if asked:
        name, module = ("command", module) if asked.get(first, ("", ""))[0] else ("study_file", "study_file")
    source = _source(f"cli.{module}")
    shared = {
        target.id: node.value
        for node in (*_source("cli.frame").body, *source.body)
        if isinstance(node, ast.Assign)
        for target in node.targets
        if isinstance(target, ast.Name)
    }
    function = next(node for node in ast.walk(source) if isinstance(node, ast.FunctionDef) and node.name == name)
    found = ["--help"]
    if name == "export":  # an option of each format
        calls = (node for file in _files("export") for node in ast.walk(file) if isinstance(node, ast.Call))
        found += [flag for node in calls if _is(node.func, "Format") for flag in _flags(node)]
    for argument in (*function.args.args, *function.args.kwonlyargs):
        if argument.annotation is not None:
            found += _of_parameter(argument.arg, argument.annotation, shared)
    if asked.get(first, ("", ""))[0]:
        found += _of_settings(*asked[first])
    for call in function.decorator_list:  # options of the fields of settings
        if isinstance(call, ast.Call) and _is(call.func, "with_options") and name != "command":
            kind = str(getattr(call.args[0], "id", ""))
            flags = ast.literal_eval(call.args[1]) if call.args[1:] else {}
            without = [one for key in call.keywords if key.arg == "without" for one in ast.literal_eval(key.value)]
            found += _of_settings(_home(source, kind), kind, flags, without)
    return sorted(dict.fromkeys(found))


def _is(node: ast.AST, name: str) -> bool:
    """Whether a node is a name, of a module or not."""
    return getattr(node, "id", getattr(node, "attr", "")) == name


def _of_parameter(name: str, annotation: ast.AST, shared: Mapping[str, ast.AST]) -> list[str]:
    """Options of one parameter: as written, or, where only its help is, as Typer calls it."""
    own = [shared[node.id] for node in ast.walk(annotation) if isinstance(node, ast.Name) and node.id in shared]
    calls = [one for part in (annotation, *own) for one in ast.walk(part) if isinstance(one, ast.Call)]
    said = [_flags(one) for one in calls if _is(one.func, "Option")]
    return [flag for flags in said for flag in flags or [f"--{name.replace('_', '-')}"]]


def _of_settings(
    module: str, kind: str, flags: Mapping[str, str] | None = None, without: Sequence[str] = ()
) -> list[str]:
    """Options of the fields of a settings class, those of its bases in the package too."""
    source, found = _source(module), list[str]()
    defined = next((one for one in source.body if isinstance(one, ast.ClassDef) and one.name == kind), None)
    if defined is None:
        return found
    for base in defined.bases:
        name = str(getattr(base, "id", ""))
        here = any(isinstance(one, ast.ClassDef) and one.name == name for one in source.body)
        if name != "Settings" and (where := module if here else _home(source, name)):
            found += _of_settings(where, name, flags, without)
    for line in defined.body:
        if isinstance(line, ast.AnnAssign) and isinstance(line.target, ast.Name):
            name, classed = line.target.id, "ClassVar" in ast.unparse(line.annotation)
            if not classed and not name.startswith("_") and name not in without:
                found.append(f"--{(flags or {}).get(name, name).replace('_', '-')}")
    return found


def _home(source: ast.Module, name: str) -> str:
    """The module that a name comes from, below the package; empty where it is none of ours."""
    for line in source.body:
        if isinstance(line, ast.ImportFrom) and any(one.name == name for one in line.names):
            return str(line.module).removeprefix("ehamj.") if str(line.module).startswith("ehamj.") else ""
    return ""


def _flags(node: ast.AST) -> list[str]:
    """Options that a piece of source writes."""
    texts = [one.value for one in ast.walk(node) if isinstance(one, ast.Constant) and isinstance(one.value, str)]
    return [text for text in texts if text.startswith("--") and " " not in text]


def _questions() -> dict[str, tuple[str, str]]:
    """Names of the studies that answer one question, as each registers itself; module and class of its settings."""
    return {
        str(node.args[0].value): (module, str(getattr(node.args[1], "id", "")))
        for module, file in zip(_modules("studies"), _files("studies"), strict=True)
        for node in ast.walk(file)
        if isinstance(node, ast.Call) and _is(node.func, "study") and node.args
        if isinstance(node.args[0], ast.Constant)
    }


def _modules(room: str) -> list[str]:
    """The modules of a room."""
    names = sorted(file.name for file in resources.files(f"ehamj.{room}").iterdir() if file.name.endswith(".py"))
    return [f"{room}.{name.removesuffix('.py')}" for name in names]


def _files(room: str) -> list[ast.Module]:
    """What the modules of a room say."""
    return [_source(module) for module in _modules(room)]


def _source(module: str) -> ast.Module:
    *rooms, name = module.split(".")
    folder = resources.files(".".join(("ehamj", *rooms)))
    return ast.parse(folder.joinpath(f"{name}.py").read_text(encoding="utf-8"))
