"""Walker: whether the printed equations give back what they start from."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from scipy.spatial.transform import Rotation

from mobility_imu.frames import FloatArray
from mobility_imu.reproduction.claims import Claim, Quotation
from mobility_imu.reproduction.walker import evidence
from mobility_imu.walker.geometry import (
    FOOTPRINT,
    TiltDirection,
    rotation_body_to_world,
)
from mobility_imu.walker.mount import WalkerMount
from mobility_imu.walker.navigation import strapdown_rates
from mobility_imu.walker.tilt_equations import (
    arm_angle,
    distance_to_edge,
    forward_axis,
    imu_height,
    position_four_tilts,
    position_two_tilts,
    quaternion_from_rotation,
    tilt_angle,
)
from mobility_imu.walker.trajectory import body_position, walking_displacement

INPUTS = 1000
SEED = 28
EXACT = "rounding of double precision"


def equation_claims() -> list[Claim]:
    """Rows for equations (1) to (28).

    Returns
    -------
    list of Claim
    """
    return [*_as_copied(), *_exact(), *_walking_length()]


def _row(where: str, what: str, unit: str, compute: Callable[[], float], **fields: Any) -> Claim:
    defaults: dict[str, Any] = {
        "reference": 0.0,
        "reference_from": "an exact equation",
        "n": INPUTS,
        "tolerance": 1e-9,
        "tolerance_reason": EXACT,
    }
    return Claim(
        work="walker",
        where=where,
        what=what,
        unit=unit,
        basis="computed by geometry alone",
        compute=compute,
        why=None if fields.get("finding") else "the text is not right",
        **(defaults | fields),
    )


def _as_copied() -> list[Claim]:
    """Equations that our text copy has in a form that is not right (it may be the copy's fault)."""
    rows: tuple[tuple[str, str, str, str, Callable[[], evidence.Evidences], float], ...] = (
        (
            "eq. 1, as our copy has it",
            "largest entry of abs(C C' - I), median of 200 attitudes",
            "1",
            "K1",
            evidence.matrix_of_a_quaternion,
            1e-9,
        ),
        (
            "eq. 7, as our copy has it",
            "error of the mounting's rotation, heading 40 deg",
            "deg",
            "K14",
            evidence.transposes,
            1e-6,
        ),
        (
            "eq. 24, gyroscope's bias, as our copy has it",
            "entry that takes the bias to the attitude error",
            "1",
            "K2",
            evidence.sign_of_the_gyroscope_bias,
            1e-6,
        ),
        (
            "eq. 24, accelerometer's bias, as our copy has it",
            "largest error of the block that takes the bias to the velocity error",
            "1",
            "K10",
            evidence.accelerometer_bias,
            1e-6,
        ),
        (
            "eq. 28, as our copy has it",
            "walking length of a made-up walk, beside (25) at both ends",
            "m",
            "K3",
            evidence.sign_of_the_lever_arm,
            1e-9,
        ),
    )
    return [
        _row(
            where,
            what,
            unit,
            _first_of(checked),
            reference=round(checked()[0].truth, 9),
            reference_from="our own derivation, and a difference quotient or another program",
            n=1,
            tolerance=tolerance,
            tolerance_reason="accuracy of the check",
            finding=finding,
        )
        for where, what, unit, finding, checked, tolerance in rows
    ]


def _first_of(checked: Callable[[], evidence.Evidences]) -> Callable[[], float]:
    return lambda: checked()[0].first


def _exact() -> list[Claim]:
    """Equations that give back a known truth: largest error over random inputs."""
    return [
        _row("eqs 2 and 6", "body axes at the start: largest error of an entry", "1", _axes),
        _row("eqs 3 to 5", "forward axis from a tilt to the back: largest error", "1", _forward),
        _row("eqs 10 to 12", "tilt angle: largest error", "rad", _angle, tolerance=1e-7),
        _row("eq. 13", "distance from the edge: largest error", "m", _distance),
        _row("eq. 14", "height, place inside the footprint: largest error", "m", _height),
        _row(
            "eq. 15, inside the footprint",
            "place: largest error",
            "m",
            lambda: _roots(_inside()),
            tolerance=1e-6,
            tolerance_reason="roots of differences that may be near 0",
        ),
        _row(
            "eq. 15, up to 0.1 m behind the rear tips",
            "place: largest error (the paper does not say where (15) holds)",
            "m",
            lambda: _roots(_behind()),
            tolerance=1e-6,
            tolerance_reason="roots of differences that may be near 0",
            finding="K16",
        ),
        _row("eqs 16 to 19, no tilt yet", "place: largest error", "m", _two_tilts, tolerance=1e-7),
        _row(
            "eq. 20",
            "rate of the quaternion, beside a difference quotient: largest error",
            "1/s",
            _quaternion_rate,
            tolerance=1e-6,
            tolerance_reason="accuracy of the difference quotient",
        ),
        _row("eq. 25", "place of the frame from that of the IMU: largest error", "m", _frame),
        _row("eq. 27", "displacement of the frame: largest error", "m", _displacement),
    ]


def _walking_length() -> list[Claim]:
    """What (28) says of an error of the IMU's position."""
    straight = (
        "they do not affect the error in walking along a straight path (see Figure 6)",
        "effect of an error of 100 mm in T, first and last heading equal",
        0.0,
    )
    corner = (
        "the estimated parameters affect the walking length error for changing direction (see "
        "Figure 7)",
        "effect of an error of 100 mm in T, last corner not turned: over 100 mm",
        270.0,
    )
    no_effect, effect = (
        _row(
            f"section 4 with eq. 28, {name}",
            what,
            unit,
            compute,
            source=Quotation(sentence),
            reference=reference,
            reference_from=reference_from,
            n=1,
            finding="K8",
        )
        for name, (sentence, what, _), unit, compute, reference, reference_from in (
            (
                "straight path",
                straight,
                "mm",
                lambda: _effect_mm(straight[2]),
                0.0,
                "the statement: no effect",
            ),
            (
                "changing direction",
                corner,
                "1",
                lambda: _effect_mm(corner[2]) / 100,
                float(np.sqrt(2)),
                "2 sin(45 deg), the change of attitude over a quarter turn",
            ),
        )
    )
    return [no_effect, effect]


def _effect_mm(turned_deg: float) -> float:
    last = Rotation.from_euler("z", turned_deg, degrees=True).as_matrix()
    ends = (np.zeros(3), np.zeros(3), np.eye(3), last, [0.4, -0.2, 0.6])
    moved = walking_displacement(*ends, [0.1, 0.0, 0.0]) - walking_displacement(*ends)
    return float(1000 * np.linalg.norm(moved))


def _rng() -> np.random.Generator:
    return np.random.default_rng(SEED)


def _inside() -> FloatArray:
    """Places (n, 3), m, over the footprint, in the body frame."""
    width, length = FOOTPRINT.footprint_width_m, FOOTPRINT.footprint_length_m
    low, high = (0.01, -width / 2 + 0.01, 0.3), (length - 0.01, width / 2 - 0.01, 0.9)
    return _rng().uniform(low, high, (INPUTS, 3))


def _behind() -> FloatArray:
    return _inside() * [0.0, 1.0, 1.0] - _rng().uniform(0.01, 0.1, (INPUTS, 1)) * [1.0, 0.0, 0.0]


def _distances(place: FloatArray) -> dict[TiltDirection, float]:
    x, y, h = (float(value) for value in place)
    width, length = FOOTPRINT.footprint_width_m, FOOTPRINT.footprint_length_m
    return {
        "front": float(np.hypot(length - x, h)),
        "back": float(np.hypot(x, h)),
        "right": float(np.hypot(y + width / 2, h)),
        "left": float(np.hypot(width / 2 - y, h)),
    }


def _axes() -> float:
    headings = _rng().uniform(-np.pi, np.pi, INPUTS)
    true = Rotation.from_euler("z", headings[:, None]).as_matrix()
    found = [rotation_body_to_world([np.cos(a), np.sin(a), 0.0]) for a in headings]
    return float(np.abs(np.array(found) - true).max())


def _forward() -> float:
    """A tilt to the back moves the IMU by x (cos a - 1) - h sin a along the forward axis."""
    rng, worst = _rng(), 0.0
    for place in _inside():
        heading, tilt = rng.uniform(-np.pi, np.pi), rng.uniform(0.35, 0.79)
        ahead = np.array([np.cos(heading), np.sin(heading), 0.0])
        back = place[0] * (1 - np.cos(tilt)) + place[2] * np.sin(tilt)
        worst = max(worst, float(np.abs(forward_axis(back * ahead + [0, 0, 0.1]) - ahead).max()))
    return worst


def _angle() -> float:
    rng = _rng()
    tilts = rng.uniform(0.35, 0.79, INPUTS)
    axes = rng.standard_normal((INPUTS, 3))
    axes /= np.linalg.norm(axes, axis=1, keepdims=True)
    matrices = Rotation.from_rotvec(tilts[:, None] * axes).as_matrix()
    found = [tilt_angle(quaternion_from_rotation(m), form="printed") for m in matrices]
    return float(np.abs(np.array(found) - tilts).max())


def _distance() -> float:
    rng, worst = _rng(), 0.0
    for place in _inside():
        tilt = rng.uniform(0.35, 0.79)
        turn = Rotation.from_rotvec([0.0, -tilt, 0.0]).as_matrix()
        chord = float(np.linalg.norm(turn @ place - place))
        true = float(np.hypot(place[0], place[2]))
        worst = max(worst, abs(distance_to_edge(chord, tilt) - true))
    return worst


def _height() -> float:
    return max(abs(imu_height(_distances(p), FOOTPRINT) - float(p[2])) for p in _inside())


def _roots(places: FloatArray) -> float:
    found = [position_four_tilts(_distances(p), FOOTPRINT, form="printed") for p in places]
    return float(np.abs(np.array(found) - places).max())


def _two_tilts() -> float:
    worst, width = 0.0, FOOTPRINT.footprint_width_m
    for place in _inside():
        x, y, h = place
        back, right = arm_angle([-h, 0.0, x]), arm_angle([0.0, -h, y + width / 2])
        far = _distances(place)
        found = position_two_tilts(far["back"], far["right"], back, right, width)
        worst = max(worst, float(np.abs(found - place).max()))
    return worst


def _attitudes() -> FloatArray:
    return np.asarray(Rotation.random(INPUTS, rng=_rng()).as_quat(scalar_first=True))


def _quaternion_rate() -> float:
    rng, worst, step = _rng(), 0.0, 1e-5
    for q in _attitudes():
        rate = rng.standard_normal(3)
        found, _, _ = strapdown_rates(q, np.zeros(3), rate, np.zeros(3))
        here = Rotation.from_quat(q, scalar_first=True)
        ends = [
            (here * Rotation.from_rotvec(s * step * rate)).as_quat(scalar_first=True)
            for s in (1, -1)
        ]
        ends = [end * np.sign(end @ q) for end in ends]  # q and -q are the same attitude
        worst = max(worst, float(np.abs((ends[0] - ends[1]) / (2 * step) - found).max()))
    return worst


def _frame() -> float:
    rng = _rng()
    mount = WalkerMount(Rotation.random(rng=rng).as_matrix(), np.array([0.4, -0.2, 0.6]))
    body_to_world = Rotation.random(INPUTS, rng=rng)
    place = rng.standard_normal((INPUTS, 3))
    imu = place + body_to_world.as_matrix() @ mount.translation_body_m
    attitude = body_to_world * Rotation.from_matrix(mount.rotation_imu_to_body)
    found, _ = body_position(imu, attitude.as_quat(scalar_first=True), mount)
    return float(np.abs(found - place).max())


def _displacement() -> float:
    rng, worst = _rng(), 0.0
    for _ in range(INPUTS):
        first, last = Rotation.random(2, rng=rng).as_matrix()
        frame_1, frame_n, t = rng.standard_normal((3, 3))
        found = walking_displacement(frame_1 + first @ t, frame_n + last @ t, first, last, t)
        worst = max(worst, float(np.abs(found - (frame_n - frame_1)).max()))
    return worst
