"""Transmissibilities as figures and tables: on a page of their own, and as a section of a run's report."""

from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Final

import numpy as np

from ehamj import plots
from ehamj.analysis.comparison import COHERENT, Comparison, Variant, own_output
from ehamj.analysis.transmissibility import ZERO, unit
from ehamj.plots import Response
from ehamj.report.document import render, write_page
from ehamj.report.parts import Picture, Table
from ehamj.report.words import AXIS_NAMES, decibel, exact, number

NAMES: Final = {**AXIS_NAMES, "rz": "yaw, rz"}
MATRIX_UNIT: Final = "m/m"


def write_transmissibility(folder: Path, found: Comparison) -> None:
    """Write ``transmissibility.html``, one page without external parts, and its figures as ``figures/*.svg``."""
    pictures = [*elements(found), *matrix(found)]
    write_page(folder, "transmissibility.html", pictures, lambda drawings: _page(found, pictures, drawings))


def _page(found: Comparison, pictures: Sequence[Picture], drawings: Mapping[str, str]) -> str:
    point = {"cg": "the centre of gravity", "mounts": "the mount plane's centre"}[found.settings.reference]
    methods = list(dict.fromkeys(one.method for variant in found.variants for one in variant.measured))
    return render(
        "transmissibility.html",
        pictures,
        drawings,
        scenario=found.scenario,
        point=point,
        methods=methods,
        tables=[*attenuation_tables(found), *agreement_table(found)],
    )


def colors(variants: Sequence[Variant]) -> dict[str, str]:
    """Colour of each variant; passive always has the same."""
    others = iter((plots.BLUE, plots.GREEN, plots.PURPLE, plots.SKY, plots.ORANGE) * len(variants))
    return {one.name: plots.VERMILLION if one.name == "passive" else next(others) for one in variants}


def elements(found: Comparison, section: str = "responses") -> Iterator[Picture]:
    """A figure for each degree of freedom of the floor: the machine's own answer in it, linear and measured."""
    for dof in found.settings.dofs:
        output = own_output(found.outputs, dof)
        title = f"Floor to machine, {NAMES[dof]}"
        figure = plots.response(title, list(curves(found, output, dof)), unit(output, dof), found.settings.confidence)
        yield Picture(f"transmissibility-{dof}", section, figure)


def curves(found: Comparison, output: str, source: str) -> Iterator[Response]:
    """One element of the matrix: linear and measured, of each variant."""
    color = colors(found.variants)
    for variant in found.variants:
        one = variant.linear
        values = one.response[:, one.outputs.index(output), one.inputs.index(source)]
        yield Response(f"{variant.name}, linear", one.frequency, values, color[variant.name])
    for variant in found.variants:
        for measured in variant.measured:
            if output in measured.outputs and source in measured.inputs:
                e, i, j = measured.estimate, measured.outputs.index(output), measured.inputs.index(source)
                yield Response(
                    f"{variant.name}, measured",
                    e.frequency,
                    e.response[:, i, j],
                    color[variant.name],
                    e.radius[:, i, j],
                    e.multiple[:, i],
                    e.ordinary[:, i, j],
                )


def matrix(found: Comparison, section: str = "matrix") -> Iterator[Picture]:
    """All magnitudes as one figure; rotations count as motion at the mounts' mean distance, so that all are m/m."""
    if len(found.settings.dofs) < 2:
        return
    linear = found.variants[0].linear
    turn = {dof: found.length if dof.startswith("r") else 1.0 for dof in NAMES}
    panels = {}
    for output in linear.outputs:
        row = output.split(" ")[-1]
        sizes = [
            max(np.abs(curve.response).max() for curve in curves(found, output, dof) if not curve.measured) / turn[dof]
            for dof in linear.inputs
        ]
        for dof, size in zip(linear.inputs, sizes, strict=True):
            if size > ZERO * max(sizes):
                factor = turn[row] / turn[dof]
                panels[row, dof] = [scaled(curve, factor) for curve in curves(found, output, dof)]
    rows = [output.split(" ")[-1] for output in linear.outputs]
    figure = plots.response_matrix("Floor to machine, every direction", rows, linear.inputs, panels, MATRIX_UNIT)
    caption = f"Rotations count as motion at {found.length:.3g} m, the mounts' mean distance. 0: zero by symmetry."
    yield Picture("transmissibility-matrix", section, figure, caption, wide=True)


def scaled(curve: Response, factor: float) -> Response:
    """The curve times a factor."""
    radius = None if curve.radius is None else factor * curve.radius
    return Response(
        curve.label, curve.frequency, factor * curve.response, curve.color, radius, curve.multiple, curve.ordinary
    )


def attenuation_tables(found: Comparison) -> Iterator[Table]:
    """Attenuation per third-octave, a table per degree of freedom."""
    columns: dict[str, dict[str, Sequence[float]]] = {}
    for variant, kind, dof, levels in found.attenuation():
        columns.setdefault(dof, {})[f"{variant}, {kind}"] = levels.tolist()
    for dof, parts in columns.items():
        rows = [
            [band.name, *(decibel(None if np.isnan(part[k]) else part[k]) for part in parts.values())]
            for k, band in enumerate(found.chosen)
        ]
        yield Table(f"Attenuation per third-octave [dB], {NAMES[dof]}", ["band [Hz]", *parts], rows)


def agreement_table(found: Comparison) -> Iterator[Table]:
    """Largest deviation of measured from linear, per variant and output."""
    agreement = found.agreement()
    if agreement:
        heads = [f"{name}, of {what}" for name in agreement for what in ("linear", "the floor")]
        rows = [
            [output, *(percent(value) for part in agreement.values() for value in part[output].values())]
            for output in found.outputs
        ]
        note = (
            "Largest |measured − linear| of a row's elements where the multiple coherence is above "
            f"{exact(COHERENT)}: over |linear| (of elements that are zero by symmetry, over the row's largest), and "
            "over the floor's motion. The linear response is that of vanishing motion; what a control has made small "
            "shows the valves' nonlinearity all the more."
        )
        yield Table("Measured against linear [%]", ["machine", *heads], rows, note)


def percent(value: float | None) -> str:
    """A share in per cent."""
    return number(None if value is None else 100.0 * value, 2)
