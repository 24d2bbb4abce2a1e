"""A board at a port: a pseudo-terminal that prints rows of text, and can be unplugged."""

import math
import os
import pathlib
import random
import threading
import time
import tty

RATE_HZ = 100
TURN_S = 1.0
BIAS = (0.12, -0.08, 0.2)
G = 9.80665


class Board:
    """Rows of acceleration in m/s² and angular rate in rad/s; noise of 3 mg."""

    def __init__(self, folder):
        self.port = pathlib.Path(folder) / "ttyBoard"
        self.lock = threading.Lock()
        self.draw = random.Random(1)
        self.files = None
        self.started = time.monotonic()
        self.start, self.goal, self.turned_s = (0.02, 0.03, 1.0), (0.02, 0.03, 1.0), -TURN_S
        self.over = False
        self.plug()
        threading.Thread(target=self.loop, daemon=True).start()

    def plug(self):
        with self.lock:
            self.files = os.openpty()
            tty.setraw(self.files[1])
            os.set_blocking(self.files[0], False)
            self.port.symlink_to(os.ttyname(self.files[1]))

    def unplug(self):
        with self.lock:
            self.port.unlink()
            for file in self.files:
                os.close(file)
            self.files = None

    def close(self):
        self.over = True
        if self.files:
            self.unplug()

    def turn(self, up):
        """Turns it by hand within a second."""
        with self.lock:
            self.start, self.goal, self.turned_s = self.goal, up, time.monotonic() - self.started

    def row(self, t_s):
        k = min(1.0, max(0.0, (t_s - self.turned_s) / TURN_S))
        k = k * k * (3 - 2 * k)
        up = [a + k * (b - a) + 1e-3 * k * (1 - k) for a, b in zip(self.start, self.goal)]
        length = math.sqrt(sum(v * v for v in up))
        accel = [G * v / length + b + self.draw.gauss(0, 0.03) for v, b in zip(up, BIAS)]
        gyro = [self.draw.gauss(0.01, 0.001) for _ in range(3)]
        return f"{round(1000 * t_s)}," + ",".join(f"{v:.4f}" for v in accel + gyro) + "\n"

    def loop(self):
        n = 0
        while not self.over:
            n += 1
            time.sleep(max(0.0, self.started + n / RATE_HZ - time.monotonic()))
            with self.lock:
                if not self.files:
                    continue
                rows = "" if n % 500 else "t_ms,ax (m/s^2),ay (m/s^2),az (m/s^2),gx (rad/s),gy (rad/s),gz (rad/s)\n"
                row = (rows + self.row(n / RATE_HZ)).encode()
                try:
                    os.write(self.files[0], row)
                except BlockingIOError:
                    # Nobody reads.
                    pass
