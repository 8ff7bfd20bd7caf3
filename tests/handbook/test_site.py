"""The site, built as `make docs` does, in a real browser, as files: nothing wider than a desk or a phone, no requests,
a search that works."""

import html
import json
import os
import re
import subprocess
import sys
from pathlib import Path
from typing import Any

import lxml.html
import pytest

from ehamj.pages.pdf import browser
from handbook.site import ROOT

CHROMIUM = browser()
needs_browser = pytest.mark.skipif(
    CHROMIUM is None, reason="no Chromium here (EHAMJ_BROWSER names one): no page is opened"
)

OPTIONS = (
    *("--headless", "--no-sandbox", "--disable-gpu", "--no-first-run", "--hide-scrollbars"),
    *("--disable-background-networking", "--disable-component-update", "--disable-sync"),
    *("--allow-file-access-from-files", "--enable-logging=stderr", "--v=0", "--virtual-time-budget=20000"),
)
DESK, PHONE = 1280, 390
PAGES = (
    *("index.html", "theory/02-one-actuator-nonlinear.html", "reference/keys/isolators.html"),
    *("reference/commands/study.html", "reference/results/summary.html", "validation/verified.html", "gallery.html"),
)
EQUATIONS = PAGES[1:3]
"""Those that have some."""

# A page that frames others, and says what each needs and loads.
FRAMES = """<!DOCTYPE html><body style="margin: 0"><script>
const found = [], wanted = WANTED;
for (const [page, width] of wanted) {
  const frame = document.createElement("iframe");
  frame.style = `border: 0; height: 900px; width: ${width}px`;
  frame.onload = () => {
    const of = frame.contentDocument, whole = of.documentElement;
    const wide = [...of.querySelectorAll("article *")].filter(one =>
      one.getBoundingClientRect().right > width + 1 && !one.closest("pre, code, .md-typeset__scrollwrap, .equation"));
    found.push({page, width, needed: whole.scrollWidth, wide: wide.map(one => one.outerHTML.slice(0, 80)).slice(0, 3),
      requests: frame.contentWindow.performance.getEntriesByType("resource").map(one => one.name),
      equations: [...of.querySelectorAll("math")].filter(one => one.getBoundingClientRect().width > 2).length});
    if (found.length == wanted.length) document.body.dataset.found = JSON.stringify(found);
  };
  frame.src = "SITE/" + page;
  document.body.append(frame);
}
</script>"""

SEARCH = """<!DOCTYPE html><body><iframe src="SITE/index.html" style="width: 1280px; height: 900px"></iframe><script>
const frame = document.querySelector("iframe");
frame.onload = () => {
  const of = frame.contentDocument, query = of.querySelector("[data-md-component=search-query]");
  of.querySelector("#__search").click();
  query.focus();
  query.value = "flow_gain";
  query.dispatchEvent(new frame.contentWindow.InputEvent("input", {bubbles: true}));
  query.dispatchEvent(new frame.contentWindow.KeyboardEvent("keyup", {bubbles: true, key: "n"}));
  const ask = setInterval(() => {
    const links = [...of.querySelectorAll(".md-search-result__link")].map(one => one.href);
    if (links.length) { document.body.dataset.found = JSON.stringify(links); clearInterval(ask); }
  }, 50);
};
</script>"""


@pytest.fixture(scope="module")
def site(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The site as it is now; a warning is an error, and so is a link that leads nowhere."""
    folder = tmp_path_factory.mktemp("site")
    command = [sys.executable, "-m", "mkdocs", "build", "--quiet", "--strict", "--site-dir", str(folder)]
    own = os.environ | {"NO_MKDOCS_2_WARNING": "1"}
    done = subprocess.run(command, cwd=ROOT, env=own, capture_output=True, text=True, check=False)
    assert done.returncode == 0, f"{done.stdout}\n{done.stderr}"
    return folder


def seen(text: str, site: Path, folder: Path) -> Any:
    """What a page finds of the site; the console must have nothing to say."""
    (folder / "frame.html").write_text(text.replace("SITE", site.as_uri()), encoding="utf-8")
    command = [str(CHROMIUM), *OPTIONS, f"--user-data-dir={folder / 'profile'}", "--dump-dom"]
    done = subprocess.run(
        [*command, (folder / "frame.html").as_uri()], capture_output=True, text=True, check=False, timeout=120
    )
    found = re.search(r'data-found="([^"]*)"', done.stdout)
    assert found, done.stderr
    assert [line for line in done.stderr.splitlines() if "CONSOLE" in line] == []
    return json.loads(html.unescape(found[1]))


@needs_browser
def test_pages_fit_a_desk_and_a_phone_and_load_nothing_from_elsewhere(site: Path, tmp_path: Path) -> None:
    wanted = [[page, width] for page in PAGES for width in (DESK, PHONE)]
    found = seen(FRAMES.replace("WANTED", json.dumps(wanted)), site, tmp_path)
    assert len(found) == len(wanted)
    for one in found:
        said = f"{one['page']} at {one['width']}"
        assert one["needed"] <= one["width"], said
        assert one["wide"] == [], said
        assert [name for name in one["requests"] if not name.startswith("file:")] == [], said
        assert one["equations"] > 0 or one["page"] not in EQUATIONS, said


@needs_browser
def test_the_search_finds_a_key_without_a_server(site: Path, tmp_path: Path) -> None:
    found = [link.removeprefix(f"{site.as_uri()}/") for link in seen(SEARCH, site, tmp_path)]
    assert "reference/keys/isolators.html?h=flow_gain#actuators.NAME.flow_gain" in found[:3]


ANSWERS = {
    "how to read a record": "how-to/read-my-loggers-file.html",
    "what flow_gain means, and where it comes from": "reference/keys/isolators.html",
    "how accurate the simulator is": "validation/accuracy.html",
}
SHOWN = "//nav[contains(@class, 'md-tabs')]//a/@href | //article//a/@href"
BESIDE = " | //li[contains(@class, 'md-nav__item--active')]//a/@href"


def clicked(page: Path, where: str) -> set[Path]:
    """Pages of the site that are one click away on a desk."""
    links = [link.partition("#")[0] for link in lxml.html.fromstring(page.read_bytes()).xpath(where) if ":" not in link]
    return {(page.parent / link).resolve() for link in links if link.endswith(".html")}


def test_answers_are_two_clicks_away(site: Path) -> None:
    first = clicked(site / "index.html", SHOWN)
    near = first.union(*(clicked(page, SHOWN + BESIDE) for page in first))
    assert [question for question, page in ANSWERS.items() if site / page not in near] == []


def test_the_site_knows_nothing_of_this_machine(site: Path) -> None:
    for path in site.rglob("*.html"):
        assert str(ROOT) not in path.read_text(encoding="utf-8"), path.name
    assert str(ROOT) not in (site / "search" / "search_index.json").read_text(encoding="utf-8")
