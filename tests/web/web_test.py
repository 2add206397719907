#!/usr/bin/python3
"""The farm's web page in a real Chromium, with a real coordinator and real workers.

web_test.py BIN [--times] [--screenshots DIR]: BIN has the programs. Exit code 77: there is no browser, or no kernel, here. Times are printed;
with --times, which is for machines that do nothing else, what is promised within two seconds must show within them, and nothing may keep the
page busy for a second. With TESSERA_TEST_FORM=long, all 1,048,576 tiles of a frame of 16384 x 16384 pixels change.
"""

import asyncio
import http.client
import json
import os
import pathlib
import re
import shutil
import signal
import ssl
import subprocess
import sys
import tempfile
import time

sys.path.insert(0, str(pathlib.Path(__file__).parent))
from browser import PATIENCE, Browser, missing  # noqa: E402

ROOT = pathlib.Path(__file__).resolve().parents[2]
LONG = os.environ.get("TESSERA_TEST_FORM") == "long"
TIMES = "--times" in sys.argv
PROMISED = 2.0  # seconds
HOSTILE = "<img src=x onerror=window.hacked=1><script>window.hacked=1</script> & \"'"


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
            made = [self.programs / "tessera-server", "--init-tls", self.certificates, "--tls-host", "farm.example", "--tls-user", "ada"]
            subprocess.run(made, check=True, capture_output=True)
            given = ["--tls", self.certificates / "server"]
        self.server = self.start(
            "tessera-server", "--listen", "127.0.0.1:0", "--data", self.folder / "data", "--unit-seconds", 1, *given, log=self.log
        )
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
        return self.start(
            "tessera-worker", "--server", self.address, "--name", name, "--threads", threads,
            log=self.folder / f"{name}.log",
        )

    def tessera(self, *arguments):
        done = subprocess.run(
            [self.programs / "tessera", *map(str, arguments), "--server", self.address],
            capture_output=True, text=True, timeout=600, check=False,
        )
        assert done.returncode == 0, f"{arguments}: {done.stderr}"
        return done.stdout.strip()

    def submit(self, scene="scenes/cornell-box/scene.pbrt", *options):
        return self.tessera("submit", ROOT / scene, "--detach", "--quiet", *options).split()[-1]

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


def check(holds, what):
    if not holds:
        raise AssertionError(what)


def within_promise(began, what):
    took = time.monotonic() - began
    print(f"  {what}: {took:.2f} s")
    if TIMES:
        check(took <= PROMISED, f"{what} took {took:.2f} s")


def row(name, column):
    """Text of a cell of the table in sight, of the row that has `name`."""
    return (
        "[...document.querySelectorAll('.page:not([hidden]) .row')].filter((row) => row.textContent.includes("
        f"{name!r})).map((row) => row.children[{column}].textContent)[0]"
    )


async def jobs_and_names(farm, browser):
    """A job shows, also one of a hostile name, whose name is text; one that is cancelled elsewhere shows that."""
    scene = farm.folder / "scene.textproto"
    named = (ROOT / "scenes/first-light/scene.textproto").read_text()
    scene.write_text(re.sub(r"^name:.*", lambda _: "name: " + json.dumps(HOSTILE), named, count=1, flags=re.MULTILINE))
    await browser.open(farm.page())
    await browser.until("document.getElementById('link').textContent === 'live'")
    began = time.monotonic()
    job = farm.submit(scene, "--spp", "4096")
    await browser.until(f"jobs.has({job!r}) && document.querySelector('.row') !== null")
    within_promise(began, "a submitted job shows")
    check(await browser.evaluate(f"document.querySelector('.row').textContent.includes({HOSTILE!r})"), "the name as it is")
    await browser.evaluate(f"location.hash = '#/job/{job}'")
    await browser.until(f"document.getElementById('job-name').textContent === {HOSTILE!r}")
    check(await browser.evaluate("document.querySelectorAll('img, main script, .row b').length") == 0, "elements of a name")
    check(not await browser.evaluate("'hacked' in window"), "the name of a job ran")
    await browser.evaluate("location.hash = '#/jobs'")
    began = time.monotonic()
    farm.tessera("cancel", job)
    await browser.until("document.querySelector('.page:not([hidden]) .row .state.CANCELLED') !== null")
    within_promise(began, "a cancelled job shows")


async def picture(farm, browser):
    """The page pauses, resumes and sets the priority; tiles show in the canvas; the page cancels."""
    # So many samples that no machine is done with them while the page is looked at.
    job = farm.submit("scenes/cornell-box/scene.pbrt", "--spp", "1048576", "--resolution", "320x240")
    await browser.open(farm.page(f"#/job/{job}"))
    painted = (
        "(() => { const c = document.getElementById('canvas'); const d = c.getContext('2d').getImageData(0, 0, c.width, c.height).data;"
        " for (let i = 3; i < d.length; i += 4) if (d[i] && d[i - 1] + d[i - 2] + d[i - 3]) return true; return false; })()"
    )
    await browser.until("viewer.source !== null")
    check(not await browser.evaluate(painted), "a picture before there is a worker")
    button = "[...document.querySelectorAll('#job-actions button')].find((b) => b.textContent === {!r}).click()"
    await browser.evaluate(button.format("Pause"))
    await browser.until("document.getElementById('job-state').textContent === 'paused'")
    check(json.loads(farm.tessera("job", job, "--json"))["status"]["paused"], "pause")
    await browser.evaluate(button.format("Resume"))
    await browser.until("document.getElementById('job-state').textContent === 'queued'")
    await browser.evaluate(
        "(() => { const p = document.querySelector('#job-actions input'); p.value = '7'; p.dispatchEvent(new Event('change')); })()"
    )
    await browser.until(f"jobs.get({job!r}).priority === 7")
    worker = farm.worker("painter")
    done = f"jobs.get({job!r}).done"
    while await browser.evaluate(done) == 0:
        await asyncio.sleep(0.02)
    began = time.monotonic()
    await browser.until(painted)
    within_promise(began, "a tile shows")
    await browser.until("viewer.work.length > 0 && workerName(viewer.work[0][4]) === 'painter'")
    await browser.until("viewer.source.valueAt(160, 120) !== null")
    # Other layers.
    for layer in ("noise", "samples", "cost"):
        await browser.evaluate(
            f"(() => {{ const l = document.getElementById('layer'); l.value = '{layer}'; l.dispatchEvent(new Event('change')); }})()"
        )
        await browser.until(f"viewer.source.layer === '{layer}' && viewer.source.range > 0")
    await browser.evaluate("document.getElementById('layer').value = 'color'; showLayer()")
    cancel = "[...document.querySelectorAll('#job-actions button')].find((b) => /ancel/.test(b.textContent)).click()"
    await browser.evaluate(cancel)
    await browser.evaluate(cancel)
    await browser.until("document.getElementById('job-state').textContent === 'cancelled'")
    # Another job beside what came of this one.
    other = farm.submit("scenes/cornell-box/scene.pbrt", "--spp", "4", "--resolution", "320x240")
    await browser.until(f"jobs.has({other!r}) && jobs.get({other!r}).state === 'DONE'")
    await browser.evaluate(f"(() => {{ listOthers(); document.getElementById('other').value = {other!r}; showLayer(); }})()")
    await browser.until("viewer.other !== null && viewer.other.valueAt(160, 120) !== null")
    return worker


async def frames(farm, browser):
    """The frames of an animation stand above the picture, as thumbnails; a click shows another one."""
    last = farm.submit("scenes/cornell-box/scene.pbrt", "--spp", "4", "--resolution", "64x48", "--frames", "1-3")
    await browser.open(farm.page(f"#/job/{last}"))
    await browser.until("document.querySelectorAll('#frames a').length === 3")
    await browser.until(
        "[...document.querySelectorAll('#frames canvas')].every("
        "(c) => c.getContext('2d').getImageData(c.width / 2, c.height / 2, 1, 1).data[3] > 0)"
    )
    await browser.evaluate("document.querySelector('#frames a').click()")
    await browser.until("document.querySelector('#frames a').getAttribute('aria-current') === 'true'")


async def dead_worker(farm, browser, worker):
    """A worker that dies is shown as silent, and then goes."""
    await browser.open(farm.page("#/workers"))
    await browser.until(f"{row('painter', 1)} !== undefined && {row('painter', 1)} !== ''")
    worker.send_signal(signal.SIGKILL)
    began = time.monotonic()
    await browser.until(f"({row('painter', 1)} || 'silent').includes('silent')")
    within_promise(began, "a dead worker shows")
    if LONG:
        await browser.until("workers.size === 0")


async def strangers(farm, browser):
    """Pages of other sites read nothing and change nothing; nothing can be uploaded."""
    job = farm.submit("scenes/first-light/scene.textproto", "--spp", "4096")
    await browser.open("data:text/html,<title>stranger</title>")
    tried = (
        "Promise.allSettled([fetch('{0}api/me'), fetch('{0}api/job?id={1}'),"
        " fetch('{0}api/cancel', {{method: 'POST', mode: 'no-cors', body: '{{\"id\":\"{1}\"}}'}})]).then((all) =>"
        " all.filter((one) => one.status === 'fulfilled' && one.value.type !== 'opaque').length)"
    )
    check(await browser.evaluate(tried.format(farm.page(), job)) == 0, "a page of another site could read")
    await browser.open(farm.page())
    await browser.until(f"jobs.has({job!r})")
    check(await browser.evaluate(f"jobs.get({job!r}).state") != "CANCELLED", "a page of another site cancelled a job")
    sent = "fetch('api/{}', {{method: '{}', headers: {{'Content-Type': 'application/json', 'X-Tessera': '1'}}, body: '{{}}'}}).then((r) => r.status)"
    for action in ("submit", "upload", "delete", "expel"):
        check(await browser.evaluate(sent.format(action, "POST")) == 404, action)
    check(await browser.evaluate(sent.format("job", "PUT")) == 405, "PUT")
    long = "fetch('api/cancel', {method: 'POST', headers: {'Content-Type': 'application/json', 'X-Tessera': '1'}, body: 'x'.repeat(5000)}).then((r) => r.status)"
    check(await browser.evaluate(long) == 413, "a long request")
    farm.tessera("cancel", job)


async def big_farm(farm, browser):
    """Ten thousand workers whose rows all change, and (in the long form) a million tiles, leave the page usable."""
    await browser.open(farm.page("#/workers"))
    await browser.until("document.getElementById('link').textContent === 'live'")
    await browser.evaluate("stream.close()")
    rounds, batches = (5, 4096) if LONG else (2, 512)  # 256 tiles a batch
    longest = await browser.evaluate(
        f"""(async () => {{
      const rounds = {rounds}, batches = {batches};"""
        + """
      let longest = 0, before = performance.now(), over = false;
      const tick = () => { const at = performance.now(); longest = Math.max(longest, at - before); before = at; if (!over) setTimeout(tick, 0); };
      tick();
      const row = (i, done) => ({id: 'w' + i, name: 'host-' + i + ':77', host: 'host-' + i, isa: 'avx512', build: '', threads: 64, leases: 4, done,
        failures: 0, memory: 900, slowness: 1, draining: false, silent: i % 100 ? 0 : 3, quarantine: '', tags: ['a'], jobs: [{id: 'j', name: 'job', leases: 4}]});
      for (let round = 0; round < rounds; ++round) {
        for (let from = 0; from < 10000; from += 1000) {
          const rows = Array.from({length: 1000}, (_, i) => row(from + i, round * 10));
          take({data: JSON.stringify({rows, gone: [], all: round === 0 && from === 0, more: from < 9000})}, workers, workerTable, workersChanged, withRate);
          await new Promise((resolve) => setTimeout(resolve, 0));
        }
        await new Promise((resolve) => setTimeout(resolve, 150));
      }
      const settings = {layers: [{name: 'color', color: true}], crop: [0, 0, 16384, 16384]};
      const source = new FrameSource('none', settings, 'color', () => viewer.changed());
      source.fetch = (piece) => { const [x0, y0, x1, y1] = piece.dirty; piece.dirty = null; source.store(piece, x0, y0, x1 - x0, y1 - y0, new Uint16Array((x1 - x0) * (y1 - y0) * 4).fill(15360)); };
      show('job');
      viewer.show(source, null);
      for (let batch = 0; batch < batches; ++batch) {
        const areas = [];
        for (let i = 0; i < 256; ++i) { const t = batch * 256 + i, x = t % 1024 * 16, y = (t >> 10) * 16; areas.push(x, y, x + 16, y + 16); }
        pictureNews(source, {areas}, false);
        if (batch % 64 === 63) await new Promise((resolve) => setTimeout(resolve, 0));
      }
      await new Promise((resolve) => setTimeout(resolve, 300));
      over = true;
      return longest;
    })()"""
    )
    print(f"  10,000 workers, {rounds} times, and {256 * batches} tiles: longest task {longest:.0f} ms")
    check(await browser.evaluate("workers.size") == 10000, "10,000 workers")
    shown = await browser.evaluate("show('workers'), new Promise((r) => setTimeout(() => r(document.querySelectorAll('#table-workers .row').length), 300))")
    check(0 < shown < 100, f"{shown} rows exist")
    if TIMES:
        check(longest < 1000, f"a task took {longest:.0f} ms")


def https(farm, path, host="farm.example", session="", body=None, certificate=None, newest=ssl.TLSVersion.TLSv1_3):
    """Status and headers of an answer over TLS, whose certificate must be the farm's."""
    context = ssl.create_default_context(cafile=farm.certificates / "server" / "ca.pem")
    context.check_hostname = False  # of 127.0.0.1, which is in it, too
    context.maximum_version = newest
    if certificate:
        context.load_cert_chain(certificate / "certificate.pem", certificate / "key.pem")
    connection = http.client.HTTPSConnection("127.0.0.1", int(farm.web), context=context, timeout=PATIENCE)
    headers = {"Host": f"{host}:{farm.web}", "Cookie": session}
    if body is not None:
        headers.update({"Content-Type": "application/json", "X-Tessera": "1"})
    connection.request("GET" if body is None else "POST", path, body=body, headers=headers)
    answer = connection.getresponse()
    answer.read()
    connection.close()
    return answer.status, dict(answer.getheaders())


async def certificates(programs, screenshots):
    """With --tls the page is encrypted, and answers those with a certificate or a login alone."""
    farm = Farm(programs, tls=True)
    try:
        check(https(farm, "/")[0] == 200, "the page by a name in the certificate")
        check(https(farm, "/", host="evil.example")[0] == 403, "the page by another name")
        check(https(farm, "/api/me")[0] == 401, "somebody unknown")
        check(https(farm, "/api/me", certificate=farm.certificates / "client-ada")[0] == 200, "a client's certificate")
        check(https(farm, "/api/me", certificate=farm.certificates / "worker")[0] == 403, "a worker's certificate")
        try:
            https(farm, "/", newest=ssl.TLSVersion.TLSv1_2)
            check(False, "TLS 1.2 was spoken")
        except (ssl.SSLError, OSError):
            pass
        address = farm.tessera("token", "--web", "--tls", farm.certificates / "client-ada")
        check(re.fullmatch(rf"https://127.0.0.1:{farm.web}/#login=[0-9a-f]+", address), address)
        token = json.dumps({"token": address.split("=")[1]})
        status, headers = https(farm, "/api/login", body=token)
        check(status == 200 and "HttpOnly" in headers["Set-Cookie"], "the login")
        check(https(farm, "/api/login", body=token)[0] == 403, "a token that was used")
        session = headers["Set-Cookie"].split(";")[0]
        check(https(farm, "/api/me", session=session)[0] == 200, "a session")
        if screenshots:
            async with Browser() as browser:
                await browser.open(farm.page())
                await browser.until("!document.getElementById('page-login').hidden")
                await browser.screenshot(screenshots / "web-login.png")
    finally:
        farm.end()


async def pictures_of_pages(programs, folder):
    """What docs/images has."""
    farm = Farm(programs)
    try:
        async with Browser() as browser:
            for i in range(3):
                farm.worker(f"node-{i}")
            await browser.open(farm.page())
            done = farm.submit("scenes/first-light/scene.textproto", "--spp", "16", "--user", "ada")
            await browser.until(f"jobs.has({done!r}) && jobs.get({done!r}).state === 'DONE'")
            rough = farm.submit("scenes/cornell-box/scene.pbrt", "--spp", "4", "--resolution", "640x640", "--user", "ben")
            broken = farm.folder / "sign.pbrt"
            (farm.folder / "sign.png").write_bytes((ROOT / "docs/images/cornell-box.png").read_bytes()[:1000])
            broken.write_text(
                'Camera "perspective"\nWorldBegin\nLightSource "infinite"\nTexture "sign" "spectrum" "imagemap" "string filename"'
                ' "sign.png"\nMaterial "diffuse" "texture reflectance" "sign"\nTranslate 0 0 4\nShape "sphere"\n'
            )
            failed = farm.submit(broken, "--user", "ada")
            await browser.until(f"jobs.has({failed!r}) && jobs.get({failed!r}).state === 'FAILED' && jobs.get({rough!r}).state === 'DONE'")
            busy = farm.submit("scenes/cornell-box/scene.pbrt", "--spp", "256", "--resolution", "640x640", "--user", "ben", "--priority", "5")
            farm.submit("scenes/glass-of-water/scene.textproto", "--user", "cleo", "--priority", "-1")
            await browser.until(f"jobs.has({busy!r}) && jobs.get({busy!r}).done > 0.3 * jobs.get({busy!r}).total")
            await browser.screenshot(folder / "web-jobs.png")
            # Without the paths of the machine that this runs on.
            await browser.evaluate("(() => { const f = document.getElementById('find-events'); f.value = 'job'; f.dispatchEvent(new Event('input')); })()")
            for name, seconds in (("workers", 4), ("events", 2), ("faults", 2)):
                await browser.evaluate(f"location.hash = '#/{name}'")
                await asyncio.sleep(seconds)
                await browser.screenshot(folder / f"web-{name}.png")
            await browser.evaluate(f"location.hash = '#/job/{busy}'")
            shown = "viewer.source && viewer.source.pieces.size > 1 && [...viewer.source.pieces.values()].every((piece) => piece.data)"
            await browser.until(shown)
            await asyncio.sleep(2)
            await browser.screenshot(folder / "web-job.png")
            await browser.evaluate("document.getElementById('layer').value = 'cost'; showLayer()")
            await browser.until(shown)
            await browser.prefer("dark")
            await asyncio.sleep(2)
            await browser.screenshot(folder / "web-cost.png")
            await browser.evaluate("document.getElementById('layer').value = 'color'; listOthers()")
            await browser.evaluate(f"document.getElementById('other').value = {rough!r}; showLayer()")
            await browser.until(shown + " && viewer.other && [...viewer.other.pieces.values()].every((piece) => piece.data)")
            await asyncio.sleep(2)
            await browser.screenshot(folder / "web-compare.png")
            await browser.resize(390, 844, mobile=True)
            await browser.evaluate("document.getElementById('other').value = ''; showLayer()")
            await asyncio.sleep(2)
            check(await browser.evaluate("document.documentElement.scrollWidth <= innerWidth"), "the phone's page is too wide")
            await browser.screenshot(folder / "web-phone.png")
            await browser.evaluate("location.hash = '#/jobs'")
            await asyncio.sleep(1)
            await browser.screenshot(folder / "web-phone-jobs.png")
    finally:
        farm.end()


async def run(programs, screenshots):
    farm = Farm(programs)
    try:
        async with Browser() as browser:
            await jobs_and_names(farm, browser)
            worker = await picture(farm, browser)
            await frames(farm, browser)
            await dead_worker(farm, browser, worker)
            await strangers(farm, browser)
            refused = [text for text in browser.errors if "stranger" not in text and "data:" not in text]
            await big_farm(farm, browser)
            check(not [text for text in refused if "Content Security Policy" in text or "exceptionDetails" in text], refused)
            check(not [text for text in browser.errors if '"text"' in text], browser.errors)
        check(farm.server.poll() is None, "the coordinator ended")
    finally:
        farm.end()
    await certificates(programs, screenshots)
    if screenshots:
        await pictures_of_pages(programs, screenshots)


def main():
    why = missing()
    if not why and not list(pathlib.Path(sys.argv[1], "../lib").glob("libtessera_kernel_*.so")):
        why = "there are no kernels"
    if why:
        print(f"[  SKIPPED ] {why}")
        if "TESSERA_SKIPS" in os.environ:  # deploy/test.sh shows them
            with open(os.environ["TESSERA_SKIPS"], "a") as skips:
                skips.write(f"web_page_test: {why}\n")
        return 77
    screenshots = None
    if "--screenshots" in sys.argv:
        screenshots = pathlib.Path(sys.argv[sys.argv.index("--screenshots") + 1])
        screenshots.mkdir(parents=True, exist_ok=True)
    asyncio.run(run(sys.argv[1], screenshots))
    return 0


if __name__ == "__main__":
    sys.exit(main())
