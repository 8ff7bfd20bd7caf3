"""Many cases on some workers, each in bounded time; what was found, grouped."""

import json
import os
import select
import signal
import subprocess
import sys
import tempfile
import time
from collections import Counter
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Final

import psutil

TIME: Final = 60.0
"""Of the processor, within which a case ends, unless it steps a long run [s]."""
PATIENCE: Final = 900.0
"""Within which it ends that waits for something [s]: on a busy machine a short case lasts."""
START: Final = 300.0
"""Within which a worker is ready: it may have to compile [s]."""
TURNS: Final = 400
"""Cases after which a worker is replaced by a fresh one."""
STEPPING: Final = ("drive.py", "advance.py", "aftermath.py", "observe.py")
"""Where a run that was accepted is, that lasts: its stack shows one of these files."""


@dataclass
class Worker:
    """One process that tries cases; see `fuzz.worker`."""

    kept: Path
    process: subprocess.Popen[bytes] = field(init=False)
    answers: int = field(init=False)
    stack: Path = field(init=False)
    turns: int = 0
    order: dict[str, Any] | None = None
    began: float = 0.0
    used: float = 0.0
    ready: bool = False
    _rest: bytes = b""

    def __post_init__(self) -> None:
        reading, writing = os.pipe()
        self.answers = reading
        handle, name = tempfile.mkstemp(prefix="fuzz-stack-")
        os.close(handle)
        self.stack = Path(name)
        arguments = [sys.executable, "-m", "fuzz.worker", str(writing), str(self.kept), name]
        quiet = {"COLUMNS": "200", "NO_COLOR": "1", "OPENBLAS_NUM_THREADS": "1", "PYTHONWARNINGS": "default"}
        seen = {name: value for name, value in os.environ.items() if name not in ("DISPLAY", "WAYLAND_DISPLAY")}
        # A worker starts elsewhere, where relative paths of this process lead to nothing.
        paths = [str(Path(path).absolute()) for path in seen.get("PYTHONPATH", "").split(os.pathsep) if path]
        seen["PYTHONPATH"] = os.pathsep.join([str(Path(__file__).parents[1].absolute()), *paths])
        self.process = subprocess.Popen(
            arguments, stdin=subprocess.PIPE, pass_fds=[writing], env={**seen, **quiet}, cwd=tempfile.gettempdir()
        )
        os.close(writing)
        self.began = time.monotonic()

    def give(self, order: dict[str, Any]) -> None:
        """A case to try."""
        self.order, self.began, self.turns = order, time.monotonic(), self.turns + 1
        self.used = self.processor()
        assert self.process.stdin is not None
        self.process.stdin.write(json.dumps(order).encode() + b"\n")
        self.process.stdin.flush()

    def lines(self) -> Iterator[dict[str, Any]] | None:
        """What it answered since; None where it is gone."""
        data = os.read(self.answers, 2**20)
        if not data:
            return None
        *whole, self._rest = (self._rest + data).split(b"\n")
        return (json.loads(line) for line in whole)

    def processor(self) -> float:
        """Time of the processor that it has used [s]."""
        try:
            return sum(psutil.Process(self.process.pid).cpu_times()[:2])
        except psutil.Error:
            return 0.0

    @property
    def late(self) -> bool:
        """Whether it should have answered."""
        waited = time.monotonic() - self.began
        if not self.ready:
            return waited > START
        return self.order is not None and (waited > PATIENCE or (waited > TIME and self.processor() - self.used > TIME))

    def shown(self) -> str:
        """Where the process is, of all its threads."""
        self.process.send_signal(signal.SIGUSR1)
        time.sleep(0.5)
        return self.stack.read_text()

    def end(self) -> int:
        """Exit code of the process, which is ended where it has not."""
        if self.process.stdin is not None:
            self.process.stdin.close()
        if self.process.poll() is None:
            self.process.kill()
        os.close(self.answers)
        self.stack.unlink(missing_ok=True)
        return self.process.wait()


@dataclass
class Tally:
    """What was found so far."""

    cases: Counter[str] = field(default_factory=Counter)
    ends: dict[str, Counter[str]] = field(default_factory=dict)
    findings: dict[str, dict[str, Any]] = field(default_factory=dict)
    slowest: dict[str, float] = field(default_factory=dict)
    largest: dict[str, float] = field(default_factory=dict)
    named: dict[str, list[int]] = field(default_factory=dict)
    seconds: Counter[str] = field(default_factory=Counter)
    ended: list[float] = field(default_factory=list)
    """How long commands took to end that were asked to [s]."""

    def add(self, kind: str, end: str, found: list[str], case: dict[str, Any]) -> None:
        """Count a case that ended so, with what was found of it; the shortest of each finding is kept."""
        self.cases[kind] += 1
        self.ends.setdefault(kind, Counter())[end] += 1
        for signature in found:
            key = f"{kind}: {signature}"
            one = self.findings.setdefault(key, {"count": 0, "shortest": None})
            one["count"] += 1
            size = len(case.get("told", "")) + len(case.get("said", ""))
            if one["shortest"] is None or size < one["size"]:
                one["shortest"], one["size"] = case, size

    def to_dict(self) -> dict[str, Any]:
        """All of it as plain data."""
        return {
            "cases": dict(self.cases), "ends": {kind: dict(one) for kind, one in self.ends.items()},
            "named": self.named, "slowest_refusal_s": self.slowest, "largest_refusal_mib": self.largest,
            "ended_s": sorted(self.ended), "seconds": dict(self.seconds), "findings": self.findings,
        }  # fmt: skip


def run(
    orders: Iterator[dict[str, Any]], workers: int, until: float, kept: Path, tally: Tally, told: Callable[[], None]
) -> None:
    """Try cases until there are no more or it is late, on ``workers`` processes."""
    pool = [Worker(kept)]
    try:
        _turn(pool, orders, workers, until, kept, tally, told)
    finally:
        for worker in pool:
            worker.end()


def _turn(
    pool: list[Worker],
    orders: Iterator[dict[str, Any]],
    workers: int,
    until: float,
    kept: Path,
    tally: Tally,
    told: Callable[[], None],
) -> None:
    following = next(orders, None)
    while following is not None or any(worker.order for worker in pool):
        if time.time() > until:
            following = None
        for worker in select.select(pool_ends := {one.answers: one for one in pool}, [], [], 1.0)[0]:
            one = pool_ends[worker]
            found = one.lines()
            if found is None:
                pool.remove(one)
                _gone(one, tally)
                if following is not None:
                    pool.append(Worker(kept))
                continue
            for answer in found:
                if one.ready:
                    _count(answer, tally, time.monotonic() - one.began)
                    one.order = None
                one.ready = True
                if len(pool) < workers and following is not None:  # the first has compiled what the others load
                    pool.append(Worker(kept))
        for one in list(pool):
            if one.late:
                pool.remove(one)
                _late(one, tally)
                if following is not None:
                    pool.append(Worker(kept))
            elif one.ready and one.order is None and one.turns >= TURNS and following is not None:
                pool.remove(one)
                one.end()
                pool.append(Worker(kept))
            elif one.ready and one.order is None and following is not None:
                one.give(following)
                following = next(orders, None)
        told()


def _count(answer: dict[str, Any], tally: Tally, seconds: float) -> None:
    from fuzz.judge import findings, named

    kind, code = answer["kind"], answer["codes"][-1]
    tally.seconds[kind] += seconds
    tally.ended += [] if answer["ended"] is None else [answer["ended"]]
    if code == 2:
        tally.slowest[kind] = max(tally.slowest.get(kind, 0.0), answer["seconds"][-1])
        tally.largest[kind] = max(tally.largest.get(kind, 0.0), answer["memory"][-1])
        counts = tally.named.setdefault(kind, [0, 0])
        counts[0] += named(answer, answer["said"])
        counts[1] += 1
    tally.add(kind, str(code), list(findings(kind, answer)), answer)


def _gone(worker: Worker, tally: Tally) -> None:
    code = worker.end()
    if worker.order is None:
        raise RuntimeError(f"a worker ended with {code} before it had a case")
    tally.add(worker.order["kind"], "died", [f"the process ended with {code}"], worker.order)


def _late(worker: Worker, tally: Tally) -> None:
    shown = worker.shown()
    worker.end()
    if worker.order is None:
        raise RuntimeError(f"a worker was not ready in {START:g} s:\n{shown}")
    kind = worker.order["kind"]
    tally.seconds[kind] += TIME
    if any(f"/{name}" in shown for name in STEPPING):
        tally.add(kind, "long run", [], worker.order)
        return
    ours = [line.strip() for line in shown.splitlines() if "/ehamj/" in line]
    place = ours[0].split("/ehamj/")[-1] if ours else "outside of ehamj"
    tally.add(
        kind, "late", [f"no end in {TIME:g} s of the processor at {place}"], {**worker.order, "stack": shown[:8000]}
    )
