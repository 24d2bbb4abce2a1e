// The signal over time and the predicted error over poses.
"use strict";

const SMALL = `11.5px ${FONT}`;
// The signal of this time is shown, s.
const SPAN_S = 60;
const GOOD_MG = 5, FAIR_MG = 20;

// A figure with two digits that count.
const precise = v => !Number.isFinite(v) ? "–" : Math.abs(v) < 0.995 ? v.toFixed(2) : Math.abs(v) < 9.95 ? v.toFixed(1) : v.toFixed(0);
const limited = (v, low, high) => Math.max(low, Math.min(high, v));

function label(pen, text, x, y, colour, align = "left") {
  pen.font = SMALL;
  pen.textBaseline = "middle";
  pen.textAlign = align;
  pen.fillStyle = colour;
  pen.fillText(text, x, y);
}

function curve(pen, points, colour, width = 1, dash = []) {
  pen.strokeStyle = colour;
  pen.lineWidth = width;
  pen.lineJoin = "round";
  pen.setLineDash(dash);
  pen.beginPath();
  // A point that is null lifts the pen.
  points.forEach((p, i) => p && (points[i - 1] ? pen.lineTo(...p) : pen.moveTo(...p)));
  pen.stroke();
  pen.setLineDash([]);
}

const rule = (pen, left, right, y, colour, dash) => curve(pen, [[left, y], [right, y]], colour, 1, dash);

class Strip {
  constructor(canvas) {
    this.canvas = canvas;
    this.reset();
  }

  reset() {
    Object.assign(this, { points: [], now_s: 0, half: 0.05, limit: null, due: true });
  }

  push(t_s, norm, noise_mg, limit_mg) {
    if (![t_s, norm, noise_mg].every(Number.isFinite) || norm <= 0) return;
    // A new session begins anew.
    if (t_s < this.now_s - 1) this.reset();
    this.points.push([t_s, norm, noise_mg]);
    while (this.points[0][0] < t_s - SPAN_S) this.points.shift();
    Object.assign(this, { now_s: t_s, limit: limit_mg, due: true });
  }

  // `marks` [{ from, to, kind }]: spans of time that became poses or did not; `gravity` in m/s².
  draw(ink, marks, gravity) {
    const area = this.due && prepare(this.canvas);
    if (!area) return;
    const { pen, width, height } = area, { points } = this;
    const left = 44, right = width - 6, top = 16, gap = 22, high = (height - top - gap - 18) / 2;
    const x = t => left + (1 + (t - this.now_s) / SPAN_S) * (right - left);
    // A knock does not flatten what is looked at: beyond half a g the line is cut off.
    const far = Math.max(0.04, ...points.map(p => Math.abs(p[1] - 1)));
    const off = Math.min(0.5, far * 1.15) - this.half;
    this.half += 0.25 * off;
    this.due = Math.abs(0.75 * off) > 0.002;
    const decades = Math.log10(limited(Math.max(...points.map(p => p[2])), 100, 1000));
    const upper = { bottom: top + high, y: v => upper.bottom - (limited((v - 1) / this.half, -1, 1) + 1) / 2 * high };
    const lower = { bottom: upper.bottom + gap + high, y: v => lower.bottom - limited(Math.log10(Math.max(v, 1)) / decades, 0, 1) * high };
    for (const mark of marks) {
      const a = Math.max(left, x(mark.from)), b = Math.min(right, x(mark.to));
      if (b <= left) continue;
      const [tint, colour, sign] = { done: [ink.goodTint, ink.good, "✓"], cross: [ink.poorTint, ink.poor, "✕"] }[mark.kind] ?? [ink.accentTint, "", ""];
      pen.fillStyle = tint;
      pen.fillRect(a, top, Math.max(1, b - a), lower.bottom - top);
      label(pen, sign, (a + b) / 2, lower.bottom - 8, colour, "center");
    }
    const digits = this.half * gravity < 1 ? 2 : 1;
    const norms = [-0.75, 0, 0.75].map(k => 1 + k * this.half).map(v => [v, (v * gravity).toFixed(digits)]);
    const noises = [1, 10, 100, 1000].filter(v => Math.log10(v) <= decades + 1e-9).map(v => [v, String(v)]);
    for (const [i, title, { bottom, y }, ticks, colour] of [[1, "‖a‖, m/s²", upper, norms, ink.accent], [2, "scatter, mg", lower, noises, ink.ink]]) {
      rule(pen, left, right, bottom, ink.strong);
      label(pen, title, left, bottom - high - 8, ink.muted);
      for (const [v, text] of ticks) label(pen, text, left - 6, y(v), ink.muted, "right");
      // The line is broken where no status came for a second.
      curve(pen, points.flatMap((p, k) => [...k && p[0] - points[k - 1][0] > 1 ? [null] : [], [x(p[0]), y(p[i])]]), colour, 1.6);
    }
    rule(pen, left, right, upper.y(1), ink.muted, [2, 3]);
    if (this.limit) {
      const y = lower.y(this.limit), text = `limit ${precise(this.limit)}`;
      rule(pen, left, right, y, ink.fair, [6, 4]);
      pen.lineWidth = 4;
      pen.strokeStyle = ink.card;
      pen.textAlign = "left";
      pen.strokeText(text, left + 2, y + 8);
      label(pen, text, left + 2, y + 8, ink.fair);
    }
    label(pen, "now", right, height - 8, ink.muted, "right");
    label(pen, "−1 min", left, height - 8, ink.muted);
  }
}

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
    const area = this.due && prepare(this.canvas);
    if (!area) return;
    this.due = false;
    const { pen, width, height } = area, { errors } = this;
    const left = 50, right = width - 10, top = 8, bottom = height - 20;
    const all = errors.flatMap(e => e.slice(1)).filter(mg => mg > 0);
    const low = Math.min(1, ...all.map(v => 10 ** Math.floor(Math.log10(v)))), high = Math.max(100, ...all.map(v => v * 1.2));
    const counts = errors.map(([n]) => n), least = Math.min(4, ...counts), most = Math.max(10, ...counts.map(n => n + 1));
    const x = n => left + (n - least + 0.3) / (most - least + 0.6) * (right - left);
    const y = v => bottom - Math.log10(v / low) / Math.log10(high / low) * (bottom - top);
    pen.fillStyle = ink.goodTint;
    pen.fillRect(left, y(GOOD_MG), right - left, bottom - y(GOOD_MG));
    for (let v = low; v <= high; v *= 10) {
      label(pen, `${v} mg`, left - 5, y(v), ink.muted, "right");
      rule(pen, left, right, y(v), ink.line);
    }
    // Errors fall from the left above to the right below: these corners are free of them.
    rule(pen, left, right, y(GOOD_MG), ink.good, [6, 4]);
    label(pen, "good: 5 mg", left + 3, y(GOOD_MG) + 8, ink.good);
    rule(pen, left, right, y(FAIR_MG), ink.fair, [6, 4]);
    label(pen, "fair: 20 mg", right - 3, y(FAIR_MG) - 8, ink.fair, "right");
    for (let n = least; n <= most; n += Math.ceil((most - least) / 8)) label(pen, String(n), x(n), height - 8, ink.muted, "center");
    label(pen, "poses", left - 5, height - 8, ink.muted, "right");
    if (!errors.length) return label(pen, "from the fourth pose on", (left + right) / 2, y(60), ink.muted, "center");
    const worst = errors.map(e => [x(e[0]), y(e[1])]);
    const hidden = errors.filter(e => e[2] > 0).map(e => [x(e[0]), y(e[2])]);
    curve(pen, hidden, ink.poor, 1.6, [4, 3]);
    pen.fillStyle = ink.poor;
    for (const [a, b] of hidden) pen.fill(new Path2D(`M${a},${b - 5} l4.5,8.5 h-9Z`));
    curve(pen, worst, ink.accent, 2);
    pen.fillStyle = ink.accent;
    for (const [a, b] of worst) pen.fill(new Path2D(`M${a - 4},${b} a4,4 0 1 0 8,0 a4,4 0 1 0 -8,0`));
  }
}
