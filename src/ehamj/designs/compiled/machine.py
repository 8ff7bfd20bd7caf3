"""The linear machine of one design at one frequency: what moves it, and what its chambers and sensors make of it.

Chambers with plate motion x over the ground and spool x_v (docs/physics.md, sections 2 and 3):

    s w A₁ x + (s C₁ + 2g₀ + c) p₁ − c p₂ = K_Q x_v,    −s w A₂ x + (s C₂ + 2g₀ + c) p₂ − c p₁ = −K_Q x_v

The force on the plate, A₁ p₁ − A₂ p₂, is −z(s) x + f(s) x_v.
"""

from ehamj.compiled import kernel


@kernel
def inverse_of(z):  # type: ignore[no-untyped-def]
    """1/z, without looking for what overflows."""
    return z.conjugate() * (1.0 / (z.real * z.real + z.imag * z.imag))


@kernel
def oil_of(s, one, found):  # type: ignore[no-untyped-def]
    """Dynamic stiffness z [N/m], force per spool f [N/mA], and pressures p₁, p₂ per x and per x_v, into ``found``
    (6,); ``one`` is a row of `ehamj.designs.stack.OIL`."""
    area_1, area_2, compliance_1, compliance_2, stretch, edge, cross, flow_gain = one[:8]
    a = s * compliance_1 + 2.0 * edge + cross
    b = s * compliance_2 + 2.0 * edge + cross
    inverse = inverse_of(a * b - cross * cross)
    swept = s * stretch * inverse
    found[2] = swept * (cross * area_2 - b * area_1)
    found[3] = swept * (a * area_2 - cross * area_1)
    found[4] = flow_gain * inverse * (b - cross)
    found[5] = -flow_gain * inverse * (a - cross)
    found[0] = area_2 * found[3] - area_1 * found[2]
    found[1] = area_1 * found[4] - area_2 * found[5]


@kernel
def spool_of(s, one):  # type: ignore[no-untyped-def]
    """Spool per command [mA/V]; ``one`` is a row of `ehamj.designs.stack.OIL`."""
    gain, frequency, damping = one[8], one[9], one[10]
    square = frequency * frequency
    return gain * square * inverse_of(s * (s + 2.0 * damping * frequency) + square)


@kernel
def dynamic(s, mass, damping, stiffness, plate, oil, matrix):  # type: ignore[no-untyped-def]
    """s²M + sC + K and the oil's z at each plate, into ``matrix`` (n, n); ``oil`` (mount, 6) is `oil_of` each."""
    n, mounts = mass.shape[0], plate.shape[0]
    omega = s.imag  # frequencies are real: s² is −ω²
    for row in range(n):
        for column in range(n):
            still = stiffness[row, column] - omega * omega * mass[row, column]
            matrix[row, column] = complex(still, omega * damping[row, column])
    for mount in range(mounts):
        for row in range(n):
            own = plate[mount, row]
            if own != 0.0:
                real, imag = own * oil[mount, 0].real, own * oil[mount, 0].imag
                for column in range(n):
                    matrix[row, column] += complex(real * plate[mount, column], imag * plate[mount, column])


@kernel
def size_of(z):  # type: ignore[no-untyped-def]
    """|z|²; the root of it costs more than all else."""
    return z.real * z.real + z.imag * z.imag


@kernel
def solved(matrix, right):  # type: ignore[no-untyped-def]
    """Solve in place by elimination with row pivoting: matrix (n, n), right (n, columns); gives the determinant."""
    n, columns = right.shape
    determinant = 1.0 + 0.0j
    for k in range(n):
        pivot, most = k, size_of(matrix[k, k])
        for row in range(k + 1, n):
            if size_of(matrix[row, k]) > most:
                pivot, most = row, size_of(matrix[row, k])
        if pivot != k:
            determinant = -determinant
            for column in range(k, n):
                matrix[k, column], matrix[pivot, column] = matrix[pivot, column], matrix[k, column]
            for column in range(columns):
                right[k, column], right[pivot, column] = right[pivot, column], right[k, column]
        determinant *= matrix[k, k]
        inverse = inverse_of(matrix[k, k])
        for row in range(k + 1, n):
            factor = matrix[row, k] * inverse
            if factor != 0.0:
                for column in range(k + 1, n):
                    matrix[row, column] -= factor * matrix[k, column]
                for column in range(columns):
                    right[row, column] -= factor * right[k, column]
    for k in range(n - 1, -1, -1):
        inverse = inverse_of(matrix[k, k])
        for row in range(k + 1, n):
            factor = matrix[k, row]
            for column in range(columns):
                right[k, column] -= factor * right[row, column]
        for column in range(columns):
            right[k, column] *= inverse
    return determinant


@kernel
def commands_in(spools, plate, oil, right):  # type: ignore[no-untyped-def]
    """Generalised forces of each valve's command into the first columns of ``right`` (n, …); ``spools`` (mount,) are
    `spool_of` each."""
    for mount in range(plate.shape[0]):
        force = oil[mount, 1] * spools[mount]
        for row in range(plate.shape[1]):
            right[row, mount] = plate[mount, row] * force


@kernel
def ground_in(s, motions, supports, ground, oil, right, first):  # type: ignore[no-untyped-def]
    """Generalised forces of motions of the ground into columns of ``right`` from ``first`` on.

    ``motions`` (3, mount, n) of each foot across, across and along its mount, ``supports`` (2, 3, mount) their
    stiffness and damping, ``ground`` (mount, 3, column) [m] in the mounts' frames.
    """
    for column in range(ground.shape[2]):
        for row in range(motions.shape[2]):
            right[row, first + column] = 0.0
        for mount in range(ground.shape[0]):
            for axis in range(3):
                stiff = supports[0, axis, mount] + s * supports[1, axis, mount]
                if axis == 2:
                    stiff += oil[mount, 0]
                force = stiff * ground[mount, axis, column]
                if force != 0.0:
                    for row in range(motions.shape[2]):
                        right[row, first + column] += motions[axis, mount, row] * force


@kernel
def strokes_of(plate, moved, first, ground, strokes):  # type: ignore[no-untyped-def]
    """Each plate over its ground per column of ``moved`` (n, columns), into ``strokes`` (mount, columns); ``ground``
    (mount, 3, column) moves in the columns from ``first`` on."""
    for mount in range(plate.shape[0]):
        for column in range(moved.shape[1]):
            strokes[mount, column] = 0.0
        for row in range(plate.shape[1]):
            own = plate[mount, row]
            if own != 0.0:
                for column in range(moved.shape[1]):
                    strokes[mount, column] += own * moved[row, column]
        for column in range(first, moved.shape[1]):
            strokes[mount, column] -= ground[mount, 2, column - first]


@kernel
def readings_of(s, motion, order, states, inside, moved, strokes, oil, spools, answers):  # type: ignore[no-untyped-def]
    """What sensors see in columns of coordinates ``moved`` (n, columns), but for the ground's own motion.

    ``motion`` (reading, n) of the machine at each, counted ``order`` (reading,) times differentiated; ``states``
    (reading, mount, 3) its shares of spool and pressures, of the readings that are ``inside`` (reading,). The first
    columns are the mounts' commands: their spools move.
    """
    mounts = oil.shape[0]
    for reading in range(motion.shape[0]):
        for column in range(moved.shape[1]):
            answers[reading, column] = 0.0
        for row in range(motion.shape[1]):
            own = motion[reading, row]
            if own != 0.0:
                for column in range(moved.shape[1]):
                    answers[reading, column] += own * moved[row, column]
        if order[reading] > 0:
            factor = s if order[reading] == 1 else s * s
            for column in range(moved.shape[1]):
                answers[reading, column] *= factor
        if inside[reading]:
            for mount in range(mounts):
                one, two = states[reading, mount, 1], states[reading, mount, 2]
                pressed = one * oil[mount, 2] + two * oil[mount, 3]
                if one != 0.0 or two != 0.0:
                    for column in range(moved.shape[1]):
                        answers[reading, column] += pressed * strokes[mount, column]
                fed = states[reading, mount, 0] + one * oil[mount, 4] + two * oil[mount, 5]
                answers[reading, mount] += fed * spools[mount]
