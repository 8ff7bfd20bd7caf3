"""One actuator failed: what still carries the machine, how it then moves, and how well the others isolate.

The law keeps driving all four valves as if nothing had happened: it is the law of the sound machine.
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from ehamj.errors import InputError
from ehamj.isolator.actuator import Actuator
from ehamj.linear.loop import Loop
from ehamj.linear.machine import LinearModel, linear_model
from ehamj.linear.response import rigid_floor
from ehamj.plant.mounts import MOUNTS, N_MOUNTS
from ehamj.plots.charts import Line, lines_chart
from ehamj.run.simulate import simulate
from ehamj.scenario.model import Scenario
from ehamj.studies.outcome import Drawing, Outcome, Progress, labelled, silent
from ehamj.studies.tables import modes_table
from ehamj.studies.variants import changed, still, with_actuators

if TYPE_CHECKING:
    from matplotlib.figure import Figure

Array = NDArray[np.float64]
ComplexArray = NDArray[np.complex128]

NEGLIGIBLE_GAIN = 1e-9
"""Gain of a valve that no longer moves [mA/V]."""
NEGLIGIBLE_AREA = 1e-6
"""Area of a piston without oil [m²]: 7 N at full pressure."""
LEAK: Final = 100.0
"""By which a worn piston seal multiplies the flow-pressure coefficient; the edges' leakage stays."""
STUCK: Final = 0.05
"""Opening of a valve that stuck while it worked, over full stroke [-]."""


def stuck(share: float) -> Callable[[Actuator], Actuator]:
    """The valve's spool stays at a share of its stroke whatever the command."""
    return lambda actuator: actuator.with_values(
        {"valve_gain": NEGLIGIBLE_GAIN, "null_offset": share * actuator.spool_stroke}
    )


def leaking(actuator: Actuator) -> Actuator:
    """Oil passes the piston `LEAK` times as easily as in all; the edges' own leakage stays."""
    return actuator.with_values(
        {
            "flow_pressure": LEAK * actuator.flow_pressure,
            "edge_leakage_share": actuator.edge_leakage_share / LEAK,
        }
    )


def membrane_only(actuator: Actuator) -> Actuator:
    """The oil is lost: only the membrane carries."""
    return actuator.with_values({"piston_area": NEGLIGIBLE_AREA})


FAILURES: Final[dict[str, Callable[[Actuator], Actuator]]] = {
    "valve stuck centred": stuck(0.0),
    f"valve stuck {100 * STUCK:.0f} % open": stuck(STUCK),
    "valve stuck fully open": stuck(0.999),
    "piston leaks": leaking,
    "membrane only": membrane_only,
}


@dataclass(frozen=True)
class FailedStudy:
    """Which mount fails, and what is looked at.

    Raises:
        InputError: if there is no such mount.
    """

    scenario: Scenario
    mount: str = "front-left"
    failures: tuple[str, ...] = tuple(FAILURES)
    """Which of `FAILURES`."""
    lines: tuple[float, ...] = (2.0, 5.0, 10.0, 20.0, 50.0, 100.0)
    """Frequencies of the heaving floor in the runs, whole numbers [Hz]."""
    velocity: float = 1e-6
    """RMS velocity of each line [m/s]: far from the valves' limits, and far above the steps of their commands."""

    def __post_init__(self) -> None:
        if self.mount not in MOUNTS:
            raise InputError(f"mount = {self.mount!r}: must be one of {', '.join(MOUNTS)}")
        for name in self.failures:
            if name not in FAILURES:
                raise InputError(f"failures: {name!r} must be one of {', '.join(FAILURES)}")


def failed(study: FailedStudy, failure: str) -> Scenario:
    """The machine with one actuator failed; ``sound`` is the machine as it is.

    Raises:
        InputError: if there is no such failure.
    """
    if failure == "sound":
        return study.scenario
    if failure not in FAILURES:
        raise InputError(f"failure = {failure!r}: must be one of sound, {', '.join(FAILURES)}")
    own = study.scenario.plant.actuators[MOUNTS.index(study.mount)]
    return changed(study.scenario, **with_actuators(study.scenario, {study.mount: FAILURES[failure](own)}))


def static_forces(model: LinearModel) -> dict[str, Array]:
    """What mounts carry at rest: ``stroke`` [m], ``oil`` and ``membrane``, forces on the plate, up [N], (mount,)."""
    plant, state = model.plant, model.equilibrium
    stroke = np.array([_stroke(model, mount) for mount in range(N_MOUNTS)])
    pressure = np.array([[state[_at(model, f"pressure_{k} {mount}")] for k in (1, 2)] for mount in MOUNTS])
    area = np.array([[a.piston_area, a.piston_area * a.area_ratio] for a in plant.actuators])
    stiffness = np.array([actuator.membrane_stiffness for actuator in plant.actuators])
    return {"stroke": stroke, "oil": (pressure * area) @ [1.0, -1.0], "membrane": -stiffness * stroke}


def _at(model: LinearModel, state: str) -> int:
    return model.states.index(state)


def _stroke(model: LinearModel, mount: int) -> float:
    plate = f"displacement plate {MOUNTS[mount]}"
    if plate in model.states:
        return float(model.equilibrium[_at(model, plate)])
    x, y = model.plant.positions[mount]
    z, rx, ry = (model.equilibrium[_at(model, f"displacement {joint}")] for joint in ("z", "rx", "ry"))
    return float(z + y * rx - x * ry)


OUTPUTS: Final = ("cg_displacement z", "machine_displacement rx", "machine_displacement ry")


def residual(model: LinearModel, loop: Loop | None, hertz: Array) -> ComplexArray:
    """CG heave [-] and rotations [rad/m] over a heaving floor, (frequency, 3), linear."""
    return rigid_floor(model, hertz, loop, OUTPUTS, ("z",)).response[:, :, 0]


def simulated_residual(study: FailedStudy, scenario: Scenario, loop: Loop | None) -> ComplexArray:
    """As `residual`, at the study's lines, from a nonlinear run of 5 s of which the last is evaluated."""
    f = np.array(study.lines)
    phases = -np.pi * np.arange(f.size) * (np.arange(f.size) + 1) / f.size
    ground = {"kind": "multisine", "dof": "z", "frequencies": f.tolist(), "velocities": (study.velocity,)}
    ground |= {"phases": phases.tolist(), "fade_in": 1.0}
    law = None if loop is None else loop.law
    run = simulate(still(scenario, ground=ground, duration=5.0, record_rate=2000.0), controller=law)
    part = run.dataset.sel(time=slice(4.0 + 1e-9, None))
    time = part["time"].values
    signals = [part["cg_displacement"].sel(axis="z"), *(part["machine_displacement"].sel(dof=d) for d in ("rx", "ry"))]
    columns = np.column_stack([np.ones_like(time), time, *_waves(time, f)])  # a mean and a drift beside the lines
    fitted = np.linalg.lstsq(columns, np.column_stack([signal.values for signal in signals]), rcond=None)[0][2:]
    answer = fitted[0::2] - 1j * fitted[1::2]
    floor = np.sqrt(2.0) * study.velocity / (2 * np.pi * f) * np.exp(1j * (phases - np.pi / 2))
    return np.asarray(answer / floor[:, None])


def _waves(time: Array, hertz: Array) -> list[Array]:
    return [wave(2 * np.pi * f * time) for f in hertz for wave in (np.cos, np.sin)]


def simulated_event(study: FailedStudy, share: float, duration: float = 1.5) -> dict[str, Array]:
    """What each mount carries after a valve of the sound machine ran to a share of its stroke and stayed there.

    As `static_forces`, from a nonlinear run that begins at the sound machine's equilibrium.
    """
    own = study.scenario.plant.actuators[MOUNTS.index(study.mount)]
    step = {"kind": "step", "mounts": (study.mount,), "amplitude": share * own.spool_stroke / own.valve_gain}
    control = {"kind": "open-loop", "signals": (step | {"start": 0.05},)}
    run = simulate(still(study.scenario, control=control, duration=duration)).dataset.isel(time=-1)
    stiffness = np.array([actuator.membrane_stiffness for actuator in study.scenario.plant.actuators])
    stroke = run["stroke"].values
    return {"stroke": stroke, "oil": run["actuator_force"].values, "membrane": -stiffness * stroke}


def failed_actuator(study: FailedStudy, progress: Progress = silent) -> Outcome:
    """Run the study.

    Raises:
        InputError: if a machine with a failed actuator has no operating point.
    """
    loop = Loop.of(study.scenario, study.scenario.controller())
    cases = ("sound", *study.failures)
    models, answers = {}, {}
    for case in cases:
        progress(f"{case}: linear model and run")
        scenario = failed(study, case)
        models[case] = linear_model(scenario.plant)
        answers[case] = (
            residual(models[case], loop, np.array(study.lines)),
            simulated_residual(study, scenario, loop),
        )
    progress("a valve runs away")
    static = static_forces(linear_model(failed(study, f"valve stuck {100 * STUCK:.0f} % open").plant))
    event = simulated_event(study, STUCK)
    off = max(float(np.abs(static[part] - event[part]).max()) for part in ("oil", "membrane"))
    forces = _forces_table(models)
    isolation = _isolation_table(study, answers)
    curves = _curves_table(models, loop)
    largest = float(isolation["difference"].max())
    return Outcome(
        title="One actuator failed",
        question=f"What does the machine do when the actuator at {study.mount} fails and the others go on?",
        answers=(
            *_failure_answers(study, isolation, forces),
            f"Nonlinear runs agree with the linear residuals within {largest:.1g} of the floor's motion.",
            f"A run in which the valve of the sound machine opens to {100 * STUCK:.0f} % and stays ends with the "
            f"forces computed for it, to {off:.2g} N.",
        ),
        tables={"isolation": isolation, "forces": forces, "modes": modes_table(models), "curves": curves},
        drawings={
            "heave": Drawing(
                "Heaving floor to the CG's heave with one actuator failed; circles: nonlinear runs.",
                lambda: _failed_chart(curves, isolation, "heave", "CG over floor [dB]"),
            ),
            "rocking": Drawing(
                "Rotation that the same floor causes, since the failed corner still follows it.",
                lambda: _failed_chart(curves, isolation, "rotation", "rotation over floor [dB re 1 rad/m]"),
            ),
        },
        notes=(
            "The law is that of the sound machine and drives all valves; without a law valves are held.",
            f"piston leaks: {LEAK:g} times the flow-pressure coefficient, across the piston. membrane only: no oil in "
            "the cylinder. A stuck valve keeps its opening whatever the command.",
            "Negative membrane forces pull: the feet must be bolted.",
        ),
        numbers={"largest_difference": largest, "force_difference_n": off},
    )


def _isolation_table(study: FailedStudy, answers: "dict[str, tuple[ComplexArray, ComplexArray]]") -> xr.Dataset:
    linear, simulated = (np.array([pair[k] for pair in answers.values()]) for k in range(2))
    over = ("case", "frequency")
    turn = [np.hypot(np.abs(part[..., 1]), np.abs(part[..., 2])) for part in (linear, simulated)]
    heave = [np.abs(part[..., 0]) for part in (linear, simulated)]
    return xr.Dataset(
        {
            "heave": labelled(over, heave[0], "1", "CG heave over floor, linear"),
            "heave_simulated": labelled(over, heave[1], "1", "CG heave over floor, nonlinear run"),
            "rotation": labelled(over, turn[0], "rad/m", "rotation over floor, linear"),
            "rotation_simulated": labelled(over, turn[1], "rad/m", "rotation over floor, nonlinear run"),
            "difference": labelled(
                over, np.abs(simulated - linear)[..., 0], "1", "run less linear, CG heave over floor, complex"
            ),
        },
        {
            "case": labelled(("case",), list(answers), "", "actuator"),
            "frequency": labelled(("frequency",), list(study.lines), "Hz", "frequency"),
        },
        {"title": f"residual of a heaving floor, failure at {study.mount}"},
    )


def _curves_table(models: dict[str, LinearModel], loop: Loop | None) -> xr.Dataset:
    f = np.geomspace(0.5, 300.0, 201)
    values = np.array([residual(model, loop, f) for model in models.values()])
    over = ("case", "frequency")
    return xr.Dataset(
        {
            "heave": labelled(over, np.abs(values[..., 0]), "1", "CG heave over floor"),
            "rotation": labelled(over, np.linalg.norm(values[..., 1:], axis=-1), "rad/m", "rotation over floor"),
        },
        {
            "case": labelled(("case",), list(models), "", "actuator"),
            "frequency": labelled(("frequency",), f, "Hz", "frequency"),
        },
        {"title": "residual of a heaving floor over frequency, linear"},
    )


def _forces_table(models: dict[str, LinearModel]) -> xr.Dataset:
    found = [static_forces(model) for model in models.values()]
    over = ("case", "mount")
    return xr.Dataset(
        {
            "stroke": labelled(over, np.array([one["stroke"] for one in found]), "m", "stroke at rest"),
            "oil": labelled(over, np.array([one["oil"] for one in found]), "N", "force of the oil at rest, up"),
            "membrane": labelled(
                over, np.array([one["membrane"] for one in found]), "N", "force of the membrane at rest, up"
            ),
        },
        {
            "case": labelled(("case",), list(models), "", "actuator"),
            "mount": labelled(("mount",), list(MOUNTS), "", "mount"),
        },
        {"title": "what carries the machine at rest"},
    )


def _failure_answers(study: FailedStudy, isolation: xr.Dataset, forces: xr.Dataset) -> list[str]:
    at = min(study.lines, key=lambda f: abs(np.log(f / 10.0)))
    one = isolation.sel(frequency=at)
    found = []
    for case in isolation["case"].values:
        heave, turn = float(one["heave"].sel(case=case)), float(one["rotation"].sel(case=case))
        carried = forces["membrane"].sel(case=case) + forces["oil"].sel(case=case)
        words = f"{case.capitalize()}: a heaving floor of {at:g} Hz reaches the CG with {20 * np.log10(heave):.0f} dB"
        words += f" and turns the machine by {turn:.2g} rad per m" if turn > 1e-6 else " and does not turn the machine"
        if case != "sound":
            low, high = float(carried.min()), float(carried.max())
            spread = f"{1e-3 * low:.1f} to {1e-3 * high:.1f}" if high - low > 1.0 else f"{1e-3 * low:.1f}"
            words += f"; at rest each mount carries {spread} kN"
            oil = float(forces["oil"].sel(case=case, mount=study.mount))
            words += f", the oil there {1e-3 * oil:.1f} kN" if abs(oil) > 1.0 else ""
        found.append(words.replace(" -", " −") + ".")
    return found


def _failed_chart(curves: xr.Dataset, isolation: xr.Dataset, what: str, label: str) -> "Figure":
    f, dots = curves["frequency"].values, isolation["frequency"].values
    lines = []
    for k, case in enumerate(curves["case"].values):
        lines.append(Line(str(case), f, 20 * np.log10(np.maximum(curves[what].sel(case=case).values, 1e-6)), k, k))
    for k, case in enumerate(isolation["case"].values):
        values = np.maximum(isolation[f"{what}_simulated"].sel(case=case).values, 1e-6)
        lines.append(Line("" if k else "nonlinear run", dots, 20 * np.log10(values), k, marker="o"))
    title = {"heave": "Heaving floor to the CG", "rotation": "Heaving floor to rotation"}[what]
    return lines_chart(title, "frequency [Hz]", {label: lines}, logarithmic="x", limits={label: (-80.0, 20.0)})
