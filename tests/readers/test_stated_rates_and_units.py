"""What a file states of its rate and units, against what the user says of it, or nobody."""

import json

import numpy as np
import pandas as pd
import pytest

from mobility_imu.errors import InputError
from mobility_imu.frames import STANDARD_GRAVITY_MPS2 as G
from mobility_imu.readers import read_recording
from mobility_imu.readers.recordings import understand

COUNT = 400
AXES = "xyz"


def sensor(rate_hz=100.0, seed=1):
    """Times, accelerations and rates of a sensor that moves a little."""
    draw = np.random.default_rng(seed)
    acc = draw.normal([0.2, 0.1, G], 0.1, (COUNT, 3))
    return np.arange(COUNT) / rate_hz, acc, draw.normal(0.0, 0.3, (COUNT, 3))


def canonical(path, time_s, acc, gyr):
    table = {"time_s": time_s}
    table |= {f"frame_acc_{a}_mps2": v for a, v in zip(AXES, acc.T, strict=True)}
    table |= {f"frame_gyr_{a}_radps": v for a, v in zip(AXES, gyr.T, strict=True)}
    pd.DataFrame(table).to_csv(path, index=False)
    return path


class TestGivenRate:
    def test_a_rate_that_fits_is_taken(self, tmp_path):
        path = canonical(tmp_path / "a.csv", *sensor())
        assert read_recording(path, sampling_rate_hz=100.5).sampling_rate_hz == 100

    def test_another_rate_than_the_clocks_is_told(self, tmp_path):
        path = canonical(tmp_path / "a.csv", *sensor())
        found = understand(path, sampling_rate_hz=50)
        assert found.recording.sampling_rate_hz == 100
        (said,) = found.warnings
        assert "a.csv: the given 50 Hz are not used: it has 100 Hz from its clock" in said

    def test_rounded_stamps_have_the_rate_of_all(self, tmp_path):
        time_s, acc, gyr = sensor(60.0)
        path = canonical(tmp_path / "a.csv", time_s.round(3), acc, gyr)
        read_recording(path, sampling_rate_hz=60)

    def test_a_rate_that_a_map_states_counts_too(self, tmp_path):
        path = canonical(tmp_path / "a.csv", *sensor())
        names = [f'"frame_acc_{a}_mps2"' for a in AXES]
        (tmp_path / "map.toml").write_text(
            f"[clock]\nrate_hz = 100\n[sensors.frame]\nacc = [{', '.join(names)}]\n"
            'acc_unit = "m/s2"\n'
        )
        found = understand(path, map_path=tmp_path / "map.toml", sampling_rate_hz=50)
        assert any("it has 100 Hz from map.toml" in sentence for sentence in found.warnings)


class TestHeldSamples:
    def held(self, times):
        _, acc, gyr = sensor()
        spread = np.arange(COUNT * times) / (100.0 * times)
        return spread, np.repeat(acc, times, axis=0), np.repeat(gyr, times, axis=0)

    def test_they_are_told_for_any_format(self, tmp_path):
        path = canonical(tmp_path / "a.csv", *self.held(5))
        (said,) = understand(path).warnings
        assert "80 % of the samples repeat the one before" in said and "about 100 new" in said

    def test_the_sensor_is_named_among_several(self, tmp_path):
        held = canonical(tmp_path / "left.csv", *self.held(5))
        time_s, acc, gyr = self.held(5)
        noise = np.random.default_rng(2).normal(0.0, 0.01, acc.shape)
        sound = canonical(tmp_path / "frame.csv", time_s, acc + noise, gyr)
        found = understand([f"frame={sound}", f"left_wheel={held}", "clock=same"])
        assert [w for w in found.warnings if "repeat the one before" in w and "left_wheel" in w]
        assert not [w for w in found.warnings if "repeat the one before" in w and ", frame" in w]

    def test_a_sensor_that_freezes_is_no_slow_one(self, tmp_path):
        """Two thirds of the samples repeat the one before, but the others all are new."""
        time_s, acc, gyr = sensor()
        acc[COUNT // 3 :] = acc[COUNT // 3]
        assert understand(canonical(tmp_path / "a.csv", time_s, acc, gyr)).warnings == ()
        # One that is slow and freezes is told as slow, with the rate that it had before.
        spread, acc, gyr = self.held(5)
        acc[len(acc) // 2 :] = acc[len(acc) // 2]
        (said,) = understand(canonical(tmp_path / "a.csv", spread, acc, gyr)).warnings
        assert "80 % of the samples repeat the one before" in said and "about 100 new" in said

    def test_coarse_steps_at_rest_are_no_held_samples(self, tmp_path):
        time_s, acc, gyr = sensor()
        step = 0.04  # m/s², as of a sensor with 12 bits over 8 g; less noise than a quarter of it
        still = np.random.default_rng(3).normal([0.19, 0.11, G], 0.01, acc.shape)
        path = canonical(tmp_path / "a.csv", time_s, np.rint(still / step) * step, gyr)
        assert not understand(path).warnings


class TestJson:
    def rows(self, gyr_unit):
        time_s, acc, gyr = sensor()
        return [
            {f"acc_{a}": v for a, v in zip(AXES, force / G, strict=True)}
            | {f"gy_{a}": v for a, v in zip(AXES, rate / gyr_unit, strict=True)}
            | {"timestamp": str(1.68e9 + t)}
            for t, force, rate in zip(time_s, acc, gyr, strict=True)
        ]

    def test_units_that_nobody_states_are_told(self, tmp_path):
        path = tmp_path / "a.json"
        path.write_text(json.dumps(self.rows(np.pi / 180)))
        found = understand(path)
        assert any("states no units; taken in g, deg/s and s" in w for w in found.warnings)
        np.testing.assert_allclose(found.recording.gyroscope("frame"), sensor()[2])

    def test_a_map_states_them(self, tmp_path):
        path, plan = tmp_path / "a.json", tmp_path / "map.toml"
        path.write_text(json.dumps(self.rows(1.0)))
        plan.write_text(
            '[clock]\ncolumn = "timestamp"\nunit = "s"\n[sensors.frame]\n'
            'acc = ["acc_x", "acc_y", "acc_z"]\nacc_unit = "g"\n'
            'gyr = ["gy_x", "gy_y", "-gy_z"]\ngyr_unit = "rad/s"\n'
        )
        found = understand(path, map_path=plan)
        assert not found.warnings
        np.testing.assert_allclose(found.recording.gyroscope("frame"), sensor()[2] * [1, 1, -1])
        plan.write_text("names = ['a']\n" + plan.read_text())
        with pytest.raises(InputError, match="names and first_row are for tables"):
            understand(path, map_path=plan)


class TestPhysicsToolbox:
    def read(self, tmp_path, silent):
        time_s, acc, gyr = sensor()
        acc, gyr = acc / G, gyr.copy()
        gyr[:silent] = 0.0
        names = ["time", *(f"gF{a}" for a in AXES), *(f"w{a}" for a in AXES)]
        pd.DataFrame(np.column_stack([time_s, acc, gyr]), columns=names).to_csv(
            tmp_path / "p.csv", index=False
        )
        return understand(tmp_path / "p.csv")

    def test_a_rest_is_kept(self, tmp_path):
        found = self.read(tmp_path, 200)
        assert len(found.recording) == COUNT
        assert any(
            "reads exactly zero in the first 2 s, taken for a rest" in w for w in found.warnings
        )

    def test_rows_before_the_gyroscope_reports_are_left_out(self, tmp_path):
        found = self.read(tmp_path, 20)
        assert len(found.recording) == COUNT - 20
        assert any("20 row(s) of zeros at the beginning" in w for w in found.warnings)

    def test_a_gyroscope_that_never_reports_is_refused(self, tmp_path):
        with pytest.raises(InputError, match="the gyroscope reads zero throughout"):
            self.read(tmp_path, COUNT)
