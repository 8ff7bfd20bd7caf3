"""What a run records, and what a law may read: variables and channels by name, with their units."""

from typing import Final

from ehamj.control.channels import SPOOLS, UPSTREAM, channel_names
from ehamj.variables import ALWAYS, DIMENSIONS, VARIABLES

OTHERS: Final = {
    "machine_acceleration": ("m/s^2 (rx, ry, rz: rad/s^2)", "acceleration of the mount plane's centre"),
    "load_pressure": ("Pa", "pressure of chamber 1 over that of chamber 2"),
    SPOOLS[0]: ("mA", "position of the valve's metering edges, which hysteresis parts from the spool"),
    SPOOLS[1]: ("mA", "position of the spool's driven end"),
}
"""Channels that are no variables of a result, or say something else there: unit, and what they are."""


def history_pages() -> dict[str, str]:
    """Markdown by path within the site."""
    return {"reference/results/histories.md": _histories(), "reference/results/channels.md": _channels()}


def _histories() -> str:
    rows = [
        f"| `{name}` | {', '.join(f'`{one}`' for one in ('time', *along))} | {unit} | {text} "
        f"| {'' if name in ALWAYS else 'where there is any'} |"
        for name, (along, unit, text) in VARIABLES.items()
    ]
    labels = [f"| `{name}` | {text} |" for name, text in DIMENSIONS.items()]
    return "\n".join(
        [
            "# Histories\n",
            "`result.nc` holds these variables (NetCDF-4; `ehamj.load_result(folder).dataset` is an `xarray.Dataset`). "
            "All are SI, spools in mA and commands in V. Pressures are absolute. Displacements count from unloaded "
            "membranes and the ground at rest.\n",
            "| variable | along | unit | what it is | |",
            "|---|---|---|---|---|",
            *rows,
            "",
            "## Dimensions\n",
            "| dimension | what lies along it |",
            "|---|---|",
            "| `time` | rows, `record_rate` of them a second [s] |",
            *labels,
            "",
        ]
    )


def _channels() -> str:
    found: dict[tuple[str, str], list[str]] = {}
    for name in channel_names(("MOUNT",)):
        variable, *labels = name.split(" ")
        where = labels[0] if labels[:1] in (["MOUNT"], [UPSTREAM]) else ""
        found.setdefault((variable, where), []).append(" ".join(labels[1 if where else 0 :]))
    rows = []
    for (variable, where), lasts in found.items():
        unit, text = OTHERS.get(variable) or VARIABLES[variable][1:]
        written = " ".join(filter(None, (variable, where)))
        last = ", ".join(f"`{one}`" for one in lasts if one)
        rows.append(f"| `{written}` | {last} | {unit} | {text} |")
    return "\n".join(
        [
            "# Channels\n",
            "What a law may read, by name: the variable, the mount's name in place of MOUNT, and the last word, as in "
            "`foot_velocity front-left z` or `stroke rear-right`. `along` is the component in the mount's own "
            f"direction, `{UPSTREAM}` the sensor in the floor that a wave reaches before the machine. Laws command "
            "`valve_command MOUNT` [V].\n",
            "`ehamj.control.channels.channel_names(mounts)` lists them for a machine.\n",
            "| channel | last word | unit | what it is |",
            "|---|---|---|---|",
            *rows,
            "",
        ]
    )
