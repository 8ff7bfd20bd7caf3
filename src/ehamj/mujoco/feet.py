"""What a step hands to the mounts at a stage, and the ground's and the turned feet's forces on the machine."""

from ehamj.compiled import kernel
from ehamj.isolator.cylinder import oil_force
from ehamj.isolator.fluid import actual_pressure
from ehamj.isolator.membrane import pull
from ehamj.mujoco.finite import across, beyond, cross, dot, hinge_moments, plus, swung, times, turn_of
from ehamj.mujoco.unpacking import cubic_of, hermite, isolator_of, through
from ehamj.plant.axes import JOINTS

X, Y, Z = JOINTS.index("x"), JOINTS.index("y"), JOINTS.index("z")
RX, RY, RZ = JOINTS.index("rx"), JOINTS.index("ry"), JOINTS.index("rz")


@kernel
def write_command(mount, s):  # type: ignore[no-untyped-def]
    """Evaluate the command beside the controller's, and what a switch of that adds, at the fraction ``s`` of a step."""
    mount.command = hermite(cubic_of(mount.open_loop), s)[0]
    mount.switching = through(mount.switch_start, mount.switch_middle, mount.switch_end, s)


@kernel
def upright_stage(machine, s, force):  # type: ignore[no-untyped-def]
    """Evaluate ground and command at the fraction ``s`` of a step; add the ground's lateral pull to ``force``.

    For upright mounts in the mount plane, whose strokes are linear to third order.
    """
    rate = machine.step[0].rate
    for k in range(machine.mounts.size):
        mount, isolator = machine.mounts[k], machine.isolators[k]
        own = isolator_of(isolator).membrane
        x, x_slope = hermite(cubic_of(mount.ground_x), s)
        y, y_slope = hermite(cubic_of(mount.ground_y), s)
        z, z_slope = hermite(cubic_of(mount.ground_z), s)
        mount.ground = z + isolator.height
        mount.ground_rate = z_slope * rate
        write_command(mount, s)
        pull_x, pull_y = pull(x, x_slope, rate, own), pull(y, y_slope, rate, own)
        force[X] += pull_x
        force[Y] += pull_y
        force[RZ] += isolator.mount_x * pull_y - isolator.mount_y * pull_x


@kernel
def foot_forces(machine, k, motion, turn, ground, own):  # type: ignore[no-untyped-def]
    """Force of a mount on its foot [N], and what of it the engine's linear membranes and coordinates have not.

    ``motion`` is (u, θ) of the machine and its rate, ``ground`` displacement and velocity of the ground. It leaves the
    ground along the action, and what the turn adds to the length, in the mount's record.
    """
    mount, isolator, state = machine.mounts[k], machine.isolators[k], machine.states[k]
    r = (isolator.mount_x, isolator.mount_y, isolator.mount_z)
    along = (isolator.along_x, isolator.along_y, isolator.along_z)
    (u, angles), (speed, spin) = motion
    more, more_rate = beyond(turn, angles, r)
    mount.turn, mount.turn_rate = dot(along, more), dot(along, more_rate)
    mount.ground = dot(along, ground[0]) + isolator.height - mount.turn
    mount.ground_rate = dot(along, ground[1]) - mount.turn_rate
    stretch = machine.length[k] - mount.ground
    stretching = machine.velocity[k] - mount.ground_rate
    pressure_1 = actual_pressure(state.pressure_1, own.fluid.vapour_pressure)
    pressure_2 = actual_pressure(state.pressure_2, own.fluid.vapour_pressure)
    axial = oil_force(pressure_1, pressure_2, own.cylinder) + isolator.plate_weight
    axial -= own.membrane.membrane_stiffness * stretch + own.membrane.membrane_damping * stretching
    linear, linear_rate = plus(u, cross(angles, r)), plus(speed, cross(spin, r))
    stiffness, damping = own.membrane.lateral_stiffness, own.membrane.lateral_damping
    left, left_rate = plus(ground[0], times(-1.0, more)), plus(ground[1], times(-1.0, more_rate))
    extra = across(plus(times(stiffness, left), times(damping, left_rate)), along)
    lateral = across(plus(times(-stiffness, linear), times(-damping, linear_rate)), along)
    return plus(plus(times(axial, along), lateral), extra), extra


@kernel
def turned_stage(machine, s, force):  # type: ignore[no-untyped-def]
    """As `upright_stage`, for mounts anywhere and in any direction: with finite turns of the machine.

    Tendons and joints of the model have the forces of the linear motion of the feet; what goes beyond them is added to
    ``force``. The plates' inertia stays on the linear coordinate.
    """
    rate, q, v = machine.step[0].rate, machine.qpos, machine.qvel
    angles, spin = (q[RX], q[RY], q[RZ]), (v[RX], v[RY], v[RZ])
    motion = ((q[X], q[Y], q[Z]), angles), ((v[X], v[Y], v[Z]), spin)
    turn = turn_of(angles, spin)
    pulled = at_rest = moved = moment = (0.0, 0.0, 0.0)
    for k in range(machine.mounts.size):
        mount, isolator = machine.mounts[k], machine.isolators[k]
        x, x_slope = hermite(cubic_of(mount.ground_x), s)
        y, y_slope = hermite(cubic_of(mount.ground_y), s)
        z, z_slope = hermite(cubic_of(mount.ground_z), s)
        write_command(mount, s)
        ground = (x, y, z), (x_slope * rate, y_slope * rate, z_slope * rate)
        whole, extra = foot_forces(machine, k, motion, turn, ground, isolator_of(isolator))
        r = (isolator.mount_x, isolator.mount_y, isolator.mount_z)
        pulled, moment = plus(pulled, extra), plus(moment, cross(r, extra))
        at_rest, moved = plus(at_rest, cross(r, whole)), plus(moved, cross(swung(turn, r), whole))
    about = hinge_moments(turn, at_rest, moved, moment)
    force[X] += pulled[0]
    force[Y] += pulled[1]
    force[Z] += pulled[2]
    force[RX] += about[0]
    force[RY] += about[1]
    force[RZ] += about[2]


@kernel
def plates(machine, length, velocity):  # type: ignore[no-untyped-def]
    """Motion of the plates along their actions, shims left out: stroke and rate over ground at rest."""
    for k in range(machine.mounts.size):
        mount = machine.mounts[k]
        length[k] = machine.length[k] + mount.turn - machine.isolators[k].height
        velocity[k] = machine.velocity[k] + mount.turn_rate
