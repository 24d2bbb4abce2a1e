#!/usr/bin/env python3
"""Measure `gravical apply` against pandas and polars on the same work.

    cargo build --release
    python3 benches/compare.py                      # 10^7 rows, 3 runs each
    python3 benches/compare.py --rows 100000

The work: read a recording, subtract the bias, multiply by the matrix, write all
its columns with the accelerometer calibrated, to a millionth of its unit.
Each competitor does these steps in a process of its own; they take turns, so
that a busy machine disturbs all alike. Measured are CPU time (user + system,
all threads together) and peak resident memory. Nothing is asserted: the table
is the result, and with it how far the competitors' values are apart.

Needs `pip install numpy pandas polars`.
"""

import argparse
import csv
import json
import os
import resource
import statistics
import subprocess
import sys
import tempfile
from itertools import islice
from pathlib import Path

# calibrated = matrix (raw - bias), m/s^2 from m/s^2.
BIAS = [0.12, -0.21, 0.05]
MATRIX = [[0.98, 0.004, -0.01], [0.0, 1.01, 0.02], [0.003, 0.0, 0.995]]

GENERATE = """
import sys
import numpy as np
path, rows = sys.argv[1], int(sys.argv[2])
rng = np.random.default_rng(1)
with open(path, "w", encoding="utf-8") as file:
    file.write("Timestamp,aX (g),aY (g),aZ (g),Temp (C),gX (°/s),gY (°/s),gZ (°/s)\\n")
    for start in range(0, rows, 100_000):
        n = min(100_000, rows - start)
        stamp = (start + np.arange(n)) * 10
        accel = rng.normal(0, 0.05, (n, 3)) + [0.1, -0.2, 9.8]
        temperature = 27 + rng.normal(0, 0.05, n)
        gyro = rng.normal(0, 0.02, (n, 3))
        columns = [stamp, *accel.T, temperature, *gyro.T]
        lines = zip(*(column.tolist() for column in columns))
        file.writelines("%d,%.4f,%.4f,%.4f,%.2f,%.4f,%.4f,%.4f\\n" % line for line in lines)
"""

PARAMETERS = f"""
import sys
BIAS = {BIAS}
MATRIX = {MATRIX}
ACCEL = ["aX (g)", "aY (g)", "aZ (g)"]
SI = ["ax_mps2", "ay_mps2", "az_mps2"]
"""

# to_csv(float_format=...) would be slower and change the other columns.
PANDAS = (
    PARAMETERS
    + """
import numpy as np
import pandas as pd
data = pd.read_csv(sys.argv[1])
calibrated = (data[ACCEL].to_numpy() - BIAS) @ np.array(MATRIX).T
data[ACCEL] = calibrated.round(6)
data.rename(columns=dict(zip(ACCEL, SI))).to_csv(sys.argv[2], index=False)
"""
)

POLARS_STEPS = (
    PARAMETERS
    + """
import polars as pl
raw = [pl.col(name) - bias for name, bias in zip(ACCEL, BIAS)]
calibrated = [
    (row[0] * raw[0] + row[1] * raw[1] + row[2] * raw[2]).round(6).alias(name)
    for name, row in zip(ACCEL, MATRIX)
]
names = dict(zip(ACCEL, SI))
"""
)
POLARS = POLARS_STEPS + "pl.read_csv(sys.argv[1]).with_columns(calibrated).rename(names).write_csv(sys.argv[2])\n"
# The engine for data that do not fit into memory.
POLARS_STREAMING = (
    POLARS_STEPS
    + "pl.scan_csv(sys.argv[1]).with_columns(calibrated).rename(names).sink_csv(sys.argv[2])\n"
)

def main():
    args = arguments()
    with tempfile.TemporaryDirectory(prefix="gravical-compare-") as temporary:
        folder = Path(args.dir or temporary)
        folder.mkdir(parents=True, exist_ok=True)
        python = sys.executable
        gravical = Path(args.gravical).resolve()
        if not gravical.exists():
            sys.exit(f"{gravical} is not there: run `cargo build --release`, or name it with --gravical")
        print(f"{os.cpu_count()} CPUs, load {os.getloadavg()[0]:.1f}")
        compare_apply(gravical, python, folder, args)


def arguments():
    root = Path(__file__).resolve().parent.parent
    target = Path(os.environ.get("CARGO_TARGET_DIR", root / "target"))
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--rows", type=int, default=10_000_000, help="rows of the recording [10^7]")
    parser.add_argument("--runs", type=int, default=3, help="runs of each competitor [3]")
    parser.add_argument("--dir", help="working folder, kept [a temporary one]")
    parser.add_argument("--gravical", default=target / "release" / "gravical", help="the program")
    args = parser.parse_args()
    if args.rows < 1 or args.runs < 1:
        parser.error("--rows and --runs have to be positive")
    return args


def compare_apply(gravical, python, folder, args):
    recording, calibration, size = inputs(python, folder, args.rows)
    outputs = {}

    def competitor(name, text):
        outputs[name] = folder / f"{name.replace(' ', '-')}.csv"
        # Not polars.py: that is what `import polars` would find.
        path = script(folder, f"with-{name.replace(' ', '-')}.py", text)
        return [python, path, recording, outputs[name]]

    outputs["gravical"] = folder / "gravical.csv"
    commands = {
        "gravical": [gravical, "apply", calibration, recording, "-o", outputs["gravical"], "--force"],
        "polars": competitor("polars", POLARS),
        "polars streaming": competitor("polars streaming", POLARS_STREAMING),
        "pandas": competitor("pandas", PANDAS),
    }
    print(f"\napply: {args.rows} rows, {size:.0f} MB, read → calibrate → write")
    table(in_turn(commands, args.runs), "s", 1.0)
    first = accelerations(outputs["gravical"])
    for name, path in outputs.items():
        if name != "gravical" and path.exists():
            apart = max(abs(a - b) for a, b in zip(first, accelerations(path)))
            print(f"  values of {name} and gravical are at most {apart:.1e} m/s² apart")
    for path in outputs.values():
        path.unlink(missing_ok=True)


def inputs(python, folder, rows):
    """The recording (made once), the calibration, and the recording's size, MB."""
    recording, calibration = folder / "recording.csv", folder / "calibration.json"
    made = folder / f"recording-of-{rows}-rows"
    if not (recording.exists() and made.exists()):
        script(folder, "generate.py", GENERATE)
        subprocess.run([python, folder / "generate.py", recording, str(rows)], check=True)
        made.touch()
    calibration.write_text(json.dumps(imucal_form()), encoding="utf-8")
    return recording, calibration, recording.stat().st_size / 1e6


def imucal_form():
    """The calibration as imucal writes it: matrix = R^-1 K^-1, here with K = 1."""
    identity = [[float(i == j) for j in range(3)] for i in range(3)]
    zero = [[0.0] * 3 for _ in range(3)]
    return {
        "acc_unit": "m/s^2", "gyr_unit": "deg/s",
        "from_acc_unit": "m/s^2", "from_gyr_unit": "deg/s",
        "K_a": identity, "R_a": inverse(MATRIX), "b_a": BIAS,
        "K_g": identity, "R_g": identity, "b_g": [0.0] * 3, "K_ga": zero,
        "cal_type": "Ferraris", "_format_version": "2.0.0",
    }  # fmt: skip


def inverse(m):
    """Of a 3 x 3 matrix, by cofactors."""
    def cofactor(i, j):
        a, b, c, d = (m[(i + k) % 3][(j + l) % 3] for k in (1, 2) for l in (1, 2))
        return a * d - b * c

    determinant = sum(m[0][j] * cofactor(0, j) for j in range(3))
    return [[cofactor(j, i) / determinant for j in range(3)] for i in range(3)]


def script(folder, name, text):
    path = folder / name
    path.write_text(text, encoding="utf-8")
    return path


def in_turn(commands, runs):
    """Name → [(CPU seconds, peak MiB)]; a competitor that fails is left out."""
    results = {name: [] for name in commands}
    for _ in range(runs):
        for name, command in commands.items():
            if results[name] is not None:
                done = measure([str(part) for part in command], name)
                results[name] = None if done is None else [*results[name], done]
    return {name: all_runs for name, all_runs in results.items() if all_runs}


def measure(command, name):
    with tempfile.TemporaryFile() as messages:
        process = subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=messages)
        _, status, usage = os.wait4(process.pid, 0)
        process.returncode = os.waitstatus_to_exitcode(status)
        # 4: a quality gate of `gravical calibrate`; it did its work.
        if process.returncode not in (0, 4):
            messages.seek(0)
            text = messages.read().decode(errors="replace").strip()
            print(f"  {name} failed with exit code {process.returncode}: {text[-400:]}")
            return None
    return usage.ru_utime + usage.ru_stime, mebibytes(usage)


def mebibytes(usage):
    return usage.ru_maxrss / (2**20 if sys.platform == "darwin" else 2**10)


def table(results, unit, factor):
    if not results:
        return
    base = statistics.median(cpu for cpu, _ in next(iter(results.values())))
    print(f"  {'':18} {'CPU ' + unit:>9} {'min':>9} {'max':>9} {'× ' + next(iter(results)):>11} {'peak MiB':>9}")
    for name, runs in results.items():
        cpu = [seconds * factor for seconds, _ in runs]
        middle = statistics.median(cpu)
        peak = statistics.median(mib for _, mib in runs)
        # A child starts as a copy of this script and its peak with that.
        own = mebibytes(resource.getrusage(resource.RUSAGE_SELF))
        shown = f"< {own:.0f}" if peak <= own else f"{peak:.0f}"
        ratio = middle / (base * factor)
        print(f"  {name:18} {middle:9.2f} {min(cpu):9.2f} {max(cpu):9.2f} {ratio:11.2f} {shown:>9}")


def accelerations(path):
    """The calibrated values of the first rows."""
    names = ["ax_mps2", "ay_mps2", "az_mps2"]
    with open(path, encoding="utf-8", newline="") as file:
        rows = islice(csv.DictReader(file), 1000)
        return [float(row[name]) for row in rows for name in names]


if __name__ == "__main__":
    main()
