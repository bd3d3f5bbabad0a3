"""As much of WebDriver (W3C) as the tests need: headless Chromium through chromedriver, without the network."""

import json
import re
import subprocess
import tempfile
from urllib.request import Request, urlopen

ARGUMENTS = ("--headless=new --no-sandbox --disable-gpu --no-first-run --disable-background-networking "
             "--disable-component-update --disable-sync --disable-dev-shm-usage --window-size=1280,800").split()


class Browser:
    def __enter__(self):
        self.profile = tempfile.TemporaryDirectory(ignore_cleanup_errors=True)
        self.driver = subprocess.Popen(["chromedriver", "--port=0"], stdout=subprocess.PIPE, text=True)
        self.base = None
        port = next(int(m[1]) for m in (re.search(r"on port (\d+)\.", line) for line in self.driver.stdout) if m)
        self.base = f"http://127.0.0.1:{port}/session"
        options = {"args": [*ARGUMENTS, f"--user-data-dir={self.profile.name}"]}
        session = self._send("POST", "", {"capabilities": {"alwaysMatch": {"goog:chromeOptions": options}}})
        self.base += "/" + session["sessionId"]
        return self

    def __exit__(self, *_):
        self._send("DELETE", "")
        self.driver.terminate()
        self.driver.wait()
        self.driver.stdout.close()
        self.profile.cleanup()

    def _send(self, method, path, body=None):
        data = None if body is None else json.dumps(body).encode()
        with urlopen(Request(self.base + path, data, {"Content-Type": "application/json"}, method=method), timeout=60) as r:
            return json.load(r)["value"]

    def open(self, url):
        self._send("POST", "/url", {"url": url})

    def run(self, script, *arguments):
        """The value that a script returns, or that its promise resolves to."""
        return self._send("POST", "/execute/sync", {"script": script, "args": list(arguments)})

    def drag(self, start, end):
        """Moves the mouse from one point of the window to another with its button down."""
        def move(point):
            return {"type": "pointerMove", "x": round(point[0]), "y": round(point[1]), "duration": 50}

        steps = [move(start), {"type": "pointerDown", "button": 0}, move(end), {"type": "pointerUp", "button": 0}]
        mouse = {"type": "pointer", "id": "mouse", "parameters": {"pointerType": "mouse"}, "actions": steps}
        self._send("POST", "/actions", {"actions": [mouse]})
