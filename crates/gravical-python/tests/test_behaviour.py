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


@pytest.mark.skipif(not os.path.isdir("/proc/self/task"), reason="threads by their names")
@pytest.mark.parametrize("work", ["gravical.read(path)", "gravical.motion(rows)"])
def test_ctrl_c_ends_what_is_read_and_a_motion(tmp_path: Path, work: str) -> None:
    code = f"""
import glob
import gravical

def working():
    names = [open(path).read() for path in glob.glob("/proc/self/task/*/comm")]
    return [name for name in names if name == "gravical\\n"]

made = gravical.simulate("static", duration=3000, output={str(tmp_path / "long")!r})
path, rows = made.paths[0], made.recordings["static.csv"]
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


def test_a_wrong_keyword_says_what_is_accepted(line: gravical.Recording) -> None:
    for call, accepted in (
        (lambda: gravical.motion(line, smoth="mean:5"), "smooth"),
        (lambda: gravical.simulate("line", free=8), "distance"),
    ):
        with pytest.raises(TypeError, match=f"unexpected keyword argument.*{accepted}"):
            call()


@pytest.mark.parametrize(
    ("given", "message"),
    [
        ({"pose_tilt": 20}, "pose_tilt=: 20° is not possible; 0 to 10° is"),
        ({"method": "linear"}, "method=: unknown variant `linear`, expected .*`joint`"),
        ({"gravity": float("nan")}, "gravity=: nan is not finite"),
        ({"altitude": 500}, "altitude=: .*latitude"),
    ],
)
def test_a_wrong_value_names_its_keyword(
    given: dict[str, Any], message: str, poses: gravical.Recording
) -> None:
    with pytest.raises(gravical.UsageError, match=message):
        gravical.calibrate(poses, **given)


def test_every_keyword_is_documented() -> None:
    for verb in ("read", "inspect", "calibrate", "denoise", "noise", "motion"):
        filters = ("mean:5",) if verb == "denoise" else ()
        with pytest.raises(TypeError) as error:
            getattr(gravical, verb)("x.csv", *filters, x=1)
        names = str(error.value).split("accepted: ")[1].split(", ")
        text = str(getattr(gravical, verb).__doc__) + str(gravical.read.__doc__)
        assert not [name for name in names if name not in text], verb
