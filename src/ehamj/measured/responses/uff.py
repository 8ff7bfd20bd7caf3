"""Responses of universal files: dataset 58 of function types 4 and 5, with coherence beside them."""

from collections.abc import Callable
from pathlib import Path
from typing import Any, Final

import numpy as np

from ehamj.arrays import Array, ComplexArray
from ehamj.measured.responses.raw import RawResponse
from ehamj.records.files import existing, reading
from ehamj.records.uff import DATA_TYPES, IEEE, direction_of, label_of, opened, sets_of
from ehamj.records.units import is_silent, unit

RESPONSES: Final = {4: "frequency response", 5: "transmissibility"}
AUTO, CROSS, COHERENCE = 2, 3, 6
"""Function types that tell how well a response is known."""
FREQUENCY: Final = (0, 1, 18)
"""Data types that the abscissa may state: unknown, general, frequency."""
FORCES: Final = (9, 13)
"""Data types of a force that excites, and of any."""
SAME: Final = 1e-5
"""How near two frequencies lie that are one, over the highest; ASCII has six digits."""

Head = dict[str, Any]


def read_uff(path: Path) -> list[RawResponse]:
    """The responses of a universal file (datasets 58 and 58b), each by node and direction of output and input.

    A direction that is negative turns the sign, as it does in records. The unit is the ordinate's label over its
    denominator's. The coherence is that of function type 6 for the same pair, else |G_xy|²/(G_xx G_yy) of the auto
    and cross spectra where all are there.

    Raises:
        ValueError: where the file cannot be read, or what it holds of a response contradicts itself.
    """
    existing(path)
    with opened(path) as file:
        with reading(path, " as a universal file"):
            heads = sets_of(file, {*RESPONSES, AUTO, CROSS, COHERENCE})
        beside: dict[tuple[int, str, str], Callable[[], Head]] = {
            (head["func_type"], *_places(head)): lambda n=n: file.read_sets(n)  # type: ignore[misc]
            for n, head in heads.items()
            if head["func_type"] not in RESPONSES
        }
        found = []
        for n, head in heads.items():
            if head["func_type"] in RESPONSES:
                output, driven = _places(head)
                with reading(path, f" as a universal file: {output} over {driven}"):
                    content = file.read_sets(n)
                    frequency, values = _values(content)
                    sign = float(np.sign(head["rsp_dir"] or 1) * np.sign(head["ref_dir"] or 1))
                    coherence = _coherence(beside, output, driven, frequency)
                found.append(
                    RawResponse(
                        output,
                        driven,
                        frequency,
                        np.asarray(sign * values, complex),
                        _unit(content),
                        coherence,
                        motion=_motion(content),
                    )
                )
    if not found:
        raise ValueError(
            f"ground.file = {path.name!r} holds no frequency response (dataset 58, function type 4 or 5); of records "
            "over time the test's kind is 'record'"
        )
    return found


def _places(head: Head) -> tuple[str, str]:
    """Output and input by node and direction."""
    return tuple(f"{head[f'{who}_node']}:{direction_of(head[f'{who}_dir'])}" for who in ("rsp", "ref"))  # type: ignore[return-value]


def _values(content: Head) -> tuple[Array, ComplexArray]:
    """Frequencies [Hz] and values of a dataset; raises ValueError where they are not what they must be."""
    if "data" not in content:
        raise ValueError(f"its ordinate data type is {content['ord_data_type']}; known are 2, 4, 5 and 6")
    values, stated = np.asarray(content["data"], complex), int(content["num_pts"])
    if content["binary"] and content["fp_format"] != IEEE:
        raise ValueError(f"it is in floating-point format {content['fp_format']}; only IEEE 754 (2) is read")
    if values.size != stated:
        raise ValueError(f"it holds {values.size} of {stated} values; the file may be truncated")
    kind, label = int(content["abscissa_spec_data_type"]), label_of(content, "abscissa")
    size = 1.0
    if not is_silent(label):
        found = unit(label)
        if found.kind not in ("frequency", "angular velocity"):
            raise ValueError(f"its abscissa is in {label!r}; label it Hz")
        size = found.size / (1.0 if found.kind == "frequency" else 2.0 * np.pi)
    elif kind not in FREQUENCY:
        raise ValueError(f"its abscissa is of data type {kind}, not of frequency (18)")
    if content["abscissa_spacing"] == 1:
        frequency = content["abscissa_min"] + content["abscissa_inc"] * np.arange(values.size)
    else:
        frequency = np.asarray(content["x"], float)
    return size * frequency, values


def _unit(content: Head) -> str | None:
    """Output's unit over input's, None where one of them is not stated."""
    parts = [label_of(content, axis) for axis in ("ordinate", "orddenom")]
    if any(is_silent(part) for part in parts):
        return None
    return f"({parts[0]})/({parts[1]})"


def _motion(content: Head) -> str:
    """What is over a force, by the data types of ordinate and denominator; "" where they do not say it."""
    if int(content.get("orddenom_spec_data_type", 0)) not in FORCES:
        return ""
    return DATA_TYPES.get(int(content.get("ordinate_spec_data_type", 0)), "")


def _coherence(
    beside: dict[tuple[int, str, str], Callable[[], Head]], y: str, x: str, frequency: Array
) -> Array | None:
    """The coherence of a pair, (f,), where the file tells it."""

    def real_of(key: tuple[int, str, str]) -> Array:
        own, values = _values(beside[key]())
        if own.shape != frequency.shape or np.abs(own - frequency).max() > SAME * frequency.max():
            raise ValueError("its coherence or spectra have other frequencies")
        return np.abs(values) ** (2 if key[0] == CROSS else 1)

    if (COHERENCE, y, x) in beside:
        return real_of((COHERENCE, y, x))
    cross = next((key for key in ((CROSS, y, x), (CROSS, x, y)) if key in beside), None)
    autos = [(AUTO, place, place) for place in (x, y)]
    if cross is None or not all(key in beside for key in autos):
        return None
    powers = real_of(autos[0]) * real_of(autos[1])
    return np.divide(real_of(cross), powers, out=np.zeros_like(powers), where=powers > 0.0)
