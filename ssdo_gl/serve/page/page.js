// Shows the pictures that the server sends, and tells it what keys, mouse and panel do.
"use strict";

// As in page_events.py: the server refuses more.
const MAX_SIDE_PX = 8192;
const IS_LOSSLESS = 1;
const DIVIDER_REACH_PX = 6;
// The browser's own, even over the picture: reloading is a new visit.
const BROWSER_KEYS = [["F5", false], ["F11", false], ["KeyT", true], ["KeyW", true],
  ["KeyN", true], ["KeyL", true]];

const $ = (id) => document.getElementById(id);
const picture = $("picture"), paper = picture.getContext("2d", { alpha: false });
let socket = null, state = {}, lossless = null, cursor = { x: 0, y: 0 };

function tell(type, fields) {
  if (socket?.readyState === WebSocket.OPEN) socket.send(JSON.stringify({ type, ...fields }));
}

// --- pictures -------------------------------------------------------------------------

let drawing = Promise.resolve();

async function show(buffer) {
  const header = new DataView(buffer), frame = header.getUint32(0);
  const isLossless = (header.getUint32(4) & IS_LOSSLESS) !== 0;
  const file = new Blob([new Uint8Array(buffer, 8)], { type: isLossless ? "image/png" : "image/jpeg" });
  const bitmap = await createImageBitmap(file, { colorSpaceConversion: "none" });
  const { width, height } = wanted;
  if (picture.width !== width || picture.height !== height) {
    picture.width = width;
    picture.height = height;
  }
  paper.drawImage(bitmap, 0, 0, picture.width, picture.height);
  bitmap.close();
  lossless = isLossless ? file : null;
  picture.dataset.lossless = isLossless;
  picture.dataset.frame = frame;
  // Nobody sees it: nothing more has to be drawn for now.
  while (document.hidden) await new Promise((seen) => addEventListener("visibilitychange", seen, { once: true, capture: true }));
  tell("ack", { frame });
}

// --- size ------------------------------------------------------------------------------

let wanted = { width: 1, height: 1 };

function measure(entry) {
  const scale = devicePixelRatio || 1, box = $("place").getBoundingClientRect();
  const exact = entry?.devicePixelContentBoxSize?.[0];
  let width = exact?.inlineSize ?? Math.round(box.width * scale);
  let height = exact?.blockSize ?? Math.round(box.height * scale);
  const fit = Math.min(1, Math.sqrt(MAX_PIXELS / (width * height)), MAX_SIDE_PX / Math.max(width, height));
  if (fit < 1) [width, height] = [Math.floor(width * fit), Math.floor(height * fit)];
  if (width < 1 || height < 1) return;
  wanted = { width, height };
  tell("size", { width: width / (scale * fit), height: height / (scale * fit), scale: scale * fit });
}

const observer = new ResizeObserver((entries) => measure(entries[0]));
try {
  observer.observe($("place"), { box: "device-pixel-content-box" });
} catch {
  observer.observe($("place"));
}

// --- keys and mouse --------------------------------------------------------------------

function place(event) {
  const box = picture.getBoundingClientRect();
  if (document.pointerLockElement === picture) {
    cursor = { x: cursor.x + event.movementX, y: cursor.y + event.movementY };
  } else {
    cursor = { x: event.clientX - box.left, y: event.clientY - box.top };
  }
  return cursor;
}

function tap(code, modifiers = 0) {
  for (const down of [true, false]) tell("key", { code, down, repeat: false, mods: modifiers });
}

tellOfMouse(picture, tell, place);
picture.addEventListener("pointermove", () => {
  const atDivider = state.split && Math.abs(cursor.x - state.divider * picture.clientWidth) <= DIVIDER_REACH_PX;
  picture.classList.toggle("at-divider", Boolean(atDivider));
});

const OWN_KEYS = {
  Tab: () => togglePanel(),
  KeyH: () => toggleHelp(),
  F1: () => toggleHelp(),
  F12: () => save(),
  KeyM: () => (document.pointerLockElement ? document.exitPointerLock() : picture.requestPointerLock()),
};

function isElsewhere(event) {
  return event.target.closest?.("select, input, dialog") || (event.code === "Space" && event.target.closest?.("button"));
}

addEventListener("keydown", (event) => {
  if (isElsewhere(event) && event.code !== "Tab") return;
  if (BROWSER_KEYS.some(([code, ctrl]) => code === event.code && ctrl === event.ctrlKey)) return;
  if (event.metaKey || (event.ctrlKey && event.code === "KeyC" && getSelection().toString())) return;
  const own = mods(event) === 0 && OWN_KEYS[event.code];
  if (own) {
    if (!event.repeat) own();
  } else {
    tell("key", { code: event.code, down: true, repeat: event.repeat, mods: mods(event) });
  }
  event.preventDefault();
});
addEventListener("keyup", (event) => tell("key", { code: event.code, down: false, repeat: false, mods: mods(event) }));
addEventListener("blur", () => tell("focus", { has: false }));
addEventListener("focus", () => tell("focus", { has: true }));
document.addEventListener("pointerlockchange", () => {
  const isLocked = document.pointerLockElement === picture;
  // The browser's Esc ends it, too, and tells no key.
  tap(isLocked ? "KeyM" : "Escape");
});

// --- panel -----------------------------------------------------------------------------

function togglePanel(shows = $("panel").hidden) {
  $("panel").hidden = !shows;
  $("open-panel").hidden = shows;
  picture.focus();
}

function toggleHelp() {
  if ($("help").open) $("help").close();
  else $("help").showModal();
}

function save() {
  if (!lossless) return say("wait for the picture to come to rest");
  const link = document.createElement("a");
  link.href = URL.createObjectURL(lossless);
  link.download = `${$("title").textContent || "picture"}.png`;
  link.click();
  setTimeout(() => URL.revokeObjectURL(link.href), 1000);
}

function say(text) {
  showLines([...(state.messages ?? []), { text, is_fault: false }]);
}

function showLines(messages) {
  $("lines").replaceChildren(...messages.map(({ text, is_fault }) => {
    const line = document.createElement("p");
    line.textContent = text;
    line.className = is_fault ? "fault" : "";
    return line;
  }));
}

function fill(select, entries) {
  select.replaceChildren(...entries.map(([value, text]) => new Option(text, value)));
}

function offer(choices) {
  document.title = `${choices.title} - ssdo_gl`;
  $("title").textContent = choices.title;
  fill($("method"), Object.entries(choices.methods));
  fill($("other_method"), Object.entries(choices.methods));
  fill($("aov"), choices.aovs.map((name) => [name, name]));
  $("presets").replaceChildren(...choices.presets.map((name) => {
    const button = document.createElement("button");
    button.type = "button";
    button.textContent = name;
    button.addEventListener("click", () => choose("preset", name));
    return button;
  }));
  $("keys").replaceChildren(...Object.entries(choices.help).map(([title, rows]) => {
    const section = document.createElement("section"), list = document.createElement("dl");
    const heading = document.createElement("h2");
    heading.textContent = title;
    for (const [keys, meaning] of rows) {
      const term = document.createElement("dt"), text = document.createElement("dd");
      term.textContent = keys;
      text.textContent = meaning;
      list.append(term, text);
    }
    section.append(heading, list);
    return section;
  }));
}

function choose(what, value) {
  tell("choose", { what, value });
  picture.focus();
}

function update(next) {
  state = next;
  for (const name of ["method", "other_method", "aov"]) {
    if (document.activeElement !== $(name)) $(name).value = state[name];
  }
  for (const name of ["split", "error"]) $(name).setAttribute("aria-pressed", state[name]);
  for (const name of ["governed", "shared_camera"]) $(name).checked = state[name];
  if (document.activeElement !== $("exposure")) $("exposure").value = state.exposure;
  $("exposure-value").textContent = `${state.exposure >= 0 ? "+" : ""}${state.exposure.toFixed(1)} EV`;
  picture.classList.toggle("looking", state.looking);
  const parts = [state.resting ? "at rest, lossless" : state.scale < 1 ? `in motion, at ${Math.round(100 * state.scale)} %` : "refining"];
  if (state.samples.length) parts.push(`${state.samples.map(([count, all]) => `${count} of ${all}`).join(" and ")} samples`);
  if (state.frame_ms) parts.push(`${state.frame_ms.toFixed(1)} ms a frame`);
  if (state.relative_error != null) parts.push(`error ${(100 * state.relative_error).toFixed(2)} %`);
  if (state.fault) parts.push(state.fault);
  $("status").textContent = parts.join(" · ");
  showLines(state.messages);
}

for (const name of ["method", "other_method", "aov"]) {
  $(name).addEventListener("change", (event) => choose(name, event.target.value));
}
for (const name of ["split", "error"]) $(name).addEventListener("click", () => choose(name, !state[name]));
for (const name of ["governed", "shared_camera"]) {
  $(name).addEventListener("change", (event) => choose(name, event.target.checked));
}
$("exposure").addEventListener("input", (event) => tell("choose", { what: "exposure", value: Number(event.target.value) }));
$("exposure").addEventListener("change", () => picture.focus());
for (const button of document.querySelectorAll("[data-key]")) {
  button.addEventListener("click", () => { tap(button.dataset.key); picture.focus(); });
}
$("save").addEventListener("click", save);
$("open-help").addEventListener("click", toggleHelp);
$("open-panel").addEventListener("click", () => togglePanel(true));
$("close-panel").addEventListener("click", () => togglePanel(false));
$("again").addEventListener("click", connect);
// A click outside of the list, which fills its frame, closes it.
$("help").addEventListener("click", (event) => { if (event.target === $("help")) $("help").close(); });

// --- the server ------------------------------------------------------------------------

const HEARD = {
  state: update,
  choices: offer,
  clipboard: ({ text }) => navigator.clipboard?.writeText(text).catch(() => say(text)) ?? say(text),
};

function connect() {
  const address = new URL("socket", location.href);
  address.protocol = address.protocol.replace("http", "ws");
  $("lost").hidden = true;
  socket = new WebSocket(address);
  socket.binaryType = "arraybuffer";
  socket.addEventListener("open", () => { measure(); picture.focus(); });
  socket.addEventListener("message", ({ data }) => {
    if (typeof data === "string") {
      const heard = JSON.parse(data);
      HEARD[heard.type]?.(heard);
    } else {
      drawing = drawing.then(() => show(data)).catch((error) => say(String(error)));
    }
  });
  socket.addEventListener("close", ({ reason, code }) => {
    $("why").textContent = reason || (code === 1006 ? "the server is not there, or has no room" : "the server has ended");
    $("lost").hidden = false;
  });
}

togglePanel(true);
connect();
