"""Every key of a scenario: one page for each kind of table."""

import json
from typing import Final, NamedTuple

from ehamj.scenario.load import scenario_schema
from handbook.reference.tables import Tables, summary_table


class Topic(NamedTuple):
    """One page: its file, its title, what it says first, and the top-level keys whose tables it describes."""

    file: str
    title: str
    intro: str
    keys: tuple[str, ...]


TOPICS: Final = (
    Topic("machine.md", "Machine, parts and slides", "What stands on the mounts.", ("machine", "part", "slide")),
    Topic("mounts.md", "Mounts", "Where isolators stand, and along what they act.", ("mount",)),
    Topic("isolators.md", "Isolators", "Valve, cylinder, oil, membrane and foot of an isolator.", ("actuators",)),
    Topic("supply.md", "Supply", "Pump, accumulator and lines that all isolators share.", ("supply",)),
    Topic("ground.md", "Ground", "How the floor moves below the mounts.", ("ground",)),
    Topic("forces.md", "Forces", "What shakes the machine itself.", ("force",)),
    Topic("control.md", "Control", "The law, and how it runs.", ("control",)),
    Topic("sensors.md", "Sensors", "What the law measures with.", ("sensors",)),
    Topic("faults.md", "Faults", "What fails in the course of a run.", ("fault",)),
    Topic("criteria.md", "Criteria", "By what a run is judged.", ("criteria", "relative")),
    Topic("output.md", "Output", "What a run writes beside its numbers.", ("output",)),
)


def key_pages() -> dict[str, str]:
    """Markdown by path within the site."""
    tables = Tables(json.loads(scenario_schema()))
    pages = {topic.file: tables.page(topic.title, topic.intro, topic.file, list(topic.keys)) for topic in TOPICS}
    return {f"reference/keys/{name}": text for name, text in {"index.md": _index(tables), **pages}.items()}


def _index(tables: Tables) -> str:
    """Keys of the top level."""
    properties = tables.schema["properties"]
    listed = "\n".join(f"- [{one.title}]({one.file}): {one.intro}" for one in TOPICS)
    parts = [tables.key(name, node, name, False) for name, node in properties.items()]
    told = (
        "A scenario is TOML in SI units; every key is checked. `ehamj schema` prints the same as a JSON schema, for an "
        "editor that completes and checks. `--set KEY=VALUE` sets any key by its path, such as "
        "`--set actuators.isolator.flow_gain=2e-6`; in the paths here NAME stands for a name of your own, and N for "
        "the number of an entry, from 0.\n\n"
        "Each physical value carries its source: "
        '<span class="badge paper">paper</span> Table I or the text of the source paper, '
        '<span class="badge identified">identified</span> fitted to something that the paper states, '
        '<span class="badge assumed">assumed</span> chosen, because nobody measured it, '
        '<span class="badge">given</span> set by you. Besides what is allowed, a *magnitude* that no such thing has is '
        "refused as a slip of the unit or of the decimal point.\n"
    )
    table = summary_table({name: (name, node) for name, node in properties.items()})
    return f"# Keys of a scenario\n\n{told}\n{listed}\n\n## Top level\n\n{table}\n" + "\n".join(parts)
