"""Every key of a study file, on one page for each of its tables."""

import json

from ehamj.campaign.file import StudyFile
from ehamj.settings import schema_of
from handbook.reference.tables import Tables, summary_table

TITLES = {
    "vary": ("Spreads", "How the values of a parameter spread, by the keys that a table has."),
    "plan": ("Plans", "Which designs a study makes."),
    "limits": ("Limits", "What a merit must keep."),
    "correlation": ("Correlations", "Parameters that go together."),
    "tolerances": ("Tolerances", "Machines around the best designs."),
    "confirm": ("Confirmation", "The best designs once more, otherwise."),
    "budget": ("Budget", "How much a study may take."),
}
"""Title and first sentence of each page, by its key."""


def study_pages() -> dict[str, str]:
    """Markdown by path within the site."""
    tables = Tables(json.loads(schema_of(StudyFile)))
    pages = {f"{key}.md": tables.page(title, said, f"{key}.md", [key]) for key, (title, said) in TITLES.items()}
    properties = tables.schema["properties"]
    required = tables.schema.get("required", ())
    parts = [
        "# Keys of a study file\n",
        "A study file is TOML: which machine, what is varied, which designs that makes, and what is asked of them. "
        "`ehamj schema study` prints the same as a JSON schema.\n",
        summary_table({name: (name, node) for name, node in properties.items()}),
        *(tables.key(name, node, name, name in required) for name, node in properties.items()),
    ]
    return {f"reference/study/{name}": text for name, text in {"index.md": "\n".join(parts), **pages}.items()}
