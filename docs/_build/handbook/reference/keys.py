"""Every key of a scenario: one page for each kind of table."""

import json
import re
from typing import Final, NamedTuple

from ehamj.scenario.load import scenario_schema
from handbook.reference.presets import preset_section
from handbook.reference.tables import Tables, summary_table


class Topic(NamedTuple):
    """One page: its file, its title, what it says first, and the top-level keys whose tables it describes."""

    file: str
    title: str
    intro: str
    keys: tuple[str, ...]


FIRST: Final = re.compile(r"[.;] ")
"""Where the first words of an intro end."""

TOPICS: Final = (
    Topic("machine.md", "Machine, parts and slides", "What stands on the mounts.", ("machine", "part", "slide")),
    Topic("mounts.md", "Mounts", "Where isolators stand, and along what they act.", ("mount",)),
    Topic(
        "isolators.md",
        "Isolators",
        "Valve, cylinder, oil, membrane and foot of an isolator. Defaults are the paper's first prototype. Equations: "
        "docs/physics.md, section 1 (linear, Table I), docs/physics.md, section 2 (nonlinear), and docs/physics.md, "
        "section 4 (options). What [presets, oils and valves](#presets) set stands at the end.",
        ("actuators",),
    ),
    Topic("supply.md", "Supply", "Pump, accumulator and lines that all isolators share.", ("supply",)),
    Topic("ground.md", "Ground", "How the floor moves below the mounts; docs/physics.md, section 5.", ("ground",)),
    Topic("forces.md", "Forces", "What shakes the machine itself.", ("force",)),
    Topic("control.md", "Control", "The law, and how it runs; docs/physics.md, section 6.", ("control",)),
    Topic("sensors.md", "Sensors", "What the law measures with.", ("sensors",)),
    Topic("faults.md", "Faults", "What fails in the course of a run.", ("fault",)),
    Topic("criteria.md", "Criteria", "By what a run is judged; docs/physics.md, section 7.", ("criteria", "relative")),
    Topic("output.md", "Output", "What a run writes beside its numbers.", ("output",)),
)


def key_pages() -> dict[str, str]:
    """Markdown by path within the site."""
    tables = Tables(json.loads(scenario_schema()))
    order = sorted(TOPICS, key=lambda topic: topic.file == "control.md")  # it holds tables of all others
    made = {one.file: tables.page(one.title, one.intro, one.file, list(one.keys)) for one in order}
    made["isolators.md"] += preset_section()
    pages = {"index.md": _index(tables), **{one.file: made[one.file] for one in TOPICS}}
    return {f"reference/keys/{name}": text for name, text in pages.items()}


def _index(tables: Tables) -> str:
    """Keys of the top level."""
    properties = tables.schema["properties"]
    listed = "\n".join(f"- [{one.title}]({one.file}): {FIRST.split(one.intro)[0]}" for one in TOPICS)
    parts = [tables.key(name, node, name, False) for name, node in properties.items()]
    told = (
        "A scenario is TOML in SI units; every key is checked. `ehamj schema` prints the same as a JSON schema, for an "
        "editor that completes and checks. `--set KEY=VALUE` sets any key by its path, such as "
        "`--set actuators.isolator.flow_gain=2e-6`; in the paths here NAME stands for a name of your own, and N for "
        "the number of an entry, from 0.\n\n"
        "Each physical value carries its source: "
        '<span class="badge paper">paper</span> Table I or the text of the source paper, '
        '<span class="badge identified">identified</span> fitted to measurements or to what the paper states, '
        '<span class="badge assumed">assumed</span> chosen, because nobody measured it, '
        '<span class="badge">given</span> set by you. Besides what is allowed, a *magnitude* that no such thing has is '
        "refused as a slip of the unit or of the decimal point.\n\n"
        'A table of physical values may state both itself: `sources = { mass = "identified" }`, and of what was '
        "identified from measurements the deviation in `deviations = { mass = 12.0 }`, in the value's unit and "
        "as long as the value. A value that is replaced loses both; the report shows them beside the value.\n"
    )
    table = summary_table({name: (name, node) for name, node in properties.items()})
    return f"# Keys of a scenario\n\n{told}\n{listed}\n\n## Top level\n\n{table}\n" + "\n".join(parts)
