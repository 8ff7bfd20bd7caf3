"""Make the pictures of the documentation anew: `make pictures`, or `make pictures PICTURES=report` for some of them.

Each comes out of ehamj's own commands, run in a folder of its own, and is photographed by the browser that prints
reports. What is committed is what this script writes to docs/pictures; names of pictures are those of its files.
"""

import subprocess
import sys
import tempfile
from collections.abc import Callable
from pathlib import Path
from typing import Final, NamedTuple

from PIL import Image

from ehamj.pages.pdf import browser

PICTURES: Final = Path(__file__).parents[1] / "pictures"
LARGEST: Final = 150_000
"""Most that a picture may have [B]."""
COLOURS: Final = 128
"""Of a picture's palette: figures have few."""
FIGURE: Final = (720, 1000)
"""Window of a figure [px]: figures are 374 pt wide."""

STUDY: Final = """
title = "A stiffer actuator"
question = "How large should the piston be, and how small the chambers?"
scenario = "recorded"
[vary]
"actuators.isolator.piston_area" = { low = 0.02, high = 0.06 }
"actuators.isolator.chamber_volume" = { low = 3e-4, high = 1.2e-3 }
[plan]
kind = "latin-hypercube"
number = 256
[objectives]
"actuator.isolator.hydraulic_frequency" = "highest"
"actuator.isolator.velocity_gain" = "highest"
[limits]
"actuator.isolator.hydraulic_damping" = { at_least = 0.05 }
"""


class Taken(NamedTuple):
    """What is photographed of a command's folder: the file, the window [px], and how large its parts are."""

    file: str
    window: tuple[int, int] = FIGURE
    scale: float = 1.0


class Source(NamedTuple):
    """A command that writes a folder, and the pictures taken there by name."""

    arguments: tuple[str, ...]
    taken: dict[str, Taken]


REPORT, PAGE = (1100, 1400), (1100, 1300)
SOURCES: Final = (
    Source(
        ("run", "recorded", "--no-replay"),
        {
            "report": Taken("report.html", REPORT),
            "isolation": Taken("figures/attenuation-z.svg"),
            "criterion": Taken("figures/criterion-z.svg"),
            "spectrogram": Taken("figures/spectrogram-z.svg"),
            "machine": Taken("figures/machine-side.svg"),
            "transmissibility": Taken("figures/transmissibility-z.svg"),
        },
    ),
    Source(
        ("design", "vc-c-floor", "--architecture", "combined"),
        {"budget": Taken("budget.svg"), "nyquist": Taken("nyquist.svg")},
    ),
    Source(
        ("study", "study.toml"),
        {"study": Taken("study.html", PAGE), "pareto-front": Taken("pareto-front.svg")},
    ),
    Source(("study", "rocking"), {"rocking": Taken("own.svg")}),
    Source(("paper",), {"figure-7": Taken("figure-7.svg")}),
)


def run(source: Source, folder: Path) -> Path:
    """Do what a source says within a folder; the folder that it wrote."""
    (folder / "study.toml").write_text(STUDY, encoding="utf-8")
    command = [sys.executable, "-c", "from ehamj.cli import main; main()", *source.arguments, "--out", "made"]
    subprocess.run(command, cwd=folder, check=True)
    return folder / "made"


def photograph(taken: Taken, folder: Path, picture: Path) -> None:
    """Write one picture, cut to what is in it.

    Raises:
        SystemExit: without a browser, or where the picture is too large to be kept.
    """
    program = browser()
    if program is None:
        raise SystemExit("make pictures: needs Chromium, Chrome or Edge; EHAMJ_BROWSER names one")
    page = folder / taken.file
    options = ["--headless", "--no-sandbox", "--disable-gpu", "--hide-scrollbars"]
    size = [f"--window-size={taken.window[0]},{taken.window[1]}", f"--force-device-scale-factor={taken.scale}"]
    subprocess.run(
        [program, *options, *size, f"--screenshot={picture}", page.as_uri()], check=True, capture_output=True
    )
    cut(picture)
    if picture.stat().st_size > LARGEST:
        raise SystemExit(f"{picture}: {picture.stat().st_size} B, more than {LARGEST}")


def cut(picture: Path, border: int = 12) -> None:
    """Take away what is empty at the right and below, and colours beyond the palette."""
    image = Image.open(picture).convert("RGB")
    empty = Image.new("RGB", image.size, image.getpixel((image.width - 1, image.height - 1)))
    where = _difference(image, empty).getbbox() or (0, 0, *image.size)
    image = image.crop((0, 0, min(image.width, where[2] + border), min(image.height, where[3] + border)))
    image.quantize(COLOURS).save(picture, optimize=True)


def _difference(one: Image.Image, other: Image.Image) -> Image.Image:
    from PIL import ImageChops

    return ImageChops.difference(one, other)


def main(wanted: list[str], done: Callable[[str], None] = print) -> None:
    """Make the pictures named, or all."""
    known = {name for source in SOURCES for name in source.taken}
    if unknown := set(wanted) - known:
        raise SystemExit(f"no picture {sorted(unknown)}; there are {sorted(known)}")
    PICTURES.mkdir(exist_ok=True)
    for source in SOURCES:
        names = [name for name in source.taken if not wanted or name in wanted]
        if names:
            with tempfile.TemporaryDirectory() as folder:
                made = run(source, Path(folder))
                for name in names:
                    photograph(source.taken[name], made, PICTURES / f"{name}.png")
                    done(f"docs/pictures/{name}.png")


if __name__ == "__main__":
    main(sys.argv[1:])
