// News of the coordinator: one stream of events for what the page shows.
"use strict";

const news = { stream: null, key: "" };

/// The stream for this page; the open one, where it is for the same.
function openStream() {
  const params = new URLSearchParams();
  if (page === "workers" || page === "job") params.set("workers", "1");
  if (page === "events") params.set("log", "1");
  if (page === "job" && shownJob) {
    params.set("job", shownJob);
    params.set("layer", byId("layer").value || "color");
  }
  const key = params.toString();
  if (news.stream && news.stream.readyState !== EventSource.CLOSED && key === news.key) return;
  closeStream();
  news.key = key;
  if (page === "events") {
    logTable.clear();
    lines = 0;
  }
  const stream = news.stream = new EventSource("api/events?" + key);
  const on = (event, then) => stream.addEventListener(event, (message) => {
    heard();
    then(JSON.parse(message.data));
  });
  on("jobs", (rows) => take(rows, jobs, jobTable, jobsChanged));
  on("workers", (rows) => take(rows, workers, workerTable, workersChanged, withRate));
  on("log", (added) => addLines(added.lines));
  on("picture", (changes) => pictureNews(viewer.source, changes, true));
  on("end", () => show("login"));
  stream.onopen = heard;
  stream.onerror = () => lost(stream);
}
function closeStream() {
  if (news.stream) news.stream.close();
  news.stream = null;
}

/// Browsers try again by themselves, but not where the answer was a refusal.
function lost(stream) {
  byId("link").textContent = "connection lost";
  byId("link").className = "lost";
  if (stream.readyState !== EventSource.CLOSED || stream !== news.stream) return;
  setTimeout(() => {
    if (stream === news.stream) ask("me").then(openStream).catch(() => lost(stream));
  }, 2000);
}
function heard() {
  byId("link").textContent = "live";
  byId("link").className = "";
}

/// Takes changed rows into `known` and its table. After `all`, rows that do not come any more are gone.
function take(changes, known, table, changed, prepare) {
  if (changes.all) take.fresh = new Set();
  for (const row of changes.rows) {
    if (take.fresh) take.fresh.add(row.id);
    if (prepare) prepare(row, known.get(row.id));
    known.set(row.id, row);
    table.set(row);
  }
  const forget = (id) => {
    known.delete(id);
    table.remove(id);
  };
  changes.gone.forEach(forget);
  if (take.fresh && !changes.more) {
    [...known.keys()].filter((id) => !take.fresh.has(id)).forEach(forget);
    take.fresh = null;
  }
  changed();
}
