#!/usr/bin/env python3
"""The page of `gravical live` in Chromium, with pretended sessions.

    tests/browser/live/check.py [PICTURES] [SCENE ...]

Every scene at two widths, dark and light; then whole sessions by keyboard and by mouse. PICTURES
is a folder for pictures, for people. What does not hold ends the program with what it was.
"""

import pathlib
import sys
import tempfile
import time

from browser import Browser
from player import FREE, ORDER, Player
from scenes import scenes
from server import Session, serve

SIZES = [(1280, 900), (400, 860)]

# What has to be seen at the end of a scene: state, and a part of the sentence.
EXPECTED = {
    "connect": ("connect", "Connecting"), "ports": ("connect", "More than one port"), "ports-none": ("connect", "No board"),
    "ports-busy": ("connect", "minicom"), "ports-silent": ("connect", "nothing arrives"), "connecting": ("connect", "Connecting"), "full": ("connect", "too many tabs"), "identify": ("identify", "Reading"), "floor": ("floor", "on the table"),
    "wait+x": ("wait", "+x is up"), "wait-z": ("wait", "−z is up"), "settle": ("settle", "hold still"),
    "capture": ("capture", "1.2 s to go"), "lost": ("lost", "Unplugged"),
    "resumed": ("wait", "−y or −z"), "end-good": ("end", "saved"), "interrupted": ("end", "Ctrl-C"),
    "simulate": ("wait", "hold it still"),
}
# Selectors that have to be shown, and that must not.
SHOWN = {
    "accept": ["#notice.done", "#next"], "rejected-moved": ["#notice.cross"], "undone": ["#notice.redo"],
    "redo": ["#tiles .redo"], "suspect": ["#tiles .redo"], "temperature": ["#notice.warning"], "gravity": ["#gravity"],
    "hint": ["#hint.due"], "capture": ["#tiles .capturing", "#chip.capture"], "settle": ["#tiles .hold_still"],
    "lost": ["#chip.lost"], "end-good": [".grade.good", ".saved"], "end-fair": [".grade.fair"], "end-poor": [".grade.poor"],
    "end-not-verifiable": [".grade.not-verifiable"], "simulate": ["#hands"], "simulate-end": [".truth"],
    "ports": ["#ports li:nth-child(3) button"], "ports-busy": ["#ports li:nth-child(2)", "#again"], "ports-silent": ["#flash .command:last-child", "#simulate"], "interrupted": [".command"],
}
HIDDEN = {
    "end-good": ["#live", "#actions", ".truth", "#strip"], "wait+x": ["#hands", "#gravity", "#result"],
    "free": ["#gravity"], "identify": ["#next"], "connect": ["#ports"], "session": ["#ports"], "ports": ["#live", "#actions", "#again", "#flash"], "connecting": ["#ports"],
    "full": ["#actions", "#ports"],
}

# Text that is too faint on what is behind it; large text may be fainter.
CONTRAST = """
const parse = c => c.match(/[\\d.]+/g).map(Number);
const light = ([r, g, b]) => [r, g, b].map(v => v / 255).map(v => v <= .03928 ? v / 12.92 : ((v + .055) / 1.055) ** 2.4)
  .reduce((s, v, i) => s + v * [.2126, .7152, .0722][i], 0);
const out = [];
for (const e of document.querySelectorAll("body *")) {
  const text = [...e.childNodes].some(n => n.nodeType === 3 && n.textContent.trim());
  if (!text || !e.checkVisibility({ visibilityProperty: true }) || e.closest(".unseen, .icons, #actions :disabled, .hands :disabled, noscript")) continue;
  let behind = [255, 255, 255];
  for (let p = e; p; p = p.parentElement) {
    const c = parse(getComputedStyle(p).backgroundColor);
    if (c.length === 3 || c[3] > .99) { behind = c; break; }
  }
  const [a, b] = [light(parse(getComputedStyle(e).color)), light(behind)].sort((x, y) => y - x);
  const ratio = (a + .05) / (b + .05);
  if (ratio < 4.5) out.push([e.textContent.trim().slice(0, 40), ratio.toFixed(2)]);
}
return out;
"""

# What is wider than the page, or than the box that holds it.
OVERFLOW = """
const out = [];
if (document.documentElement.scrollWidth > innerWidth) out.push(["page", document.documentElement.scrollWidth]);
for (const e of document.querySelectorAll("main *, header *")) {
  const b = e.getBoundingClientRect();
  if (b.width && !e.closest(".scroll, #facts, .unseen") && (b.right > innerWidth + 1 || b.left < -1)) out.push([e.tagName, e.id, e.className, b.right]);
  if (e.matches("button") && e.scrollWidth > e.clientWidth + 1) out.push(["button", e.textContent]);
}
return out;
"""


class Check:
    def __init__(self, browser, session, url, pictures):
        self.browser, self.session, self.url, self.pictures = browser, session, url, pictures
        self.host = url.split("/?")[0]

    def open(self, events):
        self.session.play(events)
        self.browser.open(self.url)
        last = events[-1]["t_s"] if events else 0
        self.until(f"return (state.log.length || {int(not events)}) || state.status || state.session || state.ports || state.connecting || full")
        self.until(f"return !{int(bool(events))} || Math.max(state.status?.t_s ?? 0, state.end?.t_s ?? 0, state.session?.t_s ?? 0) >= {last}")
        self.browser.settle(6)

    def until(self, script, seconds=15.0):
        end = time.monotonic() + seconds
        while not (value := self.tried(script)):
            assert time.monotonic() < end, f"it never came: {script}\n{self.browser.run('return document.body.innerText')}"
            time.sleep(0.05)
        return value

    def tried(self, script):
        """What the script answers; nothing while a new tab still shows the browser's own page."""
        return self.browser.run(f"if (typeof state === 'undefined') return null; {script}")

    def shown(self, selector):
        return self.browser.run(f"const e = document.querySelector({selector!r}); return Boolean(e && e.checkVisibility())")

    def quiet(self, name):
        loud = self.browser.complaints()
        assert not loud, (name, loud)
        for url in self.browser.requests():
            assert url.startswith((self.host, "data:", "chrome:", "chrome-untrusted:")), (name, url)

    def scene(self, name, events):
        for width, height in SIZES:
            self.browser.size(width, height)
            self.open(events)
            for scheme in ("light", "dark"):
                # Without movement, so that colours are there at once.
                self.browser.media(scheme, "reduce")
                self.browser.settle()
                where = (name, width, scheme)
                state, part = EXPECTED.get(name, ("", ""))
                said, is_state = self.browser.run("return [document.querySelector('#sentence').textContent, document.body.dataset.state]")
                assert said and part in said, (where, said)
                assert not state or is_state == state, (where, is_state)
                for selector in SHOWN.get(name, []):
                    assert self.shown(selector), (where, selector)
                for selector in HIDDEN.get(name, []):
                    assert not self.shown(selector), (where, selector)
                assert not (faint := self.browser.run(CONTRAST)), (where, faint)
                assert not (wide := self.browser.run(OVERFLOW)), (where, wide)
                if self.pictures:
                    self.browser.settle(40)
                    self.browser.picture(self.pictures / f"{name}-{width}-{scheme}.png", whole=width == 400)
        if name == "hostile":
            assert self.browser.run("return document.querySelectorAll('img').length") == 0
        self.quiet(name)
        print("scene", name)

    def commands(self):
        return self.session.commands

    def accepted(self, number):
        self.until(f"return state.poses.size === {number} && [...state.poses.values()].every(p => p.t_s <= state.next_pose.t_s)")
        self.browser.settle()

    def by_keyboard(self):
        """From the first face to the end, a bump, undo and a face again on the way."""
        browser = self.browser
        Player(self.session)
        browser.open(self.url)
        self.until("return state.next_pose")
        key = {face: str(i + 1) for i, face in enumerate(["+x", "-x", "+y", "-y", "+z", "-z"])}
        for n, face in enumerate(ORDER):
            browser.key(key[face])
            self.accepted(n + 1)
        assert self.browser.run("return [...document.querySelectorAll('#tiles .done')].length") == 6
        browser.key("u")
        self.accepted(5)
        browser.key(key["-z"])
        self.accepted(6)
        browser.key("r")
        self.until("return document.querySelector('#tiles').classList.contains('choosing')")
        browser.key("Escape")
        self.until("return !document.querySelector('#tiles').classList.contains('choosing')")
        browser.key("r")
        browser.key("-")
        browser.key("y")
        self.accepted(5)
        assert self.commands()[-1] == {"command": "redo", "face": "-y"}
        browser.key(key["-y"])
        self.accepted(6)
        # A session that is not good yet asks before it ends.
        browser.key("Enter")
        self.until("return document.querySelector('#sure').open")
        browser.key("Escape")
        self.until("return !document.querySelector('#sure').open")
        browser.key("ArrowLeft")
        browser.key("ArrowLeft")
        browser.key("ArrowUp")
        self.until("return state.status.state === 'capture' || state.status.tilt_deg > 10")
        browser.key(" ")
        self.accepted(7)
        # Reload in the middle: the same session.
        browser.open(self.url)
        self.accepted(7)
        self.until("return state.status")
        browser.key("n")
        self.accepted(8)
        browser.key("n")
        self.accepted(9)
        self.until("return state.verdict?.grade === 'good'")
        browser.key("Enter")
        self.until("return state.end")
        self.until("return !document.querySelector('#result').hidden")
        assert self.shown(".truth") and self.shown(".grade.good")
        self.quiet("keyboard")
        print("a session by keyboard")

    def by_mouse(self):
        browser = self.browser
        Player(self.session)
        browser.open(self.url)
        self.until("return state.next_pose")
        for n, face in enumerate(ORDER):
            browser.click(f"#tiles button[title='Put {face.replace('-', '−')} up']")
            self.accepted(n + 1)
        browser.click("[data-command=undo]")
        self.accepted(5)
        browser.click("#tiles li:last-child button")
        self.accepted(6)
        browser.click("[data-command=redo]")
        self.until("return document.querySelector('#tiles').classList.contains('choosing')")
        browser.click("#tiles li:nth-child(1) button")
        self.accepted(5)
        browser.click("#tiles button")
        self.accepted(6)
        for n in (7, 8):
            browser.click("#as-drawn")
            self.accepted(n)
        x, y = browser.run("const b = document.querySelector('#board').getBoundingClientRect(); return [b.left + b.width / 2, b.top + b.height / 2]")
        # The board is drawn with the heading of the next pose now.
        self.until("return Math.cos(headingTo(lying(wanted().up), attitude)) > 0.9999")
        browser.drag((x, y), (x + 90, y - 60))
        self.until("return state.status.state === 'capture'")
        # Shaken while it is captured: rejected, and then taken where it lies.
        browser.click("#shake")
        self.until("return state.notice?.kind === 'cross'")
        self.accepted(9)
        sent = [c for c in self.commands() if c["command"] == "hand" and "up" in c][-1]["up"]
        assert abs(sum(v * v for v in sent) - 1) < 1e-6, sent
        browser.click("[data-command=finish]")
        self.until("return state.end && document.querySelector('.saved')")
        browser.click("#result [aria-expanded]")
        self.until("return document.querySelector('iframe')?.contentDocument?.title === 'Report'")
        self.quiet("mouse")
        print("a session by mouse")

    def the_rest(self, all_scenes):
        browser = self.browser
        # What the program refuses is said.
        self.open(all_scenes["accept"])
        self.session.refuse = "No pose is held now."
        browser.key(" ")
        self.until("return document.querySelector('#notice.warning')?.textContent.includes('No pose is held now')")
        assert any("400" in c["message"] for c in browser.complaints())
        # Gravity, with a comma.
        self.open(all_scenes["gravity"])
        browser.run("document.querySelector('#latitude').value = '48,1'; document.querySelector('#gravity [type=submit]').click()")
        self.until("return true")
        browser.settle()
        assert self.commands()[-1] == {"command": "gravity", "latitude": 48.1, "value": None}
        self.session.say({"v": 1, "t_s": 9.0, "type": "gravity", "gravity_mps2": 9.8085, "gravity_source": "latitude", "text": "Local gravity is 9.80850 m/s²."})
        self.until("return document.querySelector('#gravity').hidden")
        # A port is chosen by a click, by its number, again by Enter; nothing else is sent.
        self.open(all_scenes["ports"])
        browser.click("#ports li:nth-child(3) button")
        browser.key("2")
        browser.key(" ")
        browser.key("u")
        browser.key("Enter")
        self.until("return true")
        browser.settle()
        assert self.commands() == [{"command": "port", "name": f"/dev/{n}"} for n in ("ttyS0", "ttyUSB0")], self.commands()
        self.open(all_scenes["ports-silent"])
        browser.key("s")
        browser.settle()
        assert self.commands() == [{"command": "simulate"}], self.commands()
        self.open(all_scenes["ports-busy"])
        browser.key("Enter")
        browser.settle()
        assert self.commands() == [{"command": "port", "name": "/dev/ttyUSB0"}], self.commands()
        # One that is plugged in appears; the focus stays where it is.
        browser.run("document.querySelector('#ports li:nth-child(2) button').focus()")
        self.session.say(all_scenes["ports"][0])
        self.until("return document.querySelectorAll('#ports li').length === 3")
        assert browser.run("return document.activeElement.dataset.name") == "/dev/ttyUSB0"
        for event in all_scenes["accept"]:
            self.session.say(event)
        self.until("return document.querySelector('#ports').hidden && state.poses.size === 3")
        assert self.shown("#live") and self.shown("#actions")
        # A button with the focus does what it says, not what Space says.
        self.open(all_scenes["accept"])
        browser.run("document.querySelector('[data-command=undo]').focus()")
        browser.key(" ")
        self.until("return true")
        browser.settle()
        assert [c["command"] for c in self.commands()] == ["undo"], self.commands()
        # Other keys do what they say wherever the focus is.
        browser.run("document.querySelector('#mute').focus()")
        browser.key("u")
        browser.settle()
        assert [c["command"] for c in self.commands()] == ["undo", "undo"], self.commands()
        # Every button is reached by Tab, with its focus seen.
        reached = set()
        for _ in range(15):
            browser.key("Tab")
            reached.add(browser.run("const e = document.activeElement; return e.matches(':focus-visible') && getComputedStyle(e).outlineStyle !== 'none' ? e.dataset.command ?? e.id : ''"))
        assert {"capture", "undo", "redo", "cancel", "mute"} <= reached, reached
        # What a reader of the screen says is the sentence.
        self.until("return document.querySelector('#announcement').textContent.startsWith('Put any face')")
        # The program is gone for a while.
        self.session.hang_up(True)
        self.until("return document.querySelector('#sentence').textContent.includes('does not answer')")
        assert self.shown("#tiles .done")
        self.session.hang_up(False)
        self.until("return document.querySelector('#sentence').textContent.startsWith('Put any face')")
        assert all("events" in c["message"] for c in browser.complaints())
        # Sound off, and still off when the page is loaded again.
        for pressed in ("true", "false"):
            browser.key("m")
            browser.open(self.url)
            self.until(f"return document.querySelector('#mute').getAttribute('aria-pressed') === '{pressed}'")
        self.quiet("the rest")
        print("refusal, gravity, focus, no answer, sound")

    def half_an_hour(self):
        """Frames a second with half an hour of history; printed, not asserted."""
        self.open(scenes()["accept"])
        rate = self.browser.call("POST", f"{self.browser.session}/execute/async", {"args": [], "script": """
          const done = arguments[0], template = structuredClone(state.status);
          let t = state.status.t_s;
          const push = () => take({ ...template, t_s: t += .1, noise_mg: 5 + 60 * Math.random(), norm_g: 1 + .1 * Math.random(),
            attitude: turn([0, 0, 1], t) });
          for (let i = 0; i < 18000; i++) push();
          const timer = setInterval(push, 100), own = chart.draw.bind(chart);
          let frames = 0;
          // The last thing that a frame draws.
          chart.draw = colours => { frames++; own(colours); };
          setTimeout(() => {
            clearInterval(timer);
            chart.draw = own;
            done([frames / 3, strip.points.length]);
          }, 3000);"""})
        print(f"{rate[0]:.0f} frames a second with half an hour of history, {rate[1]} points")
        assert rate[1] < 700, rate


def main():
    words = sys.argv[1:]
    pictures = pathlib.Path(words[0]) if words else None
    if pictures:
        pictures.mkdir(parents=True, exist_ok=True)
    wanted = words[1:]
    session = Session()
    _, url = serve(session)
    all_scenes = scenes()
    with tempfile.TemporaryDirectory() as profile:
        browser = Browser(profile)
        try:
            check = Check(browser, session, url, pictures)
            for name, events in all_scenes.items():
                if not wanted or name in wanted:
                    check.scene(name, events)
            if not wanted:
                browser.size(1280, 900)
                browser.media()
                check.by_keyboard()
                check.by_mouse()
                check.the_rest(all_scenes)
                check.half_an_hour()
        finally:
            browser.stop()


if __name__ == "__main__":
    main()
