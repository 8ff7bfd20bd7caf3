"""Options of a command that are the fields of a settings class: names, units and defaults stand there, once."""

import inspect
from collections.abc import Callable, Collection, Mapping
from typing import Annotated, Any, Literal, get_args, get_origin

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
    fields = {name: field for name, field in settings.model_fields.items() if name not in without}

    def decorate(command: Callable[..., None]) -> Callable[..., None]:
        def called(**arguments: Any) -> None:
            texts = {name: arguments.pop(name) for name in fields}
            given = {name: _value(fields[name], text) for name, text in texts.items() if text is not None}
            command(given=given, **arguments)

        parameters = []
        for parameter in inspect.signature(command, eval_str=True).parameters.values():
            if parameter.name == "given":
                parameters += [_parameter(name, field, (flags or {}).get(name, name)) for name, field in fields.items()]
            else:
                parameters.append(parameter.replace(kind=inspect.Parameter.KEYWORD_ONLY))
        called.__name__, called.__doc__ = command.__name__, command.__doc__
        called.__signature__ = inspect.Signature(parameters)  # type: ignore[attr-defined]
        called.__annotations__ = {one.name: one.annotation for one in parameters}
        return called

    return decorate


def _parameter(name: str, field: FieldInfo, flag: str) -> inspect.Parameter:
    words = field.description or name.replace("_", " ")
    shown = _shown(field.default)
    option: dict[str, Any] = {"help": f"{words[0].upper()}{words[1:]}" + (f" [default: {shown}]." if shown else ".")}
    kind: Any = bool
    if field.annotation is not bool:
        kind, option["metavar"] = str, _metavar(field)
    flag = "--" + flag.replace("_", "-")
    if field.annotation is bool and field.default:
        flag += f"/--no-{flag[2:]}"
    annotation = Annotated[kind | None, typer.Option(flag, **option)]
    return inspect.Parameter(name, inspect.Parameter.KEYWORD_ONLY, default=None, annotation=annotation)


def _leaves(annotation: Any) -> list[Any]:
    """What a type is made of: the types and, of literals, the values in it."""
    if get_origin(annotation) is Literal:
        return list(get_args(annotation))
    if get_origin(annotation) is Annotated:
        return _leaves(get_args(annotation)[0])
    parts = [leaf for part in get_args(annotation) if part is not ... for leaf in _leaves(part)]
    return parts or [annotation]


def _is_list(field: FieldInfo) -> bool:
    return any(get_origin(part) is tuple for part in (field.annotation, *get_args(field.annotation)))


def _is_number(field: FieldInfo) -> bool:
    return not {int, float}.isdisjoint(_leaves(field.annotation))


def _metavar(field: FieldInfo) -> str:
    leaves = [leaf for leaf in _leaves(field.annotation) if leaf is not type(None)]
    if _is_number(field):
        one = "INTEGER" if leaves[0] is int else "NUMBER"
    else:
        one = "NAME" if str in leaves else f"[{'|'.join(map(str, leaves))}]"
    if not _is_list(field):
        return one
    return ",".join([one] * len(leaves)) if _is_number(field) and len(leaves) > 1 else f"{one},…"


def _shown(default: Any) -> str:
    if not isinstance(default, tuple):
        return "" if default is None or isinstance(default, bool) else _text(default)
    if len(default) > SHOWN:
        return f"{len(default)} from {_text(default[0])} to {_text(default[-1])}"
    return ",".join(map(_text, default))


def _text(value: Any) -> str:
    return f"{value:g}" if isinstance(value, float) else str(value)


def _value(field: FieldInfo, text: str | bool) -> Any:
    """What a text says: of a list its parts, between commas; of a number the number, where it is one."""
    if isinstance(text, bool):
        return text
    parts: list[Any] = [part.strip() for part in text.split(",")] if _is_list(field) else [text]
    if _is_number(field):
        parts = [written(part) for part in parts]
    return tuple(parts) if _is_list(field) else parts[0]
