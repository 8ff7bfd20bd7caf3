"""The page of a comparison: transmissibilities, linear and measured."""

from collections.abc import Iterator, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Final

import numpy as np

from ehamj import plots
from ehamj.linear.response import ZERO, Transfer, unit
from ehamj.pages import Page, Picture, Section, Table, write_page
from ehamj.pages.words import AXIS_NAMES, decibel, exact
from ehamj.plots import Response
from ehamj.rig.comparison import COHERENT, JUDGED, Comparison, own_output
from ehamj.rig.measurement import Measurement

MATRIX_UNIT: Final = "m/m"
UNKNOWN: Final = "left out where the confidence circle reaches zero"


def write_transmissibility(folder: Path, found: Comparison) -> None:
    """Write ``transmissibility.html``, one page without external parts, and its figures as ``figures/*.svg``."""
    write_page(folder, "transmissibility.html", comparison_page(found))


def comparison_page(found: Comparison) -> Page:
    """A comparison as a page."""
    point = {"cg": "the centre of gravity", "mounts": "the mount plane's centre"}[found.settings.reference]
    methods = list(dict.fromkeys(one.method for variant in found.variants for one in variant.measured))
    how = [
        f"Displacement of the machine (translation of {point}, rotation) over that of a rigid floor at the mount "
        "plane's centre. Linear: about the equilibrium, with the sampled control loop.",
        f"Measured in nonlinear runs: {'; '.join(methods)}; {UNKNOWN}.",
    ]
    meaning = (
        "Attenuation: positive is quieter than the floor, of a floor with the same velocity at every frequency of a "
        "band."
    )
    sections = [Section("responses", "Each direction by itself", list(elements(found)), notes=how)]
    if whole := list(matrix(found)):
        sections.append(Section("matrix", "Every direction", whole))
    tables = [*attenuation_tables(found), *agreement_table(found)]
    sections.append(Section("tables", "Numbers", tables=tables, notes=[meaning]))
    name = found.scenario.name
    return Page(f"{name}: transmissibility", f"{name}: floor to machine", found.scenario.description, sections)


def linear(label: str, found: Transfer, output: str, source: str, color: str) -> Response:
    """An element of a linear response."""
    values = found.response[:, found.outputs.index(output), found.inputs.index(source)]
    return Response(f"{label}, linear", found.frequency, values, color)


def measured(label: str, found: Measurement, output: str, source: str, color: str) -> Response:
    """An element of a measured response, with coherences and the radius of its confidence."""
    e, i, j = found.estimate, found.outputs.index(output), found.inputs.index(source)
    return Response(
        f"{label}, measured",
        e.frequency,
        e.response[:, i, j],
        color,
        e.radius[:, i, j],
        e.multiple[:, i],
        e.ordinary[:, i, j],
    )


def elements(found: Comparison) -> Iterator[Picture]:
    """A figure for each degree of freedom of the floor: the machine's own answer in it, linear and measured."""
    for dof in found.settings.dofs:
        output = own_output(found.outputs, dof)
        title = f"Floor to machine, {AXIS_NAMES[dof]}"
        figure = plots.response(title, list(curves(found, output, dof)), unit(output, dof), found.settings.confidence)
        yield Picture(f"transmissibility-{dof}", figure)


def curves(found: Comparison, output: str, source: str) -> Iterator[Response]:
    """One element of the matrix: linear and measured, of each variant."""
    color = plots.colors_of([variant.name for variant in found.variants], "passive")
    for variant in found.variants:
        yield linear(variant.name, variant.linear, output, source, color[variant.name])
    for variant in found.variants:
        for one in variant.measured:
            if output in one.outputs and source in one.inputs:
                yield measured(variant.name, one, output, source, color[variant.name])


def matrix(found: Comparison) -> Iterator[Picture]:
    """All magnitudes as one figure; rotations count as motion at the mounts' mean distance, so that all are m/m."""
    if len(found.settings.dofs) < 2:
        return
    linear = found.variants[0].linear
    turn = {dof: found.length if dof.startswith("r") else 1.0 for dof in AXIS_NAMES}
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
    yield Picture("transmissibility-matrix", figure, caption, wide=True)


def scaled(curve: Response, factor: float) -> Response:
    """The curve times a factor."""
    radius = None if curve.radius is None else factor * curve.radius
    return replace(curve, response=factor * curve.response, radius=radius)


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
        yield Table(f"Attenuation per third-octave [dB], {AXIS_NAMES[dof]}", ["band [Hz]", *parts], rows)


def agreement_table(found: Comparison) -> Iterator[Table]:
    """Largest deviation of measured from linear, per variant and output."""
    agreement = found.agreement()
    if agreement:
        heads = [f"{name}, {what}" for name in agreement for what in ("[dB]", "[°]", "of the floor [dB]")]
        rows = [
            [output, *(cell for part in agreement.values() for cell in map(decibel, part[output][:3]))]
            for output in found.outputs
        ]
        note = (
            "Largest deviation of magnitude and phase where the multiple coherence is above "
            f"{exact(COHERENT)}, of elements above {exact(100.0 * JUDGED)} % of their row's largest; and the largest "
            "|measured − linear| of any element over the floor's motion. The linear response is that of vanishing "
            "motion; what a control has made small shows the valves' nonlinearity all the more."
        )
        yield Table("Measured against linear", ["machine", *heads], rows, note)
