// The pages: which one is shown, by the address, and what its fields and keys do.
"use strict";

let me = null, page = "";

function show(next) {
  page = next;
  for (const section of document.querySelectorAll(".page")) section.hidden = section.id !== "page-" + next;
  for (const tab of document.querySelectorAll("#tabs a")) {
    const current = tab.dataset.page === (next === "job" ? "jobs" : next);
    current ? tab.setAttribute("aria-current", "page") : tab.removeAttribute("aria-current");
  }
  const title = next === "login" ? "" : next[0].toUpperCase() + next.slice(1) + " - ";
  if (next !== "job") document.title = title + "Tessera";
  if (next === "login") closeStream();
}
function route() {
  if (!me) return;
  const [, name, id] = location.hash.split("/");
  const next = name === "job" && id ? "job" : ["workers", "faults", "events"].includes(name) ? name : "jobs";
  show(next);
  if (next !== "job") {
    closeJob();
    openStream();
  } else if (id !== shownJob) {
    openJob(decodeURIComponent(id));
  }
  if (next === "faults") drawFaults();
}

const logIn = (token) => ask("login", { token }).catch((error) => {
  tell(error.message);
  throw error;
});
async function start() {
  const token = /^#login=([0-9a-f]+)$/.exec(location.hash);
  if (token) {
    history.replaceState(null, "", location.pathname);
    await logIn(token[1]).catch(() => {});
  }
  try {
    me = await ask("me");
  } catch (error) {
    if (!error.message) return;
    tell(error.message);
    setTimeout(start, 2000);
    return;
  }
  clock.offset = me.time - Date.now();
  byId("version").textContent = me.version;
  byId("who").hidden = !me.login;
  document.querySelector("[data-page=events]").hidden = !me.log;
  byId("who").textContent = me.login ? me.user + ": log out" : "";
  route();
}

function on(id, event, then) {
  byId(id).addEventListener(event, (happened) => then(happened.target, happened));
}

addEventListener("hashchange", () => location.hash.startsWith("#login=") ? start() : route());
on("login", "submit", (form, event) => {
  event.preventDefault();
  logIn(byId("token").value.trim().replace(/.*#login=/, "")).then(() => {
    byId("token").value = "";
    start();
  }).catch(() => {});
});
on("who", "click", () => act("logout", {}).then(() => {
  me = null;
  show("login");
}));
for (const [field, table] of [["jobs", jobTable], ["workers", workerTable], ["events", logTable]])
  on("find-" + field, "input", (target) => table.find(target.value));
on("layer", "change", showLayer);
on("other", "change", showLayer);
on("other", "focus", listOthers);
on("channel", "change", (target) => viewer.setLook({ channel: Number(target.value) }));
on("tone", "change", (target) => viewer.setLook({ curve: Number(target.value) }));
on("exposure", "input", (target) => {
  byId("exposure-out").textContent = target.value;
  viewer.setLook({ exposure: Number(target.value) });
});
on("exposure", "dblclick", (target) => {
  target.value = 0;
  target.dispatchEvent(new Event("input"));
});
on("outlines", "change", (target) => {
  viewer.outlines = target.checked;
  viewer.changed();
});
on("fit", "click", () => viewer.fit());
on("one", "click", () => viewer.zoomTo(1));
/// What the arrow keys move: the table or the picture of the page, whether it was clicked before or not. Other
/// things that take keys of their own keep them.
function moved(event) {
  if (event.target.closest(".facts, button, summary") || (event.key === "Enter" && event.target.closest("a")))
    return null;
  return { job: viewer, jobs: jobTable, workers: workerTable, events: logTable }[page];
}
addEventListener("keydown", (event) => {
  const types = /^(INPUT|SELECT|TEXTAREA)$/.test(event.target.tagName);
  if (event.ctrlKey || event.altKey || event.metaKey || types) return;
  const shown = moved(event);
  if (shown) shown.key(event);
  const target = { j: "jobs", w: "workers", f: "faults", e: "events" }[event.key];
  const field = event.key === "/" ? byId("find-" + page) : null;
  if (target) location.hash = "#/" + target;
  else if (event.key === "Escape" && page === "job") location.hash = "#/jobs";
  if (!field) return;
  event.preventDefault();
  field.focus();
});
setInterval(() => {
  const job = jobs.get(shownJob);
  if (page === "job" && job && !kOver.has(job.state)) drawLine(job);
}, 1000);
start();
