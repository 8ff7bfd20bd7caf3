"""Try cases and say what was found: `make fuzz`, or ``PYTHONPATH=tests python -m fuzz --help``."""

import argparse
import json
import shutil
import sys
import tempfile
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from fuzz.campaign import Tally, run
from fuzz.kinds import KINDS


def main() -> int:
    """Exit code: 1 where anything was found."""
    asked = _arguments()
    with tempfile.TemporaryDirectory(prefix="fuzz-kept-") as kept:
        if asked.case is not None:
            return _once(asked, Path(kept))
        tally, out = Tally(), asked.out
        out.mkdir(parents=True, exist_ok=True)
        last = time.time()

        def told() -> None:
            nonlocal last
            if time.time() - last > 30:
                last = time.time()
                _keep(tally, out, asked)
                print(_line(tally), file=sys.stderr, flush=True)

        try:
            run(_orders(asked), asked.workers, time.time() + 60 * asked.minutes, Path(kept), tally, told)
        finally:
            _keep(tally, out, asked)
            _print(tally, out, asked)
    return int(bool(tally.findings))


def _arguments() -> argparse.Namespace:
    parser = argparse.ArgumentParser(prog="python -m fuzz", description=__doc__)
    about = "; ".join(f"{name}: {kind.about}" for name, kind in KINDS.items())
    parser.add_argument(
        "--kind", action="append", choices=list(KINDS), help=f"kinds of cases, all where none is named ({about})"
    )
    parser.add_argument("--number", type=int, help="cases of each kind; without: those of a full run")
    parser.add_argument("--share", type=float, default=1.0, help="of a full run [-]")
    parser.add_argument("--first", type=int, default=0, help="number of the first case")
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--minutes", type=float, default=1e6, help="after which no case begins")
    parser.add_argument("--workers", type=int, default=2, help="processes")
    parser.add_argument("--case", type=int, help="repeat this case of a kind here, and show all of it")
    parser.add_argument(
        "--out", type=Path, default=Path("runs/fuzz"), help="folder of fuzz.json; with --case: of the case"
    )
    asked = parser.parse_args()
    if asked.case is not None and len(asked.kind or ()) != 1:
        parser.error("--case: name its --kind, one")
    return asked


def _orders(asked: argparse.Namespace) -> Iterator[dict[str, Any]]:
    """Cases of all kinds in turn, so that an early end has some of each."""
    kinds = asked.kind or list(KINDS)
    counts = {
        kind: asked.number if asked.number is not None else round(asked.share * KINDS[kind].full) for kind in kinds
    }
    longest = max(counts.values())
    for step in range(longest):
        for kind in kinds:
            begin, end = (counts[kind] * at // longest for at in (step, step + 1))
            for number in range(begin, end):
                yield {"kind": kind, "seed": asked.seed, "number": asked.first + number}


def _once(asked: argparse.Namespace, kept: Path) -> int:
    from dataclasses import asdict

    from fuzz.judge import findings
    from fuzz.worker import tried

    (kind,) = asked.kind
    folder = asked.out / f"{kind}-{asked.seed}-{asked.case}"
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir(parents=True)
    outcome = asdict(tried(kind, asked.seed, asked.case, kept, folder))
    print(json.dumps({key: value for key, value in outcome.items() if key != "said"}, indent=1, ensure_ascii=False))
    print(outcome["said"])
    found = list(findings(kind, outcome))
    print("\n".join(f"finding: {one}" for one in found) or "nothing found", f"\nthe case is in {folder}")
    return int(bool(found))


def _keep(tally: Tally, out: Path, asked: argparse.Namespace) -> None:
    told = {"seed": asked.seed, "workers": asked.workers, **tally.to_dict()}
    (out / "fuzz.json").write_text(json.dumps(told, indent=1, ensure_ascii=False), encoding="utf-8")


def _line(tally: Tally) -> str:
    return ", ".join(f"{kind} {count}" for kind, count in tally.cases.items()) + f": {len(tally.findings)} findings"


def _print(tally: Tally, out: Path, asked: argparse.Namespace) -> None:
    print(f"{'kind':12}{'cases':>8}  {'named':>8}  {'slowest':>8}  {'most':>9}  s/1000  ends")
    for kind, count in tally.cases.items():
        named, refused = tally.named.get(kind, (0, 0))
        share = f"{100 * named / refused:.2f} %" if refused else "-"
        ends = ", ".join(f"{end}: {number}" for end, number in tally.ends[kind].most_common())
        slow, most = tally.slowest.get(kind, 0.0), tally.largest.get(kind, 0.0)
        pace = 1000 * tally.seconds[kind] / count
        print(f"{kind:12}{count:8}  {share:>8}  {slow:6.2f} s  {most:5.0f} MiB  {pace:6.0f}  {ends}")
    if tally.ended:
        half, most = (sorted(tally.ended)[int(share * (len(tally.ended) - 1))] for share in (0.5, 0.95))
        print(
            f"asked to, commands ended within {half:.2f} s (half), {most:.2f} s (95 %), {max(tally.ended):.2f} s (all)"
        )
    for signature, one in sorted(tally.findings.items(), key=lambda found: -found[1]["count"]):
        case = one["shortest"]
        print(f"\n{one['count']} × {signature}")
        again = f"--kind {case['kind']} --seed {case['seed']} --case {case['number']}"
        print(f"  PYTHONPATH=tests {sys.executable} -m fuzz {again}")
    print(f"\n{out / 'fuzz.json'}")


if __name__ == "__main__":
    sys.exit(main())
