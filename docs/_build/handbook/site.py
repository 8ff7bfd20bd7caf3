"""What MkDocs is told of this site: pages that are made, their order, equations, and links between sections."""

from pathlib import Path
from typing import Any, Final

from mkdocs.config.defaults import MkDocsConfig
from mkdocs.exceptions import PluginError
from mkdocs.plugins import get_plugin_logger
from mkdocs.structure.files import File, Files
from mkdocs.structure.pages import Page
from mkdocs.utils import get_relative_url

from handbook.generated import generated_pages
from handbook.links import faults
from handbook.maths import typeset
from handbook.nav import filled
from handbook.sections import link_sections
from handbook.theory import Theory

LOG: Final = get_plugin_logger(__name__)
ROOT: Final = Path(__file__).parents[3]


class _Site:
    """What is made once in a build."""

    theory = Theory("", "", [])


def on_files(files: Files, config: MkDocsConfig) -> Files:
    """Add what is made: chapters, reference, and the files of the project that are pages."""
    _Site.theory = Theory.of((ROOT / "docs" / "physics.md").read_text(encoding="utf-8"))
    for path, text in {**_Site.theory.pages(), **generated_pages(ROOT)}.items():
        files.append(File.generated(config, path, content=text))
    assert config.nav is not None
    config.nav = filled(config.nav, [file.src_uri for file in files.documentation_pages()])
    return files


def on_page_markdown(markdown: str, page: Page, **_: Any) -> str:
    """Links to the theory as one file lead to its chapters."""
    try:
        return _Site.theory.links_here(markdown)
    except KeyError as error:
        raise PluginError(f"{page.file.src_uri}: docs/physics.md has no heading with the anchor {error}") from error


def on_page_content(html: str, page: Page, **_: Any) -> str:
    """Typeset equations; link what is said of sections."""

    def chapter_url(number: int) -> str | None:
        named = {one.number: f"theory/{one.name.removesuffix('.md')}.html" for one in _Site.theory.chapters}
        own = page.file.dest_uri
        return get_relative_url(named[number], own) if number in named and named[number] != own else None

    try:
        made = typeset(html)
    except ValueError as error:
        raise PluginError(f"{page.file.src_uri}: {error}") from error
    return link_sections(made, chapter_url, page.file.src_uri.startswith("theory/"))


def on_post_build(config: MkDocsConfig) -> None:
    """Warn of links, anchors and pictures that are not there, and of what would be loaded from elsewhere."""
    for fault in faults(Path(config.site_dir)):
        LOG.warning(fault)
