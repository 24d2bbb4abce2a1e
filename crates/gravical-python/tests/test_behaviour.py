"""Beside the numbers: Ctrl-C, other threads, unknown keywords."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import threading
import time
from pathlib import Path

import gravical
import pytest

@pytest.mark.skipif(os.name == "nt", reason="signals")
def test_ctrl_c_ends_the_wait(tmp_path: Path) -> None:
    code = f"""
import gravical, sys, time
print("begun", flush=True)
try:
    gravical.simulate("static", duration=2.5e6, output={str(tmp_path / "long")!r})
except KeyboardInterrupt:
    print("interrupted", flush=True)
    import os
    os._exit(7)
"""
    process = subprocess.Popen([sys.executable, "-c", code], stdout=subprocess.PIPE, text=True)
    assert process.stdout is not None and process.stdout.readline() == "begun\n"
    time.sleep(1.0)
    begun = time.monotonic()
    process.send_signal(signal.SIGINT)
    out, _ = process.communicate(timeout=30)
    assert process.returncode == 7 and "interrupted" in out
    assert time.monotonic() - begun < 5.0


@pytest.mark.skipif(not os.path.isdir("/proc/self/task"), reason="threads by their names")
@pytest.mark.parametrize("work", ["gravical.read(path)", "gravical.motion(rows)"])
def test_ctrl_c_ends_what_is_read_and_a_motion(tmp_path: Path, work: str) -> None:
    code = f"""
import glob, sys
import numpy as np
import gravical

def working():
    names = [open(path).read() for path in glob.glob("/proc/self/task/*/comm")]
    return [name for name in names if name == "gravical\\n"]

n = 300_000
g = np.random.default_rng(1)
t = np.arange(n) / 100
accel = g.normal(0, 0.03, (n, 3)) + [0, 0, 9.81]
phase = t % 20
accel[:, 1] += np.where((phase > 10) & (phase < 12), np.sin(np.pi * (phase - 10)), 0)
rows = gravical.Recording.from_arrays(t=t, accel=accel, gyro=g.normal(0, 1e-3, (n, 3)), unit="m/s^2", gyro_unit="rad/s")
path = {str(tmp_path / "long.csv")!r}
with open(path, "w") as file:
    file.write("t,ax,ay,az\\n")
    for part in range(30 if "read" in {work!r} else 0):
        some = slice(part * n // 30, (part + 1) * n // 30)
        np.savetxt(file, np.column_stack([t[some], accel[some]]), fmt="%.9f", delimiter=",")
print("begun", flush=True)
try:
    while True:
        {work}
except KeyboardInterrupt:
    print("interrupted", working(), flush=True)
"""
    process = subprocess.Popen([sys.executable, "-c", code], stdout=subprocess.PIPE, text=True)
    assert process.stdout is not None and process.stdout.readline() == "begun\n"
    time.sleep(0.3)
    process.send_signal(signal.SIGINT)
    out, _ = process.communicate(timeout=60)
    assert out == "interrupted []\n"


def test_other_threads_go_on(poses: gravical.Recording) -> None:
    count, done = 0, threading.Event()

    def tick() -> None:
        nonlocal count
        while not done.is_set():
            count += 1
            time.sleep(0.001)

    thread = threading.Thread(target=tick)
    thread.start()
    begun = time.monotonic()
    gravical.simulate("static", duration=3000)
    took = time.monotonic() - begun
    done.set()
    thread.join()
    # A held interpreter would let it tick a few times only.
    assert count > 10 * took


def test_several_threads_calibrate(
    poses: gravical.Recording, calibration: gravical.Calibration
) -> None:
    from concurrent.futures import ThreadPoolExecutor

    with ThreadPoolExecutor(4) as pool:
        made = list(pool.map(lambda _: gravical.calibrate(poses, gravity=9.80665), range(8)))
    assert all((one.bias == calibration.bias).all() for one in made)


def test_the_version_is_that_of_the_crate(root: Path) -> None:
    manifest = (root / "Cargo.toml").read_text()
    assert f'version = "{gravical.__version__}"' in manifest


def test_unknown_keywords_are_refused(line: gravical.Recording) -> None:
    for call in (
        lambda: gravical.read("x.csv", acel_unit="g"),  # type: ignore[call-arg]
        lambda: gravical.motion(line, smoth="mean:5"),  # type: ignore[call-arg]
        lambda: gravical.simulate("line", free=8),
        lambda: gravical.calibrate(line, methd="joint"),  # type: ignore[call-arg]
    ):
        with pytest.raises(TypeError, match="unexpected keyword argument"):
            call()
