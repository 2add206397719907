"""The pictures of docs/images."""

import asyncio

from browser import Browser
from farm import Farm, check

SHOWN = """viewer.source && viewer.source.pieces.size > 1 &&
  [...viewer.source.pieces.values()].every((piece) => piece.data)"""
# Without the paths of the machine that this runs on.
ONLY_JOBS = """(() => {
  const f = document.getElementById('find-events');
  f.value = 'job';
  f.dispatchEvent(new Event('input'));
})()"""


async def fill(farm, browser):
    """Jobs of all kinds; one that is long at work, and one that is done with few samples."""
    for i in range(3):
        farm.worker(f"node-{i}")
    await browser.open(farm.page())
    cornell, size = "scenes/cornell-box/scene.pbrt", ("--resolution", "640x640", "--user", "ben")
    done = farm.submit("scenes/first-light/scene.textproto", "--spp", "16", "--user", "ada")
    await browser.until(f"jobs.has({done!r}) && jobs.get({done!r}).state === 'DONE'")
    rough = farm.submit(cornell, "--spp", "4", *size)
    failed = farm.submit_broken("--user", "ada")
    await browser.until(
        f"jobs.has({failed!r}) && jobs.get({failed!r}).state === 'FAILED' && jobs.get({rough!r}).state === 'DONE'"
    )
    busy = farm.submit(cornell, "--spp", "256", "--priority", "5", *size)
    farm.submit("scenes/glass-of-water/scene.textproto", "--user", "cleo", "--priority", "-1")
    await browser.until(f"jobs.has({busy!r}) && jobs.get({busy!r}).done > 0.3 * jobs.get({busy!r}).total")
    return busy, rough


async def lists(browser, folder):
    await browser.screenshot(folder / "web-jobs.png")
    await browser.evaluate(ONLY_JOBS)
    for name, seconds in (("workers", 4), ("events", 2), ("faults", 2)):
        await browser.evaluate(f"location.hash = '#/{name}'")
        await asyncio.sleep(seconds)
        if name == "faults":
            await browser.evaluate("document.querySelector('details.failure').open = true")
        await browser.screenshot(folder / f"web-{name}.png")


async def pictures(browser, folder, busy, rough):
    await browser.evaluate(f"location.hash = '#/job/{busy}'")
    await browser.until(SHOWN)
    await asyncio.sleep(2)
    await browser.screenshot(folder / "web-job.png")
    await browser.evaluate("document.getElementById('layer').value = 'cost'; showLayer()")
    await browser.until(SHOWN)
    await browser.prefer("dark")
    await asyncio.sleep(2)
    await browser.screenshot(folder / "web-cost.png")
    await browser.evaluate("document.getElementById('layer').value = 'color'; listOthers()")
    await browser.evaluate(f"document.getElementById('other').value = {rough!r}; showLayer()")
    other = "viewer.other && [...viewer.other.pieces.values()].every((piece) => piece.data)"
    await browser.until(SHOWN + " && " + other)
    await asyncio.sleep(2)
    await browser.screenshot(folder / "web-compare.png")


async def phone(browser, folder):
    await browser.resize(390, 844, mobile=True)
    await browser.evaluate("document.getElementById('other').value = ''; showLayer()")
    await asyncio.sleep(2)
    fits = await browser.evaluate("document.documentElement.scrollWidth <= innerWidth")
    check(fits, "the phone's page is too wide")
    await browser.screenshot(folder / "web-phone.png")
    await browser.evaluate("location.hash = '#/jobs'")
    await asyncio.sleep(1)
    await browser.screenshot(folder / "web-phone-jobs.png")


async def pictures_of_pages(programs, folder):
    """Writes them; that of the login is guard_checks'."""
    farm = Farm(programs)
    try:
        async with Browser() as browser:
            busy, rough = await fill(farm, browser)
            await lists(browser, folder)
            await pictures(browser, folder, busy, rough)
            await phone(browser, folder)
    finally:
        farm.end()
