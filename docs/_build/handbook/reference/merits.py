"""Figures of merit that a study file may name."""

from typing import Final

from ehamj.merits.catalogue import SOURCES
from ehamj.merits.listing import listing
from ehamj.merits.merit import Machine
from ehamj.scenario.load import load_scenario

SCENARIO: Final = "recorded"
"""Of whose machine they are listed."""
SAID: Final = {
    "actuator": "Of the actuators by themselves, in closed form.",
    "passive": "Of the machine with its valves held.",
    "loop": "Of the closed loop, linear.",
    "run": "Of nonlinear runs: the numbers of [summary.json](../results/summary.md).",
}
"""What each source is about, by its name."""


def merit_pages() -> dict[str, str]:
    """Markdown by path within the site."""
    machine = Machine(load_scenario(SCENARIO))
    parts = [
        "# Figures of merit\n",
        "What a study file's `merits`, `objectives` and `limits` may name. AXIS, BAND, MOUNT, … stand for each that "
        "the machine has; `ehamj merits SCENARIO --find WORD` shows all of them for a machine. Here they are those of "
        f"`{SCENARIO}`. `own.NAME` is a Python function of yours (`ehamj.run_study(…, functions={{…}})`).\n",
    ]
    for name, source in SOURCES.items():
        rows = [
            f"| `{one}` | {'' if merit.unit == '1' else merit.unit} | {merit.text} |"
            for one, merit in listing(source.merits(machine), machine.scenario).items()
        ]
        parts += [
            f"## {name}\n",
            f"{SAID.get(name, '')}\n",
            "| merit | unit | what it is |",
            "|---|---|---|",
            *rows,
            "",
        ]
    return {"reference/study/merits.md": "\n".join(parts)}
