// Tools that all parts of the page share: elements, questions to the coordinator, times.
"use strict";

const byId = (id) => document.getElementById(id);

function element(tag, text, className) {
  const made = document.createElement(tag);
  if (text !== undefined) made.textContent = text;
  if (className) made.className = className;
  return made;
}

/// Shows a message for a while; without one, takes it away.
function tell(text) {
  byId("message").textContent = text || "";
  byId("message").hidden = !text;
  clearTimeout(tell.timer);
  if (text) tell.timer = setTimeout(() => tell(""), 8000);
}

/// Asks the coordinator, or with a body tells it. Rejects with its words; without any where it wants a login.
async function ask(path, body) {
  const headers = { "Content-Type": "application/json", "X-Tessera": "1" };
  const sent = body === undefined ? {} : { method: "POST", headers, body: JSON.stringify(body) };
  const response = await fetch("api/" + path, sent);
  const answer = await response.json().catch(() => ({}));
  if (response.ok) return answer;
  if (response.status === 401 && path !== "login") {
    show("login");
    throw new Error("");
  }
  throw new Error(answer.error || "the coordinator answered " + response.status);
}
const act = (path, body) => ask(path, body).catch((error) => tell(error.message));

/// Calls `what` once for all calls within `delay` ms.
function soon(what, delay) {
  let timer = 0;
  return () => {
    if (timer) return;
    timer = setTimeout(() => {
      timer = 0;
      what();
    }, delay);
  };
}

const clock = { offset: 0 }; // ms that the coordinator's clock is ahead of this one
const now = () => Date.now() + clock.offset;
const timeOf = (ms) => new Date(ms).toLocaleTimeString([], { hour12: false });
function dayOrTime(ms) {
  const date = new Date(ms);
  return date.toDateString() === new Date(now()).toDateString() ? timeOf(ms) : date.toLocaleDateString();
}
