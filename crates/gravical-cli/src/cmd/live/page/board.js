// The board as a drawing: a breakout of the size of a GY-521, in mm, with z out of the side that
// carries the chip.
"use strict";

const BOARD = [21, 16, 1.6], CHIP = [4, 4, 1.1];
const LIGHT = unit(sum(sum(scaled(VIEW.right, -0.45), scaled(VIEW.near, 0.75)), [0, 0, 0.8]));
const AXIS_COLOURS = ["#D55E00", "#009E73", "#0072B2"];
// Where an axis leaves the board, where its arrow ends, where its name stands; mm.
const AXES = [[10.5, 16.5, 19.3], [8, 14, 16.8], [1.6, 10.5, 13.3]];
const FONT = "system-ui, 'DejaVu Sans', sans-serif";

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
    // Where the axes of the sensor point to: right, down and towards the camera.
    this.flat = this.world.map(w => [dot(w, VIEW.right), -dot(w, VIEW.up), dot(w, VIEW.near)]);
  }

  at(p) {
    return [0, 1].map(i => this.centre[i] + this.scale * dot(p, this.flat.map(axis => axis[i])));
  }

  // The sides of a box that are turned to the camera; `print` draws on those across z, in mm.
  box(centre, size, colour, edge, print) {
    const { pen, scale } = this;
    for (const axis of [0, 1, 2]) {
      if (Math.abs(this.flat[axis][2]) < 1e-3) continue;
      const sign = Math.sign(this.flat[axis][2]), [a, b] = [[1, 2], [0, 2], [0, 1]][axis];
      const normal = scaled(this.world[axis], sign), origin = [...centre];
      origin[axis] += sign * size[axis] / 2;
      pen.save();
      const [p, q] = [this.flat[a], this.flat[b]];
      pen.transform(scale * p[0], scale * p[1], scale * q[0], scale * q[1], ...this.at(origin));
      pen.fillStyle = shade(axis === 2 ? colour : edge, normal);
      pen.fillRect(-size[a] / 2, -size[b] / 2, size[a], size[b]);
      if (axis === 2) print(sign > 0, normal);
      pen.restore();
    }
  }

  disc(x, y, radius, colour) {
    this.pen.fillStyle = colour;
    this.pen.beginPath();
    this.pen.arc(x, y, radius, 0, 2 * Math.PI);
    this.pen.fill();
  }

  text(words, x, y, size) {
    const { pen } = this;
    pen.save();
    pen.translate(x, y);
    // Text goes down the page, y goes up.
    pen.scale(size / 10, -size / 10);
    pen.font = `600 10px ${FONT}`;
    pen.textAlign = "center";
    pen.textBaseline = "middle";
    pen.fillStyle = "rgba(255,255,255,.85)";
    pen.fillText(words, 0, 0);
    pen.restore();
  }

  // Pads and holes; what is written on each side.
  print(is_top, normal) {
    const gold = shade([212, 175, 74], normal);
    for (let x = -3.5 * 2.54; x < 9; x += 2.54) {
      this.disc(x, -6.4, 0.85, gold);
      this.disc(x, -6.4, 0.45, "rgb(20,24,30)");
    }
    for (const x of [-8.2, 8.2]) {
      this.disc(x, 5.7, 1.75, gold);
      this.disc(x, 5.7, 1.25, this.ink.card);
    }
    if (is_top) return this.text("ACCEL + GYRO", 0.6, 6, 1.3);
    // Seen from below it is written from the other side.
    this.pen.scale(-1, 1);
    this.text("−z", 0, 0.4, 4.4);
    this.text("back", 0, -2.9, 1.5);
  }

  chip() {
    this.box([0.6, 0.6, (BOARD[2] + CHIP[2]) / 2], CHIP, [38, 40, 44], [38, 40, 44], () => {
      this.disc(-1.4, 1.4, 0.3, "rgba(255,255,255,.75)");
      this.text("IMU", 0, -0.1, 1.25);
    });
  }

  arrow(axis) {
    const { pen, scale, ink } = this;
    const [a, b, name] = AXES[axis].map(d => this.at([0, 1, 2].map(i => i === axis ? d : 0)));
    const along = [b[0] - a[0], b[1] - a[1]], length = Math.hypot(...along);
    pen.lineCap = pen.lineJoin = "round";
    if (length > 1) {
      const head = Math.min(length, scale * 2.6), d = along.map(v => v / length);
      const neck = [b[0] - d[0] * head, b[1] - d[1] * head], wing = head * 0.45;
      const arrow = new Path2D(`M${a} L${neck} M${b} L${neck[0] - d[1] * wing},${neck[1] + d[0] * wing} ${neck[0] + d[1] * wing},${neck[1] - d[0] * wing}Z`);
      const thick = Math.max(2, scale * 0.5);
      // A border of paper: blue on a blue board is seen, too.
      for (const [colour, width] of [[ink.card, thick + 0.4 * scale], [AXIS_COLOURS[axis], thick]]) {
        pen.strokeStyle = pen.fillStyle = colour;
        pen.lineWidth = width;
        pen.stroke(arrow);
        pen.fill(arrow);
      }
    } else {
      this.disc(...b, scale * 0.7, AXIS_COLOURS[axis]);
    }
    pen.font = `700 ${Math.round(Math.max(13, 2.3 * scale))}px ${FONT}`;
    outlined(pen, "xyz"[axis], ...name, ink.ink, ink.card);
  }

  // What the board covers of the table, `height` mm straight below it.
  shadow(height) {
    const { pen, scale, centre, ink } = this, [x, y] = [scaled(this.world[0], BOARD[0] / 2), scaled(this.world[1], BOARD[1] / 2)];
    pen.fillStyle = ink.table;
    pen.beginPath();
    for (const [i, j] of [[1, 1], [1, -1], [-1, -1], [-1, 1]]) {
      const corner = sum(scaled(x, i), scaled(y, j));
      corner[2] = -height;
      pen.lineTo(centre[0] + scale * dot(corner, VIEW.right), centre[1] - scale * dot(corner, VIEW.up));
    }
    pen.closePath();
    pen.fill();
  }

  // With the arrows of these axes. What is on a side of the board is in front if that side is.
  draw(axes = [0, 1, 2]) {
    const is_front = axis => this.flat[axis][2] > 0;
    for (const axis of axes) if (!is_front(axis)) this.arrow(axis);
    if (!is_front(2)) this.chip();
    this.box([0, 0, 0], BOARD, [28, 88, 158], [196, 178, 120], (is_top, normal) => this.print(is_top, normal));
    if (is_front(2)) this.chip();
    for (const axis of axes) if (is_front(axis)) this.arrow(axis);
  }
}

// Text with a border, in the middle of a place.
function outlined(pen, text, x, y, colour, border) {
  pen.textAlign = "center";
  pen.textBaseline = "middle";
  pen.lineWidth = 5;
  pen.lineJoin = "round";
  pen.strokeStyle = border;
  pen.strokeText(text, x, y);
  pen.fillStyle = colour;
  pen.fillText(text, x, y);
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
