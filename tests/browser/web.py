#!/usr/bin/env python3
"""The page in the browser, from one file, without a server.

    tests/browser/web.py GRAVICAL.html [PICTURES]
"""

import pathlib
import sys
import tempfile
import time

from browser import CONTRAST, Browser

ROOT = pathlib.Path(__file__).resolve().parents[2]
SIX = sorted((ROOT / "examples/simulated-six-position").glob("*.csv"))
OVERFLOW = "const w = document.documentElement.clientWidth; return document.documentElement.scrollWidth > w ? [document.documentElement.scrollWidth - w] : []"


class Page:
    def __init__(self, browser, page, pictures):
        self.browser, self.page, self.pictures = browser, page, pictures

    def open(self):
        self.browser.complaints(), self.browser.requests()
        self.browser.open(f"file://{self.page}")
        self.until("return TARGETS.length > 5")

    def until(self, script, seconds=60):
        end = time.monotonic() + seconds
        while not self.browser.run(script):
            assert time.monotonic() < end, (script, self.browser.run("return document.body.innerText.slice(0, 2000)"))
            time.sleep(0.05)

    def choose(self, *paths):
        """Files as a person chooses them."""
        document = self.browser.cdp("DOM.getDocument")["root"]["nodeId"]
        node = self.browser.cdp("DOM.querySelector", nodeId=document, selector="#chosen")["nodeId"]
        self.browser.cdp("DOM.setFileInputFiles", nodeId=node, files=[str(p) for p in paths])

    def ready(self, verb):
        self.until(f"return result?.verb === '{verb}' && !result.is_busy")

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
        assert all(url.startswith("file://") and self.page.name in url for url in urls), urls

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
        self.browser.run("document.querySelector('[name=latitude]').value = '48,1'")
        self.press("#options > button")
        self.until("return result?.done?.result.gravity_source === 'latitude'")
        # A value that is none is said.
        self.browser.run("document.querySelector('[name=latitude]').value = 'here'")
        self.press("#options > button")
        self.until("return document.querySelector('#computed').textContent.includes('is no number')")
        self.quiet()
        print(f"six files, {took:.1f} s")

    def example(self):
        self.open()
        self.press("[data-example]")
        self.until("return dropped.length === 3 && dropped.every(e => e.kind) && !result.is_busy")
        assert self.browser.run("return dropped.find(e => e.is_made).verdict.grade") == "good"
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
            self.until("return dropped.length === 3 && dropped.every(e => e.kind || e.error) && !result?.is_busy")
            assert not self.browser.run("return window.bad ?? document.querySelector('iframe')?.contentWindow.bad")
            assert self.browser.run("return dropped.filter(e => e.error).length") >= 2
            self.look("hostile")
            self.open()
            self.choose(large)
            self.until("return Boolean(result?.is_busy) || dropped[0]?.error", 60)
            self.until("return Boolean(document.querySelector('[data-cancel]'))")
            self.press("[data-cancel]")
            self.until("return result.error?.code === 'cancelled'", 5)
            # And on: the next question finds a new thread.
            self.choose(SIX[0])
            self.until("return dropped.length === 2 && dropped[1].kind === 'recording'")
        print("markup, binary files, 60 MB and Cancel")


def main():
    page = pathlib.Path(sys.argv[1]).resolve()
    pictures = pathlib.Path(sys.argv[2]) if len(sys.argv) > 2 else None
    if pictures:
        pictures.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory() as profile:
        browser = Browser(profile)
        try:
            browser.size(1280, 900)
            tested = Page(browser, page, pictures)
            tested.six_files()
            tested.example()
            tested.hostile()
        finally:
            browser.stop()


if __name__ == "__main__":
    main()
