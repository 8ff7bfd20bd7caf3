"""The files that are written and read: a page of prose with tables from the program."""

from pathlib import Path
from typing import Final

from ehamj.control.law import KEYS, NEEDED
from ehamj.export.formats import FORMATS
from ehamj.records.readers import READERS

PROSE: Final = Path(__file__).with_name("files.md")

LAW: Final = {
    "inputs": ("", "channels that it reads, in the order of u, see [Channels](channels.md)"),
    "outputs": ("", "`valve_command MOUNT` of each valve, in the order of y"),
    "period_s": ("s", "from sample to sample"),
    "delay_s": ("s", "from a sample to when its commands act; null: one period"),
    "voltage_limit_v": ("V", "commands are limited to ± this"),
    "bits": ("bit", "resolution of the commands; null: exact"),
    "switch_on_s": ("s", "until then the valves get zero"),
    "fade_s": ("s", "over which the commands fade in, as 3s² − 2s³"),
    "from_rest": ("", "whether displacements, strokes and pressures count from where the machine stands at the start"),
    "A": ("", "matrix, states × states"),
    "B": ("", "matrix, states × inputs"),
    "C": ("V", "matrix, valves × states"),
    "D": ("V", "matrix, valves × inputs"),
    "anti_windup": ("", "matrix L, states × valves; null: zero"),
    "valves": ("", "what is known of each valve and made good before the converter; empty: nothing is"),
    "learners": ("", "what is known of each mount's isolator, of which it learns; empty: nothing is learnt"),
    "lines": ("", "lines whose frequency it follows"),
    "spools": ("", "what is known of each spool, behind whose position a loop is closed; empty: none is"),
}
"""Keys of a law's file: unit, and what they are."""


def file_pages() -> dict[str, str]:
    """Markdown by path within the site."""
    law = [f"| `{key}` | {unit} | {text} |" for key, (unit, text) in LAW.items()]
    readers = [
        f"| {one.title} | {', '.join(f'`{ending}`' for ending in one.endings) or 'as it begins'} "
        f"| {', '.join(f'[`{key}`](../keys/ground.md#ground.record.{key})' for key in sorted(one.uses))} |"
        for one in READERS.values()
    ]
    text = PROSE.read_text(encoding="utf-8")
    needed = ", ".join(f"`{KEYS[name]}`" for name in NEEDED)
    exports = [f"| `{one.option} {one.takes}` | {one.what} |" for one in FORMATS.values()]
    made = {
        "{law}": "\n".join(law),
        "{needed}": needed,
        "{readers}": "\n".join(readers),
        "{exports}": "\n".join(exports),
    }
    for name, table in made.items():
        text = text.replace(name, table)
    return {"reference/results/files.md": text}
