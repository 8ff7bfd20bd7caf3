"""Pages in a real browser: no errors, no requests, nothing wider than a phone or an A4 page, nothing cut off."""

import html
import json
import re
import subprocess
from pathlib import Path
from typing import Any

import pytest

from ehamj.pages.pdf import browser, print_page
from ehamj.report import write_report
from ehamj.report.comparison import write_transmissibility
from ehamj.run.many import simulate_many
from ehamj.scenario.load import load_scenario
from ehamj.scenario.variants import labels

CHROMIUM = browser()
pytestmark = pytest.mark.skipif(
    CHROMIUM is None,
    reason="no Chromium here (apt-get install chromium, or EHAMJ_BROWSER names one): no page is opened",
)

OPTIONS = (
    *("--headless", "--no-sandbox", "--disable-gpu", "--disable-quic", "--no-first-run", "--hide-scrollbars"),
    *("--disable-background-networking", "--disable-component-update", "--disable-sync"),
    *("--enable-logging=stderr", "--v=0"),
)

PHONE, A4 = 360, 696
"""Widths in CSS pixels: a phone's, and that of an A4 page between its margins of 13 mm."""

# The page reports to the page that frames it: what the window needs, what is cut off, which figures lack something.
PROBE = """<script>onload = () => {
  const page = document.documentElement, found = {cut: [], bare: [], small: [], wide: []};
  for (const svg of document.querySelectorAll("figure svg")) {
    const frame = svg.getBoundingClientRect(), name = svg.closest("figure").id;
    const texts = [...svg.querySelectorAll("text")];
    for (const text of texts) {
      const box = text.getBoundingClientRect();
      if (box.right > frame.right + 1 || box.left < frame.left - 1) found.cut.push(`${name}: ${text.textContent}`);
      if (parseFloat(getComputedStyle(text).fontSize) * frame.width / svg.viewBox.baseVal.width < 6.5)
        found.small.push(`${name}: ${text.textContent}`);
    }
    const units = texts.filter(text => /\\w.* \\[[^\\]]+\\]/.test(text.textContent)).length;
    if (units < 2 || !svg.querySelector('[id*="legend"]')) found.bare.push(name);
  }
  for (const box of document.querySelectorAll("main *"))
    if (!box.closest(".table, .drawing, svg") && box.getBoundingClientRect().right > page.clientWidth + 1)
      found.wide.push(box.tagName + " " + box.textContent.slice(0, 40));
  found.width = page.clientWidth; found.needed = page.scrollWidth;
  found.figures = document.querySelectorAll("figure svg").length;
  found.requests = performance.getEntriesByType("resource").map(entry => entry.name);
  parent.postMessage(JSON.stringify(found), "*");
}</script>"""

FRAME = """<!DOCTYPE html><html><body style="margin: 0">
<script>onmessage = event => { document.body.dataset.found = event.data; }</script>
<iframe src="page.html" style="border: 0; width: WIDTHpx; height: 900px"></iframe></body></html>"""


@pytest.fixture(scope="module")
def pages(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Path]:
    """Reports of shipped scenarios with their variants, shortened, plates tied (the same equations)."""
    found = {}
    for name in ("recorded", "workshop"):
        scenario = load_scenario(name, ("duration=8", "plates=tied"))
        wanted = [scenario, *(scenario.variant(variant) for variant in scenario.compare)]
        results = dict(zip(labels(wanted), simulate_many(wanted), strict=True))
        folder = tmp_path_factory.mktemp(name)
        write_report(folder, results)
        found[name] = folder / "report.html"
    return found


def opened(page: Path, width: int, folder: Path, print_style: bool = False) -> tuple[dict[str, Any], list[str]]:
    """What the probe found in a page framed at ``width``, and what the console said."""
    text = page.read_text(encoding="utf-8").replace("</body>", PROBE + "</body>")
    if print_style:
        text = text.replace("@media print", "@media screen")
        # Columns are a sheet's; figures are as wide as one of them.
        text = text.replace("columns: 2;", "").replace("</style>", ".annexed figure { width: 336px; }</style>")
    (folder / "page.html").write_text(text, encoding="utf-8")
    (folder / "frame.html").write_text(FRAME.replace("WIDTH", str(width)), encoding="utf-8")
    command = [str(CHROMIUM), *OPTIONS, f"--user-data-dir={folder / 'profile'}", "--window-size=1200,1000"]
    command += ["--virtual-time-budget=10000", "--dump-dom", f"file://{folder}/frame.html"]
    done = subprocess.run(command, capture_output=True, text=True, check=False, timeout=120)
    found = re.search(r'data-found="([^"]*)"', done.stdout)
    assert found, done.stderr
    console = [line for line in done.stderr.splitlines() if "CONSOLE" in line]
    return json.loads(html.unescape(found[1])), console


@pytest.mark.parametrize(("medium", "width"), [("phone", PHONE), ("paper", A4)])
@pytest.mark.parametrize("name", ["recorded", "workshop"])
def test_a_browser_shows_the_report(pages: dict[str, Path], name: str, medium: str, width: int, tmp_path: Path) -> None:
    seen, console = opened(pages[name], width, tmp_path, print_style=medium == "paper")
    assert console == []
    assert seen["requests"] == []
    assert seen["width"] == width
    assert seen["needed"] <= width
    assert seen["wide"] == []
    assert seen["figures"] >= 15
    assert seen["cut"] == []
    assert seen["bare"] == []
    assert seen["small"] == []


def sheets(page: Path) -> int:
    """How many A4 sheets a page takes."""
    target = page.with_suffix(".pdf")
    print_page(page, target)
    content = target.read_bytes()
    boxes = set(re.findall(rb"/MediaBox \[0 0 ([\d.]+) ([\d.]+)\]", content))
    assert [tuple(round(float(side) * 25.4 / 72) for side in box) for box in boxes] == [(210, 297)]
    return len(re.findall(rb"/Type /Page\b", content))


@pytest.mark.parametrize("name", ["recorded", "workshop"])
def test_a_browser_prints_two_sheets_and_an_annex_that_begins_on_the_third(
    pages: dict[str, Path], name: str, tmp_path: Path
) -> None:
    page = tmp_path / "report.html"
    text = pages[name].read_text(encoding="utf-8")
    page.write_text(text, encoding="utf-8")
    whole = sheets(page)
    assert 8 <= whole <= 17
    page.write_text(text.replace("</style>", ".annexed, footer { display: none; }</style>"), encoding="utf-8")
    assert sheets(page) == 2
    page.write_text(text.replace("</style>", "main > :not(.annexed) { display: none; }</style>"), encoding="utf-8")
    assert sheets(page) in (whole - 3, whole - 2)  # the footer may have a sheet of its own


def test_a_browser_shows_the_page_of_a_transmissibility(tmp_path: Path) -> None:
    from ehamj.rig.comparison import TransmissibilitySettings, compare_scenario

    scenario = load_scenario("recorded", ("plates=tied", 'control={kind="feedforward"}'))
    settings = TransmissibilitySettings(dofs=("z", "ry"), lines=6, first=5.0, last=50.0)
    write_transmissibility(tmp_path, compare_scenario(scenario, settings))
    seen, console = opened(tmp_path / "transmissibility.html", PHONE, tmp_path)
    assert console == []
    assert seen["requests"] == []
    assert seen["needed"] <= PHONE
    assert seen["figures"] == 3
    assert seen["cut"] == []
