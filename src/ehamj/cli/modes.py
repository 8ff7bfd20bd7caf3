"""The command that gives the machine's modes."""

import math
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Annotated, Any

import typer
import xarray as xr

from ehamj.cli.frame import Command, Json, ScenarioName, Set, app
from ehamj.cli.modal_tables import print_measured, print_modes, print_paired
from ehamj.cli.printing import print_json, say
from ehamj.cli.progress import doing
from ehamj.designs.sensitivity import sensitivities
from ehamj.errors import InputError, did_you_mean
from ehamj.findings import finite
from ehamj.folders import check_file
from ehamj.identification.modal.computed import computed_modes
from ehamj.identification.modal.files import modes_of_file
from ehamj.identification.modal.told import Pairing, pairing
from ehamj.linear.loop import Loop, linear_under
from ehamj.linear.modes import Mode
from ehamj.linear.modes import modes as modes_of
from ehamj.rig.modal_test import KINDS, ModalTest, check_test, kind_of, modal_test
from ehamj.scenario.load import load_scenario
from ehamj.scenario.model import Scenario

VARIANTS = {"modes": "valves held", "bypassed": "chambers bypassed, membranes only", "closed_loop": "closed loop"}
"""What modes are given of, by the key in the JSON object."""

SHORT = {"modes": "valves held", "closed_loop": "closed loop", "bypassed": "membranes only"}
"""What the replay calls them, in its order."""

Points = Annotated[
    list[str] | None,
    typer.Option("--point", metavar="NAME=X,Y,Z", help="A point beside the scenario's whose motion is given [m]."),
]
Measured = Annotated[
    str | None,
    typer.Option(
        metavar="KIND|FILE",
        help=f"Identify them from a simulated measurement too: {', '.join(KINDS)}; or a file of measured modes or "
        "responses.",
    ),
]
Noise = Annotated[float, typer.Option(help="Noise of the measurement's sensors, as a share of each signal's RMS.")]


@app.command(cls=Command)
def modes(
    scenario: ScenarioName = "recorded",
    overrides: Set = None,
    points: Points = None,
    sensitivity: Annotated[
        bool, typer.Option("--sensitivity", help="What each parameter does to each mode: d ln f/d ln p, dζ/d ln p.")
    ] = False,
    measured: Measured = None,
    noise: Noise = 0.0,
    replay: Annotated[
        Path | None, typer.Option(metavar="FILE.rrd", help="Also write the modes as an animated Rerun recording.")
    ] = None,
    overwrite: Annotated[bool, typer.Option("--overwrite", help="Replace an existing recording.")] = False,
    everything: Annotated[
        bool, typer.Option("--all", help="The controller's own poles too; with --measured, every other table too.")
    ] = False,
    as_json: Json = False,
) -> None:
    """Natural frequencies, damping and shapes of the machine: passive, and under the scenario's digital controller.

    Passive it is twice: with its valves held (membranes and oil), and with its chambers bypassed (membranes only).
    Frequencies are |λ|/2π, damping ratios −Re λ/|λ|; shapes are the motion of the mount plane's centre, its largest
    part one. A feedforward does not move modes, so its closed loop adds only the controller's own.

    `--measured` simulates a test of the machine with valves held and sets what is identified beside what is computed:
    `ring-down` jolts of the floor and free decays, `random` periodic noise and `sweep` a sine sweep of the floor,
    `hammer` blows on an upper corner of the machine. A FILE holds the modes of a real test: a table with a row per mode
    and columns `frequency [Hz]`, `damping [%]` and one per sensor, such as `foot_velocity front-left x`; TOML, or a
    universal file with mode shapes (dataset 55) or with responses of motions to forces (58), in which modes are found
    first. Each is paired with a computed one by the likeness of their shapes. That table stands alone unless `--all`
    asks for the others. The TOML may name another `file`, and say of it where `[nodes]` stood, which `band` counts.

    With `--replay` the modes are drawn exaggerated, the variants beside each other; open it with `rerun FILE.rrd`.
    """
    _check_test(measured, noise)
    if replay is not None:
        _check_recording(replay, overwrite)
    loaded = load_scenario(scenario, overrides or ())
    places = {**loaded.points, **_points(points or [], loaded.plant.mounts)}
    test, pairs = _measured(loaded, measured, noise)
    loops = _loops(loaded)
    found = {key: _modes_under(loaded, loop, bypassed, places) for key, (loop, bypassed) in loops.items()}
    if replay is not None:
        _draw(replay, loaded, found)
    slopes = _slopes(loaded, loops) if sensitivity else {}
    if as_json:
        print_json(_plain(found, slopes, test, pairs) | ({} if replay is None else {"replay": str(replay)}))
        return
    if (test is None and pairs is None) or everything or sensitivity or points:
        _print(loaded, found, everything, list(places), slopes)
    if test is not None:
        print_measured(f"{loaded.name}: computed, and found in signals, valves held", test)
    if pairs is not None:
        print_paired(f"{loaded.name}: measured, and computed with valves held", pairs)
    if replay is not None:
        say(f"modes, animated: {replay}  (open it with: rerun {replay})", whole=True)


def _print(
    scenario: Scenario,
    found: Mapping[str, Sequence[Mode]],
    everything: bool,
    places: list[str],
    slopes: Mapping[str, xr.Dataset],
) -> None:
    """A table per variant, what was assumed, and where slides stand."""
    for key, some in found.items():
        print_modes(f"{scenario.name}: {VARIANTS[key]}", some, everything, places, slopes.get(key))
    for said in scenario.machine.assumptions:
        say(said)
    for said in scenario.where_slides_stand:
        say(f"{said}; --set slide.NAME.start=… chooses another place")


def _draw(path: Path, scenario: Scenario, found: Mapping[str, Sequence[Mode]]) -> None:
    """Write the recording."""
    from ehamj.replay.modes import replay_modes

    with doing("drawing the modes"):
        replay_modes(path, scenario, {SHORT[key]: found[key] for key in SHORT if key in found})


def _loops(scenario: Scenario) -> dict[str, tuple[Loop | None, bool]]:
    """The loop of each variant, and whether its chambers are bypassed."""
    loop = Loop.of(scenario, scenario.controller())
    return {"modes": (None, False), "bypassed": (None, True)} | ({"closed_loop": (loop, False)} if loop else {})


def _modes_under(
    scenario: Scenario, loop: Loop | None, bypassed: bool, places: Mapping[str, tuple[float, float, float]]
) -> Sequence[Mode]:
    model = linear_under(scenario.plant, None if loop is None else loop.law)
    return modes_of(model, loop, bypassed, places)


def _check_test(measured: str | None, noise: float) -> None:
    """Raise InputError unless what is to be measured can be; called before anything is computed."""
    if measured is not None and _is_file(measured):
        if noise != 0.0:
            raise InputError(
                f"--noise {noise:g}: belongs to a simulated measurement, not to a file of modes; leave it out"
            )
    elif measured is not None and measured not in KINDS:
        near = did_you_mean(measured, KINDS)
        raise InputError(f"--measured {measured!r}: {near}must be one of {', '.join(KINDS)}, or a file of modes")
    elif measured is not None:
        check_test(measured, noise)
    elif noise != 0.0:
        raise InputError(f"--noise {noise:g}: belongs to a measurement; add --measured, one of {', '.join(KINDS)}")


def _numbers(text: str, count: int) -> list[float] | None:
    """So many finite numbers between commas; None where they are not."""
    try:
        found = [float(part) for part in text.split(",")]
    except ValueError:
        return None
    return found if len(found) == count and all(map(math.isfinite, found)) else None


def _measured(scenario: Scenario, measured: str | None, noise: float) -> tuple[ModalTest | None, Pairing | None]:
    """What a simulated test finds, or which of a file's modes is which of the model's."""
    if measured is None:
        return None, None
    if measured not in KINDS:
        with doing("finding modes in the file"):
            found = modes_of_file(Path(measured), scenario, {})
        return None, pairing(found, computed_modes(scenario))
    with doing(f"measuring: {measured}"):
        return modal_test(scenario, kind_of(measured), noise), None


def _slopes(scenario: Scenario, loops: Mapping[str, tuple[Loop | None, bool]]) -> dict[str, xr.Dataset]:
    """What each parameter does to the modes of each variant."""
    with doing("changing every parameter"):
        return {
            key: sensitivities(scenario, loop.law if loop else None, bypassed)
            for key, (loop, bypassed) in loops.items()
        }


def _is_file(measured: str) -> bool:
    """Whether what was measured is a file's: it is there, or ends as a file does."""
    return measured not in KINDS and (Path(measured).is_file() or bool(Path(measured).suffix))


def _check_recording(path: Path, overwrite: bool) -> None:
    """Raise InputError unless a recording may be written there; called before anything is computed."""
    if path.suffix != ".rrd":
        raise InputError(f"--replay {str(path)!r}: must end in .rrd")
    if path.exists() and not (overwrite and path.is_file()):
        raise InputError(f"--replay {str(path)!r}: exists already; name another file or add --overwrite")
    check_file(path, "--replay")


def _points(given: Sequence[str], mounts: Sequence[str]) -> dict[str, tuple[float, float, float]]:
    found: dict[str, tuple[float, float, float]] = {}
    for text in given:
        name, equals, place = text.partition("=")
        at = _numbers(place, 3)
        if not (name and equals) or at is None:
            raise InputError(f"--point {text!r}: must be a name and three numbers in m, such as spindle=0.2,0,1.4")
        if name in ("cg", *mounts):
            raise InputError(f"--point {text!r}: {name} is given anyway; choose another name")
        found[name] = (at[0], at[1], at[2])
    return found


def _plain(
    found: Mapping[str, Sequence[Mode]],
    slopes: Mapping[str, xr.Dataset],
    test: ModalTest | None,
    pairs: Pairing | None,
) -> dict[str, Any]:
    """What was found as plain data; slopes have one number per mode, in the modes' order, null where there is none."""
    content: dict[str, Any] = {key: [mode.to_dict() for mode in modes] for key, modes in found.items()}
    if slopes:
        content["sensitivity"] = {
            key: {
                str(one["parameter"].item()): {
                    "value": float(one["value"]),
                    "unit": one["unit"].item(),
                    **{name: [finite(value) for value in one[name].values] for name in ("frequency", "damping")},
                }
                for one in (some.isel(parameter=k) for k in range(some.sizes["parameter"]))
            }
            for key, some in slopes.items()
        }
    if pairs is not None:
        content["paired"] = pairs.to_dict()
    return content if test is None else {**content, "measured": test.to_dict()}
