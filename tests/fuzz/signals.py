"""Commands ended from outside at any moment: what they leave is nothing or whole, and the next one succeeds."""

import os
import shutil
import signal
import subprocess
import sys
import time
from pathlib import Path
from random import Random
from tempfile import mkdtemp
from typing import TYPE_CHECKING, Final, NamedTuple

from ehamj.unfinished import _NAME as UNFINISHED
from fuzz.worker import Outcome

if TYPE_CHECKING:
    import pandas

LIMIT: Final = 5.0
"""Within which a command ends that is asked to [s]: it promises one second of a machine that has nothing else to do,
and here as many processes as cores try cases beside it."""
PATIENCE: Final = 300.0
"""Within which a command that is left alone ends [s]."""
SIGNALS: Final = (signal.SIGKILL, signal.SIGINT, signal.SIGTERM)
SMALL: Final = ("--set", "duration=0.2", "--set", "compare=[]", "--set", "ground={kind='rest'}")


class Job(NamedTuple):
    """A command that writes a folder, and whether one stands there already."""

    name: str
    words: tuple[str, ...]
    replaces: bool = False
    resumes: bool = False
    """Whether what is there is kept, and it goes on with that."""


JOBS: Final = (
    Job("run", ("run", "recorded", *SMALL, "--set", "name=new", "--out", "out")),
    Job("bare run", ("run", "recorded", *SMALL, "--set", "name=new", "--no-report", "--no-replay", "--out", "out")),
    Job("replacing run", ("run", "recorded", *SMALL, "--set", "name=new", "--out", "out", "--overwrite"), True),
    Job("study", ("study", "rocking", "recorded", "--out", "out")),
    Job("study file", ("study", "paper-sensitivity", "--set", "plan.groups=16", "--out", "out"), resumes=True),
    Job("design", ("design", "recorded", "--architecture", "feedforward", *SMALL, "--out", "out")),
)


class Whole(NamedTuple):
    """What a job takes when it is left alone, and all that it leaves."""

    seconds: float
    folder: Path

    @property
    def names(self) -> set[str]:
        return _names(self.folder)


def whole(job: Job, kept: Path) -> Whole:
    """A job that nothing ends, done once."""
    folder = kept / f"whole-{job.name.replace(' ', '-')}"
    if not (folder / "seconds").is_file():
        made = Path(mkdtemp(dir=kept))
        began = time.monotonic()
        words = tuple("name=old" if word == "name=new" and job.replaces else word for word in job.words)
        process = _begin(tuple(word for word in words if word != "--overwrite"), made)
        code = process.wait(PATIENCE)
        if code:
            raise RuntimeError(f"{job.name} ends with {code}: {(made / 'said').read_text()}")
        (made / "seconds").write_text(str(time.monotonic() - began))
        try:
            made.rename(folder)
        except OSError:  # another worker was first
            shutil.rmtree(made)
    return Whole(float((folder / "seconds").read_text()), folder / "out")


def _begin(words: tuple[str, ...], folder: Path) -> "subprocess.Popen[bytes]":
    command = [sys.executable, "-c", "from ehamj.cli import main; main()", *words]
    with (folder / "said").open("wb") as said:
        return subprocess.Popen(
            command, cwd=folder, stdout=subprocess.DEVNULL, stderr=said, env={**os.environ, "COLUMNS": "200"}
        )


def _names(folder: Path) -> set[str]:
    return {str(path.relative_to(folder)) for path in folder.rglob("*") if path.is_file()}


def interrupted(random: Random, kept: Path, folder: Path) -> Outcome:
    """Begin a job, end it at some moment, look, and do it again in the same place."""
    job, number = random.choice(JOBS), random.choice(SIGNALS)
    good = whole(job, kept)
    if job.replaces:
        shutil.copytree(good.folder, folder / "out")
    share = random.uniform(0.02, 1.02)
    found = Outcome(told=f"{job.name}, {number.name} after {share:.2f} of its time", commands=[list(job.words)])
    process = _begin(job.words, folder)
    try:
        code: int | None = process.wait(share * good.seconds)
    except subprocess.TimeoutExpired:
        code = None
    if code is None:
        began = time.monotonic()
        process.send_signal(number)
        try:
            code = process.wait(60.0)
        except subprocess.TimeoutExpired:
            process.kill()
            code = process.wait()
        found.ended = None if number == signal.SIGKILL else round(time.monotonic() - began, 3)
    found.said = (folder / "said").read_text(errors="replace")
    found.codes = [130 if code == -signal.SIGKILL and number == signal.SIGKILL else code]
    found.whole = _wrong(job, good, folder, number) or _again(job, good, folder)
    return found


def _wrong(job: Job, good: Whole, folder: Path, number: signal.Signals) -> str:
    """What is wrong with what was left."""
    out, left = folder / "out", [path.name for path in folder.iterdir() if UNFINISHED.fullmatch(path.name)]
    if left and number != signal.SIGKILL:
        return f"{job.name}: {number.name} leaves {left[0].split('-')[0]}"
    if out.is_dir() and not any(out.iterdir()) and number == signal.SIGKILL:
        return ""  # it holds the name; the next run clears it
    if job.replaces and not out.is_dir() and not any(".replaced-" in name for name in left):
        return f"{job.name}: neither the old result nor the new one is there after {number.name}"
    if job.resumes:
        return ""  # finished designs are kept
    return _incomplete(job, good, out) if out.exists() else ""


def _incomplete(job: Job, good: Whole, out: Path) -> str:
    """What is missing of a folder that is there, or is in it too much."""
    missing, more = good.names - _names(out), _names(out) - good.names
    if missing:
        return f"{job.name}: {min(missing)} is missing"
    if more:
        return f"{job.name}: {min(more)} is left"
    if job.resumes:
        return "" if _designs(good.folder).equals(_designs(out)) else f"{job.name}: other designs than undisturbed"
    if job.words[0] != "run":
        return ""
    from ehamj.result import load_result

    try:
        result = load_result(out)
    except Exception as error:
        return f"{job.name}: load_result: {type(error).__name__}: {error}"
    return "" if result.complete else f"{job.name}: the result is incomplete"


def _designs(folder: Path) -> "pandas.DataFrame":
    from ehamj.campaign.tables import frame

    return frame(folder).drop(columns="seconds")


def _again(job: Job, good: Whole, folder: Path) -> str:
    """What is wrong with the same job done again in the same place."""
    there = (folder / "out").is_dir() and any((folder / "out").iterdir())
    words = job.words if job.replaces or not there else (*job.words, "--overwrite")
    if job.resumes and (folder / "out" / "designs.sqlite").is_file():
        words = (*job.words, "--resume")
    code = _begin(words, folder).wait(PATIENCE)
    if code:
        return f"{job.name}: done again it ends with {code}: {(folder / 'said').read_text(errors='replace')[-300:]}"
    left = [path.name for path in folder.iterdir() if UNFINISHED.fullmatch(path.name)]
    return (
        f"{job.name}: done again it leaves {left[0].split('-')[0]}" if left else _incomplete(job, good, folder / "out")
    )
