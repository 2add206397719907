// The pages: what there is, kept up to date by one stream of events.
"use strict";

const byId = (id) => document.getElementById(id);
const kOver = new Set(["DONE", "FAILED", "CANCELLED", "INCOMPLETE"]);
const jobs = new Map(), workers = new Map(), details = new Map();
let me = null, page = "", shownJob = "", stream = null, otherStream = null, clockOffset = 0, lastWord = 0, streamKey = "";

function element(tag, text, className) {
  const made = document.createElement(tag);
  if (text !== undefined) made.textContent = text;
  if (className) made.className = className;
  return made;
}
function tell(text) {
  byId("message").textContent = text || "";
  byId("message").hidden = !text;
  clearTimeout(tell.timer);
  if (text) tell.timer = setTimeout(() => tell(""), 8000);
}
async function ask(path, body) {
  const response = await fetch("api/" + path, body === undefined ? {} :
    { method: "POST", headers: { "Content-Type": "application/json", "X-Tessera": "1" }, body: JSON.stringify(body) });
  const answer = await response.json().catch(() => ({}));
  if (response.ok) return answer;
  if (response.status === 401 && path !== "login") { show("login"); throw new Error(""); }
  throw new Error(answer.error || "the coordinator answered " + response.status);
}
const act = (path, body) => ask(path, body).catch((error) => tell(error.message));
const now = () => Date.now() + clockOffset;
const workerName = (id) => workers.has(id) ? workers.get(id).name : "";
const timeOf = (ms) => new Date(ms).toLocaleTimeString([], { hour12: false });
const dayOrTime = (ms) => (new Date(ms).toDateString() === new Date(now()).toDateString() ? timeOf(ms) : new Date(ms).toLocaleDateString());

// ---- rows

function stateOf(job) { return job.paused && !kOver.has(job.state) ? "paused" : job.state.toLowerCase(); }
function stateNode(job) { return element("span", stateOf(job), "state " + (job.paused && !kOver.has(job.state) ? "paused" : job.state)); }
function bar(job) {
  const outer = element("div", undefined, "progress"), inner = element("div");
  inner.style.width = 100 * job.done / Math.max(1, job.total) + "%";
  outer.title = job.done + " of " + job.total + " units";
  outer.append(inner);
  return outer;
}
const percent = (job) => (Math.floor(1000 * job.done / Math.max(1, job.total)) / 10).toFixed(1) + " %";
function leftOf(job) {
  if (kOver.has(job.state)) return "";
  return job.left ? duration(job.left) : job.phase ? "phase " + job.phase : "";
}
const elapsed = (job) => duration(((job.finished || now()) - job.submitted) / 1000);

const jobTable = new Table(byId("table-jobs"), [
  { title: "Job", width: "minmax(96px, 2fr)", cell: (job) => job.name || job.id, value: (job) => (job.name || job.id).toLowerCase() },
  { title: "State", width: "86px", cell: stateNode, value: stateOf },
  { title: "", width: "minmax(40px, 1fr)", cell: bar },
  { title: "Done", width: "64px", num: true, cell: percent, value: (job) => job.done / Math.max(1, job.total) },
  { title: "Left", width: "104px", num: true, wide: true, cell: leftOf, value: (job) => job.left },
  { title: "User", width: "minmax(60px, 120px)", wide: true, cell: (job) => job.user, value: (job) => job.user },
  { title: "Prio", width: "44px", num: true, wide: true, cell: (job) => String(job.priority), value: (job) => job.priority },
  { title: "Workers", width: "60px", num: true, wide: true, cell: (job) => String(job.workers), value: (job) => job.workers },
  { title: "Core-hours", width: "84px", num: true, wide: true, cell: (job) => coreHours(job.cpu), value: (job) => job.cpu },
  { title: "Submitted", width: "84px", num: true, wide: true, cell: (job) => dayOrTime(job.submitted), value: (job) => job.submitted },
], { open: (job) => { location.hash = "#/job/" + job.id; }, sort: 9, down: true, empty: "No jobs yet: tessera submit SCENE -o OUT.exr" });

function workerState(worker) {
  if (worker.quarantine) return element("span", "quarantine", "state bad");
  if (worker.silent) return element("span", "silent " + worker.silent + " s", "state bad");
  if (worker.draining) return element("span", "leaving", "state warn");
  return worker.leases ? element("span", "working", "state RUNNING") : element("span", "idle", "state soft");
}
function nameNode(worker) {
  const node = element("span"), dot = element("span", "\u25a0 ");
  dot.style.color = "hsl(" + hueOf(worker.id) + " 70% 50%)";
  node.append(dot, worker.name);
  node.title = worker.name + (worker.quarantine ? "\n" + worker.quarantine : "");
  return node;
}
const workerTable = new Table(byId("table-workers"), [
  { title: "Worker", width: "minmax(110px, 2fr)", cell: nameNode, value: (worker) => worker.name },
  { title: "State", width: "88px", cell: workerState, value: (worker) => (worker.quarantine ? 0 : worker.silent ? 1 : worker.leases ? 3 : 2) },
  { title: "Threads", width: "60px", num: true, cell: (worker) => String(worker.threads), value: (worker) => worker.threads },
  { title: "ISA", width: "64px", wide: true, cell: (worker) => worker.isa, value: (worker) => worker.isa },
  { title: "Units/min", width: "76px", num: true, cell: (worker) => worker.rate === undefined ? "" : worker.rate.toFixed(1), value: (worker) => worker.rate || 0 },
  { title: "Units", width: "68px", num: true, wide: true, cell: (worker) => String(worker.done), value: (worker) => worker.done },
  { title: "Slow", width: "52px", num: true, wide: true, cell: (worker) => worker.slowness > 1.4 ? "x" + worker.slowness : "", value: (worker) => worker.slowness },
  { title: "Memory", width: "76px", num: true, wide: true, cell: (worker) => worker.memory ? worker.memory + " MB" : "", value: (worker) => worker.memory },
  { title: "Failed", width: "56px", num: true, wide: true, cell: (worker) => worker.failures ? String(worker.failures) : "", value: (worker) => worker.failures },
  { title: "In hand", width: "minmax(90px, 1.5fr)", wide: true, cell: (worker) => worker.jobs.map((job) => job.leases + " of " + (job.name || job.id || "another user's job")).join(", "), value: (worker) => worker.leases },
  { title: "Tags", width: "minmax(50px, 100px)", wide: true, cell: (worker) => worker.tags.join(" "), value: (worker) => worker.tags.join(" ") },
], { empty: "No workers: tessera-worker --server HOST:PORT" });

const logTable = new Table(byId("table-events"), [
  { title: "Time", width: "76px", cell: (line) => timeOf(line.time) },
  { title: "", width: "58px", cell: (line) => element("span", line.level, line.level === "info" ? "soft" : line.level === "warning" ? "warn" : "bad") },
  { title: "Event", width: "minmax(200px, 1fr)", cell: (line) => line.message },
], { height: 28, sort: -1, open: (line) => { if (jobs.has(line.job)) location.hash = "#/job/" + line.job; }, empty: "Nothing happened yet." });
let lines = 0;

// ---- news

function openStream() {
  const params = new URLSearchParams();
  if (page === "workers" || page === "job") params.set("workers", "1");
  if (page === "events") params.set("log", "1");
  if (page === "job" && shownJob) { params.set("job", shownJob); params.set("layer", byId("layer").value || "color"); }
  const key = params.toString();
  if (stream && stream.readyState !== EventSource.CLOSED && key === streamKey) return;
  if (stream) stream.close();
  streamKey = key;
  stream = new EventSource("api/events?" + key);
  stream.addEventListener("jobs", (event) => take(event, jobs, jobTable, jobsChanged));
  stream.addEventListener("workers", (event) => take(event, workers, workerTable, workersChanged, withRate));
  stream.addEventListener("log", (event) => {
    heard();
    for (const line of JSON.parse(event.data).lines) logTable.set(Object.assign(line, { id: ++lines, text: line.message }));
    while (logTable.rows.size > 5000) logTable.rows.delete(logTable.rows.keys().next().value);
    if (byId("follow").checked) setTimeout(() => { byId("table-events").scrollTop = 1e9; }, 60);
  });
  stream.addEventListener("picture", (event) => { heard(); pictureNews(viewer.source, JSON.parse(event.data), true); });
  stream.addEventListener("end", () => { stream.close(); show("login"); });
  if (page === "events") { logTable.clear(); lines = 0; }
  stream.onopen = heard;
  const opened = stream;
  stream.onerror = () => {
    byId("link").textContent = "connection lost";
    byId("link").className = "lost";
    if (opened.readyState === EventSource.CLOSED && opened === stream) {
      setTimeout(() => { if (opened === stream) { ask("me").then(() => { streamKey = ""; openStream(); }).catch(() => opened.onerror()); } }, 2000);
    }
  };
}
function heard() {
  lastWord = Date.now();
  byId("link").textContent = "live";
  byId("link").className = "";
}
function take(event, known, table, changed, prepare) {
  heard();
  const news = JSON.parse(event.data);
  if (news.all) take.fresh = new Set();
  for (const row of news.rows) {
    if (take.fresh) take.fresh.add(row.id);
    if (prepare) prepare(row, known.get(row.id));
    known.set(row.id, row);
    table.set(row);
  }
  for (const id of news.gone) { known.delete(id); table.remove(id); }
  if (take.fresh && !news.more) {
    for (const id of [...known.keys()]) if (!take.fresh.has(id)) { known.delete(id); table.remove(id); }
    take.fresh = null;
  }
  changed();
}
/// Units a minute over the last half minute or so.
function withRate(worker, before) {
  const past = before && before.past ? before.past : [];
  past.push([Date.now(), worker.done]);
  while (past.length > 2 && past[0][0] < Date.now() - 30000) past.shift();
  const span = (past[past.length - 1][0] - past[0][0]) / 60000;
  if (span > 0) worker.rate = (past[past.length - 1][1] - past[0][1]) / span;
  Object.defineProperty(worker, "past", { value: past, enumerable: false });
}
function soon(what, delay) {
  let timer = 0;
  return () => { if (!timer) timer = setTimeout(() => { timer = 0; what(); }, delay); };
}
const jobsChanged = soon(() => {
  let open = 0, faults = 0;
  for (const job of jobs.values()) { open += kOver.has(job.state) ? 0 : 1; faults += job.aside > 0 || job.state === "FAILED" || job.failures > 0 ? 1 : 0; }
  byId("count-jobs").textContent = open || "";
  byId("count-faults").textContent = faults || "";
  if (page === "job") drawJob();
  if (page === "faults") drawFaults();
}, 50);
const workersChanged = soon(() => {
  let threads = 0, busy = 0, rate = 0, silent = 0;
  for (const worker of workers.values()) { threads += worker.threads; busy += worker.leases > 0; silent += worker.silent > 0; rate += worker.rate || 0; }
  byId("count-workers").textContent = workers.size || "";
  byId("sum-workers").textContent = workers.size + " workers, " + threads + " threads, " + busy + " at work" + (silent ? ", " + silent + " silent" : "") + ", " + rate.toFixed(0) + " units a minute";
}, 100);

// ---- one job

const viewer = new Viewer(byId("stage"));
const strip = new Strip(byId("frames"), jobs);

function pictureNews(source, news, first) {
  if (!source) return;
  if (news.all) source.invalidateAll();
  for (let i = 0; news.areas && i < news.areas.length; i += 4) source.invalidate(...news.areas.slice(i, i + 4));
  if (first && news.work) viewer.setWork(news.work);
}

async function detailsOf(id) {
  const answer = await ask("job?" + new URLSearchParams({ id }));
  details.set(id, answer);
  return answer;
}
async function openJob(id) {
  // Commands print beginnings of ids.
  const full = [...jobs.keys()].find((known) => known.startsWith(id)) || id;
  shownJob = full;
  try {
    const found = await detailsOf(full);
    if (shownJob !== full) return;
    const layer = byId("layer"), before = layer.value;
    layer.replaceChildren(...found.settings.layers.map((known) => Object.assign(element("option", known.name), { value: known.name })));
    layer.value = found.settings.layers.some((known) => known.name === before) ? before : found.settings.layers[0].name;
    byId("other").value = "";
    showLayer();
    listOthers();
    drawJob();
  } catch (error) { tell(error.message); }
}
async function showLayer() {
  const found = details.get(shownJob);
  if (!found) return;
  const name = byId("layer").value, color = found.settings.layers.find((known) => known.name === name).color;
  byId("channel").disabled = byId("tone").disabled = !color;
  const source = new FrameSource(shownJob, found.settings, name, () => viewer.changed());
  let other = null;
  if (otherStream) { otherStream.close(); otherStream = null; }
  const compared = byId("other").value;
  if (compared) {
    try {
      const settings = (await detailsOf(compared)).settings;
      other = new FrameSource(compared, settings, settings.layers.some((known) => known.name === name) ? name : settings.layers[0].name, () => viewer.changed());
      otherStream = new EventSource("api/events?" + new URLSearchParams({ job: compared, layer: other.layer }));
      otherStream.addEventListener("picture", (event) => pictureNews(other, JSON.parse(event.data), false));
    } catch (error) { tell(error.message); }
  }
  viewer.setWork([]);
  viewer.show(source, other);
  openStream();
}
function listOthers() {
  const select = byId("other"), before = select.value;
  const rows = [...jobs.values()].filter((job) => job.id !== shownJob).sort((a, b) => b.submitted - a.submitted).slice(0, 100);
  select.replaceChildren(Object.assign(element("option", "nothing"), { value: "" }),
    ...rows.map((job) => Object.assign(element("option", (job.name || "job") + " " + job.id.slice(0, 8)), { value: job.id })));
  select.value = before;
}
const refreshDetails = soon(() => { if (page === "job" && shownJob) detailsOf(shownJob).then(drawFacts).catch(() => {}); }, 1000);

function drawJob() {
  const job = jobs.get(shownJob);
  if (!job) return;
  byId("job-name").textContent = job.name || job.id;
  document.title = percent(job) + " " + (job.name || job.id) + " - Tessera";
  byId("job-state").replaceWith(Object.assign(stateNode(job), { id: "job-state" }));
  byId("job-progress").firstElementChild.style.width = 100 * job.done / Math.max(1, job.total) + "%";
  drawLine(job);
  strip.show(job, (details.get(shownJob) || {}).settings);
  const over = kOver.has(job.state), actions = byId("job-actions"), key = [job.state, job.paused, job.priority, job.aside > 0].join();
  if (actions.dataset.key !== key + shownJob) {
    actions.dataset.key = key + shownJob;
    const button = (title, path, body, enabled) => {
      const made = element("button", title);
      made.disabled = !enabled;
      made.addEventListener("click", () => act(path, Object.assign({ id: shownJob }, body)));
      return made;
    };
    const cancel = element("button", "Cancel");
    cancel.disabled = over;
    cancel.addEventListener("click", () => {
      // The second click is meant.
      if (cancel.dataset.sure) act("cancel", { id: shownJob });
      cancel.dataset.sure = "1";
      cancel.textContent = "Really cancel?";
      setTimeout(() => { delete cancel.dataset.sure; cancel.textContent = "Cancel"; }, 4000);
    });
    const label = element("label", "Priority "), priority = element("input");
    priority.type = "number";
    priority.value = job.priority;
    priority.disabled = over;
    priority.addEventListener("change", () => act("priority", { id: shownJob, priority: Math.round(Number(priority.value)) }));
    label.append(priority);
    actions.replaceChildren(label, job.paused ? button("Resume", "resume", {}, !over) : button("Pause", "pause", {}, !over),
      button("Retry", "retry", {}, job.state === "INCOMPLETE" || job.aside > 0), cancel);
  }
  refreshDetails();
}
function drawLine(job) {
  const left = leftOf(job), parts = [percent(job), job.done + " of " + job.total + " units", kOver.has(job.state) ? "took " + elapsed(job) : "for " + elapsed(job)];
  if (left) parts.push(left + (job.left ? " left" : ""));
  if (job.workers) parts.push(job.workers + (job.workers === 1 ? " worker" : " workers"));
  if (job.aside) parts.push(job.aside + " units set aside");
  if (job.error) parts.push(job.error);
  byId("job-line").textContent = parts.join(" \u00b7 ");
}
function facts(pairs) {
  const list = element("dl");
  for (const [name, value] of pairs) if (value !== "" && value !== undefined && value !== 0) list.append(element("dt", name), element("dd", String(value)));
  return list;
}
function textList(title, texts) {
  if (!texts.length) return [];
  const list = element("ul");
  for (const text of texts) list.append(element("li", text));
  return [element("h2", title), list];
}
function failureText(failure) { return (failure.unit !== undefined ? "unit " + failure.unit + ", " : "") + failure.host + (failure.lost ? " was lost: " : ": ") + failure.message; }
function drawFacts() {
  const found = details.get(shownJob), job = jobs.get(shownJob);
  if (!found || !job) return;
  const s = found.settings, whole = s.crop[0] === 0 && s.crop[1] === 0 && s.crop[2] === s.width && s.crop[3] === s.height;
  byId("facts").replaceChildren(element("h2", "Job"), facts([
    ["Id", job.id], ["User", job.user], ["Size", s.width + " x " + s.height], ["Crop", whole ? "" : s.crop.join(", ")],
    ["Samples", s.spp + (s.noise ? " at most, noise " + s.noise : "")], ["Taken", found.samples ? found.samples.toLocaleString("en") : ""], ["Integrator", s.integrator],
    ["Core-hours", coreHours(job.cpu)], ["Submitted", new Date(job.submitted).toLocaleString()], ["Priority", String(job.priority)],
    ["Tags", s.tags.join(" ")], ["Adopted", found.adopted ? found.adopted + " units of " + found.adopted_from : ""], ["Waiting", found.waiting],
  ]), ...textList("Set aside", found.aside.map((unit) => "unit " + unit.unit + (unit.pixels ? ", pixels " + unit.pixels.join(" ") : "") + ": " + unit.failures.map(failureText).join("; "))),
  ...textList("Latest failures", found.latest.map(failureText).reverse()), ...textList("Slow hosts", found.slow.map((host) => host.host + ", x" + host.slowness)),
  ...textList("Notes", found.notes.concat(found.left_out ? [found.left_out] : [])), ...textList("Warnings", found.warnings));
}

// ---- faults

const drawFaults = soon(async () => {
  const bad = [...jobs.values()].filter((job) => job.aside > 0 || job.failures > 0 || job.state === "FAILED").sort((a, b) => b.submitted - a.submitted).slice(0, 50);
  const boxes = await Promise.all(bad.map(async (job) => {
    const found = await detailsOf(job.id).catch(() => null);
    const box = element("div", undefined, "fault"), title = element("a", job.name || job.id);
    title.href = "#/job/" + job.id;
    box.append(title, " ", stateNode(job), " ", element("span", job.aside + " units set aside, " + job.failures + " failures", "sum"));
    if (job.error) box.append(element("pre", job.error));
    if (found) {
      const text = found.aside.flatMap((unit) => unit.failures.map((failure) => failureText(Object.assign({ unit: unit.unit }, failure))))
        .concat(found.latest.map(failureText)).join("\n");
      if (text) box.append(element("pre", text));
    }
    if (job.state === "INCOMPLETE" || job.aside > 0) {
      const retry = element("button", "Retry");
      retry.addEventListener("click", () => act("retry", { id: job.id }));
      box.append(retry);
    }
    return box;
  }));
  if (page === "faults") byId("list-faults").replaceChildren(...(boxes.length ? boxes : [element("p", "No unit failed, and none is set aside.", "soft")]));
}, 300);

// ---- pages

function show(next) {
  page = next;
  for (const section of document.querySelectorAll(".page")) section.hidden = section.id !== "page-" + next;
  for (const tab of document.querySelectorAll("#tabs a"))
    tab.dataset.page === next || (next === "job" && tab.dataset.page === "jobs") ? tab.setAttribute("aria-current", "page") : tab.removeAttribute("aria-current");
  if (next !== "job") document.title = next === "login" ? "Tessera" : next[0].toUpperCase() + next.slice(1) + " - Tessera";
  if (next === "login" && stream) { stream.close(); stream = null; }
}
function route() {
  if (!me) return;
  const [, name, id] = location.hash.split("/");
  const next = name === "job" && id ? "job" : ["workers", "faults", "events"].includes(name) ? name : "jobs";
  show(next);
  if (next !== "job") {
    shownJob = "";
    if (otherStream) { otherStream.close(); otherStream = null; }
    viewer.show(null, null);
    openStream();
  } else if (id !== shownJob) {
    openJob(decodeURIComponent(id));
  }
  if (next === "faults") drawFaults();
}
async function start() {
  const token = /^#login=([0-9a-f]+)$/.exec(location.hash);
  if (token) {
    history.replaceState(null, "", location.pathname);
    try { await ask("login", { token: token[1] }); } catch (error) { tell(error.message); }
  }
  try {
    me = await ask("me");
  } catch (error) {
    if (error.message) { tell(error.message); setTimeout(start, 2000); }
    return;
  }
  clockOffset = me.time - Date.now();
  byId("version").textContent = me.version;
  byId("who").hidden = !me.login;
  document.querySelector("[data-page=events]").hidden = !me.log;
  byId("who").textContent = me.login ? me.user + ": log out" : "";
  route();
}

addEventListener("hashchange", () => location.hash.startsWith("#login=") ? start() : route());
byId("login").addEventListener("submit", async (event) => {
  event.preventDefault();
  try { await ask("login", { token: byId("token").value.trim().replace(/.*#login=/, "") }); byId("token").value = ""; start(); } catch (error) { tell(error.message); }
});
byId("who").addEventListener("click", () => act("logout", {}).then(() => { me = null; show("login"); }));
for (const [field, table] of [["find-jobs", jobTable], ["find-workers", workerTable], ["find-events", logTable]])
  byId(field).addEventListener("input", (event) => table.find(event.target.value));
byId("layer").addEventListener("change", showLayer);
byId("other").addEventListener("change", showLayer);
byId("other").addEventListener("focus", listOthers);
byId("channel").addEventListener("change", (event) => viewer.setLook({ channel: Number(event.target.value) }));
byId("tone").addEventListener("change", (event) => viewer.setLook({ curve: Number(event.target.value) }));
byId("exposure").addEventListener("input", (event) => { byId("exposure-out").textContent = event.target.value; viewer.setLook({ exposure: Number(event.target.value) }); });
byId("exposure").addEventListener("dblclick", (event) => { event.target.value = 0; event.target.dispatchEvent(new Event("input")); });
byId("outlines").addEventListener("change", (event) => { viewer.outlines = event.target.checked; viewer.changed(); });
byId("fit").addEventListener("click", () => viewer.fit());
byId("one").addEventListener("click", () => viewer.zoomTo(1));
addEventListener("keydown", (event) => {
  if (event.ctrlKey || event.altKey || event.metaKey || /^(INPUT|SELECT|TEXTAREA)$/.test(event.target.tagName)) return;
  const target = { j: "jobs", w: "workers", f: "faults", e: "events" }[event.key];
  if (target) location.hash = "#/" + target;
  else if (event.key === "/") { const field = byId("find-" + page); if (field) { event.preventDefault(); field.focus(); } }
  else if (event.key === "Escape" && page === "job") location.hash = "#/jobs";
});
setInterval(() => { const job = jobs.get(shownJob); if (page === "job" && job && !kOver.has(job.state)) drawLine(job); }, 1000);
start();
