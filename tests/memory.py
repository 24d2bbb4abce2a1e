#!/usr/bin/env python3
"""Peak memory of the commands: of `apply`, which reads a recording of any size, at most 64 MiB; of those
that read it whole the bytes of the file and 150 bytes a row of eight columns more.

    tests/memory.py target/debug/gravical

Simulates a session of about a million rows, of which the columns alone are 64 MiB: with the program,
above the limit.
"""

import os
import subprocess
import sys
import tempfile

LIMIT_MIB = 64
BYTES_PER_ROW = 150

FILTERS = ["--filter", "hampel:7,3", "--filter", "savgol:21,2", "--filter", "butter:4,5Hz"]


def peak_mib(command):
    """Runs a command; its peak memory in MiB. Exit code 4 is a failed quality gate, which is a
    result."""
    with tempfile.TemporaryFile() as messages:
        process = subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=messages)
        _, status, usage = os.wait4(process.pid, 0)
        code = os.waitstatus_to_exitcode(status)
        if code not in (0, 4):
            messages.seek(0)
            sys.exit(f"{' '.join(command)}: exit {code}\n{messages.read().decode()}")
    return usage.ru_maxrss / 1024


def measure(gravical, command, file_bytes, rows):
    """Prints the peak memory of a command; true above the limit."""
    peak = peak_mib([gravical, *command])
    whole_bytes = 0 if command[0] == "apply" else file_bytes + BYTES_PER_ROW * rows
    limit = LIMIT_MIB + whole_bytes / 2**20
    print(f"{command[0]:10} {peak:6.1f} MiB, limit {limit:.0f}")
    return peak > limit


def main():
    gravical = os.path.abspath(sys.argv[1])
    with tempfile.TemporaryDirectory() as folder:
        os.chdir(folder)
        simulate = [gravical, "simulate", "poses", "-o", "sim", "--rate", "400", "--hold", "200"]
        subprocess.run([*simulate, "--free", "8", "--quiet"], check=True)
        recording, calibration = "sim/poses.csv", "cal.json"
        commands = [
            ["inspect", recording],
            ["calibrate", recording, "-o", calibration],
            ["check", calibration, recording],
            ["apply", calibration, recording, "-o", "out.csv"],
            ["motion", recording, "--calibration", calibration, "-o", "track.csv"],
            ["denoise", recording, *FILTERS, "-o", "smooth.csv"],
        ]
        with open(recording, "rb") as lines:
            rows = sum(1 for _ in lines)
        file_bytes = os.path.getsize(recording)
        above = False
        for command in commands:
            above |= measure(gravical, command, file_bytes, rows)
        # A guided session: the replay, and the calculation from its folder.
        replay = ["live", "--replay", recording, "--any-pose", "--events", "all.ndjson"]
        above |= measure(gravical, [*replay, "-o", "live.json"], file_bytes, rows)
        os.mkdir("session")
        os.rename(recording, "session/recording.csv")
        with open("all.ndjson") as events, open("session/session.ndjson", "w") as journal:
            journal.writelines(line for line in events if '"type":"status"' not in line)
        above |= measure(gravical, ["calibrate", "session", "-o", "again.json"], file_bytes, rows)
        if above:
            sys.exit("above the limit")


main()
