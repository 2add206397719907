// One job: its picture, what it is, and what can be done with it.
"use strict";

const details = new Map(); // of jobs that were looked at, by id
let shownJob = "", otherStream = null;
const viewer = new Viewer(byId("stage"));
const strip = new Strip(byId("frames"), jobs);

/// Areas of the picture that changed; where it is the first of two, also what is in work.
function pictureNews(source, changes, first) {
  if (!source) return;
  if (changes.all) source.invalidateAll();
  const areas = changes.areas || [];
  for (let i = 0; i < areas.length; i += 4) source.invalidate(...areas.slice(i, i + 4));
  if (first && changes.work) viewer.setWork(changes.work);
}

async function detailsOf(id) {
  const answer = await ask("job?" + new URLSearchParams({ id }));
  details.set(id, answer);
  return answer;
}
const option = (text, value) => Object.assign(element("option", text), { value });

async function openJob(id) {
  // Commands print beginnings of ids.
  const full = [...jobs.keys()].find((known) => known.startsWith(id)) || id;
  shownJob = full;
  try {
    const found = await detailsOf(full);
    if (shownJob !== full) return;
    const layer = byId("layer"), before = layer.value, known = found.settings.layers;
    layer.replaceChildren(...known.map(({ name }) => option(name, name)));
    layer.value = known.some(({ name }) => name === before) ? before : known[0].name;
    byId("other").value = "";
    showLayer();
    listOthers();
    drawJob();
  } catch (error) {
    tell(error.message);
  }
}
function closeJob() {
  shownJob = "";
  if (otherStream) otherStream.close();
  otherStream = null;
  viewer.show(null, null);
}

/// The picture of the job to compare with, in the same layer where it has that.
async function otherSource(id, name) {
  const settings = (await detailsOf(id)).settings;
  const layer = (settings.layers.find((known) => known.name === name) || settings.layers[0]).name;
  const other = new FrameSource(id, settings, layer, () => viewer.changed());
  otherStream = new EventSource("api/events?" + new URLSearchParams({ job: id, layer }));
  otherStream.addEventListener("picture", (event) => pictureNews(other, JSON.parse(event.data), false));
  return other;
}
async function showLayer() {
  const found = details.get(shownJob);
  if (!found) return;
  const name = byId("layer").value, layer = found.settings.layers.find((known) => known.name === name);
  byId("channel").disabled = byId("tone").disabled = !layer.color;
  byId("layer-about").textContent = layer.about;
  const source = new FrameSource(shownJob, found.settings, name, () => viewer.changed());
  if (otherStream) otherStream.close();
  otherStream = null;
  const compared = byId("other").value;
  const other = compared ? await otherSource(compared, name).catch((error) => tell(error.message)) : null;
  viewer.setWork([]);
  viewer.show(source, other || null);
  openStream();
}
function listOthers() {
  const select = byId("other"), before = select.value;
  const rows = [...jobs.values()].filter((job) => job.id !== shownJob);
  rows.sort((a, b) => b.submitted - a.submitted);
  select.replaceChildren(option("nothing", ""),
    ...rows.slice(0, 100).map((job) => option((job.name || "job") + " " + job.id.slice(0, 8), job.id)));
  select.value = before;
}

// ---- what can be done

function actionButton(title, path, enabled) {
  const made = element("button", title);
  made.disabled = !enabled;
  made.addEventListener("click", () => act(path, { id: shownJob }));
  return made;
}
function cancelButton(enabled) {
  const cancel = element("button", "Cancel");
  cancel.disabled = !enabled;
  cancel.addEventListener("click", () => {
    // The second click is meant.
    if (cancel.dataset.sure) act("cancel", { id: shownJob });
    cancel.dataset.sure = "1";
    cancel.textContent = "Really cancel?";
    setTimeout(() => {
      delete cancel.dataset.sure;
      cancel.textContent = "Cancel";
    }, 4000);
  });
  return cancel;
}
function priorityField(job, enabled) {
  const label = element("label", "Priority "), field = element("input");
  field.type = "number";
  field.value = job.priority;
  field.disabled = !enabled;
  const change = () => act("priority", { id: shownJob, priority: Math.round(Number(field.value)) });
  field.addEventListener("change", change);
  label.append(field);
  return label;
}
function drawActions(job) {
  const open = !kOver.has(job.state), actions = byId("job-actions");
  const key = [shownJob, job.state, job.paused, job.priority, job.aside > 0].join();
  if (actions.dataset.key === key) return;
  actions.dataset.key = key;
  actions.replaceChildren(priorityField(job, open),
    job.paused ? actionButton("Resume", "resume", open) : actionButton("Pause", "pause", open),
    actionButton("Retry", "retry", job.state === "INCOMPLETE" || job.aside > 0), cancelButton(open));
}

// ---- what it is

const refreshDetails = soon(() => {
  if (page === "job" && shownJob) detailsOf(shownJob).then(drawFacts).catch(() => {});
}, 1000);

function drawJob() {
  const job = jobs.get(shownJob);
  if (!job) return;
  byId("job-name").textContent = job.name || job.id;
  document.title = percent(job) + " " + (job.name || job.id) + " - Tessera";
  byId("job-state").replaceWith(Object.assign(stateNode(job), { id: "job-state" }));
  byId("job-progress").firstElementChild.style.width = 100 * shareOf(job) + "%";
  drawLine(job);
  strip.show(job, (details.get(shownJob) || {}).settings);
  drawActions(job);
  refreshDetails();
}
function drawLine(job) {
  const left = leftOf(job), parts = [percent(job), job.done + " of " + job.total + " units"];
  parts.push((kOver.has(job.state) ? "took " : "for ") + elapsed(job));
  if (left) parts.push(left + (job.left ? " left" : ""));
  if (job.workers) parts.push(job.workers + (job.workers === 1 ? " worker" : " workers"));
  if (job.aside) parts.push(job.aside + " units set aside");
  if (job.error) parts.push(job.error);
  byId("job-line").textContent = parts.join(" \u00b7 ");
}
function facts(pairs) {
  const list = element("dl");
  for (const [name, value] of pairs) {
    if (value !== "" && value !== undefined && value !== 0)
      list.append(element("dt", name), element("dd", String(value)));
  }
  return list;
}
function textList(title, texts) {
  if (!texts.length) return [];
  const list = element("ul");
  for (const text of texts) list.append(element("li", text));
  return [element("h2", title), list];
}
function asideText(unit) {
  const where = unit.pixels ? ", pixels " + unit.pixels.join(" ") : "";
  return "unit " + unit.unit + where + ": " + unit.failures.map(failureText).join("; ");
}
function drawFacts() {
  const found = details.get(shownJob), job = jobs.get(shownJob);
  if (!found || !job) return;
  const s = found.settings;
  const whole = s.crop[0] === 0 && s.crop[1] === 0 && s.crop[2] === s.width && s.crop[3] === s.height;
  byId("facts").replaceChildren(
    element("h2", "Job"),
    facts([
      ["Id", job.id],
      ["User", job.user],
      ["Size", s.width + " x " + s.height],
      ["Crop", whole ? "" : s.crop.join(", ")],
      ["Samples", s.spp + (s.noise ? " at most, noise " + s.noise : "")],
      ["Taken", found.samples ? found.samples.toLocaleString("en") : ""],
      ["Integrator", s.integrator],
      ["Core-hours", coreHours(job.cpu)],
      ["Submitted", new Date(job.submitted).toLocaleString()],
      ["Priority", String(job.priority)],
      ["Tags", s.tags.join(" ")],
      ["Adopted", found.adopted ? found.adopted + " units of " + found.adopted_from : ""],
      ["Waiting", found.waiting],
    ]),
    ...textList("Set aside", found.aside.map(asideText)),
    ...textList("Latest failures", found.latest.map(failureText).reverse()),
    ...textList("Slow hosts", found.slow.map((host) => host.host + ", x" + host.slowness)),
    ...textList("Notes", found.notes.concat(found.left_out ? [found.left_out] : [])),
    ...textList("Warnings", found.warnings));
}
