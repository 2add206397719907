"""A coordinator and a worker on free ports, for tests; and what tests need to read the program's files."""

from __future__ import annotations

import os
import struct
import subprocess
import tempfile
import zlib
from pathlib import Path
from types import TracebackType

import numpy as np
import tessera

BIN = Path(os.environ.get("TESSERA_BIN_DIR", "build/release/bin"))
PROGRAM = str(BIN / "tessera")


class FarmUnderTest:
    """Ends all that it has started."""

    def __init__(self, *server_options: str, workers: int = 1) -> None:
        self.folder = tempfile.TemporaryDirectory(prefix="tessera-python-")
        self.path = Path(self.folder.name)
        self._options = server_options
        self._processes: list[subprocess.Popen[str]] = []
        self._address = "127.0.0.1:0"
        self.start_server()
        for number in range(workers):
            self.start_worker(number)

    def start_server(self) -> None:
        command = [BIN / "tessera-server", "--listen", self._address, "--data", self.path / "data"]
        self._server = subprocess.Popen(
            [*map(str, command), "--log-level", "error", *self._options], stdout=subprocess.PIPE, text=True
        )
        assert self._server.stdout is not None
        self._address = self._server.stdout.readline().split()[-1]

    def stop_server(self) -> None:
        self._server.terminate()
        self._server.communicate()

    def start_worker(self, number: int = 0) -> None:
        command = [BIN / "tessera-worker", "--server", self._address, "--threads", "1"]
        command += ["--cache", self.path / f"cache-{number}", "--log-level", "off"]
        self._processes.append(subprocess.Popen([str(word) for word in command], text=True))

    def connect(self) -> tessera.Farm:
        return tessera.Farm(self._address, user="tester", program=PROGRAM)

    def run(self, *words: str) -> str:
        """Runs `tessera` against this farm."""
        ran = subprocess.run(
            [PROGRAM, *words, "--server", self._address], capture_output=True, text=True, check=False
        )
        if ran.returncode:
            raise AssertionError(f"tessera {' '.join(words)}: {ran.stderr}")
        return ran.stdout

    def __enter__(self) -> FarmUnderTest:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        for process in self._processes:
            process.terminate()
        for process in self._processes:
            process.wait()
        self.stop_server()
        self.folder.cleanup()


def small_scene(spp: int = 16) -> tessera.Scene:
    """A sphere on a chequered floor under a lamp and a sky, 48 x 40."""
    scene = tessera.Scene("small")
    floor = scene.diffuse("floor", scene.checkerboard("tiles", 0.7, 0.2, (8, 8)))
    red = scene.principled("red", (0.7, 0.1, 0.1), roughness=0.3)
    corners = [(-3, 0, -3), (3, 0, -3), (3, 0, 3), (-3, 0, 3)]
    uvs = [(0, 0), (1, 0), (1, 1), (0, 1)]
    scene.mesh(corners, np.array([(0, 2, 1), (0, 3, 2)]), floor, uvs=uvs, name="floor")
    scene.sphere(1, (0, 1, 0), red)
    scene.rectangle([(-1, 4, -1), (1, 4, -1), (1, 4, 1), (-1, 4, 1)], emission=8.0)
    scene.environment(np.full((4, 8, 3), 0.3, np.float32))
    scene.camera(tessera.look_at((0, 2, 6), (0, 1, 0)), 40)
    scene.film(48, 40)
    scene.settings.spp = spp
    return scene


def read_exr(path: Path) -> dict[str, np.ndarray]:
    """The planes of an EXR of one part, scanlines, floats, ZIP: what the program writes. A reader of its own,
    by the description of the format, so that the package is compared with the file and not with itself."""
    data = path.read_bytes()
    assert data[:4] == b"\x76\x2f\x31\x01"
    at, attributes = 8, {}
    while data[at]:
        name, kind = (data[at:].split(b"\0", 2))[:2]
        at += len(name) + len(kind) + 2
        (size,) = struct.unpack_from("<i", data, at)
        attributes[name.decode()] = data[at + 4 : at + 4 + size]
        at += 4 + size
    at += 1
    channels, rest = [], attributes["channels"]
    while rest[0]:
        name, rest = rest.split(b"\0", 1)
        assert struct.unpack_from("<i", rest)[0] == 2, "32-bit floats"
        channels.append(name.decode())
        rest = rest[16:]
    x0, y0, x1, y1 = struct.unpack("<4i", attributes["dataWindow"])
    width, height = x1 - x0 + 1, y1 - y0 + 1
    assert attributes["compression"][0] == 3, "ZIP"
    planes = {name: np.zeros((height, width), np.float32) for name in channels}
    blocks = -(-height // 16)
    for (offset,) in struct.iter_unpack("<Q", data[at : at + 8 * blocks]):
        y, size = struct.unpack_from("<ii", data, offset)
        rows = min(16, height - (y - y0))
        packed = data[offset + 8 : offset + 8 + size]
        raw = 4 * len(channels) * width * rows
        if size < raw:
            deltas = np.frombuffer(zlib.decompress(packed), np.uint8).astype(np.int64)
            deltas[1:] -= 128
            halves = np.cumsum(deltas).astype(np.uint8)
            middle = (raw + 1) // 2
            whole = np.empty(raw, np.uint8)
            whole[0::2], whole[1::2] = halves[:middle], halves[middle:]
            packed = whole.tobytes()
        lines = np.frombuffer(packed, "<f4").reshape(rows, len(channels), width)
        for c, name in enumerate(channels):
            planes[name][y - y0 : y - y0 + rows] = lines[:, c]
    return planes
