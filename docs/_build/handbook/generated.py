"""All pages of the site that are made at build, by path within it."""

from pathlib import Path

from handbook.reference.api import api_pages
from handbook.reference.commands import command_pages
from handbook.reference.files import file_pages
from handbook.reference.histories import history_pages
from handbook.reference.identify import identify_pages
from handbook.reference.keys import key_pages
from handbook.reference.merits import merit_pages
from handbook.reference.study import study_pages
from handbook.reference.summary import summary_pages
from handbook.verified import verified_pages


def generated_pages(root: Path) -> dict[str, str]:
    """Markdown by path; ``root`` is the project's folder."""
    made = (
        command_pages,
        key_pages,
        study_pages,
        identify_pages,
        merit_pages,
        history_pages,
        summary_pages,
        file_pages,
        verified_pages,
    )
    return {path: text for pages in made for path, text in pages().items()} | api_pages(root) | project_pages(root)


def project_pages(root: Path) -> dict[str, str]:
    """Files at the project's top that are pages too."""
    found = {
        "changelog.md": root / "CHANGELOG.md",
        "reference/contributing.md": root / "CONTRIBUTING.md",
        "reference/index.md": Path(__file__).with_name("reference") / "index.md",
    }
    return {path: file.read_text(encoding="utf-8") for path, file in found.items() if file.is_file()}
