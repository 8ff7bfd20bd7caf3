"""The benchmark case in the best peer, beside the bare loop, over which the part *engines* has ehamj's own rates."""

from collections.abc import Mapping
from importlib import import_module
from typing import Any, Final

from ehamj.bench.ceiling import Ceiling
from ehamj.bench.engines import FINER, benchmark, deviation
from ehamj.bench.exudyn_case import ExudynCase
from ehamj.bench.parts import Effort, Figures, part
from ehamj.bench.reading import BARE, BARE_IS, HIGHER, LOWER, RATE, Table
from ehamj.bench.runs import medians
from ehamj.errors import InputError
from ehamj.extras import check_extra
from ehamj.plots.timings import Bars, Panel

PEER: Final = "Exudyn"


def _panels(figures: Mapping[str, Any]) -> list[Panel]:
    peer = figures["peer"]
    rates, errors = peer["simulated_s_per_wall_s"], peer["error"]
    notes = {name: f"(error {error:.1e})" for name, error in errors.items()}
    return [Bars("Benchmark case, with the best peer", f"{RATE} ({HIGHER})", rates, notes)]


def _tables(figures: Mapping[str, Any]) -> list[Table]:
    found = figures["peer"]
    columns = {
        "simulated\ns per s [-]": found["simulated_s_per_wall_s"],
        "rate over\nbare loop [-]": found["rate_over_bare_loop"],
        "error\n[-]": found["error"],
    }
    words = (
        f"A row is who steps it; the bare scalar loop is {BARE_IS}. The part engines has rates of ehamj's own over it. "
        f"Rates: {HIGHER}; errors (largest, over a channel's peak): {LOWER}."
    )
    names = {name: name for name in found["error"]}
    return [Table.of("The benchmark case in the best peer", words, "who steps", columns, names)]


def check_peer() -> Any:
    """The peer's package.

    Raises:
        InputError: if it is not installed, or is of another system.
    """
    check_extra("exudyn", "peer")
    try:
        return import_module("exudyn")
    except ImportError as error:
        raise InputError(f"peer: Exudyn cannot be imported ({error})") from None


@part(
    "peer", "the benchmark case in Exudyn, where it is installed", _panels, read=_tables, asked=True, check=check_peer
)
def peer(effort: Effort) -> Figures:
    """Rates and errors of peer and bare loop."""
    exudyn = check_peer()
    scenario, step = benchmark(effort)
    works: dict[str, Any] = {BARE: Ceiling(scenario, step), PEER: ExudynCase(exudyn, scenario, step)}
    times = medians(works, effort.repetitions)
    reference = Ceiling(scenario, step / FINER).channels()
    return {
        "peer": {
            "step_s": step,
            "simulated_s_per_wall_s": {name: scenario.duration / seconds for name, seconds in times.items()},
            "rate_over_bare_loop": {name: times[BARE] / seconds for name, seconds in times.items()},
            "error": {name: deviation(work.channels(), reference) for name, work in works.items()},
        }
    }
