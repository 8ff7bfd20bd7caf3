"""What an instrument makes of motion: the response of its stages, held against the overall sensitivity."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from ehamj.arrays import ComplexArray
from ehamj.records.channel import Response
from ehamj.records.choices import ResponseChoice
from ehamj.records.orientation import Orientation
from ehamj.records.units import Quantity
from ehamj.signals import Array

DISAGREEMENT = 0.05
"""How far sensitivity and stages may be apart, relative: what evalresp warns at, and half a decibel in the levels."""

WORTH_SAYING = 0.01
"""From where on it is said that they differ, relative: rounded metadata stay below."""


@dataclass(frozen=True)
class Instrument:
    """An instrument as its metadata say: in counts per SI unit of what it senses."""

    quantity: Quantity
    stages: Callable[[Array], ComplexArray] | None
    """Response of all stages at frequencies [Hz], shape (n,); None where only a sensitivity is stated."""
    product: float | None
    """The stages' own sensitivity where the stated one holds [counts per SI unit]; None where that is unknown."""
    stated: float | None
    """Overall sensitivity [counts per SI unit]; None where none is stated."""
    unit: tuple[str, float] = ("m", 1.0)
    """Of what is sensed, as the metadata spell it, and its SI value; for messages."""
    where: str = ""
    """At which frequency both sensitivities are, for messages."""
    notes: tuple[str, ...] = ()


class Sensed(NamedTuple):
    """What a channel senses, its response in counts per SI unit, and remarks."""

    quantity: Quantity
    response: Response
    notes: tuple[str, ...]
    orientation: Orientation | None = None
    """Where it points, as the metadata state it."""


def agreed_response(name: str, found: Instrument, choice: ResponseChoice | None) -> Sensed:
    """The response of channel ``name``, by stages or scaled to the overall sensitivity as the user chooses.

    Raises ValueError where the two disagree and the user does not choose, and where what is chosen is not there.
    """
    stated = found.stated
    if found.stages is None:
        if choice == "stages" or stated is None:
            raise ValueError(f'ground.response = "stages", but the metadata of {name} have a sensitivity only')
        flat = f"{name}: only an overall sensitivity is stated, {_per(stated, found)}: taken as flat, without poles"
        constant = complex(stated)
        return Sensed(found.quantity, lambda frequency: np.full(frequency.shape, constant), (*found.notes, flat))
    stages = found.stages
    if stated is None or not found.product:
        if choice == "sensitivity":
            raise ValueError(
                f'ground.response = "sensitivity", but the metadata of {name} state no overall sensitivity that could '
                'be held against the stages; use "stages"'
            )
        return Sensed(found.quantity, stages, found.notes)
    ratio = abs(stated / found.product)
    both = (
        f"the overall sensitivity of {name} is stated as {_per(abs(stated), found)}, its stages make "
        f"{_per(found.product, found)}{found.where}"
    )
    if choice is None and abs(np.log(ratio)) > np.log1p(DISAGREEMENT):
        raise ValueError(
            f'ground.inventory: {both}; choose with ground.response = "stages" or "sensitivity" (the stages\' shape, '
            "scaled to it)"
        )
    notes = found.notes
    if abs(ratio - 1.0) > WORTH_SAYING:
        taken = "the stages are scaled to it" if choice == "sensitivity" else "the stages are taken"
        notes = (*notes, f"{both}; {taken}")
    factor = ratio if choice == "sensitivity" else 1.0
    return Sensed(found.quantity, lambda frequency: factor * stages(frequency), notes)


def _per(value: float, found: Instrument) -> str:
    unit, size = found.unit
    return f"{value * size:.6g} counts per {unit!r}"
