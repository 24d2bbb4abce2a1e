// Figures: toggles, zoom, cursor, and a layout that fits the page's width.
// What is drawn stays in the SVG; a path is read when the cursor first needs it.
(() => {
const make = (name, attributes, parent) => {
  const e = document.createElementNS("http://www.w3.org/2000/svg", name);
  set(e, attributes);
  if (parent) parent.append(e);
  return e;
};
const html = (name, properties, parent) => {
  const e = Object.assign(document.createElement(name), properties);
  if (parent) parent.append(e);
  return e;
};
const set = (e, o) => { if (e) for (const k in o) e.setAttribute(k, o[k]); };
// A minus is as wide as a digit, and none stands before zero.
const minus = text => text.replace(/^-(?=[0.]*$)/, "").replace(/-/g, "−");
const all = (e, selector) => [...e.querySelectorAll(selector)];
const numbers = text => text.split(/\s+/).map(Number);
const width = text => 6.7 * [...text].length;

// Round values between from and to, and the decimals that tell them apart.
function ticks(from, to, most) {
  const raw = (to - from) / most, power = 10 ** Math.floor(Math.log10(raw));
  const step = [1, 2, 5, 10].map(m => m * power).find(s => s >= .8 * raw);
  if (!(step > 0)) return [];
  const decimals = Math.min(12, Math.max(0, Math.ceil(-Math.log10(step) - 1e-9)));
  const out = [];
  for (let k = Math.ceil(from / step - 1e-6); k * step <= to + 1e-6 * step && out.length < 40; k++) {
    const v = k * step, size = Math.abs(v);
    const text = size >= 1e7 || (size && size < 1e-6)
      ? (+v.toPrecision(6)).toExponential().replace("e+", "e") : v.toFixed(decimals);
    out.push([v, minus(text)]);
  }
  return out;
}

// The same between two decimal logarithms: powers of ten, with 2 and 5 where these are few.
function logTicks(from, to, most) {
  const step = Math.max(1, Math.ceil((to - from) / most)), out = [];
  for (let k = Math.floor(from / step); k * step <= to + 1e-9 && out.length < 40; k++) {
    for (const m of to - from < 2.5 ? [1, 2, 5] : [1]) {
      const power = k * step, v = power + Math.log10(m);
      if (v < from - 1e-9 || v > to + 1e-9) continue;
      const raised = String(power).replace(/./g, c => c === "-" ? "⁻" : "⁰¹²³⁴⁵⁶⁷⁸⁹"[c]);
      const plain = power >= -2 && power <= 4;
      out.push([v, plain ? (m * 10 ** power).toFixed(Math.max(0, -power)) : (m > 1 ? m + "·" : "") + "10" + raised]);
    }
  }
  // Zoomed into less than a decade.
  return out.length > 1 ? out : ticks(from, to, most).map(([v]) => [v, (10 ** v).toPrecision(3)]);
}

// A path in dots of the plot as it was drawn: the points of each piece of it.
function pieces(d) {
  const out = [];
  let x = 0, y = 0;
  for (const [, command, rest] of d.matchAll(/([Mlhv])([^Mlhvz]*)/g)) {
    const [a, b] = rest.match(/-?(\d+\.?\d*|\.\d+)/g).map(Number);
    if (command === "M") { out.push([]); x = a; y = b; }
    else if (command === "l") { x += a; y += b; }
    else if (command === "h") x += a;
    else y += a;
    out[out.length - 1].push([x, y]);
  }
  return out;
}

class Panel {
  constructor(g) {
    const [x, y, w, h] = numbers(g.dataset.plot), [x0, x1, y0, y1] = numbers(g.dataset.view);
    Object.assign(this, {
      g, plot: g.querySelector("svg.plot"), drawn: { x, y, w, h }, at: { x, y, w, h },
      full: { x0, x1, y0, y1 }, view: { x0, x1, y0, y1 }, labelled: "labelled" in g.dataset,
      names: g.dataset.xnames ? g.dataset.xnames.split("\n") : null,
      xlog: "xlog" in g.dataset, ylog: "ylog" in g.dataset, hidden: "xhidden" in g.dataset, equal: "equal" in g.dataset, title: g.dataset.title || "",
    });
    this.series = all(g, "g.series").map(s => ({
      g: s, name: s.dataset.name, mark: s.dataset.mark, guide: s.classList.contains("guide"),
    }));
  }
  // Hangs the names below the axis when they do not fit side by side.
  hang(w) {
    return this.names && Math.max(...this.names.map(width)) + 6 > w / Math.max(1, this.view.x1 - this.view.x0);
  }
  below(w) {
    const label = this.g.dataset.x ? 22 : 6;
    if (this.hidden) return 8;
    return this.hang(w) ? 14 + label + .8 * Math.min(160, Math.max(...this.names.map(width))) : 16 + label;
  }
  // Dots of the drawing as it was made → units, and units → dots of now.
  ux(px) { return this.full.x0 + px / this.drawn.w * (this.full.x1 - this.full.x0); }
  uy(py) { return this.full.y1 - py / this.drawn.h * (this.full.y1 - this.full.y0); }
  px(x) { return (x - this.view.x0) / (this.view.x1 - this.view.x0) * this.at.w; }
  py(y) { return (this.view.y1 - y) / (this.view.y1 - this.view.y0) * this.at.h; }
  inv(px) { return this.view.x0 + px / this.at.w * (this.view.x1 - this.view.x0); }
  inw(py) { return this.view.y1 - py / this.at.h * (this.view.y1 - this.view.y0); }

  draw() {
    const { x, y, w, h } = this.at, v = this.view, g = this.g;
    set(this.plot, { x, y, width: w, height: h });
    set(g.querySelector(".frame"), { x, y, width: w, height: h });
    set(g.querySelector(".panel-title"), { x, y: y - 6 });
    set(g.querySelector(".lx"), { x: x + w / 2, y: y + h + this.below(w) - 4 });
    set(g.querySelector(".ly"), { x: 13, y: y + h / 2, transform: `rotate(-90 13 ${y + h / 2})` });
    const sx = this.px(this.ux(1)) - this.px(this.ux(0)), tx = this.px(this.ux(0));
    const sy = this.py(this.uy(1)) - this.py(this.uy(0)), ty = this.py(this.uy(0));
    for (const e of all(this.plot, "g.data")) e.setAttribute("transform", `matrix(${sx} 0 0 ${sy} ${tx} ${ty})`);
    for (const e of all(this.plot, "g.at")) {
      const px = +e.dataset.x * sx + tx;
      e.setAttribute("transform", `translate(${px} ${+e.dataset.y * sy + ty})`);
    }
    if (this.hidden) return;
    const grid = g.querySelector(".grid"), along = g.querySelector(".tx"), up = g.querySelector(".ty");
    const line = d => make("path", { d }, grid);
    const text = (parent, content, at) => { make("text", { class: "minor", ...at }, parent).textContent = content; };
    for (const e of [grid, along, up]) e.replaceChildren();
    const hang = this.hang(w);
    const most = Math.max(2, Math.min(8, Math.floor(w / 80)));
    const step = this.names ? Math.max(1, Math.ceil((v.x1 - v.x0) / (w / 14))) : 1;
    const places = this.names
      ? this.names.map((n, i) => [i, n]).filter(([i]) => i % step === 0 && i >= v.x0 && i <= v.x1)
      : (this.xlog ? logTicks : ticks)(v.x0, v.x1, most);
    let free = -Infinity;
    for (const [value, label] of places) {
      const px = x + this.px(value);
      line(`M${px} ${y}v${h}`);
      if (!this.labelled) continue;
      if (hang) text(along, label, { x: px + 3, y: y + h + 11, "text-anchor": "end", transform: `rotate(-50 ${px + 3} ${y + h + 11})` });
      else if (px - width(label) / 2 > free) {
        text(along, label, { x: px, y: y + h + 15, "text-anchor": "middle" });
        free = px + width(label) / 2 + 6;
      }
    }
    for (const [value, label] of (this.ylog ? logTicks : ticks)(v.y0, v.y1, h > 200 ? 5 : 4)) {
      const py = y + this.py(value);
      line(`M${x} ${py}h${w}`);
      text(up, label, { x: x - 6, y: py + 4, "text-anchor": "end" });
    }
  }

  // A series as points in units: [{x, y, low, high, label}], read once.
  data(s) {
    if (s.data) return s.data;
    const out = { x: [], y: [], low: [], high: [], label: [] };
    const add = (x, y, low, high, label) => {
      out.x.push(this.ux(x)); out.y.push(this.uy(y));
      out.low.push(this.uy(low)); out.high.push(this.uy(high)); out.label.push(label || "");
    };
    const path = s.g.querySelector("g.data path");
    if (s.mark === "points") {
      for (const e of all(s.g, "g.at")) {
        const pm = "pm" in e.dataset ? +e.dataset.pm : NaN, y = +e.dataset.y, t = e.querySelector("title");
        add(+e.dataset.x, y, y + pm, y - pm, t ? t.textContent.trim() : "");
      }
    } else if (path) {
      for (const q of pieces(path.getAttribute("d"))) {
        if (s.mark === "columns") {
          const zero = this.drawn.h * this.full.y1 / (this.full.y1 - this.full.y0), a = q[0][1], b = q[2][1];
          add((q[0][0] + q[1][0]) / 2, Math.abs(a - zero) > Math.abs(b - zero) ? a : b);
        } else if (s.mark === "band") {
          for (let i = 0, n = q.length / 2; i < n; i++) add(q[i][0], 0, q[q.length - 1 - i][1], q[i][1]);
        } else for (const [x, y] of s.mark === "rule" ? [q[0]] : q) add(x, y);
      }
    }
    return (s.data = out);
  }
  // Number with the digits that a hundredth of a dot is worth.
  number(value, span, dots) {
    const grain = .01 * span / dots;
    const decimals = Math.max(0, Math.min(12, Math.floor(-Math.log10(grain))));
    return minus(Math.abs(value) >= 1e7 || grain < 1e-9 ? value.toExponential(3) : value.toFixed(decimals));
  }
  yText(value) { return (this.ylog ? minus(String(+(10 ** value).toPrecision(3))) : this.number(value, this.full.y1 - this.full.y0, this.drawn.h)) + (this.g.dataset.yu ? " " + this.g.dataset.yu : ""); }
  xText(value) {
    if (this.names) return this.names[Math.round(value)] || "";
    return (this.xlog ? String(+(10 ** value).toPrecision(3)) : this.number(value, this.full.x1 - this.full.x0, this.drawn.w)) + (this.g.dataset.xu ? " " + this.g.dataset.xu : "");
  }
}

// The index of the value nearest to x.
const nearest = (xs, x) => xs.reduce((best, v, i) => Math.abs(v - x) < Math.abs(xs[best] - x) ? i : best, 0);

class Drawing {
  constructor(box, figure) {
    this.box = box;
    this.figure = figure;
    this.svg = box.querySelector("svg.gv");
    this.panels = all(this.svg, "g.panel").map(g => new Panel(g));
    this.size = numbers(this.svg.getAttribute("viewBox")).slice(2);
    this.free = this.panels.some(p => p.equal || p.hidden);
    this.listen();
  }
  get open() { return this.panels.filter(p => !p.hidden); }

  // Lays everything out for `w` dots of width; text keeps its size.
  layout(w) {
    if (!(w > 80) || !this.panels.length) return;
    this.w = w;
    const [old] = this.size, first = this.panels[0].drawn;
    const right = old - first.x - first.w, inner = Math.max(40, w - first.x - right);
    // Without the legend, whose place buttons have.
    let shift = (this.panels.some(p => p.title) || first.y < 8 ? 24 : 10) - first.y;
    let bottom = 0;
    this.panels.forEach((p, i) => {
      const h = p.equal || p.hidden ? p.drawn.h * inner / p.drawn.w : p.drawn.h;
      p.at = { x: p.drawn.x, y: p.drawn.y + shift, w: inner, h };
      shift += h - p.drawn.h;
      p.draw();
      bottom = p.at.y + h + (i + 1 === this.panels.length ? p.below(inner) : 0);
    });
    const height = Math.ceil(bottom + 4);
    set(this.svg, { width: w, height, viewBox: `0 0 ${w} ${height}` });
    this.mark();
  }
  redraw() { this.panels.forEach(p => p.draw()); this.mark(); }

  // Shows x0 … x1 (all panels) and, where given, y0 … y1 of one panel.
  show(x0, x1, panel, y0, y1) {
    for (const p of this.open) {
      const f = p.full, span = f.x1 - f.x0;
      if (x1 - x0 >= span) { p.view.x0 = f.x0; p.view.x1 = f.x1; } else {
        const least = Math.max(x1 - x0, span * 1e-5), from = Math.min(Math.max(x0, f.x0), f.x1 - least);
        p.view.x0 = from; p.view.x1 = from + least;
      }
      if (p === panel && y1 > y0) {
        const least = Math.max(y1 - y0, (f.y1 - f.y0) * 1e-5);
        p.view.y0 = y0; p.view.y1 = y0 + least;
      }
    }
    this.redraw();
  }
  zoom(factor, panel, at) {
    panel = panel || this.open[0];
    if (!panel) return;
    const v = panel.view, f = panel.full;
    const cx = at ? at.x : this.cx !== undefined ? this.cx : (v.x0 + v.x1) / 2;
    const x0 = cx + (v.x0 - cx) * factor, x1 = cx + (v.x1 - cx) * factor;
    if (!panel.equal) return this.show(x0, x1);
    const cy = at ? at.y : (v.y0 + v.y1) / 2;
    if (x1 - x0 >= f.x1 - f.x0) return this.reset();
    this.show(x0, x1, panel, cy + (v.y0 - cy) * factor, cy + (v.y1 - cy) * factor);
  }
  reset() { for (const p of this.panels) p.view = { ...p.full }; this.redraw(); }

  // Where the pointer is: panel, and dots from the corner of its plot.
  place(event, panel) {
    const box = this.svg.getBoundingClientRect(), k = this.svg.viewBox.baseVal.width / box.width;
    const x = (event.clientX - box.left) * k, y = (event.clientY - box.top) * k;
    const inside = p => y >= p.at.y && y <= p.at.y + p.at.h && x >= p.at.x && x <= p.at.x + p.at.w;
    panel = panel || this.panels.find(inside);
    return panel && { panel, x: x - panel.at.x, y: y - panel.at.y };
  }

  listen() {
    const svg = this.svg;
    let drag = null;
    svg.addEventListener("pointermove", e => {
      if (drag) return this.drag(drag, this.place(e, drag.panel));
      const at = this.place(e);
      if (at) this.point(at, false); else this.leave();
    });
    svg.addEventListener("pointerleave", () => drag || this.leave());
    svg.addEventListener("pointerdown", e => {
      const at = this.place(e);
      if (!at || e.button || e.pointerType === "touch" || at.panel.hidden) return;
      // Nothing is selected, and the keys work all the same.
      e.preventDefault();
      this.box.focus({ preventScroll: true });
      drag = { ...at, pan: e.shiftKey, view: { ...at.panel.view } };
      svg.setPointerCapture(e.pointerId);
    });
    const end = e => {
      if (!drag) return;
      const d = drag, at = this.place(e, d.panel);
      drag = null;
      if (this.rubber) { this.rubber.remove(); this.rubber = null; }
      if (d.pan || e.type === "pointercancel" || Math.hypot(at.x - d.x, at.y - d.y) < 6) return;
      const p = d.panel, [a, b] = this.span(d, at);
      const tall = Math.abs(at.y - d.y) > 24;
      if (p.equal) {
        // Equal axes stay equal: the larger side decides.
        const half = Math.max((b - a) / p.at.w, Math.abs(at.y - d.y) / p.at.h) / 2;
        const cx = (a + b) / 2, cy = (d.y + at.y) / 2;
        return this.show(p.inv(cx - half * p.at.w), p.inv(cx + half * p.at.w), p, p.inw(cy + half * p.at.h), p.inw(cy - half * p.at.h));
      }
      const ys = tall ? [p.inw(Math.max(d.y, at.y)), p.inw(Math.min(d.y, at.y))] : [];
      this.show(p.inv(a), p.inv(b), p, ...ys);
    };
    svg.addEventListener("pointerup", end);
    svg.addEventListener("pointercancel", end);
    svg.addEventListener("dblclick", () => this.reset());
    svg.addEventListener("wheel", e => {
      const at = this.place(e);
      if (!e.ctrlKey || !at || at.panel.hidden) return;
      e.preventDefault();
      this.zoom(Math.exp(e.deltaY / 500), at.panel, { x: at.panel.inv(at.x), y: at.panel.inw(at.y) });
    }, { passive: false });
    this.box.addEventListener("keydown", e => {
      const far = e.shiftKey ? 10 : 1, act = {
        ArrowLeft: () => this.step(-far), ArrowRight: () => this.step(far), Escape: () => this.leave(),
        "+": () => this.zoom(.5), "=": () => this.zoom(.5), "-": () => this.zoom(2), 0: () => this.reset(),
      }[e.key];
      if (!act || e.ctrlKey || e.altKey || e.metaKey) return;
      act();
      e.preventDefault();
    });
  }
  span(d, at) { return [Math.max(0, Math.min(d.x, at.x)), Math.min(d.panel.at.w, Math.max(d.x, at.x))]; }
  drag(d, at) {
    const p = d.panel;
    if (d.pan) {
      const v = d.view, dx = (d.x - at.x) / p.at.w * (v.x1 - v.x0), dy = (at.y - d.y) / p.at.h * (v.y1 - v.y0);
      const up = p.equal || v.y0 !== p.full.y0 || v.y1 !== p.full.y1;
      return this.show(v.x0 + dx, v.x1 + dx, up ? p : null, v.y0 + dy, v.y1 + dy);
    }
    if (!this.rubber) this.rubber = make("rect", { class: "drag" }, this.svg);
    const [a, b] = this.span(d, at), tall = p.equal || Math.abs(at.y - d.y) > 24;
    const top = tall ? Math.max(0, Math.min(d.y, at.y)) : 0, low = tall ? Math.min(p.at.h, Math.max(d.y, at.y)) : p.at.h;
    const r = { x: p.at.x + a, y: p.at.y + top, width: b - a, height: Math.max(0, low - top) };
    set(this.rubber, r);
  }

  shown(p) { return p.series.filter(s => !s.g.hasAttribute("hidden") && !s.guide && s.mark !== "shade"); }
  // Every point that can be picked.
  spots(p) {
    const some = this.shown(p).filter(s => s.mark !== "rule" && s.mark !== "band");
    return some.flatMap(s => { const d = p.data(s); return d.x.map((_, i) => ({ s, d, i, p })); });
  }
  // The cursor at a place of a panel; `spoken` when the keyboard moved it.
  point(at, spoken) {
    const p = at.panel;
    if (this.free) return this.pick(p, at.x, at.y, spoken);
    const x = p.inv(at.x);
    this.cursor(p.names ? Math.min(p.names.length - 1, Math.max(0, Math.round(x))) : x, spoken);
  }
  // A line through all panels, with every value there.
  cursor(x, spoken) {
    this.cx = x;
    this.picked = null;
    const rows = [];
    let shownX = x;
    let best = Infinity;
    for (const p of this.open) {
      const values = [];
      for (const s of this.shown(p)) {
        const d = p.data(s);
        if (s.mark === "rule") { if (d.y.length) values.push([s.name, d.y.map(v => p.yText(v)).join(", ")]); continue; }
        const i = nearest(d.x, x), off = Math.abs(d.x[i] - x);
        // No further than four dots, or most of a step: beyond a gap there is no value.
        if (!(off <= (p.names ? .6 : Math.max(p.inv(4) - p.inv(0), (d.x.at(-1) - d.x[0]) / d.x.length)))) continue;
        if (off < best) { best = off; shownX = d.x[i]; }
        d.x.forEach((v, k) => { if (k === i || (p.names && Math.abs(v - x) < .5)) values.push([s.name, this.value(p, s, d, k)]); });
      }
      rows.push([p.title, values]);
    }
    const p = this.open[0];
    if (p) this.say(`${p.g.dataset.x} ${p.xText(p.names ? x : shownX)}`, rows, spoken);
    this.mark();
  }
  value(p, s, d, i) {
    if (s.mark === "band") return `${p.yText(d.low[i])} to ${p.yText(d.high[i])}`;
    let text = p.yText(d.y[i]);
    if (isFinite(d.low[i]) && s.mark === "points") text += ` ± ${p.number((d.high[i] - d.low[i]) / 2, p.full.y1 - p.full.y0, p.drawn.h)}`;
    return d.label[i] ? `${d.label[i]}: ${text}` : text;
  }
  // Where x is no time: the point that is nearest in the plane.
  pick(p, x, y, spoken) {
    let best = null;
    for (const q of this.spots(p)) {
      q.off = Math.hypot(p.px(q.d.x[q.i]) - x, p.py(q.d.y[q.i]) - y) - (q.d.label[q.i] ? 6 : 0);
      if (!best || q.off < best.off) best = q;
    }
    if (!best || best.off > 40) return this.leave();
    this.picked = best;
    this.tell(spoken);
  }
  tell(spoken) {
    const { s, d, i, p } = this.picked;
    const place = p.hidden ? s.name : `${p.g.dataset.x} ${p.xText(d.x[i])}, ${p.g.dataset.y} ${p.yText(d.y[i])}`;
    this.say([d.label[i], place].filter(Boolean).join(": "), p.hidden ? [] : [["", [[s.name]]]], spoken);
    this.mark();
  }
  // One point on, or one dot where points are closer.
  step(by) {
    if (this.free) {
      const now = this.picked, spots = this.spots(now ? now.p : this.panels[0]);
      if (!spots.length) return;
      const from = now ? spots.findIndex(q => q.s === now.s && q.i === now.i) : by > 0 ? -1 : 0;
      // Four hundred steps are the whole way, however many points there are.
      const stride = now ? Math.max(1, Math.round(spots.length / 400)) : 1;
      this.picked = spots[(from + by * stride + 10 * spots.length) % spots.length];
      return this.tell(true);
    }
    const p = this.open[0];
    if (!p) return;
    const v = p.view, dot = (v.x1 - v.x0) / p.at.w;
    if (p.names) {
      const now = this.cx === undefined ? (by > 0 ? Math.ceil(v.x0) - by : Math.floor(v.x1) - by) : this.cx;
      return this.cursor(Math.min(p.names.length - 1, Math.max(0, Math.round(now) + by)), true);
    }
    const now = this.cx === undefined ? (v.x0 + v.x1) / 2 : this.cx;
    // Points lie apart: the next one. Else four dots.
    const sparse = this.shown(p).map(s => p.data(s)).find(d => d.x.length > 1 && (p.full.x1 - p.full.x0) / d.x.length > 4 * dot);
    let next = now + 4 * dot * by;
    if (sparse) next = sparse.x[Math.min(sparse.x.length - 1, Math.max(0, nearest(sparse.x, now) + by))];
    next = Math.min(p.full.x1, Math.max(p.full.x0, next));
    if (next < v.x0 || next > v.x1) this.show(next - (v.x1 - v.x0) / 2, next + (v.x1 - v.x0) / 2);
    this.cursor(next, true);
  }
  leave() { this.cx = this.picked = undefined; this.figure.out.replaceChildren(); this.mark(); }
  say(head, rows, spoken) {
    const out = this.figure.out;
    // A screen reader hears what keys bring, not every dot of a mouse's way.
    out.ariaLive = spoken ? "polite" : "off";
    const parts = [html("b", { textContent: head })];
    for (const [title, values] of rows) {
      // Both ends of a box say the same.
      for (const text of new Set(values.map(v => [title, ...v].join(" ").trim()))) parts.push(html("span", { textContent: text }));
    }
    out.replaceChildren(...parts.flatMap((p, i) => i ? [" ", p] : [p]));
    if (parts.length > 1) out.children[0].style.marginRight = "1rem";
  }
  // The cursor's lines and rings.
  mark() {
    for (const e of all(this.svg, ".cursor,.pick")) e.remove();
    if (this.picked) {
      const { p, d, i } = this.picked;
      make("circle", { class: "pick", cx: p.px(d.x[i]), cy: p.py(d.y[i]), r: 7 }, p.plot);
    } else if (this.cx !== undefined) {
      for (const p of this.open) make("path", { class: "cursor", d: `M${p.px(this.cx)} 0V${p.at.h}` }, p.plot);
    }
  }
}

// One light picture of the drawings as they were made, two in a row, below a title.
function picture(title, drawings) {
  const svg = make("svg", { xmlns: "http://www.w3.org/2000/svg", class: "gv" });
  make("style", {}, svg).textContent = document.getElementById("figures").textContent;
  make("rect", { class: "paper", width: "100%", height: "100%" }, svg);
  make("text", { class: "title", x: 16, y: 22 }, svg).textContent = title;
  let x = 0, y = 30, row = 0, wide = 0;
  drawings.forEach((d, i) => {
    const [, , width, height] = numbers(d.getAttribute("viewBox"));
    if (i % 2 === 0) { x = 0; y += row; row = 0; }
    set(d, { x, y, width, height });
    svg.append(d);
    x += width + 16;
    row = Math.max(row, height);
    wide = Math.max(wide, x - 16);
  });
  set(svg, { width: wide, height: y + row, viewBox: `0 0 ${wide} ${y + row}` });
  return svg;
}
const download = (blob, name) => {
  const href = URL.createObjectURL(blob);
  html("a", { href, download: name }).click();
  setTimeout(() => URL.revokeObjectURL(href), 1e4);
};
function save(svg, name, kind) {
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

class Figure {
  constructor(element) {
    const title = element.querySelector("h3").textContent;
    const drawings = element.querySelector(".drawings");
    if (!drawings) return;
    const originals = all(drawings, "svg.gv").map(d => d.cloneNode(true));
    const tools = html("div", { className: "tools" });
    drawings.before(tools);
    this.out = html("output", { className: "readout", ariaLive: "polite" });
    drawings.after(this.out);
    this.drawings = all(element, ".drawing").map(box => {
      const ariaLabel = `${title}. Arrows move the cursor, + and − zoom, 0 shows all.`;
      Object.assign(box, { tabIndex: 0, role: "group", ariaLabel });
      return new Drawing(box, this);
    });
    for (const entry of all(element, ".legend .entry")) this.toggle(entry, element, tools);
    const zoomable = this.drawings.filter(d => d.open.length);
    if (zoomable.length) {
      for (const [text, title, run] of [["+", "Zoom in", d => d.zoom(.5)], ["−", "Zoom out", d => d.zoom(2)], ["0", "Show all", d => d.reset()]]) {
        html("button", { textContent: text, ariaLabel: title, className: "end zoom", onclick: () => zoomable.forEach(run) }, tools);
      }
    }
    for (const kind of ["PNG", "SVG"]) {
      const run = () => save(picture(title, originals.map(d => d.cloneNode(true))), element.id.replace("figure-", ""), kind);
      html("button", { textContent: kind, ariaLabel: `Save as ${kind}`, className: "end save", onclick: run }, tools);
    }
    // In the next frame: within this one the observer would watch its own work.
    const fit = d => requestAnimationFrame(() => { if (d.w !== d.box.clientWidth) d.layout(d.box.clientWidth); });
    for (const d of this.drawings) { d.layout(d.box.clientWidth); new ResizeObserver(() => fit(d)).observe(d.box); }
  }
  toggle(entry, element, tools) {
    const name = entry.dataset.name;
    const b = html("button", { ariaPressed: "true" }, tools);
    const kind = entry.getAttribute("class"), box = make("svg", { width: 26, height: 12, class: "gv", "aria-hidden": "true" }, b);
    make("g", { class: kind, transform: "translate(1 10)" }, box).append(entry.querySelector("g").cloneNode(true));
    b.append(name);
    b.onclick = () => {
      const on = b.ariaPressed !== "true";
      b.ariaPressed = on;
      for (const e of all(element, "svg.plot [data-name]")) {
        if (e.dataset.name === name) e.toggleAttribute("hidden", !on);
      }
    };
  }
}

document.body.classList.add("js");
const figures = all(document, "figure").map(f => new Figure(f)).filter(f => f.drawings);
// Paper is as wide as the drawings were made for.
addEventListener("beforeprint", () => { for (const f of figures) for (const d of f.drawings) { d.kept = d.w; d.layout(d.size[0]); } });
addEventListener("afterprint", () => { for (const f of figures) for (const d of f.drawings) d.layout(d.kept); });

for (const pre of all(document, "pre.paste")) {
  const text = pre.textContent;
  const wrap = html("div", { style: "position:relative" });
  pre.replaceWith(wrap);
  wrap.append(pre);
  const b = html("button", { className: "copy", textContent: "Copy" }, wrap);
  b.onclick = async () => {
    // Where the clipboard is not allowed the text is at least selected.
    getSelection().selectAllChildren(pre);
    try { await navigator.clipboard.writeText(text); } catch { document.execCommand("copy"); }
    b.textContent = "Copied";
    setTimeout(() => { b.textContent = "Copy"; }, 2000);
  };
}
})();
