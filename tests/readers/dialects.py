"""Writes a recording as vendors' software does, for the tests of the readers.

Each writer takes a recording, a path or folder, and gives the name that a command is called with.
Grammar, units and signs are those of public files of each vendor.
"""

import json

import numpy as np
import pandas as pd

from mobility_imu.frames import STANDARD_GRAVITY_MPS2 as G

XYZ = "XYZ"


def columns(imu, acc_names, gyr_names, acc_scale=1.0, gyr_scale=1.0):
    found = {n: v * acc_scale for n, v in zip(acc_names, imu.acc_mps2.T, strict=True)}
    if imu.gyr_radps is not None and gyr_names:
        rates = zip(gyr_names, imu.gyr_radps.T, strict=True)
        found |= {n: v * gyr_scale for n, v in rates}
    return found


def single(recording):
    (imu,) = recording.sensors.values()
    return imu


def xsens_mt(recording, folder, separator="\t", head="// Update Rate: 100.0Hz\n", fine=False):
    names = {"frame": "Frame", "left_wheel": "LeftWheel", "right_wheel": "RightWheel"}
    for sensor, imu in recording.sensors.items():
        table = {"PacketCounter": (65300 + np.arange(len(recording))) % 65536}
        if fine:
            table["SampleTimeFine"] = np.rint(recording.time_s * 1e4).astype(int) + 777
        table |= columns(imu, [f"Acc_{a}" for a in XYZ], [f"Gyr_{a}" for a in XYZ])
        text = "// General information:\n" + head
        text += pd.DataFrame(table).to_csv(index=False, sep=separator)
        (folder / f"MT-{names.get(sensor, sensor)}.txt").write_text(text)
    return folder / "MT"


def xsens_dot(recording, folder):
    table = {
        "PacketCounter": np.arange(len(recording)),
        "SampleTimeFine": (2**32 - 500_000 + np.rint(recording.time_s * 1e6).astype(int)) % 2**32,
    } | columns(
        single(recording), [f"Acc_{a}" for a in XYZ], [f"Gyr_{a}" for a in XYZ], 1, 180 / np.pi
    )
    text = "sep=,\nDeviceTag:,frame\nFirmwareVersion:,2.0.0\n\n" + pd.DataFrame(table).to_csv(
        index=False
    )
    (folder / "dot.csv").write_text(text)
    return folder / "dot.csv"


def lpms(recording, folder):
    rows = []
    for number, sensor in enumerate(recording.sensors, start=1):
        imu = recording.sensors[sensor]
        rows.append(
            pd.DataFrame(
                {"SensorId": number, " TimeStamp (s)": recording.time_s, " FrameNumber": 0}
                | columns(
                    imu, [f" Acc{a} (g)" for a in XYZ], [f" Gyro{a} (deg/s)" for a in XYZ],
                    -1 / G, 180 / np.pi,
                )
            )
        )  # fmt: skip
    table = pd.concat(rows).sort_values(" TimeStamp (s)", kind="stable")
    (folder / "lpms.csv").write_text(table.to_csv(index=False, lineterminator="\r\n"))
    return folder / "lpms.csv"


def xio_table(recording, imu, clock, scale):
    names = [f"Accelerometer {a} (g)" for a in XYZ], [f"Gyroscope {a} (deg/s)" for a in XYZ]
    table = {clock: recording.time_s * scale} | columns(imu, *names, 1 / G, 180 / np.pi)
    return pd.DataFrame(table)[[clock, *names[1], *names[0]]]


def ngimu(recording, folder):
    for sensor, imu in recording.sensors.items():
        inner = folder / f"NGIMU - {sensor.replace('_wheel', '')} - 00337909"
        inner.mkdir(parents=True)
        xio_table(recording, imu, "Time (s)", 1.0).to_csv(inner / "sensors.csv", index=False)
        (inner / "quaternion.csv").write_text("Time (s),W,X,Y,Z\n0,1,0,0,0\n")
    return folder


def ximu3(recording, folder):
    table = xio_table(recording, single(recording), "Timestamp (us)", 1e6)
    table.iloc[:, 0] += 392_000_000
    table.to_csv(folder / "Inertial.csv", index=False)
    return folder / "Inertial.csv"


def apdm(recording, folder):
    imu = single(recording)
    table = {"Time": recording.time_s} | columns(
        imu,
        [f"Frame/Acceleration/{a}" for a in XYZ],
        [f"Frame/Angular Velocity/{a}" for a in XYZ],
    )
    text = pd.DataFrame(table).to_csv(index=False)
    names, rows = text.split("\n", 1)
    head = f"Test Name:,Walk{',' * 5}\nSample Rate:,100,Hz,,,,\n"
    units = "s,m/s^2,m/s^2,m/s^2,rad/s,rad/s,rad/s\n"
    (folder / "apdm.csv").write_text(f"{head}{names}\n{units}{rows}")
    return folder / "apdm.csv"


def apdm_format_7(recording, folder):
    imu = single(recording)
    text = pd.DataFrame(
        {"t": np.rint(1.55e15 + recording.time_s * 1e6).astype(np.int64)}
        | columns(imu, [f"a{a}" for a in XYZ], [f"g{a}" for a in XYZ])
    ).to_csv(index=False, header=False)
    head = "Format=7,5718,,,Frame,,\nTime,Accelerometer,,,Gyroscope,,\n,X,Y,Z,X,Y,Z\n"
    (folder / "apdm7.csv").write_text(head + text)
    return folder / "apdm7.csv"


def shimmer(recording, folder):
    name = "Shimmer_40AC"
    table = {f"{name}_Timestamp_Unix_CAL": recording.time_s * 1e3 + 1.5e12} | columns(
        single(recording),
        [f"{name}_Accel_WR_{a}_CAL" for a in XYZ],
        [f"{name}_Gyro_{a}_CAL" for a in XYZ],
        1,
        180 / np.pi,
    )
    text = pd.DataFrame(table).to_csv(index=False, sep=";")
    names, rows = text.split("\n", 1)
    units = ";".join(["ms", *["m/(s^2)"] * 3, *["deg/s"] * 3])
    lines = [f"{line};" for line in [names, units, *rows.rstrip().split("\n")]]
    (folder / "shimmer.csv").write_text('"sep=;"\r\n' + "\r\n".join(lines) + "\r\n")
    return folder / "shimmer.csv"


def movesense(recording, folder):
    imu = single(recording)
    blocks = []
    for begin in range(0, len(recording) - 7, 8):
        rows = range(begin, begin + 8)
        blocks.append(
            {
                "ArrayAcc": [dict(zip("xyz", imu.acc_mps2[k], strict=True)) for k in rows],
                "ArrayGyro": [
                    dict(zip("xyz", np.rad2deg(imu.gyr_radps[k]), strict=True)) for k in rows
                ],
                "Timestamp": round(1e3 * recording.time_s[begin]),
            }
        )
    (folder / "movesense.json").write_text(json.dumps({"Meas": {"IMU9": blocks}}))
    return folder / "movesense.json"


def actigraph(recording, folder):
    imu = single(recording)
    stamps = pd.Timestamp("2019-02-14T08:58:00") + pd.to_timedelta(recording.time_s, unit="s")
    table = {"Timestamp": stamps.strftime("%Y-%m-%dT%H:%M:%S.%f0")} | columns(
        imu,
        [f"Accelerometer {a}" for a in XYZ],
        [f"Gyroscope {a}" for a in XYZ],
        1 / G,
        180 / np.pi,
    )
    head = (
        "------------ Data File Created By ActiGraph Link IMU 9DOF Sensor ActiLife v6.13.3 "
        "Firmware v1.7.2 date format M/d/yyyy at 100 Hz  -----------\nSerial Number: T\n"
        "Start Time 08:58:00\nStart Date 2/14/2019\nEpoch Period (hh:mm:ss) 00:00:00\n"
        "Download Time 09:03:03\nDownload Date 2/14/2019\nCurrent Memory Address: 0\n"
        f"Current Battery Voltage: 4.15     Mode = 12\n{'-' * 50}\n"
    )
    (folder / "actigraph.csv").write_text(head + pd.DataFrame(table).to_csv(index=False))
    return folder / "actigraph.csv"


def json_samples(recording, folder):
    imu = single(recording)
    cells = {f"acc_{axis}": imu.acc_mps2[:, k] / G for k, axis in enumerate("xyz")}
    cells |= {f"gy_{axis}": np.rad2deg(imu.gyr_radps[:, k]) for k, axis in enumerate("xyz")}
    table = pd.DataFrame({"timestamp": recording.time_s} | cells)
    (folder / "samples.json").write_text(json.dumps(table.to_dict("records")))
    return folder / "samples.json"


def sensor_logger(recording, folder, platform="android"):
    imu, base = single(recording), 1_713_800_421_000_000_000
    stamps = {
        "time": base + np.rint(recording.time_s * 1e9).astype(np.int64),
        "seconds_elapsed": recording.time_s,
    }

    def write(name, values):
        table = stamps | dict(zip("zyx", values.T[::-1], strict=True))
        (folder / f"{name}.csv").write_text(pd.DataFrame(table).to_csv(index=False).rstrip())

    if platform == "android":
        write("TotalAcceleration", imu.acc_mps2)
        write("Accelerometer", imu.acc_mps2 - [0, 0, G])
    else:
        gravity = np.tile([0.3, -0.2, -9.79], (len(recording), 1))
        write("Gravity", gravity)
        write("Accelerometer", -imu.acc_mps2 - gravity)
        write("AccelerometerUncalibrated", -imu.acc_mps2 / G)
    write("Gyroscope", imu.gyr_radps)
    (folder / "Annotation.csv").write_text("")
    (folder / "Metadata.csv").write_text(
        f"version,device name,platform,appVersion\n3,phone,{platform},1.31.4"
    )
    return folder


def phyphox(recording, folder, separator=","):
    imu = single(recording)
    for name, values, unit in (
        ("Accelerometer", imu.acc_mps2, "m/s^2"),
        ("Gyroscope", imu.gyr_radps, "rad/s"),
    ):
        names = separator.join(['"Time (s)"', *(f'"{a} ({unit})"' for a in XYZ)])
        rows = np.column_stack([recording.time_s, values])
        lines = [separator.join(f"{v:.15E}" for v in row) for row in rows]
        (folder / f"{name}.csv").write_text("\n".join([names, *lines]))
    (folder / "meta").mkdir()
    (folder / "meta/time.csv").write_text('"event","experiment time"\n"START",0\n')
    return folder


def androsensor(recording, folder):
    wall = pd.Timestamp("2019-04-29 17:21:51.640") + pd.to_timedelta(recording.time_s, unit="s")
    table = columns(
        single(recording),
        [f"ACCELEROMETER {a} (m/s²)" for a in XYZ],
        [f"GYROSCOPE {a} (rad/s)" for a in XYZ],
    ) | {
        "Time since start in ms ": recording.time_s * 1e3,
        "YYYY-MO-DD HH-MI-SS_SSS": [
            f"{t:%Y-%m-%d %H:%M:%S}:{t.microsecond // 1000:03d}" for t in wall
        ],
    }
    pd.DataFrame(table).to_csv(folder / "andro.csv", index=False)
    return folder / "andro.csv"


def physics_toolbox(recording, folder):
    table = {"time": recording.time_s} | columns(
        single(recording), [f"gF{a}" for a in "xyz"], [f"w{a}" for a in "xyz"], 1 / G
    )
    lines = pd.DataFrame(table).to_csv(index=False).rstrip().split("\n")
    (folder / "toolbox.csv").write_text("\n" + "\n".join(f"{line}," for line in lines) + "\n")
    return folder / "toolbox.csv"


def canonical(recording, folder, **options):
    recording.to_frame().to_csv(folder / "own.csv", **({"index": False} | options))
    return folder / "own.csv"


def excel_german(recording, folder):
    return canonical(recording, folder, sep=";", decimal=",")


def excel_sep_line(recording, folder):
    text = "sep=;\n" + recording.to_frame().to_csv(index=False, sep=";")
    (folder / "sep.csv").write_text(text)
    return folder / "sep.csv"


def utf16(recording, folder):
    return canonical(recording, folder, sep="\t", encoding="utf-16")


def pandas_index(recording, folder):
    return canonical(recording, folder, index=True)


def quoted_with_extras(recording, folder):
    table = recording.to_frame()
    table["mag_x_ut"] = 1.0
    table["note"] = "a; b, c"
    table.to_csv(folder / "extras.csv", index=False, quoting=2)
    return folder / "extras.csv"


def r_table(recording, folder):
    table = recording.to_frame()
    table.index = [f"{k + 1}" for k in range(len(table))]
    text = table.to_csv(quoting=2)
    (folder / "r.csv").write_text(text.replace('"",', "", 1))
    return folder / "r.csv"
