#!/usr/bin/env python3
"""The whole way with a machine in place of the hand: the firmware on an emulated Uno, `gravical live`
at its port and its page in Chromium, the calibration, then a known move of the same board.

    tests/browser/live/whole_way.py GRAVICAL VIRTUAL_BOARD FIRMWARE [PICTURES]

The sensor of the board is simulated: its truth is known, and so is the move.
"""

import json
import math
import pathlib
import subprocess
import sys
import tempfile
import threading
import time

from browser import Browser
from check import SIZES
from program import FACES, Live

G = 9.80665
MG = G / 1000
# What is pushed, in the axes of the board with z up: m.
MOVE_M = (0.02, 0.7, 0.0)
# Single figures hold within this many standard deviations: one run in 500 fails by chance with 12 of them.
MOST_SD = 4.0
# No sensor of the simulated sessions that were good had more (docs/live.md).
MOST_RMS_MG = 2.5


class Uno:
    """The emulated board, its sensor in hands that do what is written to them."""

    def __init__(self, program, firmware, folder, seed):
        self.port = folder / "ttyUno"
        self.truth = folder / "truth.json"
        self.child = subprocess.Popen(
            [program, "--hands", "--firmware", firmware, "--seed", str(seed), "--truth", self.truth, "--link", self.port],
            stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
        self.answers = []
        threading.Thread(target=lambda: self.answers.extend(self.child.stderr), daemon=True).start()
        assert self.child.stdout.readline().strip() == str(self.port)

    def act(self, command):
        """Does it; seconds until the sensor rests."""
        before = len(self.answers)
        self.say(command)
        end = time.monotonic() + 20
        while time.monotonic() < end:
            for line in self.answers[before:]:
                if line.startswith(f"{command}: rests in "):
                    return float(line.split()[-2])
            time.sleep(0.01)
        raise AssertionError((command, self.answers[before:]))

    def say(self, line):
        self.child.stdin.write(line + "\n")
        self.child.stdin.flush()

    def close(self):
        self.child.kill()
        self.child.wait()


def times(matrix, vector):
    return [sum(m * v for m, v in zip(row, vector)) for row in matrix]


def sphere(n):
    golden = math.pi * (3 - math.sqrt(5))
    for i in range(n):
        z = 1 - (2 * i + 1) / n
        yield [math.sqrt(1 - z * z) * math.cos(golden * i), math.sqrt(1 - z * z) * math.sin(golden * i), z]


def calibrated(calibration, truth):
    """Bias and scale are within what the file says of them, and gravity is gravity in every direction."""
    found, true = calibration["accelerometer"], truth["accelerometer"]
    assert calibration["verdict"]["grade"] == "good", calibration["verdict"]
    warmer_c = calibration["temperature_c"]["mean"] - 25
    bias = [b + warmer_c * d for b, d in zip(true["bias_mps2"], true["bias_drift_mps2_per_c"])]
    said = found["deviations"]
    for i, axis in enumerate("xyz"):
        off, sd = found["bias"][i] - bias[i], said["bias"][i]
        scale = math.hypot(*true["matrix"][i])
        scale_off, scale_sd = found["scale"][i] / scale - 1, said["scale"][i] / scale
        print(f"{axis}: bias off by {off / MG:.2f} mg (sd {sd / MG:.2f}), scale by {100 * scale_off:.3f} % (sd {100 * scale_sd:.3f})")
        assert abs(off) < MOST_SD * sd and abs(scale_off) < MOST_SD * scale_sd, axis
        assert sd < 2 * MG and scale_sd < 0.002, "an interval that wide says nothing"
    errors = []
    for up in sphere(400):
        raw = [f + b - o for f, b, o in zip(times(true["matrix"], [G * v for v in up]), bias, found["bias"])]
        errors.append((math.hypot(*times(found["matrix"], raw)) - G) / MG)
    rms, worst = math.sqrt(sum(e * e for e in errors) / len(errors)), max(map(abs, errors))
    limit = found["worst_direction"]["error_mps2"] / MG
    print(f"‖a‖ off by {rms:.2f} mg rms, {worst:.2f} mg at most; the file says at most {limit:.2f} mg (95 %)")
    # The limit holds in 95 % of sessions.
    assert rms < MOST_RMS_MG and worst < MOST_SD / 2 * limit


def moved(result):
    """The move is inside its band."""
    moves = result["moves"]
    assert len(moves) == 1, moves
    for axis, true, is_m, sd in zip("xyz", MOVE_M, moves[0]["displacement_m"], moves[0]["sigma_m"]):
        print(f"{axis}: moved {is_m:.4f} m (sd {sd:.4f}), true {true} m")
        assert abs(is_m - true) < MOST_SD * sd, axis
        assert sd < 0.02, "a band that wide says nothing"


class WholeWay(Live):
    """A browser, the program and the emulated board."""

    def until_next(self):
        self.until("return state.next_pose && [...state.poses.values()].every(p => p.t_s <= state.next_pose.t_s)", 60)

    def guide(self, uno, folder):
        """From the first row to "Saved": what the page asks for is done with the board."""
        browser = self.browser
        with self.session("--port", str(uno.port), "--folder", str(folder)):
            self.ready()
            # Gravity is known here.
            browser.run(f"document.querySelector('#value').value = '{G}'")
            browser.click("#gravity [type=submit]")
            self.until("return state.session.gravity_source === 'given'")
            for count, face in enumerate(FACES, start=2):
                uno.act(face)
                if face == "+y":
                    # The plug is pulled in the middle of a capture.
                    self.until("return state.status?.state === 'capture' && state.status.ring > 0.3", 30)
                    uno.say("unplug")
                    self.until("return document.body.dataset.state === 'lost'", 30)
                    assert browser.run("return state.poses.size") == count - 1
                    self.until(f"return document.querySelector('#hint').textContent.includes('{count - 1} poses are safe')")
                    self.picture("uno-lost")
                    uno.say("plug")
                    self.until("return document.body.dataset.state !== 'lost'", 30)
                self.accepted(count)
            # One more than needed, taken back.
            browser.key("u")
            self.until("return state.poses.size === 5")
            uno.act("+x")
            uno.act(FACES[-1])
            self.accepted(6)
            for count in range(7, 20):
                self.until_next()
                if self.is_good():
                    break
                up = browser.run("return state.next_pose.up")
                assert up, browser.run("return state.next_pose")
                uno.act(" ".join(f"{v:.4f}" for v in up))
                self.accepted(count)
            assert self.is_good()
            self.picture("uno-good")
            seconds, free = browser.run("return [state.status.t_s, state.poses.size - 6]")
            browser.key("Enter")
            self.until("return state.saved && state.end?.reason === 'finished'", 60)
            self.picture("uno-end")
            assert not self.shown(".truth"), "the program does not know this sensor"
            self.quiet("the whole way")
        print(f"good with 6 faces and {free} free poses, {seconds:.0f} s of the board")

    def push(self, uno, folder):
        """A recording of a known move of the same board, as everybody makes it."""
        uno.act("+z")
        time.sleep(3)
        line = folder / "line.csv"
        logger = subprocess.Popen([self.program, "log", "-o", line, "--port", uno.port, "--rows", "1100", "--quiet"],
                                  stdin=subprocess.DEVNULL)
        end = time.monotonic() + 30
        # Some seconds of rest before the move, and after it.
        while not line.exists() or sum(1 for row in line.open() if row[0].isdigit()) < 300:
            assert time.monotonic() < end and logger.poll() is None
            time.sleep(0.05)
        uno.act("push")
        assert logger.wait(timeout=60) == 0
        return line


def main():
    program, board, firmware = (str(pathlib.Path(p).resolve()) for p in sys.argv[1:4])
    pictures = pathlib.Path(sys.argv[4]) if len(sys.argv) > 4 else None
    if pictures:
        pictures.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory() as profile, tempfile.TemporaryDirectory() as there:
        folder = pathlib.Path(there)
        browser = Browser(profile)
        uno = Uno(board, firmware, folder, seed=7)
        try:
            browser.size(*SIZES[0])
            browser.media()
            way = WholeWay(browser, program, pictures)
            session = folder / "session"
            way.guide(uno, session)
            calibration = session / "calibration.json"
            calibrated(json.loads(calibration.read_text()), json.loads(uno.truth.read_text()))
            line = way.push(uno, folder)
        finally:
            uno.close()
            browser.stop()
        done = subprocess.run([program, "motion", line, "-c", calibration, "--json"], capture_output=True, text=True, check=True)
        moved(json.loads(done.stdout))
    print("the whole way")


if __name__ == "__main__":
    main()
