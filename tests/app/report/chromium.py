"""Chromium without a window, driven through a pipe of its DevTools protocol; and PNG pictures read and cut. Standard library only."""
import base64
import json
import os
import select
import shutil
import struct
import subprocess
import tempfile
import time
import zlib


def chromium():
    """Its path, or None."""
    return next((p for p in map(shutil.which, ("chromium", "chromium-browser", "google-chrome")) if p), None)


class Browser:
    """One page. `requests` are the addresses that it asked for, `errors` what its console and its scripts complained of."""

    def __init__(self, program, scripts=True):
        self.folder = tempfile.mkdtemp(prefix="limberg-chromium-")
        to_child, self.out = os.pipe()
        self.inward, from_child = os.pipe()

        def pipes():  # the browser reads from 3 and writes to 4
            a, b = os.dup(to_child), os.dup(from_child)
            os.dup2(a, 3)
            os.dup2(b, 4)

        self.child = subprocess.Popen(
            [program, "--headless=new", "--remote-debugging-pipe", "--no-sandbox", "--disable-gpu-sandbox",
             "--enable-unsafe-swiftshader", "--hide-scrollbars", "--no-first-run",
             "--disable-background-networking", "--disable-component-update", "--disable-extensions",
             "--user-data-dir=" + self.folder, "about:blank"],
            preexec_fn=pipes, close_fds=False, stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        os.close(to_child)
        os.close(from_child)
        self.number, self.buffer, self.events, self.session = 0, b"", [], None
        self.requests, self.errors = [], []
        target = next(t for t in self.call("Target.getTargets")["targetInfos"] if t["type"] == "page")
        self.session = self.call("Target.attachToTarget", targetId=target["targetId"], flatten=True)["sessionId"]
        for domain in ("Page", "Runtime", "Network", "Log"):
            self.call(domain + ".enable")
        if not scripts:
            self.call("Emulation.setScriptExecutionDisabled", value=True)

    def close(self):
        self.child.terminate()
        try:
            self.child.wait(10)
        except subprocess.TimeoutExpired:
            self.child.kill()
            self.child.wait()
        shutil.rmtree(self.folder, ignore_errors=True)

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.close()

    def _message(self, limit_s):
        until = time.monotonic() + limit_s
        while b"\0" not in self.buffer:
            if not select.select([self.inward], [], [], max(0, until - time.monotonic()))[0]:
                return None
            more = os.read(self.inward, 1 << 20)
            if not more:
                raise RuntimeError("the browser has ended")
            self.buffer += more
        text, self.buffer = self.buffer.split(b"\0", 1)
        return json.loads(text)

    def _note(self, m):
        method, p = m.get("method"), m.get("params", {})
        if method == "Network.requestWillBeSent":
            self.requests.append(p["request"]["url"])
        elif method == "Runtime.exceptionThrown":
            self.errors.append(json.dumps(p["exceptionDetails"])[:500])
        elif method == "Runtime.consoleAPICalled" and p["type"] in ("error", "warning", "assert"):
            self.errors.append(str([a.get("value", a.get("description")) for a in p["args"]])[:500])
        elif method == "Log.entryAdded" and p["entry"]["level"] in ("error", "warning"):
            # Without a graphics card the browser fetches each picture of a canvas, and complains of that itself.
            if "GPU stall due to ReadPixels" not in p["entry"]["text"]:
                self.errors.append(p["entry"]["text"])
        self.events.append(method)

    def call(self, method, limit_s=120, **params):
        self.number += 1
        m = {"id": self.number, "method": method, "params": params}
        if self.session:
            m["sessionId"] = self.session
        os.write(self.out, json.dumps(m).encode() + b"\0")
        until = time.monotonic() + limit_s
        while True:
            answer = self._message(until - time.monotonic())
            if answer is None:
                raise RuntimeError(method + ": no answer")
            if answer.get("id") == self.number:
                if "error" in answer:
                    raise RuntimeError(f"{method}: {answer['error']}")
                return answer["result"]
            self._note(answer)

    def size(self, width, height, phone=False):
        self.call("Emulation.setDeviceMetricsOverride", width=width, height=height, deviceScaleFactor=1, mobile=phone)
        self.call("Emulation.setTouchEmulationEnabled", enabled=phone)

    def open(self, file, limit_s=60):
        self.events.clear()
        self.call("Page.navigate", url="file://" + os.path.abspath(file))
        until = time.monotonic() + limit_s
        while "Page.loadEventFired" not in self.events:
            m = self._message(until - time.monotonic())
            if m is None:
                raise RuntimeError("the page does not load")
            self._note(m)

    def run(self, script, limit_s=120):
        """The value of a script, awaited."""
        r = self.call("Runtime.evaluate", limit_s, expression=script, awaitPromise=True, returnByValue=True)
        if "exceptionDetails" in r:
            raise RuntimeError(json.dumps(r["exceptionDetails"])[:800])
        return r["result"].get("value")

    def wait(self, condition, limit_s=60):
        until = time.monotonic() + limit_s
        while not self.run(condition):
            if time.monotonic() > until:
                raise RuntimeError("never true: " + condition)
            time.sleep(0.05)

    def mouse(self, kind, x, y, **more):
        self.call("Input.dispatchMouseEvent", type=kind, x=x, y=y, **more)

    def drag(self, x0, y0, x1, y1, button="left", steps=8):
        self.mouse("mousePressed", x0, y0, button=button, buttons=1, clickCount=1)
        for i in range(1, steps + 1):
            self.mouse("mouseMoved", x0 + (x1 - x0) * i / steps, y0 + (y1 - y0) * i / steps, button=button, buttons=1)
        self.mouse("mouseReleased", x1, y1, button=button, clickCount=1)

    def key(self, key, code=None, **more):
        for kind in ("keyDown", "keyUp"):
            self.call("Input.dispatchKeyEvent", type=kind, key=key, code=code or key, **more)

    def picture(self, file=None, selector=None, whole=False):
        """A Picture of the window, of an element that is scrolled into it, or of the whole page."""
        options = {"format": "png"}
        if selector:
            self.run(f"document.querySelector({json.dumps(selector)}).scrollIntoView({{block: 'center'}})")
            r = self.run(f"(() => {{ const r = document.querySelector({json.dumps(selector)}).getBoundingClientRect();"
                         " return [r.x + scrollX, r.y + scrollY, r.width, r.height] })()")
            options["clip"] = {"x": r[0], "y": r[1], "width": r[2], "height": r[3], "scale": 1}
        options["captureBeyondViewport"] = whole
        png = base64.b64decode(self.call("Page.captureScreenshot", **options)["data"])
        if file:
            with open(file, "wb") as f:
                f.write(png)
        return Picture(png)


class Picture:
    """8-bit RGB or RGBA without interlacing. pixel(x, y) gives (r, g, b)."""

    def __init__(self, png):
        at, data, self.width, self.height, channels = 8, b"", 0, 0, 0
        while at < len(png):
            length, kind = struct.unpack(">I4s", png[at:at + 8])
            body = png[at + 8:at + 8 + length]
            if kind == b"IHDR":
                self.width, self.height, depth, colour, _, _, interlaced = struct.unpack(">IIBBBBB", body)
                assert depth == 8 and colour in (2, 6) and not interlaced, "a PNG of another kind"
                channels = 4 if colour == 6 else 3
            elif kind == b"IDAT":
                data += body
            at += 12 + length
        raw, row = zlib.decompress(data), self.width * channels
        before = bytearray(row)
        self.rows, self.channels = [], channels
        for y in range(self.height):
            kind, line = raw[y * (row + 1)], bytearray(raw[y * (row + 1) + 1:(y + 1) * (row + 1)])
            if kind == 1:
                for i in range(channels, row):
                    line[i] = (line[i] + line[i - channels]) & 255
            elif kind == 2:
                for i in range(row):
                    line[i] = (line[i] + before[i]) & 255
            elif kind == 3:
                for i in range(row):
                    line[i] = (line[i] + ((line[i - channels] if i >= channels else 0) + before[i]) // 2) & 255
            elif kind == 4:
                for i in range(row):
                    a, b = (line[i - channels] if i >= channels else 0), before[i]
                    c = before[i - channels] if i >= channels else 0
                    p, q, r = abs(b - c), abs(a - c), abs(a + b - 2 * c)
                    line[i] = (line[i] + (a if p <= q and p <= r else b if q <= r else c)) & 255
            self.rows.append(line)
            before = line

    def pixel(self, x, y):
        at = x * self.channels
        return tuple(self.rows[y][at:at + 3])

    def mean(self, x, y, r):
        """Over a square about a place."""
        all_of = [self.pixel(i, j) for j in range(max(0, y - r), min(self.height, y + r + 1))
                  for i in range(max(0, x - r), min(self.width, x + r + 1))]
        return tuple(sum(c) / len(all_of) for c in zip(*all_of))


def file_picture(file):
    with open(file, "rb") as f:
        return Picture(f.read())


def difference(a, b):
    return max(abs(p - q) for p, q in zip(a, b))
