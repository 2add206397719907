"""A headless Chromium, driven through its DevTools protocol.

https://chromedevtools.github.io/devtools-protocol/
"""

import asyncio
import base64
import json
import os
import pathlib
import shutil
import subprocess
import tempfile
import urllib.request

PATIENCE = 300.0  # seconds until something that is waited for counts as missing


class Browser:
    """One page of one Chromium with a profile of its own."""

    def __init__(self, width=1280, height=800):
        self.size = (width, height)
        self.profile = tempfile.mkdtemp(prefix="tessera-browser-")
        self.errors = []  # exceptions, and what a policy refused, of the page
        self.answers = {}
        self.calls = 0

    async def __aenter__(self):
        import websockets

        self.process = subprocess.Popen(
            [
                "chromium", "--headless=new", "--no-sandbox", "--disable-gpu", "--disable-dev-shm-usage",
                "--no-first-run", "--ignore-certificate-errors", "--remote-debugging-port=0",
                f"--user-data-dir={self.profile}", f"--window-size={self.size[0]},{self.size[1]}", "about:blank",
            ],
            stdout=subprocess.DEVNULL,
            stderr=subprocess.DEVNULL,
        )
        port_file = pathlib.Path(self.profile, "DevToolsActivePort")
        await self.wait(lambda: port_file.exists() and len(port_file.read_text().split()) == 2, "Chromium")
        port = port_file.read_text().split()[0]
        pages = json.load(urllib.request.urlopen(f"http://127.0.0.1:{port}/json"))
        address = next(page["webSocketDebuggerUrl"] for page in pages if page["type"] == "page")
        self.socket = await websockets.connect(address, max_size=None)
        self.reader = asyncio.create_task(self.read())
        for domain in ("Page", "Runtime", "Log"):
            await self.call(f"{domain}.enable")
        await self.resize(*self.size)
        return self

    async def __aexit__(self, *_):
        self.reader.cancel()
        await self.socket.close()
        self.process.terminate()
        try:
            self.process.wait(10)
        except subprocess.TimeoutExpired:
            self.process.kill()
            self.process.wait()
        shutil.rmtree(self.profile, ignore_errors=True)

    async def read(self):
        async for message in self.socket:
            answer = json.loads(message)
            if "id" in answer:
                self.answers.pop(answer["id"]).set_result(answer)
            elif answer["method"] == "Runtime.exceptionThrown":
                self.errors.append(json.dumps(answer["params"]["exceptionDetails"])[:600])
            elif answer["method"] == "Log.entryAdded" and answer["params"]["entry"]["source"] == "security":
                self.errors.append(answer["params"]["entry"]["text"])

    async def call(self, method, **params):
        self.calls += 1
        self.answers[self.calls] = asyncio.get_running_loop().create_future()
        future = self.answers[self.calls]
        await self.socket.send(json.dumps({"id": self.calls, "method": method, "params": params}))
        answer = await asyncio.wait_for(future, PATIENCE)
        if "error" in answer:
            raise RuntimeError(f"{method}: {answer['error']}")
        return answer["result"]

    async def open(self, address):
        await self.call("Page.navigate", url=address)
        await self.until("document.readyState === 'complete'")

    async def evaluate(self, expression):
        result = await self.call("Runtime.evaluate", expression=expression, returnByValue=True, awaitPromise=True)
        if "exceptionDetails" in result:
            raise RuntimeError(f"{expression}: {json.dumps(result['exceptionDetails'])[:600]}")
        return result["result"].get("value")

    async def wait(self, condition, what):
        for _ in range(int(PATIENCE / 0.05)):
            if condition():
                return
            await asyncio.sleep(0.05)
        raise TimeoutError(what)

    async def until(self, expression):
        """Waits until the expression is true; an error in it counts as false."""
        for _ in range(int(PATIENCE / 0.05)):
            result = await self.call("Runtime.evaluate", expression=expression, returnByValue=True, awaitPromise=True)
            if result["result"].get("value") and "exceptionDetails" not in result:
                return
            await asyncio.sleep(0.05)
        raise TimeoutError(expression)

    async def resize(self, width, height, mobile=False, scale=1):
        await self.call(
            "Emulation.setDeviceMetricsOverride", width=width, height=height, deviceScaleFactor=scale, mobile=mobile
        )

    async def press(self, key):
        for kind in ("keyDown", "keyUp"):
            await self.call("Input.dispatchKeyEvent", type=kind, key=key, code=key)

    async def prefer(self, scheme):
        await self.call("Emulation.setEmulatedMedia", features=[{"name": "prefers-color-scheme", "value": scheme}])

    async def screenshot(self, path):
        picture = await self.call("Page.captureScreenshot", format="png")
        pathlib.Path(path).write_bytes(base64.b64decode(picture["data"]))


def missing():
    """Why there is no browser here; empty when there is one."""
    if shutil.which("chromium") is None:
        return "needs chromium (deploy/setup.sh --ci)"
    try:
        import websockets  # noqa: F401
    except ImportError:
        return "needs python3-websockets (deploy/setup.sh --ci)"
    return "" if os.name == "posix" else "needs a POSIX system"
