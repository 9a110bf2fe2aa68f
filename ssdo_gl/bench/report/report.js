"use strict";
document.documentElement.classList.add("js");
const data = JSON.parse(document.getElementById("data").textContent);
const byId = id => document.getElementById(id);

function card(candidate) { return byId("card-" + candidate.card).content.cloneNode(true); }
function paragraph(text, name) {
  const p = document.createElement("p");
  p.textContent = text;
  if (name) p.className = name;
  return p;
}
// A front is sorted by time, and its errors fall: as in advice.py.
function mostAccurateWithin(front, ms) { return [...front].reverse().find(c => c.ms <= ms) || null; }
function cheapestWithin(front, error) { return front.find(c => c.error <= error) || null; }
const texts = {
  have: "The most accurate within this time:",
  haveNone: "Nothing measured is this fast. The fastest:",
  bear: "The fastest within this error:",
  bearNone: "Nothing measured is this accurate. The most accurate:",
};
function answer(front, asked, bound) {
  const found = (asked === "have" ? mostAccurateWithin : cheapestWithin)(front, bound);
  const shown = found || front[asked === "have" ? 0 : front.length - 1];
  return [paragraph(texts[found ? asked : asked + "None"]), card(shown)];
}
const judge = byId("judge");
function ask(asked) {
  const value = parseFloat(byId(asked).value), box = byId(asked + "-answer");
  const front = data[judge.value].front;
  if (!(value > 0)) { box.replaceChildren(paragraph("A number above 0, please.", "note")); return; }
  if (front.length) box.replaceChildren(...answer(front, asked, asked === "have" ? value : value / 100));
  else box.replaceChildren(paragraph("Nothing was measured.", "note"));
}
function askAll() {
  byId("unit").textContent = data[judge.value].unit;
  ask("have"); ask("bear");
}
if (judge) {
  const folded = [byId("usual"), byId("presets")];
  for (const box of folded) box.open = false;
  addEventListener("beforeprint", () => { for (const box of folded) box.open = true; });
  judge.addEventListener("change", askAll);
  for (const name of ["have", "bear"]) byId(name).addEventListener("input", () => ask(name));
  askAll();
}

document.addEventListener("click", async event => {
  const button = event.target.closest("button.copy");
  if (!button) return;
  const code = button.parentNode.querySelector("code");
  try { await navigator.clipboard.writeText(code.textContent); button.textContent = "Copied"; }
  catch {
    getSelection().selectAllChildren(code);
    button.textContent = document.execCommand("copy") ? "Copied" : "Selected";
  }
  setTimeout(() => { button.textContent = "Copy"; }, 2000);
});

const tip = byId("tip");
function hide() { tip.style.display = "none"; }
for (const dot of document.querySelectorAll(".dot, .bar")) {
  const title = dot.querySelector("title"), text = title.textContent;
  dot.setAttribute("aria-label", text);
  title.remove();
  const show = (x, y) => {
    tip.textContent = text;
    tip.style.display = "block";
    tip.style.left = Math.max(0, Math.min(x + 14, innerWidth - tip.offsetWidth - 8)) + "px";
    tip.style.top = Math.max(0, Math.min(y + 14, innerHeight - tip.offsetHeight - 8)) + "px";
  };
  dot.addEventListener("pointermove", event => show(event.clientX, event.clientY));
  dot.addEventListener("pointerleave", hide);
  dot.addEventListener("focus", () => { const r = dot.getBoundingClientRect(); show(r.right, r.bottom); });
  dot.addEventListener("blur", hide);
  if (!dot.dataset.label) continue;
  dot.addEventListener("click", () => choose(dot.dataset.label));
  dot.addEventListener("keydown", event => {
    if (event.key === "Escape") hide();
    if (event.key === "Enter" || event.key === " ") { event.preventDefault(); choose(dot.dataset.label); }
  });
}

const leftBox = byId("left"), rightBox = byId("right"), flipBox = byId("flip"), slider = byId("edge-slider");
const picture = index => byId("picture-" + index), figure = index => picture(index).parentNode;
function place() {
  const share = slider.value / 10;
  byId("over").style.clipPath = "inset(0 " + (100 - share) + "% 0 0)";
  byId("edge").style.left = share + "%";
}
function refresh() {
  for (const option of rightBox.options) {
    const other = figure(option.value).dataset.group !== figure(leftBox.value).dataset.group;
    option.disabled = other; option.hidden = other;
  }
  if (rightBox.selectedOptions[0].disabled) {
    const first = [...rightBox.options].find(o => !o.disabled && "reference" in figure(o.value).dataset);
    if (first) rightBox.value = first.value;
  }
  const map = flipBox.checked && byId("flip-" + leftBox.value), name = picture(leftBox.value).alt;
  byId("image-over").src = picture(leftBox.value).src;
  byId("image-under").src = map ? map.src : picture(rightBox.value).src;
  byId("name-left").textContent = name;
  byId("name-right").textContent = map ? "FLIP map of " + name : picture(rightBox.value).alt;
  byId("caption").textContent = figure(leftBox.value).querySelector("figcaption").textContent;
  place();
}
// A picture is first seen beside the reference that its FLIP map is against.
function judgeLeft() {
  const against = figure(leftBox.value).dataset.against;
  const reference = [...rightBox.options].find(o => picture(o.value).alt === against);
  if (reference && "reference" in figure(rightBox.value).dataset) rightBox.value = reference.value;
  refresh();
}
function choose(label) {
  const option = leftBox && [...leftBox.options].find(o => picture(o.value).alt === label);
  if (!option) return;
  leftBox.value = option.value; judgeLeft();
  byId("compare").scrollIntoView({behavior: "smooth", block: "center"});
  slider.focus({preventScroll: true});
}
if (leftBox) {
  byId("gallery").open = false;
  leftBox.addEventListener("change", judgeLeft);
  for (const box of [rightBox, flipBox]) box.addEventListener("change", refresh);
  slider.addEventListener("input", place);
  const frame = byId("compare");
  frame.addEventListener("pointermove", event => {
    if (event.pointerType === "mouse" && event.buttons === 0) return;
    const r = frame.getBoundingClientRect();
    slider.value = Math.round(1000 * Math.min(1, Math.max(0, (event.clientX - r.left) / r.width)));
    place();
  });
  judgeLeft();
}

const table = byId("points");
table.querySelectorAll("th button").forEach((button, column) => button.addEventListener("click", () => {
  const head = button.parentNode, up = head.getAttribute("aria-sort") !== "ascending";
  table.querySelectorAll("th").forEach(th => th.removeAttribute("aria-sort"));
  head.setAttribute("aria-sort", up ? "ascending" : "descending");
  const value = row => {
    const cell = row.cells[column], number = cell.dataset.value;
    return number === undefined ? cell.textContent : number === "" ? NaN : +number;
  };
  const body = table.tBodies[0];
  [...body.rows].sort((r, s) => {
    const a = value(r), b = value(s);
    if (typeof a === "number" && (isNaN(a) || isNaN(b))) return isNaN(a) - isNaN(b);
    return (a < b ? -1 : a > b ? 1 : 0) * (up ? 1 : -1);
  }).forEach(row => body.append(row));
}));
