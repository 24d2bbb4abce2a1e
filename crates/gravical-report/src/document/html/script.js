// Figures: values below the pointer, zooming into an interval of x by dragging, buttons that save.
// What is drawn stays in the SVG.
(() => {
const all = (e, selector) => [...e.querySelectorAll(selector)];
const numbers = text => text.split(" ").map(Number);
const make = (name, attributes, parent) => {
  const e = document.createElementNS("http://www.w3.org/2000/svg", name);
  set(e, attributes);
  parent?.append(e);
  return e;
};
const set = (e, attributes) => { for (const k in attributes) e.setAttribute(k, attributes[k]); };
const html = (name, properties, parent) => {
  const e = Object.assign(document.createElement(name), properties);
  parent?.append(e);
  return e;
};
const fixed = (value, decimals) => value.toFixed(decimals).replace(/^-(?=[0.]*$)/, "").replace("-", "−");

// Round values between two others, and their decimals.
function ticks(from, to) {
  const raw = (to - from) / 8, power = 10 ** Math.floor(Math.log10(raw));
  const step = power * [1, 2, 5, 10].find(m => m * power >= .8 * raw);
  const count = Math.floor(to / step) - Math.ceil(from / step) + 1;
  const values = Array.from({ length: count }, (_, i) => (Math.ceil(from / step) + i) * step);
  return [values, Math.min(12, Math.max(0, Math.ceil(-Math.log10(step) - 1e-9)))];
}

// A panel with linear axes.
class Panel {
  constructor(g) {
    const [x, y, w, h] = numbers(g.dataset.plot), [x0, x1, y0, y1] = numbers(g.dataset.view);
    Object.assign(this, { g, x, y, w, h, x0, x1, y0, y1, from: x0, to: x1 });
    this.frame = g.querySelector(".frame");
    this.cursor = make("rect", { class: "cursor", height: h, visibility: "hidden" }, g.querySelector(".plot"));
  }
  // Dots of what is shown now.
  dots(x) { return (x - this.from) / (this.to - this.from) * this.w; }
  // The values below the pointer.
  place(event) {
    const box = this.frame.getBoundingClientRect(), share = v => Math.min(1, Math.max(0, v));
    return [this.from + share((event.clientX - box.left) / box.width) * (this.to - this.from),
      this.y1 - share((event.clientY - box.top) / box.height) * (this.y1 - this.y0)];
  }
  show(from, to) {
    [this.from, this.to] = [from, to];
    const k = (this.x1 - this.x0) / (to - from), shift = this.dots(this.x0);
    for (const e of all(this.g, ".data")) set(e, { transform: `matrix(${k} 0 0 1 ${shift} 0)` });
    for (const e of all(this.g, ".at")) {
      e.home ??= numbers(e.getAttribute("transform").slice(10, -1));
      set(e, { transform: `translate(${k * e.home[0] + shift} ${e.home[1]})` });
    }
    const axis = this.g.querySelector(".tx"), labelled = axis.querySelector("text");
    const [values, decimals] = ticks(from, to);
    axis.replaceChildren();
    for (const v of values) {
      const x = this.x + this.dots(v);
      make("path", { d: `M${x} ${this.y}v${this.h}` }, axis);
      const at = { class: "minor", x, y: this.y + this.h + 15, "text-anchor": "middle" };
      if (labelled) make("text", at, axis).textContent = fixed(v, decimals);
    }
  }
  mark(a, b) {
    const [from, to] = [this.dots(Math.min(a, b)), this.dots(Math.max(a, b))];
    set(this.cursor, { x: from - .5, width: to - from + 1, visibility: "visible" });
  }
}

function readAndZoom(figure) {
  const panels = all(figure, "[data-view]").map(g => new Panel(g));
  if (!panels.length) return;
  const out = html("output", { ariaLive: "off" }, figure);
  const value = (v, span) => fixed(v, Math.min(12, Math.max(0, Math.ceil(3 - Math.log10(span)))));
  for (const panel of panels) {
    // Those over the same axis go along.
    const together = panels.filter(p => p.x0 === panel.x0 && p.x1 === panel.x1), names = panel.g.dataset;
    const show = (from, to) => together.forEach(p => p.show(from, to));
    let start = null;
    panel.g.onpointerdown = e => {
      if (e.button || e.pointerType === "touch") return;
      e.preventDefault();
      panel.g.setPointerCapture(e.pointerId);
      start = panel.place(e)[0];
    };
    panel.g.onpointermove = e => {
      const [x, y] = panel.place(e), read = [value(x, panel.to - panel.from), value(y, panel.y1 - panel.y0)];
      together.forEach(p => p.mark(start ?? x, x));
      out.textContent = `${names.x} ${read[0]}; ${names.title} ${read[1]} ${names.unit}`;
    };
    panel.g.onpointerup = e => {
      const [from, to] = [start ?? 0, panel.place(e)[0]].sort((a, b) => a - b), span = panel.to - panel.from;
      if (start !== null && to - from > Math.max(.01 * span, 1e-5 * (panel.x1 - panel.x0))) show(from, to);
      start = null;
    };
    panel.g.onpointercancel = () => { start = null; };
    panel.g.onpointerleave = () => { for (const p of together) set(p.cursor, { visibility: "hidden" }); out.textContent = ""; };
    panel.g.ondblclick = () => show(panel.x0, panel.x1);
  }
}

function download(blob, name) {
  const href = URL.createObjectURL(blob);
  html("a", { href, download: name }).click();
  setTimeout(() => URL.revokeObjectURL(href), 1e4);
}

// The drawing of a figure as it is seen.
function save(figure, kind) {
  const svg = figure.querySelector("svg").cloneNode(true), name = figure.id.replace("figure-", "");
  for (const e of all(svg, ".cursor")) e.remove();
  const text = new XMLSerializer().serializeToString(svg);
  if (kind === "SVG") return download(new Blob([text], { type: "image/svg+xml" }), name + ".svg");
  // Two dots for one of the drawing: sharp in print.
  const image = new Image(), canvas = html("canvas", { width: 2 * svg.getAttribute("width"), height: 2 * svg.getAttribute("height") });
  image.onload = () => {
    canvas.getContext("2d").drawImage(image, 0, 0, canvas.width, canvas.height);
    canvas.toBlob(blob => download(blob, name + ".png"));
  };
  image.src = "data:image/svg+xml," + encodeURIComponent(text);
}

for (const figure of all(document, "figure")) {
  readAndZoom(figure);
  const tools = html("div", { className: "tools" }, figure);
  for (const kind of ["PNG", "SVG"]) {
    html("button", { textContent: kind, ariaLabel: `Save as ${kind}`, onclick: () => save(figure, kind) }, tools);
  }
}
})();
