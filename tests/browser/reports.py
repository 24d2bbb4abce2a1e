#!/usr/bin/env python3
"""Reports in Chromium: what has to hold of each.

    tests/browser/reports.py GRAVICAL [PICTURES]

The reports are those of simulated recordings and, where GRAVICAL_DATA is set, of real ones. PICTURES is a folder for
pictures of every page, for people. What does not hold ends the program with what it was.
"""

import os
import pathlib
import re
import subprocess
import sys
import tempfile
import time

from browser import CONTRAST, Browser

SIMULATED = ["six-position --output six --seed 3", "poses --output poses --seed 4", "line --output line --seed 5",
             "static --output static --seed 6"]
REPORTS = {
    "six": "calibrate six -o six.json", "ferraris": "calibrate six --method ferraris",
    "poses": "calibrate poses/poses.csv -o poses.json", "line": "motion line/line.csv",
    "line-calibrated": "motion line/line.csv -c poses.json", "static": "motion static/static.csv -c poses.json",
    "check": "check poses.json six", "compare": "compare poses.json six.json", "inspect": "inspect poses/poses.csv",
    "denoise": "denoise line/line.csv -o smooth.csv --filter hampel:7,3 --filter butter:4,5Hz",
}
OF_DATA = {
    "mpu6050": "calibrate {data}/tomisuarez-mpu6050/calibration.csv -o mpu.json",
    "mpu6050-motion": "motion {data}/tomisuarez-mpu6050/calibration.csv -c mpu.json",
    "xsens": "calibrate {data}/imu_tk-xsens/xsens_acc.txt.gz --gravity 9.81744",
    "chamber": "inspect {data}/tofupilot-thermal/part1_rows0-5249.tsv",
    "elevator": "motion {data}/pabrod-elevator/skyscrapper_up.csv", "walk": "motion {data}/xio-gait/short_walk.csv",
}

# Each returns what is wrong: nothing. The names of a legend are those of what is drawn; landmarks, one h1, no id
# twice, heads of tables with a scope.
WHOLE = {
    "series": """
const wrong = [];
for (const f of document.querySelectorAll('figure')) {
  const names = [...f.querySelectorAll('.plot [data-name]')].filter(e => !e.classList.contains('guide')).map(e => e.dataset.name);
  const entries = [...f.querySelectorAll('.legend .entry')].map(e => e.dataset.name);
  const distinct = [...new Set(names.filter(Boolean))];
  if (distinct.some(n => !entries.includes(n)) || entries.length !== distinct.length) wrong.push([f.id, distinct, entries]);
  if (!f.querySelector('.plot')) wrong.push([f.id, 'no plot']);
  for (const s of f.querySelectorAll('.series'))
    if (!s.querySelector('path, line, .at, rect')) wrong.push([f.id, s.dataset.name, 'empty']);
}
return wrong""",
    "tables": """
return [...document.querySelectorAll('.scroll')].filter(e => e.scrollWidth > e.clientWidth + 1)
  .map(e => [e.getAttribute('aria-label'), e.scrollWidth, e.clientWidth])""",
    "structure": """
const wrong = [], one = s => document.querySelectorAll(s).length;
for (const s of ['main', 'header', 'nav', 'h1', 'a.skip']) if (one(s) !== 1) wrong.push([s, one(s)]);
const ids = [...document.querySelectorAll('[id]')].map(e => e.id);
for (const id of ids) if (ids.indexOf(id) !== ids.lastIndexOf(id)) wrong.push(['twice', id]);
for (const th of document.querySelectorAll('th')) if (!th.scope) wrong.push(['scope', th.textContent]);
for (const a of document.querySelectorAll('a[href^="#"]')) if (!document.getElementById(a.hash.slice(1))) wrong.push(['no target', a.hash]);
for (const s of document.querySelectorAll('[aria-labelledby]')) for (const id of s.getAttribute('aria-labelledby').split(' ')) if (!document.getElementById(id)) wrong.push(['no label', id]);
return wrong""",
}
TICKS = ("[...f.querySelectorAll('.tx text, .ty text')].map(t => t.textContent).join(' ')"
         " + [...f.querySelectorAll('g.data')].map(g => g.getAttribute('transform'))")

# Text stays in its drawing and is large enough, and ticks stay apart.
OVERLAP = """
const wrong = [], box = e => e.getBoundingClientRect();
for (const svg of document.querySelectorAll('.drawing > svg')) {
  const all = box(svg), id = svg.closest('figure').id;
  for (const t of svg.querySelectorAll('text')) {
    const b = box(t);
    if (!b.width || getComputedStyle(t).visibility === 'hidden' || t.closest('.plot')) continue;
    if (b.left < all.left - 1 || b.right > all.right + 1 || b.top < all.top - 1 || b.bottom > all.bottom + 1)
      wrong.push([id, 'outside', t.textContent, b.left - all.left, b.right - all.right, b.top - all.top, b.bottom - all.bottom]);
    const size = parseFloat(getComputedStyle(t).fontSize) * all.width / svg.viewBox.baseVal.width;
    if (size < 10.5) wrong.push([id, 'small', t.textContent, size]);
  }
  for (const kind of ['.tx', '.ty']) for (const g of svg.querySelectorAll(kind)) {
    const ticks = [...g.querySelectorAll('text:not([transform])')].map(t => [t.textContent, box(t)]);
    for (let i = 1; i < ticks.length; i++) {
      const [a, b] = [ticks[i - 1][1], ticks[i][1]];
      const apart = a.right <= b.left || b.right <= a.left || a.bottom <= b.top + 2 || b.bottom <= a.top + 2;
      if (!apart) wrong.push([id, 'overlap', ticks[i - 1][0], ticks[i][0]]);
    }
  }
}
return wrong"""

OVERFLOW = """
const w = document.documentElement.clientWidth, wrong = [];
if (document.documentElement.scrollWidth > w) for (const e of document.body.querySelectorAll('*'))
  if (e.getBoundingClientRect().right > w + 1 && !e.closest('.scroll > *, pre > *, svg')) wrong.push([e.tagName, e.className]);
return document.documentElement.scrollWidth > w ? [document.documentElement.scrollWidth - w, wrong.slice(0, 5)] : []"""

# Where the plot of the first figure in which one reads and zooms lies in the window.
FIRST_PLOT = """
const p = document.querySelector('.panel[data-view]');
if (!p) return null;
window.f = p.closest('figure');
f.scrollIntoView({ block: 'center' });
const b = p.querySelector('.frame').getBoundingClientRect();
return [b.left, b.top, b.width, b.height]"""

def written(program, folder):
    """Every report, written into the folder."""
    def run(line):
        done = subprocess.run([program, *line.split()], cwd=folder, capture_output=True, text=True)
        # A poor verdict is no failure of the program.
        assert done.returncode in (0, 4), (line, done.stderr)

    for line in SIMULATED:
        run(f"simulate {line}")
    lines = dict(REPORTS)
    if data := os.environ.get("GRAVICAL_DATA"):
        lines |= {name: line.format(data=data) for name, line in OF_DATA.items()}
    else:
        print("skipped: reports of real recordings, GRAVICAL_DATA is not set")
    for name, line in lines.items():
        run(f"{line} --json --report {name}.html --force")
    return [folder / f"{name}.html" for name in lines]


class Reports:
    def __init__(self, browser, pictures):
        self.browser, self.pictures = browser, pictures

    def nothing(self, what, script):
        assert not (wrong := self.browser.run(script)), (self.page.name, what, wrong)

    def mouse(self, kind, x, y, **more):
        self.browser.cdp("Input.dispatchMouseEvent", type=kind, x=x, y=y, **more)

    def ticks(self):
        return self.browser.run(f"return {TICKS}")

    def shot(self, how):
        if self.pictures:
            self.browser.picture(self.pictures / f"{self.page.stem}-{how}.png", whole=True)

    def an_interval_is_zoomed_into(self):
        """A mouse that is dragged; a double click brings back what was there."""
        left, top, width, height = self.browser.run(FIRST_PLOT)
        before, y = self.ticks(), top + height / 2
        self.browser.drag((left + 0.4 * width, y), (left + 0.6 * width, y), 2)
        assert before != self.ticks(), "a drag zooms"
        for count in (1, 2):
            click = {"button": "left", "buttons": 1, "clickCount": count}
            self.mouse("mousePressed", left + 0.5 * width, y, **click)
            self.mouse("mouseReleased", left + 0.5 * width, y, **click)
        shown = self.browser.run("return [...f.querySelectorAll('g.data')].map(g => g.getAttribute('transform'))")
        assert all(t is None or t.startswith("matrix(1 0 0 1 0") or not t.startswith("matrix") for t in shown), shown

    def the_pointer_reads_its_place(self):
        left, top, width, height = self.browser.run(FIRST_PLOT)
        self.mouse("mouseMoved", left + 0.25 * width, top + 0.75 * height)
        said = self.browser.run("return f.querySelector('output').textContent").replace("−", "-")
        view = self.browser.run("return f.querySelector('.panel').dataset.view.split(' ').map(Number)")
        for value, (low, high) in zip(re.findall(r" (-?[\d.]+)(?=;| )", said), (view[:2], view[2:])):
            assert abs(float(value) - (0.75 * low + 0.25 * high)) < 0.01 * (high - low), (said, view)

    def without_script(self):
        """The same sections, tables and drawings; no buttons, and the legends are there."""
        count = "return ['section', 'tr', '.drawing > svg', 'td'].map(s => document.querySelectorAll(s).length)"
        before = self.browser.run(count)
        self.browser.cdp("Emulation.setScriptExecutionDisabled", value=True)
        self.browser.cdp("Page.reload")
        time.sleep(0.5)
        self.browser.cdp("Emulation.setScriptExecutionDisabled", value=False)
        assert before == self.browser.run(count)
        plain = ("return [document.querySelectorAll('button').length,"
                 " [...document.querySelectorAll('.legend')].every(l => getComputedStyle(l).display !== 'none')]")
        assert self.browser.run(plain) == [0, True]

    def quiet(self):
        """Nothing was complained of, and nothing but the page was asked for."""
        assert not (loud := self.browser.complaints()), loud
        urls = [url for url in self.browser.requests() if not url.startswith(("data:", "chrome"))]
        assert urls and all(url.startswith("file://") and self.page.name in url for url in urls), urls

    def look(self, page):
        self.page, browser = page, self.browser
        browser.size(1280, 900)
        browser.media()
        browser.complaints(), browser.requests()
        browser.open(f"file://{page}")
        browser.settle()
        for what, script in WHOLE.items():
            self.nothing(what, script)
        if browser.run(FIRST_PLOT):
            self.the_pointer_reads_its_place()
            self.an_interval_is_zoomed_into()
        assert browser.cdp("Page.printToPDF")["data"]
        for width in (1280, 800, 400):
            browser.size(width, 900)
            browser.settle()
            self.nothing(width, OVERFLOW)
            self.nothing(width, OVERLAP)
            self.shot(width)
        self.nothing("contrast", CONTRAST)
        browser.size(1280, 900)
        self.without_script()
        self.quiet()
        print(page.stem)


def main():
    program = str(pathlib.Path(sys.argv[1]).resolve())
    pictures = pathlib.Path(sys.argv[2]) if len(sys.argv) > 2 else None
    if pictures:
        pictures.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory() as profile, tempfile.TemporaryDirectory() as folder:
        pages = written(program, pathlib.Path(folder))
        browser = Browser(profile)
        try:
            reports = Reports(browser, pictures)
            for page in pages:
                reports.look(page)
        finally:
            browser.stop()


if __name__ == "__main__":
    main()
