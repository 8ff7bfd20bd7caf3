"""Where a key of a table leads: the types of settings, walked without a validator, which takes long to build."""

from functools import cache
from types import NoneType, UnionType
from typing import Annotated, Any, Union, get_args, get_origin, get_type_hints

from pydantic import Tag

from ehamj.settings import Settings


@cache
def keys_of(settings: type[Settings]) -> dict[str, Any]:
    """The types of the keys of a table, by key as a user writes it."""
    types = get_type_hints(settings, include_extras=True)
    return {field.alias or name: types[name] for name, field in settings.model_fields.items()}


def choices(kind: Any) -> list[Any]:
    """What a value of a type may be, one by one: of a union its members, and no nothing."""
    origin = get_origin(kind)
    if origin is Annotated:
        return choices(get_args(kind)[0])
    if origin in (Union, UnionType):
        return [choice for part in get_args(kind) for choice in choices(part)]
    return [] if kind is NoneType else [kind]


def by_kind(kind: Any) -> dict[str, type[Settings]]:
    """Tables of which ``kind`` says which of them one is, or a tag where their keys do; none where there is no
    choice."""
    tables = _tables(kind)
    if len(tables) < 2:
        return {}
    if tags := _tags(kind):
        return tags
    return {name: table for table in tables for name in get_args(keys_of(table).get("kind"))}


def only(kind: Any) -> Any:
    """The one real choice of a type: what may be left out, or be a name instead, has one; nothing where there are
    more."""
    all_of_them, tables = choices(kind), _tables(kind)
    return all_of_them[0] if len(all_of_them) == 1 else tables[0] if len(tables) == 1 else None


def inside(kind: Any, part: int | str) -> Any:
    """The type of what stands under a part of a key, in a table or a list of a type; nothing where it leads nowhere."""
    if _is_table(kind):
        return keys_of(kind).get(str(part))
    origin, parts = get_origin(kind), get_args(kind)
    if origin is dict:
        return parts[1]
    return parts[0] if origin is tuple and parts[1:] == (...,) and isinstance(part, int) else None


def _is_table(kind: Any) -> bool:
    return isinstance(kind, type) and issubclass(kind, Settings)


def _tags(kind: Any) -> dict[str, type[Settings]]:
    """Tables of a union whose members have tags, by tag."""
    if get_origin(kind) is Annotated:
        inner, *said = get_args(kind)
        tags = [one.tag for one in said if isinstance(one, Tag)]
        return {tags[0]: inner} if tags else _tags(inner)
    parts = get_args(kind) if get_origin(kind) in (Union, UnionType) else ()
    return {tag: table for part in parts for tag, table in _tags(part).items()}


def _tables(kind: Any) -> list[type[Settings]]:
    return [choice for choice in choices(kind) if _is_table(choice)]
