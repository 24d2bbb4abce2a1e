// The board as a drawing: a breakout of the size of a GY-521, in mm, with z out of the side that
// carries the chip.
"use strict";

const BOARD = { size: [21, 16, 1.6], blue: [28, 88, 158], edge: [196, 178, 120] };
const PARTS = [
  // centre, size, colour
  { at: [0.6, 0.6], size: [4, 4, 1.1], colour: [38, 40, 44], chip: true },
  { at: [-6.3, 0.4], size: [3, 1.7, 1.2], colour: [44, 46, 50] },
  { at: [-6.3, 3.3], size: [2, 1.2, 0.7], colour: [186, 150, 96] },
  { at: [6.2, 2.6], size: [1.6, 0.9, 0.6], colour: [60, 62, 66] },
  { at: [6.2, 0.6], size: [1.6, 0.9, 0.6], colour: [60, 62, 66] },
  { at: [6.2, -1.4], size: [1.6, 0.9, 0.6], colour: [186, 150, 96] },
  { at: [-2.6, -2.6], size: [1.6, 0.9, 0.6], colour: [186, 150, 96] },
  { at: [3.1, 5.2], size: [1.7, 0.9, 0.6], colour: [214, 226, 214] },
];
const LIGHT = unit(sum(sum(scaled(VIEW.right, -0.45), scaled(VIEW.near, 0.75)), [0, 0, 0.8]));
const AXIS_COLOURS = ["#D55E00", "#009E73", "#0072B2"];
// Where an axis leaves the board, where its arrow ends, where its name stands; mm.
const AXES = [[10.5, 16.5, 19.3], [8, 14, 16.8], [1.6, 10.5, 13.3]];

// Canvas of the size it is shown in, in CSS pixels around its middle; null while it is hidden.
function prepare(canvas) {
  const width = canvas.clientWidth, height = canvas.clientHeight;
  if (!width || !height) return null;
  const density = Math.min(window.devicePixelRatio || 1, 3);
  const wide = Math.round(width * density), high = Math.round(height * density);
  if (canvas.width !== wide || canvas.height !== high) {
    canvas.width = wide;
    canvas.height = high;
  }
  const pen = canvas.getContext("2d");
  pen.setTransform(density, 0, 0, density, 0, 0);
  pen.clearRect(0, 0, width, height);
  return { pen, width, height };
}

const shade = (colour, normal) => {
  const k = 0.58 + 0.5 * Math.max(0, dot(normal, LIGHT));
  return `rgb(${colour.map(v => Math.round(Math.min(255, v * k))).join()})`;
};

class BoardDrawing {
  // `scale` in pixels per mm, `centre` in pixels.
  constructor(pen, centre, scale, attitude, ink) {
    Object.assign(this, { pen, centre, scale, ink });
    this.world = [[1, 0, 0], [0, 1, 0], [0, 0, 1]].map(v => rotated(attitude, v));
    this.flat = this.world.map(w => [dot(w, VIEW.right), -dot(w, VIEW.up), dot(w, VIEW.near)]);
  }

  at(p) {
    const [x, y, z] = this.flat;
    return [
      this.centre[0] + this.scale * (p[0] * x[0] + p[1] * y[0] + p[2] * z[0]),
      this.centre[1] + this.scale * (p[0] * x[1] + p[1] * y[1] + p[2] * z[1]),
    ];
  }

  // Draws in mm on the plane through `origin` along the axes of the sensor `u` and `v`.
  on(origin, u, v, draw) {
    const { pen, scale } = this, [x, y] = this.at(origin);
    const p = this.flat[u[0]], q = this.flat[v[0]];
    pen.save();
    pen.transform(u[1] * scale * p[0], u[1] * scale * p[1], v[1] * scale * q[0], v[1] * scale * q[1], x, y);
    draw(pen);
    pen.restore();
  }

  // The sides of a box that are turned to the camera; `top` draws on its upper one.
  box(centre, size, colours, radius, top, bottom) {
    for (const axis of [0, 1, 2]) {
      const sign = this.flat[axis][2] >= 0 ? 1 : -1;
      if (Math.abs(this.flat[axis][2]) < 1e-3) continue;
      const [a, b] = axis === 2 ? [0, 1] : axis === 0 ? [1, 2] : [0, 2];
      const origin = [...centre];
      origin[axis] += sign * size[axis] / 2;
      const normal = scaled(this.world[axis], sign);
      this.on(origin, [a, 1], [b, 1], pen => {
        pen.fillStyle = shade(colours[axis === 2 ? 0 : 1], normal);
        pen.beginPath();
        const r = axis === 2 ? radius : 0;
        pen.roundRect(-size[a] / 2, -size[b] / 2, size[a], size[b], r);
        pen.fill();
        if (axis === 2 && sign > 0 && top) top(pen, normal);
        if (axis === 2 && sign < 0 && bottom) bottom(pen, normal);
      });
    }
  }

  pads(pen, normal) {
    for (let i = 0; i < 8; i++) {
      const x = (i - 3.5) * 2.54;
      this.disc(pen, x, -6.4, 0.85, shade([212, 175, 74], normal));
      this.disc(pen, x, -6.4, 0.45, "rgb(20,24,30)");
    }
    for (const x of [-8.2, 8.2]) {
      this.disc(pen, x, 5.7, 1.75, shade([212, 175, 74], normal));
      this.disc(pen, x, 5.7, 1.25, this.ink.hole);
    }
  }

  disc(pen, x, y, radius, colour) {
    pen.fillStyle = colour;
    pen.beginPath();
    pen.arc(x, y, radius, 0, 2 * Math.PI);
    pen.fill();
  }

  top(pen, normal) {
    this.pads(pen, normal);
    pen.strokeStyle = pen.fillStyle = "rgba(255,255,255,.88)";
    pen.lineWidth = 0.22;
    pen.strokeRect(-1.9, -1.9, 5, 5);
    // The printed axes: what the arrows in space stand for.
    pen.beginPath();
    for (const [x, y] of [[3, 0], [0, 3]]) {
      pen.moveTo(-9.2, -3.3);
      pen.lineTo(-9.2 + x, -3.3 + y);
      pen.lineTo(-9.2 + x - (x ? 0.7 : 0.5), -3.3 + y - (x ? 0.5 : 0.7));
      pen.moveTo(-9.2 + x, -3.3 + y);
      pen.lineTo(-9.2 + x - (x ? 0.7 : -0.5), -3.3 + y - (x ? -0.5 : 0.7));
    }
    pen.stroke();
    this.text(pen, "X", -5.6, -3.3, 1.4);
    this.text(pen, "Y", -9.2, 0.6, 1.4);
    this.text(pen, "ACCEL + GYRO", 5.3, 7.1 - 0.4, 1.05, "right");
    this.text(pen, "VCC GND SCL SDA XDA XCL AD0 INT".split(" "), 0, -4.75, 0.78);
  }

  bottom(pen, normal) {
    this.pads(pen, normal);
    pen.fillStyle = "rgba(255,255,255,.8)";
    // Seen from below, so that it is written from the other side.
    pen.scale(-1, 1);
    this.text(pen, "−z", 0, 0.4, 4.4);
    this.text(pen, "back", 0, -2.9, 1.5);
  }

  text(pen, words, x, y, size, align = "center") {
    pen.save();
    pen.translate(x, y);
    // Text goes down the page, y goes up.
    pen.scale(size / 10, -size / 10);
    pen.font = "600 10px system-ui, 'DejaVu Sans', sans-serif";
    pen.textAlign = align;
    pen.textBaseline = "middle";
    if (Array.isArray(words)) {
      words.forEach((word, i) => pen.fillText(word, (i - 3.5) * 2.54 * 10 / size, 0));
    } else {
      pen.fillText(words, 0, 0);
    }
    pen.restore();
  }

  arrow(axis) {
    const { pen } = this, [from, to, name] = AXES[axis];
    const point = d => this.at([0, 1, 2].map(i => i === axis ? d : 0));
    const [a, b, c] = [point(from), point(to), point(name)];
    const along = [b[0] - a[0], b[1] - a[1]], length = Math.hypot(...along);
    const thick = Math.max(2, this.scale * 0.5);
    pen.lineCap = pen.lineJoin = "round";
    if (length > 1) {
      const head = Math.min(length, this.scale * 2.6), d = scaled([...along, 0], 1 / length);
      const neck = [b[0] - d[0] * head, b[1] - d[1] * head];
      const shaft = new Path2D(), tip = new Path2D();
      shaft.moveTo(...a);
      shaft.lineTo(...neck);
      tip.moveTo(...b);
      tip.lineTo(neck[0] - d[1] * head * 0.45, neck[1] + d[0] * head * 0.45);
      tip.lineTo(neck[0] + d[1] * head * 0.45, neck[1] - d[0] * head * 0.45);
      tip.closePath();
      // A border of paper: blue on a blue board is seen, too.
      pen.strokeStyle = this.ink.paper;
      pen.lineWidth = thick + 0.4 * this.scale;
      pen.stroke(shaft);
      pen.lineWidth = 0.4 * this.scale;
      pen.stroke(tip);
      pen.strokeStyle = pen.fillStyle = AXIS_COLOURS[axis];
      pen.lineWidth = thick;
      pen.stroke(shaft);
      pen.fill(tip);
    } else {
      this.disc(pen, ...b, this.scale * 0.7, AXIS_COLOURS[axis]);
    }
    pen.font = `700 ${Math.round(Math.max(13, 2.3 * this.scale))}px system-ui, 'DejaVu Sans', sans-serif`;
    pen.textAlign = "center";
    pen.textBaseline = "middle";
    pen.lineWidth = 5;
    pen.lineJoin = "round";
    pen.strokeStyle = this.ink.paper;
    pen.strokeText("xyz"[axis], ...c);
    pen.fillStyle = this.ink.ink;
    pen.fillText("xyz"[axis], ...c);
  }

  // What the board covers of the table straight below it.
  shadow(height) {
    const { pen } = this, corners = [];
    for (const x of [-1, 1]) for (const y of [-1, 1]) for (const z of [-1, 1]) {
      const p = BOARD.size.map((s, i) => [x, y, z][i] * s / 2);
      const w = sum(sum(scaled(this.world[0], p[0]), scaled(this.world[1], p[1])), scaled(this.world[2], p[2]));
      const v = [w[0], w[1], -height];
      corners.push([
        this.centre[0] + this.scale * dot(v, VIEW.right),
        this.centre[1] - this.scale * dot(v, VIEW.up),
      ]);
    }
    pen.fillStyle = this.ink.shadow;
    pen.beginPath();
    hull(corners).forEach((p, i) => i ? pen.lineTo(...p) : pen.moveTo(...p));
    pen.closePath();
    pen.fill();
  }

  // With the arrows of these axes.
  draw(axes = [0, 1, 2]) {
    // An arrow stands beyond one side of the board: it is in front if that side is.
    const front = axis => this.flat[axis][2] > 0;
    for (const axis of axes) if (!front(axis)) this.arrow(axis);
    const parts = [...PARTS].sort((a, b) => this.depth(a.at) - this.depth(b.at));
    const drawParts = () => {
      for (const part of parts) {
        this.box([...part.at, BOARD.size[2] / 2 + part.size[2] / 2], part.size, [part.colour, part.colour], 0.15,
          pen => part.chip && this.chip(pen));
      }
    };
    if (!front(2)) drawParts();
    this.box([0, 0, 0], BOARD.size, [BOARD.blue, BOARD.edge], 0.6, (p, n) => this.top(p, n), (p, n) => this.bottom(p, n));
    if (front(2)) drawParts();
    for (const axis of axes) if (front(axis)) this.arrow(axis);
  }

  depth(p) {
    return p[0] * this.flat[0][2] + p[1] * this.flat[1][2];
  }

  chip(pen) {
    this.disc(pen, -1.4, 1.4, 0.3, "rgba(255,255,255,.75)");
    pen.fillStyle = "rgba(255,255,255,.75)";
    this.text(pen, "IMU", 0, -0.1, 1.25);
  }
}

// The convex outline of points, by monotone chains.
function hull(points) {
  const sorted = [...points].sort((a, b) => a[0] - b[0] || a[1] - b[1]);
  const half = list => {
    const out = [];
    for (const p of list) {
      while (out.length > 1) {
        const [a, b] = out.slice(-2);
        if ((b[0] - a[0]) * (p[1] - a[1]) - (b[1] - a[1]) * (p[0] - a[0]) > 0) break;
        out.pop();
      }
      out.push(p);
    }
    return out.slice(0, -1);
  };
  return [...half(sorted), ...half(sorted.reverse())];
}

// The board in the middle of a canvas.
function drawBoard(canvas, attitude, ink, options = {}) {
  const area = prepare(canvas);
  if (!area) return;
  const { pen, width, height } = area;
  const scale = Math.min(width, height) / (options.span || 44);
  const centre = [width / 2, height * (options.low || 0.5)];
  const drawing = new BoardDrawing(pen, centre, scale, attitude, ink);
  if (options.shadow) drawing.shadow(options.shadow);
  drawing.draw(options.axes);
}
