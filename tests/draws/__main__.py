"""Draw machines, measure and identify them, and say how honest what comes back is: `make draws`, or
``PYTHONPATH=tests python -m draws --help``."""

import argparse
import json
import multiprocessing
import os
import sys
from collections.abc import Iterator
from concurrent.futures import ProcessPoolExecutor, as_completed
from pathlib import Path
from typing import Any

from draws.summary import summary
from draws.trial import KINDS, tried


def main() -> int:
    """Exit code: 1 where what is asked is missed."""
    asked = _arguments()
    asked.out.mkdir(parents=True, exist_ok=True)
    path = asked.out / "draws.jsonl"
    known = told(path)
    done = {(one["kind"], one["seed"], one["number"]) for one in known}
    orders = [order for order in _orders(asked) if order not in done]
    with ProcessPoolExecutor(asked.workers, multiprocessing.get_context("spawn")) as pool:
        for one in as_completed([pool.submit(tried, *order) for order in orders]):
            known.append(one.result())
            with path.open("a", encoding="utf-8") as file:
                file.write(json.dumps(known[-1], ensure_ascii=False) + "\n")
            print(f"{known[-1]['kind']} {known[-1]['number']}", file=sys.stderr, flush=True)
    lines = summary([one for one in known if one["seed"] == asked.seed])
    print("\n".join([*lines, "", str(path)]))
    return int(any("MISSED" in line for line in lines))


def told(path: Path) -> list[dict[str, Any]]:
    """Trials that are known; a last line that was cut off is none."""
    if not path.exists():
        return []
    lines = path.read_text(encoding="utf-8").splitlines(keepends=True)
    whole = [line for line in lines if line.endswith("\n")]
    if len(whole) < len(lines):
        path.write_text("".join(whole), encoding="utf-8")
    return [json.loads(line) for line in whole]


def _orders(asked: argparse.Namespace) -> Iterator[tuple[str, int, int]]:
    """Kinds in turn, so that an early end has some of each."""
    for number in range(asked.first, asked.first + asked.number):
        for kind in asked.kind or ("values", "options"):
            yield kind, asked.seed, number


def _arguments() -> argparse.Namespace:
    parser = argparse.ArgumentParser(prog="python -m draws", description=__doc__)
    about = "; ".join(f"{name}: {kind.about}" for name, kind in KINDS.items())
    parser.add_argument(
        "--kind", action="append", choices=list(KINDS), help=f"values and options where none is named ({about})"
    )
    parser.add_argument("--number", type=int, default=100, help="draws of each kind; those that are known stay")
    parser.add_argument("--first", type=int, default=0, help="number of the first draw")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--workers", type=int, default=os.cpu_count() or 1, help="processes")
    parser.add_argument("--out", type=Path, default=Path("runs/draws"), help="folder of draws.jsonl")
    return parser.parse_args()


if __name__ == "__main__":
    sys.exit(main())
