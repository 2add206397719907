"""What the pages show of a real farm, and what they do."""

import asyncio
import json
import re
import signal
import time

from farm import ROOT, check
from form import LONG, within_promise

HOSTILE = "<img src=x onerror=window.hacked=1><script>window.hacked=1</script> & \"'"


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
    hostile = "name: " + json.dumps(HOSTILE)
    scene.write_text(re.sub(r"^name:.*", lambda _: hostile, named, count=1, flags=re.MULTILINE))
    await browser.open(farm.page())
    await browser.until("document.getElementById('link').textContent === 'live'")
    began = time.monotonic()
    job = farm.submit(scene, "--spp", "4096")
    await browser.until(f"jobs.has({job!r}) && document.querySelector('.row') !== null")
    within_promise(began, "a submitted job shows")
    shown = await browser.evaluate(f"document.querySelector('.row').textContent.includes({HOSTILE!r})")
    check(shown, "the name as it is")
    await browser.evaluate(f"location.hash = '#/job/{job}'")
    await browser.until(f"document.getElementById('job-name').textContent === {HOSTILE!r}")
    made = await browser.evaluate("document.querySelectorAll('img, main script, .row b').length")
    check(made == 0, "elements of a name")
    check(not await browser.evaluate("'hacked' in window"), "the name of a job ran")
    await browser.evaluate("location.hash = '#/jobs'")
    await browser.until("page === 'jobs'")
    await browser.press("ArrowDown")
    await browser.until(f"jobTable.at === {job!r}")
    began = time.monotonic()
    farm.tessera("cancel", job)
    await browser.until("document.querySelector('.page:not([hidden]) .row .state.CANCELLED') !== null")
    within_promise(began, "a cancelled job shows")


PAINTED = """(() => {
  const c = document.getElementById('canvas');
  const d = c.getContext('2d').getImageData(0, 0, c.width, c.height).data;
  for (let i = 3; i < d.length; i += 4) if (d[i] && d[i - 1] + d[i - 2] + d[i - 3]) return true;
  return false;
})()"""


def choose(field, value):
    return (
        f"(() => {{ const f = document.getElementById({field!r}); f.value = {value!r};"
        " f.dispatchEvent(new Event('change')); })()"
    )


# Bytes of 8, 0.2 and 0.05, given as 16-bit floats, in the looks that mix colours: as in display_view_test.cpp.
LOOKS = {3: "255,188,119", 4: "255,173,159"}


async def looks(browser):
    for curve, expected in LOOKS.items():
        shown = await browser.evaluate(
            f"(() => {{ const tone = new Tone(); tone.set(0, {curve});"
            " return tone.mix(0x4800, 0x3266, 0x2a66).map((code) => Math.round(255 * code)).join(); })()")
        check(shown == expected, f"look {curve} shows {shown}")


async def picture(farm, browser):
    """The page pauses, resumes and sets the priority; tiles show in the canvas; the page cancels."""
    # So many samples that no machine is done with them while the page is looked at.
    job = farm.submit("scenes/cornell-box/scene.pbrt", "--spp", "1048576", "--resolution", "320x240")
    await browser.open(farm.page(f"#/job/{job}"))
    await browser.until("viewer.source !== null")
    check(not await browser.evaluate(PAINTED), "a picture before there is a worker")
    # The arrow keys move it, though nothing was clicked.
    await browser.evaluate("document.activeElement.blur()")
    left = await browser.evaluate("viewer.view.x")
    await browser.press("ArrowRight")
    await browser.until(f"viewer.view.x > {left}")
    await browser.press("0")
    await browser.until(f"viewer.view.x === {left}")
    # Until the coordinator has answered, the page says that it loads.
    await browser.until("viewer.source.arrived")
    loading = "document.getElementById('stage').classList.contains('loading')"
    await browser.until(f"!{loading}")
    check(await browser.evaluate(f"(viewer.source.arrived = false, viewer.draw(), {loading})"), "a sign of loading")
    await browser.evaluate("viewer.source.arrived = true, viewer.changed()")
    button = "[...document.querySelectorAll('#job-actions button')].find((b) => b.textContent === {!r}).click()"
    await browser.evaluate(button.format("Pause"))
    await browser.until("document.getElementById('job-state').textContent === 'paused'")
    check(json.loads(farm.tessera("job", job, "--json"))["status"]["paused"], "pause")
    await browser.evaluate(button.format("Resume"))
    await browser.until("document.getElementById('job-state').textContent === 'queued'")
    await browser.evaluate(
        "(() => { const p = document.querySelector('#job-actions input'); p.value = '7';"
        " p.dispatchEvent(new Event('change')); })()"
    )
    await browser.until(f"jobs.get({job!r}).priority === 7")
    worker = farm.worker("painter")
    done = f"jobs.get({job!r}).done"
    while await browser.evaluate(done) == 0:
        await asyncio.sleep(0.02)
    began = time.monotonic()
    await browser.until(PAINTED)
    within_promise(began, "a tile shows")
    await browser.until("viewer.work.length > 0 && workerName(viewer.work[0][4]) === 'painter'")
    await browser.until("viewer.source.valueAt(160, 120) !== null")
    for layer in ("noise", "samples", "cost"):
        await browser.evaluate(choose("layer", layer))
        await browser.until(f"viewer.source.layer === '{layer}' && viewer.source.range > 0")
    await browser.evaluate("document.getElementById('layer').value = 'color'; showLayer()")
    cancel = "[...document.querySelectorAll('#job-actions button')].find((b) => /ancel/.test(b.textContent)).click()"
    await browser.evaluate(cancel)
    await browser.evaluate(cancel)
    await browser.until("document.getElementById('job-state').textContent === 'cancelled'")
    # Another job beside what came of this one.
    other = farm.submit("scenes/cornell-box/scene.pbrt", "--spp", "4", "--resolution", "320x240")
    await browser.until(f"jobs.has({other!r}) && jobs.get({other!r}).state === 'DONE'")
    await browser.evaluate("listOthers()")
    await browser.evaluate(choose("other", other))
    await browser.until("viewer.other !== null && viewer.other.valueAt(160, 120) !== null")
    return worker


async def spectrum(farm, browser):
    """A click on a pixel of a film with bands shows its spectrum; one beside the picture takes it away."""
    job = farm.submit("scenes/metamers/scene.textproto", "--spp", "4", "--resolution", "64x48", "--film", "spectral:12")
    await browser.open(farm.page(f"#/job/{job}"))
    await browser.until(f"jobs.has({job!r}) && jobs.get({job!r}).state === 'DONE'")
    await browser.until("viewer.source !== null && viewer.source.valueAt(32, 24) !== null")
    await click(browser)
    await browser.until("document.querySelector('#spectrum:not([hidden]) .curve') !== null")
    steps = await browser.evaluate("document.querySelector('#spectrum .curve').getAttribute('d').split('H').length - 1")
    check(steps == 12, f"{steps} steps in the plot of 12 bands")
    caption = await browser.evaluate("document.querySelector('#spectrum figcaption').textContent")
    check(caption.endswith(": 4 samples"), f"the plot says '{caption}'")
    await browser.evaluate("viewer.probe(-1, -1)")
    check(await browser.evaluate("byId('spectrum').hidden"), "a plot beside the picture")


async def click(browser, share_x=0.5, share_y=0.5):
    """Clicks on the picture, at a place in shares of the canvas."""
    box = await browser.evaluate(
        f"(() => {{ const b = byId('canvas').getBoundingClientRect();"
        f" return [b.left + {share_x} * b.width, b.top + {share_y} * b.height]; }})()"
    )
    for kind in ("mousePressed", "mouseReleased"):
        await browser.call("Input.dispatchMouseEvent", type=kind, x=box[0], y=box[1], button="left", clickCount=1)


async def meter(farm, browser):
    """A click tells a pixel's luminance, with its error where the job has the variance; false colours have a legend."""
    line = "[...document.querySelectorAll('#meter:not([hidden]) tr')].find((row) => row.textContent.includes('luminance'))"
    for aovs in ((), ("--aov", "variance")):
        options = ("--spp", "16", "--resolution", "64x48", "--reconstruction", "sample", *aovs)
        job = farm.submit("scenes/cornell-box/scene.pbrt", *options)
        await browser.open(farm.page(f"#/job/{job}"))
        await browser.until(f"jobs.has({job!r}) && jobs.get({job!r}).state === 'DONE'")
        await browser.until("viewer.source !== null && viewer.source.valueAt(32, 24) !== null")
        await click(browser)
        await browser.until(f"{line} !== undefined")
        taken = "[...document.querySelectorAll('#meter tr')].pop().children[1].textContent"
        await browser.until(f"{taken} === '16'")
        pixel, block = await browser.evaluate(f"[...{line}.children].slice(1).map((cell) => cell.textContent)")
        note = await browser.evaluate("document.querySelector('#meter:not([hidden]) p').textContent")
        check(("\u00b1" in pixel) == bool(aovs) and ("\u00b1" in block) == bool(aovs), f"the meter says {pixel}, {block}")
        check(("--aov variance" in note) == (not aovs), note)
        # The page has the colours as 16-bit floats, of 11 bits, and the meter tells four digits, or to half of the
        # last one of its error. The page hears of the last results a while after the job's end.
        caption = await browser.evaluate("document.querySelector('#meter figcaption').textContent")
        factor = (await browser.evaluate(f"ask('units?job={job}')"))["cd_per_m2"]
        told = [float(part) for part in pixel.split("\u00b1")]
        slack = told[0] * (2**-11 + 1e-3) + (0.1 * told[1] if aovs else 0)
        await browser.until(
            f"(() => {{ const [r, g, b] = viewer.source.valueAt({caption}).values;"
            f" return Math.abs({told[0]} - {factor} * (0.2126 * r + 0.7152 * g + 0.0722 * b)) <= {slack}; }})()")
    await browser.evaluate(choose("tone", "6"))
    await browser.until("!byId('legend').hidden && document.querySelectorAll('#legend text').length > 1")
    check(await browser.evaluate("document.querySelector('#legend figcaption').textContent") == "cd/m\u00b2", "its unit")
    await browser.until(
        "(() => { const c = byId('canvas'), d = c.getContext('2d').getImageData(c.width / 2, c.height / 2, 1, 1).data;"
        " for (let i = 0; i < 768; i += 3) if ([0, 1, 2].every((b) => kCividis[i + b] === d[b])) return true;"
        " return false; })()")
    await browser.evaluate(choose("layer", "samples"))
    await browser.until("viewer.source.layer === 'samples' && byId('legend').hidden")
    await browser.evaluate(choose("layer", "color"))
    await browser.evaluate(choose("tone", "0"))
    await browser.until("viewer.source.layer === 'color' && byId('legend').hidden")
    await browser.evaluate("viewer.probe(-1, -1)")
    check(await browser.evaluate("byId('meter').hidden"), "a meter beside the picture")


async def noise(farm, browser):
    """A job with noise has one result a tile: its map is the pilot's, or that of its variance."""
    told = {}
    for aovs, words in (((), "pilot foresaw"), (("--aov", "variance"), "variance of its samples")):
        options = ("--noise", "0.1", "--spp", "64", "--resolution", "96x64", *aovs)
        job = farm.submit("scenes/cornell-box/scene.pbrt", *options)
        await browser.open(farm.page(f"#/job/{job}"))
        await browser.until(f"jobs.has({job!r}) && jobs.get({job!r}).state === 'DONE'")
        await browser.until("viewer.source !== null")
        await browser.evaluate(choose("layer", "noise"))
        await browser.until("viewer.source.layer === 'noise' && viewer.source.range > 0")
        about = await browser.evaluate("document.getElementById('layer-about').textContent")
        check(words in about, about)
        values = "[...viewer.source.pieces.values()].find((piece) => piece.level === 0 && piece.data).data"
        mean = f"(() => {{ const v = [...{values}]; return v.reduce((a, b) => a + b, 0) / v.length; }})()"
        told[words] = await browser.evaluate(mean)
    # Both are of the same samples; the pilot's is an upper bound where samples go into several pixels.
    pilot, variance = told.values()
    print(f"  noise of the pilot {pilot:.4f}, of the variance {variance:.4f}")
    check(0.2 < pilot / variance < 5, told)


async def faults(farm, browser):
    """A failure has the last lines of its worker's log, as text, and stays open while others come."""
    job = farm.submit_broken()
    await browser.open(farm.page("#/faults"))
    await browser.until(f"jobs.has({job!r}) && jobs.get({job!r}).state === 'FAILED'")
    await browser.until("document.querySelector('.failure pre') !== null")
    log = await browser.evaluate("document.querySelector('.failure pre').textContent")
    check("[error] unit" in log and "sign.png" in log, log)
    await browser.evaluate("document.querySelector('.failure').open = true")
    await browser.evaluate("drawFaults(), new Promise((done) => setTimeout(done, 1000))")
    check(await browser.evaluate("document.querySelector('.failure').open"), "what was open")
    check("[error] unit" in farm.tessera("job", job), "the log by the command line")


async def frames(farm, browser):
    """The frames of an animation stand above the picture, as thumbnails; a click shows another one."""
    options = ("--spp", "4", "--resolution", "64x48", "--frames", "1-3")
    last = farm.submit("scenes/cornell-box/scene.pbrt", *options)
    await browser.open(farm.page(f"#/job/{last}"))
    await browser.until("document.querySelectorAll('#frames a').length === 3")
    await browser.until(
        "[...document.querySelectorAll('#frames canvas')].every("
        "(c) => c.getContext('2d').getImageData(c.width / 2, c.height / 2, 1, 1).data[3] > 0)"
    )
    # They leave room for the picture.
    below = "document.getElementById('stage').getBoundingClientRect().bottom - innerHeight"
    check(await browser.evaluate(below) <= 0, "the picture reaches below the window")
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
