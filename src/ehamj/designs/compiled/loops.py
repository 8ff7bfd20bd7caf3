"""Passive machines and closed loops of many designs over frequency."""

import math

import numpy as np

from ehamj.compiled import kernel
from ehamj.designs.compiled.machine import (
    commands_in,
    dynamic,
    ground_in,
    inverse_of,
    oil_of,
    readings_of,
    solved,
    spool_of,
    strokes_of,
)
from ehamj.designs.compiled.margins import begin, follow
from ehamj.designs.compiled.seen import at_readings, closed, see


@kernel
def at_frequency(s, one, oil, spools, matrix):  # type: ignore[no-untyped-def]
    """Oil, spools and dynamic stiffness of one design, ``one`` (mass, damping, stiffness, motions, supports, oil)."""
    for mount in range(oil.shape[0]):
        oil_of(s, one[5][mount], oil[mount])
        spools[mount] = spool_of(s, one[5][mount])
    dynamic(s, one[0], one[1], one[2], one[3][2], oil, matrix)


@kernel
def around(law, answers, seen, unit, wanted):  # type: ignore[no-untyped-def]
    """1 − law·plant into ``unit`` (mount, mount), and what the law makes of the ground into ``wanted`` (mount, column);
    ``answers`` (reading, mount + column) of commands and ground, ``seen`` (reading, column) the ground's own motion."""
    mounts = unit.shape[0]
    for row in range(mounts):
        for column in range(answers.shape[1]):
            total = 0.0j
            for reading in range(answers.shape[0]):
                value = answers[reading, column]
                if column >= mounts:
                    value += seen[reading, column - mounts]
                total += law[row, reading] * value
            if column < mounts:
                unit[row, column] = (1.0 if row == column else 0.0) - total
            else:
                wanted[row, column - mounts] = total


def floor_answers(stack, hertz, law, known, sensors, grounds, seen, found, commands):  # type: ignore[no-untyped-def]
    """What columns of the ground's motion make of the centre of gravity and the commands.

    Args:
        stack: mass, damping, stiffness, motions, supports, oil and cg of the designs.
        hertz: frequencies of each design (design, f) [Hz].
        law: commands over readings with what the instruments make of them (f, mount, reading); none without a loop.
        known: which row of ``law``, ``grounds`` and ``seen`` belongs to a frequency, (f,).
        sensors: motion (design, reading, n), order (reading,), states (reading, mount, 3) of each reading, and whether
            it has any of these (reading,).
        grounds: motion of the ground in the mounts' frames (f, mount, 3, column) [m].
        seen: the ground's own motion in each reading, (f, reading, column).
        found: displacement of the centre of gravity (design, f, 3, column) [m], to be filled.
        commands: as they act (design, f, mount, column) [V], to be filled where there is a loop.
    """
    mass, damping, stiffness, motions, supports, oils, cg = stack
    motion, order, states, inside = sensors
    designs, n, mounts, columns = hertz.shape[0], mass.shape[1], oils.shape[1], grounds.shape[3]
    readings, fed_back = motion.shape[1], law.shape[0] > 0
    driven = mounts if fed_back else 0
    matrix, right = np.empty((n, n), np.complex128), np.empty((n, driven + columns), np.complex128)
    oil, spools = np.empty((mounts, 6), np.complex128), np.empty(mounts, np.complex128)
    strokes, unit = np.empty((mounts, mounts + columns), np.complex128), np.empty((mounts, mounts), np.complex128)
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
            if fed_back:
                commands_in(spools, motions[design, 2], oil, right)
            ground_in(s, motions[design], supports[design], grounds[at], oil, right, driven)
            solved(matrix, right)
            if driven:
                strokes_of(motions[design, 2], right, mounts, grounds[at], strokes)
                readings_of(s, motion[design], order, states, inside, right, strokes, oil, spools, answers)
                around(law[at], answers, seen[at], unit, wanted)
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


@kernel
def centre(sensitivity, active, centred):  # type: ignore[no-untyped-def]
    """S − 1/2 at the valves that obey, (mount, mount)."""
    for row in range(active.size):
        for column in range(active.size):
            value = sensitivity[active[row], active[column]]
            centred[row, column] = value - (0.5 if row == column else 0.0)


@kernel
def follow_valves(sensitivity, active, basis, first, last, places):  # type: ignore[no-untyped-def]
    """Follow each valve, then each pattern of ``basis`` (strokes per pattern, and its inverse)."""
    own = active.size
    for place in range(own):
        follow(sensitivity[active[place], active[place]], last[place], first, places[place])
        total = 0.0j
        for row in range(own):
            inner = 0.0j
            for column in range(own):
                inner += sensitivity[active[row], active[column]] * basis[0][column, place]
            total += basis[1][place, row] * inner
        follow(total, last[own + place], first, places[own + place])


@kernel
def follow_readings(at, after, first, last, places):  # type: ignore[no-untyped-def]
    """Follow each reading; its sensitivity's real and imaginary part are in ``at``, its place stands ``after`` some."""
    for place in range(after, places.shape[0]):
        follow(complex(at[0, place - after], at[1, place - after]), last[place], first, places[place])


@kernel
def one_at(matrix):  # type: ignore[no-untyped-def]
    """The unit matrix."""
    for row in range(matrix.shape[0]):
        for column in range(matrix.shape[1]):
            matrix[row, column] = 1.0 if row == column else 0.0


@kernel
def turn(ratio, before, turns):  # type: ignore[no-untyped-def]
    """Add the turn of the determinant between two frequencies."""
    step = ratio * inverse_of(before)
    angle = math.atan2(step.imag, step.real)
    turns[0] += angle
    turns[1] = max(turns[1], abs(angle))


def loop_margins(stack, hertz, law, sensors, chosen, active, patterns, nominal, found):  # type: ignore[no-untyped-def]
    """Margins of each design's loop, broken at valves, patterns and readings.

    Args:
        stack: as `floor_answers`.
        hertz: frequencies (f,) [Hz].
        law: of readings that move with the machine alone, as there, but real and imaginary parts apart
            (2, f, mount, reading), and with silent readings at the end (`ehamj.designs.compiled.seen`).
        sensors: as there, of these, but the motion (design, n, reading), and the order (3, reading), 1 for the one
            that a reading has.
        chosen: numbers of each design's frequencies, rising (design, most), and how many there are (design,).
        active: numbers of the mounts that obey.
        patterns: strokes of these mounts per pattern, and its inverse, (2, design, mount, mount).
        nominal: determinant of 1 − law·plant of the design that the others are compared with, (f,); to be filled by
            the first design where it is zero.
        found: to be filled: `begin` of each valve, pattern and reading (design, place, 4); turns of the determinant
            over the nominal one, altogether and in the largest step, (design, 2) [rad]; S − 1/2 at the valves that obey
            (design, most, mount, mount).
    """
    mass, damping, stiffness, motions, supports, oils, _ = stack
    motion, order, states, inside = sensors
    (picks, counts), (places, turns, centred) = chosen, found
    designs, n, mounts, readings = picks.shape[0], mass.shape[1], oils.shape[1], motion.shape[2]
    matrix, right = np.empty((n, n), np.complex128), np.empty((n, mounts), np.complex128)
    oil, spools = np.empty((mounts, 6), np.complex128), np.empty(mounts, np.complex128)
    strokes, unit = np.empty((mounts, mounts), np.complex128), np.empty((mounts, mounts), np.complex128)
    sensitivity, nowhere = np.empty_like(unit), np.empty((mounts, 3, 0), np.complex128)
    real, imag = np.empty((mounts, readings)), np.empty((mounts, readings))
    passed, at = np.empty((2, readings)), np.empty((2, readings))
    last = np.empty((places.shape[1], 1), np.complex128)
    for design in range(designs):
        one = (
            mass[design], damping[design], stiffness[design], motions[design], supports[design], oils[design],
        )  # fmt: skip
        basis = (patterns[0, design], patterns[1, design])
        for place in range(places.shape[1]):
            begin(places[design, place])
        before, turns[design] = 1.0 + 0.0j, 0.0
        for number in range(counts[design]):
            k, first = picks[design, number], number == 0
            s = 2j * math.pi * hertz[k]
            at_frequency(s, one, oil, spools, matrix)
            commands_in(spools, one[3][2], oil, right)
            solved(matrix, right)
            strokes_of(one[3][2], right, mounts, nowhere, strokes)
            see(s, motion[design], (order, states, inside), right, strokes, oil, spools, real, imag)
            closed(law[0, k], law[1, k], real, imag, passed, unit)
            one_at(sensitivity)
            determinant = solved(unit, sensitivity)
            if nominal[k] == 0.0:
                nominal[k] = determinant
            ratio = determinant * inverse_of(nominal[k])
            if not first:
                turn(ratio, before, turns[design])
            before = ratio
            centre(sensitivity, active, centred[design, number])
            follow_valves(sensitivity, active, basis, first, last, places[design])
            at_readings(law[0, k], law[1, k], real, imag, sensitivity, passed, at)
            follow_readings(at, 2 * active.size, first, last, places[design])
