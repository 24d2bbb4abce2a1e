#!/usr/bin/env python3
"""Reports in Chromium: what has to hold of each.

    tests/browser/reports.py GRAVICAL [PICTURES]

The reports are those of simulated recordings and, where GRAVICAL_DATA is set, of real ones. PICTURES is a folder for
pictures of every page, for people. What does not hold ends the program with what it was.
"""

import base64
import os
import pathlib
import re
import shutil
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
    "orient": "orient line/line.csv -c poses.json", "noise": "noise static/static.csv",
}
OF_DATA = {
    "mpu6050": "calibrate {data}/tomisuarez-mpu6050/calibration.csv -o mpu.json",
    "mpu6050-motion": "motion {data}/tomisuarez-mpu6050/calibration.csv -c mpu.json",
    "xsens": "calibrate {data}/imu_tk-xsens/xsens_acc.txt.gz --gravity 9.81744",
    "chamber": "inspect {data}/tofupilot-thermal/part1_rows0-5249.tsv",
    "elevator": "motion {data}/pabrod-elevator/skyscrapper_up.csv", "walk": "motion {data}/xio-gait/short_walk.csv",
}

# Each returns what is wrong: nothing. The names of a legend are those of what is drawn; landmarks, one h1, no id
# twice, heads of tables with a scope, names of figures and tables for a screen reader.
WHOLE = {
    "series": """
const wrong = [];
for (const f of document.querySelectorAll('figure')) {
  const names = [...f.querySelectorAll('.data [data-name]')].filter(e => e.getAttribute('d')).map(e => e.dataset.name);
  const keys = [...f.querySelectorAll('.keys > span')].map(e => e.textContent);
  const distinct = [...new Set(names.filter(Boolean))];
  if (distinct.some(n => !keys.includes(n))) wrong.push([f.id, distinct, keys]);
  if (!f.querySelector('.plot, .solid')) wrong.push([f.id, 'no plot']);
  if (!f.getAttribute('aria-label') || !f.querySelector('[role][aria-label]')) wrong.push([f.id, 'no name']);
}
return wrong""",
    "tables": """
return [...document.querySelectorAll('.table')].filter(e => e.scrollWidth > e.clientWidth + 1 && e.offsetHeight)
  .map(e => [e.textContent.slice(0, 80), e.scrollWidth, e.clientWidth])""",
    "structure": """
const wrong = [], one = s => document.querySelectorAll(s).length;
for (const s of ['main', 'header', 'footer', 'h1', 'a.skip']) if (one(s) !== 1) wrong.push([s, one(s)]);
const ids = [...document.querySelectorAll('[id]')].map(e => e.id);
for (const id of ids) if (ids.indexOf(id) !== ids.lastIndexOf(id)) wrong.push(['twice', id]);
for (const th of document.querySelectorAll('th')) if (!th.scope) wrong.push(['scope', th.textContent]);
for (const t of document.querySelectorAll('table')) if (!t.getAttribute('aria-label')) wrong.push(['no name', t.textContent.slice(0, 80)]);
for (const a of document.querySelectorAll('a[href^="#"]')) if (!document.getElementById(a.hash.slice(1))) wrong.push(['no target', a.hash]);
for (const s of document.querySelectorAll('[aria-labelledby]')) for (const id of s.getAttribute('aria-labelledby').split(' ')) if (!document.getElementById(id)) wrong.push(['no label', id]);
return wrong""",
    # The verdict, and at least the head of the figure beside it, are on the first screen.
    "first screen": """
const wrong = [], f = document.querySelector('.verdict + section figure');
if (document.querySelector('#verdict')?.getBoundingClientRect().bottom > innerHeight) wrong.push('verdict');
if (f && f.getBoundingClientRect().top > innerHeight / 2) wrong.push('figure');
return wrong""",
}
TICKS = "[...f.querySelectorAll('.gx text, .gy text')].map(t => t.textContent).join(' ')"

# Texts of a plot stay in the page, are large enough, and ticks stay apart.
OVERLAP = """
const wrong = [], box = e => e.getBoundingClientRect(), w = document.documentElement.clientWidth;
for (const svg of document.querySelectorAll('.plot')) {
  const id = svg.closest('figure').id, shown = [...svg.querySelectorAll('text')].filter(t => box(t).width);
  for (const t of shown) {
    const b = box(t);
    if (b.left < -1 || b.right > w + 1) wrong.push([id, 'outside', t.textContent, b.left, b.right]);
    if (parseFloat(getComputedStyle(t).fontSize) < 10.5) wrong.push([id, 'small', t.textContent]);
  }
  for (const kind of ['.gx', '.gy']) {
    const ticks = shown.filter(t => t.closest(kind)).map(t => [t.textContent, box(t)]);
    for (let i = 1; i < ticks.length; i++) {
      const [a, b] = [ticks[i - 1][1], ticks[i][1]];
      const apart = a.right <= b.left || b.right <= a.left || a.bottom <= b.top + 3 || b.bottom <= a.top + 3;
      if (!apart) wrong.push([id, 'overlap', ticks[i - 1][0], ticks[i][0]]);
    }
  }
}
return wrong"""

OVERFLOW = """
const w = document.documentElement.clientWidth, wrong = [];
if (document.documentElement.scrollWidth > w) for (const e of document.body.querySelectorAll('*'))
  if (e.getBoundingClientRect().right > w + 1 && !e.closest('.table > *, pre, svg')) wrong.push([e.tagName, e.className]);
return document.documentElement.scrollWidth > w ? [document.documentElement.scrollWidth - w, wrong.slice(0, 5)] : []"""

# Where the plot of the first figure in which one reads and zooms lies in the window.
FIRST_PLOT = """
const p = [...document.querySelectorAll('.panel:not([data-rows]):not([data-log])')].find(e => e.offsetHeight);
if (!p) return null;
window.f = p.closest('figure');
f.scrollIntoView({ block: 'center' });
const b = p.querySelector('.plot').getBoundingClientRect();
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
    # Two calibrations and one that fails.
    for session in ("six", "poses", "static"):
        shutil.copytree(folder / session, folder / "fleet" / session)
    run("calibrate --each fleet --report all.html")
    return [folder / f"{name}.html" for name in [*lines, "all"]]


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
        assert before == self.ticks(), "a double click shows all"

    def the_pointer_reads_its_place(self):
        left, top, width, height = self.browser.run(FIRST_PLOT)
        self.mouse("mouseMoved", left + 0.25 * width, top + 0.75 * height)
        said = self.browser.run("return f.querySelector('.at').textContent").replace("−", "-")
        low, high = self.browser.run("return f.querySelector('.panel').dataset.x.split(' ').map(Number)")
        value = float(re.search(r"-?[\d.]+", said)[0])
        assert abs(value - (0.75 * low + 0.25 * high)) < 0.02 * (high - low), (said, low, high)
        assert self.browser.run("return f.querySelector('.name output').textContent.length") > 0

    def a_heading_sorts(self):
        """Numbers as numbers, and the other way round when it is pressed again; what has no number comes last."""
        column = ("const t = document.querySelector('[data-sort]'), i = [...t.tHead.rows[0].cells].findIndex(c => c.textContent.includes('error'));"
                  "t.tHead.rows[0].cells[i].querySelector('button').click();"
                  "return [...t.tBodies[0].rows].map(r => parseFloat(r.cells[i].innerText))")
        up, down = self.browser.run(column), self.browser.run(column)
        assert up[-1] is None and down[-1] is None and up[0] < up[1] and down[:2] == up[1::-1], (up, down)

    def a_board_lies_as_at_the_pointer(self):
        left, top, width, height = self.browser.run(FIRST_PLOT)
        lies = "return document.querySelector('[data-angles]').style.getPropertyValue('--attitude')"
        before = self.browser.run(lies)
        self.mouse("mouseMoved", left + 0.45 * width, top + height / 2)
        assert before != self.browser.run(lies), before

    def without_script(self):
        """The same sections, tables, drawings and legends; no buttons."""
        count = "return ['section', 'tr', '.data path', 'td', '.keys > span'].map(s => document.querySelectorAll(s).length)"
        before = self.browser.run(count)
        self.browser.cdp("Emulation.setScriptExecutionDisabled", value=True)
        self.browser.cdp("Page.reload")
        time.sleep(0.5)
        self.browser.cdp("Emulation.setScriptExecutionDisabled", value=False)
        assert before == self.browser.run(count)
        assert self.browser.run("return document.querySelectorAll('button').length") == 0

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
        if browser.run("return Boolean(document.querySelector('[data-angles]'))"):
            self.a_board_lies_as_at_the_pointer()
        if browser.run("return Boolean(document.querySelector('[data-sort]'))"):
            self.a_heading_sorts()
        printed = base64.b64decode(browser.cdp("Page.printToPDF", preferCSSPageSize=True)["data"])
        assert (pages := len(re.findall(rb"/Type\s*/Page[^s]", printed))) <= 3, (page.name, pages, "printed pages")
        for width in (1280, 800, 400, 360):
            browser.size(width, 900)
            browser.settle()
            self.nothing(width, OVERFLOW)
            self.nothing(width, OVERLAP)
            self.shot(width)
        for scheme in ("light", "dark"):
            browser.media(scheme)
            self.nothing(f"contrast, {scheme}", CONTRAST)
        browser.media()
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
