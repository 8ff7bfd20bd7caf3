"""What is wrong with a site is found, each kind of it."""

from pathlib import Path

from handbook.links import faults

GOOD = """<html><head><link rel="stylesheet" href="house.css"><script src="a.js"></script></head><body>
<h1 id="top">Top</h1><a href="#top">t</a> <a href="b/other.html#there">o</a> <a href="https://example.org">out</a>
<img src="b/p.svg"></body></html>"""


def site(folder: Path, page: str = GOOD, sheet: str = "") -> list[str]:
    (folder / "b").mkdir()
    (folder / "index.html").write_text(page)
    (folder / "house.css").write_text(sheet)
    (folder / "a.js").write_text("")
    (folder / "b" / "p.svg").write_text("<svg/>")
    (folder / "b" / "other.html").write_text('<p id="there">x <a href="../index.html">back</a></p>')
    return faults(folder)


def test_a_whole_site_has_no_faults(tmp_path: Path) -> None:
    assert site(tmp_path, sheet="a { background: url(data:abc); }") == []


def test_each_fault_is_named(tmp_path: Path) -> None:
    wrong = {
        "b/other.html#there": "b/other.html#nowhere",
        "#top": "#bottom",
        "b/p.svg": "b/q.svg",
        "a.js": "https://example.org/a.js",
        "house.css": "//example.org/house.css",
        "https://example.org": "../outside.html",
    }
    page = GOOD
    for good, bad in reversed(wrong.items()):
        page = page.replace(f'"{good}"', f'"{bad}"')
    found = site(tmp_path, page, "@import 'https://example.org/font.css';")
    assert sorted(found) == sorted(
        [
            "index.html: #bottom has no such anchor",
            "index.html: b/other.html#nowhere has no such anchor",
            "index.html: ../outside.html is no file",
            "index.html: b/q.svg is no file",
            "index.html: loads https://example.org/a.js",
            "index.html: loads //example.org/house.css",
            "house.css: loads https://example.org/font.css",
        ]
    )
