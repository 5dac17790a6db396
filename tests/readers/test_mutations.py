"""Valid files of every vendor with one thing changed end in a recording or in one line."""

import os
import random
import warnings

import pytest
from test_dialects import OF_ONE, made

from mobility_imu.errors import InputError
from mobility_imu.readers.recordings import understand

COUNT = int(os.environ.get("MOBILITY_IMU_MUTATIONS", "200")) // len(OF_ONE)
"""Changes of each format; ``make check`` tries 2,000 in all."""
DIGITS = b'0123456789.,;\t\n"eE-+NaInf{}[]:'
STRANGE = (b"\x00", b"\xff\xfe", b"1e999", b"-", b'""', b"9" * 400, b"\r", b"[[[[")


def damaged(raw, rng):
    raw = bytearray(raw)
    i = rng.randrange(len(raw))
    j = min(len(raw), i + rng.randrange(1, 40))
    kind = rng.randrange(7)
    if kind == 0:
        raw[i] = rng.randrange(256)
    elif kind == 1:
        del raw[i:j]
    elif kind == 2:
        raw[i:i] = raw[i:j]
    elif kind == 3:
        del raw[i:]
    elif kind == 4:
        raw[i:j] = bytes(rng.choice(DIGITS) for _ in range(j - i))
    elif kind == 5:
        lines = bytes(raw).split(b"\n")
        rng.shuffle(lines)
        return b"\n".join(lines)
    else:
        raw[i:i] = rng.choice(STRANGE)
    return bytes(raw)


@pytest.mark.parametrize("write", OF_ONE, ids=lambda w: w.__name__)
def test_a_damaged_file_is_read_or_refused_in_one_line(tmp_path, write):
    rng = random.Random(write.__name__)
    path = write(made(count=60), tmp_path)
    files = [f for f in sorted(tmp_path.rglob("*")) if f.is_file() and f.stat().st_size]
    for _ in range(COUNT):
        file = rng.choice(files)
        valid = file.read_bytes()
        file.write_bytes(damaged(valid, rng))
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            try:
                understand(path, expected=("frame",))
            except InputError as error:
                assert "\n" not in str(error)
        file.write_bytes(valid)
