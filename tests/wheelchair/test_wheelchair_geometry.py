"""Wheelchair: what is measured on the chair."""

import math
from dataclasses import replace

import numpy as np
import pytest
from chairs import (
    CHAIRS,
    ROUNDING,
)

from mobility_imu.errors import InputError
from mobility_imu.wheelchair import (
    SAMPLE_CHAIR,
    WheelchairGeometry,
)
from mobility_imu.wheelchair.geometry import DOCUMENT_TO_CHAIR, side_sign


@pytest.mark.parametrize("side", ["left", "right"])
@pytest.mark.parametrize("camber_deg", [0, 3, 19, 24])
def test_wheel_touches_the_floor_half_a_track_beside_the_middle(side, camber_deg):
    chair = WheelchairGeometry.from_degrees(
        camber_deg, wheel_radius_left_m=0.31, wheel_radius_right_m=0.33, track_m=0.8
    )
    axle, centre = chair.axle_direction(side), chair.wheel_centre(side)
    assert abs(np.linalg.norm(axle) - 1) < ROUNDING
    down_the_wheel = np.cross(axle, [1, 0, 0])  # in the wheel's plane, across the travel
    contact = centre + getattr(chair.wheel_radius_m, side) * down_the_wheel
    assert contact == pytest.approx([0, side_sign(side) * 0.4, 0], abs=ROUNDING)
    # forward roll: the point on the floor is at rest when the centre moves forward at r per rad
    assert np.cross(axle, contact - centre)[0] < 0
    # tops lean in
    assert abs(centre[1]) <= 0.4


def test_distance_of_the_wheel_centres_is_that_between_their_places():
    apart = SAMPLE_CHAIR.wheel_centre("left") - SAMPLE_CHAIR.wheel_centre("right")
    assert apart[1] == pytest.approx(SAMPLE_CHAIR.wheel_centre_distance_m, abs=ROUNDING)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"camber_rad": 19}, "camber_rad = 19.*camber in degrees"),
        ({"camber_rad": math.nan}, "camber_rad = nan"),
        ({"wheel_radius_left_m": 31.47}, "wheel_radius_left_m = 31.47.*cm"),
        ({"wheel_radius_right_m": 2.0}, "wheel_radius_right_m = 2.*circumference"),
        ({"wheel_radius_right_m": -0.3}, "wheel_radius_right_m = -0.3"),
        ({"track_m": 84}, "track_m = 84.*cm"),
        ({"track_m": 0.35}, "wheel centres"),
    ],
)
def test_impossible_chairs_are_refused_with_the_value_and_a_guess(change, message):
    with pytest.raises(InputError, match=message):
        replace(SAMPLE_CHAIR, **change)


def test_camber_given_in_radians_where_degrees_are_asked_is_refused():
    with pytest.raises(InputError, match=r"radians.*camber_rad = 0\.33 if it is.*0\.00576 if not"):
        WheelchairGeometry.from_degrees(
            0.33, wheel_radius_left_m=0.3, wheel_radius_right_m=0.3, track_m=0.8
        )


@pytest.mark.parametrize("camber_rad", [0.0, 1e-6, 0.005, -0.0105, 0.02, 0.33])
def test_every_camber_comes_back_from_its_file(tmp_path, camber_rad):
    """Also one below 0.6 degrees, which in degrees would look like an angle in radians."""
    chair = replace(SAMPLE_CHAIR, camber_rad=camber_rad)
    chair.to_toml(tmp_path / "geometry.toml")
    read = WheelchairGeometry.from_toml(tmp_path / "geometry.toml")
    assert read.camber_rad == pytest.approx(camber_rad, rel=1e-11, abs=0)


def test_roll_out_length_gives_the_same_chair_as_the_radius():
    rolled = WheelchairGeometry.from_circumference(
        19,
        wheel_circumference_left_m=2 * math.pi * 0.3147,
        wheel_circumference_right_m=2 * math.pi * 0.3195,
        track_m=0.84,
    )
    for name in vars(rolled):
        assert getattr(rolled, name) == pytest.approx(getattr(SAMPLE_CHAIR, name), abs=ROUNDING)


def write_toml(folder, text):
    path = folder / "geometry.toml"
    path.write_text(text)
    return path


WHEELCHAIR_TOML = """[wheelchair]
camber_deg = 19.0
wheel_radius_left_m = 0.3147
wheel_radius_right_m = 0.3195
track_m = 0.84
"""


def test_geometry_file(tmp_path):
    path = write_toml(tmp_path, WHEELCHAIR_TOML + "[scooter]\nlever_inclination_deg = 9\n")
    assert WheelchairGeometry.from_toml(path) == SAMPLE_CHAIR


@pytest.mark.parametrize(
    ("text", "message"),
    [
        (WHEELCHAIR_TOML.replace("track_m = 0.84", ""), "track_m is missing"),
        (WHEELCHAIR_TOML.replace("track_m", "trak_m"), "trak_m is unknown"),
        (WHEELCHAIR_TOML.replace("0.84", '"0.84"'), "track_m = '0.84': expected a number"),
        (WHEELCHAIR_TOML.replace("0.84", "84"), r"\[wheelchair\].*track_m = 84"),
        (WHEELCHAIR_TOML.replace("0.84", "0,84"), "not valid TOML"),
        (WHEELCHAIR_TOML + "camber_rad = 0.1\n", "camber_rad and camber_deg are both"),
        (WHEELCHAIR_TOML.replace("camber_deg", "camber_rad"), r"\[wheelchair\].*camber_rad = 19"),
        ("[scooter]\n", r"no section \[wheelchair\]"),
        ("", "empty"),
    ],
)
def test_bad_geometry_file_is_named_with_what_is_wrong(tmp_path, text, message):
    path = write_toml(tmp_path, text)
    with pytest.raises(InputError, match=message) as error:
        WheelchairGeometry.from_toml(path)
    assert str(path) in str(error.value)


@pytest.mark.parametrize("name", ["camber_rad", "wheel_radius_left_m", "track_m"])
@pytest.mark.parametrize("value", ["0.3", None, True, 1j, [0.3], np.nan])
def test_dimensions_that_are_no_numbers_are_refused(name, value):
    with pytest.raises(InputError, match=f"{name} = .*expected a number"):
        replace(SAMPLE_CHAIR, **{name: value})


def test_dimensions_of_numpy_become_floats():
    chair = replace(SAMPLE_CHAIR, track_m=np.float32(0.75), camber_rad=np.float64(0.25))
    assert type(chair.track_m) is float and type(chair.camber_rad) is float
    assert chair == replace(SAMPLE_CHAIR, track_m=0.75, camber_rad=0.25)


@pytest.mark.parametrize("camber_deg", [80, -30, 1e6, math.inf])
def test_a_camber_in_degrees_is_answered_in_degrees(tmp_path, camber_deg):
    with pytest.raises(InputError, match="camber_deg = ") as error:
        WheelchairGeometry.from_degrees(
            camber_deg, wheel_radius_left_m=0.3, wheel_radius_right_m=0.3, track_m=0.8
        )
    assert "rad" not in str(error.value)
    if math.isfinite(camber_deg):
        assert "expected between -5.7 and 35 deg" in str(error.value)
    text = WHEELCHAIR_TOML.replace("19.0", str(camber_deg))
    with pytest.raises(InputError, match=r"\[wheelchair\].*camber_deg = "):
        WheelchairGeometry.from_toml(write_toml(tmp_path, text))


@pytest.mark.parametrize("chair", [SAMPLE_CHAIR, *CHAIRS])
def test_a_written_geometry_reads_as_the_same(tmp_path, chair):
    path = tmp_path / "geometry.toml"
    assert chair.to_toml(path) == path.read_text()
    found = WheelchairGeometry.from_toml(path)
    for name in vars(chair):
        assert getattr(found, name) == pytest.approx(getattr(chair, name), abs=ROUNDING)
    assert SAMPLE_CHAIR.to_toml() == WHEELCHAIR_TOML


@pytest.mark.parametrize("length", ["2.0", -2.0, None, np.nan])
def test_roll_out_lengths_are_checked(length):
    with pytest.raises(InputError, match="wheel_circumference_right_m = "):
        WheelchairGeometry.from_circumference(
            0, wheel_circumference_left_m=2.0, wheel_circumference_right_m=length, track_m=0.8
        )


def test_wheel_centres_too_close_for_a_chair_are_refused():
    """With 20 deg of camber the centres are 0.205 m closer than the tracks of the tyres."""
    for track, fits in ((0.50, True), (0.44, True), (0.38, False)):
        sizes = {"wheel_radius_left_m": 0.3, "wheel_radius_right_m": 0.3, "track_m": track}
        if fits:
            WheelchairGeometry(np.deg2rad(20), **sizes)
        else:
            with pytest.raises(InputError, match="track_m"):
                WheelchairGeometry(np.deg2rad(20), **sizes)


def test_the_documents_axes_cannot_be_changed():
    with pytest.raises(ValueError, match="read-only"):
        DOCUMENT_TO_CHAIR[0, 0] = 2.0


@pytest.mark.parametrize(
    ("name", "within", "beyond"),
    [
        ("camber_deg", 35.0, 35.1),
        ("camber_deg", -5.7, -5.8),
        ("wheel_radius_left_m", 0.1, 0.099),
        ("wheel_radius_right_m", 0.5, 0.501),
    ],
)
def test_what_no_chair_has_is_refused_from_the_limit_on(name, within, beyond):
    usual = {"wheel_radius_left_m": 0.3, "wheel_radius_right_m": 0.3, "track_m": 0.8}
    usual["camber_deg"] = 10.0
    WheelchairGeometry.from_degrees(**{**usual, name: within})
    with pytest.raises(InputError, match=f"{name} = "):
        WheelchairGeometry.from_degrees(**{**usual, name: beyond})
