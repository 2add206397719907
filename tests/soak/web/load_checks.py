"""How long the page is busy with much at once."""

from farm import check
from form import LONG, TIMES

# Calls what(), and returns the longest time between two turns of the page meanwhile, in ms.
LONGEST = """(async () => {
  let longest = 0, before = performance.now(), over = false;
  const tick = () => {
    const at = performance.now();
    longest = Math.max(longest, at - before);
    before = at;
    if (!over) setTimeout(tick, 0);
  };
  const pause = (ms) => new Promise((resolve) => setTimeout(resolve, ms));
  tick();
  await (%s)(pause);
  await pause(300);
  over = true;
  return longest;
})()"""

WORKERS_AND_TILES = """async (pause) => {
  const rounds = %d, batches = %d;
  const row = (i, done) => ({id: 'w' + i, name: 'host-' + i + ':77', host: 'host-' + i, isa: 'avx512', build: '',
    threads: 64, leases: 4, done, failures: 0, memory: 900, slowness: 1, draining: false,
    silent: i %% 100 ? 0 : 3, quarantine: '', tags: ['a'], jobs: [{id: 'j', name: 'job', leases: 4}]});
  for (let round = 0; round < rounds; ++round) {
    for (let from = 0; from < 10000; from += 1000) {
      const rows = Array.from({length: 1000}, (_, i) => row(from + i, round * 10));
      const changes = {rows, gone: [], all: round === 0 && from === 0, more: from < 9000};
      take(JSON.parse(JSON.stringify(changes)), workers, workerTable, workersChanged, withRate);
      await pause(0);
    }
    await pause(150);
  }
  const settings = {layers: [{name: 'color', color: true}], crop: [0, 0, 16384, 16384]};
  const source = new FrameSource('none', settings, 'color', () => viewer.changed());
  source.fetch = (piece) => {
    const [x0, y0, x1, y1] = piece.dirty;
    piece.dirty = null;
    source.store(piece, x0, y0, x1 - x0, y1 - y0, new Uint16Array((x1 - x0) * (y1 - y0) * 4).fill(15360));
  };
  show('job');
  viewer.show(source, null);
  for (let batch = 0; batch < batches; ++batch) {
    const areas = [];
    for (let i = 0; i < 256; ++i) {
      const t = batch * 256 + i, x = t %% 1024 * 16, y = (t >> 10) * 16;
      areas.push(x, y, x + 16, y + 16);
    }
    pictureNews(source, {areas}, false);
    if (batch %% 64 === 63) await pause(0);
  }
}"""

# All frames of an animation change, five times a second, as when a farm renders them.
FRAMES = """async (pause) => {
  const settings = {layers: [{name: 'color', color: true}], crop: [0, 0, 1920, 1080]}, frames = %d, rounds = %d;
  FrameSource.prototype.fetch = async function (piece) {
    const [x0, y0, x1, y1] = piece.dirty;
    piece.dirty = null;
    await pause(5);
    this.store(piece, x0, y0, x1 - x0, y1 - y0, new Uint16Array((x1 - x0) * (y1 - y0) * 4).fill(15360));
    this.changed();
  };
  show('job');
  shownJob = 'f0';
  details.set('f0', {settings});
  for (let round = 0; round < rounds; ++round) {
    const rows = Array.from({length: frames}, (_, i) => ({id: 'f' + i, name: 'shot', group: 'g', frame: i + 1,
      user: 'ada', state: 'RUNNING', paused: false, priority: 0, done: round, total: 100, leased: 1, aside: 0,
      failures: 0, workers: 1, cpu: 1, submitted: 1, finished: 0, left: 9, phase: '', error: ''}));
    take({rows, gone: [], all: round === 0, more: false}, jobs, jobTable, jobsChanged);
    await pause(200);
    document.getElementById('frames').scrollLeft += 400;
  }
}"""


async def open_quiet(farm, browser):
    """A page that hears nothing of the farm."""
    await browser.open(farm.page("#/workers"))
    await browser.until("document.getElementById('link').textContent === 'live'")
    await browser.evaluate("closeStream(), openStream = () => {}")


def told(what, longest):
    print(f"  {what}: longest task {longest:.0f} ms")
    if TIMES:
        check(longest < 1000, f"{what}: a task took {longest:.0f} ms")


async def big_farm(farm, browser):
    """Ten thousand workers whose rows all change, and (in the long form) a million tiles leave the page usable."""
    await open_quiet(farm, browser)
    rounds, batches = (5, 4096) if LONG else (2, 512)  # 256 tiles a batch
    longest = await browser.evaluate(LONGEST % (WORKERS_AND_TILES % (rounds, batches)))
    told(f"10,000 workers, {rounds} times, and {256 * batches} tiles", longest)
    check(await browser.evaluate("workers.size") == 10000, "10,000 workers")
    rows = "document.querySelectorAll('#table-workers .row').length"
    shown = await browser.evaluate(f"show('workers'), new Promise((r) => setTimeout(() => r({rows}), 300))")
    check(0 < shown < 100, f"{shown} rows exist")


async def long_animation(farm, browser):
    """The strip of five hundred frames that all change leaves the page usable."""
    await open_quiet(farm, browser)
    rounds = 50 if LONG else 15
    told(f"500 frames, {rounds} times", await browser.evaluate(LONGEST % (FRAMES % (500, rounds))))
    check(await browser.evaluate("document.querySelectorAll('#frames a').length") == 500, "500 thumbnails")
    painted = (
        "[...document.querySelectorAll('#frames canvas')].filter("
        "(c) => c.getContext('2d').getImageData(c.width / 2, c.height / 2, 1, 1).data[3] > 0).length"
    )
    check(await browser.evaluate(painted) > 5, "thumbnails in sight are painted")
