#!/usr/bin/env python3
"""Error of ‖a‖ on real recordings: gravical beside imucal, imu_tk and the script of the student report.

    cargo build --release
    python3 -m venv target/accuracy && target/accuracy/bin/pip install imucal==2.6.0
    . target/accuracy/bin/activate
    GRAVICAL_DATA=FOLDER python3 benches/accuracy.py

prints the table of the README. FOLDER holds the recordings of tests/data/SOURCES.md.

Every program gets the same rows of the same file and is tested on rows that it did not get: the error is that of the
magnitude of the mean of a static interval, ‖a‖/g − 1 in mg, rms over these intervals.

- *raw*: the nominal scale of the unit.
- *student's script*: Ferraris with the first 100 rows of each face and Rᵀ for R⁻¹, which gives the errors that the
  report prints (docs/method.md, Common mistakes).
- *imucal*: its Ferraris calibration, installed. It takes three turns for the gyroscope; where a recording has none,
  turns are made up, which do not enter its accelerometer.
- *imu_tk*: not run. Its published parameters of its own recording, and for the MPU-6050 those that another program
  with the same model published. Both were fitted to the poses that they are tested on.
- *gravical*: `calibrate --sections`. "Each left out": it is fitted again for each interval, without it and without
  those whose direction is less than 10° from it.

CPU time is user + system of a process from the file to the parameters, starting Python included: the least of RUNS,
mean of the recordings with six faces, rounded to 1, 2 or 5, which is what a busy machine allows to repeat.
"""

import csv
import dataclasses
import json
import math
import os
import pathlib
import subprocess
import sys
import tempfile

import numpy as np

ROOT = pathlib.Path(__file__).resolve().parent.parent
GRAVICAL = pathlib.Path(os.environ.get("CARGO_TARGET_DIR", ROOT / "target")) / "release/gravical"
RUNS = 5
FACES = ["x_p", "x_a", "y_p", "y_a", "z_p", "z_a"]

# Each prints {"matrix", "bias"} of matrix (raw - bias).
STUDENT = """
import json, sys
import numpy as np, pandas as pd
data = pd.read_csv(sys.argv[1]).to_numpy()[:, :3]
sections, g = json.load(open(sys.argv[2])), float(sys.argv[3])
mean = {name: data[s["start"]:s["start"] + 100].mean(axis=0) for name, s in sections.items()}
plus, minus = (np.column_stack([mean[axis + sign] for axis in "xyz"]) for sign in ("_p", "_a"))
bias, difference = np.diag(plus + minus) / 2, plus - minus
scale = np.linalg.norm(difference, axis=1) / (2 * g)
rotation = difference / scale[:, None] / (2 * g)
print(json.dumps({"matrix": (rotation.T / scale).tolist(), "bias": bias.tolist()}))
"""
IMUCAL = """
import json, sys, warnings
warnings.simplefilter("ignore")
import imucal, numpy as np, pandas as pd
data = pd.read_csv(sys.argv[1]).to_numpy()
sections, g, rate = json.load(open(sys.argv[2])), float(sys.argv[3]), float(sys.argv[4])
parts = {name: data[s["start"]:s["end"]] for name, s in sections.items()}
for i, axis in enumerate("xyz"):
    if axis + "_rot" not in parts:
        parts[axis + "_rot"] = np.tile(np.concatenate([parts[axis + "_p"][0, :3], -360 * np.eye(3)[i]]), (round(rate), 1))
fields = {f"{sensor}_{name}": part[:, columns] for name, part in parts.items()
          for sensor, columns in (("acc", slice(0, 3)), ("gyr", slice(3, 6)))}
regions = imucal.FerrarisSignalRegions(**{name: fields[name] for name in imucal.FerrarisSignalRegions._fields})
result = imucal.FerrarisCalibration(grav=g).compute(regions, rate, from_acc_unit="a.u.", from_gyr_unit="a.u.")
print(json.dumps({"matrix": (np.linalg.inv(result.R_a) @ np.linalg.inv(result.K_a)).tolist(), "bias": result.b_a.tolist()}))
"""


@dataclasses.dataclass
class Session:
    """A recording; `poses` name row ranges, `tests` are those of the intervals that are left out."""

    name: str
    data: np.ndarray
    gravity: float
    rate: float
    options: list
    poses: dict
    tests: list | None = None
    nominal: float | None = None
    published: tuple | None = None


def magnitude_errors(session, intervals, calibration):
    """‖a‖/g − 1 of each interval, mg."""
    matrix, bias = np.asarray(calibration[0]), np.asarray(calibration[1])
    means = [session.data[start:end, :3].mean(axis=0) for start, end in intervals]
    return [1000 * (np.linalg.norm(matrix @ (mean - bias)) / session.gravity - 1) for mean in means]


def rms(values):
    return math.sqrt(np.mean(np.square(values)))


def round_125(value):
    return f"{min((10.0**e * digit for e in range(-4, 4) for digit in (1, 2, 5)), key=lambda r: abs(math.log(r / value))):g}"


def static_intervals(accel, rest_rows, window=100, factor=6):
    """Windows whose variance is below `factor` times that of the rest at the start (Tedaldi et al. 2014)."""
    limit = factor * np.linalg.norm(accel[:rest_rows].var(axis=0))
    found = []
    for start in range(0, len(accel) - window + 1, 5):
        if np.linalg.norm(accel[start:start + window].var(axis=0)) < limit:
            if found and start <= found[-1][1]:
                found[-1][1] = start + window
            else:
                found.append([start, start + window])
    return [tuple(interval) for interval in found]


def load(path, **options):
    return np.genfromtxt(path, delimiter=",", **options)


def sessions(data):
    folder = data / "imucal-ferraris"
    rows = load(folder / "example_ferraris_session.csv", skip_header=1)[:, [4, 5, 6, 1, 2, 3]]
    sections = {name: (s["start"], s["end"])
                for name, s in json.loads((folder / "example_ferraris_session_list.json").read_text()).items()}
    last = max(sections[face][1] for face in FACES)
    turned = [(start, end) for start, end in static_intervals(rows[:, :3], 300) if start > last]
    yield Session("imucal's example: 6 faces; 6 rests", rows, 9.81, 102.4,
                  ["--accel-unit", "m/s^2", "--gyro-unit", "deg/s"], sections, turned, 1.0)

    folder, parts, poses = data / "airbrakes-sixmoves", [], {}
    tests = {"zplus": (2860, 3050), "zminus": (3950, 4170)}  # put back where it lay
    intervals, start = [], 0
    for face, name in zip(FACES, ["xplus", "xminus", "yplus", "yminus", "zplus", "zminus"]):
        part = load(folder / f"{name}.csv", skip_header=1)[:, 1:]
        part[:, 3:] = np.degrees(part[:, 3:])
        poses[face] = (start, start + 200)
        intervals += [(start + tests[name][0], start + tests[name][1])] if name in tests else []
        parts.append(part)
        start += len(part)
    yield Session("3DM-CX5: 6 faces; 2 rests after", np.vstack(parts), 9.80665, 1000,
                  ["--accel-unit", "g", "--gyro-unit", "deg/s"], poses, intervals, 9.80665)

    folder = data / "tomisuarez-mpu6050"
    rows = load(folder / "calibration.csv", skip_header=5)
    found = static_intervals(rows[:, :3], 3500)
    ayz, azy, azx, *rest = np.loadtxt(folder / "published_params_acc.csv")
    published = np.array([[1, -ayz, azy], [0, 1, -azx], [0, 0, 1]]) @ np.diag(rest[:3]), -np.array(rest[3:])
    order = ["z_p", "z_a", "x_a", "x_p", "y_a", "y_p"]
    counts = ["--accel-unit", "counts", "--accel-range", "2", "--gyro-unit", "counts", "--gyro-range", "250"]
    yield Session("MPU-6050: 6 faces; 4 oblique poses", rows, 9.80665, 100, counts, dict(zip(order, found)), found[6:],
                  9.80665 / 16384)
    names = order + [f"pose {i}" for i in range(7, len(found) + 1)]
    yield Session("MPU-6050: 10 poses, each left out", rows, 9.80665, 100, counts, dict(zip(names, found)),
                  nominal=9.80665 / 16384, published=published)

    folder = data / "imu_tk-xsens"
    rows = np.hstack([np.loadtxt(folder / f"xsens_{sensor}.txt.gz")[:, 1:] for sensor in ("acc", "gyro")])
    found = static_intervals(rows[:, :3], 5000)
    matrix = np.array([[1, -0.00335929903, -0.00890639474], [0, 1, -0.0213341192], [0, 0, 1]])
    published = matrix @ np.diag([0.00241278463, 0.00242712280, 0.00241168028]), [33124.1826, 33275.1794, 32364.4156]
    yield Session("Xsens: 38 poses, each left out", rows, 9.81744, 100,
                  ["--accel-unit", "counts", "--gyro-unit", "counts"],
                  {f"pose {i}": interval for i, interval in enumerate(found, 1)}, published=published)


def run(command):
    """What a process prints, and its CPU time in s."""
    process = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL)
    printed = process.stdout.read()
    _, status, usage = os.wait4(process.pid, 0)
    process.returncode = os.waitstatus_to_exitcode(status)
    # 4: fitted, and said to be poor.
    if process.returncode not in (0, 4):
        sys.exit(f"{command[:3]} ended with {process.returncode}")
    return json.loads(printed), usage.ru_utime + usage.ru_stime


def write_sections(path, poses):
    path.write_text(json.dumps({name: {"start": start, "end": end} for name, (start, end) in poses.items()}))


def commands(session, recording, sections):
    """How each program is called; the others need six faces."""
    gravity, rate = str(session.gravity), str(session.rate)
    options = ["--sections", sections, "--rate", rate, "--gravity", gravity, *session.options]
    yield "gravical", [GRAVICAL, "calibrate", recording, "--json", "--quiet", *options]
    if session.tests:
        for name, script in (("student", STUDENT), ("imucal", IMUCAL)):
            yield name, [sys.executable, "-c", script, recording, sections, gravity, rate]


def parameters(result):
    result = result.get("accelerometer", result)
    return result["matrix"], result["bias"]


def left_out_errors(session, calibration, recording, folder):
    """The error of each pose by a fit without it and its neighbours."""
    matrix, bias = (np.asarray(values) for values in calibration)
    vectors = {name: matrix @ (session.data[start:end, :3].mean(axis=0) - bias)
               for name, (start, end) in session.poses.items()}
    units = {name: vector / np.linalg.norm(vector) for name, vector in vectors.items()}
    sections, errors = folder / "others.json", []
    for name, interval in session.poses.items():
        others = {other: rows for other, rows in session.poses.items()
                  if units[name] @ units[other] < math.cos(math.radians(10))}
        write_sections(sections, others)
        _, command = next(commands(session, recording, sections))
        errors += magnitude_errors(session, [interval], parameters(run(command)[0]))
    return errors


def measure(session, folder):
    """The row of a session: texts by column; and the CPU time by program."""
    recording, sections = folder / "recording.csv", folder / "sections.json"
    with open(recording, "w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file)
        writer.writerow(["acc_x", "acc_y", "acc_z", "gyr_x", "gyr_y", "gyr_z"])
        writer.writerows(session.data.tolist())
    write_sections(sections, session.poses)
    texts, cpu_s = {"recording": session.name}, {}
    fitted = list(session.poses.values())
    for name, command in commands(session, recording, sections):
        results = [run(command) for _ in range(RUNS)]
        cpu_s[name] = min(seconds for _, seconds in results)
        result = results[0][0]
        calibration = parameters(result)
        if session.tests:
            texts[name] = f"{rms(magnitude_errors(session, session.tests, calibration)):.2f}"
        else:
            errors = left_out_errors(session, calibration, recording, folder)
            inside = rms(magnitude_errors(session, fitted, calibration))
            texts[name] = f"{rms(errors):.2f}; fitted: {inside:.2f}"
        if name == "gravical":
            limit = 1000 * result["reliability"]["worst_direction"]["error_mps2"] / session.gravity
            # As the program says it: of six faces the limit holds less often (docs/accuracy.md).
            share = 90 if result["reliability"]["left_out_rms_mps2"] is None else 95
            texts["limit"] = f"{limit:.2g} ({share} %), {result['verdict']['grade']}"
    if session.nominal:
        raw = np.eye(3) * session.nominal, np.zeros(3)
        texts["raw"] = f"{rms(magnitude_errors(session, session.tests or fitted, raw)):.1f}"
    if session.published:
        texts["imu_tk"] = f"fitted: {rms(magnitude_errors(session, fitted, session.published)):.2f}"
    return texts, cpu_s


def main():
    if "GRAVICAL_DATA" not in os.environ:
        sys.exit("GRAVICAL_DATA names the folder of the recordings (tests/data/SOURCES.md)")
    columns = {"recording": "error of ‖a‖, mg rms", "raw": "raw", "student": "student's script", "imucal": "imucal",
               "imu_tk": "imu_tk", "gravical": "gravical", "limit": "gravical's limit, verdict"}
    print("| " + " | ".join(columns.values()) + " |")
    print("|---" * len(columns) + "|")
    row = lambda texts: print("| " + " | ".join(texts.get(column, "–") for column in columns) + " |", flush=True)
    times = []
    with tempfile.TemporaryDirectory(prefix="gravical-accuracy-") as folder:
        for session in sessions(pathlib.Path(os.environ["GRAVICAL_DATA"])):
            texts, cpu_s = measure(session, pathlib.Path(folder))
            row(texts)
            if session.tests:
                times.append(cpu_s)
    cpu = {name: round_125(np.mean([cpu_s[name] for cpu_s in times])) for name in times[0]}
    row({"recording": "CPU time, 6 faces, s", **cpu})


if __name__ == "__main__":
    main()
