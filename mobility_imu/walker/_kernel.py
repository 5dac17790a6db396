"""The compiled loops of :mod:`mobility_imu.walker.navigation`: strapdown, filter and smoother.

A state has 16 numbers: attitude, position, velocity, biases of gyroscope and accelerometer. The
error state has 15, in the order of eq. 23: there the position comes third and the velocity fourth.

The state is integrated at every sample. The covariance P goes in strides of one or more samples: it
needs the product of their transitions, and is stored at their ends. Where the frame is still, a
stride ends with an update. Going back, the smoother knows what all later updates say of the state
(mu) and how surely (big, a matrix of information): between updates both only go through the
transposed transition. With P after an update, the smoothed error is P mu and its covariance
P - P big P. (Bryson and Frazier's form; Rauch, Tung and Striebel's needs an inverse per step.)
"""

from __future__ import annotations

import numpy as np
from numba import njit

from mobility_imu.frames import STANDARD_GRAVITY_MPS2, FloatArray

# Where the sensor was cut off, this much noise (m/s² per sample) says that nothing is known.
CUT_ACC_SD_MPS2 = 20.0
# Numbers of the transition of one sample, and of a stride of several.
STEP, CHAIN = 45, 72


def aligned(rows: int, columns: int) -> FloatArray:
    """Zeros that begin where a line of the cache does: twice as fast to load in whole vectors."""
    room = np.zeros(rows * columns + 8)
    first = -room.ctypes.data // 8 % 8
    return room[first : first + rows * columns].reshape(rows, columns)


# A product and the sum after it may be rounded once instead of twice ("contract"), nothing else.
_compiled = njit(cache=True, fastmath={"contract"})

# A view of an array, such as states[k], costs as much as thirty products, for it is counted: hence
# whole arrays with an index, and tuples.


@_compiled
def _matrix(w, x, y, z):
    """Quaternion to matrix, IMU to world, row by row."""
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
def _product(w0, w1, w2, w3, c, x, y, z):
    """Product of two quaternions."""
    return (
        w0 * c - w1 * x - w2 * y - w3 * z,
        w0 * x + w1 * c + w2 * z - w3 * y,
        w0 * y - w1 * z + w2 * c + w3 * x,
        w0 * z + w1 * y - w2 * x + w3 * c,
    )


@_compiled
def _from_vector(v1, v2, v3):
    """Quaternion of a rotation vector."""
    square = (v1 * v1 + v2 * v2 + v3 * v3) / 4
    if square < 1e-3:  # the next terms are below rounding
        c = 1 - square * (1 / 2 - square * (1 / 24 - square * (1 / 720 - square * (1 / 40320))))
        s = 1 / 2 - square * (1 / 12 - square * (1 / 240 - square * (1 / 10080)))
        return c, s * v1, s * v2, s * v3
    half = np.sqrt(square)
    s = np.sin(half) / (2 * half)
    return np.cos(half), s * v1, s * v2, s * v3


@_compiled
def _move(states, k, acc, gyr, dt, share):
    """State k over the interval of sample k; it becomes state k + 1.

    share is how much of the measured rate is taken for motion. Given back are the turn, the
    quaternion of its half, the force and the attitude in the middle.
    """
    p1 = (gyr[k, 0] - states[k, 10]) * share * dt
    p2 = (gyr[k, 1] - states[k, 11]) * share * dt
    p3 = (gyr[k, 2] - states[k, 12]) * share * dt
    f1, f2, f3 = acc[k, 0] - states[k, 13], acc[k, 1] - states[k, 14], acc[k, 2] - states[k, 15]
    half = _from_vector(p1 / 2, p2 / 2, p3 / 2)
    hc, hx, hy, hz = half
    m0, m1, m2, m3 = _product(
        states[k, 0], states[k, 1], states[k, 2], states[k, 3], hc, hx, hy, hz
    )
    r = _matrix(m0, m1, m2, m3)
    m0, m1, m2, m3 = _product(m0, m1, m2, m3, hc, hx, hy, hz)
    # The length is 1 but for rounding: a step of Newton's method divides by it.
    scale = (3 - (m0 * m0 + m1 * m1 + m2 * m2 + m3 * m3)) / 2
    n = k + 1
    states[n, 0], states[n, 1], states[n, 2], states[n, 3] = (
        m0 * scale, m1 * scale, m2 * scale, m3 * scale
    )  # fmt: skip
    g1 = dt * (r[0] * f1 + r[1] * f2 + r[2] * f3)
    g2 = dt * (r[3] * f1 + r[4] * f2 + r[5] * f3)
    g3 = dt * (r[6] * f1 + r[7] * f2 + r[8] * f3 - STANDARD_GRAVITY_MPS2)
    v1, v2, v3 = states[k, 7], states[k, 8], states[k, 9]
    states[n, 4] = states[k, 4] + dt * (v1 + g1 / 2)
    states[n, 5] = states[k, 5] + dt * (v2 + g2 / 2)
    states[n, 6] = states[k, 6] + dt * (v3 + g3 / 2)
    states[n, 7], states[n, 8], states[n, 9] = v1 + g1, v2 + g2, v3 + g3
    for i in range(10, 16):
        states[n, i] = states[k, i]
    return (p1, p2, p3), half, (f1, f2, f3), r


@_compiled
def advance(states, k, acc, gyr, dt, share, sign, couple, step):
    """As _move, with the transition: five blocks of 3 x 3, row by row.

    They are: attitude from attitude and gyroscope bias; velocity from attitude, gyroscope and
    accelerometer bias. What the velocity gains, the position gains by half the interval.
    """
    turn, half, force, r = _move(states, k, acc, gyr, dt, share)
    p1, p2, p3 = turn
    hc, hx, hy, hz = half
    m0, m1, m2, m3 = _product(hc, -hx, -hy, -hz, hc, -hx, -hy, -hz)
    qq = _matrix(m0, m1, m2, m3)
    back = _matrix(hc, -hx, -hy, -hz)
    # The bias acts on the attitude through the right Jacobian 1 - [p x] / 2 + [p x]² / 6.
    n = sign * 0.5 * share * dt
    square = p1 * p1 + p2 * p2 + p3 * p3
    s1, s2, s3 = p1 * (1 / 6), p2 * (1 / 6), p3 * (1 / 6)
    left = 1 - square * (1 / 6)
    for i in range(9):
        step[i] = qq[i]
    step[9] = n * (left + s1 * p1)
    step[10] = n * (s1 * p2 + p3 / 2)
    step[11] = n * (s1 * p3 - p2 / 2)
    step[12] = n * (s2 * p1 - p3 / 2)
    step[13] = n * (left + s2 * p2)
    step[14] = n * (s2 * p3 + p1 / 2)
    step[15] = n * (s3 * p1 + p2 / 2)
    step[16] = n * (s3 * p2 - p1 / 2)
    step[17] = n * (left + s3 * p3)
    _velocity_row(step, 0, r[0], r[1], r[2], force, turn, back, dt, n, couple)
    _velocity_row(step, 3, r[3], r[4], r[5], force, turn, back, dt, n, couple)
    _velocity_row(step, 6, r[6], r[7], r[8], force, turn, back, dt, n, couple)


@_compiled
def _velocity_row(step, at, r0, r1, r2, force, turn, back, dt, n, couple):
    """A row of the velocity's blocks. -2 R [f x] acts on the attitude in the interval's middle."""
    f1, f2, f3 = force
    p1, p2, p3 = turn
    a = -2 * dt * (r1 * f3 - r2 * f2)
    b = -2 * dt * (r2 * f1 - r0 * f3)
    c = -2 * dt * (r0 * f2 - r1 * f1)
    step[18 + at] = a * back[0] + b * back[3] + c * back[6]
    step[19 + at] = a * back[1] + b * back[4] + c * back[7]
    step[20 + at] = a * back[2] + b * back[5] + c * back[8]
    step[27 + at] = n / 2 * (a - b * p3 / 4 + c * p2 / 4)
    step[28 + at] = n / 2 * (b + a * p3 / 4 - c * p1 / 4)
    step[29 + at] = n / 2 * (c - a * p2 / 4 + b * p1 / 4)
    step[36 + at], step[37 + at], step[38 + at] = (
        -couple * dt * r0, -couple * dt * r1, -couple * dt * r2
    )  # fmt: skip


@_compiled
def _begin(step, dt, chain):
    """A stride's transition is its first sample's: five blocks, and three for the position.

    They are position from attitude, gyroscope and accelerometer bias.
    """
    for i in range(STEP):
        chain[i] = step[i]
    for i in range(27):
        chain[45 + i] = dt / 2 * step[18 + i]


@_compiled
def _chain(step, dt, chain):
    """Put a sample's transition behind those of its stride."""
    for j in range(3):
        x0, x1, x2 = chain[j], chain[3 + j], chain[6 + j]
        y0, y1, y2 = chain[9 + j], chain[12 + j], chain[15 + j]
        for k in range(j, 9 + j, 3):
            s0, s1, s2 = step[18 + k - j], step[19 + k - j], step[20 + k - j]
            gain = s0 * x0 + s1 * x1 + s2 * x2
            chain[45 + k] += dt * chain[18 + k] + dt / 2 * gain
            chain[18 + k] += gain
            gain = s0 * y0 + s1 * y1 + s2 * y2 + step[27 + k]
            chain[54 + k] += dt * chain[27 + k] + dt / 2 * gain
            chain[27 + k] += gain
            gain = step[36 + k]
            chain[63 + k] += dt * chain[36 + k] + dt / 2 * gain
            chain[36 + k] += gain
            s0, s1, s2 = step[k - j], step[k - j + 1], step[k - j + 2]
            chain[k] = s0 * x0 + s1 * x1 + s2 * x2
            chain[9 + k] = s0 * y0 + s1 * y1 + s2 * y2 + step[9 + k]


@_compiled
def between(states, ends, variance, middle, spread):
    """From the midpoints between the samples to the samples; standard deviations from variances."""
    for k in range(len(middle)):
        for i in range(16):
            middle[k, i] = (states[k, i] + states[k + 1, i]) / 2
        square = 0.0
        for i in range(4):
            square += middle[k, i] * middle[k, i]
        length = np.sqrt(square)
        for i in range(4):
            middle[k, i] /= length
    begin = 0
    for g in range(len(ends)):
        for k in range(begin, ends[g]):
            later = (k + 0.5 - begin) / (ends[g] - begin)
            for i in range(15):
                spread[k, i] = np.sqrt((1 - later) * variance[g, i] + later * variance[g + 1, i])
        begin = ends[g]


@_compiled
def integrate(acc, gyr, still, dt, states):
    """Strapdown alone."""
    for k in range(len(acc)):
        _move(states, k, acc, gyr, dt[k], 1.0)
        if still[k]:
            states[k + 1, 7:10] = 0.0


@_compiled
def interval_means(acc, gyr, dt, force, rate):
    """See :func:`mobility_imu.walker.navigation.interval_means`; force and rate begin as copies.

    No recursion, but compiled: the temporaries of the array form cost a seventh of the filter.
    """
    for k in range(1, len(acc) - 1):
        g0, g1, g2 = gyr[k, 0], gyr[k, 1], gyr[k, 2]
        a0, a1, a2 = acc[k, 0], acc[k, 1], acc[k, 2]
        s0 = (gyr[k + 1, 0] - gyr[k - 1, 0]) / 2
        s1 = (gyr[k + 1, 1] - gyr[k - 1, 1]) / 2
        s2 = (gyr[k + 1, 2] - gyr[k - 1, 2]) / 2
        for i in range(3):
            rate[k, i] += (gyr[k + 1, i] - 2 * gyr[k, i] + gyr[k - 1, i]) / 24
        rate[k, 0] += dt / 12 * (g1 * s2 - g2 * s1)
        rate[k, 1] += dt / 12 * (g2 * s0 - g0 * s2)
        rate[k, 2] += dt / 12 * (g0 * s1 - g1 * s0)
        force[k, 0] -= dt / 8 * (s1 * a2 - s2 * a1)
        force[k, 1] -= dt / 8 * (s2 * a0 - s0 * a2)
        force[k, 2] -= dt / 8 * (s0 * a1 - s1 * a0)


@_compiled
def stride_ends(still, alone, moving, resting):
    """Where strides end; none holds still and moving samples, and some samples stand alone.

    Near the edges of a rest each sample is a stride: there the updates tell most.
    """
    ends = np.empty(len(still), np.int64)
    count, begin = 0, 0
    while begin < len(still):
        stop = begin + 1
        while stop < len(still) and still[stop] == still[begin] and alone[stop] == alone[begin]:
            stop += 1
        k = begin
        while k < stop:
            size = 1
            if not alone[begin]:
                if not still[begin]:
                    size = moving
                elif k >= begin + resting:
                    size = min(resting, max(1, stop - resting - k))
            k = min(k + size, stop)
            ends[count] = k
            count += 1
        begin = stop
    return ends[:count].copy()


# Matrices of the error state lie flat, 16 numbers a row of which the last is 0, 16 rows: only then
# does the compiler see that a row fits its registers. Six times faster than (15, 15) arrays.


@_compiled
def _rows(chain, dt, p, out):
    """Transition of a stride times p."""
    for i in range(0, 9, 3):
        q0, q1, q2 = chain[i], chain[i + 1], chain[i + 2]
        b0, b1, b2 = chain[i + 9], chain[i + 10], chain[i + 11]
        v0, v1, v2 = chain[i + 18], chain[i + 19], chain[i + 20]
        u0, u1, u2 = chain[i + 27], chain[i + 28], chain[i + 29]
        a0, a1, a2 = chain[i + 36], chain[i + 37], chain[i + 38]
        w0, w1, w2 = chain[i + 45], chain[i + 46], chain[i + 47]
        s0, s1, s2 = chain[i + 54], chain[i + 55], chain[i + 56]
        t0, t1, t2 = chain[i + 63], chain[i + 64], chain[i + 65]
        k = 16 * (i // 3)
        for j in range(16):
            x0, x1, x2 = p[j], p[16 + j], p[32 + j]
            y0, y1, y2 = p[48 + j], p[64 + j], p[80 + j]
            z0, z1, z2 = p[192 + j], p[208 + j], p[224 + j]
            out[k + j] = q0 * x0 + q1 * x1 + q2 * x2 + b0 * y0 + b1 * y1 + b2 * y2
            out[48 + k + j] = p[48 + k + j]
            out[96 + k + j] = (
                (p[96 + k + j] + dt * p[144 + k + j])
                + (w0 * x0 + w1 * x1 + w2 * x2)
                + (s0 * y0 + s1 * y1 + s2 * y2)
                + (t0 * z0 + t1 * z1 + t2 * z2)
            )
            out[144 + k + j] = (
                (p[144 + k + j] + v0 * x0 + v1 * x1 + v2 * x2)
                + (u0 * y0 + u1 * y1 + u2 * y2)
                + (a0 * z0 + a1 * z1 + a2 * z2)
            )
            out[192 + k + j] = p[192 + k + j]


@_compiled
def _rows_back(chain, dt, p, out):
    """Transposed transition of a stride times p."""
    for i in range(3):
        q0, q1, q2 = chain[i], chain[i + 3], chain[i + 6]
        b0, b1, b2 = chain[i + 9], chain[i + 12], chain[i + 15]
        v0, v1, v2 = chain[i + 18], chain[i + 21], chain[i + 24]
        u0, u1, u2 = chain[i + 27], chain[i + 30], chain[i + 33]
        a0, a1, a2 = chain[i + 36], chain[i + 39], chain[i + 42]
        w0, w1, w2 = chain[i + 45], chain[i + 48], chain[i + 51]
        s0, s1, s2 = chain[i + 54], chain[i + 57], chain[i + 60]
        t0, t1, t2 = chain[i + 63], chain[i + 66], chain[i + 69]
        k = 16 * i
        for j in range(16):
            x0, x1, x2 = p[j], p[16 + j], p[32 + j]
            y0, y1, y2 = p[96 + j], p[112 + j], p[128 + j]
            z0, z1, z2 = p[144 + j], p[160 + j], p[176 + j]
            out[k + j] = (
                (q0 * x0 + q1 * x1 + q2 * x2)
                + (w0 * y0 + w1 * y1 + w2 * y2)
                + (v0 * z0 + v1 * z1 + v2 * z2)
            )
            out[48 + k + j] = (
                (p[48 + k + j] + b0 * x0 + b1 * x1 + b2 * x2)
                + (s0 * y0 + s1 * y1 + s2 * y2)
                + (u0 * z0 + u1 * z1 + u2 * z2)
            )
            out[96 + k + j] = p[96 + k + j]
            out[144 + k + j] = p[144 + k + j] + dt * p[96 + k + j]
            out[192 + k + j] = (p[192 + k + j] + t0 * y0 + t1 * y1 + t2 * y2) + (
                a0 * z0 + a1 * z1 + a2 * z2
            )


@_compiled
def _transpose(p, out):
    for i in range(15):
        for j in range(15):
            out[16 * i + j] = p[16 * j + i]


@_compiled
def _row_times(a, i, b, out):
    """Row i of a times the matrix b; in short sums, which do not wait for one another."""
    k = 16 * i
    a0, a1, a2, a3, a4 = a[k], a[k + 1], a[k + 2], a[k + 3], a[k + 4]
    a5, a6, a7, a8, a9 = a[k + 5], a[k + 6], a[k + 7], a[k + 8], a[k + 9]
    a10, a11, a12, a13, a14 = a[k + 10], a[k + 11], a[k + 12], a[k + 13], a[k + 14]
    for j in range(16):
        out[k + j] = (
            (a0 * b[j] + a1 * b[16 + j] + a2 * b[32 + j] + a3 * b[48 + j])
            + (a4 * b[64 + j] + a5 * b[80 + j] + a6 * b[96 + j] + a7 * b[112 + j])
            + (a8 * b[128 + j] + a9 * b[144 + j] + a10 * b[160 + j] + a11 * b[176 + j])
            + (a12 * b[192 + j] + a13 * b[208 + j] + a14 * b[224 + j])
        )


@_compiled
def _product_rows(a, b, out, first, last):
    """Rows first to last of a times the matrix b, three at a time: b is read once for them."""
    for k in range(16 * first, 16 * last, 48):
        for j in range(16):
            x, y, z = a[k] * b[j], a[k + 16] * b[j], a[k + 32] * b[j]
            for m in range(1, 15):
                x += a[k + m] * b[16 * m + j]
                y += a[k + 16 + m] * b[16 * m + j]
                z += a[k + 32 + m] * b[16 * m + j]
            out[k + j], out[k + 16 + j], out[k + 32 + j] = x, y, z


@_compiled
def _correct(states, k, error):
    """Put an error into a state (eq. 22 turned round)."""
    m0, m1, m2, m3 = _product(
        states[k, 0], states[k, 1], states[k, 2], states[k, 3], 1.0, error[0], error[1], error[2]
    )
    scale = 1 / np.sqrt(m0 * m0 + m1 * m1 + m2 * m2 + m3 * m3)
    states[k, 0], states[k, 1], states[k, 2], states[k, 3] = (
        m0 * scale, m1 * scale, m2 * scale, m3 * scale
    )  # fmt: skip
    for i in range(3):
        states[k, 10 + i] += error[3 + i]
        states[k, 4 + i] += error[6 + i]
        states[k, 7 + i] += error[9 + i]
        states[k, 13 + i] += error[12 + i]


@_compiled
def _share(still, zero_rate, noise):
    """How much of a measured rate is motion, if a standing frame has a noise of its own.

    With the prior "rate 0 with noise s" and a reading with noise g, the rate's best estimate is
    s²/(s²+g²) of the reading; its error does not depend on the reading less the bias, so that the
    latter may be used once more, as an observation of the bias with variance s² + g².
    """
    if still and zero_rate:
        return noise[6] / (noise[6] + noise[0])
    return 1.0


@_compiled
def _up(states, k):
    """The world's z in the IMU's axes."""
    r = _matrix(states[k, 0], states[k, 1], states[k, 2], states[k, 3])
    return r[6], r[7], r[8]


# The observed states are 3, 4, 5 (bias of the gyroscope), 8 (height), 9, 10, 11 (velocity).


@_compiled
def _state_of(m):
    """Number of the m-th observed state."""
    return m + 3 if m < 3 else m + 5


@_compiled
def _observation(states, begin, end, gyr, seen, noise, zero_rate, upright, h, residual, spread):
    """Observed less predicted at a stride's end, and variances: infinite if not observed."""
    for m in range(7):
        residual[m] = 0.0
    for k in range(begin, end):
        row = k if len(seen) > 1 else 0
        for i in range(3):
            residual[i] += gyr[k, i] - states[k + 1, 10 + i]
            residual[4 + i] += seen[row, i]
        residual[3] += seen[row, 3]
    for m in range(7):
        residual[m] /= end - begin
    residual[3] -= states[end, 6]
    for i in range(3):
        residual[4 + i] -= states[end, 7 + i]
    for i in range(3):
        spread[i] = (noise[6] + noise[0]) / h if zero_rate else np.inf
        spread[4 + i] = noise[4] / h
    spread[3] = noise[5] / h if upright else np.inf


@_compiled
def forward(
    acc, gyr, still, cut, seen, dt, ends, length, places, noise, zero_rate, sign, couple,
    upright_cos, first, states, chains, packed, shifts, said, nis, dof, room,
):  # fmt: skip
    """Filter. Kept are chains, P before strides, and updates (shifts; residuals and weights)."""
    p, work, other, rows, vectors = room[0], room[1], room[2], room[3], room[4]
    step, chain, error = vectors[0:48], vectors[48:120], vectors[120:136]
    residual, spread, inverse = vectors[136:144], vectors[144:152], vectors[152:160]
    up0, up1, up2 = _up(states, 0)
    for i in range(15):
        for j in range(15):
            p[16 * i + j] = first[i, j]
    begin = 0
    for g in range(len(ends)):
        end, h, rest = ends[g], length[g], still[begin]
        share = _share(rest, zero_rate, noise)
        advance(states, begin, acc, gyr, dt[begin], share, sign, couple, step)
        _begin(step, dt[begin], chain)
        for k in range(begin + 1, end):
            advance(states, k, acc, gyr, dt[k], share, sign, couple, step)
            _chain(step, dt[k], chain)
        _rows(chain, h, p, work)
        _transpose(work, other)
        # Here, since what was just transposed cannot be read at once.
        _pack(p, packed, g)
        for i in range(places[g + 1] - places[g]):
            chains[places[g] + i] = chain[i]
        _rows(chain, h, other, p)
        white = CUT_ACC_SD_MPS2**2 * h if cut[begin] else noise[1]
        inner = h * h * h * (1 / 3 - 1 / (12 * (end - begin) ** 2))
        for i in range(3):
            p[17 * i] += noise[0] * share / 4 * h
            p[17 * (3 + i)] += noise[2] * h
            p[17 * (6 + i)] += white * inner
            p[17 * (6 + i) + 3] += white * h * h / 2
            p[17 * (9 + i) - 3] += white * h * h / 2
            p[17 * (9 + i)] += white * h
            p[17 * (12 + i)] += noise[3] * h
        if rest:
            now0, now1, now2 = _up(states, end)
            upright = now0 * up0 + now1 * up1 + now2 * up2 > upright_cos
            _observation(states, begin, end, gyr, seen, noise, zero_rate, upright, h, residual,
                         spread)  # fmt: skip
            for m in range(7):
                said[g, m] = residual[m]
                said[g, 8 + m] = 1 / spread[m]
            dof[end - 1] = 3 + 3 * zero_rate + upright
            nis[end - 1] = _observe(p, residual, spread, work, inverse, rows, error)
            _correct(states, end, error)
            for i in range(16):
                shifts[g, i] = error[i]
        begin = end
    _pack(p, packed, len(ends))


@_compiled
def _observe(p, residual, spread, low, inverse, rows, error):
    """Covariance and error after an observation; given back is the normalised innovation squared.

    The innovations' covariance is taken apart into L / inverse L', with ones on L's diagonal.
    """
    for m in range(7):
        k = 16 * _state_of(m)
        for n in range(m + 1):
            low[8 * m + n] = p[k + _state_of(n)]
        low[9 * m] += spread[m]
    for n in range(7):
        inverse[n] = 1 / low[9 * n]
        for m in range(n + 1, 7):
            gain = low[8 * m + n] * inverse[n]
            for k in range(n + 1, m + 1):
                low[8 * m + k] -= gain * low[8 * k + n]
        for m in range(n + 1, 7):
            low[8 * m + n] *= inverse[n]
    nis = 0.0
    for m in range(7):
        for n in range(m):
            residual[m] -= low[8 * m + n] * residual[n]
        nis += residual[m] * residual[m] * inverse[m]
    a = low[8]
    b0, b1 = low[16], low[17]
    c0, c1, c2 = low[24], low[25], low[26]
    d0, d1, d2, d3 = low[32], low[33], low[34], low[35]
    e0, e1, e2, e3, e4 = low[40], low[41], low[42], low[43], low[44]
    f0, f1, f2, f3, f4, f5 = low[48], low[49], low[50], low[51], low[52], low[53]
    for m in range(7):
        residual[m] *= inverse[m]
    s0, s1, s2, s3 = residual[0], residual[1], residual[2], residual[3]
    s4, s5, s6 = residual[4], residual[5], residual[6]
    for j in range(16):
        u0 = p[48 + j]
        u1 = p[64 + j] - a * u0
        u2 = p[80 + j] - (b0 * u0 + b1 * u1)
        u3 = p[128 + j] - (c0 * u0 + c1 * u1 + c2 * u2)
        u4 = p[144 + j] - (d0 * u0 + d1 * u1) - (d2 * u2 + d3 * u3)
        u5 = p[160 + j] - (e0 * u0 + e1 * u1 + e2 * u2) - (e3 * u3 + e4 * u4)
        u6 = p[176 + j] - (f0 * u0 + f1 * u1 + f2 * u2) - (f3 * u3 + f4 * u4 + f5 * u5)
        rows[j], rows[16 + j], rows[32 + j], rows[48 + j] = u0, u1, u2, u3
        rows[64 + j], rows[80 + j], rows[96 + j] = u4, u5, u6
        error[j] = (s0 * u0 + s1 * u1 + s2 * u2 + s3 * u3) + (s4 * u4 + s5 * u5 + s6 * u6)
    _take_off(p, rows, inverse)
    return nis


@_compiled
def _take_off(p, rows, inverse):
    """Take the squares of seven rows, times their weights, off a covariance."""
    i0, i1, i2, i3 = inverse[0], inverse[1], inverse[2], inverse[3]
    i4, i5, i6 = inverse[4], inverse[5], inverse[6]
    for i in range(0, 15, 3):
        k = 16 * i
        a0, a1, a2, a3 = i0 * rows[i], i1 * rows[16 + i], i2 * rows[32 + i], i3 * rows[48 + i]
        a4, a5, a6 = i4 * rows[64 + i], i5 * rows[80 + i], i6 * rows[96 + i]
        i += 1
        b0, b1, b2, b3 = i0 * rows[i], i1 * rows[16 + i], i2 * rows[32 + i], i3 * rows[48 + i]
        b4, b5, b6 = i4 * rows[64 + i], i5 * rows[80 + i], i6 * rows[96 + i]
        i += 1
        c0, c1, c2, c3 = i0 * rows[i], i1 * rows[16 + i], i2 * rows[32 + i], i3 * rows[48 + i]
        c4, c5, c6 = i4 * rows[64 + i], i5 * rows[80 + i], i6 * rows[96 + i]
        for j in range(16):
            r0, r1, r2, r3 = rows[j], rows[16 + j], rows[32 + j], rows[48 + j]
            r4, r5, r6 = rows[64 + j], rows[80 + j], rows[96 + j]
            p[k + j] -= (a0 * r0 + a1 * r1 + a2 * r2 + a3 * r3) + (a4 * r4 + a5 * r5 + a6 * r6)
            p[k + 16 + j] -= (b0 * r0 + b1 * r1 + b2 * r2 + b3 * r3) + (b4 * r4 + b5 * r5 + b6 * r6)
            p[k + 32 + j] -= (c0 * r0 + c1 * r1 + c2 * r2 + c3 * r3) + (c4 * r4 + c5 * r5 + c6 * r6)


@_compiled
def _pack(p, packed, g):
    """Lower triangle, row by row."""
    at = 0
    for i in range(15):
        for j in range(i + 1):
            packed[g, at + j] = p[16 * i + j]
        at += i + 1


@_compiled
def unpack(packed, g, p):
    """Both triangles from the lower one."""
    at = 0
    for i in range(15):
        for j in range(i + 1):
            p[16 * i + j] = packed[g, at + j]
            p[16 * j + i] = packed[g, at + j]
        at += i + 1


@_compiled
def backward(
    still, ends, length, places, chains, packed, shifts, said, mu_last, big_last, states,
    smoothed_var, room,
):  # fmt: skip
    """Smoother; mu_last and big_last are what is known beyond the last update. States in place.

    All updates observe single states, so that going back over them is cheap: mu += (residual -
    error) / R, with the residual after the update, and _take_back for big with D = 1 / R.
    """
    p, big, known, work = room[0], room[1], room[2], room[3]
    other, eye, vectors = room[4], room[5], room[6]
    for i in range(15):
        eye[17 * i] = 1.0
    mu, was, error, later = vectors[0:16], vectors[16:32], vectors[32:48], vectors[48:64]
    variance, weight, chain = vectors[64:80], vectors[80:96], vectors[96:168]
    for i in range(15):
        mu[i] = mu_last[i]
        for j in range(15):
            big[16 * i + j] = big_last[i, j]
    unpack(packed, len(ends), p)
    for g in range(len(ends), -1, -1):
        end = ends[g - 1] if g > 0 else 0
        _row_times(mu, 0, p, error)
        if g > 0 and still[end - 1]:
            for m in range(7):
                i = _state_of(m)
                weight[i] = said[g - 1, 8 + m]
                mu[i] += weight[i] * (said[g - 1, m] - shifts[g - 1, i] - error[i])
        _correct(states, end, error)
        if g < len(ends):
            _spread_error(states, end, ends[g], error, later, was)
        _product_rows(big, p, known, 0, 15)
        _diagonal(p, known, variance)
        for j in range(15):
            smoothed_var[g, j] = max(variance[j], 0.0)
        if g == 0:
            break
        s = g - 1
        h, size = length[s], places[g] - places[s]
        for i in range(size):
            chain[i] = chains[places[s] + i]
        if size == STEP:
            _begin(chain, h, chain)
        for i in range(16):
            later[i] = error[i]
        if still[end - 1]:
            for i in range(16):
                later[i] += shifts[s, i]
            _take_back(p, known, weight, work, eye, big)
        _rows_back(chain, h, big, work)
        _transpose(work, other)
        unpack(packed, s, p)  # here, as in forward
        for i in range(16):
            was[i] = mu[i]
        _vector_back(chain, h, was, mu)
        _rows_back(chain, h, other, big)
        # Rounding makes big a little unsymmetric; the updates would let that grow without bound.
        for i in range(15):
            for j in range(i):
                big[16 * j + i] = big[16 * i + j]


@_compiled
def _spread_error(states, begin, end, first, last, error):
    """Correct the states inside a stride by what is between the errors at its ends."""
    for k in range(begin + 1, end):
        later = (k - begin) / (end - begin)
        for i in range(16):
            error[i] = (1 - later) * first[i] + later * last[i]
        _correct(states, k, error)


@_compiled
def _diagonal(p, known, out):
    """Diagonal of p less that of p times known."""
    for j in range(16):
        out[j] = p[17 * j]
    for k in range(0, 240, 80):  # five rows at a time, or the compiler takes them apart
        for j in range(k, k + 16):
            out[j - k] -= (
                p[j] * known[j]
                + p[j + 16] * known[j + 16]
                + p[j + 32] * known[j + 32]
                + p[j + 48] * known[j + 48]
                + p[j + 64] * known[j + 64]
            )


@_compiled
def _take_back(p, known, weight, rows, eye, big):
    """Bring big back over updates: (1 - D P) big (1 - P D) + D - D P D; known is big P.

    The weights, D, are those of the observed states; the others have none.
    """
    for k in range(0, 240, 80):  # five rows at a time, as in _diagonal
        for j in range(k, k + 16):
            w = weight[j - k]
            big[j] -= known[j] * w
            big[j + 16] -= known[j + 16] * w
            big[j + 32] -= known[j + 32] * w
            big[j + 48] -= known[j + 48] * w
            big[j + 64] -= known[j + 64] * w
    _product_rows(p, big, rows, 3, 6)
    _product_rows(p, big, rows, 9, 12)
    _row_times(p, 8, big, rows)
    for k in range(48, 192, 48):
        w0, w1, w2 = weight[k // 16], weight[k // 16 + 1], weight[k // 16 + 2]
        for j in range(16):
            w = weight[j]
            big[k + j] -= w0 * (rows[k + j] + p[k + j] * w - eye[k + j])
            big[k + 16 + j] -= w1 * (rows[k + 16 + j] + p[k + 16 + j] * w - eye[k + 16 + j])
            big[k + 32 + j] -= w2 * (rows[k + 32 + j] + p[k + 32 + j] * w - eye[k + 32 + j])


@_compiled
def _vector_back(chain, dt, v, out):
    """Transposed transition of a stride times a vector."""
    for i in range(3):
        out[i] = (
            chain[i] * v[0] + chain[3 + i] * v[1] + chain[6 + i] * v[2]
            + chain[45 + i] * v[6] + chain[48 + i] * v[7] + chain[51 + i] * v[8]
            + chain[18 + i] * v[9] + chain[21 + i] * v[10] + chain[24 + i] * v[11]
        )  # fmt: skip
        out[3 + i] = (
            v[3 + i] + chain[9 + i] * v[0] + chain[12 + i] * v[1] + chain[15 + i] * v[2]
            + chain[54 + i] * v[6] + chain[57 + i] * v[7] + chain[60 + i] * v[8]
            + chain[27 + i] * v[9] + chain[30 + i] * v[10] + chain[33 + i] * v[11]
        )  # fmt: skip
        out[6 + i] = v[6 + i]
        out[9 + i] = v[9 + i] + dt * v[6 + i]
        out[12 + i] = (
            v[12 + i] + chain[63 + i] * v[6] + chain[66 + i] * v[7] + chain[69 + i] * v[8]
            + chain[36 + i] * v[9] + chain[39 + i] * v[10] + chain[42 + i] * v[11]
        )  # fmt: skip
