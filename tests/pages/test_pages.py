"""Pages: what a user called something never leaves its place, and figures of a page that is gone go too."""

from pathlib import Path
from xml.etree import ElementTree

import pytest
from lxml import html
from markupsafe import Markup

from ehamj.pages import ANNEX, Page, Picture, Section, Table, badge, render, safe_name, write_page
from ehamj.plots.charts import Line, lines_chart


def picture(name: str) -> Picture:
    return Picture(name, lines_chart(name, "x [m]", {"y [m]": [Line(name, [0, 1], [0, 1])]}), "caption of " + name)


def page(*sections: Section) -> Page:
    return Page("window", "<h1>", "a & b", sections)


@pytest.mark.parametrize("name", ["iso-2631-2", "criterion-vc_z", "Prüfstand", "加工"])
def test_names_that_can_stay_stay(name: str) -> None:
    assert safe_name(name) == name


@pytest.mark.parametrize("name", ["DIN 4150/3", "../../etc", "a b", "", 'x" onload="', "a.b", "\0", "C:\\x"])
def test_names_that_cannot_are_changed_and_stay_apart(name: str, tmp_path: Path) -> None:
    safe = safe_name(name)
    assert (tmp_path / safe).parent == tmp_path
    assert set(safe).isdisjoint(' /\\".:\0')
    assert safe_name(safe) == safe
    assert safe != safe_name(name + " ")


@pytest.mark.parametrize("name", ["line 3 / west", "../up", 'x" onload="y'])
def test_a_figure_of_any_name_is_a_file_beside_its_page(name: str, tmp_path: Path) -> None:
    write_page(tmp_path, "page.html", page(Section("one", "One", [picture(name)])))
    (file,) = (tmp_path / "figures").iterdir()
    assert {path.name for path in tmp_path.iterdir()} == {"page.html", "figures"}
    ids = [node.get("id") for node in ElementTree.parse(file).iter() if node.get("id")]
    assert ids
    assert all(" " not in one and "/" not in one for one in ids)
    (figure,) = html.fromstring((tmp_path / "page.html").read_text("utf-8")).xpath("//figure")
    assert figure.get("id") == f"figure-{file.stem}"
    assert figure.get("onload") is None
    assert figure.xpath(".//figcaption")[0].text_content() == f"caption of {name}"


def test_figures_of_the_page_before_are_removed_and_others_stay(tmp_path: Path) -> None:
    write_page(tmp_path, "page.html", page(Section("one", figures=[picture("a b"), picture("c")])), figures=".")
    (tmp_path / "mine.svg").write_text("<svg/>")
    write_page(tmp_path, "other.html", page(Section("one", figures=[picture("d")])), figures=".")
    write_page(tmp_path, "page.html", page(Section("one", figures=[picture("c")])), figures=".")
    assert {path.name for path in tmp_path.iterdir()} == {"page.html", "other.html", "c.svg", "d.svg", "mine.svg"}


def test_two_figures_of_one_name_are_refused(tmp_path: Path) -> None:
    with pytest.raises(ValueError, match="alike"):
        write_page(tmp_path, "page.html", page(Section("one", figures=[picture("a"), picture("a")])))
    assert list(tmp_path.iterdir()) == []


def test_text_is_text_and_markup_is_markup() -> None:
    table = Table("A < B", ["", "v"], [["<i>", badge("given")], ["group"], ["m", Markup("<b>x</b>")]], note="n & m")
    seen = html.fromstring(render(page(Section("one", "S & T", tables=[table], notes=["<p>"], items=["<li>"]))))
    assert seen.xpath("//h1")[0].text_content() == "<h1>"
    assert [cell.text_content() for cell in seen.xpath("//tbody//th")] == ["<i>", "group", "m"]
    assert seen.xpath("//td/b/text()") == ["x"]
    assert seen.xpath('//td/span[@class="badge given"]/text()') == ["given"]
    assert [node.text_content() for node in seen.xpath('//section//p[@class="note"]')] == ["<p>", "n & m"]
    assert seen.xpath("//section//li")[0].text_content() == "<li>"


def test_what_is_empty_is_left_out() -> None:
    seen = html.fromstring(render(page(Section("one", tables=[Table("T", ["a"], [])], notes=["", ""]))))
    (section,) = seen.xpath("//section")
    assert section.text_content().strip() == ""
    assert seen.xpath("//footer | //ul | //h2 | //table") == []


@pytest.mark.parametrize(("first", "order"), [(True, ["table", "figure"]), (False, ["figure", "table"])])
def test_tables_stand_where_they_should(first: bool, order: list[str]) -> None:
    table = Table("T", ["", "v"], [["a", "1"]])
    section = Section("one", figures=[picture("a")], tables=[table], tables_first=first)
    seen = html.fromstring(render(page(section)))
    assert [node.tag for node in seen.iter("table", "figure")] == order


def test_a_folded_table_shows_its_line() -> None:
    table = Table("T", ["", "v"], [["a", "1"], ["b", "2"]], folded="least 1 <a>")
    (details,) = html.fromstring(render(page(Section("one", tables=[table])))).xpath("//details")
    assert details.get("open") is None
    assert details.xpath("./summary/span/text()") == ["least 1 <a>"]
    assert details.xpath("./table//tbody//td/text()") == ["1", "2"]


def test_sheets_are_headed_by_title_and_day_whatever_these_are_called() -> None:
    one = Page('a"}</style><script>', "h", "", [Section("one", notes=["n"])], day="2026-01-02")
    text = render(one)
    assert html.fromstring(text).xpath("//script") == []
    assert r'content: "a\22 \7d \3c \2f style\3e \3c script\3e ";' in text
    assert r'content: "2026\2d 01\2d 02";' in text


def test_a_heading_is_kept_with_what_follows_and_the_annex_with_all_after_it() -> None:
    long = Table("L", ["a", "b"], [["x", "y"]] * 20)
    sections = [Section("one", "One", [picture("a"), picture("b")]), ANNEX, Section("two", "Two", tables=[long])]
    seen = html.fromstring(render(page(*sections)))
    assert seen.xpath('//section[@id="one"]/div[@class="start"]/*/@id') == ["figure-a"]
    assert seen.xpath('//section[@id="one"]/div[@class="figures"]/*/@id') == ["figure-b"]
    assert seen.xpath('//div[@class="annexed"]/section/@id') == ["annex", "two"]
    assert seen.xpath('//section[@id="two"]/div[@class="start"]//table') == []


@pytest.mark.parametrize(
    ("kind", "cells", "broad"),
    [("words", ["a", "b"], False), ("words", ["a" * 20] * 4, True), ("numbers", ["a" * 70, "1"], True)],
)
def test_a_broad_table_is_one_that_half_a_sheet_does_not_hold(kind: str, cells: list[str], broad: bool) -> None:
    assert Table("T", cells, [cells], kind=kind).broad is broad
