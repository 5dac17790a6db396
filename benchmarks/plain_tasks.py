"""The document's steps 1-5 read aloud: plain Python, loops over offsets and frames, no NumPy.

Written from the text of section 2, not from ``mobility_imu.wheelchair.tasks``, to be that
module's second opinion in the tests and its slow peer in ``bench_tasks.py``. Where the document
is silent the public tool's rule is taken, marked "tool:".
"""

import math

STATIC, FORWARD, BACKWARD, PIVOT, TIGHT, WIDE = 1, 2, 3, 4, 5, 6


def plain_tasks(velocity, yaw_rate_radps, segment, look, settings, edge):
    """Task code of every frame, as a list.

    ``segment`` and ``look`` are in frames; ``settings`` has the thresholds' names of TaskSettings.
    """
    velocity = [float(v) for v in velocity]
    turning = [abs(math.degrees(float(w))) for w in yaw_rate_radps]
    signals = {
        "V": velocity,
        "abs V": [abs(v) for v in velocity],
        "abs yaw": turning,
        "R": [radius(v, float(w)) for v, w in zip(velocity, yaw_rate_radps, strict=True)],
    }
    sax = {
        name: symbolic_signal(name, values, segment, settings, edge)
        for name, values in signals.items()
    }
    codes = [
        table_2(sax["V"][t], sax["abs V"][t], sax["abs yaw"][t], sax["R"][t])
        for t in range(len(velocity))
    ]
    codes = refine(codes, signals["abs V"], turning, look, settings)
    return reduce(codes, segment)


def radius(v, w):
    """Equation 2.1 with the yaw rate in rad/s; no turning is an infinite radius."""
    return math.inf if w == 0 else abs(v / w)


def symbolic_signal(name, values, segment, settings, edge):
    """Steps 1 and 2: one approximation per offset, one row of letters each, then the vote."""
    rows = [
        letters_of_offset(name, values, offset, segment, settings, edge)
        for offset in range(min(segment, len(values)))
    ]
    voted = []
    for t in range(len(values)):
        votes = [row[t] for row in rows if row[t] is not None]
        # tool: of equally many votes the first letter wins.
        voted.append(max("abc", key=lambda letter: (votes.count(letter), -ord(letter))))
    return voted


def letters_of_offset(name, values, offset, segment, settings, edge):
    """One row of the matrix of step 2: the letters for segments that begin at this offset."""
    # tool: frames before the offset count as no motion.
    missing = ("c" if name == "R" else "b") if edge == "tool" else None
    row = [missing] * offset
    for start in range(offset, len(values), segment):
        part = values[start : start + segment]  # tool: the last segment may be short
        total = 0.0
        for value in part:
            total += value
        row += [table_1(name, total / len(part), settings)] * len(part)
    return row


def table_1(name, mean, settings):
    """Letter of one mean."""
    if name == "V":
        if mean <= -settings.linear_velocity_mps:
            return "a"
        return "c" if mean >= settings.linear_velocity_mps else "b"
    if name == "abs V":
        return "c" if mean >= settings.linear_velocity_mps else "b"
    if name == "abs yaw":
        return "c" if mean >= settings.yaw_rate_degps else "b"  # tool: >=, the table prints >
    if mean <= settings.pivot_radius_m:
        return "a"
    return "b" if mean < settings.wide_radius_m else "c"


def table_2(v, speed, yaw, r):
    """Task of one frame."""
    if yaw == "c":
        return {"a": PIVOT, "b": TIGHT, "c": WIDE}[r]
    if speed == "b":
        return STATIC
    return BACKWARD if v == "a" else FORWARD  # tool: forward also with v == "b"


def refine(codes, speed, turning, look, settings):
    """Step 4: forward, then backward, then the rotations; each from left to right, in place."""
    codes = list(codes)
    slow = settings.onset_velocity_mps
    calm = settings.onset_yaw_rate_degps
    for group, signal, limit in (
        ((FORWARD,), speed, slow),
        ((BACKWARD,), speed, slow),
        ((PIVOT, TIGHT, WIDE), turning, calm),
    ):
        active = [code in group for code in codes]  # before this group's own extensions
        for t in range(1, len(codes)):
            if active[t] and not active[t - 1]:
                for k in range(t - 1, max(t - look, 0) - 1, -1):
                    if signal[k] < limit:
                        codes[k + 1 : t] = [codes[t]] * (t - k - 1)
                        break
            if active[t - 1] and not active[t]:
                # tool: the search after a task begins one frame late.
                for k in range(t + 1, min(t + look, len(codes) - 1) + 1):
                    if signal[k] < limit:
                        codes[t:k] = [codes[t - 1]] * (k - t)
                        break
    return codes


def reduce(codes, segment):
    """Step 5: short tasks between two of one kind become that kind, until nothing changes."""
    codes = list(codes)
    changed = True
    while changed:
        changed = False
        runs = []
        for t, code in enumerate(codes):
            if runs and runs[-1][0] == code:
                runs[-1][2] = t + 1
            else:
                runs.append([code, t, t + 1])
        for k in range(1, len(runs) - 1):
            left, (code, start, stop), right = runs[k - 1][0], runs[k], runs[k + 1][0]
            # tool: only what is shorter than a segment.
            if left == right != code and stop - start < segment:
                runs[k][0] = left
                codes[start:stop] = [left] * (stop - start)
                changed = True
    return codes
