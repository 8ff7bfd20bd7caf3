"""Every command: what it does, its options with their defaults, and examples, which the tests run."""

import re
import tomllib
from importlib import import_module
from pathlib import Path
from typing import Any, Final

import typer
from typer.core import TyperGroup

from ehamj.cli.frame import COMMANDS, app

EXAMPLES: Final = Path(__file__).with_name("examples.toml")
"""Command lines by command, each with what it is for."""


def commands() -> dict[str, Any]:
    """Every command by name, in the order of `ehamj --help`, complete with its options."""
    for module in dict.fromkeys(COMMANDS.values()):
        import_module(f"ehamj.cli.{module}")
    group = typer.main.get_group(app)
    return {name: group.commands[name] for name in COMMANDS}


def examples() -> dict[str, list[dict[str, Any]]]:
    """Examples of each command: ``line``, ``text``; ``run`` = false where it takes minutes."""
    found: dict[str, list[dict[str, Any]]] = tomllib.loads(EXAMPLES.read_text(encoding="utf-8"))
    return found


def command_pages() -> dict[str, str]:
    """Markdown by path within the site."""
    found, shown = commands(), examples()
    listed = [f"| [`ehamj {name}`]({name}.md) | {_first(one.help)} |" for name, one in found.items()]
    index = "\n".join(
        [
            "# Commands\n",
            f"{_words(app.info.help or '')}\n",
            "| command | what it does |",
            "|---|---|",
            *listed,
            "",
            "Every command has `--help`. `--json` prints one JSON object on standard output and nothing else there.\n",
            "| exit code | means |",
            "|---|---|",
            "| 0 | done |",
            "| 1 | `verify`: a case failed |",
            "| 2 | bad input: one message names the key, the value and what is allowed; nothing was written |",
            "| 3 | the simulation failed, or a file could not be written; what was computed until then is kept |",
            "| 130 | interrupted; what was not finished is not kept |",
            "",
        ]
    )
    pages = {name: _page(name, one, shown.get(name, [])) for name, one in found.items()}
    return {f"reference/commands/{name}.md": text for name, text in {"index": index, **pages}.items()}


def _page(name: str, command: Any, shown: list[dict[str, Any]]) -> str:
    parts = [f"# ehamj {name}\n", f"{_words(command.help)}\n", _usage(f"ehamj {name}", command)]
    if shown:
        parts.append("## Examples\n")
        parts += [f"{one['text']}\n\n```sh\n{one['line']}\n```\n" for one in shown]
    parts += ["## Options\n", _options(command)]
    if isinstance(command, TyperGroup):
        for below, one in command.commands.items():
            title = f"ehamj {name}" if below == "FILE" else f"ehamj {name} {below}"
            parts += [f"## ehamj {name} {below}\n", f"{_words(one.help)}\n", _usage(title, one), _options(one)]
    return "\n".join(parts)


def _usage(title: str, command: Any) -> str:
    words = [_word(one) for one in command.params if one.param_type_name == "argument"]
    return f"```text\n{' '.join([title, *words, '[OPTIONS]'])}\n```\n"


def _word(argument: Any) -> str:
    word = argument.metavar or argument.name.upper()
    return word if argument.required else f"[{word}]"


def _options(command: Any) -> str:
    """All that a command takes as a table."""
    rows = [_row(one) for one in command.params if not getattr(one, "hidden", False)]
    heads = ["| option | what it does | default |", "|---|---|---|"]
    return "\n".join([*heads, *rows, "| `--help` | Show this and exit. | |", ""])


def _row(one: Any) -> str:
    if one.param_type_name == "argument":
        name = f"`{one.metavar or one.name.upper()}`"
    else:
        word = "" if one.is_flag else f" {one.metavar or one.name.upper().replace('OUT_', '')}"
        name = ", ".join(f"`{flag}{word}`" for flag in (*one.opts, *one.secondary_opts))
    text = _words(one.help or "").replace("\n", " ")
    stated = re.search(r" \[default: (.+?)\](?=\.?$)", text)
    text = text.replace(stated[0], "") if stated else text
    own = getattr(one.default, "value", one.default)
    default = stated[1] if stated else "" if own in (None, False) else f"`{own}`"
    return f"| {name} | {_cell(text)} | {'required' if one.required else _cell(default)} |"


def _cell(text: str) -> str:
    return re.sub(r"(?<!\\)\|", r"\\|", text)


def _words(text: str | None) -> str:
    """Help as Markdown: its lines joined to paragraphs."""
    lines = [line.strip() for line in (text or "").replace("\b", "").strip().splitlines()]
    return re.sub(r"\n(?=[^\n])(?<!\n\n)", " ", "\n".join(lines))


def _first(text: str) -> str:
    return re.split(r"(?<=[.;:]) |\n", _words(text))[0].rstrip(";:")
