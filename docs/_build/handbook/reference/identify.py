"""Every key of an identification file, on one page for each of its tables."""

import json

from ehamj.identification.file import IdentifyFile
from ehamj.settings import schema_of
from handbook.reference.tables import Tables, summary_table

TITLES = {
    "parameters": ("Parameters", "How the values are looked for, each by its key in the scenario."),
    "test": ("Tests that were made", "What was measured, by the kinds of tests that there are."),
    "fit": ("Fit", "How the values are fitted to the tests."),
    "choice": ("Options of the valves", "What the valves may have if the tests justify it."),
    "plan": (
        "Tests that could be made",
        "What `ehamj identify FILE --plan` chooses from, by the kinds of candidates that there are, and what counts.",
    ),
}
"""Title and first sentence of each page, by its key."""


def identify_pages() -> dict[str, str]:
    """Markdown by path within the site."""
    tables = Tables(json.loads(schema_of(IdentifyFile)))
    pages = {f"{key}.md": tables.page(title, said, f"{key}.md", [key]) for key, (title, said) in TITLES.items()}
    properties = tables.schema["properties"]
    required = tables.schema.get("required", ())
    parts = [
        "# Keys of an identification file\n",
        "An identification file is TOML: which machine, which of its values are looked for, which tests tell them, and "
        "which could. `ehamj schema identify` prints the same as a JSON schema.\n",
        summary_table({name: (name, node) for name, node in properties.items()}),
        *(tables.key(name, node, name, name in required) for name, node in properties.items()),
    ]
    return {f"reference/identify/{name}": text for name, text in {"index.md": "\n".join(parts), **pages}.items()}
