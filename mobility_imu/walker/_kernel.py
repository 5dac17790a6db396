"""The filter and smoother of :mod:`mobility_imu.walker.eskf` in compiled loops.

One file, since numba knows by the file's date when kept machine code is out of date.

Layout. A state is a row of 16 numbers, the error state has 15 in the order of eq. 23::

    states[k]  | q q q q | r r r | v v v | b_g b_g b_g | b_a b_a b_a |    k = 0 ... n
                           POS     VEL     GYR           ACC
                 0         4       7       10            13
    error        | half turn | b_g     | r       | v       | b_a     | 0 |
                               D_GYR     D_POS     D_VEL     D_ACC
                   0 .. 2      3 .. 5    6 .. 8    9 .. 11   12 .. 14  15

A matrix lies flat, 15 rows of 16 numbers (the last is 0): element (i, j) is at 16 i + j, the
diagonal at 17 i. Only with this constant does the compiler see that a row fits its registers, which
makes the loops six times faster than those over (15, 15) arrays. The transition of one sample, with
unit matrices 1, empty blocks zero, and each block where its row and column begin::

    Phi              q        b_g      r        v        b_a
         column      0        D_GYR    D_POS    D_VEL    D_ACC
    row  0        | Phi_qq | Phi_qb |        |        |        |   from   0 on
    row  D_GYR    |        |   1    |        |        |        |         48
    row  D_POS    | Phi_rq | Phi_rb |   1    |  dt 1  | Phi_ra |         96
    row  D_VEL    | Phi_vq | Phi_vb |        |   1    | Phi_va |        144
    row  D_ACC    |        |        |        |        |   1    |        192

Slicing an array (``states[k]``) makes numba count a reference, which costs as much as 30 products;
therefore whole arrays are indexed, and small functions take and return numbers.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from mobility_imu._compiled import compiled
from mobility_imu.frames import STANDARD_GRAVITY_MPS2, FloatArray

Vector = tuple[float, float, float]
Quaternion = tuple[float, float, float, float]
Matrix = tuple[float, float, float, float, float, float, float, float, float]

POS, VEL, GYR, ACC = 4, 7, 10, 13  # in a row of states
D_GYR, D_POS, D_VEL, D_ACC = 3, 6, 9, 12  # in the error state
HEIGHT = D_POS + 2
XY = 15  # in a row of variances, after those of the error state: covariance of x and y
ROW, DIAGONAL, SIZE = 16, 17, 240  # of a flat matrix: from row to row, along the diagonal, numbers
# Order of the noise's squared densities, see eskf.Noise.
N_GYR, N_ACC, N_GYR_WALK, N_ACC_WALK, N_VELOCITY, N_HEIGHT, N_RATE, N_LONG = range(8)
N_SATURATED, N_RATE_SATURATED = 8, 9  # squares of a sample's noise at the end of the range

# A product and the sum after it may be rounded once instead of twice ("contract"), nothing else.
_compiled = compiled(fastmath={"contract"}, error_model="numpy")


def aligned(rows: int) -> FloatArray:
    """Zero matrices aligned to 64 bytes, a cache line, so that vector loads straddle none."""
    memory = np.zeros(rows * 256 + 8)
    first = -memory.ctypes.data // 8 % 8
    return memory[first : first + rows * 256].reshape(rows, 256)


@_compiled
def matrix_of(w: float, x: float, y: float, z: float) -> Matrix:
    """C'(q), IMU to world, row by row (eq. 1 transposed)."""
    return (
        w * w + x * x - y * y - z * z,
        2 * (x * y - w * z),
        2 * (x * z + w * y),
        2 * (x * y + w * z),
        w * w - x * x + y * y - z * z,
        2 * (y * z - w * x),
        2 * (x * z - w * y),
        2 * (y * z + w * x),
        w * w - x * x - y * y + z * z,
    )


@_compiled
def times(a: Quaternion, b: Quaternion) -> Quaternion:
    """Product of two quaternions."""
    return (
        a[0] * b[0] - a[1] * b[1] - a[2] * b[2] - a[3] * b[3],
        a[0] * b[1] + a[1] * b[0] + a[2] * b[3] - a[3] * b[2],
        a[0] * b[2] - a[1] * b[3] + a[2] * b[0] + a[3] * b[1],
        a[0] * b[3] + a[1] * b[2] - a[2] * b[1] + a[3] * b[0],
    )


@_compiled
def half_turn(p: Vector) -> Quaternion:
    """Quaternion of half the rotation vector p."""
    square = (p[0] * p[0] + p[1] * p[1] + p[2] * p[2]) / 16
    if square < 1e-3:  # the series' next terms are below rounding
        c = 1 - square * (1 / 2 - square * (1 / 24 - square * (1 / 720 - square * (1 / 40320))))
        s = 1 / 4 - square * (1 / 24 - square * (1 / 480 - square * (1 / 20160)))
    else:
        angle = np.sqrt(square)
        c, s = np.cos(angle), np.sin(angle) / (4 * angle)
    return c, s * p[0], s * p[1], s * p[2]


@_compiled
def row_times_cross(a: Vector, v: Vector) -> Vector:
    """The row a [v x]."""
    return a[1] * v[2] - a[2] * v[1], a[2] * v[0] - a[0] * v[2], a[0] * v[1] - a[1] * v[0]


@_compiled
def row_times(a: Vector, m: Matrix) -> Vector:
    """The row a times a 3 x 3 matrix."""
    return (
        a[0] * m[0] + a[1] * m[3] + a[2] * m[6],
        a[0] * m[1] + a[1] * m[4] + a[2] * m[7],
        a[0] * m[2] + a[1] * m[5] + a[2] * m[8],
    )


@_compiled
def strapdown(
    states: FloatArray, k: int, acc: FloatArray, gyr: FloatArray, dt: float, fraction: float
) -> tuple[Vector, Quaternion, Vector, Matrix]:
    """State k + 1 from state k and sample k (eqs 20 and 21).

    Returned are the rotation vector p, the quaternion of p / 2, the force f = o_a - b_a and C'(q)
    in the middle of the interval.
    """
    p = (
        (gyr[k, 0] - states[k, GYR]) * fraction * dt,
        (gyr[k, 1] - states[k, GYR + 1]) * fraction * dt,
        (gyr[k, 2] - states[k, GYR + 2]) * fraction * dt,
    )
    f = (acc[k, 0] - states[k, ACC], acc[k, 1] - states[k, ACC + 1], acc[k, 2] - states[k, ACC + 2])
    half = half_turn(p)
    middle = times((states[k, 0], states[k, 1], states[k, 2], states[k, 3]), half)
    r = matrix_of(middle[0], middle[1], middle[2], middle[3])
    q = times(middle, half)
    # The length is 1 but for rounding: a step of Newton's method divides by it.
    scale = (3 - (q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3])) / 2
    for i in range(4):
        states[k + 1, i] = q[i] * scale
    gain = (
        dt * (r[0] * f[0] + r[1] * f[1] + r[2] * f[2]),
        dt * (r[3] * f[0] + r[4] * f[1] + r[5] * f[2]),
        dt * (r[6] * f[0] + r[7] * f[1] + r[8] * f[2] - STANDARD_GRAVITY_MPS2),
    )
    for i in range(3):
        states[k + 1, POS + i] = states[k, POS + i] + dt * (states[k, VEL + i] + gain[i] / 2)
        states[k + 1, VEL + i] = states[k, VEL + i] + gain[i]
    for i in range(GYR, 16):
        states[k + 1, i] = states[k, i]
    return p, half, f, r


@_compiled
def strapdown_path(
    acc: FloatArray, gyr: FloatArray, still: NDArray[np.bool_], dt: FloatArray, states: FloatArray
) -> None:
    """States without a filter; the velocity is set to 0 where the frame is still."""
    for k in range(len(acc)):
        strapdown(states, k, acc, gyr, dt[k], 1.0)
        if still[k]:
            states[k + 1, VEL], states[k + 1, VEL + 1], states[k + 1, VEL + 2] = 0.0, 0.0, 0.0


@_compiled
def step(
    states: FloatArray, k: int, acc: FloatArray, gyr: FloatArray, dt: float, fraction: float,
    sign: float, coupling: float, phi: FloatArray,
) -> None:  # fmt: skip
    """As ``strapdown``, with Phi (eq. 24 over one interval): see eskf.strapdown_step."""
    p, half, f, r = strapdown(states, k, acc, gyr, dt, fraction)
    back = matrix_of(half[0], -half[1], -half[2], -half[3])  # R(p / 2)'
    bias_gain = sign * 0.5 * fraction * dt
    for i in range(3):
        # Phi_qq = R(p)'
        row = row_times((back[3 * i], back[3 * i + 1], back[3 * i + 2]), back)
        phi[ROW * i], phi[ROW * i + 1], phi[ROW * i + 2] = row
        # Phi_qb = bias_gain (1 - [p x] / 2 + [p x]² / 6)
        one = (1.0 if i == 0 else 0.0, 1.0 if i == 1 else 0.0, 1.0 if i == 2 else 0.0)
        once = row_times_cross(one, p)
        twice = row_times_cross(once, p)
        # Rows of -2 dt C'(q) [f x], which acts at the middle of the interval.
        tilt = row_times_cross((r[3 * i], r[3 * i + 1], r[3 * i + 2]), f)
        tilt = -2 * dt * tilt[0], -2 * dt * tilt[1], -2 * dt * tilt[2]
        from_tilt = row_times(tilt, back)  # Phi_vq
        turned = row_times_cross(tilt, p)
        v_row, r_row, h = ROW * (D_VEL + i), ROW * (D_POS + i), dt / 2
        for j in range(3):
            phi[ROW * i + D_GYR + j] = bias_gain * (one[j] - once[j] / 2 + twice[j] / 6)
            from_gyr = bias_gain / 2 * (tilt[j] - turned[j] / 4)  # Phi_vb
            from_acc = -coupling * dt * r[3 * i + j]  # Phi_va
            phi[v_row + j], phi[v_row + D_GYR + j], phi[v_row + D_ACC + j] = (
                from_tilt[j], from_gyr, from_acc
            )  # fmt: skip
            # What the velocity gains, the position gains by half the interval.
            phi[r_row + j], phi[r_row + D_GYR + j], phi[r_row + D_ACC + j] = (
                h * from_tilt[j], h * from_gyr, h * from_acc
            )  # fmt: skip
        phi[r_row + D_VEL + i] = dt


@_compiled
def identity(out: FloatArray) -> None:
    """The unit matrix."""
    for i in range(SIZE):
        out[i] = 0.0
    for i in range(15):
        out[DIAGONAL * i] = 1.0


@_compiled
def multiply(a: FloatArray, b: FloatArray, out: FloatArray) -> None:
    """Product a b, three rows at a time: b is read once for them."""
    for k in range(0, SIZE, 3 * ROW):
        for j in range(ROW):
            x, y, z = a[k] * b[j], a[k + ROW] * b[j], a[k + 2 * ROW] * b[j]
            for m in range(1, 15):
                x += a[k + m] * b[ROW * m + j]
                y += a[k + ROW + m] * b[ROW * m + j]
                z += a[k + 2 * ROW + m] * b[ROW * m + j]
            out[k + j], out[k + ROW + j], out[k + 2 * ROW + j] = x, y, z


@_compiled
def transpose(a: FloatArray, out: FloatArray) -> None:
    """Transposed matrix."""
    for i in range(15):
        for j in range(15):
            out[ROW * i + j] = a[ROW * j + i]


@_compiled
def sandwich(a: FloatArray, p: FloatArray, work: FloatArray, other: FloatArray) -> None:
    """Replace a symmetric p by a p a' = a (a p)'."""
    multiply(a, p, work)
    transpose(work, other)
    multiply(a, other, p)


@_compiled
def symmetrise(p: FloatArray) -> None:
    """Take out the unsymmetric part that rounding leaves; the updates would let it grow."""
    for i in range(15):
        for j in range(i):
            p[ROW * j + i] = p[ROW * i + j]


@_compiled
def times_vector(p: FloatArray, v: FloatArray, out: FloatArray) -> None:
    """Product of a symmetric matrix and a vector."""
    for j in range(ROW):
        out[j] = 0.0
    for i in range(15):
        for j in range(ROW):
            out[j] += v[i] * p[ROW * i + j]


@_compiled
def correct(states: FloatArray, k: int, error: FloatArray) -> None:
    """Take an error off a state (eqs 22 and 23 solved for the true state)."""
    q = times((states[k, 0], states[k, 1], states[k, 2], states[k, 3]),
              (1.0, error[0], error[1], error[2]))  # fmt: skip
    scale = 1 / np.sqrt(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3])
    for i in range(4):
        states[k, i] = q[i] * scale
    for i in range(3):
        states[k, GYR + i] += error[D_GYR + i]
        states[k, POS + i] += error[D_POS + i]
        states[k, VEL + i] += error[D_VEL + i]
        states[k, ACC + i] += error[D_ACC + i]


@_compiled
def add_noise(
    p: FloatArray, noise: FloatArray, acc: float, gyr: float, h: float, samples: int
) -> None:
    """P + Q of a stride, see eskf.process_noise; acc and gyr are the sensors' squared densities."""
    position = acc * h * h * h * (1 / 3 - 1 / (12 * samples**2))
    for i in range(3):
        p[DIAGONAL * i] += gyr / 4 * h
        p[DIAGONAL * (D_GYR + i)] += noise[N_GYR_WALK] * h
        p[DIAGONAL * (D_POS + i)] += position
        p[ROW * (D_POS + i) + D_VEL + i] += acc * h * h / 2
        p[ROW * (D_VEL + i) + D_POS + i] += acc * h * h / 2
        p[DIAGONAL * (D_VEL + i)] += acc * h
        p[DIAGONAL * (D_ACC + i)] += noise[N_ACC_WALK] * h


@_compiled
def zero_updates(
    states: FloatArray, begin: int, end: int, h: float, gyr: FloatArray, observed: FloatArray,
    noise: FloatArray, zero_rate: bool, upright: bool, g: int, innovations: FloatArray,
    weights: FloatArray,
) -> None:  # fmt: skip
    """Innovations z of stride g and their weights 1 / R, by state, see eskf.zero_updates."""
    height = 0.0
    for k in range(begin, end):
        height += observed[k if len(observed) > 1 else 0, 3] / (end - begin)
    if upright:
        innovations[g, HEIGHT] = height - states[end, POS + 2]
        weights[g, HEIGHT] = h / noise[N_HEIGHT]
    for i in range(3):
        rate, velocity = 0.0, 0.0
        for k in range(begin, end):
            rate += gyr[k, i] / (end - begin)
            velocity += observed[k if len(observed) > 1 else 0, i] / (end - begin)
        innovations[g, D_VEL + i] = velocity - states[end, VEL + i]
        weights[g, D_VEL + i] = h / noise[N_VELOCITY]
        if zero_rate:
            innovations[g, D_GYR + i] = rate - states[end, GYR + i]
            weights[g, D_GYR + i] = h / (noise[N_RATE] + noise[N_GYR])


@_compiled
def observe(
    p: FloatArray, error: FloatArray, row: FloatArray, i: int, innovation: float, weight: float
) -> float:
    """Update by an observation of the single state i with variance 1 / weight.

    Observations with independent noise may be used one after the other: the first correct the
    error, and with it the innovation of those that follow. Returned is the innovation squared over
    its variance.
    """
    left = innovation - error[i]
    variance: float = p[DIAGONAL * i] + 1 / weight  # S
    for j in range(ROW):
        row[j] = p[ROW * i + j]
    for j in range(ROW):
        error[j] += row[j] * (left / variance)  # K times what is left of the innovation
    for k in range(15):
        gain = row[k] / variance
        for j in range(ROW):
            p[ROW * k + j] -= gain * row[j]
    nis: float = left * left / variance
    return nis


@_compiled
def run_filter(
    acc: FloatArray, gyr: FloatArray, still: NDArray[np.bool_], long_move: NDArray[np.bool_],
    saturated: NDArray[np.bool_], rate_saturated: NDArray[np.bool_],
    observed: FloatArray, dt: FloatArray, ends: NDArray[np.int64], noise: FloatArray,
    zero_rate: bool, sign: float, coupling: float, upright_cos: float, work: FloatArray,
    states: FloatArray, covariances: FloatArray, transitions: FloatArray, innovations: FloatArray,
    weights: FloatArray, errors: FloatArray, nis: FloatArray, nis_dof: NDArray[np.int64],
) -> None:  # fmt: skip
    """Filter all strides, see eskf.run_filter.

    Row 0 of states and covariances is the start. Of stride g the smoother needs P after it (row
    g + 1), Phi and, by state, the innovations z, their weights 1 / R (0: not observed) and K z.
    """
    p, phi, one, other, spare = work[0], work[1], work[2], work[3], work[4]
    error, row = work[5], work[6]
    for i in range(SIZE):
        p[i] = covariances[0, i]
    identity(one)
    up = matrix_of(states[0, 0], states[0, 1], states[0, 2], states[0, 3])
    begin = 0
    for g in range(len(ends)):
        end, rest, h = ends[g], still[begin], 0.0
        fraction = 1.0
        if rest and zero_rate:
            fraction = noise[N_RATE] / (noise[N_RATE] + noise[N_GYR])
        identity(phi)
        for k in range(begin, end):
            h += dt[k]
            if k == begin:
                step(states, k, acc, gyr, dt[k], fraction, sign, coupling, phi)
            else:
                step(states, k, acc, gyr, dt[k], fraction, sign, coupling, one)
                multiply(one, phi, other)
                for i in range(SIZE):
                    phi[i] = other[i]
        sandwich(phi, p, other, spare)
        symmetrise(p)
        more = noise[N_LONG] if long_move[begin] else 1.0
        force = noise[N_SATURATED] * h if saturated[begin] else noise[N_ACC] * more
        rate = noise[N_GYR] * (fraction * more)
        if rate_saturated[begin]:
            rate = noise[N_RATE_SATURATED] * h
        add_noise(p, noise, force, rate, h, end - begin)
        if rest:
            now = matrix_of(states[end, 0], states[end, 1], states[end, 2], states[end, 3])
            upright = now[6] * up[6] + now[7] * up[7] + now[8] * up[8] > upright_cos
            zero_updates(states, begin, end, h, gyr, observed, noise, zero_rate, upright,
                         g, innovations, weights)  # fmt: skip
            for i in range(ROW):
                error[i] = 0.0
            for i in range(D_GYR, D_ACC):
                if weights[g, i] > 0:
                    nis[end - 1] += observe(p, error, row, i, innovations[g, i], weights[g, i])
                    nis_dof[end - 1] += 1
            correct(states, end, error)
            for i in range(15):
                errors[g, i] = error[i]
        for i in range(SIZE):
            covariances[g + 1, i] = p[i]
            transitions[g, i] = phi[i]
        begin = end


@_compiled
def back_over_update(
    p: FloatArray, before: FloatArray, innovations: FloatArray, weights: FloatArray, g: int,
    mu: FloatArray, big_lambda: FloatArray, work: FloatArray,
) -> None:  # fmt: skip
    """Take mu and Lambda back: mu + D (z - K z - P mu), C' Lambda C + D - D P D, C' = 1 - D P.

    D holds the weights 1 / R on its diagonal. With P after the update K H = P D, and H' S⁻¹ H =
    D - D P D: what eskf.back_over_update computes, without an inverse. before is K z + P mu.
    """
    c_back = work[3]
    identity(c_back)
    for i in range(15):
        weight = weights[g, i]
        mu[i] += weight * (innovations[g, i] - before[i])
        for j in range(15):
            c_back[ROW * i + j] -= weight * p[ROW * i + j]
    sandwich(c_back, big_lambda, work[4], work[5])
    for i in range(15):
        for j in range(15):
            big_lambda[ROW * i + j] += c_back[ROW * i + j] * weights[g, j]


@_compiled
def back_over_step(
    phi: FloatArray, mu: FloatArray, big_lambda: FloatArray, work: FloatArray
) -> None:
    """Phi' mu and Phi' Lambda Phi."""
    back, changed = work[3], work[9]
    for i in range(ROW):
        changed[i] = 0.0
    for k in range(15):
        for i in range(ROW):
            changed[i] += phi[ROW * k + i] * mu[k]
    for i in range(ROW):
        mu[i] = changed[i]
    transpose(phi, back)
    sandwich(back, big_lambda, work[4], work[5])
    symmetrise(big_lambda)


@_compiled
def run_smoother(
    ends: NDArray[np.int64], covariances: FloatArray, transitions: FloatArray,
    innovations: FloatArray, weights: FloatArray, errors: FloatArray, mu_last: FloatArray,
    lambda_last: FloatArray, work: FloatArray, states: FloatArray, variances: FloatArray,
) -> None:  # fmt: skip
    """Smooth all strides from the last to the first, see eskf.run_smoother; states in place."""
    p, phi, big_lambda, lambda_p = work[0], work[1], work[2], work[3]
    mu, error, before, between = work[6], work[7], work[8], work[9]
    for i in range(15):
        mu[i] = mu_last[i]
    for i in range(SIZE):
        big_lambda[i] = lambda_last[i]
    for g in range(len(ends), -1, -1):
        for i in range(SIZE):
            p[i] = covariances[g, i]
        end = ends[g - 1] if g > 0 else 0
        times_vector(p, mu, error)  # smoothed error P mu
        correct(states, end, error)
        if g < len(ends):
            for k in range(end + 1, ends[g]):
                later = (k - end) / (ends[g] - end)
                for i in range(15):
                    between[i] = (1 - later) * error[i] + later * before[i]
                correct(states, k, between)
        multiply(big_lambda, p, lambda_p)
        for i in range(15):  # diagonal of P - P Lambda P
            variances[g, i] = p[DIAGONAL * i]
        for k in range(15):
            for i in range(15):
                variances[g, i] -= p[ROW * k + i] * lambda_p[ROW * k + i]
        variances[g, XY] = p[ROW * D_POS + D_POS + 1]
        for k in range(15):
            variances[g, XY] -= p[ROW * k + D_POS] * lambda_p[ROW * k + D_POS + 1]
        if g == 0:
            break
        observed = False
        for i in range(15):
            before[i] = error[i] + errors[g - 1, i]
            observed |= weights[g - 1, i] > 0
        if observed:
            back_over_update(p, before, innovations, weights, g - 1, mu, big_lambda, work)
        for i in range(SIZE):
            phi[i] = transitions[g - 1, i]
        back_over_step(phi, mu, big_lambda, work)
