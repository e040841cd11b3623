"""Time stepping (compiled): generalised-alpha, pads and contact solved within the step.

One step first advances rail, slabs and vehicle without their new interface forces. Pad forces and
wheel forces at the end of the step then follow from small dense systems in which rail, slabs and
vehicle stand as compliances of the step; the contact law is solved by Newton's method. With these
forces the step is done again exactly. So the result is that of the monolithic implicit system.

All compiled functions are in this one file, because numba's cache only watches a function's own.
"""

import numpy as np
from numba import njit

from .containers import Footing, Workspace

OPTIONS = {"cache": True, "fastmath": {"contract", "reassoc", "nsz", "arcp"}}


@njit(**OPTIONS)
def local_compliance(x, length, bending_stiffness, shear_stiffness):  # pragma: no cover
    """Deflection in m/N under a unit load at x within an element clamped at both ends.

    Added to the nodal solution it makes static deflections exact under the load, too: the part of
    the kink that the element's own shapes cannot follow.
    """
    if x <= 1e-9 * length or x >= (1 - 1e-9) * length:
        return 0.0
    direct, cross, rotary = 0.0, 0.0, 0.0
    for part, sign in ((x, 1.0), (length - x, -1.0)):
        phi = 12 * bending_stiffness / (shear_stiffness * part**2)
        factor = bending_stiffness / ((1 + phi) * part**3)
        direct += 12 * factor
        cross -= sign * 6 * factor * part
        rotary += (4 + phi) * factor * part**2
    return rotary / (direct * rotary - cross**2)


@njit(**OPTIONS)
def solve_factored(lower, inverse_diagonal, x):
    n = len(x)
    x[1] -= lower[1, 0] * x[0]
    x[2] -= lower[2, 1] * x[0] + lower[2, 0] * x[1]
    for i in range(3, n):
        x[i] -= lower[i, 2] * x[i - 3] + lower[i, 1] * x[i - 2] + lower[i, 0] * x[i - 1]
    for i in range(n):
        x[i] *= inverse_diagonal[i]
    x[n - 2] -= lower[n - 1, 0] * x[n - 1]
    x[n - 3] -= lower[n - 1, 1] * x[n - 1] + lower[n - 2, 0] * x[n - 2]
    for i in range(n - 4, -1, -1):
        x[i] -= lower[i + 3, 2] * x[i + 3] + lower[i + 2, 1] * x[i + 2] + lower[i + 1, 0] * x[i + 1]


@njit(**OPTIONS)
def predict_rail(ops, scheme, motion, old_force, blend, right):
    """Turn (u, v, a) of one family into predictors; return the step's known right-hand side."""
    u, v, a = motion[0], motion[1], motion[2]
    dt, n = scheme.step, len(u)
    for i in range(n):
        predicted = u[i] + dt * v[i] + dt * dt * (0.5 - scheme.beta) * a[i]
        blend[i] = (1 - scheme.alpha_f) * predicted + scheme.alpha_f * u[i]
        u[i] = predicted
        v[i] += dt * (1 - scheme.gamma) * a[i]
        right[i] = scheme.alpha_f * old_force[i]
    for d in range(7):
        shift = d - 3
        for i in range(max(0, -shift), n - max(0, shift)):
            right[i] -= (
                scheme.alpha_m * ops.mass[d, i] * a[i + shift]
                + ops.stiffness[d, i] * blend[i + shift]
            )


@njit(**OPTIONS)
def predict_slabs(scheme, motion, old_force, stiffness, damping, right):
    """As `predict_rail`, for all slabs of one family (slab, mode)."""
    u, v, a = motion[0], motion[1], motion[2]
    dt, alpha = scheme.step, scheme.alpha_f
    for s in range(u.shape[0]):
        for m in range(u.shape[1]):
            up = u[s, m] + dt * v[s, m] + dt * dt * (0.5 - scheme.beta) * a[s, m]
            vp = v[s, m] + dt * (1 - scheme.gamma) * a[s, m]
            right[s, m] = (
                alpha * old_force[s, m]
                - scheme.alpha_m * a[s, m]
                - damping[m] * ((1 - alpha) * vp + alpha * v[s, m])
                - stiffness[m] * ((1 - alpha) * up + alpha * u[s, m])
            )
            u[s, m] = up
            v[s, m] = vp


@njit(**OPTIONS)
def free_pad_forces(ops, scheme, family, rail, rail_free, slab, slab_right):
    """Pad forces at the end of the step if the wheels did not press."""
    bu, gu = scheme.beta * scheme.step**2, scheme.gamma * scheme.step
    k, c = ops.pad_stiffness, ops.pad_damping
    mixed = k * slab[0] + c * slab[1] + (k * bu + c * gu) * slab_right * ops.slab_inverse[family]
    below = np.dot(mixed, np.ascontiguousarray(ops.seat_shape[family].T)).ravel()
    drive = np.empty(len(ops.pad_dofs))
    for p in range(len(drive)):
        i = ops.pad_dofs[p]
        drive[p] = (
            k * (rail[0, i] + bu * rail_free[i]) + c * (rail[1, i] + gu * rail_free[i]) - below[p]
        )
    return np.dot(ops.pad_solver[family], drive)


@njit(**OPTIONS)
def move_columns(ops, scheme, columns, wheel, first):
    """Set up the responses for the element that a wheel has come to."""
    columns.first[wheel] = first
    for a in range(4):
        column, row = columns.rail[wheel, a], 4 * wheel + a
        column[:] = 0.0
        column[first + a] = 1.0
        solve_factored(ops.lower, ops.inverse_diagonal, column)
        columns.at_pads[row] = column[ops.pad_dofs]
        for f in range(len(ops.pad_solver)):
            columns.pad_force[f, row] = ops.pad_gain * np.dot(
                ops.pad_solver[f], columns.at_pads[row]
            )
    gain = scheme.beta * scheme.step**2 * (1 - scheme.alpha_f)
    for f in range(len(ops.pad_solver)):
        for i in range(len(columns.at_pads)):
            for a in range(4):
                row = 4 * wheel + a
                direct = columns.rail[wheel, a, columns.first[i // 4] + i % 4]
                value = gain * (direct - np.dot(columns.at_pads[i], columns.pad_force[f, row]))
                columns.compliance[f, i, row] = value
                columns.compliance[f, row, i] = value


@njit(**OPTIONS)
def contact_compliance(ops, weights, columns, vehicle_compliance, local):
    """Approach of wheel and rail in m per N of wheel force (contact, contact)."""
    sides = len(ops.family_sign)
    wheels = len(weights)
    total = vehicle_compliance.copy()
    for i in range(wheels):
        for j in range(wheels):
            for f in range(sides):
                block = columns.compliance[f, 4 * i : 4 * i + 4, 4 * j : 4 * j + 4]
                value = 0.0
                for a in range(4):
                    for b in range(4):
                        value += weights[i, a] * block[a, b] * weights[j, b]
                for s in range(sides):
                    for t in range(sides):
                        sign = ops.family_sign[s, f] * ops.family_sign[t, f]
                        total[i * sides + s, j * sides + t] += sign * value / sides
        for s in range(sides):
            total[i * sides + s, i * sides + s] += local[i]
    return total


@njit(**OPTIONS)
def solve_contact(free_approach, compliance, hertz_constant, penetration):
    """Penetrations with ``penetration + compliance @ force(penetration) = free_approach``."""
    count = len(free_approach)
    force = np.zeros(count)
    for _ in range(50):
        jacobian = np.eye(count)
        for c in range(count):
            ratio = max(penetration[c], 0.0) / hertz_constant
            force[c] = ratio * np.sqrt(ratio)
            jacobian[:, c] += compliance[:, c] * (1.5 * np.sqrt(ratio) / hertz_constant)
        residual = free_approach - penetration - np.dot(compliance, force)
        change = np.linalg.solve(jacobian, residual)
        penetration += change
        if np.abs(change).max() < 1e-15:
            break
    for c in range(count):
        ratio = max(penetration[c], 0.0) / hertz_constant
        force[c] = ratio * np.sqrt(ratio)
    return force


@njit(**OPTIONS)
def predict_vehicle(vehicle, scheme, state):
    """Turn the vehicle's state into predictors; return its step without new wheel forces."""
    dt, alpha = scheme.step, scheme.alpha_f
    z, v, a = state.body[0].copy(), state.body[1].copy(), state.body[2].copy()
    state.body[0] = z + dt * v + dt * dt * (0.5 - scheme.beta) * a
    state.body[1] = v + dt * (1 - scheme.gamma) * a
    right = vehicle.load - scheme.alpha_m * np.dot(vehicle.mass, a)
    right -= alpha * vehicle.multiplicity * np.dot(vehicle.contact.T, state.force)
    right -= np.dot(vehicle.damping, (1 - alpha) * state.body[1] + alpha * v)
    right -= np.dot(vehicle.stiffness, (1 - alpha) * state.body[0] + alpha * z)
    return np.dot(vehicle.inverse, right)


@njit(**OPTIONS)
def wheel_shapes(ops, scheme, columns, positions):
    """Rail shapes under each wheelset; sets up columns where a new element begins."""
    wheels, h = len(positions), ops.element_length
    weights, slopes = np.zeros((wheels, 4)), np.zeros((wheels, 4))
    local, local_slope = np.zeros(wheels), np.zeros(wheels)
    for w in range(wheels):
        element = int(positions[w] / h)
        if columns.first[w] != 2 * element:
            move_columns(ops, scheme, columns, w, 2 * element)
        x = positions[w] - element * h
        for a in range(4):
            c = ops.shapes[:, a]
            weights[w, a] = c[0] + x * (c[1] + x * (c[2] + x * c[3]))
            slopes[w, a] = c[1] + x * (2 * c[2] + 3 * x * c[3])
        local[w] = local_compliance(x, h, ops.bending_stiffness, ops.shear_stiffness)
        low, high = max(x - 1e-5 * h, 0.0), min(x + 1e-5 * h, h)
        rise = local_compliance(high, h, ops.bending_stiffness, ops.shear_stiffness)
        rise -= local_compliance(low, h, ops.bending_stiffness, ops.shear_stiffness)
        local_slope[w] = rise / (high - low)
    return Footing(weights, slopes, local, local_slope)


@njit(**OPTIONS)
def correct_track(ops, scheme, state, family, work):
    """Finish one family's step with all interface forces known."""
    bu, gu = scheme.beta * scheme.step**2, scheme.gamma * scheme.step
    pad_force, nodal = work.pad_force[family], work.nodal[family]
    for p in range(len(pad_force)):
        nodal[ops.pad_dofs[p]] -= pad_force[p]
    state.rail_force[family] = nodal
    acceleration = state.rail[2, family]
    acceleration[:] = work.right[family] + (1 - scheme.alpha_f) * nodal
    solve_factored(ops.lower, ops.inverse_diagonal, acceleration)
    state.rail[0, family] += bu * acceleration
    state.rail[1, family] += gu * acceleration
    seats = ops.seat_shape[family].shape[0]
    modal = np.dot(pad_force.reshape((-1, seats)), ops.seat_shape[family])
    state.slab_force[family] = modal
    motion = work.slab_right[family] + (1 - scheme.alpha_f) * modal
    motion *= ops.slab_inverse[family]
    state.slab[2, family] = motion
    state.slab[0, family] += bu * motion
    state.slab[1, family] += gu * motion


@njit(**OPTIONS)
def dissipation(ops, vehicle, state):
    """Power lost in pads, CAM and suspensions, in W, counted per modelled wheel pair."""
    sides = len(ops.family_sign)
    total = 0.0
    for f in range(sides):
        seats = np.dot(state.slab[1, f], np.ascontiguousarray(ops.seat_shape[f].T)).ravel()
        stroke_rate = state.rail[1, f][ops.pad_dofs] - seats
        total += ops.pad_damping * np.dot(stroke_rate, stroke_rate)
        for s in range(state.slab.shape[2]):
            total += np.sum(ops.slab_damping[f] * state.slab[1, f, s] ** 2)
    total *= vehicle.multiplicity * sides
    return total + np.dot(state.body[1], np.dot(vehicle.damping, state.body[1]))


@njit(**OPTIONS)
def advance_freely(ops, scheme, state, columns, footing, work, approach):
    """Predict the track without new wheel forces; take the rails off the wheels' approach."""
    bu, sides = scheme.beta * scheme.step**2, len(ops.family_sign)
    for f in range(sides):
        rail, slab, free = state.rail[:, f], state.slab[:, f], work.free[f]
        predict_rail(ops, scheme, rail, state.rail_force[f], work.blend, work.right[f])
        stiffness, damping = ops.slab_stiffness[f], ops.slab_damping[f]
        slab_right = work.slab_right[f]
        predict_slabs(scheme, slab, state.slab_force[f], stiffness, damping, slab_right)
        free[:] = work.right[f]
        solve_factored(ops.lower, ops.inverse_diagonal, free)
        work.pad_force[f] = free_pad_forces(ops, scheme, f, rail, free, slab, slab_right)
        for w in range(len(footing.weights)):
            height = 0.0
            for a in range(4):
                i = columns.first[w] + a
                pads = np.dot(columns.at_pads[4 * w + a], work.pad_force[f])
                moved = rail[0, i] + bu * (free[i] - (1 - scheme.alpha_f) * pads)
                height += footing.weights[w, a] * moved
            for s in range(sides):
                approach[w * sides + s] -= ops.family_sign[s, f] * height


@njit(**OPTIONS)
def press_track(ops, scheme, state, columns, footing, work, force):
    """Finish the track's step under the wheel forces found."""
    sides = len(ops.family_sign)
    work.nodal[:] = 0.0
    for f in range(sides):
        for w in range(len(footing.weights)):
            load = 0.0
            for s in range(sides):
                load += ops.family_sign[s, f] * force[w * sides + s] / sides
            for a in range(4):
                share = footing.weights[w, a] * load
                work.nodal[f, columns.first[w] + a] += share
                work.pad_force[f] += share * columns.pad_force[f, 4 * w + a]
        correct_track(ops, scheme, state, f, work)


@njit(**OPTIONS)
def observe(ops, vehicle, state, columns, footing, speed, record, row):
    """Fill a row of the record from the state at its instant."""
    sides, force = len(ops.family_sign), state.force
    record.force[row] = force
    record.body[row] = state.body[0]
    # Balance of forces: the scheme's own accelerations hold only in the mean over a step.
    resultant = vehicle.load - vehicle.multiplicity * np.dot(vehicle.contact.T, force)
    resultant -= np.dot(vehicle.damping, state.body[1])
    resultant -= np.dot(vehicle.stiffness, state.body[0])
    record.body_acceleration[row] = np.dot(vehicle.inverse_mass, resultant)
    for c in range(len(force)):
        w, s = c // sides, c % sides
        height, slope = footing.local[w] * force[c], 0.5 * footing.local_slope[w] * force[c]
        for f in range(sides):
            for a in range(4):
                u = ops.family_sign[s, f] * state.rail[0, f, columns.first[w] + a]
                height += footing.weights[w, a] * u
                slope += footing.slopes[w, a] * u
        record.deflection[row, c] = height
        record.power[row, 1] -= vehicle.multiplicity * speed * force[c] * slope


@njit(**OPTIONS)
def run(ops, vehicle, scheme, state, columns, start, speed, record, with_power):
    """Advance from the state given through all rows of the record; row 0 is the start."""
    sides, n = len(ops.family_sign), state.rail.shape[2]
    bu, gu = scheme.beta * scheme.step**2, scheme.gamma * scheme.step
    gain = vehicle.multiplicity * (1 - scheme.alpha_f)
    body_response = gain * np.dot(vehicle.inverse, np.ascontiguousarray(vehicle.contact.T))
    vehicle_compliance = bu * np.dot(vehicle.contact, body_response)
    work = Workspace(
        np.zeros((sides, n)),
        np.zeros((sides, n)),
        np.zeros(n),
        np.zeros(state.slab.shape[1:]),
        np.zeros((sides, len(ops.pad_dofs))),
        np.zeros((sides, n)),
    )
    for row in range(1, len(record.force)):
        footing = wheel_shapes(ops, scheme, columns, start + speed * scheme.step * row)
        body_free = predict_vehicle(vehicle, scheme, state)
        approach = np.dot(vehicle.contact, state.body[0] + bu * body_free)
        advance_freely(ops, scheme, state, columns, footing, work, approach)
        compliance = contact_compliance(
            ops, footing.weights, columns, vehicle_compliance, footing.local
        )
        state.force[:] = solve_contact(
            approach, compliance, vehicle.hertz_constant, state.penetration
        )
        press_track(ops, scheme, state, columns, footing, work, state.force)
        state.body[2] = body_free - np.dot(body_response, state.force)
        state.body[0] += bu * state.body[2]
        state.body[1] += gu * state.body[2]
        observe(ops, vehicle, state, columns, footing, speed, record, row)
        if with_power:
            record.power[row, 0] = dissipation(ops, vehicle, state)
