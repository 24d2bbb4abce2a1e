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

import numpy as np  # noqa: E402

RATE = 100.0
# Not the same work: what gravical computes beyond the other.
MORE = {
    "calibrate, method Ferraris": "finds the poses; uncertainty, tests, verdict",
    "noise, Allan deviation": "rests; intervals; N, B and K with theirs; check by the density",
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


def measured(work: Callable[[], Callable[[], Any]], size: int, out: Any) -> None:
    call = work()
    gc.collect()
    before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    times = []
    for _ in range(REPEATS):
        begun = time.perf_counter()
        result = call()
        times.append(time.perf_counter() - begun)
        del result
    after = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    out.put((min(times), (after - before) * 1024 / size if size else 0.0))


def run(work: Callable[[], Callable[[], Any]], size: int) -> tuple[float, float]:
    context = multiprocessing.get_context("fork")
    out = context.Queue()
    process = context.Process(target=measured, args=(work, size, out))
    process.start()
    done: tuple[float, float] = out.get(timeout=3600)
    process.join()
    return done


def cases(rows: int, folder: str) -> list[tuple[str, str, int, Callable[..., Any], Callable[..., Any]]]:
    """What is done, beside what, size of its input, and how both do it."""
    data = samples(rows)
    size = sum(values.nbytes for values in data.values())
    path = os.path.join(folder, "rows.csv")
    columns = ["t", "ax", "ay", "az", "gx", "gy", "gz"]
    table = np.column_stack([data["t"], data["accel"], data["gyro"]])
    np.savetxt(path, table, delimiter=",", header=",".join(columns), comments="", fmt="%.5f")
    poses = session(20.0)
    pose_size = sum(values.nbytes for values in poses.values())
    rest = {k: v[: rows // 2] for k, v in data.items()}

    def recording(source: dict[str, Any] = data) -> Any:
        import gravical

        return gravical.Recording.from_arrays(**source, unit="m/s^2", gyro_unit="rad/s")

    def ours_read() -> Any:
        import gravical

        return lambda: gravical.read(path)

    def pandas_read() -> Any:
        import pandas

        return lambda: pandas.read_csv(path)

    def ours_calibrate() -> Any:
        import gravical

        order = ["x_p", "x_a", "y_p", "y_a", "z_p", "z_a", "x_rot", "y_rot", "z_rot"]
        stacked = np.concatenate([poses[name] for name in order])
        labels = np.repeat(order, [len(poses[name]) for name in order])
        t = np.arange(len(stacked)) / RATE
        session = gravical.Recording.from_arrays(
            t=t, accel=stacked[:, :3], gyro=stacked[:, 3:], labels=labels, unit="m/s^2", gyro_unit="deg/s"
        )
        return lambda: gravical.calibrate(session, method="ferraris", gravity=9.81)

    def imucal_calibrate() -> Any:
        from imucal import FerrarisCalibration

        regions = imucal_regions(poses)
        method = FerrarisCalibration()
        return lambda: method.compute(regions, RATE, from_acc_unit="m/s^2", from_gyr_unit="deg/s")

    def calibration() -> Any:
        import gravical

        six = gravical.simulate("poses", free=8, seed=3).recordings["poses.csv"]
        return gravical.calibrate(six, gravity=9.80665)

    def ours_apply() -> Any:
        cal = calibration()
        return lambda: cal.apply_gyro(data["gyro"], cal.apply(data["accel"]))

    def imucal_apply() -> Any:
        import imucal

        cal = imucal.CalibrationInfo.from_json(calibration().export("imucal"))
        return lambda: cal.calibrate(data["accel"], data["gyro"], "m/s^2", "rad/s")

    def ours_filter(spec: str) -> Callable[[], Any]:
        def begun() -> Any:
            import gravical

            own = recording()
            return lambda: gravical.denoise(own, spec)

        return begun

    def ours_noise() -> Any:
        import gravical

        lying = recording(still())
        return lambda: gravical.noise(lying)

    def scipy_butter() -> Any:
        from scipy.signal import butter, sosfiltfilt

        sos = butter(4, 5.0, fs=RATE, output="sos")
        return lambda: (sosfiltfilt(sos, data["accel"], axis=0), sosfiltfilt(sos, data["gyro"], axis=0))

    def scipy_savgol() -> Any:
        from scipy.signal import savgol_filter

        return lambda: (
            savgol_filter(data["accel"], 11, 2, axis=0),
            savgol_filter(data["gyro"], 11, 2, axis=0),
        )

    def still() -> dict[str, Any]:
        g = np.random.default_rng(3)
        n = len(rest["t"])
        accel = g.normal(0, 0.03, (n, 3))
        accel[:, 2] += 9.81
        return {"t": rest["t"], "accel": accel, "gyro": g.normal(0, 1e-3, (n, 3))}

    def allantools_noise() -> Any:
        import allantools

        lying = still()
        channels = [*lying["accel"].T, *lying["gyro"].T]
        channels = [np.ascontiguousarray(c) for c in channels]
        return lambda: [
            allantools.oadev(c, rate=RATE, data_type="freq", taus="octave") for c in channels
        ]

    def ours_motion() -> Any:
        import gravical

        own = recording()
        return lambda: gravical.motion(own)

    def gaitmap_motion() -> Any:
        import pandas
        from gaitmap.trajectory_reconstruction import RtsKalman

        frame = pandas.DataFrame(
            np.column_stack([data["accel"], np.degrees(data["gyro"])]),
            columns=["acc_x", "acc_y", "acc_z", "gyr_x", "gyr_y", "gyr_z"],
        )
        return lambda: RtsKalman().estimate(frame, sampling_rate_hz=RATE)

    half = size // 2
    return [
        ("read a CSV of seven columns", "pandas.read_csv", size, ours_read, pandas_read),
        ("calibrate, method Ferraris", "imucal", pose_size, ours_calibrate, imucal_calibrate),
        ("apply to both sensors", "imucal", size, ours_apply, imucal_apply),
        ("Butterworth, zero phase", "scipy sosfiltfilt", size, ours_filter("butter:4,5Hz"), scipy_butter),
        ("Savitzky–Golay", "scipy savgol_filter", size, ours_filter("savgol:11,2"), scipy_savgol),
        ("noise, Allan deviation", "allantools oadev", half, ours_noise, allantools_noise),
        ("position with error bands", "gaitmap RtsKalman", size, ours_motion, gaitmap_motion),
    ]


def imucal_regions(poses: dict[str, np.ndarray]) -> Any:
    """The session as imucal takes it."""
    from imucal import FerrarisSignalRegions

    fields = {}
    for name, values in poses.items():
        for sensor, part in (("acc", slice(0, 3)), ("gyr", slice(3, 6))):
            fields[f"{sensor}_{name}"] = values[:, part]
    return FerrarisSignalRegions(**{f: fields[f] for f in FerrarisSignalRegions._fields})


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
