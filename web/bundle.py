#!/usr/bin/env python3
"""bundle.py WASM DIST [FIRMWARE]: the page as one file, gravical.html; and index.html with gravical.wasm beside it, to be served.

FIRMWARE is the folder of firmware/build: its sketch can be flashed from the page.
"""

import base64
import datetime
import gzip
import hashlib
import io
import os
import re
import sys
import tarfile
from pathlib import Path

HERE = Path(__file__).resolve().parent
ROOT = HERE.parent
SHARED = ROOT / "crates/gravical-report/src/style"
LIVE = ROOT / "crates/gravical-cli/src/cmd/live/page"
STYLES = [SHARED / "shared.css", SHARED / "board.css", LIVE / "page.css", HERE / "page/web.css"]
# The page of `gravical live` is a part of this one; who guides its session is another.
SCRIPTS = [LIVE / f"{name}.js" for name in ["dom", "board", "session", "markup", "sound"]]
SCRIPTS += [HERE / f"page/{name}.js" for name in ["engine", "serial", "zip", "flash", "host"]] + [LIVE / "page.js", HERE / "page/files.js"]
SKETCH = ROOT / "firmware/mpu6050_logger/mpu6050_logger.ino"
PICTURE = ROOT / "docs/gallery/calibration.webp"
EXAMPLES = {"poses.csv": ROOT / "examples/demo/poses/poses.csv", "move.csv": ROOT / "examples/demo/line/line.csv"}
REPORT = ROOT / "crates/gravical-report/src/document/html/script.js"
# Nothing is sent, and no script runs but that of the page and that of the reports in it. What lies beside the page is fetched,
# where it does.
POLICY = (
    "default-src 'none'; script-src {scripts} 'wasm-unsafe-eval'; style-src 'unsafe-inline'; worker-src blob:; "
    "img-src data: blob:; frame-src blob:; base-uri 'none'; form-action 'none'; connect-src {connect}"
)


def joined(paths):
    return "\n".join(path.read_text() for path in paths)


def inert(name, text, kind=""):
    """Text that the page reads, and that the browser does not run."""
    assert "</script" not in text, name
    return f'<script type="text/plain" id="{name}" class="{kind}">{text}</script>\n'


def packed(data):
    return base64.b64encode(gzip.compress(data, 9, mtime=0)).decode()


def firmware(folder):
    """The sketch as it is flashed, and the sources of all that is in it, as the licence of the Arduino core asks for."""
    core = Path(os.environ.get("ARDUINO_AVR", "/usr/share/arduino/hardware/arduino/avr"))
    archive = io.BytesIO()
    with tarfile.open(fileobj=archive, mode="w") as tar:
        def add(path, name):
            info = tar.gettarinfo(path, name)
            info.mtime, info.uid, info.gid, info.uname, info.gname = 0, 0, 0, "", ""
            with open(path, "rb") as file:
                tar.addfile(info, file)

        for root, name in [(core / "cores/arduino", "arduino/cores/arduino"), (core / "variants/standard", "arduino/variants/standard"),
                           (core / "libraries/Wire/src", "arduino/libraries/Wire/src"), (ROOT / "firmware", "firmware")]:
            for path in sorted(p for p in root.rglob("*") if p.is_file()):
                add(path, f"{name}/{path.relative_to(root)}")
        licence = Path("/usr/share/common-licenses/LGPL-2.1")
        if licence.is_file():
            add(licence, "arduino/LGPL-2.1")
    return inert("firmware", (folder / "mpu6050_logger.hex").read_text()) + inert("sources", packed(archive.getvalue()))


def session():
    """The page of `gravical live`: what is before its head line, in it, and after it."""
    page = (LIVE / "page.html").read_text()
    for name in ["sheet", "scene"]:
        page = page.replace(f"{{{name}}}", (SHARED / f"{name}.html").read_text())
    return re.search(r"<body[^>]*>(.*?)<header>.*?</p>(.*?)</header>(.*?)<noscript>", page, re.S).groups()


def page(wasm, version):
    parts = inert("worker", (HERE / "page/worker.js").read_text()) + inert("sketch", SKETCH.read_text())
    parts += "".join(inert(f"{name}.gz", packed(path.read_bytes()), "example") for name, path in EXAMPLES.items())
    parts += firmware(Path(sys.argv[3])) if len(sys.argv) > 3 else ""
    parts += inert("wasm", packed(wasm)) if wasm else ""
    before, head, after = session()
    script = '\n"use strict";\n' + joined(SCRIPTS)
    hashes = [base64.b64encode(hashlib.sha256(text.encode()).digest()).decode() for text in [script, REPORT.read_text()]]
    scripts = " ".join(f"'sha256-{text}'" for text in hashes)
    values = {"policy": POLICY.format(scripts=scripts, connect="'none'" if wasm else "'self'"), "style": joined(STYLES), "parts": parts,
              "version": version, "script": script, "picture": "data:image/webp;base64," + base64.b64encode(PICTURE.read_bytes()).decode(), "before": before, "head": head, "session": after}
    return re.sub(r"\{(\w+)\}", lambda m: values[m[1]], (HERE / "page/page.html").read_text())


wasm, dist = Path(sys.argv[1]).read_bytes(), Path(sys.argv[2])
day = datetime.datetime.fromtimestamp(int(os.environ.get("SOURCE_DATE_EPOCH", datetime.datetime.now().timestamp())), datetime.timezone.utc)
number = re.search(r'^version = "(.*)"', (ROOT / "Cargo.toml").read_text(), re.M)[1]
version = f"{number}, {day:%Y-%m-%d}"
dist.mkdir(parents=True, exist_ok=True)
for name, data in [("gravical.wasm", wasm), ("index.html", page(None, version).encode()), ("gravical.html", page(wasm, version).encode())]:
    (dist / name).write_bytes(data)
    print(f"{dist / name}: {len(data) / 1e6:.2f} MB")
