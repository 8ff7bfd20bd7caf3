"""The command that gives the machine's modes."""

import math
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Annotated, Any

import typer
import xarray as xr

from ehamj.cli.frame import JsonOption, ScenarioArgument, SetOption, app, log, print_json, say
from ehamj.cli.modal_tables import print_measured, print_modes
from ehamj.designs.sensitivity import sensitivities
from ehamj.errors import InputError
from ehamj.findings import finite
from ehamj.linear.loop import Loop
from ehamj.linear.machine import linear_model
from ehamj.linear.modes import Mode
from ehamj.linear.modes import modes as modes_of
from ehamj.rig.modal_test import KINDS, ModalTest, kind_of, modal_test
from ehamj.scenario.load import load_scenario

VARIANTS = {"modes": "valves held", "bypassed": "chambers bypassed, membranes only", "closed_loop": "closed loop"}
"""What modes are given of, by the key in the JSON object."""

SHORT = {"modes": "valves held", "closed_loop": "closed loop", "bypassed": "membranes only"}
"""What the replay calls them, in its order."""

PointsOption = Annotated[
    list[str] | None,
    typer.Option("--point", metavar="NAME=X,Y,Z", help="A point beside the scenario's whose motion is given [m]."),
]
SensitivityOption = Annotated[
    bool, typer.Option("--sensitivity", help="What each parameter does to each mode: d ln f/d ln p, dζ/d ln p.")
]
MeasuredOption = Annotated[
    str | None,
    typer.Option(
        "--measured", metavar="KIND", help=f"Identify them from a simulated measurement too: {', '.join(KINDS)}."
    ),
]
NoiseOption = Annotated[
    float, typer.Option("--noise", help="Noise of the measurement's sensors, as a share of each signal's RMS.")
]
ReplayOption = Annotated[
    Path | None,
    typer.Option("--replay", metavar="FILE.rrd", help="Also write the modes as an animated Rerun recording."),
]


@app.command()
def modes(
    scenario: ScenarioArgument = "recorded",
    overrides: SetOption = None,
    points: PointsOption = None,
    sensitivity: SensitivityOption = False,
    measured: MeasuredOption = None,
    noise: NoiseOption = 0.0,
    replay: ReplayOption = None,
    overwrite: Annotated[bool, typer.Option("--overwrite", help="Replace an existing recording.")] = False,
    as_json: JsonOption = False,
) -> None:
    """Natural frequencies, damping and shapes of the machine: passive, and under the scenario's digital controller.

    Passive it is twice: with its valves held (membranes and oil), and with its chambers bypassed (membranes only).
    Frequencies are |λ|/2π, damping ratios −Re λ/|λ|; shapes are the motion of the mount plane's centre, its largest
    part one. A feedforward does not move modes, so its closed loop adds only the controller's own.

    `--measured` simulates a test of the machine with valves held and sets what is identified beside what is computed:
    `ring-down` jolts of the floor and free decays, `random` periodic noise and `sweep` a sine sweep of the floor,
    `hammer` blows on an upper corner of the machine.

    With `--replay` the modes are drawn exaggerated, the variants beside each other; open it with `rerun FILE.rrd`.
    """
    if noise != 0.0 and measured is None:
        raise InputError(f"--noise {noise:g}: belongs to a measurement; add --measured, one of {', '.join(KINDS)}")
    if replay is not None:
        _check_recording(replay, overwrite)
    loaded = load_scenario(scenario, overrides or ())
    places = {**loaded.points, **_points(points or [], loaded.plant.mounts)}
    model, loop = linear_model(loaded.plant), Loop.of(loaded, loaded.controller())
    settings: dict[str, tuple[Loop | None, bool]] = {"modes": (None, False), "bypassed": (None, True)} | (
        {"closed_loop": (loop, False)} if loop else {}
    )
    found = {key: modes_of(model, one, bypassed, places) for key, (one, bypassed) in settings.items()}
    test, slopes = None, {}
    if measured is not None:
        with log.status(f"measuring: {measured}"):
            test = modal_test(loaded, kind_of(measured), noise)
    if replay is not None:
        from ehamj.replay.modes import replay_modes

        with log.status("drawing"):
            replay_modes(replay, loaded, {SHORT[key]: found[key] for key in SHORT if key in found})
    if sensitivity:
        with log.status("changing every parameter"):
            slopes = {
                key: sensitivities(loaded, one.law if one else None, bypassed)
                for key, (one, bypassed) in settings.items()
            }
    if as_json:
        print_json(_plain(found, slopes, test) | ({} if replay is None else {"replay": str(replay)}))
        return
    for key, some in found.items():
        print_modes(f"{loaded.name}: {VARIANTS[key]}", some, key != "bypassed", list(places), slopes.get(key))
    if test is not None:
        print_measured(f"{loaded.name}: identified from signals, valves held", test)
    if replay is not None:
        say(f"modes, animated: {replay}  (open it with: rerun {replay})")


def _check_recording(path: Path, overwrite: bool) -> None:
    """Raise InputError unless a recording may be written there; called before anything is computed."""
    if path.suffix != ".rrd":
        raise InputError(f"--replay {str(path)!r}: must end in .rrd")
    if path.exists() and not (overwrite and path.is_file()):
        raise InputError(f"--replay {str(path)!r}: exists already; name another file or add --overwrite")
    if not path.absolute().parent.is_dir():
        raise InputError(f"--replay {str(path)!r}: {str(path.parent)!r} is no folder")


def _points(given: Sequence[str], mounts: Sequence[str]) -> dict[str, tuple[float, float, float]]:
    found: dict[str, tuple[float, float, float]] = {}
    for text in given:
        name, equals, place = text.partition("=")
        try:
            x, y, z = (float(part) for part in place.split(","))
        except ValueError:
            x = y = z = math.nan
        if not (name and equals and all(map(math.isfinite, (x, y, z)))):
            raise InputError(f"--point {text!r}: must be a name and three numbers in m, such as spindle=0.2,0,1.4")
        if name in ("cg", *mounts):
            raise InputError(f"--point {text!r}: {name} is given anyway; choose another name")
        found[name] = (x, y, z)
    return found


def _plain(
    found: Mapping[str, Sequence[Mode]], slopes: Mapping[str, xr.Dataset], test: ModalTest | None
) -> dict[str, Any]:
    """What was found as plain data."""
    return {
        **{key: [mode.to_dict() for mode in modes] for key, modes in found.items()},
        **({"sensitivity": {key: _plain_slopes(one) for key, one in slopes.items()}} if slopes else {}),
        **({} if test is None else {"measured": test.to_dict()}),
    }


def _plain_slopes(slopes: xr.Dataset) -> dict[str, Any]:
    """d ln f/d ln p and dζ/d ln p by parameter, one number per mode in the modes' order; null where there is none."""
    return {
        str(key): {
            "value": float(slopes["value"].sel(parameter=key)),
            "unit": slopes["unit"].sel(parameter=key).item(),
            "frequency": [finite(value) for value in slopes["frequency"].sel(parameter=key).values],
            "damping": [finite(value) for value in slopes["damping"].sel(parameter=key).values],
        }
        for key in slopes["parameter"].values
    }
