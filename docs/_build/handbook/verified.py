"""The errors that `ehamj verify` measured, kept for the site; `make verified` measures those that are new, and all of
them, in minutes, where a package has another version."""

import json
import math
import platform
from collections.abc import Mapping
from importlib.metadata import version
from pathlib import Path
from typing import Any, Final

from mkdocs.exceptions import PluginError

from ehamj.result import written_whole
from ehamj.verify import CASES, verify
from handbook.reference.tables import literal
from handbook.theory import anchor_of

KEPT: Final = Path(__file__).parents[1] / "verified.json"


def measured(kept: Mapping[str, Any]) -> dict[str, Any]:
    """Errors by case, and with what they were measured; those that are ``kept`` of the same versions stay."""
    versions = {"python": platform.python_version()}
    versions |= {name: version(name) for name in ("ehamj", "mujoco", "numpy", "scipy")}
    known = kept["errors"] if kept["versions"] == versions else {}
    new = [case for name, case in CASES.items() if known.get(name) is None]
    found = verify(lambda one: print(one.case.name, one.error), new) if new else []
    errors = known | {one.case.name: _short(one.error) for one in found}
    return {"errors": {name: errors[name] for name in CASES}, "versions": versions}


def _short(error: float) -> float | None:
    return float(f"{error:.2g}") if math.isfinite(error) else None


def verified_pages() -> dict[str, str]:
    """Markdown by path within the site: every case with its error and its tolerance, which are the program's own."""
    kept = json.loads(KEPT.read_text(encoding="utf-8"))
    if missing := [name for name in CASES if name not in kept["errors"]]:
        raise PluginError(f"{KEPT.name} has no error of {', '.join(missing)}: run `make verified`")
    rows = [
        f"| [{name}](#{anchor_of(name)}) | {kept['errors'][name]:.2g} | {case.tolerance:.2g} | {case.unit} |"
        for name, case in CASES.items()
    ]
    told_of = [
        f"### {name} {{ #{anchor_of(name)} }}\n\n{literal(f'{case.compares}, with: {case.source}')}.\n\n"
        f"Tolerance: {literal(case.why)}.\n"
        for name, case in CASES.items()
    ]
    versions = ", ".join(f"{name} {number}" for name, number in kept["versions"].items())
    told = (
        "`ehamj verify` compares the simulator with independent solutions: closed forms, a SciPy model of the whole "
        "machine with every option, conservation of oil and energy, orders of convergence, modes and equilibria. It "
        f"takes minutes and runs on your machine too. These errors were measured with {versions}."
    )
    heads = ["| case | error | tolerance | unit |", "|---|---|---|---|"]
    page = ["# Verified cases\n", f"{told}\n", *heads, *rows, "\n## What is compared\n", *told_of]
    return {"validation/verified.md": "\n".join(page)}


if __name__ == "__main__":
    with written_whole(KEPT) as beside:
        kept_now = json.loads(KEPT.read_text(encoding="utf-8"))
        beside.write_text(json.dumps(measured(kept_now), indent=1, ensure_ascii=False) + "\n", encoding="utf-8")
