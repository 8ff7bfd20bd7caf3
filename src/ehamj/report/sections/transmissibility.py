"""Transmissibility of the floor that a run had: linear, and measured from the run."""

from collections.abc import Collection, Iterator
from typing import Final

from ehamj import plots
from ehamj.linear.response import machine_channels, unit
from ehamj.pages import Picture, Section
from ehamj.pages.words import AXIS_NAMES
from ehamj.report.comparison import UNKNOWN, linear, measured
from ehamj.report.shown import Shown
from ehamj.rig.comparison import own_output

NOTE: Final = (
    "Displacement of the machine (translation of its centre of gravity, rotation) over that of the floor, of which a "
    "rigid slab is fitted to the mounts. Lines: linear, about the equilibrium, with the sampled control loop. Marks or "
    "broken lines: measured from the run, each direction by itself; coherence below one tells of other directions that "
    "move the machine as well, of noise, and of the valves' nonlinearity."
)


def transmissibility(shown: Shown) -> Section:
    """The vertical, and what else the floor of a run excites; a run that is too short shows the linear one alone."""
    return Section("transmissibility", "Transmissibility", list(figures_of(shown)), notes=[NOTE])


def figures_of(shown: Shown, motions: Collection[str] = tuple(AXIS_NAMES)) -> Iterator[Picture]:
    """Transmissibility of some motions: the vertical, and those that the floor excites."""
    evaluations = {label: one for label, one in shown.evaluations.items() if one.machine.model is not None}
    if not evaluations:
        return
    passive = any(result.scenario.control.kind == "passive" for result in shown.results.values())
    held = None if passive else next(iter(evaluations.values())).machine.transfer
    for dof, words in AXIS_NAMES.items():
        if dof not in motions:
            continue
        output = own_output(machine_channels(), dof)
        curves = [] if held is None else [linear("valves held", held, output, dof, plots.GREY)]
        curves += [
            linear(label, one.transfer, output, dof, shown.colors[label])
            for label, one in evaluations.items()
            if one.transfer is not None
        ]
        found = {label: one.measured[dof] for label, one in evaluations.items() if dof in one.measured}
        if not found and dof != "z":
            continue
        curves += [measured(label, one, output, dof, shown.colors[label]) for label, one in found.items()]
        methods = dict.fromkeys(one.method for one in found.values())
        caption = f"Measured: {'; '.join(methods)}; {UNKNOWN}." if found else "Not measured: the run is too short."
        figure = plots.response(f"Transmissibility, {words}", curves, unit(output, dof))
        yield Picture(f"transmissibility-{dof}", figure, caption)
