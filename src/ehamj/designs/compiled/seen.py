"""Loop gains from readings, with all readings side by side: real and imaginary parts apart, so that the compiler works
on several readings at once. Readings lie along the last axis, and fill up with silent ones to a multiple of `SIDE`."""

from ehamj.compiled import kernel

SIDE = 4


@kernel
def see(s, motion, kinds, moved, strokes, oil, spools, real, imag):  # type: ignore[no-untyped-def]
    """As `ehamj.designs.compiled.machine.readings_of` of the commands alone; ``motion`` (n, reading), ``order`` (3,
    reading) is 1 for the order that a reading has (``kinds``: it, ``states`` and ``inside``), what is seen goes into
    ``real`` and ``imag`` (mount, reading)."""
    order, states, inside = kinds
    omega, readings = s.imag, motion.shape[1]
    for column in range(real.shape[0]):
        one, two = real[column], imag[column]
        for reading in range(readings):
            one[reading] = two[reading] = 0.0
        for row in range(motion.shape[0]):
            across, along = moved[row, column].real, moved[row, column].imag
            own = motion[row]
            for reading in range(readings):
                one[reading] += own[reading] * across
            for reading in range(readings):
                two[reading] += own[reading] * along
        for reading in range(readings):  # (jω)^order
            kept = order[0, reading] - omega * omega * order[2, reading]
            turned = omega * order[1, reading]
            before = one[reading]
            one[reading] = kept * before - turned * two[reading]
            two[reading] = kept * two[reading] + turned * before
    for reading in range(readings):
        if inside[reading]:
            for mount in range(oil.shape[0]):
                spool, first, second = states[reading, mount, 0], states[reading, mount, 1], states[reading, mount, 2]
                if first != 0.0 or second != 0.0:
                    pressed = first * oil[mount, 2] + second * oil[mount, 3]
                    for column in range(real.shape[0]):
                        more = pressed * strokes[mount, column]
                        real[column, reading] += more.real
                        imag[column, reading] += more.imag
                fed = (spool + first * oil[mount, 4] + second * oil[mount, 5]) * spools[mount]
                real[mount, reading] += fed.real
                imag[mount, reading] += fed.imag


@kernel
def closed(told_real, told_imag, real, imag, inner, unit):  # type: ignore[no-untyped-def]
    """1 − law·plant into ``unit`` (mount, mount), of a law ``told`` (mount, reading) and what is seen; ``inner`` (2,
    reading) is for passing results."""
    u, v = inner[0], inner[1]
    for row in range(unit.shape[0]):
        a, b = told_real[row], told_imag[row]
        for column in range(unit.shape[1]):
            c, d = real[column], imag[column]
            for k in range(c.size):
                u[k] = a[k] * c[k] - b[k] * d[k]
            for k in range(c.size):
                v[k] = a[k] * d[k] + b[k] * c[k]
            x0 = x1 = x2 = x3 = y0 = y1 = y2 = y3 = 0.0
            for k in range(0, c.size, SIDE):
                x0, x1, x2, x3 = x0 + u[k], x1 + u[k + 1], x2 + u[k + 2], x3 + u[k + 3]
                y0, y1, y2, y3 = y0 + v[k], y1 + v[k + 1], y2 + v[k + 2], y3 + v[k + 3]
            unit[row, column] = (1.0 if row == column else 0.0) - complex((x0 + x1) + (x2 + x3), (y0 + y1) + (y2 + y3))


@kernel
def at_readings(told_real, told_imag, real, imag, sensitivity, inner, found):  # type: ignore[no-untyped-def]
    """Sensitivity at each reading, 1 + Σ plant·S·law, real and imaginary into ``found`` (2, reading); ``inner`` alike
    is for passing results."""
    mounts, readings = real.shape[0], found.shape[1]
    x, y, u, v = found[0], found[1], inner[0], inner[1]
    for k in range(readings):
        x[k], y[k] = 1.0, 0.0
    for column in range(mounts):
        for k in range(readings):
            u[k] = v[k] = 0.0
        for row in range(mounts):
            p, q = sensitivity[row, column].real, sensitivity[row, column].imag
            c, d = real[row], imag[row]
            for k in range(readings):
                u[k] += c[k] * p - d[k] * q
            for k in range(readings):
                v[k] += c[k] * q + d[k] * p
        a, b = told_real[column], told_imag[column]
        for k in range(readings):
            x[k] += u[k] * a[k] - v[k] * b[k]
        for k in range(readings):
            y[k] += u[k] * b[k] + v[k] * a[k]
