"""qmt's angles of two hinges in a row, for bench_peers.py, in an interpreter of its own.

``python peer_qmt.py IN OUT``: for each IN/*.npz, OUT/*.npz. Orientation of each sensor by the
offline VQF; the heading of one against the other by the constraint of a joint with two axes.
"""

import sys
from pathlib import Path

import numpy as np
import qmt

SETTINGS = {
    "constraint": "euler",  # the other two raise an error in 0.2.4
    "alignment": "center",
    "windowTime": 32.0,
    "tauDelta": 2.0,
    "tauBias": 2.0,
}


def angles_of(data, **settings):
    """Angles about the first axis (z of the base) and the second (x of the tip)."""
    rate_hz = round(float(data["rate_hz"]))
    time_s = np.arange(len(data["base_gyr"])) / rate_hz  # equidistant, or qmt refuses
    base, tip = (
        qmt.oriEstOfflineVQF(data[f"{name}_gyr"], data[f"{name}_acc"], params={"Ts": 1 / rate_hz})
        for name in ("base", "tip")
    )
    joint = np.array([[0.0, 0.0, 1.0], [1.0, 0.0, 0.0]])
    tip = qmt.headingCorrection(
        data["base_gyr"],
        data["tip_gyr"],
        base,
        tip,
        time_s,
        joint,
        {},
        estSettings={**SETTINGS, **settings},
    )[0]
    relative = qmt.qmult(qmt.qinv(base), tip)
    # Between both is what the joint does not allow: small, or the heading is wrong.
    first, _, second = qmt.eulerAngles(relative, "zyx", intrinsic=True).T
    return first, second


def main():
    source, target = Path(sys.argv[1]), Path(sys.argv[2])
    for path in sorted(source.glob("*.npz")):
        first, second = angles_of(dict(np.load(path)))
        np.savez(target / path.name, first_rad=first, second_rad=second)


if __name__ == "__main__":
    main()
