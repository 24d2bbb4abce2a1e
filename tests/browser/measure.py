#!/usr/bin/env python3
"""What the page of `gravical live` costs: from a sample to its tile, processor, memory.

    tests/browser/measure.py GRAVICAL [SECONDS]

A scripted board sends 500 rows a second to a pseudo-terminal; its clock is that of this computer. The figures are in
CONTRIBUTING.md; nothing is judged here.
"""

import os
import pathlib
import sys
import tempfile
import time

from board import Board
from browser import Browser
from program import SIZES, Live

RATE_HZ = 500
# After the page was updated with a status: the age of the sample that it shows, ms.
AGES = """
const began_ms = %f, own = update;
window.ages = [];
let last = null;
update = () => {
  own();
  const t_s = state.status?.t_s;
  if (t_s === undefined || t_s === last) return;
  last = t_s;
  // What is drawn now is seen with the next frame.
  requestAnimationFrame(() => ages.push(performance.timeOrigin + performance.now() - began_ms - 1000 * t_s));
};
"""


def cost(pid):
    """Seconds of processor, and resident memory, MiB."""
    fields = pathlib.Path(f"/proc/{pid}/stat").read_text().rsplit(")", 1)[1].split()
    status = pathlib.Path(f"/proc/{pid}/status").read_text()
    memory = next(int(line.split()[1]) for line in status.splitlines() if line.startswith("VmHWM"))
    return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK"), memory / 1024


def quantiles(values):
    values = sorted(values)
    return [values[min(len(values) - 1, int(q * len(values)))] for q in (0.5, 0.95, 1.0)]


class Measure(Live):
    def page(self, seconds):
        with tempfile.TemporaryDirectory() as folder:
            board = Board(folder, RATE_HZ)
            try:
                with self.session("--port", str(board.port), "--folder", "s") as where:
                    self.ready()
                    rows = (where / "s/recording.csv").read_text().splitlines()
                    first_ms = float(next(r for r in rows if r[:1].isdigit()).split(",")[0])
                    self.browser.run(AGES % (1000 * board.started_at + first_ms))
                    before_s, _ = cost(self.child.pid)
                    began = time.monotonic()
                    ups = [(1, 0, 0.02), (-1, 0.02, 0), (0, 1, 0.02), (0.02, -1, 0), (0, 0.02, -1), (0.6, 0.6, 0.5), (-0.6, 0.6, 0.5)]
                    k = 0
                    while time.monotonic() - began < seconds:
                        # Turned every seven seconds: captures, fits and rejections belong to it.
                        board.turn(ups[k % len(ups)])
                        k += 1
                        time.sleep(7)
                    spent_s, memory = cost(self.child.pid)
                    took_s = time.monotonic() - began
                    ages = self.browser.run("return ages")
                    poses = self.browser.run("return state.poses.size")
            finally:
                board.close()
        print(f"{RATE_HZ} Hz, {took_s:.0f} s, {poses} poses: {100 * (spent_s - before_s) / took_s:.1f} % of a core, {memory:.0f} MiB")
        print("from a sample to the page, ms (median, 95 %, most): " + ", ".join(f"{v:.0f}" for v in quantiles(ages)), f"of {len(ages)}")


def main():
    program = str(pathlib.Path(sys.argv[1]).resolve())
    seconds = float(sys.argv[2]) if len(sys.argv) > 2 else 180.0
    with tempfile.TemporaryDirectory() as profile:
        browser = Browser(profile)
        try:
            browser.size(*SIZES[0])
            browser.media()
            Measure(browser, program, None).page(seconds)
        finally:
            browser.stop()


if __name__ == "__main__":
    main()
