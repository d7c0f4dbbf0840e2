"""A page in headless Chromium, by its DevTools over a pipe: screenshots, console messages, and what a script says of it.

Chromium is what CHROMIUM names, or chromium, chromium-browser or google-chrome on the path.
"""
import base64
import json
import os
import select
import shutil
import subprocess
import tempfile

PROGRAM = next((found for found in map(shutil.which, (os.environ.get("CHROMIUM", ""), "chromium", "chromium-browser", "google-chrome")) if found), None)
LIMIT = 60  # [s] for an answer


class Browser:
    """Use as a context. `messages`: what pages said on the console, or failed in, or asked for beyond their own file."""

    def __enter__(self):
        self.folder = tempfile.TemporaryDirectory(prefix="moraine-chromium-", ignore_cleanup_errors=True)
        theirs, self.out = os.pipe()
        self.answers, theirs_too = os.pipe()

        def place():  # DevTools read from 3 and write to 4
            for fd, wanted in ((os.dup(theirs), 3), (os.dup(theirs_too), 4)):
                os.dup2(fd, wanted)
        self.started = subprocess.Popen(
            [PROGRAM, "--headless=new", "--no-sandbox", "--disable-gpu", "--disable-dev-shm-usage", "--hide-scrollbars",
             "--remote-debugging-pipe", f"--user-data-dir={self.folder.name}", "about:blank"],
            preexec_fn=place, close_fds=False, stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        os.close(theirs), os.close(theirs_too)
        self.number, self.rest, self.messages, self.loaded, self.session = 0, b"", [], False, None
        page = next(target for target in self.ask("Target.getTargets")["targetInfos"] if target["type"] == "page")
        self.session = self.ask("Target.attachToTarget", targetId=page["targetId"], flatten=True)["sessionId"]
        for domain in ("Page", "Runtime", "Log", "Network"):
            self.ask(domain + ".enable")
        return self

    def __exit__(self, *_):
        self.started.kill()
        self.started.wait()
        os.close(self.out), os.close(self.answers)
        self.folder.cleanup()

    def _take(self):
        """The next message of Chromium."""
        while b"\0" not in self.rest:
            if not select.select([self.answers], [], [], LIMIT)[0]:
                raise AssertionError(f"Chromium said nothing for {LIMIT} s")
            piece = os.read(self.answers, 1 << 20)
            if not piece:
                raise AssertionError("Chromium ended")
            self.rest += piece
        text, self.rest = self.rest.split(b"\0", 1)
        message = json.loads(text)
        kind, of = message.get("method"), message.get("params", {})
        if kind == "Page.loadEventFired":
            self.loaded = True
        elif kind in ("Runtime.consoleAPICalled", "Runtime.exceptionThrown", "Log.entryAdded"):
            self.messages.append(json.dumps(of)[:500])
        elif kind == "Network.requestWillBeSent" and not of["request"]["url"].startswith(("data:", "file:")):
            self.messages.append("asked for " + of["request"]["url"])
        return message

    def ask(self, method, **words):
        self.number += 1
        session = {"sessionId": self.session} if self.session else {}
        os.write(self.out, json.dumps({"id": self.number, "method": method, "params": words, **session}).encode() + b"\0")
        while True:
            message = self._take()
            if message.get("id") == self.number:
                assert "error" not in message, message
                return message["result"]

    def open(self, path, width, dark=False):
        self.ask("Emulation.setDeviceMetricsOverride", width=width, height=900, deviceScaleFactor=1, mobile=width < 500)
        self.ask("Emulation.setEmulatedMedia", features=[{"name": "prefers-color-scheme", "value": "dark" if dark else "light"}])
        self.loaded = False
        self.ask("Page.navigate", url=f"file://{path}")
        while not self.loaded:
            self._take()

    def value(self, expression):
        """Of a JavaScript expression, as Python's."""
        found = self.ask("Runtime.evaluate", expression=expression, returnByValue=True, awaitPromise=True)
        assert "exceptionDetails" not in found, found
        return found["result"].get("value")

    def screenshot(self, path):
        """The whole page."""
        height = self.value("document.documentElement.scrollHeight")
        width = self.value("innerWidth")
        clip = {"x": 0, "y": 0, "width": width, "height": min(height, 16000), "scale": 1}
        found = self.ask("Page.captureScreenshot", format="png", captureBeyondViewport=True, clip=clip)
        with open(path, "wb") as file:
            file.write(base64.b64decode(found["data"]))
