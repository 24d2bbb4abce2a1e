#!/usr/bin/env python3
"""Speed and memory of the Python package beside imucal, gaitmap, scipy, allantools and pandas.

    pip install ./crates/gravical-python -r benches/python/requirements.txt
    python benches/python/compare.py             a table of CPU time and memory
    python benches/python/compare.py --rows 1e5  smaller recordings

All in one run on one machine, each in a process of its own: the best of three times, and by how much
the highest memory of the process grew beyond its start, over the size of the arrays that go in. It
fails where gravical is slower at the same work. Some lines are not the same work: MORE says what
gravical computes beyond it.
"""

from __future__ import annotations

import argparse
import gc
import multiprocessing
import os
import resource
import sys
import tempfile
import time
import warnings
from collections.abc import Callable
from typing import Any

warnings.simplefilter("ignore")

import allantools  # noqa: E402
import gravical  # noqa: E402
import imucal  # noqa: E402
import numpy as np  # noqa: E402
import pandas  # noqa: E402
from gaitmap.trajectory_reconstruction import RtsKalman  # noqa: E402
from scipy.signal import butter, savgol_filter, sosfiltfilt  # noqa: E402

RATE = 100.0
# Not the same work: what gravical computes beyond the other.
MORE = {
    "calibrate, method Ferraris": "finds the poses; uncertainty, tests, verdict",
    "noise, Allan deviation": "rests; intervals; N, B and K with theirs",
    "Butterworth, zero phase": "gaps, uneven stamps; noise before and after",
    "Savitzky–Golay": "gaps, uneven stamps; noise before and after",
}
REPEATS = 3


def samples(rows: int) -> dict[str, Any]:
    """A recording at rest with moves, in m/s² and rad/s."""
    g = np.random.default_rng(1)
    t = np.arange(rows) / RATE
    accel = g.normal(0, 0.03, (rows, 3))
    accel[:, 2] += 9.81
    gyro = g.normal(0, 1e-3, (rows, 3))
    # A move of 2 s every 20 s.
    phase = t % 20.0
    moving = (phase > 10) & (phase < 12)
    accel[:, 1] += np.where(moving, np.sin(np.pi * (phase - 10)), 0.0)
    return {"t": t, "accel": accel, "gyro": gyro}


def session(hold: float) -> dict[str, np.ndarray]:
    """Six faces and three turns of 360°, as imucal takes them: accelerometer and gyroscope."""
    g = np.random.default_rng(2)
    n = int(hold * RATE)
    out: dict[str, np.ndarray] = {}
    for axis, name in enumerate("xyz"):
        for sign, end in ((1, "p"), (-1, "a")):
            a = g.normal(0, 0.03, (n, 6))
            a[:, 3:] *= 0.03
            a[:, axis] += sign * 9.81
            out[f"{name}_{end}"] = a
        turn = g.normal(0, 0.03, (n, 6))
        turn[:, 3:] *= 0.03
        turn[:, 3 + axis] += -360.0 / hold
        out[f"{name}_rot"] = turn
    return out


def measured(call: Callable[[], Any], size: int, out: Any) -> None:
    gc.collect()
    before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    times = []
    for _ in range(REPEATS):
        begun = time.perf_counter()
        result = call()
        times.append(time.perf_counter() - begun)
        del result
    after = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    out.put((min(times), (after - before) * 1024 / size))


def run(call: Callable[[], Any], size: int) -> tuple[float, float]:
    context = multiprocessing.get_context("fork")
    out = context.Queue()
    process = context.Process(target=measured, args=(call, size, out))
    process.start()
    done: tuple[float, float] = out.get(timeout=3600)
    process.join()
    return done


def cases(rows: int, folder: str) -> list[tuple[str, str, int, Callable[[], Any], Callable[[], Any]]]:
    """What is done, beside what, size of its input, and how both do it."""
    data = samples(rows)
    t, accel, gyro = data["t"], data["accel"], data["gyro"]
    size = sum(values.nbytes for values in data.values())
    path = os.path.join(folder, "rows.csv")
    table = np.column_stack([t, accel, gyro])
    np.savetxt(path, table, delimiter=",", header="t,ax,ay,az,gx,gy,gz", comments="", fmt="%.5f")
    own = gravical.Recording.from_arrays(**data, accel_unit="m/s^2", gyro_unit="rad/s")

    poses = session(20.0)
    pose_size = sum(values.nbytes for values in poses.values())
    order = ["x_p", "x_a", "y_p", "y_a", "z_p", "z_a", "x_rot", "y_rot", "z_rot"]
    stacked = np.concatenate([poses[name] for name in order])
    faces = gravical.Recording.from_arrays(
        t=np.arange(len(stacked)) / RATE, accel=stacked[:, :3], gyro=stacked[:, 3:],
        labels=np.repeat(order, [len(poses[name]) for name in order]), accel_unit="m/s^2", gyro_unit="deg/s",
    )  # fmt: skip
    ferraris, regions = imucal.FerrarisCalibration(), imucal_regions(poses)
    units = {"from_acc_unit": "m/s^2", "from_gyr_unit": "deg/s"}
    calibration = gravical.calibrate(gravical.simulate("poses", free=8, seed=3).recordings["poses.csv"], gravity=9.80665)
    theirs = imucal.CalibrationInfo.from_json(calibration.export("imucal"))

    half = rows // 2
    g = np.random.default_rng(3)
    still = {"t": t[:half], "accel": g.normal(0, 0.03, (half, 3)) + [0, 0, 9.81], "gyro": g.normal(0, 1e-3, (half, 3))}
    lying = gravical.Recording.from_arrays(**still, accel_unit="m/s^2", gyro_unit="rad/s")
    channels = [np.ascontiguousarray(c) for c in (*still["accel"].T, *still["gyro"].T)]
    sos = butter(4, 5.0, fs=RATE, output="sos")
    names = ["acc_x", "acc_y", "acc_z", "gyr_x", "gyr_y", "gyr_z"]
    frame = pandas.DataFrame(np.column_stack([accel, np.degrees(gyro)]), columns=names)
    return [
        ("read a CSV of seven columns", "pandas.read_csv", size,
         lambda: gravical.read(path), lambda: pandas.read_csv(path)),
        ("calibrate, method Ferraris", "imucal", pose_size,
         lambda: gravical.calibrate(faces, method="ferraris", gravity=9.81),
         lambda: ferraris.compute(regions, RATE, **units)),
        ("apply to both sensors", "imucal", size,
         lambda: calibration.apply_gyro(gyro, calibration.apply(accel)),
         lambda: theirs.calibrate(accel, gyro, "m/s^2", "rad/s")),
        ("Butterworth, zero phase", "scipy sosfiltfilt", size,
         lambda: gravical.denoise(own, "butter:4,5Hz"),
         lambda: [sosfiltfilt(sos, values, axis=0) for values in (accel, gyro)]),
        ("Savitzky–Golay", "scipy savgol_filter", size,
         lambda: gravical.denoise(own, "savgol:11,2"),
         lambda: [savgol_filter(values, 11, 2, axis=0) for values in (accel, gyro)]),
        ("noise, Allan deviation", "allantools oadev", size // 2,
         lambda: gravical.noise(lying),
         lambda: [allantools.oadev(c, rate=RATE, data_type="freq", taus="octave") for c in channels]),
        ("position with error bands", "gaitmap RtsKalman", size,
         lambda: gravical.motion(own), lambda: RtsKalman().estimate(frame, sampling_rate_hz=RATE)),
    ]  # fmt: skip


def imucal_regions(poses: dict[str, np.ndarray]) -> Any:
    """The session as imucal takes it."""
    fields = {}
    for name, values in poses.items():
        for sensor, part in (("acc", slice(0, 3)), ("gyr", slice(3, 6))):
            fields[f"{sensor}_{name}"] = values[:, part]
    return imucal.FerrarisSignalRegions(**{f: fields[f] for f in imucal.FerrarisSignalRegions._fields})


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--rows", type=lambda text: int(float(text)), default=1_000_000)
    parser.add_argument("--only", default="", help="part of what is measured")
    arguments = parser.parse_args()
    slower = []
    print(f"{arguments.rows} rows, {os.cpu_count()} cores, best of {REPEATS}\n")
    print("| what | beside | gravical, s | other, s | times faster | gravical, memory | other, memory |")
    print("|---|---|---|---|---|---|---|")
    with tempfile.TemporaryDirectory() as folder:
        for what, beside, size, ours, other in cases(arguments.rows, folder):
            if arguments.only not in what:
                continue
            (own_s, own_memory), (other_s, other_memory) = run(ours, size), run(other, size)
            if own_s > other_s and what not in MORE:
                slower.append(what)
            print(
                f"| {what} | {beside} | {own_s:.3g} | {other_s:.3g} | {other_s / own_s:.1f} "
                f"| {own_memory:.1f} × | {other_memory:.1f} × |",
                flush=True,
            )
    for what, more in MORE.items():
        print(f"\n{what}: gravical does more ({more}).")
    print("\nMemory: growth of the process over the size of the arrays that go in.")
    if slower:
        print(f"slower: {', '.join(slower)}", file=sys.stderr)
    return 1 if slower else 0


if __name__ == "__main__":
    sys.exit(main())
