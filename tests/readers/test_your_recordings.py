"""What the page "Your own recordings" says of the program is what the program says."""

import re
from pathlib import Path

import numpy as np
import pytest
from scipy.spatial.transform import Rotation
from test_health import changed, clean, hold, spiked

from mobility_imu import scooter
from mobility_imu.cli.main import app
from mobility_imu.errors import InputError
from mobility_imu.faults import with_half
from mobility_imu.health import examine
from mobility_imu.readers.recordings import understand
from mobility_imu.readers.streams import FACTORS, held_warnings
from mobility_imu.recording import Imu, Recording
from mobility_imu.scooter import ScooterMount
from mobility_imu.scooter.exchanges import exchanged_halves
from mobility_imu.simulation.scooter import COURSES, draw_driver, draw_scooter, simulate_ride
from mobility_imu.wheelchair.slip import SlipSettings, at_odds

PAGE = (Path(__file__).resolve().parents[2] / "book" / "your_recordings.md").read_text()
LONGEST_LINE = 72


def boxes():
    return re.findall(r"```(\w+)\n(.*?)```", PAGE, re.DOTALL)


def of_a_ride():
    """Sentences on an accelerometer of a scooter that was made faulty in each way."""
    unit = draw_scooter(51)
    ride = simulate_ride(COURSES["curves"], seed=51, unit=unit, driver=draw_driver(51)).recording
    mount = ScooterMount(*(Rotation.from_rotvec(t).as_matrix() for t in unit.mountings.values()))
    acc = np.array(ride.sensor("lever").acc_mps2)
    noise = np.random.default_rng(1).normal(0, 0.01, acc.shape)
    part = (ride.time_s >= 8) & (ride.time_s < 11)
    fresh = np.arange(len(ride))
    fresh -= np.where(fresh % 50 < 15, fresh % 50, 0)
    turn = Rotation.from_euler("y", 40, degrees=True).as_matrix()
    late, body = (ride.time_s > ride.time_s[-1] / 2)[:, None], ride.sensor("body")
    slipped = Imu(*(np.where(late, v @ turn.T, v) for v in (body.acc_mps2, body.gyr_radps)))
    changes = {
        "no gravity": with_half(ride, "lever", "acc", np.where(part[:, None], noise, acc)),
        "scale": with_half(ride, "lever", "acc", 2 * acc),
        "held": with_half(ride, "lever", "acc", acc[fresh]),
        "reversed": with_half(ride, "lever", "acc", acc * [-1, 1, 1]),
        "slipped": Recording(ride.time_s, {"lever": ride.sensor("lever"), "body": slipped}),
        "exchanged": exchanged_halves(ride, "gyr"),
    }
    for code, faulty in changes.items():
        found = scooter.find_faults(faulty, scooter.SUZUKI_ET4D, mount)
        yield next(fault.told for fault in found if fault.code == code)


def of_sensors():
    """Sentences on a wheel that was made faulty in each way, and on two names for one sensor."""
    drive, wheel = clean("wheelchair", 1), "left_wheel"
    fastest = np.abs(drive.sensor(wheel).gyr_radps).max()
    changes = (
        lambda v: hold(v, 0.5),
        lambda v: v * [1, 0, 1],
        lambda v: spiked(v, 34.0),
        lambda v: np.clip(v, -fastest / 2, fastest / 2),
        lambda v: -v,
    )
    for change in changes:
        (fault,) = examine(changed(drive, wheel, gyr=change))
        yield fault.told
    yield from of_a_ride()
    twice = {name: drive.sensor(wheel) for name in (wheel, "right_wheel")}
    yield from (fault.told for fault in examine(Recording(drive.time_s, twice)))


def of_files():
    yield from at_odds(np.ones(9), np.ones(9), -np.ones(9), SlipSettings(), "a.csv")
    acc = np.repeat(np.random.default_rng(1).standard_normal((50, 3)), 4, axis=0)
    yield from held_warnings(np.arange(200) / 100, acc, "a.csv")


def test_warnings_are_quoted_as_they_are():
    quoted = re.findall(r'^\| "(.*?)" \|', PAGE, re.MULTILINE)
    said = [*of_sensors(), *of_files()]
    assert len(quoted) == len(said)
    for words, sentence in zip(quoted, said, strict=True):
        assert words in sentence


def test_commands_that_look_at_the_sensors_have_the_option_that_refuses():
    sentence = re.search(r"commands that compute from sensors \((.*?)\)", PAGE, re.DOTALL)[1]
    device, named = "", set()
    for words in re.findall(r"`(.*?)`", sentence.replace("\n", " ")):
        *before, command = words.split()
        device = before[0] if before else device
        named.add((device, command))
    strict = set()
    for group in app.registered_groups:
        for command in group.typer_instance.registered_commands:
            if "strict" in command.callback.__annotations__:
                strict.add((group.name, command.name))
    assert named == strict
    assert not any("strict" in c.callback.__annotations__ for c in app.registered_commands)


def test_tables_in_g_and_without_gravity_are_refused():
    time_s, up = np.arange(200) / 100, np.array([0.0, 0.0, 1.0])
    for size, says in ((1.0, "this looks like g"), (0.01, "was gravity taken out")):
        with pytest.raises(InputError, match=says):
            Recording(time_s, {"frame": Imu(np.tile(size * up, (200, 1)))})


def test_units_are_those_that_are_known():
    known = {*FACTORS["speed"], *FACTORS["gyr"]}
    sentence = re.search(r"The program knows (.*?)\. If", PAGE, re.DOTALL)[1]
    assert set(re.split(r",\s|\sand\s", sentence)) == known


def test_lines_of_code_fit_the_page():
    for _, text in boxes():
        assert max(len(line) for line in text.splitlines()) <= LONGEST_LINE


def test_names_of_several_files_are_given_as_the_page_says(tmp_path):
    drive, folder = clean("wheelchair", 1), tmp_path
    (names,) = re.findall(r"^ +(frame=f\.csv,\S+) ", PAGE, re.MULTILINE)
    for part in names.split(","):
        sensor, file = part.split("=")
        one = Recording(drive.time_s, {sensor: drive.sensor(sensor)})
        one.to_frame().to_csv(folder / file, index=False)
    parts = [part.replace("=", f"={folder}/") for part in names.split(",")]
    for name in (",".join([*parts, "clock=same"]), [*parts, "clock=same"]):
        assert list(understand(name).recording.sensors) == list(drive.sensors)
