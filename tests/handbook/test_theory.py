"""The theory in chapters: nothing is lost, links lead on, and an equation becomes one."""

from pathlib import Path

import pytest
from lxml import html

from handbook.maths import typeset
from handbook.nav import filled
from handbook.sections import link_sections
from handbook.theory import Theory

PHYSICS = Path(__file__).parents[2] / "docs" / "physics.md"

TEXT = """# Title

Before.

## 1. One, and more

See [two](#21-within), ![a figure](figures/a.svg), <img src="figures/b.svg">, [out](https://example.org).

## 2. Two

### 2.1 Within

Text of section 1.
"""


def test_every_line_of_the_file_is_on_one_page() -> None:
    """Headings aside, the pages are the file."""
    text = PHYSICS.read_text(encoding="utf-8")
    theory = Theory.of(text)
    assert "".join(chapter.text for chapter in theory.chapters) == text[text.index("## 1. ") :]
    assert [chapter.number for chapter in theory.chapters] == list(range(1, text.count("\n## ") + 1))
    assert len(theory.pages()) == 1 + len(theory.chapters)


def test_headings_rise_and_links_lead_to_chapters() -> None:
    theory = Theory.of(TEXT)
    one, two = theory.pages()["theory/01-one-and-more.md"], theory.pages()["theory/02-two.md"]
    assert one.startswith("# 1. One, and more\n")
    assert "[two](02-two.md#21-within), ![a figure](../figures/a.svg)" in one
    assert '<img src="../figures/b.svg">, [out](https://example.org)' in one
    assert "\n## 2.1 Within\n" in two
    assert theory.links_here("[x](../physics.md#21-within)") == "[x](../theory/02-two.md#21-within)"
    assert theory.links_here("[x](physics.md)") == "[x](theory/index.md)"
    with pytest.raises(KeyError):
        theory.links_here("[x](physics.md#nowhere)")


def test_a_section_out_of_order_is_refused() -> None:
    with pytest.raises(ValueError, match=r"'## 3\. Two' must be '## 2\. …'"):
        Theory.of(TEXT.replace("## 2. ", "## 3. "))


def test_equations_become_mathml() -> None:
    made = html.fromstring(typeset('<p>a<span class="arithmatex">\\(\\frac{K_Q}{A_p} &lt; 1\\)</span></p>'))
    assert [one.text_content() for one in made.xpath(".//mfrac/*")] == ["KQ", "Ap"]
    assert "<" in [one.text for one in made.xpath(".//mo")]
    shown = html.fromstring(typeset('<div><div class="arithmatex">\\[x^2\\]</div></div>'))
    assert shown.xpath('./div[@class="equation"]/math/@display') == ["block"]
    signs = html.fromstring(typeset('<p><span class="arithmatex">\\(|x| ± a/2 · ∞\\)</span></p>'))
    assert [(one.text, one.get("rspace")) for one in signs.xpath(".//mo")] == [
        *(("|", "0"), ("|", "0"), ("±", None), ("/", "0"), ("·", None))
    ]
    for wrong in ("\\frac{1", "\\notacommand x"):
        with pytest.raises(ValueError, match="cannot be read"):
            typeset(f'<span class="arithmatex">\\({wrong}\\)</span>')


def test_sections_are_linked_outside_code_and_links() -> None:
    def url(number: int) -> str | None:
        return f"{number}.html" if number < 3 else None

    told = "<p>docs/physics.md, section 2; <code>docs/physics.md, section 2</code>; section 1</p>"
    made = html.fromstring(link_sections(told, url, False))
    assert [(one.text, one.get("href")) for one in made.xpath(".//a")] == [("theory, section 2", "2.html")]
    made = html.fromstring(link_sections("<p>section 1, <a>section 2</a>, section 9</p>", url, True))
    assert made.xpath(".//a/@href") == ["1.html"]


def test_a_star_takes_what_is_not_named() -> None:
    pages = ["t/a.md", "t/b.md", "t/index.md", "g.md"]
    nav = ["t/b.md", {"T": ["t/*"]}, {"G": "g*"}, {"None": "n/*"}]
    assert filled(nav, pages) == ["t/b.md", {"T": ["t/index.md", "t/a.md"]}, {"G": "g.md"}]
