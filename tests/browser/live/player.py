"""A pretended session that answers to commands: what is needed to drive the page from the first
key to the end. It measures and estimates nothing; that is tested with the program itself."""

import math
import threading
import time

from scenes import FREE, ORDER, Script, direction, nearest, unit

TURN_S = 1.2
CAPTURE_S = 3.0


def angle(a, b):
    return math.degrees(math.acos(max(-1.0, min(1.0, sum(x * y for x, y in zip(a, b))))))


class Player(Script):
    """`speed`: seconds of the session in one of the clock."""

    def __init__(self, session, speed=8.0):
        self.session = session
        self.speed = speed
        self.lock = threading.RLock()
        self.over = False
        self.moving_s = 0.0
        self.still_s = 0.0
        self.taken = True
        self.forced = False
        session.play([])
        super().__init__("simulate", "simulated MPU6050", "standard")
        session.react = self.command
        threading.Thread(target=self.loop, daemon=True).start()

    def add(self, name, /, **fields):
        super().add(name, **fields)
        self.session.say(self.events[-1])
        return self

    def loop(self):
        for state, seconds in (("identify", 1.0), ("floor", 3.0)):
            for i in range(int(seconds * 10)):
                self.wait()
                self.status(state, "Put the sensor on the table, hands off", ring=i / (10 * seconds), limit=None)
            self.identified() if state == "identify" else self.floor()
        while not self.over:
            self.wait()
            with self.lock:
                if not self.over:
                    self.step()

    def wait(self):
        time.sleep(0.1 / self.speed)
        self.t += 0.1

    def step(self):
        if self.moving_s > 0:
            self.moving_s -= 0.1
            k = min(1.0, max(0.0, 1 - self.moving_s / TURN_S))
            up = unit([a + k * (b - a) + 1e-3 for a, b in zip(self.start, self.goal)])
            self.status("wait", "Turn it to a face that is to do", up=up, still=False, noise=84, norm=1.1)
            self.still_s = 0.0
            return
        self.still_s += 0.1
        face, tilt = nearest(self.up)
        done = [f for f in self.poses.values() if angle(f[1], self.up) < 8]
        free = tilt > 25
        welcome = "duplicate" if done else "between" if free and len(self.faces_done()) < 6 else "free" if free else "face"
        if self.taken or (welcome in ("duplicate", "between") and not self.forced):
            if welcome == "duplicate" and not self.taken and self.still_s > 3:
                self.taken = True
                self.add("pose_rejected", reason="duplicate", text="This pose is recorded already. Turn it to a face that is to do.")
            self.status("wait", "Put any face up that is to do", welcome=welcome)
        elif self.still_s < 0.6:
            self.status("settle", "Hold still", ring=self.still_s / 0.6, welcome=welcome)
        elif self.still_s < 0.6 + CAPTURE_S:
            if not self.capturing:
                self.capturing = True
                self.candidate(self.up)
            left_s = CAPTURE_S + 0.6 - self.still_s
            self.status("capture", f"Hold still, {left_s:.1f} s to go", ring=1 - left_s / CAPTURE_S, welcome=welcome)
        else:
            self.taken, self.forced = True, False
            self.accept(self.up)
            self.status("wait", "Put any face up that is to do")

    def go(self, up):
        if self.moving_s <= 0 and self.still_s > 0.6 and not self.taken:
            self.add("pose_rejected", reason="moved", text="It moved after 1.2 s: 84 mg, limit 19 mg. Lay it down, take the hand off, and wait.")
        self.start, self.goal = self.up, unit([c + 0.01 for c in up])
        self.moving_s, self.taken, self.capturing, self.forced = TURN_S, False, False, False

    def command(self, command):
        with self.lock:
            name = command["command"]
            if name == "hand":
                self.go(direction(command["put"]) if "put" in command else command.get("up", self.up))
            elif name == "capture":
                self.taken, self.forced, self.capturing = False, True, False
            elif name == "undo" and self.poses:
                number, (face, _) = self.poses.popitem()
                self.add("pose_undone", pose=number, face=face, why="undo").next()
            elif name == "redo":
                number = next(n for n, (f, _) in self.poses.items() if f == command["face"])
                del self.poses[number]
                self.redo.add(command["face"])
                self.add("pose_undone", pose=number, face=command["face"], why="redo").next()
            elif name == "finish":
                self.over = True
                self.ended("good" if len(self.poses) >= 9 else "fair" if len(self.poses) > 6 else "not-verifiable")


__all__ = ["FREE", "ORDER", "Player"]
