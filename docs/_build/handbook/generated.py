"""All pages of the site that are made at build, by path within it."""

from pathlib import Path

from handbook.reference.keys import key_pages


def generated_pages(root: Path) -> dict[str, str]:
    """Markdown by path; ``root`` is the project's folder."""
    return {**key_pages(), **project_pages(root)}


def project_pages(root: Path) -> dict[str, str]:
    """Files at the project's top that are pages too."""
    found = {"changelog.md": root / "CHANGELOG.md", "reference/contributing.md": root / "CONTRIBUTING.md"}
    return {path: file.read_text(encoding="utf-8") for path, file in found.items() if file.is_file()}
