"""Soft passive mounts as the baseline: how well they isolate, and when a tall machine tips over on them.

Gravity works against the mounts: a tilt φ about the mount plane moves the centre of gravity sideways by h φ, and the
weight turns the machine with m g h φ. The mounts turn it back with Σ k y² φ. What stands must have Σ k y² > m g h, with
the static stiffness k: oil or gas that can leak around the piston holds nothing in the long run.
"""

from collections.abc import Mapping
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
import xarray as xr
from numpy.typing import NDArray
from scipy.optimize import brentq

from ehamj.errors import InputError
from ehamj.isolator.actuator import Actuator
from ehamj.linear.loop import Loop
from ehamj.linear.machine import LinearModel, linear_model
from ehamj.linear.response import rigid_floor
from ehamj.mujoco import hydraulics
from ehamj.plant.axes import AXES
from ehamj.plant.plant import Plant
from ehamj.plots.charts import Line, lines_chart
from ehamj.run.simulate import simulate
from ehamj.scenario.model import Scenario
from ehamj.studies.outcome import Drawing, Outcome, Progress, labelled, silent
from ehamj.studies.tables import modes_table
from ehamj.studies.variants import changed, positions, preset, resized, still, with_every_actuator

if TYPE_CHECKING:
    from matplotlib.figure import Figure

Array = NDArray[np.float64]

MOUNTS_COMPARED = ("elastic-mount", "pneumatic-mount")
AXES_OF_TIPPING = ("about x", "about y")
NUDGE = 1e-6
"""Peak rate of the floor's tilt that starts the nonlinear run [rad/s]: it then moves by nanoradians and rests."""

MARGIN = 5e-3
"""Off the boundary by this much, nonlinear runs are made."""


@dataclass(frozen=True)
class SoftMountStudy:
    """Which machine, on which mounts.

    Raises:
        InputError: if a width is not positive, or there is no gravity.
    """

    scenario: Scenario
    presets: tuple[str, ...] = MOUNTS_COMPARED
    widths: tuple[float, ...] = (0.3, 0.4, 0.5, 0.6, 0.8, 1.0, 1.25, 1.5)
    """Factors on the mounts' places for which the tipping boundary is computed."""
    simulated: tuple[float, ...] = (0.5, 1.0)
    """Factors for which it is found by nonlinear simulation, too."""
    duration: float = 60.0
    """Simulated time of each run [s]."""

    def __post_init__(self) -> None:
        if self.scenario.gravity == 0.0:
            raise InputError("gravity = 0 m/s²: must be positive for this study, since nothing tips without it")
        for factor in (*self.widths, *self.simulated):
            if not 0.0 < factor < np.inf:
                raise InputError(f"widths: {factor!r} must be a positive, finite factor")


def static_stiffness(actuator: Actuator) -> float:
    """Vertical stiffness of a mount against a load that stays [N/m]: the membrane, and oil only where nothing leaks."""
    spring = actuator.membrane_stiffness + (actuator.hydraulic_stiffness if actuator.flow_pressure == 0.0 else 0.0)
    return spring if actuator.rigid_foot else spring * actuator.foot_stiffness / (spring + actuator.foot_stiffness)


def tipping_height(plant: Plant) -> tuple[float, float]:
    """CG height above the mount plane at which the machine tips, about x and about y [m]; the lower one decides.

    Closed form Σ k y²/(m g) and Σ k x²/(m g), about the mounts' elastic centre; for a layout that is not symmetric,
    the two principal values of Σ k r rᵀ.
    """
    k = np.array([static_stiffness(actuator) for actuator in plant.actuators])
    r = np.array(plant.positions)
    centred = r - k @ r / k.sum()
    restoring = np.einsum("m,mi,mj->ij", k, centred, centred)
    values, vectors = np.linalg.eigh(restoring)
    about_x = int(np.argmax(np.abs(vectors[1])))
    weight = plant.machine.mass * plant.gravity
    return float(values[about_x] / weight), float(values[1 - about_x] / weight)


def tall(scenario: Scenario, actuator: Actuator, height: float, width: float = 1.0) -> Scenario:
    """The bare machine on these mounts, its CG at ``height`` [m] and its mounts' places multiplied by ``width``.

    The CG stands over the middle of the mounts: one beside it has no upright rest near the boundary, it leans (`lean`).
    """
    places = width * positions(scenario)
    sized = resized(scenario, (*places.mean(axis=0), height), places)
    placed = still(scenario, **sized)
    return still(placed, plates="tied", **with_every_actuator(placed, actuator))


def lean(scenario: Scenario, actuator: Actuator) -> float:
    """Largest tilt at rest of the machine as it is on these mounts [rad], small angles; infinite where it tips over.

    A CG beside the middle by e turns it with m g e, against Σ k y² − m g h.
    """
    machine = scenario.machine
    offset = np.abs(np.array(machine.cg[:2]) - positions(scenario).mean(axis=0))[::-1]  # about x, about y
    heights = np.array(tipping_height(tall(scenario, actuator, machine.cg[2]).plant))
    if heights.min() <= machine.cg[2]:
        return float("inf")
    return float((offset / (heights - machine.cg[2])).max())


def growth(scenario: Scenario) -> float:
    """Largest real part of the machine's eigenvalues that is not rounding [1/s]; positive: it tips over."""
    values = np.linalg.eigvals(linear_model(scenario.plant).A)
    clear = values.real[np.abs(values) > 1e-9 * np.abs(values).max()]
    return float(clear.max())


def falls(scenario: Scenario, about: str, duration: float = 60.0) -> bool:
    """Whether the machine falls over in a nonlinear run that a tilt of the floor starts and then leaves to itself.

    It does if its tilt at the end is well beyond the largest of the first half; a machine that stands swings back.
    """
    dof = "rx" if about == "about x" else "ry"
    nudge = {"kind": "shock", "dof": dof, "velocity": NUDGE, "pulse_time": 0.05, "return_time": 0.2, "begin": 0.01}
    output = {"replay": False, "report": False}
    run = simulate(changed(scenario, ground=nudge, duration=duration, record_rate=200.0, output=output))
    tilt = np.abs(run.dataset["machine_displacement"].sel(dof=dof).values)
    return bool(tilt[-tilt.size // 10 :].max() > 1.5 * tilt[: tilt.size // 2].max())


def boundary(scenario: Scenario, actuator: Actuator, width: float) -> float:
    """CG height at which the machine tips [m] by the eigenvalues of the linear model, to 1e-5 of itself."""
    closed = min(tipping_height(tall(scenario, actuator, 1.0, width).plant))
    rate = lambda height: growth(tall(scenario, actuator, height, width))  # noqa: E731
    return float(brentq(rate, 0.9 * closed, 1.1 * closed, xtol=1e-5 * closed))


def soft_mounts(study: SoftMountStudy, progress: Progress = silent) -> Outcome:
    """Run the study.

    Raises:
        InputError: if a machine cannot stand on its mounts at all.
    """
    progress("tipping boundary")
    tipping = tipping_table(study)
    progress("transmissibility and modes")
    systems = compared_systems(study)
    return Outcome(
        title="Soft passive mounts",
        question="How well do passive mounts isolate this machine, and when does it tip over on them?",
        answers=_answers(study, tipping),
        tables={
            "tipping": tipping,
            "transmissibility": transmissibility_table(systems),
            "modes": modes_table({name: model for name, (model, _) in systems.items()}),
        },
        drawings={
            "tipping": Drawing(
                "CG height at which the machine tips, over half the distance of the mounts (the narrower direction). "
                "Squares: nonlinear runs of 60 s; filled ones fell over.",
                lambda: _tipping_chart(study, tipping),
            ),
            "heave": Drawing(
                "How much of a heaving floor reaches the centre of gravity; below 0 dB the machine is quieter.",
                lambda: _transmissibility_chart(systems, "z", "Floor to machine, vertical"),
            ),
            "sway": Drawing(
                "The same along x. The isolators act vertically, and reach sway only through its rocking part.",
                lambda: _transmissibility_chart(systems, "x", "Floor to machine, along x"),
            ),
        },
        notes=(
            "Transmissibility is that of the linear model: a floor that drives valves to their "
            "limits is isolated less (`ehamj run`).",
            "The presets elastic-mount (a spring of 5 Hz under 4 t) and pneumatic-mount (an air spring with damping "
            "chamber, 2 Hz) are assumed, typical values; levelling valves are not modelled.",
            "Static stiffness is the membrane's: oil or gas leaks around the piston and holds no load that stays.",
            "The boundary is that of a CG over the middle of the mounts; beside it the machine leans. "
            "Mass and inertia about the CG are kept while its height changes; height counts from the mount plane.",
        ),
        numbers={
            "tipping_height_m": {
                str(name): float(tipping["eigenvalue"].sel(mounts=name, width=1.0)) for name in tipping["mounts"].values
            }
        },
    )


def tipping_table(study: SoftMountStudy) -> xr.Dataset:
    """CG height at which the machine tips [m], over ``mounts`` and ``width``: closed form, eigenvalues, and runs.

    The runs stand 0.5 % below the eigenvalue's height and fall 0.5 % above; ``stands`` and ``falls`` are the heights at
    which they did, NaN where none was made or the run did otherwise.
    """
    widths = sorted({*study.widths, *study.simulated, 1.0})
    shape = (len(study.presets), len(widths))
    closed, eigen, stands, fell = (np.full(shape, np.nan) for _ in range(4))
    about = np.full(shape, "", dtype=object)
    runs = []
    for i, name in enumerate(study.presets):
        for j, width in enumerate(widths):
            actuator = preset(name)
            both = tipping_height(tall(study.scenario, actuator, 1.0, width).plant)
            closed[i, j], about[i, j] = min(both), AXES_OF_TIPPING[int(np.argmin(both))]
            eigen[i, j] = boundary(study.scenario, actuator, width)
            if width in study.simulated:
                runs += [(i, j, side * MARGIN) for side in (-1, 1)]

    def run(case: tuple[int, int, float]) -> bool:
        i, j, off = case
        scenario = tall(study.scenario, preset(study.presets[i]), (1.0 + off) * eigen[i, j], widths[j])
        return falls(scenario, about[i, j], study.duration)

    with hydraulics(), ThreadPoolExecutor() as pool:
        outcomes = list(pool.map(run, runs))
    for (i, j, off), down in zip(runs, outcomes, strict=True):
        if down == (off > 0):
            (fell if down else stands)[i, j] = (1.0 + off) * eigen[i, j]
    over = ("mounts", "width")
    half = 0.5 * np.ptp(positions(study.scenario), axis=0).min()
    return xr.Dataset(
        {
            "half_distance": labelled(("width",), half * np.array(widths), "m", "half distance of the mounts"),
            "about": labelled(over, about.astype(str), "", "direction in which it tips first"),
            "closed_form": labelled(over, closed, "m", "CG height, closed form Σ k y²/(m g)"),
            "eigenvalue": labelled(over, eigen, "m", "CG height, from eigenvalues"),
            "stands": labelled(over, stands, "m", "CG height at which a run stood"),
            "falls": labelled(over, fell, "m", "CG height at which a run fell over"),
        },
        {
            "mounts": labelled(("mounts",), list(study.presets), "", "mounts"),
            "width": labelled(("width",), widths, "1", "factor on the mounts' places"),
        },
        {"title": "CG height at which the machine tips over"},
    )


Systems = Mapping[str, tuple[LinearModel, Loop | None]]


def compared_systems(study: SoftMountStudy) -> Systems:
    """The machine on each kind of soft mount and on its own actuators: valves held, and under its control if any."""
    scenario = study.scenario
    found: dict[str, tuple[LinearModel, Loop | None]] = {}
    for name in study.presets:
        passive = still(scenario)
        found[name] = (linear_model(still(passive, **with_every_actuator(passive, preset(name))).plant), None)
    own = linear_model(scenario.plant)
    found["its own, valves held"] = (own, None)
    loop = Loop.of(scenario, scenario.controller())
    if loop is not None:
        found["its own, controlled"] = (own, loop)
    return found


def transmissibility_table(systems: Systems, hertz: Array | None = None) -> xr.Dataset:
    """CG motion over that of a rigid floor along x, y and z [-], over ``system``, ``axis`` and ``frequency``."""
    f = np.geomspace(0.3, 300.0, 301) if hertz is None else hertz
    outputs = tuple(f"cg_displacement {axis}" for axis in AXES)
    answers = [rigid_floor(model, f, loop, outputs, AXES).response for model, loop in systems.values()]
    values = np.array([np.abs(np.diagonal(answer, axis1=1, axis2=2)).T for answer in answers])
    return xr.Dataset(
        {"gain": labelled(("system", "axis", "frequency"), values, "1", "CG over floor")},
        {
            "system": labelled(("system",), list(systems), "", "mounts"),
            "axis": labelled(("axis",), list(AXES), "", "axis"),
            "frequency": labelled(("frequency",), f, "Hz", "frequency"),
        },
        {"title": "floor to machine"},
    )


def _answers(study: SoftMountStudy, tipping: xr.Dataset) -> tuple[str, ...]:
    height = study.scenario.machine.cg[2]
    one = tipping.sel(width=1.0)
    found = []
    for name in tipping["mounts"].values:
        limit, about = float(one["eigenvalue"].sel(mounts=name)), str(one["about"].sel(mounts=name).values)
        tilt = lean(study.scenario, preset(str(name)))
        leaning = f", leaning by {1e3 * tilt:.2g} mrad" if tilt > 1e-6 else ""
        state = f"stands{leaning}" if height < limit else "TIPS OVER"
        found.append(
            f"On {name}, the machine tips {about} with its CG above {limit:.2f} m; at {height:.2f} m it {state}."
        )
    half = float(one["half_distance"])
    rule = np.sqrt(study.scenario.gravity * height) / (2 * np.pi * half)
    found.append(
        f"As a rule, whatever the mass: mounts tip the machine when it heaves below √(g h)/(2π b) = {rule:.2f} Hz, "
        f"with CG height h = {height:.2f} m and half the mounts' distance b = {half:.2f} m."
    )
    done = int(np.isfinite(tipping["stands"]).sum()), int(np.isfinite(tipping["falls"]).sum())
    wanted = len(study.presets) * len(study.simulated)
    found.append(
        f"Nonlinear runs agree: {done[0]} of {wanted} stood {100 * MARGIN:g} % below the computed height, and "
        f"{done[1]} of {wanted} fell over {100 * MARGIN:g} % above."
    )
    return tuple(found)


def _tipping_chart(study: SoftMountStudy, tipping: xr.Dataset) -> "Figure":
    half = tipping["half_distance"].values
    lines = []
    for k, name in enumerate(tipping["mounts"].values):
        one = tipping.sel(mounts=name)
        lines.append(Line(f"{name}: tips above", half, one["closed_form"].values, color=k))
    for label, marker in (("stands", "s"), ("falls", "X")):
        both = np.concatenate([tipping[label].sel(mounts=name).values for name in tipping["mounts"].values])
        words = {"stands": "run stood (0.5 % below)", "falls": "run fell (0.5 % above)"}[label]
        lines.append(
            Line(words, np.tile(half, tipping.sizes["mounts"]), both, color=7 if marker == "s" else 1, marker=marker)
        )
    lines.append(
        Line(
            "this machine",
            [half[list(tipping["width"].values).index(1.0)]],
            [study.scenario.machine.cg[2]],
            2,
            marker="o",
        )
    )
    return lines_chart(
        "When it tips over", "half distance of the mounts [m]", {"CG height [m]": lines}, logarithmic="y"
    )


def _transmissibility_chart(systems: Systems, axis: str, title: str) -> "Figure":
    table = transmissibility_table(systems)["gain"].sel(axis=axis)
    f = table["frequency"].values
    lines = [
        Line(str(name), f, 20 * np.log10(table.sel(system=name).values), color=k, dash=k)
        for k, name in enumerate(table["system"].values)
    ]
    return lines_chart(
        title,
        "frequency [Hz]",
        {"CG over floor [dB]": lines},
        logarithmic="x",
        limits={"CG over floor [dB]": (-70.0, 30.0)},
    )
