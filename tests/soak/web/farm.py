"""A coordinator with its web page, workers, and the command line, for tests."""

import pathlib
import re
import shutil
import subprocess
import tempfile
import time

from browser import PATIENCE

ROOT = pathlib.Path(__file__).resolve().parents[3]


def check(holds, what):
    if not holds:
        raise AssertionError(what)


class Farm:
    """A coordinator with its web page, and programs that call it."""

    def __init__(self, programs, tls=False):
        self.programs = pathlib.Path(programs).resolve()
        self.folder = pathlib.Path(tempfile.mkdtemp(prefix="tessera-web-test-"))
        self.running = []
        self.log = self.folder / "server.log"
        self.certificates = self.folder / "tls"
        given = []
        if tls:
            made = [self.programs / "tessera-server", "--init-tls", self.certificates]
            made += ["--tls-host", "farm.example", "--tls-user", "ada"]
            subprocess.run(made, check=True, capture_output=True)
            given = ["--tls", self.certificates / "server"]
        given += ["--listen", "127.0.0.1:0", "--data", self.folder / "data", "--unit-seconds", 1]
        self.server = self.start("tessera-server", *given, log=self.log)
        self.port = self.find(r"listening on 127.0.0.1:(\d+)")
        self.web = self.find(r"web page on port (\d+)")
        self.address = f"127.0.0.1:{self.port}"

    def start(self, program, *arguments, log):
        with open(log, "w") as out:
            process = subprocess.Popen([self.programs / program, *map(str, arguments)], stdout=out, stderr=out)
        self.running.append(process)
        return process

    def find(self, pattern):
        for _ in range(int(PATIENCE / 0.05)):
            found = re.search(pattern, self.log.read_text())
            if found:
                return found.group(1)
            assert self.server.poll() is None, self.log.read_text()
            time.sleep(0.05)
        raise TimeoutError(pattern + " in " + self.log.read_text())

    def worker(self, name, threads=1):
        given = ("--server", self.address, "--name", name, "--threads", threads)
        return self.start("tessera-worker", *given, log=self.folder / f"{name}.log")

    def tessera(self, *arguments):
        done = subprocess.run(
            [self.programs / "tessera", *map(str, arguments), "--server", self.address],
            capture_output=True,
            text=True,
            timeout=600,
            check=False,
        )
        assert done.returncode == 0, f"{arguments}: {done.stderr}"
        return done.stdout.strip()

    def submit(self, scene="scenes/cornell-box/scene.pbrt", *options):
        return self.tessera("submit", ROOT / scene, "--detach", "--quiet", *options).split()[-1]

    def submit_broken(self, *options):
        """A job whose scene cannot be built, for its texture is cut."""
        scene = self.folder / "sign.pbrt"
        picture = (ROOT / "docs/images/cornell-box.png").read_bytes()
        (self.folder / "sign.png").write_bytes(picture[:1000])
        scene.write_text(
            'Camera "perspective"\nWorldBegin\nLightSource "infinite"\n'
            'Texture "sign" "spectrum" "imagemap" "string filename" "sign.png"\n'
            'Material "diffuse" "texture reflectance" "sign"\nTranslate 0 0 4\nShape "sphere"\n'
        )
        return self.submit(scene, *options)

    def page(self, place=""):
        return f"http{'s' if self.certificates.exists() else ''}://127.0.0.1:{self.web}/{place}"

    def end(self):
        for process in self.running:
            if process.poll() is None:
                process.terminate()
        for process in self.running:
            try:
                process.wait(20)
            except subprocess.TimeoutExpired:
                process.kill()
                process.wait()
        shutil.rmtree(self.folder, ignore_errors=True)
