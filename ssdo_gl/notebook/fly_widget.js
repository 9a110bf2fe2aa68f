// Shows the pictures that the kernel sends, and tells it what mouse, keys and choices do.

function element(tag, parent, style = {}) {
  const made = document.createElement(tag);
  Object.assign(made.style, style);
  parent.append(made);
  return made;
}

function render({ model, el }) {
  const id = Math.random().toString(36).slice(2);
  const tell = (type, fields = {}) => model.send({ type, ...fields });
  const root = element("div", el, { maxWidth: `${model.get("width")}px`, position: "relative" });
  // JupyterLab's shortcuts are keys, too.
  root.dataset.lmSuppressShortcuts = "true";
  const canvas = element("canvas", root, {
    display: "block", width: "100%", touchAction: "none", outlineOffset: "-1px",
    aspectRatio: `${model.get("width")} / ${model.get("height")}`,
  });
  canvas.tabIndex = 0;
  const paper = canvas.getContext("2d", { alpha: false });
  const bar = element("div", root, { display: "flex", gap: "6px", font: "12px sans-serif", padding: "3px 0" });
  const status = element("span", bar, { marginLeft: "auto", opacity: "0.7" });

  let wanted = { width: 1, height: 1 }, drawing = Promise.resolve();

  function measure() {
    const box = canvas.getBoundingClientRect();
    if (box.width < 1 || box.height < 1) return;
    const scale = Math.min(devicePixelRatio || 1, Math.sqrt(MAX_PIXELS / (box.width * box.height)));
    wanted = { width: Math.round(box.width * scale), height: Math.round(box.height * scale) };
    tell("size", { width: box.width, height: box.height, scale });
  }

  async function show({ frame, lossless }, data) {
    const file = new Blob([data], { type: lossless ? "image/png" : "image/jpeg" });
    const bitmap = await createImageBitmap(file, { colorSpaceConversion: "none" });
    if (canvas.width !== wanted.width || canvas.height !== wanted.height) Object.assign(canvas, wanted);
    paper.drawImage(bitmap, 0, 0, canvas.width, canvas.height);
    bitmap.close();
    canvas.dataset.lossless = lossless;
    canvas.dataset.frame = frame;
    tell("ack", { frame });
  }

  function choice(what, entries) {
    const select = element("select", bar, { order: -1 });
    select.title = select.name = what;
    select.replaceChildren(...entries.map(([value, text]) => new Option(text, value)));
    select.addEventListener("change", () => { tell("choose", { what, value: select.value }); canvas.focus(); });
    return select;
  }

  const selects = {};
  const heard = {
    picture: (message, [data]) => {
      drawing = drawing.then(() => show(message, data)).catch((error) => { status.textContent = String(error); });
    },
    choices: ({ methods, aovs }) => {
      selects.aov ??= choice("aov", aovs.map((name) => [name, name]));
      selects.method ??= choice("method", Object.entries(methods));
    },
    state: (state) => {
      for (const [name, select] of Object.entries(selects)) select.value = state[name];
      const said = state.messages.map(({ text }) => text);
      status.textContent = said.at(-1) ?? (state.resting ? "at rest, lossless" : "");
    },
    fault: ({ text }) => { status.textContent = text; },
  };
  const hear = (message, buffers) => heard[message.type]?.(message, buffers);
  model.on("msg:custom", hear);

  const place = (event) => {
    const box = canvas.getBoundingClientRect();
    return { x: event.clientX - box.left, y: event.clientY - box.top };
  };
  // The page scrolls until the picture is clicked.
  tellOfMouse(canvas, tell, place, () => [document.activeElement, canvas.getRootNode().activeElement].includes(canvas));
  for (const [kind, down] of [["keydown", true], ["keyup", false]]) {
    canvas.addEventListener(kind, (event) => {
      event.stopPropagation();
      if (event.metaKey || event.ctrlKey || event.code === "Tab") return;
      tell("key", { code: event.code, down, repeat: event.repeat, mods: mods(event) });
      event.preventDefault();
    });
  }
  canvas.addEventListener("blur", () => tell("focus", { has: false }));
  canvas.addEventListener("focus", () => tell("focus", { has: true }));

  const observer = new ResizeObserver(measure);
  tell("open", { page: id });
  observer.observe(canvas);
  return () => {
    observer.disconnect();
    model.off("msg:custom", hear);
    tell("close", { page: id });
  };
}

export default { render };
