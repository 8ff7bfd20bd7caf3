"""Options of a command that are the fields of a settings class: names, units and defaults stand there, once."""

import inspect
from collections.abc import Callable, Collection, Mapping
from typing import Annotated, Any, NamedTuple, Self

import typer
from pydantic.fields import FieldInfo

from ehamj.scenario.load import written
from ehamj.settings import Settings

SHOWN = 8
"""Values of a default that --help writes out."""


def with_options(
    settings: type[Settings], flags: Mapping[str, str] | None = None, without: Collection[str] = ()
) -> Callable[[Callable[..., None]], Callable[..., None]]:
    """Decorator of a command: its parameter ``given`` becomes an option for every field of the settings.

    The command gets in it what was written, by field; the settings class judges it.

    Args:
        settings: class of the settings.
        flags: name of the option where it is not the field's.
        without: fields that have no option.
    """
    schema = settings.model_json_schema()["properties"]
    fields = {name: field for name, field in settings.model_fields.items() if name not in without}
    kinds = {name: _Kind.of(schema[name], field) for name, field in fields.items()}

    def decorate(command: Callable[..., None]) -> Callable[..., None]:
        def called(**arguments: Any) -> None:
            texts = {name: arguments.pop(name) for name in kinds}
            given = {name: kinds[name].value(text) for name, text in texts.items() if text is not None}
            command(given=given, **arguments)

        parameters = []
        for parameter in inspect.signature(command, eval_str=True).parameters.values():
            if parameter.name == "given":
                parameters += [_parameter(name, kind, (flags or {}).get(name, name)) for name, kind in kinds.items()]
            else:
                parameters.append(parameter.replace(kind=inspect.Parameter.KEYWORD_ONLY))
        called.__name__, called.__doc__ = command.__name__, command.__doc__
        called.__signature__ = inspect.Signature(parameters)  # type: ignore[attr-defined]
        called.__annotations__ = {one.name: one.annotation for one in parameters}
        return called

    return decorate


class _Kind(NamedTuple):
    """What the text of an option stands for: ``items`` are the JSON schemas of its parts, of one where not ``many``."""

    field: FieldInfo
    items: list[dict[str, Any]]
    many: bool

    @classmethod
    def of(cls, schema: dict[str, Any], field: FieldInfo) -> Self:
        one = next((part for part in schema.get("anyOf", ()) if part["type"] != "null"), schema)
        many = one["type"] == "array"
        return cls(field, one.get("prefixItems") or [one["items"]] if many else [one], many)

    @property
    def flag(self) -> bool:
        return bool(self.items[0]["type"] == "boolean")

    def metavar(self) -> str:
        names = {"integer": "INTEGER", "number": "NUMBER", "string": "NAME"}
        parts = [f"[{'|'.join(one['enum'])}]" if "enum" in one else names[one["type"]] for one in self.items]
        return ",".join(parts) + (",…" if self.many and len(parts) == 1 else "")

    def value(self, text: str | bool) -> Any:
        """What a text says: of a list its parts, between commas; of a number the number, where it is one."""
        if isinstance(text, bool):
            return text
        parts: list[Any] = [part.strip() for part in text.split(",")] if self.many else [text]
        if self.items[0]["type"] in ("integer", "number"):
            parts = [written(part) for part in parts]
        return tuple(parts) if self.many else parts[0]


def _parameter(name: str, kind: _Kind, flag: str) -> inspect.Parameter:
    words, default = kind.field.description or name.replace("_", " "), kind.field.default
    shown = "" if default is None or kind.flag else f" [default: {_shown(default)}]"
    flag = "--" + flag.replace("_", "-")
    if kind.flag and default:
        flag += f"/--no-{flag[2:]}"
    text, kind_of_value = f"{words[0].upper()}{words[1:]}{shown}.", bool if kind.flag else str
    option = typer.Option(flag, help=text, metavar=None if kind.flag else kind.metavar())
    annotation: Any = Annotated[kind_of_value | None, option]
    return inspect.Parameter(name, inspect.Parameter.KEYWORD_ONLY, default=None, annotation=annotation)


def _shown(default: Any) -> str:
    if not isinstance(default, tuple):
        return f"{default:g}" if isinstance(default, float) else str(default)
    if len(default) > SHOWN:
        return f"{len(default)} from {_shown(default[0])} to {_shown(default[-1])}"
    return ",".join(map(_shown, default))
