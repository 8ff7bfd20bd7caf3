"""A process that puts cases before the command line, one after the other, and says what came of each.

Orders are lines of JSON on standard input, answers lines of JSON on the descriptor that `--answers` names.
"""

import contextlib
import faulthandler
import json
import os
import resource
import shutil
import signal
import sys
import tempfile
import time
from collections.abc import Iterator
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Any

SPACE = 6 * 2**30
"""Addresses beyond those of an idle worker [B]."""
EXECUTES = ("os.system", "os.exec", "os.posix_spawn", "os.spawn", "os.startfile", "subprocess.Popen", "socket.connect")
"""What no input may lead to; pages are drawn in forked processes."""
CLASSES = {"os", "posix", "nt", "subprocess", "sys", "shutil", "importlib", "socket", "ctypes", "pty", "runpy"}
"""Modules of which no pickle may name anything."""


@dataclass
class Outcome:
    """What came of a case: per command its exit code, times and memory; what was said; what is left."""

    codes: list[int] = field(default_factory=list)
    seconds: list[float] = field(default_factory=list)
    """Of the processor."""
    memory: list[float] = field(default_factory=list)
    """Above what was taken before [MiB]."""
    said: str = ""
    printed: int = 0
    left: list[str] = field(default_factory=list)
    whole: str = ""
    """What is wrong with a result that is there; empty for one that is whole, or none."""
    complete: bool | None = None
    executed: list[str] = field(default_factory=list)
    told: str = ""
    keys: list[str] = field(default_factory=list)
    commands: list[list[str]] = field(default_factory=list)
    damaged: bool = False
    ended: float | None = None
    """How long a command took to end that was asked to [s]."""


_heard: list[str] = []
_hearing = False


def _audit(event: str, arguments: tuple[Any, ...]) -> None:
    if not _hearing:
        return
    if event == "subprocess.Popen" and list(arguments[1][:2]) == ["git", "rev-parse"]:
        return  # Rerun asks where it is
    if event in EXECUTES or (event == "pickle.find_class" and str(arguments[0]).partition(".")[0] in CLASSES):
        _heard.append(f"{event} {arguments[:2]}"[:200])


def peak() -> float:
    """Most memory taken since `forget_peak` [MiB], and if that cannot be told, since the beginning."""
    with contextlib.suppress(OSError), Path("/proc/self/status").open() as status:
        return next(float(line.split()[1]) / 1024 for line in status if line.startswith("VmHWM"))
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024


def forget_peak() -> float:
    """Memory that is taken now [MiB], from which on the peak counts."""
    with contextlib.suppress(OSError), Path("/proc/self/clear_refs").open("w") as clear:
        clear.write("5")
    return peak()


@contextlib.contextmanager
def into_files(folder: Path) -> Iterator[None]:
    """Standard output and error, of C as well, into files."""
    sys.stdout.flush()
    sys.stderr.flush()
    before = [os.dup(number) for number in (1, 2)]
    for number, name in ((1, "stdout"), (2, "stderr")):
        file = os.open(folder / name, os.O_WRONLY | os.O_CREAT | os.O_APPEND)
        os.dup2(file, number)
        os.close(file)
    try:
        yield
    finally:
        sys.stdout.flush()
        sys.stderr.flush()
        for number, kept in zip((1, 2), before, strict=True):
            os.dup2(kept, number)
            os.close(kept)


def called(arguments: tuple[str, ...] | list[str]) -> int:
    """Exit code of the command line."""
    from ehamj.cli import main

    sys.argv = ["ehamj", *arguments]
    try:
        main()
    except SystemExit as ended:
        return int(ended.code or 0)


@contextlib.contextmanager
def _own_folder(keep: Path | None) -> Iterator[Path]:
    folder = keep or Path(tempfile.mkdtemp(prefix="fuzz-"))
    try:
        yield folder
    finally:
        if keep is None:
            shutil.rmtree(folder, ignore_errors=True)


def tried(kind: str, seed: int, number: int, kept: Path, keep: Path | None = None) -> Outcome:
    """Put a case before the command line, in a folder of its own or in one to ``keep``."""
    global _hearing
    from fuzz.case import MARK, chance
    from fuzz.kinds import KINDS

    random, own = chance(kind, seed, number), KINDS[kind]
    if own.try_out is not None:
        with _own_folder(keep) as folder:
            return own.try_out(random, kept, folder)
    assert own.make is not None
    case = own.make(random, kept)
    found = Outcome(
        told=case.told, keys=list(case.keys), commands=[list(one) for one in case.commands], damaged=case.damaged
    )
    folder = keep or Path(tempfile.mkdtemp(prefix="fuzz-"))
    said = Path(tempfile.mkdtemp(prefix="fuzz-said-"))
    stood = Path.cwd()
    try:
        case.lay(folder)
        laid = {str(path.relative_to(folder)) for path in folder.rglob("*")}
        os.chdir(folder)
        for command in case.commands:
            _heard.clear()
            before, began = forget_peak(), time.process_time()
            with into_files(said):
                _hearing = True
                try:
                    found.codes.append(called(command))
                finally:
                    _hearing = False
            found.seconds.append(round(time.process_time() - began, 3))
            found.memory.append(round(peak() - before, 1))
            found.executed += _heard
            if found.codes[-1]:
                break
        found.said = (said / "stderr").read_text(encoding="utf-8", errors="replace")
        found.printed = (said / "stdout").stat().st_size
        if (folder / MARK).exists():
            found.executed.append("content of a file")
        found.left = sorted({str(path.relative_to(folder)) for path in folder.rglob("*")} - laid)
        if (folder / "out" / "summary.json").is_file():
            found.complete, found.whole = looked_at(folder / "out")
    finally:
        os.chdir(stood)
        shutil.rmtree(said, ignore_errors=True)
        if keep is None:
            shutil.rmtree(folder, ignore_errors=True)
    return found


def looked_at(folder: Path) -> tuple[bool, str]:
    """Whether a result says that it is complete, and what is wrong with it."""
    import numpy as np

    from ehamj.result import load_result

    try:
        result = load_result(folder)
    except Exception as error:
        return False, f"load_result: {type(error).__name__}: {error}"
    lost = [str(name) for name, channel in result.dataset.data_vars.items() if not np.isfinite(channel.values).all()]
    short = result.complete and result.dataset.time.size < 2
    wrong = f"{lost[0]} is not finite" if lost and result.complete else "complete, without rows" if short else ""
    return result.complete, wrong


def main() -> None:
    """Take orders until there is none."""
    answers = os.fdopen(int(sys.argv[1]), "w")
    kept = Path(sys.argv[2])
    where = Path(sys.argv[3]).open("w")  # noqa: SIM115  # for as long as the process lasts
    faulthandler.register(signal.SIGUSR1, where, all_threads=True)
    from fuzz.warm import warm

    warm(kept)
    sys.addaudithook(_audit)
    taken = int(Path("/proc/self/statm").read_text().split()[0]) * os.sysconf("SC_PAGE_SIZE")
    resource.setrlimit(resource.RLIMIT_AS, (taken + SPACE, taken + SPACE))
    print(json.dumps({"ready": True}), file=answers, flush=True)
    for line in sys.stdin:
        order = json.loads(line)
        found = tried(order["kind"], order["seed"], order["number"], kept)
        print(json.dumps({**order, **asdict(found)}), file=answers, flush=True)


if __name__ == "__main__":
    main()
