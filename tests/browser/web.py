#!/usr/bin/env python3
"""The page in the browser: from one file without a server, and served, where sessions are kept.

    tests/browser/web.py GRAVICAL.html [PICTURES]
"""

import base64
import functools
import http.server
import io
import pathlib
import sys
import tempfile
import threading
import time
import zipfile

from browser import CONTRAST, Browser

ROOT = pathlib.Path(__file__).resolve().parents[2]
SIX = sorted((ROOT / "examples/simulated-six-position").glob("*.csv"))
OVERFLOW = "const w = document.documentElement.clientWidth; return document.documentElement.scrollWidth > w ? [document.documentElement.scrollWidth - w] : []"
# A board at a serial port, as the browser would give it: rows, silence, noise, or held by another program. Its worker can
# be made to trap.
FAKE = """
const G = 9.80665, BIAS = [0.12, -0.08, 0.2];
window.fake = { mode: "rows", up: [0.02, 0.03, 1], n: 0, controller: null, opened: 0 };
fake.port = {
  readable: null,
  getInfo: () => ({ usbVendorId: 0x2341, usbProductId: 0x0043 }),
  async open() {
    if (fake.mode === "held") throw new DOMException("Failed to open serial port.", "NetworkError");
    fake.opened++;
    this.readable = new ReadableStream({ start(controller) { fake.controller = controller; } });
  },
  async close() { this.readable = fake.controller = null; },
};
// The bootloader of an Uno (STK500 version 1); in the mode "mega" the chip is another one.
fake.flash = new Uint8Array(32768).fill(255);
fake.port.setSignals = async () => {};
Object.defineProperty(fake.port, "writable", { get: () => new WritableStream({ write(bytes) {
  if (!["boot", "mega"].includes(fake.mode)) return;
  const at = 2 * (fake.word ?? 0), size = bytes[1] * 256 + bytes[2];
  if (bytes[0] === 0x55) fake.word = bytes[1] + 256 * bytes[2];
  if (bytes[0] === 0x64) fake.flash.set(bytes.slice(4, 4 + size), at);
  const answer = { 0x75: [0x1e, fake.mode === "mega" ? 0x98 : 0x95, 0x0f], 0x74: fake.flash.slice(at, at + size) }[bytes[0]] ?? [];
  fake.controller.enqueue(Uint8Array.from([0x14, ...answer, 0x10]));
  if (bytes[0] === 0x51) fake.mode = "rows";
} }) });
fake.unplug = () => {
  fake.controller.error(new DOMException("The device has been lost.", "NetworkError"));
  fake.controller = fake.port.readable = null;
};
fake.plug = () => navigator.serial.dispatchEvent(Object.assign(new Event("connect"), { port: fake.port }));
const serial = new EventTarget();
serial.requestPort = async () => fake.port;
Object.defineProperty(navigator, "serial", { value: serial });
Object.defineProperty(fake.port, "dispatchEvent", { value() {} });
const noise = () => { let sum = 0; for (let i = 0; i < 12; i++) sum += Math.random(); return sum - 6; };
setInterval(() => {
  for (let i = 0; i < 5; i++) {
    fake.n++;
    if (!fake.controller || ["silent", "boot", "mega"].includes(fake.mode)) continue;
    const length = Math.hypot(...fake.up), a = fake.up.map((v, k) => G * v / length + BIAS[k] + 0.03 * noise());
    const text = `${10 * fake.n},${[...a, ...[0, 0, 0].map(() => 0.01 + 0.001 * noise())].map(v => v.toFixed(4))}\\n`;
    const bytes = fake.mode === "noise" ? Uint8Array.from({ length: 40 }, () => 128 + 127 * Math.random()) : new TextEncoder().encode(text);
    fake.controller.enqueue(bytes);
  }
}, 50);
const Blob0 = Blob;
window.Blob = class extends Blob0 {
  constructor(parts, options) {
    const trap = `addEventListener("message", e => {
      if (!e.data.trap) return;
      wasm = { ...wasm, alloc: () => 0x7fffffff };
      e.stopImmediatePropagation();
    });\\n`;
    super(options?.type === "text/javascript" ? [trap, ...parts] : parts, options);
  }
};
"""


class Silent(http.server.SimpleHTTPRequestHandler):
    def log_message(self, *_):
        pass


class Page:
    def __init__(self, browser, page, pictures, served):
        self.browser, self.page, self.pictures, self.served = browser, page, pictures, served

    def open(self, url=None):
        self.browser.complaints(), self.browser.requests()
        self.browser.open(url or f"file://{self.page}")
        self.until("return TARGETS.length > 5")

    def until(self, script, seconds=60):
        end = time.monotonic() + seconds
        while not self.browser.run(script):
            assert time.monotonic() < end, (script, self.browser.run("return document.body.innerText.slice(0, 2000)"))
            time.sleep(0.05)

    def choose(self, *paths, at="#chosen"):
        """Files as a person chooses them."""
        document = self.browser.cdp("DOM.getDocument")["root"]["nodeId"]
        node = self.browser.cdp("DOM.querySelector", nodeId=document, selector=at)["nodeId"]
        self.browser.cdp("DOM.setFileInputFiles", nodeId=node, files=[str(p) for p in paths])

    def ready(self, verb):
        self.until(f"return result?.verb === '{verb}' && !result.isBusy")

    def press(self, selector):
        self.browser.click(selector)

    def look(self, name):
        browser = self.browser
        for width in (1280, 400):
            browser.size(width, 900)
            for scheme in ("dark", "light"):
                browser.media(scheme, "reduce")
                browser.settle()
                assert not (faint := browser.run(CONTRAST)), (name, width, scheme, faint)
            assert not (wide := browser.run(OVERFLOW)), (name, width, wide)
            if self.pictures:
                browser.picture(self.pictures / f"web-{name}-{width}.png", whole=width == 400)
        browser.size(1280, 900)
        browser.media()

    def quiet(self):
        """Nothing was complained of, and nothing but the page was asked for: nothing can be uploaded."""
        assert not (loud := self.browser.complaints()), loud
        urls = [url for url in self.browser.requests() if not url.startswith(("data:", "blob:", "chrome", "about:"))]
        assert all(url.startswith((f"file://{self.page}", self.served)) for url in urls), urls

    def six_files(self):
        self.open()
        self.look("door")
        began = time.monotonic()
        self.choose(*SIX)
        self.ready("calibrate")
        took = time.monotonic() - began
        self.until("return Boolean(document.querySelector('iframe')?.contentDocument?.querySelector('#verdict'))")
        assert "not verifiable" in self.browser.run("return document.querySelector('iframe').contentDocument.body.innerText")
        self.until("const f = document.querySelector('iframe'); return f.clientHeight >= f.contentDocument.body.scrollHeight")
        self.look("six")
        # A place, and everything is computed again.
        self.browser.run("document.querySelector('#options [name=latitude]').value = '48,1'")
        self.press("#options > button")
        self.until("return result?.done?.result.gravity_source === 'latitude'")
        # A value that is none is said.
        self.browser.run("document.querySelector('#options [name=latitude]').value = 'here'")
        self.press("#options > button")
        self.until("return document.querySelector('#computed').textContent.includes('is no number')")
        # As a folder they are the same session.
        self.open()
        self.choose(SIX[0].parent, at="#folder")
        self.ready("calibrate")
        assert self.browser.run("return isFolder && poses().length") == 6
        self.quiet()
        print(f"six files, {took:.1f} s; their folder")

    def example(self):
        self.open()
        self.press("[data-example]")
        self.until("return dropped.length === 3 && dropped.every(e => e.kind) && !result.isBusy")
        assert self.browser.run("return dropped.find(e => e.isMade).verdict.grade") == "good"
        self.browser.run("chosen = dropped.find(e => e.name.startsWith('move'))")
        for verb in ("motion", "orient", "check", "denoise", "apply", "convert"):
            self.press(f"[data-verb={verb}]")
            self.ready(verb)
            assert not self.browser.run("return result.error?.message"), verb
            if verb == "motion":
                self.browser.settle(5)
                self.look(verb)
        self.press("[data-verb=noise]")
        self.ready("noise")
        assert self.browser.run("return result.error.code") == "not-at-rest"
        self.look("error")
        self.press("[data-inspect='0']")
        self.until("return result.verb === 'inspect' && Boolean(document.querySelector('iframe')?.contentDocument?.querySelector('#verdict'))")
        self.quiet()
        print("the example, every verb")

    def hostile(self):
        """Names and contents with markup are text; what is no recording says so; a long computation can be cancelled."""
        with tempfile.TemporaryDirectory() as folder:
            name = pathlib.Path(folder) / "<img src=x onerror=window.bad=1>.csv"
            name.write_bytes(b"<script>window.bad=1</script>\n" + SIX[0].read_bytes())
            binary = pathlib.Path(folder) / "binary.bin"
            binary.write_bytes(bytes(range(256)) * 4000)
            strange = pathlib.Path(folder) / "strange.json"
            strange.write_text('{"format": "gravical-calibration/3", "accelerometer": "<script>window.bad=1</script>"}')
            large = pathlib.Path(folder) / "large.csv"
            large.write_bytes(b"t_ms,ax,ay,az\n" + b"".join(b"%d,0.%03d,0.1,9.81\n" % (10 * i, i % 1000) for i in range(3_000_000)))
            self.open()
            self.choose(name, binary, strange)
            self.until("return dropped.length === 3 && dropped.every(e => e.kind || e.error) && !result?.isBusy")
            assert not self.browser.run("return window.bad ?? document.querySelector('iframe')?.contentWindow.bad")
            assert self.browser.run("return dropped.filter(e => e.error).length") >= 2
            self.look("hostile")
            self.open()
            self.choose(large)
            self.until("return Boolean(result?.isBusy) || dropped[0]?.error", 60)
            self.until("return Boolean(document.querySelector('[data-cancel]'))")
            self.press("[data-cancel]")
            self.until("return result.error?.code === 'cancelled'", 5)
            # And on: the next question finds a new thread.
            self.choose(SIX[0])
            self.until("return dropped.length === 2 && dropped[1].kind === 'recording'")
        print("markup, binary files, 60 MB and Cancel")


    def poses(self, count, seconds=60):
        # What is wanted next is known after the fit.
        self.until(f"return state.poses.size === {count} && (state.fit?.poses ?? {count}) === {count}"
                   " && [...state.poses.values()].every(p => p.t_s <= state.next_pose?.t_s)", seconds)

    def simulated(self):
        """A guided session to `good`; loaded again within it; a trap; everything saved."""
        browser, url = self.browser, f"{self.served}/?seed=4&speed=8"
        self.open(url)
        self.press("[data-simulate]")
        self.until("return state.poses.size === 1 && state.status?.state === 'wait'")
        self.look("session")
        for count, face in enumerate(["+x", "-x", "+y", "-y", "-z"], start=2):
            self.until("return state.status?.state === 'wait' && ![...document.querySelectorAll('[data-face]')].some(b => b.disabled)")
            browser.key(browser.run(f"return String(FACES.indexOf('{face}') + 1)"))
            self.poses(count)
            if count == 3:
                # Another tab cannot take it; loaded again it is kept, with its poses.
                here = browser.call("GET", f"{browser.session}/window")
                there = browser.call("POST", f"{browser.session}/window/new", {"type": "tab"})["handle"]
                browser.call("POST", f"{browser.session}/window", {"handle": there})
                browser.open(self.served)
                self.press("[data-resume]")
                self.until("return document.querySelector('#trouble').textContent.includes('open in another tab')")
                browser.call("DELETE", f"{browser.session}/window")
                browser.call("POST", f"{browser.session}/window", {"handle": here})
                self.open(url)
                self.press("[data-resume]")
                self.poses(3)
            if count == 4:
                # What cannot go on says so, and goes on.
                browser.run("engine.worker.postMessage({ trap: true })")
                self.until("return state.end?.reason === 'failed'")
                self.look("trap")
                self.press("#result .primary")
                self.poses(4)
        for count in range(7, 17):
            if browser.run("return state.verdict?.grade === 'good'"):
                break
            browser.key("n")
            self.poses(count)
        assert browser.run("return state.verdict.grade") == "good"
        browser.key("Enter")
        self.until("return state.end?.reason === 'finished' && document.querySelector('.truth')")
        before, after = browser.run("return [state.truth.before_mg, state.truth.norm_error_mg]")
        assert after < 5 < before, (before, after)
        self.until("return document.querySelector('#result iframe')?.contentDocument?.querySelectorAll('svg').length > 3")
        self.look("end")
        # The folder of the session, as one file.
        browser.run("window.packed_ = null; filesOfSession(guided.folder).then(files => zip(files).arrayBuffer())"
                    ".then(b => { packed_ = btoa(Array.from(new Uint8Array(b), c => String.fromCharCode(c)).join('')); })")
        self.until("return packed_")
        archive = zipfile.ZipFile(io.BytesIO(base64.b64decode(browser.run("return packed_"))))
        assert archive.testzip() is None
        assert set(archive.namelist()) == {"calibration.json", "calibration.html", "gravical_calibration.h", "recording.csv", "session.ndjson"}
        assert archive.read("session.ndjson").count(b'"pose_accepted"') == browser.run("return state.poses.size")
        # On to a move with this calibration.
        self.press("[data-further]")
        self.until("return dropped.length === 1 && dropped[0].kind === 'calibration'")
        self.quiet()
        self.open(url)
        self.press("[data-forget]")
        self.press("[data-forget]")
        self.until("return !document.querySelector('[data-forget]')")
        print("a simulated session to good, loaded again, a trap, everything saved")

    def from_a_file(self):
        """Without a server a session is in memory: the page asks before it is lost."""
        browser = self.browser
        self.open(f"file://{self.page}?seed=4&speed=8")
        self.press("[data-simulate]")
        self.poses(1)
        assert browser.run("return guided.isMemory && isUnsaved()")
        browser.key("c")
        browser.key("Enter")
        self.until("return state.end?.reason === 'cancelled' && guided.files['recording.csv']?.length > 1000")
        assert browser.run("return isUnsaved()")
        self.press("#result [data-keep=zip]")
        self.until("return !isUnsaved()")
        self.quiet()
        print("a session from a file, in memory")

    def at_a_port(self):
        """A board that is held, sends noise, nothing, and rows; its cable is pulled in a pose."""
        browser = self.browser
        self.open(self.served)
        browser.run("fake.mode = 'held'")
        self.press("[data-plug]")
        self.until("return document.querySelector('#trouble').textContent.includes('Another program')")
        browser.run("fake.mode = 'noise'")
        self.press("[data-plug]")
        self.until("return state.ports?.text.includes('baud rate')", 30)
        self.look("noise")
        browser.run("fake.mode = 'silent'")
        self.press("#again")
        self.until("return state.ports?.text.includes('nothing arrives')", 30)
        browser.run("fake.mode = 'rows'")
        self.press("#again")
        self.poses(1)
        browser.run("document.querySelector('#gravity [name=latitude]').value = '48,1'")
        self.press("#gravity button")
        self.until("return state.session.gravity_source === 'latitude'")
        browser.run("fake.up = [1, 0.02, -0.03]")
        self.until("return state.status?.state === 'capture'")
        browser.run("fake.unplug()")
        self.until("return document.body.dataset.state === 'lost'")
        assert browser.run("return state.poses.size") == 1
        browser.run("fake.plug()")
        self.poses(2)
        # It ends, and everything stays.
        browser.key("c")
        browser.key("Enter")
        self.until("return state.end?.reason === 'cancelled'")
        self.look("cancelled")
        self.quiet()
        print("a board: held, noise, silent, unplugged")

    def flashed(self):
        """The sketch is flashed from the page, and the session begins; another chip is left alone."""
        browser = self.browser
        self.open(self.served)
        if not browser.run("return document.querySelector('#firmware')"):
            print("no sketch in the page: flashing is not tried")
            return
        browser.run("fake.mode = 'mega'")
        self.press("#door [data-flash]")
        self.press("#flashing [data-flash=now]")
        self.until("return document.querySelector('#flashing .mark').textContent.includes('1e 98 0f')")
        self.look("flash")
        assert browser.run("return fake.flash.every(byte => byte === 255)")
        browser.run("fake.mode = 'boot'")
        self.press("#flashing [data-flash=now]")
        self.poses(1)
        assert browser.run("return parseHex(document.querySelector('#firmware').textContent).every((byte, i) => fake.flash[i] === byte)")
        browser.key("c")
        browser.key("Enter")
        self.until("return state.end?.reason === 'cancelled'")
        self.quiet()
        print("the sketch is flashed")


def main():
    page = pathlib.Path(sys.argv[1]).resolve()
    pictures = pathlib.Path(sys.argv[2]) if len(sys.argv) > 2 else None
    if pictures:
        pictures.mkdir(parents=True, exist_ok=True)
    handler = functools.partial(Silent, directory=page.parent)
    server = http.server.ThreadingHTTPServer(("127.0.0.1", 0), handler)
    threading.Thread(target=server.serve_forever, daemon=True).start()
    wanted = sys.argv[3:]
    with tempfile.TemporaryDirectory() as profile:
        browser = Browser(profile)
        try:
            browser.size(1280, 900)
            browser.cdp("Page.addScriptToEvaluateOnNewDocument", source=FAKE)
            tested = Page(browser, page, pictures, f"http://127.0.0.1:{server.server_port}")
            for part in (tested.six_files, tested.example, tested.hostile, tested.simulated, tested.from_a_file, tested.at_a_port, tested.flashed):
                if not wanted or part.__name__ in wanted:
                    part()
        finally:
            browser.stop()
            server.shutdown()


if __name__ == "__main__":
    main()
