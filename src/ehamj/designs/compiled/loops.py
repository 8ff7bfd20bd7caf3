"""Passive machines and closed loops of many designs over frequency."""

import math

import numpy as np

from ehamj.compiled import kernel
from ehamj.designs.compiled.machine import (
    commands_in,
    dynamic,
    ground_in,
    oil_of,
    read,
    solved,
    spool_of,
)
from ehamj.designs.compiled.margins import begin, follow
from ehamj.designs.compiled.structured import largest_mu


@kernel
def at_frequency(s, one, oil, spools, matrix):  # type: ignore[no-untyped-def]
    """Oil, spools and dynamic stiffness of one design, ``one`` (mass, damping, stiffness, motions, supports, oil)."""
    for mount in range(oil.shape[0]):
        oil_of(s, one[5][mount], oil[mount])
        spools[mount] = spool_of(s, one[5][mount])
    dynamic(s, one[0], one[1], one[2], one[3][2], oil, matrix)


@kernel
def strokes_of(plate, moved, column, ground, strokes):  # type: ignore[no-untyped-def]
    """Each plate over its ground in a column of ``moved``, ``ground`` (mount, 3, column − mounts) where it moves."""
    mounts = plate.shape[0]
    for mount in range(mounts):
        total = 0.0j
        for row in range(plate.shape[1]):
            total += plate[mount, row] * moved[row, column]
        if column >= mounts:
            total -= ground[mount, 2, column - mounts]
        strokes[mount] = total


def floor_answers(stack, hertz, law, known, sensors, grounds, seen, found, commands):  # type: ignore[no-untyped-def]
    """What columns of the ground's motion make of the centre of gravity and the commands.

    Args:
        stack: mass, damping, stiffness, motions, supports, oil and cg of the designs.
        hertz: frequencies of each design (design, f) [Hz].
        law: commands over readings with what the instruments make of them (f, mount, reading); none without a loop.
        known: which row of ``law``, ``grounds`` and ``seen`` belongs to a frequency, (f,).
        sensors: motion (design, reading, n), order (reading,), states (reading, mount, 3) of each reading.
        grounds: motion of the ground in the mounts' frames (f, mount, 3, column) [m].
        seen: the ground's own motion in each reading, (f, reading, column).
        found: displacement of the centre of gravity (design, f, 3, column) [m], to be filled.
        commands: as they act (design, f, mount, column) [V], to be filled where there is a loop.
    """
    mass, damping, stiffness, motions, supports, oils, cg = stack
    motion, order, states = sensors
    designs, n, mounts, columns = mass.shape[0], mass.shape[1], oils.shape[1], grounds.shape[3]
    readings, closed = motion.shape[1], law.shape[0] > 0
    driven = mounts if closed else 0
    matrix, right = np.empty((n, n), np.complex128), np.empty((n, driven + columns), np.complex128)
    oil, spools = np.empty((mounts, 6), np.complex128), np.empty(mounts, np.complex128)
    strokes, unit = np.empty(mounts, np.complex128), np.empty((mounts, mounts), np.complex128)
    wanted = np.empty((mounts, columns), np.complex128)
    answers = np.empty((readings, mounts + columns), np.complex128)
    for design in range(designs):
        one = (
            mass[design], damping[design], stiffness[design], motions[design], supports[design], oils[design],
        )  # fmt: skip
        for k in range(hertz.shape[1]):
            s = 2j * math.pi * hertz[design, k]
            at = known[k]
            at_frequency(s, one, oil, spools, matrix)
            if closed:
                commands_in(spools, motions[design, 2], oil, right)
            ground_in(s, motions[design], supports[design], grounds[at], oil, right, driven)
            solved(matrix, right)
            if driven:
                for column in range(mounts + columns):
                    strokes_of(motions[design, 2], right, column, grounds[at], strokes)
                    for reading in range(readings):
                        answers[reading, column] = read(
                            s, motion[design, reading], order[reading], states[reading], right, oil, spools, column,
                            mounts, strokes,
                        )  # fmt: skip
                for row in range(mounts):
                    for column in range(mounts + columns):
                        total = 0.0j
                        for reading in range(readings):
                            value = answers[reading, column]
                            if column >= mounts:
                                value += seen[at, reading, column - mounts]
                            total += law[at, row, reading] * value
                        if column < mounts:
                            unit[row, column] = (1.0 if row == column else 0.0) - total
                        else:
                            wanted[row, column - mounts] = total
                solved(unit, wanted)
                for mount in range(mounts):
                    for column in range(columns):
                        commands[design, k, mount, column] = wanted[mount, column]
            for axis in range(3):
                for column in range(columns):
                    total = 0.0j
                    for row in range(n):
                        value = right[row, driven + column]
                        for mount in range(driven):
                            value += right[row, mount] * wanted[mount, column]
                        total += cg[design, axis, row] * value
                    found[design, k, axis, column] = total


def loop_margins(stack, hertz, law, sensors, picks, counts, active, patterns, nominal, places, whole):  # type: ignore[no-untyped-def]
    """Margins of each design's loop, broken at valves, patterns and readings.

    Args:
        stack: as `floor_answers`.
        hertz: frequencies (f,) [Hz].
        law: as there, of readings that move with the machine alone.
        sensors: as there.
        picks: numbers of each design's frequencies, rising (design, most).
        counts: how many of them there are, (design,).
        active: numbers of the mounts that obey.
        patterns: strokes of these mounts per pattern, and its inverse, (2, design, mount, mount).
        nominal: determinant of 1 − law·plant of the design that the others are compared with, (f,); to be filled by
            the first design where it is zero.
        places: `begin` of each valve, pattern and reading (design, place, 4), to be filled.
        whole: largest µ(S − 1/2) of all valves, turn of the determinant over the nominal one [rad], its largest step,
            (design, 3), to be filled.
    """
    mass, damping, stiffness, motions, supports, oils, _ = stack
    motion, order, states = sensors
    designs, n, mounts, readings, own = mass.shape[0], mass.shape[1], oils.shape[1], motion.shape[1], active.size
    matrix, right = np.empty((n, n), np.complex128), np.empty((n, mounts), np.complex128)
    oil, spools = np.empty((mounts, 6), np.complex128), np.empty(mounts, np.complex128)
    strokes, unit = np.empty(mounts, np.complex128), np.empty((mounts, mounts), np.complex128)
    sensitivity, answers = np.empty_like(unit), np.empty((readings, mounts), np.complex128)
    nowhere = np.empty((mounts, 3, 0), np.complex128)
    last = np.empty((2 * own + readings, 1), np.complex128)
    centred = np.empty((picks.shape[1], own, own), np.complex128)
    work, real = np.empty((3, own, own), np.complex128), np.empty((own + 5, own))
    bounds, scale = np.empty(picks.shape[1]), np.empty(own)
    for design in range(designs):
        one = (
            mass[design], damping[design], stiffness[design], motions[design], supports[design], oils[design],
        )  # fmt: skip
        for place in range(2 * own + readings):
            begin(places[design, place])
        before, turned, most = 1.0 + 0.0j, 0.0, 0.0
        for number in range(counts[design]):
            k = picks[design, number]
            s = 2j * math.pi * hertz[k]
            at_frequency(s, one, oil, spools, matrix)
            commands_in(spools, motions[design, 2], oil, right)
            solved(matrix, right)
            for column in range(mounts):
                strokes_of(motions[design, 2], right, column, nowhere, strokes)
                for reading in range(readings):
                    answers[reading, column] = read(
                        s, motion[design, reading], order[reading], states[reading], right, oil, spools, column,
                        mounts, strokes,
                    )  # fmt: skip
            for row in range(mounts):
                for column in range(mounts):
                    total = 0.0j
                    for reading in range(readings):
                        total += law[k, row, reading] * answers[reading, column]
                    unit[row, column] = (1.0 if row == column else 0.0) - total
                    sensitivity[row, column] = 1.0 if row == column else 0.0
            determinant = solved(unit, sensitivity)
            if nominal[k] == 0.0:
                nominal[k] = determinant
            ratio = determinant / nominal[k]
            if number > 0:
                step = ratio / before
                angle = math.atan2(step.imag, step.real)
                turned, most = turned + angle, max(most, abs(angle))
            before = ratio
            for row in range(own):
                for column in range(own):
                    value = sensitivity[active[row], active[column]]
                    centred[number, row, column] = value - (0.5 if row == column else 0.0)
            for place in range(own):
                value = sensitivity[active[place], active[place]]
                follow(value, last[place], number == 0, places[design, place])
                total = 0.0j
                for row in range(own):
                    inner = 0.0j
                    for column in range(own):
                        inner += sensitivity[active[row], active[column]] * patterns[0, design, column, place]
                    total += patterns[1, design, place, row] * inner
                follow(total, last[own + place], number == 0, places[design, own + place])
            for reading in range(readings):
                total = 1.0 + 0.0j
                for row in range(mounts):
                    inner = 0.0j
                    for column in range(mounts):
                        inner += sensitivity[row, column] * law[k, column, reading]
                    total += answers[reading, row] * inner
                follow(total, last[2 * own + reading], number == 0, places[design, 2 * own + reading])
        whole[design, 0] = largest_mu(centred, counts[design], bounds, scale, work, real)
        whole[design, 1], whole[design, 2] = turned, most
