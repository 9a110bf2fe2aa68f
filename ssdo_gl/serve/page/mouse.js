// What a picture tells of the mouse over it: the same in a browser and in a notebook.

// As in page_events.py: more is refused.
const MAX_PIXELS = 3840 * 2160;
const PIXELS_PER_NOTCH = 100; // of a wheel, as browsers count; a line is 16

function mods(event) {
  return event.shiftKey + 2 * event.ctrlKey + 4 * event.altKey + 8 * event.metaKey;
}

// `place` returns where in the picture an event is, `takesWheel` whether the wheel is for it.
function tellOfMouse(picture, tell, place, takesWheel = () => true) {
  picture.addEventListener("pointerdown", (event) => {
    picture.focus();
    picture.setPointerCapture(event.pointerId);
    if (event.button <= 2) tell("button", { button: event.button, down: true, ...place(event) });
    event.preventDefault();
  });
  picture.addEventListener("pointermove", (event) => {
    const { button } = event, at = place(event);
    tell("cursor", at);
    // With one button held, another one that goes down or up is a movement.
    if (button >= 0 && button <= 2) {
      tell("button", { button, down: (event.buttons & [1, 4, 2][button]) !== 0, ...at });
    }
  });
  for (const end of ["pointerup", "pointercancel"]) {
    picture.addEventListener(end, (event) => {
      const button = Math.max(0, event.button);
      if (button <= 2) tell("button", { button, down: false, ...place(event) });
    });
  }
  picture.addEventListener("contextmenu", (event) => { event.preventDefault(); event.stopPropagation(); });
  picture.addEventListener("wheel", (event) => {
    if (!takesWheel()) return;
    const pixels = [1, 16, 800][event.deltaMode] * event.deltaY;
    tell("cursor", place(event));
    tell("wheel", { notches: Math.max(-20, Math.min(20, -pixels / PIXELS_PER_NOTCH)) });
    event.preventDefault();
  }, { passive: false });
}
