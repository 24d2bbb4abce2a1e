#!/usr/bin/env python3
"""CPU time, time by the clock and memory of `gravical apply` beside pandas and polars at the same work.

    cargo build --release
    python3 benches/compare.py [ROWS [RUNS]]         # 10^7 rows, 3 runs each

The work: read a recording, subtract the bias, multiply by the matrix, write all its columns with the accelerometer
calibrated, to a millionth of its unit. Each does these steps in a process of its own; they take turns, so that a
busy machine disturbs all alike. CPU time is user + system of all threads, memory the peak that is resident. Nothing
is asserted: the table is the result, and with it how far the values are apart.

Needs `pip install numpy pandas polars`.
"""

import json
import multiprocessing
import os
import pathlib
import statistics
import subprocess
import sys
import tempfile
import time

ROOT = pathlib.Path(__file__).resolve().parent.parent
GRAVICAL = pathlib.Path(os.environ.get("CARGO_TARGET_DIR", ROOT / "target")) / "release/gravical"
# calibrated = matrix (raw - bias), m/s^2 from m/s^2.
BIAS = [0.12, -0.21, 0.05]
MATRIX = [[0.98, 0.004, -0.01], [0.0, 1.01, 0.02], [0.003, 0.0, 0.995]]
HEAD = f"""
import sys
BIAS, MATRIX = {BIAS}, {MATRIX}
ACCEL, SI = ["aX (g)", "aY (g)", "aZ (g)"], ["ax_mps2", "ay_mps2", "az_mps2"]
names = dict(zip(ACCEL, SI))
"""
# to_csv(float_format=...) would be slower and change the other columns.
PANDAS = HEAD + """
import numpy as np, pandas as pd
data = pd.read_csv(sys.argv[1])
data[ACCEL] = ((data[ACCEL].to_numpy() - BIAS) @ np.array(MATRIX).T).round(6)
data.rename(columns=names).to_csv(sys.argv[2], index=False)
"""
POLARS = HEAD + """
import polars as pl
raw = [pl.col(name) - bias for name, bias in zip(ACCEL, BIAS)]
calibrated = [sum(m * r for m, r in zip(row, raw)).round(6).alias(name) for name, row in zip(ACCEL, MATRIX)]
"""
COMPETITORS = {
    "polars": POLARS + "pl.read_csv(sys.argv[1]).with_columns(calibrated).rename(names).write_csv(sys.argv[2])",
    # The engine for data that do not fit into memory.
    "polars, streaming": POLARS + "pl.scan_csv(sys.argv[1]).with_columns(calibrated).rename(names).sink_csv(sys.argv[2])",
    "pandas": PANDAS,
}


def write_recording(path, rows):
    import numpy as np

    rng = np.random.default_rng(1)
    with open(path, "w", encoding="utf-8") as file:
        file.write("Timestamp,aX (g),aY (g),aZ (g),Temp (C),gX (°/s),gY (°/s),gZ (°/s)\n")
        for start in range(0, rows, 100_000):
            n = min(100_000, rows - start)
            columns = [(start + np.arange(n)) * 10, *(rng.normal(0, 0.05, (n, 3)) + [0.1, -0.2, 9.8]).T,
                       27 + rng.normal(0, 0.05, n), *rng.normal(0, 0.02, (n, 3)).T]
            lines = zip(*(column.tolist() for column in columns))
            file.writelines("%d,%.4f,%.4f,%.4f,%.2f,%.4f,%.4f,%.4f\n" % line for line in lines)


def write_calibration(path):
    """As imucal writes it: matrix = R^-1 K^-1, here with K = 1."""
    import numpy as np

    one, zero = np.eye(3).tolist(), np.zeros((3, 3)).tolist()
    units = {"acc_unit": "m/s^2", "gyr_unit": "deg/s", "from_acc_unit": "m/s^2", "from_gyr_unit": "deg/s"}
    accel = {"K_a": one, "R_a": np.linalg.inv(MATRIX).tolist(), "b_a": BIAS}
    gyro = {"K_g": one, "R_g": one, "b_g": [0.0] * 3, "K_ga": zero}
    path.write_text(json.dumps({**units, **accel, **gyro, "cal_type": "Ferraris", "_format_version": "2.0.0"}))


def measure(command):
    """CPU time and time by the clock in s, and peak memory in MiB of a run."""
    begin = time.monotonic()
    process = subprocess.Popen(command, stdout=subprocess.DEVNULL)
    _, status, usage = os.wait4(process.pid, 0)
    process.returncode = os.waitstatus_to_exitcode(status)
    if process.returncode:
        sys.exit(f"{command[0]} ended with {process.returncode}")
    return usage.ru_utime + usage.ru_stime, time.monotonic() - begin, usage.ru_maxrss / 1024


def main():
    rows = int(sys.argv[1]) if len(sys.argv) > 1 else 10_000_000
    runs = int(sys.argv[2]) if len(sys.argv) > 2 else 3
    with tempfile.TemporaryDirectory(prefix="gravical-compare-") as folder:
        folder = pathlib.Path(folder)
        recording, calibration = folder / "recording.csv", folder / "calibration.json"
        # In processes of their own: the peak of a program counts that of the one that starts it.
        make = multiprocessing.get_context("spawn").Pool(1, maxtasksperchild=1)
        make.apply(write_recording, (recording, rows))
        make.apply(write_calibration, (calibration,))
        make.close()
        outputs = {name: folder / f"{name}.csv" for name in ["gravical", *COMPETITORS]}
        commands = {"gravical": [GRAVICAL, "apply", calibration, recording, "--force", "-o", outputs["gravical"]]}
        for name, script in COMPETITORS.items():
            commands[name] = [sys.executable, "-c", script, recording, outputs[name]]
        results = {name: [] for name in commands}
        for _ in range(runs):
            for name, command in commands.items():
                results[name].append(measure(command))
        import numpy as np

        first = None
        print(f"{os.cpu_count()} CPUs, load {os.getloadavg()[0]:.1f}; {rows} rows")
        print("| program | CPU, s | times gravical | wall, s | peak memory, MiB | apart by, m/s² |")
        print("| --- | ---: | ---: | ---: | ---: | ---: |")
        for name, path in outputs.items():
            cpu, wall, peak = (statistics.median(values) for values in zip(*results[name]))
            values = np.genfromtxt(path, delimiter=",", skip_header=1, max_rows=1000, usecols=(1, 2, 3), encoding="utf-8")
            first = (cpu, values) if first is None else first
            apart = np.abs(values - first[1]).max()
            print(f"| {name} | {cpu:.2f} | {cpu / first[0]:.2f} | {wall:.2f} | {peak:.0f} | {apart:.1e} |")


if __name__ == "__main__":
    main()
