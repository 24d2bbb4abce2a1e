// The signal over time and the predicted error over poses.
"use strict";

const SMALL = "11.5px system-ui, 'DejaVu Sans', sans-serif";

// Least and greatest value in each of a fixed number of columns of time: half an hour costs no
// more memory or drawing than a minute.
class Columns {
  constructor(span_s, count) {
    this.step_s = span_s / count;
    this.count = count;
    this.first = 0;
    this.rows = [];
  }

  push(t_s, values) {
    const index = Math.floor(t_s / this.step_s);
    if (!this.rows.length) this.first = index;
    // Time does not run backwards within a session; a new session begins with new columns.
    if (index < this.first + this.rows.length - 1) return;
    // A long silence is not filled column by column.
    if (index - this.first >= 3 * this.count) {
      this.rows = [];
      this.first = index;
    }
    while (this.first + this.rows.length <= index) this.rows.push(null);
    const row = this.rows[this.rows.length - 1];
    this.rows[this.rows.length - 1] = values.map((v, i) =>
      row ? [Math.min(row[i][0], v), Math.max(row[i][1], v)] : [v, v]);
    const extra = this.rows.length - this.count - 1;
    if (extra > 64) {
      this.rows.splice(0, extra);
      this.first += extra;
    }
  }

  // Each column that holds something since `from_s`, as (middle s, row).
  forEach(from_s, visit) {
    const start = Math.max(0, Math.floor(from_s / this.step_s) - this.first);
    for (let i = start; i < this.rows.length; i++) {
      if (this.rows[i]) visit((this.first + i + 0.5) * this.step_s, this.rows[i]);
    }
  }
}

const SPANS = [["1 min", 60], ["5 min", 300], ["30 min", 1800]];

class Strip {
  constructor(canvas) {
    this.canvas = canvas;
    this.span = 0;
    this.reset();
  }

  reset() {
    this.columns = SPANS.map(([, span_s]) => new Columns(span_s, 320));
    this.now_s = 0;
    this.half = 0.05;
    this.limit = null;
    this.due = true;
  }

  push(t_s, norm, noise_mg, limit_mg) {
    if (![t_s, norm, noise_mg].every(Number.isFinite) || norm <= 0) return;
    if (t_s < this.now_s - 1) this.reset();
    for (const c of this.columns) c.push(t_s, [norm, Math.max(noise_mg, 1e-3)]);
    this.now_s = Math.max(this.now_s, t_s);
    this.limit = limit_mg;
    this.due = true;
  }

  // `marks` [{ from, to, kind }]: spans of time that became poses or did not; `gravity` in m/s².
  draw(ink, marks, gravity) {
    if (!this.due) return;
    const area = prepare(this.canvas);
    if (!area) return;
    this.due = false;
    const { pen, width, height } = area, span_s = SPANS[this.span][1];
    const left = 44, right = width - 6, gap = 22, top = 16;
    const high = (height - top - gap - 18) / 2;
    const from_s = this.now_s - span_s, x = t => left + (t - from_s) / span_s * (right - left);
    const upper = { top, bottom: top + high }, lower = { top: top + high + gap, bottom: top + 2 * high + gap };
    let far = 0.04, most = 100;
    this.columns[this.span].forEach(from_s, (t, [norm, noise]) => {
      far = Math.max(far, Math.abs(norm[0] - 1), Math.abs(norm[1] - 1));
      most = Math.max(most, noise[1]);
    });
    // A knock does not flatten what is looked at: beyond half a g the line is cut off.
    this.half += 0.25 * (Math.min(0.5, far * 1.15) - this.half);
    if (Math.abs(Math.min(0.5, far * 1.15) - this.half) > 0.002) this.due = true;
    const y1 = v => upper.bottom - (Math.max(-1, Math.min(1, (v - 1) / this.half)) + 1) / 2 * high;
    const decades = Math.log10(Math.min(1000, most) / 1) || 2;
    const y2 = v => lower.bottom - Math.max(0, Math.min(1, Math.log10(Math.max(v, 1)) / decades)) * high;
    pen.font = SMALL;
    pen.textBaseline = "middle";
    for (const m of marks) this.span_of(pen, m, x, left, right, upper, lower, ink);
    this.frame(pen, left, right, upper, `‖a‖, m/s²`, ink);
    this.frame(pen, left, right, lower, "scatter, mg", ink);
    const digits = this.half * gravity < 1 ? 2 : 1;
    for (const v of [1 - this.half * 0.75, 1, 1 + this.half * 0.75]) this.tick(pen, left, y1(v), (v * gravity).toFixed(digits), ink);
    for (const v of [1, 10, 100, 1000]) if (Math.log10(v) <= decades + 1e-9) this.tick(pen, left, y2(v), String(v), ink);
    this.rule(pen, left, right, y1(1), ink.muted, [2, 3]);
    this.line(pen, 0, x, y1, from_s, ink.accent);
    this.line(pen, 1, x, y2, from_s, ink.ink);
    if (this.limit) {
      const y = y2(this.limit), text = `limit ${precise(this.limit)}`;
      this.rule(pen, left, right, y, ink.fair, [6, 4]);
      pen.textAlign = "left";
      pen.lineWidth = 4;
      pen.strokeStyle = ink.card;
      pen.strokeText(text, left + 2, y + 8);
      pen.fillStyle = ink.fair;
      pen.fillText(text, left + 2, y + 8);
    }
    pen.fillStyle = ink.muted;
    pen.textAlign = "right";
    pen.fillText("now", right, height - 8);
    pen.textAlign = "left";
    pen.fillText(`−${SPANS[this.span][0]}`, left, height - 8);
  }

  frame(pen, left, right, { top, bottom }, title, ink) {
    this.rule(pen, left, right, bottom, ink.strong, []);
    pen.fillStyle = ink.muted;
    pen.textAlign = "left";
    pen.fillText(title, left, top - 8);
  }

  tick(pen, left, y, text, ink) {
    pen.fillStyle = ink.muted;
    pen.textAlign = "right";
    pen.fillText(text, left - 6, y);
  }

  rule(pen, left, right, y, colour, dash) {
    pen.strokeStyle = colour;
    pen.lineWidth = 1;
    pen.setLineDash(dash);
    pen.beginPath();
    pen.moveTo(left, y);
    pen.lineTo(right, y);
    pen.stroke();
    pen.setLineDash([]);
  }

  line(pen, series, x, y, from_s, colour) {
    pen.strokeStyle = colour;
    pen.lineWidth = 1.6;
    pen.lineJoin = "round";
    pen.beginPath();
    let last = null;
    const columns = this.columns[this.span], silence_s = Math.max(1, 2.5 * columns.step_s);
    columns.forEach(from_s, (t, row) => {
      const [low, high] = row[series];
      if (last === null || t - last > silence_s) pen.moveTo(x(t), y(low));
      else pen.lineTo(x(t), y(low));
      if (high !== low) pen.lineTo(x(t), y(high));
      last = t;
    });
    pen.stroke();
  }

  span_of(pen, { from, to, kind }, x, left, right, upper, lower, ink) {
    const a = Math.max(left, x(from)), b = Math.min(right, x(to));
    if (b <= left) return;
    pen.fillStyle = kind === "done" ? ink.goodTint : kind === "cross" ? ink.poorTint : ink.accentTint;
    pen.fillRect(a, upper.top, Math.max(1, b - a), lower.bottom - upper.top);
    if (kind !== "open") {
      pen.fillStyle = kind === "done" ? ink.good : ink.poor;
      pen.textAlign = "center";
      pen.fillText(kind === "done" ? "✓" : "✕", (a + b) / 2, lower.bottom - 8);
    }
  }
}

// A figure with two digits that count.
const precise = v => !Number.isFinite(v) ? "–" : Math.abs(v) < 0.995 ? v.toFixed(2) : Math.abs(v) < 9.95 ? v.toFixed(1) : v.toFixed(0);

const GOOD_MG = 5, FAIR_MG = 20;

class ErrorChart {
  constructor(canvas) {
    this.canvas = canvas;
    this.show([]);
  }

  // `errors` [[poses, mg in the worst direction, mg that an error of one pose could hide or null]]:
  // the verdict judges both by the same limits.
  show(errors) {
    this.errors = errors;
    this.due = true;
  }

  draw(ink) {
    if (!this.due) return;
    const area = prepare(this.canvas);
    if (!area) return;
    this.due = false;
    const { pen, width, height } = area, left = 50, right = width - 10, top = 8, bottom = height - 20;
    const all = this.errors.flatMap(([, worst, hidden]) => [worst, hidden]).filter(mg => mg > 0);
    const low = Math.min(1, ...all.map(v => 10 ** Math.floor(Math.log10(v)))), high = Math.max(100, ...all.map(v => v * 1.2));
    const last = this.errors.length ? this.errors[this.errors.length - 1] : null;
    const least = Math.min(4, ...this.errors.map(([n]) => n)), most = Math.max(10, last ? last[0] + 1 : 0);
    const x = n => left + (n - least + 0.3) / (most - least + 0.6) * (right - left);
    const y = v => bottom - (Math.log10(v) - Math.log10(low)) / (Math.log10(high) - Math.log10(low)) * (bottom - top);
    pen.font = SMALL;
    pen.textBaseline = "middle";
    pen.fillStyle = ink.goodTint;
    pen.fillRect(left, y(GOOD_MG), right - left, bottom - y(GOOD_MG));
    for (let v = low; v <= high; v *= 10) {
      pen.fillStyle = ink.muted;
      pen.textAlign = "right";
      pen.fillText(`${v} mg`, left - 5, y(v));
      this.rule(pen, left, right, y(v), ink.line, []);
    }
    // Errors fall from the left above to the right below: these corners are free of them.
    for (const [v, word, colour, align, at, off] of [
      [GOOD_MG, "good: 5 mg", ink.good, "left", left + 3, 8], [FAIR_MG, "fair: 20 mg", ink.fair, "right", right - 3, -8],
    ]) {
      this.rule(pen, left, right, y(v), colour, [6, 4]);
      pen.fillStyle = colour;
      pen.textAlign = align;
      pen.fillText(word, at, y(v) + off);
    }
    pen.fillStyle = ink.muted;
    pen.textAlign = "center";
    const every = Math.ceil((most - least) / 8);
    for (let n = least; n <= most; n += every) pen.fillText(String(n), x(n), height - 8);
    pen.textAlign = "right";
    pen.fillText("poses", left - 5, height - 8);
    pen.textAlign = "center";
    if (!last) {
      pen.fillStyle = ink.muted;
      pen.fillText("from the fourth pose on", (left + right) / 2, y(60));
      return;
    }
    const worst = this.errors.map(e => [x(e[0]), y(e[1])]);
    const hidden = this.errors.filter(e => e[2] > 0).map(e => [x(e[0]), y(e[2])]);
    pen.setLineDash([4, 3]);
    this.curve(pen, hidden, ink.poor, 1.6);
    pen.setLineDash([]);
    for (const [a, b] of hidden) {
      pen.fillStyle = ink.poor;
      pen.beginPath();
      pen.moveTo(a, b - 5);
      pen.lineTo(a + 4.5, b + 3.5);
      pen.lineTo(a - 4.5, b + 3.5);
      pen.fill();
    }
    this.curve(pen, worst, ink.accent, 2);
    for (const p of worst) {
      pen.fillStyle = ink.accent;
      pen.beginPath();
      pen.arc(...p, 4, 0, 2 * Math.PI);
      pen.fill();
    }
  }

  curve(pen, points, colour, width) {
    pen.strokeStyle = colour;
    pen.lineWidth = width;
    pen.beginPath();
    points.forEach((p, i) => i ? pen.lineTo(...p) : pen.moveTo(...p));
    pen.stroke();
  }
}
ErrorChart.prototype.rule = Strip.prototype.rule;
