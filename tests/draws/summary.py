"""What many trials show beside what is asked of them, in words."""

from collections.abc import Iterator, Mapping, Sequence
from typing import Any, Final

import numpy as np

from draws.machines import OPTIONS

SPREAD: Final = (0.8, 1.25)
"""RMS of errors over their stated deviations."""
BEYOND: Final = 3.0
"""Error over its stated deviation that few have."""
WITHIN: Final = 0.98
"""Share of errors that stay within it, at least."""
WIDE: Final = 1.5
"""Stated deviation over the least possible one, at most."""
FOUND, FALSE = 0.95, 0.05
"""Share of options that are found where they are, at least, and where they are not, at most."""

Trials = Sequence[Mapping[str, Any]]


def summary(trials: Trials) -> list[str]:
    """Lines of all kinds of trials that there are; empty where there are none."""
    lines = []
    for kind in dict.fromkeys(one["kind"] for one in trials):
        own = [one for one in trials if one["kind"] == kind]
        whole = [one for one in own if "found" in one]
        seconds = np.median([one["seconds"] for one in whole]) if whole else float("nan")
        lines.append(
            f"{kind}: {len(own)} draws, {len(own) - len(whole)} without an end; a draw takes {seconds:.0f} s of CPU"
        )
        lines += [f"  {one['number']}: {one['failed']}" for one in own if "failed" in one]
        lines += [*_values(whole), *_options(whole)]
    return lines


def errors(trials: Trials) -> dict[str, np.ndarray]:
    """Error of each value over its stated deviation, by key, (draw,); NaN where it came back without a number."""
    keys = dict.fromkeys(key for one in trials for key in one["true"])
    return {key: np.array([_error(one, key) for one in trials]) for key in keys}


def _error(trial: Mapping[str, Any], key: str) -> float:
    value, deviation, _ = trial["found"][key]
    return float("nan") if value is None else (value - trial["true"][key]) / deviation


def _values(trials: Trials) -> Iterator[str]:
    if not trials:
        return
    found = errors(trials)
    yield f"  {'':40}{'RMS':>6}{'within 3':>10}{'most':>7}{'without':>9}   over the least possible: median, most"
    for key, own in found.items():
        yield _line(key, own, _widths(trials, key))
    everything = np.concatenate(list(found.values()))
    widths = np.concatenate([_widths(trials, key) for key in found])
    yield _line("all", everything, widths)
    known = everything[np.isfinite(everything)]
    low, high = SPREAD
    share = float(np.mean(np.abs(known) < BEYOND))
    yield _asked(low <= float(np.sqrt(np.mean(known**2))) <= high, f"RMS of {low:g} to {high:g}")
    yield _asked(share >= WITHIN, f"{100 * WITHIN:g} % within {BEYOND:g} deviations")
    if widths.size:
        narrow = float(np.mean(widths < WIDE))
        yield _asked(narrow == 1.0, f"deviations within {WIDE:g} times the least possible ({100 * narrow:.1f} % are)")


def _widths(trials: Trials, key: str) -> np.ndarray:
    known = [one for one in trials if "bound" in one and one["found"][key][0] is not None]
    return np.array([one["found"][key][1] / one["bound"][key] for one in known])


def _line(name: str, own: np.ndarray, widths: np.ndarray) -> str:
    known = own[np.isfinite(own)]
    if not known.size:
        return f"  {name:40}{'':23}{own.size:>9}"
    told = f"{np.sqrt(np.mean(known**2)):6.2f}{100 * np.mean(np.abs(known) < BEYOND):8.1f} %{np.abs(known).max():7.2f}"
    wide = f"   {np.median(widths):.2f}, {widths.max():.2f}" if widths.size else ""
    return f"  {name:40}{told}{own.size - known.size:>9}{wide}"


def _options(trials: Trials) -> Iterator[str]:
    own = [one for one in trials if "justified" in one]
    for name in OPTIONS if own else ():
        there = [name in one["justified"] for one in own if name in one["options"]]
        absent = [name in one["justified"] for one in own if name not in one["options"]]
        found, false = f"{sum(there)} of {len(there)}", f"{sum(absent)} of {len(absent)}"
        yield f"  {name}: found {found} where it is, {false} where it is not"
        if there:
            yield _asked(sum(there) >= FOUND * len(there), f"found in {100 * FOUND:g} %")
        if absent:
            yield _asked(sum(absent) <= FALSE * len(absent), f"false in {100 * FALSE:g} % at most")


def _asked(met: bool, what: str) -> str:
    return f"    {'met' if met else 'MISSED'}: {what}"
