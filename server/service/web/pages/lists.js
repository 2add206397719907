// Jobs, workers and lines of the log, and their tables.
"use strict";

const kOver = new Set(["DONE", "FAILED", "CANCELLED", "INCOMPLETE"]);
const jobs = new Map(), workers = new Map();

const workerName = (id) => workers.has(id) ? workers.get(id).name : "";

function isPaused(job) { return job.paused && !kOver.has(job.state); }
function hasFaults(job) { return job.aside > 0 || job.failures > 0 || job.state === "FAILED"; }
function stateOf(job) { return isPaused(job) ? "paused" : job.state.toLowerCase(); }
function stateNode(job) {
  return element("span", stateOf(job), "state " + (isPaused(job) ? "paused" : job.state));
}
const shareOf = (job) => job.done / Math.max(1, job.total);
function bar(job) {
  const outer = element("div", undefined, "progress"), inner = element("div");
  inner.style.width = 100 * shareOf(job) + "%";
  outer.title = job.done + " of " + job.total + " units";
  outer.append(inner);
  return outer;
}
const percent = (job) => (Math.floor(1000 * shareOf(job)) / 10).toFixed(1) + " %";
function leftOf(job) {
  if (kOver.has(job.state)) return "";
  return job.left ? duration(job.left) : job.phase ? "phase " + job.phase : "";
}
const elapsed = (job) => duration(((job.finished || now()) - job.submitted) / 1000);

/// A column whose cells are a member, as text; it sorts by it.
const plain = (title, width, name, more) =>
  ({ title, width, cell: (row) => String(row[name]), value: (row) => row[name], ...more });
const kNumber = { num: true }, kWideNumber = { num: true, wide: true };

const jobTable = new Table(byId("table-jobs"), [
  { title: "Job", width: "minmax(96px, 2fr)", cell: (job) => job.name || job.id,
    value: (job) => (job.name || job.id).toLowerCase() },
  { title: "State", width: "86px", cell: stateNode, value: stateOf },
  { title: "", width: "minmax(40px, 1fr)", cell: bar },
  { title: "Done", width: "64px", cell: percent, value: shareOf, ...kNumber },
  { title: "Left", width: "104px", cell: leftOf, value: (job) => job.left, ...kWideNumber },
  plain("User", "minmax(60px, 120px)", "user", { wide: true }),
  plain("Prio", "44px", "priority", kWideNumber),
  plain("Workers", "60px", "workers", kWideNumber),
  { title: "Core-hours", width: "84px", cell: (job) => coreHours(job.cpu), value: (job) => job.cpu,
    ...kWideNumber },
  { title: "Submitted", width: "84px", cell: (job) => dayOrTime(job.submitted), value: (job) => job.submitted,
    ...kWideNumber },
], {
  open: (job) => { location.hash = "#/job/" + job.id; },
  sort: 9, down: true, empty: "No jobs yet: tessera submit SCENE -o OUT.exr",
});

function workerState(worker) {
  if (worker.quarantine) return element("span", "quarantine", "state bad");
  if (worker.silent) return element("span", "silent " + worker.silent + " s", "state bad");
  if (worker.draining) return element("span", "leaving", "state warn");
  return worker.leases ? element("span", "working", "state RUNNING") : element("span", "idle", "state soft");
}
function workerRank(worker) { return worker.quarantine ? 0 : worker.silent ? 1 : worker.leases ? 3 : 2; }
function nameNode(worker) {
  const node = element("span"), dot = element("span", "\u25a0 ");
  dot.style.color = "hsl(" + hueOf(worker.id) + " 70% 50%)";
  node.append(dot, worker.name);
  node.title = worker.name + (worker.quarantine ? "\n" + worker.quarantine : "");
  return node;
}
function rateOf(worker) { return worker.rate === undefined ? "" : worker.rate.toFixed(1); }
function inHand(worker) {
  const text = (job) => job.leases + " of " + (job.name || job.id || "another user's job");
  return worker.jobs.map(text).join(", ");
}
const workerTable = new Table(byId("table-workers"), [
  { title: "Worker", width: "minmax(110px, 2fr)", cell: nameNode, value: (worker) => worker.name },
  { title: "State", width: "88px", cell: workerState, value: workerRank },
  plain("Threads", "60px", "threads", kNumber),
  plain("ISA", "64px", "isa", { wide: true }),
  { title: "Units/min", width: "76px", cell: rateOf, value: (worker) => worker.rate || 0, ...kNumber },
  plain("Units", "68px", "done", kWideNumber),
  { title: "Slow", width: "52px", cell: (worker) => worker.slowness > 1.4 ? "x" + worker.slowness : "",
    value: (worker) => worker.slowness, ...kWideNumber },
  { title: "Memory", width: "76px", cell: (worker) => worker.memory ? worker.memory + " MB" : "",
    value: (worker) => worker.memory, ...kWideNumber },
  { title: "Failed", width: "56px", cell: (worker) => worker.failures ? String(worker.failures) : "",
    value: (worker) => worker.failures, ...kWideNumber },
  { title: "In hand", width: "minmax(90px, 1.5fr)", wide: true, cell: inHand,
    value: (worker) => worker.leases },
  { title: "Tags", width: "minmax(50px, 100px)", wide: true, cell: (worker) => worker.tags.join(" "),
    value: (worker) => worker.tags.join(" ") },
], { empty: "No workers: tessera-worker --server HOST:PORT" });

/// Adds units a minute over the last half minute or so.
function withRate(worker, before) {
  const past = before && before.past ? before.past : [];
  past.push([Date.now(), worker.done]);
  while (past.length > 2 && past[0][0] < Date.now() - 30000) past.shift();
  const last = past[past.length - 1], span = (last[0] - past[0][0]) / 60000;
  if (span > 0) worker.rate = (last[1] - past[0][1]) / span;
  Object.defineProperty(worker, "past", { value: past, enumerable: false });
}

const jobsChanged = soon(() => {
  let open = 0, faults = 0;
  for (const job of jobs.values()) {
    if (!kOver.has(job.state)) ++open;
    if (hasFaults(job)) ++faults;
  }
  byId("count-jobs").textContent = open || "";
  byId("count-faults").textContent = faults || "";
  if (page === "job") drawJob();
  if (page === "faults") drawFaults();
}, 50);
const workersChanged = soon(() => {
  let threads = 0, busy = 0, rate = 0, silent = 0;
  for (const worker of workers.values()) {
    threads += worker.threads;
    busy += worker.leases > 0;
    silent += worker.silent > 0;
    rate += worker.rate || 0;
  }
  byId("count-workers").textContent = workers.size || "";
  byId("sum-workers").textContent = workers.size + " workers, " + threads + " threads, " + busy + " at work" +
    (silent ? ", " + silent + " silent" : "") + ", " + rate.toFixed(0) + " units a minute";
}, 100);

function levelNode(line) {
  return element("span", line.level, { info: "soft", warning: "warn" }[line.level] || "bad");
}
const kMostLines = 5000;
const logTable = new Table(byId("table-events"), [
  { title: "Time", width: "76px", cell: (line) => timeOf(line.time) },
  { title: "", width: "58px", cell: levelNode },
  { title: "Event", width: "minmax(200px, 1fr)", cell: (line) => line.message },
], {
  height: 28, sort: -1, open: (line) => { if (jobs.has(line.job)) location.hash = "#/job/" + line.job; },
  empty: "Nothing happened yet.",
});
let lines = 0;
function addLines(added) {
  for (const line of added) logTable.set(Object.assign(line, { id: ++lines, text: line.message }));
  while (logTable.rows.size > kMostLines) logTable.rows.delete(logTable.rows.keys().next().value);
  if (byId("follow").checked) setTimeout(() => { byId("table-events").scrollTop = 1e9; }, 60);
}
