#!/usr/bin/env python3
"""The page of `gravical live` in Chromium: whole sessions with the program itself.

    tests/browser/program.py GRAVICAL [PICTURES]

PICTURES is a folder for pictures, for people. What does not hold ends the program with what it was.
"""

import contextlib
import pathlib
import signal
import subprocess
import sys
import tempfile
import time

from board import BIAS, G, Board
from browser import CONTRAST, Browser

SIZES = [(1280, 900), (400, 860)]
FACES = ["+x", "-x", "+y", "-y", "-z"]

# What is wider than the page, or than the box that holds it.
OVERFLOW = """
const out = [];
if (document.documentElement.scrollWidth > innerWidth) out.push(["page", document.documentElement.scrollWidth]);
for (const e of document.querySelectorAll("main *, header *")) {
  const b = e.getBoundingClientRect();
  if (b.width && !e.closest("#facts, .unseen, .drawing") && (b.right > innerWidth + 1 || b.left < -1)) out.push([e.tagName, e.id, e.className, b.right]);
  if (e.matches("button") && e.scrollWidth > e.clientWidth + 1) out.push(["button", e.textContent]);
}
return out;
"""


class Live:
    """A browser at the page of a program."""

    def __init__(self, browser, program, pictures):
        self.browser, self.program, self.pictures = browser, program, pictures

    @contextlib.contextmanager
    def session(self, *options):
        """A program that runs until this ends; its page is open."""
        with tempfile.TemporaryDirectory() as folder:
            self.child = subprocess.Popen([self.program, "live", "--no-open", *options], cwd=folder, text=True,
                                          stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE)
            try:
                self.url = self.child.stderr.readline().strip()
                self.host = self.url.split("/?")[0]
                self.browser.open(self.url)
                yield pathlib.Path(folder)
            finally:
                # A page whose program ends under it complains, at a time that nobody knows: in the next session.
                with contextlib.suppress(RuntimeError):
                    self.browser.open("about:blank")
                self.child.send_signal(signal.SIGINT)
                self.child.communicate(timeout=20)
                self.browser.complaints()
                self.browser.requests()

    def simulated(self, speed, seed=4, *options):
        return self.session("--simulate", "--seed", str(seed), "--folder", "s", "--speed", str(speed), *options)

    def until(self, script, seconds=15.0):
        """Waits for what the script answers; nothing while a new tab still shows the browser's own page."""
        end = time.monotonic() + seconds
        while not (value := self.browser.run(f"if (typeof state === 'undefined') return null; {script}")):
            assert time.monotonic() < end, f"it never came: {script}\n{self.browser.run('return document.body.innerText')}"
            time.sleep(0.05)
        return value

    def shown(self, selector):
        return self.browser.run(f"const e = document.querySelector({selector!r}); return Boolean(e && e.checkVisibility())")

    def quiet(self, name):
        """Nothing was complained of, and nothing but the program was asked."""
        assert not (loud := self.browser.complaints()), (name, loud)
        for url in self.browser.requests():
            assert url.startswith((self.host, "data:", "chrome:", "chrome-untrusted:")), (name, url)

    def look(self, name):
        """All text is read and nothing overflows, dark and light, at both sizes; a picture of each size."""
        browser = self.browser
        for width, height in SIZES:
            browser.size(width, height)
            # Without movement, so that colours are there at once.
            for scheme in ("dark", "light"):
                browser.media(scheme, "reduce")
                browser.settle()
                assert not (faint := browser.run(CONTRAST)), (name, width, scheme, faint)
                assert not (wide := browser.run(OVERFLOW)), (name, width, wide)
            if self.pictures:
                browser.settle(10)
                browser.picture(self.pictures / f"{name}-{width}.png", whole=width == 400)
        browser.size(*SIZES[0])
        browser.media()

    def take(self, event):
        """Gives an event to the page, as if the program had sent it."""
        self.browser.run(f"take({event})")
        self.browser.settle()

    def ready(self):
        """The first pose is the rest that the noise was measured in."""
        self.until("return state.poses.size === 1 && state.status?.state === 'wait'", 60)

    def accepted(self, number):
        # What is wanted next is known after the fit.
        self.until(f"return state.poses.size === {number} && (state.fit?.poses ?? {number}) === {number}"
                   " && [...state.poses.values()].every(p => p.t_s <= state.next_pose.t_s)", 60)
        self.browser.settle(8)

    def is_good(self):
        return self.browser.run("return state.verdict?.grade === 'good'")

    def ended(self, name):
        """The end: verdict, truth, report, and nothing that the console complains about."""
        self.until("return state.end?.reason === 'finished'", 60)
        self.until("return document.querySelector('.truth')?.checkVisibility()")
        assert self.shown(".saved") and not self.shown("#actions") and not self.shown(".grade")
        before, after = self.browser.run("return [state.truth.before_mg, state.truth.norm_error_mg]")
        assert after < 5 < before, (before, after)
        # The report as a whole: the page scrolls, not its frame.
        self.until("return document.querySelector('iframe')?.contentDocument?.querySelectorAll('svg').length > 3")
        self.until("const f = document.querySelector('iframe'); return f.clientHeight >= f.contentDocument.body.scrollHeight")
        self.look(f"{name}-end")
        # Where it could not be written the page says the verdict.
        self.take("{ ...state.saved, report: null }")
        for grade in ("fair", "poor", "not-verifiable"):
            self.take(f"{{ ...state.verdict, grade: '{grade}' }}")
            assert self.shown(f".grade.{grade}")
            self.look(f"{name}-{grade}")
        self.quiet(name)

    def by_keyboard(self):
        browser = self.browser
        # Long enough for a push in it, at this speed.
        with self.simulated(4, 4, "--capture", "4") as folder:
            self.ready()
            self.look("ready")
            key = lambda face: browser.key(browser.run(f"return String(FACES.indexOf('{face}') + 1)"))
            # A push in the capture: rejected with its reason; what was accepted stays. The key is
            # pressed from within, so that it is in time.
            browser.run("""const timer = setInterval(() => {
              if (state.status?.state !== 'capture' || state.status.ring < 0.2) return;
              clearInterval(timer);
              document.body.dispatchEvent(new KeyboardEvent('keydown', { key: 's', bubbles: true }));
            }, 10);""")
            key("+x")
            self.until("return document.querySelector('#notice[data-mark=cross]')?.textContent.includes('moved')", 60)
            self.look("rejected")
            self.accepted(2)
            for count, face in enumerate(FACES[1:], start=3):
                key(face)
                self.accepted(count)
            browser.key("u")
            self.until("return state.poses.size === 5 && document.querySelector('#notice[data-mark=redo]')")
            key("-z")
            self.accepted(6)
            browser.key("r")
            key("-y")
            self.until("return state.status?.tiles['-y'] === 'redo'")
            self.look("redo")
            key("-y")
            self.accepted(6)
            self.look("six")
            # An early end, and on: the question says what the verdict will be.
            browser.key("Enter")
            assert "Not verifiable" in browser.run("return document.querySelector('#sure p').textContent")
            self.look("sure")
            browser.key("Enter")
            self.until("return state.saved?.next[0] === 'gravical live --resume s' && state.end", 60)
            self.look("saved-early")
            browser.click("#result .primary")
            self.until("return !state.end && state.poses.size === 6 && state.status?.state === 'wait'", 60)
            browser.click("#as-drawn")
            self.accepted(7)
            for count in range(8, 17):
                if self.is_good():
                    break
                browser.key("n")
                self.accepted(count)
            assert self.is_good()
            self.look("good")
            browser.key("Enter")
            self.ended("keyboard")
            for name in ("recording.csv", "session.ndjson", "calibration.json", "calibration-2.json", "calibration-2.html"):
                assert (folder / "s" / name).stat().st_size > 1000, name
            # The last tab is gone: the program, too.
            browser.open("about:blank")
            assert self.child.wait(timeout=20) == 0
        print("a session by keyboard")

    def by_hand(self):
        """The virtual board is dragged, and turned by keys."""
        browser = self.browser
        with self.simulated(4):
            self.ready()
            x, y, width = browser.run("const b = document.querySelector('#board').getBoundingClientRect();"
                                      "return [b.left + b.width / 2, b.top + b.height / 2, b.width]")
            arrow = lambda: browser.key("ArrowLeft")
            for turn in (lambda: browser.drag((x, y), (x - width / 4, y - width / 5)), lambda: (arrow(), arrow())):
                up = browser.run("return state.status.up")
                turn()
                self.until(f"return angleDeg(state.status.up, {up}) > 15 && !turned", 30)
            self.quiet("by hand")
        print("a virtual board that is dragged")

    def loaded_again(self):
        """A page that is loaded again in a capture, and two tabs, of which each can command."""
        browser = self.browser
        # Long enough for the page to be loaded again in it, on a busy machine too.
        with self.simulated(1, 4, "--capture", "6"):
            self.ready()
            browser.key("1")
            self.until("return state.status?.state === 'capture' && state.status.ring > 0.2", 60)
            self.look("capture")
            browser.open(self.url)
            self.until("return state.poses.size === 1 && state.status?.state === 'capture'")
            self.accepted(2)
            first = browser.call("GET", f"{browser.session}/window")
            second = browser.call("POST", f"{browser.session}/window/new", {"type": "tab"})["handle"]
            browser.call("POST", f"{browser.session}/window", {"handle": second})
            browser.open(self.url)
            self.until("return state.poses.size === 2")
            assert self.shown("#actions")
            browser.call("POST", f"{browser.session}/window", {"handle": first})
            browser.call("DELETE", f"{browser.session}/window")
            browser.call("POST", f"{browser.session}/window", {"handle": second})
            # A button with the focus does what it says, not what Space says; every button is reached by Tab, and is seen.
            browser.run("document.querySelector('#undo').focus()")
            browser.key(" ")
            self.until("return state.poses.size === 1")
            reached = set()
            for _ in range(40):
                browser.key("Tab")
                reached.add(browser.run("const e = document.activeElement; return e.matches(':focus-visible')"
                                        " && getComputedStyle(e).outlineStyle !== 'none' ? e.id : ''"))
            # While it captures, "capture" is disabled.
            assert {"undo", "redo", "cancel", "mute"} <= reached, reached
            # Sound off, and still off when the page is loaded again.
            for pressed in ("true", "false"):
                browser.key("m")
                browser.open(self.url)
                self.until(f"return document.querySelector('#mute').getAttribute('aria-pressed') === '{pressed}' && state.status")
            self.quiet("loaded again")
            # The board is drawn with the heading of the next pose.
            self.until("return headingTo(lying(wanted(state).up), attitude) === null || Math.cos(headingTo(lying(wanted(state).up), attitude)) > 0.9998")
            # Cancelled, after a question: the page says where everything is, and how to go on.
            browser.key("c")
            assert "stay in s" in browser.run("return document.querySelector('#sure p').textContent")
            self.look("cancel")
            browser.key("Escape")
            browser.settle()
            assert not browser.run("return document.querySelector('#sure').open || state.end")
            browser.click("#cancel")
            browser.click("#sure [value=yes]")
            self.until("return state.end?.reason === 'cancelled' && document.querySelector('.command code')?.textContent.includes('--resume')")
            self.look("cancelled")
            assert self.child.wait(timeout=20) == 130
        print("loaded again in a capture, two tabs, cancelled")

    def at_a_port(self):
        """A board that is unplugged in a capture, and plugged in again."""
        browser = self.browser
        ups = [[(0.02, -0.03, 1.0)[(i + k) % 3] * sign for i in range(3)] for k in (0, 2, 1) for sign in (1, -1)]
        with tempfile.TemporaryDirectory() as folder:
            board = Board(folder)
            try:
                with self.session("--port", str(board.port), "--folder", "s"):
                    self.ready()
                    assert self.shown("#gravity") and not self.shown("#hands")
                    browser.run("document.querySelector('[name=latitude]').value = '48,1'")
                    browser.click("#gravity button")
                    self.until("return state.session.gravity_source === 'latitude'")
                    for count, up in enumerate(ups[1:], start=2):
                        board.turn(up)
                        if count == 3:
                            self.until("return state.status?.state === 'capture'", 30)
                            board.unplug()
                            self.until("return document.body.dataset.state === 'lost'", 30)
                            self.look("lost")
                            # A tab that is opened now shows it, too.
                            browser.open(self.url)
                            self.until("return document.body.dataset.state === 'lost' && state.status", 5)
                            assert self.browser.run("return state.poses.size") == 2
                            board.plug()
                            self.until("return document.body.dataset.state !== 'lost'", 30)
                        self.accepted(count)
                    board.turn([0.6, 0.6, 0.5])
                    self.accepted(7)
                    browser.key("Enter")
                    if browser.run("return document.querySelector('#sure').open"):
                        browser.key("Enter")
                    self.until("return state.end?.reason === 'finished'", 60)
                    # The bias of this board.
                    bias = browser.run("return state.fit.bias_mg")
                    for found, true in zip(bias, BIAS):
                        assert abs(found - 1000 * true / G) < 8, (bias, BIAS)
                    assert not self.shown(".truth")
                    self.look("port-end")
                    self.quiet("at a port")
            finally:
                board.close()
        print("a board at a port, unplugged in a capture")

    def port_chosen(self):
        """The port is absent, then something else, then there: tried again on the page."""
        browser = self.browser
        with tempfile.TemporaryDirectory() as folder:
            board = Board(folder)
            board.unplug()
            try:
                with self.session("--port", str(board.port), "--folder", "s") as where:
                    # The page is drawn some milliseconds after its state.
                    self.until("return state.ports?.tried && document.querySelector('#sentence').textContent.includes('no such port')")
                    # What is no port of this computer is refused, wherever it comes from.
                    port = "({ name, device: 'Arduino Uno', usb: '2341:0043', serial: null, board: true })"
                    self.take(f"{{ ...state.ports, tried: null, text: 'No row arrives from /dev/serial/by-id/usb-1a86_USB_Serial_75736303336351E0C1A1-if00-port0. Which port is it?', ports: ['/etc/hosts', '/etc/passwd'].map(name => {port}) }}")
                    self.look("ports")
                    browser.click("#ports button:nth-of-type(2)")
                    self.until("return document.querySelector('#notice').textContent.includes('is no port of this computer')")
                    assert not (where / "s").exists()
                    # It is tried as soon as it is there; this is no port.
                    board.port.write_text("")
                    self.until("return state.ports.tried && !state.ports.text.includes('no such port')", 30)
                    board.port.unlink()
                    board.plug()
                    browser.click("#again")
                    self.ready()
                    assert not self.shown("#ports") and self.shown("#live")
                    self.quiet("port chosen")
                    # The program is suspended, and wakes up.
                    self.child.send_signal(signal.SIGSTOP)
                    self.until("return document.querySelector('#sentence').textContent.includes('does not answer')", 3.5)
                    self.child.send_signal(signal.SIGCONT)
                    self.until("return !document.querySelector('#sentence').textContent.includes('does not answer')", 3.5)
                    # The program is gone.
                    self.child.kill()
                    self.until("return document.querySelector('#sentence').textContent.includes('does not answer')", 3)
            finally:
                board.close()
        print("a port chosen")

    def of_a_board(self):
        """What a board sends is text, whatever it is."""
        evil = "<img src=x onerror=alert(1)>"
        rows = "".join(f"{10 * i},{0.02 * (i * 7919 % 13 - 6):.3f},0.1,{9.8 + 0.01 * (i % 5):.3f},1\n" for i in range(600))
        with tempfile.TemporaryDirectory() as folder:
            path = pathlib.Path(folder) / f"{evil.replace('/', '')}.csv"
            path.write_text(f"t_ms,ax,ay,az,{evil}</script>\n{rows}")
            with self.session("--replay", str(path), "--speed", "2"):
                self.until("return document.querySelector('#device').textContent.includes('onerror')")
                self.until("return state.end", 60)
                assert self.browser.run("return document.images.length") == 0
                self.quiet("of a board")
        print("strings of a board")


def main():
    program = str(pathlib.Path(sys.argv[1]).resolve())
    pictures = pathlib.Path(sys.argv[2]) if len(sys.argv) > 2 else None
    if pictures:
        pictures.mkdir(parents=True, exist_ok=True)
    wanted = sys.argv[3:]
    with tempfile.TemporaryDirectory() as profile:
        browser = Browser(profile)
        try:
            browser.size(*SIZES[0])
            browser.media()
            live = Live(browser, program, pictures)
            for part in (live.by_keyboard, live.by_hand, live.loaded_again, live.at_a_port, live.port_chosen, live.of_a_board):
                if not wanted or part.__name__ in wanted:
                    part()
        finally:
            browser.stop()


if __name__ == "__main__":
    main()
