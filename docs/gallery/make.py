#!/usr/bin/env python3
"""Makes the gallery: pages of the recordings in examples/, and pictures of their first screens.

    docs/gallery/make.py GRAVICAL [FOLDER]

FOLDER is this one by default. Where GRAVICAL_DATA is set, pages of real recordings go into its folder real, which is
not kept. Chromium and chromedriver have to be there.
"""

import os
import pathlib
import subprocess
import sys
import tempfile

HERE = pathlib.Path(__file__).resolve().parent
sys.path.insert(0, str(HERE.parents[1] / "tests/browser"))
from browser import Browser

PAGES = {
    "calibration": "calibrate poses/poses.csv --gravity 9.80665 -o cal.json",
    "motion": "motion line/line.csv -c cal.json -o track.csv",
    "orientation": "orient line/line.csv -c cal.json -o attitude.csv",
    "check": "check cal.json line/line.csv",
}
REAL = {
    "calibration": "calibrate {data}/tomisuarez-mpu6050/calibration.csv -o mpu.json",
    "elevator": "motion {data}/pabrod-elevator/skyscrapper_up.csv -o up.csv",
    "walk": "motion {data}/xio-gait/short_walk.csv -o walk.csv",
    "turns": "orient {data}/broad-orientation/05_undisturbed_slow_rotation_with_breaks_B.csv.gz -o q.csv",
}


def make(gravical, pages, folder):
    """Runs in the folder of the examples' recordings, so that the command in the foot of a page is short."""
    folder.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory() as work, tempfile.TemporaryDirectory() as profile:
        for name in ("poses", "line"):
            (pathlib.Path(work) / name).symlink_to(HERE.parents[1] / "examples/demo" / name)
        for name, line in pages.items():
            line = line.format(data=os.environ.get("GRAVICAL_DATA"))
            done = subprocess.run([gravical, *line.split(), "--report", f"{name}.html", "--quiet"], cwd=work)
            # An end that is open is no failure of the program.
            assert done.returncode in (0, 4), line
            (folder / f"{name}.html").write_bytes((pathlib.Path(work) / f"{name}.html").read_bytes())
        browser = Browser(profile)
        try:
            browser.size(1280, 900)
            for name in pages:
                browser.open(f"file://{folder.resolve()}/{name}.html")
                browser.settle(5)
                browser.picture(folder / f"{name}.webp", format="webp", quality=80)
        finally:
            browser.stop()


if __name__ == "__main__":
    program = str(pathlib.Path(sys.argv[1]).resolve())
    target = pathlib.Path(sys.argv[2]) if len(sys.argv) > 2 else HERE
    make(program, PAGES, target)
    if os.environ.get("GRAVICAL_DATA"):
        make(program, REAL, target / "real")
    print(f"{sum(f.stat().st_size for f in target.glob('*.*')) // 1000} kB")
