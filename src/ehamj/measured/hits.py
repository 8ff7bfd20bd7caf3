"""Blows of a hammer in a record: where each is, and the responses that all of them tell, with their deviations.

The force counts within each blow alone (a force window), since between blows it is the sensor's noise; motions count
from before a blow until before the next one, without a window, so that nothing is damped that the machine does not damp
itself. H1 = Σ Y F̄/Σ |F|² over the blows at a place. What is left of Y beside H1 F is noise; its power, averaged over
blows and over neighbouring lines, says how well each line is known (Bendat & Piersol, Random Data, 4th ed., 9.1), at
best as well as gains of sensors are (`ehamj.measured.responses.variance`).
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np

from ehamj.arrays import Array, ComplexArray
from ehamj.errors import InputError
from ehamj.measured.measured import Measured, MeasuredChannel, MeasuredResponses
from ehamj.measured.responses.variance import LEAST

BLOW: Final = 0.2
"""Force over the record's largest from which it is a blow [-]."""
FOOT: Final = 0.01
"""Force over a blow's peak beyond which the blow lasts [-]."""
NOISY: Final = 6.0
"""The same over the RMS of the noise between blows."""
BOUNCE: Final = 0.05
"""Time within which a second blow is a bounce of the first one [s]."""
BEFORE: Final = 0.002
"""Quiet time that a segment has at its beginning [s]."""
LONGEST: Final = 0.1
"""Duration of a blow at most [s]."""
QUIET: Final = 3e-3
"""Noise of the force over a blow's peak from which it is told of [-]."""
FAINT: Final = 1e-2
"""Power of the force at a line over its largest, below which nothing is compared: 20 dB."""
LEFT: Final = 0.03
"""Motion at a segment's end over its largest from which it has not died out [-]."""
MOST_LEFT: Final = 0.3
"""The same from which the segment is of no use."""
FEWEST_LINES: Final = 8
FREEDOM: Final = 60
"""Lines and blows that the noise of a line is averaged over."""
FEWEST: Final = 2
"""Blows at a place."""


@dataclass(frozen=True)
class Blows:
    """Blows on one place: first and last samples of the force (blow, 2), and of the peaks (blow,)."""

    channel: MeasuredChannel
    spans: np.ndarray
    peaks: np.ndarray


def responses_of_hits(
    records: Sequence[Measured], band: tuple[float, float], length: float | None, key: str, name: str = ""
) -> tuple[MeasuredResponses, ComplexArray]:
    """Responses of all outputs to the hammer, and what each blow adds to their errors, (blow, f, output, input).

    The blows' parts of an error sum to zero; the sum of their squares is that of an error of the responses, of the
    force's noise too, which goes into all outputs and many lines alike.

    Args:
        records: with forces as inputs, one for each place that was hit there, and the same outputs, motions.
        band: that is wanted [Hz].
        length: of a segment after each blow [s]; None: until the next blow, or the record's end.
        key: of the test's table, for messages.
        name: of the test.

    Raises:
        InputError: if an input is no force, there are fewer than two blows at a place, or the machine does not come to
            rest between them.
    """
    places = [(record, _blows(one, record, key)) for record in records for one in record.inputs]
    if not places or not records[0].outputs:
        raise InputError(
            f"{key}.measurement: blows need a force, force = {{ point, direction }}, and an output at least"
        )
    rate, outputs = _alike(records, key)
    count, notes = _length(places, length, key)
    frequency = np.fft.rfftfreq(count, 1.0 / rate)
    usable = min(one.usable_to for one in records)
    inside = (frequency >= band[0]) & (frequency <= min(band[1], usable)) & (frequency > 0.0)
    if inside.sum() < FEWEST_LINES:
        raise InputError(
            f"{key}.band = {list(band)}: {count / rate:.3g} s after each blow have a line each {rate / count:.3g} Hz, "
            f"{inside.sum()} of them there; {FEWEST_LINES} are needed: widen it or leave more time between blows"
        )
    notes += _noisy([one for _, one in places])
    each = [_one_place(one, record, count, inside) for record, one in places]
    response, variance = np.stack([one[0] for one in each], axis=-1), np.stack([one[1] for one in each], axis=-1)
    coherence = np.stack([one[2] for one in each], axis=-1)
    kept = np.isfinite(variance).any(axis=(1, 2))
    inputs = [one.channel for _, one in places]
    whole = MeasuredResponses(
        name or records[0].name,
        np.asarray(frequency[inside][kept], np.float64),
        tuple(one.name for one in inputs),
        tuple(one.name for one in outputs),
        tuple(one.unit for one in inputs),
        tuple(one.unit for one in outputs),
        response[kept],
        variance[kept],
        coherence[kept],
        tuple(one.place for one in inputs),
        tuple(dict.fromkeys([*(note for record in records for note in record.notes), *notes])),
        tuple(one.place for one in outputs),
    )
    errors = np.zeros((sum(len(one[3]) for one in each), *whole.response.shape), complex)
    first = 0
    for k, one in enumerate(each):
        errors[first : first + len(one[3]), :, :, k] = one[3][:, kept]
        first += len(one[3])
    return whole, errors


def _alike(records: Sequence[Measured], key: str) -> tuple[float, tuple[MeasuredChannel, ...]]:
    """Rate and outputs of all records.

    Raises:
        InputError: where they differ.
    """
    first = records[0]
    for record in records:
        if record.rate != first.rate:
            raise InputError(f"{key}: records of {first.rate:g} and {record.rate:g} Hz; make them two tests")
        if [one.name for one in record.outputs] != [one.name for one in first.outputs]:
            raise InputError(f"{key}: records have other outputs; make them two tests")
    return first.rate, first.outputs


def _blows(channel: MeasuredChannel, measured: Measured, key: str) -> Blows:
    """Where a hammer hit."""
    if channel.place is None:
        raise InputError(f"{key}.measurement: {channel.name} is an input, and no force; blows are of a hammer alone")
    force = channel.samples - np.median(channel.samples)
    size = np.abs(force)
    noise = 1.4826 * float(np.median(size))
    above = np.flatnonzero(size > BLOW * size.max(initial=0.0))
    if not above.size or size.max() < 10.0 * noise:
        raise InputError(f"{key}.measurement: {channel.name} shows no blow; is it the hammer's channel?")
    apart = np.flatnonzero(np.diff(above) > BOUNCE * measured.rate)
    groups = np.split(above, apart + 1)
    peaks = np.array([group[np.argmax(size[group])] for group in groups])
    if len(peaks) < FEWEST:
        raise InputError(
            f"{key}.measurement: {channel.name} shows {len(peaks)} blow; {FEWEST} at a place are needed at least, or "
            f"nothing says how well the responses are known: hit it again, {1e3 * BOUNCE:g} ms later or more, and with "
            f"{BLOW:.0%} of the hardest at least"
        )
    spans = np.array([_span(size, group, noise) for group in groups])
    longest = float((spans[:, 1] - spans[:, 0]).max()) / measured.rate
    if longest > LONGEST:
        raise InputError(
            f"{key}.measurement: {channel.name} shows a blow of {1e3 * longest:.3g} ms; a hammer's are shorter than "
            f"{1e3 * LONGEST:.3g} ms. A steady force is kind = 'record'"
        )
    return Blows(channel, spans, peaks)


def _noisy(places: Sequence[Blows]) -> list[str]:
    """That the noise of the hammer's signal is more than deviations count; nothing of a quiet one."""
    shares = []
    for blows in places:
        force = np.abs(blows.channel.samples - np.median(blows.channel.samples))
        shares.append(1.4826 * float(np.median(force)) / float(force[blows.peaks].min()))
    if max(shares) < QUIET:
        return []
    return [
        f"{places[int(np.argmax(shares))].channel.name} has noise of {max(shares):.1%} of its weakest blow's peak, "
        "which makes all modes wrong together; deviations count modes as independent: in trials at 1 % that of the "
        "height of the centre of gravity was 1.8 times too small. A range of the channel that fits the blows helps"
    ]


def _span(size: Array, group: np.ndarray, noise: float) -> tuple[int, int]:
    """First sample of a blow, and the one after its last."""
    least = max(FOOT * float(size[group].max()), NOISY * noise)
    first, last = int(group[0]), int(group[-1])
    while first > 0 and size[first - 1] > least:
        first -= 1
    while last + 1 < size.size and size[last + 1] > least:
        last += 1
    beyond = last - first + 3  # its feet are below the noise; what they lack would lean on every line
    return max(first - beyond, 0), min(last + beyond + 1, size.size)


def _length(places: Sequence[tuple[Measured, Blows]], length: float | None, key: str) -> tuple[int, list[str]]:
    """Samples of a segment, and remarks."""
    rate = places[0][0].rate
    begins: dict[int, list[int]] = {}
    records = {id(record): record for record, _ in places}
    for record, one in places:
        begins.setdefault(id(record), []).extend((one.spans[:, 0] - round(BEFORE * rate)).tolist())
    free = min(
        int(np.diff([*sorted(own), records[which].channels[0].samples.size]).min()) for which, own in begins.items()
    )
    wanted = free if length is None else round(length * rate)
    if min(min(own) for own in begins.values()) < 0:
        raise InputError(f"{key}: a record begins with a blow; it must begin {1e3 * BEFORE:g} ms before it at least")
    if wanted > free:
        raise InputError(
            f"{key}.length = {length:g} s: the shortest time from a blow to the next, or to a record's end, is "
            f"{free / rate:.3g} s"
        )
    still: dict[str, float] = {}
    for number, output in enumerate(places[0][0].outputs):
        segments = [
            records[which].outputs[number].samples[k : k + wanted] for which, own in begins.items() for k in own
        ]
        ratio = float(np.median([_left(segment) for segment in segments]))
        name = output.component or output.name
        if ratio > MOST_LEFT:
            raise InputError(
                f"{key}: {name} still moves {wanted / rate:.3g} s after a blow, with {ratio:.0%} of its most: it shows "
                "noise alone, or blows follow too soon; wait longer between them, or leave the channel out"
            )
        if ratio > LEFT:
            still[name] = ratio
    notes = []
    if still:
        most = max(still, key=lambda name: still[name])
        others = f" ({len(still)} channels do)" if len(still) > 1 else ""
        notes.append(
            f"{most} still moves {wanted / rate:.3g} s after a blow, with {still[most]:.0%} of its most{others}"
        )
    return wanted, notes


def _left(segment: Array) -> float:
    """RMS of the last tenth over that of the loudest one."""
    parts = np.array_split(segment - segment.mean(), 10)
    sizes = [float(np.std(part)) for part in parts]
    return sizes[-1] / max(max(sizes), 1e-300)


def _one_place(
    blows: Blows, measured: Measured, count: int, inside: np.ndarray
) -> tuple[ComplexArray, Array, Array, ComplexArray]:
    """Responses to blows at one place, (line, output) each: H1, its variance, coherence; and what each blow adds to its
    error, (blow, line, output)."""
    lead = round(BEFORE * measured.rate)
    force = blows.channel.samples - np.median(blows.channel.samples)
    begins = blows.spans[:, 0] - lead
    given = np.zeros((len(begins), count))
    for row, (first, last) in zip(given, blows.spans, strict=True):
        row[lead : lead + last - first] = force[first:last]
    moved = np.array([[one.samples[k : k + count] for one in measured.outputs] for k in begins])
    f = np.fft.rfft(given, axis=-1)[:, inside]
    y = np.fft.rfft(moved, axis=-1)[:, :, inside]
    power = (np.abs(f) ** 2).sum(axis=0)
    h1 = np.einsum("nol,nl->lo", y, f.conj()) / power[:, None]
    apart = y - np.einsum("lo,nl->nol", h1, f)
    left, n = np.abs(apart) ** 2, len(begins)
    errors = np.sqrt(n / (n - 1)) * np.einsum("nol,nl->nlo", apart, f.conj()) / power[:, None]
    lines = max(1, round(FREEDOM / (n - 1)))
    noise = _smooth(left.sum(axis=0).T / (n - 1), lines)
    variance = np.maximum(noise / power[:, None], np.abs(LEAST * h1) ** 2)
    # The force's own noise within a blow of L samples makes all outputs wrong alike, and count/L lines as well: no mean
    # over them makes it smaller. n σ² L/Σ|F|² of each, times as many.
    quiet = 1.4826 * float(np.median(np.abs(force)))
    variance += np.abs(h1) ** 2 * (n * quiet**2 * count * h1.shape[1] / power)[:, None]
    total = np.einsum("nol->lo", np.abs(y) ** 2)
    coherence = np.minimum(np.abs(h1) ** 2 * power[:, None] / np.maximum(total, 1e-300), 1.0)
    variance[power < FAINT * power.max()] = np.nan
    return h1, variance, coherence, errors


def _smooth(values: Array, lines: int) -> Array:
    """Mean over ``lines`` neighbours of each line, fewer at the ends, (line, …)."""
    half = min(lines, len(values)) // 2
    total = np.concatenate([np.zeros((1, *values.shape[1:])), np.cumsum(values, axis=0)])
    at = np.arange(len(values))
    low, high = np.maximum(at - half, 0), np.minimum(at + half + 1, len(values))
    return np.asarray((total[high] - total[low]) / (high - low)[:, None])
