#!/usr/bin/python3
"""The farm's web page in a real Chromium, with a real coordinator and real workers.

web_test.py BIN [--times] [--screenshots DIR]: BIN has the programs. Exit code 77: there is no browser, or no
kernel, here. Times are printed; with --times, which is for machines that do nothing else, what is promised within
two seconds must show within them, and nothing may keep the page busy for a second. With TESSERA_TEST_FORM=long, all
1,048,576 tiles of a frame of 16384 x 16384 pixels change.
"""

import asyncio
import os
import pathlib
import sys

sys.path.insert(0, str(pathlib.Path(__file__).parent))
import guard_checks  # noqa: E402
import load_checks  # noqa: E402
import page_checks  # noqa: E402
from browser import Browser, missing  # noqa: E402
from farm import Farm, check  # noqa: E402
from screenshots import pictures_of_pages  # noqa: E402


async def run(programs, screenshots):
    farm = Farm(programs)
    try:
        async with Browser() as browser:
            await page_checks.jobs_and_names(farm, browser)
            worker = await page_checks.picture(farm, browser)
            await page_checks.looks(browser)
            await page_checks.meter(farm, browser)
            await page_checks.spectrum(farm, browser)
            await page_checks.noise(farm, browser)
            await page_checks.frames(farm, browser)
            await page_checks.faults(farm, browser)
            await page_checks.dead_worker(farm, browser, worker)
            await guard_checks.strangers(farm, browser)
            refused = [text for text in browser.errors if "stranger" not in text and "data:" not in text]
            await load_checks.big_farm(farm, browser)
            await load_checks.long_animation(farm, browser)
            bad = [text for text in refused if "Content Security Policy" in text or "exceptionDetails" in text]
            check(not bad, refused)
            check(not [text for text in browser.errors if '"text"' in text], browser.errors)
        check(farm.server.poll() is None, "the coordinator ended")
    finally:
        farm.end()
    await guard_checks.certificates(programs, screenshots)
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
