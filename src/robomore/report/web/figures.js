// Figures whose marks say more: pointed at, tapped, or reached with the arrow keys.

// A live page wires what is new in it again and again; what was there already is left alone.
const wired = new WeakSet();

// `open(key)` is called for a mark of an evaluation that is chosen.
export function wireFigures(open, root = document) {
  for (const figure of root.querySelectorAll("svg.figure.marked")) {
    if (!wired.has(figure)) wire(figure, open);
    wired.add(figure);
  }
}

function wire(figure, open) {
  const marks = [...figure.querySelectorAll(".tip")];
  if (!marks.length) return;
  const said = figure.parentElement.querySelector(".said");
  const asks = said?.textContent;
  const tell = (mark) => {
    if (said) said.textContent = mark?.getAttribute("aria-label") ?? asks;
  };
  for (const mark of marks) mark.setAttribute("tabindex", "-1");
  let current = marks[0];
  current.setAttribute("tabindex", "0");
  const reach = (mark) => mark.focus({ preventScroll: true });
  const markOf = (event) => event.target.closest(".tip");
  figure.addEventListener("pointerover", (event) => tell(markOf(event)));
  figure.addEventListener("pointerleave", () => tell(null));
  figure.addEventListener("focusin", (event) => {
    const mark = markOf(event);
    current.setAttribute("tabindex", "-1");
    current = mark ?? current;
    current.setAttribute("tabindex", "0");
    tell(mark);
  });
  figure.addEventListener("click", (event) => {
    const mark = markOf(event);
    if (!mark) return;
    reach(mark);
    tell(mark);
    if (mark.dataset.key) open(mark.dataset.key);
  });
  figure.addEventListener("keydown", (event) => {
    const direction = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, -1],
      ArrowDown: [0, 1] }[event.key];
    if (direction) {
      event.preventDefault();
      reach(neighbour(marks, current, direction) ?? current);
    } else if ((event.key === "Enter" || event.key === " ") && current.dataset.key) {
      event.preventDefault();
      open(current.dataset.key);
    }
  });
}

// The nearest mark in a direction; what lies aside counts double.
function neighbour(marks, from, [dx, dy]) {
  const middle = (mark) => {
    const { x, y, width, height } = mark.getBoundingClientRect();
    return [x + width / 2, y + height / 2];
  };
  const [x, y] = middle(from);
  let best = null;
  let least = Infinity;
  for (const mark of marks) {
    const [mx, my] = middle(mark);
    const along = (mx - x) * dx + (my - y) * dy;
    const aside = Math.abs((mx - x) * dy) + Math.abs((my - y) * dx);
    if (mark !== from && along > 0.5 && along + 2 * aside < least) {
      least = along + 2 * aside;
      best = mark;
    }
  }
  return best;
}
