"""Beside the numbers: Ctrl-C, other threads, unknown keywords."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import threading
import time
from pathlib import Path
from typing import Any

import gravical
import pytest

def interrupted(code: str, after_s: float, within_s: float) -> str:
    """What a process of this code prints that is interrupted after it said that it begins, and ends."""
    process = subprocess.Popen([sys.executable, "-c", code], stdout=subprocess.PIPE, text=True)
    assert process.stdout is not None and process.stdout.readline() == "begun\n"
    time.sleep(after_s)
    process.send_signal(signal.SIGINT)
    return process.communicate(timeout=within_s)[0]


@pytest.mark.skipif(os.name == "nt", reason="signals")
def test_ctrl_c_ends_the_wait(tmp_path: Path) -> None:
    code = f"""
import gravical, os
print("begun", flush=True)
try:
    gravical.simulate("static", duration=2.5e6, output={str(tmp_path / "long")!r})
except KeyboardInterrupt:
    print("interrupted", flush=True)
    os._exit(7)
"""
    assert interrupted(code, 1.0, 5.0) == "interrupted\n"


@pytest.mark.skipif(not os.path.isdir("/proc/self/task"), reason="threads by their names")
@pytest.mark.parametrize("work", ["gravical.read(path)", "gravical.motion(rows)"])
def test_ctrl_c_ends_what_is_read_and_a_motion(tmp_path: Path, work: str) -> None:
    code = f"""
import glob
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
rows = gravical.Recording.from_arrays(t=t, accel=accel, gyro=g.normal(0, 1e-3, (n, 3)), accel_unit="m/s^2", gyro_unit="rad/s")
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
    assert interrupted(code, 0.3, 60.0) == "interrupted []\n"


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


def test_the_version_is_that_of_the_crate(root: Path) -> None:
    manifest = (root / "Cargo.toml").read_text()
    assert f'version = "{gravical.__version__}"' in manifest


def test_a_wrong_keyword_says_what_is_accepted(line: gravical.Recording) -> None:
    for call, accepted in (
        (lambda: gravical.read("x.csv", acel_unit="g"), "accel_unit"),  # type: ignore[call-arg]
        (lambda: gravical.motion(line, procedur="report"), "procedure"),  # type: ignore[call-arg]
        (lambda: gravical.simulate("line", free=8), "distance"),
        (lambda: gravical.calibrate(line, methd="joint"), "method"),  # type: ignore[call-arg]
    ):
        with pytest.raises(TypeError, match=f"unexpected keyword argument.*{accepted}"):
            call()


@pytest.mark.parametrize(
    ("given", "message"),
    [
        ({"pose_tilt": 20}, "pose_tilt=: 20° is not possible; 0 to 10° is"),
        ({"pose_tilt": "x"}, "pose_tilt=: .*expected a number"),
        ({"method": "linear"}, "method=: unknown variant `linear`, expected .*`joint`"),
        ({"axes": "a,b,c"}, "axes=: .*not an axis; give three axes"),
        ({"gravity": float("nan")}, "gravity=: nan is not finite"),
        ({"altitude": 500}, "altitude=: .*latitude"),
        ({"free_pose": "nowhere"}, "free_pose=: there is no pose nowhere"),
    ],
)
def test_a_wrong_value_names_its_keyword(
    given: dict[str, Any], message: str, poses: gravical.Recording
) -> None:
    with pytest.raises(gravical.UsageError, match=message):
        gravical.calibrate(poses, **given)


def test_every_keyword_is_documented(line: gravical.Recording) -> None:
    verbs = ("read", "inspect", "calibrate", "apply", "denoise", "noise", "check", "motion")
    for verb in verbs:
        first = (line,) if verb in ("apply", "check") else ()
        filters = ("savgol:5,2",) if verb == "denoise" else ()
        with pytest.raises((TypeError, gravical.Error)) as error:
            getattr(gravical, verb)(*first, "x.csv", *filters, x=1)
        if verb in ("apply", "check"):
            continue  # The calibration is refused first.
        names = str(error.value).split("accepted: ")[1].split(", ")
        text = str(getattr(gravical, verb).__doc__) + str(gravical.read.__doc__)
        assert not [name for name in names if name not in text], verb
