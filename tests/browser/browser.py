"""Chromium behind chromedriver, by the protocol of WebDriver over plain HTTP."""

import base64
import json
import re
import subprocess
import time
import urllib.request

# Text that is too faint on what is behind it; large text may be fainter.
CONTRAST = """
const parse = c => c.match(/[\\d.]+/g).map(Number);
const light = ([r, g, b]) => [r, g, b].map(v => v / 255).map(v => v <= .03928 ? v / 12.92 : ((v + .055) / 1.055) ** 2.4)
  .reduce((s, v, i) => s + v * [.2126, .7152, .0722][i], 0);
const out = [];
for (const e of document.querySelectorAll("body *")) {
  const text = [...e.childNodes].some(n => n.nodeType === 3 && n.textContent.trim());
  if (!text || !e.checkVisibility({ visibilityProperty: true }) || e.closest(".unseen, .drawing, #actions :disabled, #hands :disabled, noscript")) continue;
  let behind = [255, 255, 255];
  for (let p = e; p; p = p.parentElement) {
    const c = parse(getComputedStyle(p).backgroundColor);
    if (c.length === 3 || c[3] > .99) { behind = c; break; }
  }
  const style = getComputedStyle(e), front = e.namespaceURI.endsWith("svg") ? style.fill : style.color;
  const [a, b] = [light(parse(front)), light(behind)].sort((x, y) => y - x);
  const ratio = (a + .05) / (b + .05);
  if (ratio < 4.5) out.push([e.textContent.trim().slice(0, 40), ratio.toFixed(2)]);
}
return out;
"""

# Aims at an element: where its middle is, or null. Until it is hit, the mouse reaches nothing else. A page that
# was left by the click has no aim any more.
AIM = """
const e = document.querySelector(%s);
if (!e || e.disabled || !e.checkVisibility()) return null;
e.scrollIntoView({ block: "center" });
if (!window.aim) {
  window.aim = {};
  for (const kind of ["pointerdown", "mousedown", "pointerup", "mouseup", "click"]) addEventListener(kind, event => {
    if (!aim.at || !event.isTrusted || event.detail === 0 && kind === "click") return;
    const hits = aim.at.contains(event.target);
    if (!hits) {
      event.stopImmediatePropagation();
      event.preventDefault();
    }
    if (kind !== "click") return;
    aim.hit = hits;
    aim.at = null;
  }, true);
}
Object.assign(window.aim, { at: e, hit: false });
const b = e.getBoundingClientRect();
return [b.left + b.width / 2, b.top + b.height / 2];
"""


class Browser:
    def __init__(self, profile):
        self.service = subprocess.Popen(["chromedriver", "--port=0"], stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True)
        port = next(m[1] for line in self.service.stdout if (m := re.search(r"successfully on port (\d+)", line)))
        self.root = f"http://127.0.0.1:{port}"
        options = {
            "args": ["--headless=new", "--no-sandbox", "--disable-gpu", "--hide-scrollbars", "--disable-dev-shm-usage",
                     "--no-first-run", "--autoplay-policy=no-user-gesture-required", f"--user-data-dir={profile}"],
            "perfLoggingPrefs": {"enableNetwork": True},
        }
        wanted = {"browserName": "chrome", "goog:chromeOptions": options,
                  "goog:loggingPrefs": {"browser": "ALL", "performance": "ALL"}}
        self.session = f"/session/{self.call('POST', '/session', {'capabilities': {'alwaysMatch': wanted}})['sessionId']}"

    def call(self, method, path, body=None):
        data = None if body is None else json.dumps(body).encode()
        request = urllib.request.Request(self.root + path, data, {"Content-Type": "application/json"}, method=method)
        try:
            with urllib.request.urlopen(request, timeout=60) as answer:
                return json.load(answer)["value"]
        except urllib.error.HTTPError as error:
            raise RuntimeError(error.read().decode()[:600]) from error

    def stop(self):
        try:
            self.call("DELETE", self.session)
        finally:
            self.service.terminate()
            self.service.wait()

    def open(self, url):
        self.call("POST", f"{self.session}/url", {"url": url})

    def run(self, script):
        return self.call("POST", f"{self.session}/execute/sync", {"script": script, "args": []})

    def settle(self, frames=4):
        self.call("POST", f"{self.session}/execute/async", {"args": [], "script":
                  f"let n = {frames}; const done = arguments[0], f = () => --n ? requestAnimationFrame(f) : done(1); requestAnimationFrame(f);"})

    def cdp(self, command, **parameters):
        return self.call("POST", f"{self.session}/goog/cdp/execute", {"cmd": command, "params": parameters})

    def size(self, width, height):
        self.cdp("Emulation.setDeviceMetricsOverride", width=width, height=height, deviceScaleFactor=1, mobile=False)

    def media(self, scheme="light", motion="no-preference"):
        self.cdp("Emulation.setEmulatedMedia", features=[
            {"name": "prefers-color-scheme", "value": scheme}, {"name": "prefers-reduced-motion", "value": motion}])

    def key(self, key):
        text = {"Enter": "\r"}.get(key, key if len(key) == 1 else "")
        code = {" ": 32, "Enter": 13, "Escape": 27, "Tab": 9}.get(key, 0)
        down = {"type": "keyDown", "key": key, "windowsVirtualKeyCode": code}
        self.cdp("Input.dispatchKeyEvent", **({**down, "text": text} if text else down))
        self.cdp("Input.dispatchKeyEvent", type="keyUp", key=key, windowsVirtualKeyCode=code)

    def drag(self, start, end, steps=6):
        mouse = lambda kind, x, y: self.cdp("Input.dispatchMouseEvent", type=kind, x=x, y=y, button="left", buttons=1, clickCount=1)
        mouse("mousePressed", *start)
        for i in range(1, steps + 1):
            mouse("mouseMoved", *(a + (b - a) * i / steps for a, b in zip(start, end)))
        mouse("mouseReleased", *end)

    def click(self, selector, seconds=15):
        """A click of the mouse in the middle of an element, once it is there and enabled.

        The page is alive: a line more above the element moves it away from under the mouse. A click that would reach
        something else reaches nothing, and is tried again."""
        end = time.monotonic() + seconds
        while time.monotonic() < end:
            if place := self.run(AIM % json.dumps(selector)):
                self.drag(place, place, 1)
                if self.run("return window.aim?.hit ?? true"):
                    return
            time.sleep(0.05)
        raise AssertionError(f"it could not be clicked: {selector}\n{self.run('return document.body.innerText')}")

    def picture(self, path, whole=False, **options):
        options |= {"format": options.get("format", "png"), "captureBeyondViewport": whole}
        if whole:
            width, height = self.run("return [innerWidth, document.documentElement.scrollHeight]")
            options["clip"] = {"x": 0, "y": 0, "width": width, "height": height, "scale": 1}
        path.write_bytes(base64.b64decode(self.cdp("Page.captureScreenshot", **options)["data"]))

    def complaints(self):
        return [e for e in self.call("POST", f"{self.session}/se/log", {"type": "browser"}) if e["level"] != "INFO"]

    def requests(self):
        out = []
        for entry in self.call("POST", f"{self.session}/se/log", {"type": "performance"}):
            event = json.loads(entry["message"])["message"]
            if event["method"] == "Network.requestWillBeSent":
                out.append(event["params"]["request"]["url"])
        return out
