// Units that failed or were set aside, with the last lines of their workers' logs.
"use strict";

const kMostFaults = 50; // jobs, the latest

function failureText(failure) {
  const unit = failure.unit !== undefined ? "unit " + failure.unit + ", " : "";
  return unit + failure.host + (failure.lost ? " was lost: " : ": ") + failure.message;
}

/// A failure, which opens where there is a log.
function failureNode(failure, open) {
  if (!failure.log.length) return element("p", failureText(failure), "failure");
  const node = element("details", undefined, "failure");
  node.dataset.key = failureText(failure) + failure.log[failure.log.length - 1];
  node.open = open.has(node.dataset.key);
  node.append(element("summary", failureText(failure)), element("pre", failure.log.join("\n")));
  return node;
}

/// Failures of a job: those of units that were set aside, and the latest ones of others.
function failuresOf(found) {
  const aside = new Set(found.aside.map((unit) => unit.unit));
  return [
    ...found.aside.flatMap((unit) => unit.failures.map((failure) => ({ unit: unit.unit, ...failure }))),
    ...found.latest.filter((failure) => !aside.has(failure.unit)).reverse(),
  ];
}

function faultBox(job, found, open) {
  const box = element("div", undefined, "fault"), title = element("a", job.name || job.id);
  title.href = "#/job/" + job.id;
  const counts = job.aside + " units set aside, " + job.failures + " failures";
  box.append(title, " ", stateNode(job), " ", element("span", counts, "sum"));
  if (job.error) box.append(element("pre", job.error));
  if (found) box.append(...failuresOf(found).map((failure) => failureNode(failure, open)));
  if (job.state === "INCOMPLETE" || job.aside > 0) {
    const retry = element("button", "Retry");
    retry.addEventListener("click", () => act("retry", { id: job.id }));
    box.append(retry);
  }
  return box;
}

const drawFaults = soon(async () => {
  const bad = [...jobs.values()].filter(hasFaults);
  bad.sort((a, b) => b.submitted - a.submitted).splice(kMostFaults);
  const details = await Promise.all(bad.map((job) => detailsOf(job.id).catch(() => null)));
  if (page !== "faults") return;
  const list = byId("list-faults");
  const open = new Set([...list.querySelectorAll("details[open]")].map((node) => node.dataset.key));
  const boxes = bad.map((job, i) => faultBox(job, details[i], open));
  if (!boxes.length) boxes.push(element("p", "No unit failed, and none is set aside.", "soft"));
  list.replaceChildren(...boxes);
}, 300);
