#!/usr/bin/env python3
"""The page of `gravical live` in Chromium, with pretended sessions.

    tests/browser/check.py [PICTURES] [SCENE ...]

Every scene at two widths, dark and light; then keys, ports and focus. PICTURES is a folder for
pictures, for people. What does not hold ends the program with what it was.
"""

import pathlib
import sys
import tempfile
import time

from browser import CONTRAST, Browser
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
    "simulate": ("wait", "hold it still"), "follower": ("wait", "to do"),
}
# Selectors that have to be shown, and that must not.
SHOWN = {
    "accept": ["#notice.done", "#next"], "rejected-moved": ["#notice.cross"], "undone": ["#notice.redo"],
    "redo": ["#tiles .redo"], "suspect": ["#tiles .redo"], "temperature": ["#notice.warning"], "gravity": ["#gravity"],
    "hint": ["#hint.due"], "capture": ["#tiles .capturing", "#chip.capture"], "settle": ["#tiles .hold_still"],
    "lost": ["#chip.lost"], "end-good": [".grade.good", ".saved"], "end-fair": [".grade.fair"], "end-poor": [".grade.poor"],
    "end-not-verifiable": [".grade.not-verifiable"], "simulate": ["#hands"], "simulate-end": [".truth"],
    "ports": ["#ports li:nth-child(3) button"], "ports-busy": ["#ports li:nth-child(2)", "#again"], "ports-silent": ["#flash .command:last-child", "#simulate"], "follower": ["#follower"], "interrupted": [".command"],
}
HIDDEN = {
    "end-good": ["#live", "#actions", ".truth", "#strip"], "follower": ["#actions"], "wait+x": ["#hands", "#gravity", "#result"],
    "free": ["#gravity"], "identify": ["#next"], "connect": ["#ports"], "session": ["#ports"], "ports": ["#live", "#actions", "#again", "#flash"], "connecting": ["#ports"],
    "full": ["#actions", "#follower", "#ports"],
}

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

    def the_rest(self, all_scenes):
        browser = self.browser
        # What the program refuses is said.
        self.open(all_scenes["accept"])
        self.session.refuse = "No pose is held now."
        browser.key(" ")
        self.until("return document.querySelector('#notice.warning')?.textContent.includes('No pose is held now')")
        assert any("400" in c["message"] for c in browser.complaints())
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
        browser.run("document.querySelector('.choice button').focus()")
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
        print("refusal, ports, focus, no answer, sound")


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
                check.the_rest(all_scenes)
        finally:
            browser.stop()


if __name__ == "__main__":
    main()
