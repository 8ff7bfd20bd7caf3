"""Channels that may be measured: their units, what of a file may be one, and what they are to a model."""

from typing import Final, NamedTuple

from ehamj.control.channels import UPSTREAM, check_channel, valve_commands
from ehamj.control.units import plain_unit, signal_units
from ehamj.errors import InputError, did_you_mean
from ehamj.measured.measured import Role
from ehamj.records.units import Kind, unit

FORCE: Final = "force"
"""First word of the name of a measured force."""
FELT: Final = "acceleration"
"""The same of an accelerometer at a point."""


class ChannelUnit(NamedTuple):
    """A channel's unit in ehamj, what it is of, and its SI value."""

    text: str
    kind: Kind
    size: float


def unit_of(channel: str) -> ChannelUnit:
    """Of a channel, a valve's command or a force: SI, and mA of a spool."""
    own = {FORCE: "N", FELT: "m/s²"}.get(channel.split(" ")[0])
    text = own or signal_units((channel,))[0]
    found = unit(plain_unit(text))
    return ChannelUnit(text, found.kind, found.size)


def drives(channel: str) -> bool:
    """Whether a channel may drive a model: a command, the ground below a mount, a force."""
    variable, _, label = channel.partition(" ")
    return variable in ("valve_command", FORCE) or (variable.startswith("ground_") and not label.startswith(UPSTREAM))


def role_of(channel: str, stated: Role | None, key: str) -> Role:
    """What a channel is to the model: as stated, else an input where it may drive one.

    Raises:
        InputError: where it is stated to be an input and cannot be, or an output and is none.
    """
    may = drives(channel)
    if stated == "input" and not may:
        raise InputError(
            f"{key}.role = 'input': {channel} is what the machine does; valve_command, ground_… below a mount, and "
            "forces drive it"
        )
    if stated == "output" and channel.split(" ")[0] in ("valve_command", FORCE):
        raise InputError(
            f"{key}.role = 'output': {channel} drives the machine, and no model predicts it; leave role out"
        )
    return stated or ("input" if may else "output")


def check_measured(channel: str, mounts: tuple[str, ...], key: str) -> None:
    """Refuse a name that is no channel of a machine on these mounts.

    Raises:
        InputError: naming the key, and what is near.
    """
    commands = valve_commands(mounts)
    if channel in commands:
        return
    if channel.startswith("valve_command"):
        near = did_you_mean(channel, commands)
        raise InputError(f"{key}.channel = {channel!r}: {near}must be one of {', '.join(commands)}")
    try:
        check_channel(channel, mounts)
    except InputError:
        raise
    except ValueError as error:
        raise InputError(f"{key}.channel: {error}") from error
