"""Excerpts of real public recordings, read in place where MOBILITY_IMU_RECORDINGS names them."""

import os
import warnings
from pathlib import Path

import numpy as np
import pytest

from mobility_imu.errors import InputError
from mobility_imu.readers.recordings import understand

FOLDER = Path(os.environ.get("MOBILITY_IMU_RECORDINGS", "/nowhere"))
pytestmark = pytest.mark.skipif(
    not (FOLDER / "lpms").is_dir(), reason="the excerpts are not where MOBILITY_IMU_RECORDINGS is"
)

READ = {
    # name: rate in Hz, median length of the accelerations in m/s² (of the first sensor)
    "actigraph/link_imu_100hz.csv": (100.0, 9.76),
    "actigraph/link_imu_100hz_resaved.csv": (100.0, 9.76),
    "actigraph/link_raw_90hz_no_time_column.csv": (90.0, 9.47),
    "apdm/mobility_lab_csv_pendulum.csv": (128.0, 9.80),
    "apdm/apdm_csv_format7.csv": (128.0, 10.3),
    "lpms/lpms_b2_resaved_no_spaces.csv": (100.0, 9.80),
    "lpms/lpmscontrol_circle.csv": (100.0, 9.83),
    "mobility_aids/rollator_idle_single.json": (80.0, 9.72),
    "mobility_aids/rollator_step_cluster_1.json": (80.0, 9.71),
    "mobility_aids/wheelchair_frame_module_asphalt_power.csv": (200.0, 9.81),
    "mobility_aids/wheelchair_left_wheel_module_asphalt.csv": (200.0, 10.67),
    "mobility_aids/wheelchair_phone_androsensor_concrete.csv": (200.0, 9.95),
    "mobility_aids/ngimu_wheelchair_frame": (400.0, 9.87),
    "mobility_aids/ngimu_wheelchair_left_wheel": (400.0, 10.02),
    "movesense/MovesenseLog_2_625.json": (106.7, 9.64),
    "movesense/MovesenseLog_3_745.json": (103.2, 10.14),
    "phone_other/physics_toolbox_multirecord.csv": (None, 10.2),
    "phyphox/ios_semicolon": (100.8, 9.85),
    "phyphox/ios_tab": (100.8, 9.85),
    "phyphox/android_semicolon_400hz": (408.0, 10.26),
    "sensor_logger/android_v1.31.4": (56.4, 9.81),
    "sensor_logger/ios_v1.10.4": (100.4, 10.02),
    "shimmer/consensys_semicolon_crlf.csv": (51.2, 9.44),
    "xio/ngimu_desk_50hz": (49.9, 9.81),
    "xio/ximu3_desk_50hz/Inertial.csv": (49.9, 9.79),
    "xio/ximu3_left_foot_udp": (49.9, 9.82),
    "xio/ximu_gait_tracking_short_walk.csv": (398.0, 9.81),
    "xsens_dot/app_offline_120hz_euler_acc_gyr.csv": (120.0, 9.64),
    "xsens_mtmanager/counter_quat_50hz.txt": (50.0, 9.76),
    "xsens_mtmanager/counter_latlon_120hz_lower_leg.txt": (120.0, 9.75),
    "xsens_mtmanager/MT_012005D6_031-000_00B421AF.txt": (100.0, 9.81),
    "xsens_mtmanager/MT_012005D6_009-001_00B421E6.txt": (100.0, 9.81),
}
ASKED = {
    # name: what the message asks for or says
    "lpms/lpmscontrol_figure8-x90.csv": r"gap of 0\.36 s.*--fill-gaps-s",
    "lpms/lpmscontrol_throwing-0.csv": r"gap of 0\.42 s.*--fill-gaps-s",
    "mobility_aids/wheelchair_frame_module_asphalt_100hz.csv": r"gap of 0\.59 s.*--fill-gaps-s",
    "mobility_aids/wheelchair_isen_joint_angles.csv": "unknown format.*--map",
    "mobility_aids/crutch_force_acc2axis_200hz.csv": "unknown format.*--map",
    "mobility_aids/wheelchair_headerless_frame_acc.csv": "unknown format.*--map",
    "phone_other/pololu_raw_counts_no_header.txt": "unknown format.*--map",
    "phone_other/ios_date_timestamp_acc.csv": "unknown format.*--map",
    "phone_other/android_logger_t_android_acc.csv": "unknown format.*--map",
    "phyphox/android_comma_linear_acceleration.csv": "accelerations without gravity",
    "phyphox/android_linear_acceleration_pause_resume.csv": "accelerations without gravity",
    "phyphox/ios_gyroscope_experiment_semicolon.csv": "no accelerations; give the folder",
    "sensor_logger/android_v1.31.4/TotalAcceleration.csv": "give the folder of the recording",
    "xio/ximu1_256hz/00033_CalInertialAndMag.csv": r"sampling rate \(its Registers.csv",
    "xsens_dot/app_realtime_60hz_pelvis.csv": "FreeAcc has no gravity",
    "xsens_dot/pc_sdk_log_oneline_header.csv": "FreeAcc has no gravity",
    "xsens_mtmanager/MT2022_ACC_00B42D4B.txt": "states no sampling rate",
    "xsens_mtmanager/MT2022_ACC_GYRO_ROT_MAT_COMMA_00B42D4B.txt": "states no sampling rate",
    "xsens_mtmanager/MT2022_ACC_GYRO_ROT_MAT_SPACE_00B42D4B.txt": "states no sampling rate",
    "xsens_mtmanager/MT_012005D6-000_sit_to_stand-000_00B421ED.txt": "no column Acc_X",
    "damaged_by_spreadsheet/phyphox_decimal_comma_lost_exponents.csv": r"gap of 1e\+07 s",
    "damaged_by_spreadsheet/bom_thousands_points_acc.csv": "unknown format",
    "damaged_by_spreadsheet/xsens_dot_euler_decimal_comma.csv": "no column Acc_X",
    "motion_bids/sub-pp002": "without a session that is known",
}


@pytest.mark.parametrize("name", READ)
def test_an_excerpt_is_read_with_its_rate_and_gravity(name):
    rate_hz, gravity = READ[name]
    found = understand(FOLDER / name)
    first = next(iter(found.recording.sensors.values()))
    length = np.median(np.linalg.norm(first.acc_mps2, axis=1))
    assert length == pytest.approx(gravity, abs=0.06)
    if rate_hz is not None:
        # Lost packets leave a hundredth or so, stamps of whole milliseconds a tenth.
        tolerance = 0.1 if name.startswith("shimmer") else 0.015
        assert found.recording.sampling_rate_hz == pytest.approx(rate_hz, rel=tolerance)


@pytest.mark.parametrize("name", ASKED)
def test_what_cannot_be_read_gets_the_right_question(name):
    with pytest.raises(InputError, match=ASKED[name]):
        understand(FOLDER / name)


def test_no_other_excerpt_ends_in_anything_but_an_answer():
    for path in sorted(FOLDER.rglob("*")):
        if path.relative_to(FOLDER).parts[0] in ("drives", "truth", "walks") or not path.is_file():
            continue
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            try:
                understand(path)
            except InputError as error:
                assert "\n" not in str(error)
