// Vectors as [x, y, z], rotations as quaternions [w, x, y, z] from the axes of the sensor to
// level ones with z up, and the camera that looks at them.
"use strict";

const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
const cross = (a, b) => [
  a[1] * b[2] - a[2] * b[1],
  a[2] * b[0] - a[0] * b[2],
  a[0] * b[1] - a[1] * b[0],
];
const scaled = (a, k) => [k * a[0], k * a[1], k * a[2]];
const sum = (a, b) => [a[0] + b[0], a[1] + b[1], a[2] + b[2]];
// Null for a vector without a direction, so that a bad reading moves nothing.
const unit = a => {
  const length = Math.hypot(...a);
  return length > 1e-9 && Number.isFinite(length) ? scaled(a, 1 / length) : null;
};
const angleDeg = (a, b) => Math.atan2(Math.hypot(...cross(a, b)), dot(a, b)) * 180 / Math.PI;

const product = (p, q) => [
  p[0] * q[0] - p[1] * q[1] - p[2] * q[2] - p[3] * q[3],
  p[0] * q[1] + p[1] * q[0] + p[2] * q[3] - p[3] * q[2],
  p[0] * q[2] - p[1] * q[3] + p[2] * q[0] + p[3] * q[1],
  p[0] * q[3] + p[1] * q[2] - p[2] * q[1] + p[3] * q[0],
];
const normalised = q => {
  const length = Math.hypot(...q);
  return length > 1e-9 && Number.isFinite(length) ? q.map(v => v / length) : [1, 0, 0, 0];
};
const rotated = (q, v) => {
  const axis = [q[1], q[2], q[3]], t = scaled(cross(axis, v), 2);
  return sum(sum(v, scaled(t, q[0])), cross(axis, t));
};
const turn = (axis, angle) => {
  const s = Math.sin(angle / 2);
  return [Math.cos(angle / 2), axis[0] * s, axis[1] * s, axis[2] * s];
};

// The smallest rotation that carries the unit vector a to b.
const shortest = (a, b) => {
  const cosine = dot(a, b);
  if (cosine < -0.999999) {
    const aside = Math.abs(a[0]) < 0.9 ? [1, 0, 0] : [0, 1, 0];
    return turn(unit(cross(a, aside)), Math.PI);
  }
  return normalised([1 + cosine, ...cross(a, b)]);
};

// Part of the way from p to q, along the shorter arc.
const between = (p, q, share) => {
  const sign = p[0] * q[0] + p[1] * q[1] + p[2] * q[2] + p[3] * q[3] < 0 ? -1 : 1;
  return normalised(p.map((v, i) => v + share * (sign * q[i] - v)));
};

// A camera far away: directions to the right, up and towards it. Parallel lines stay parallel,
// so that each plane of a body is one affine transformation of the canvas.
const camera = (azimuthDeg, elevationDeg) => {
  const a = azimuthDeg * Math.PI / 180, e = elevationDeg * Math.PI / 180;
  return {
    right: [-Math.sin(a), Math.cos(a), 0],
    up: [-Math.sin(e) * Math.cos(a), -Math.sin(e) * Math.sin(a), Math.cos(e)],
    near: [Math.cos(e) * Math.cos(a), Math.cos(e) * Math.sin(a), Math.sin(e)],
  };
};
const VIEW = camera(-62, 27);

// How a sensor lies whose direction `up` points up: gravity leaves the heading open, and the side
// with the chip is turned to the camera as far as that goes.
const lying = up => {
  const level = [Math.cos(-0.72), Math.sin(-0.72), 0];
  const align = shortest(up, [0, 0, 1]);
  const top = rotated(align, [0, 0, 1]);
  if (Math.hypot(top[0], top[1]) < 0.05) {
    // It lies flat: x goes to the right.
    const x = rotated(align, [1, 0, 0]);
    return normalised(product(turn([0, 0, 1], -Math.atan2(x[1], x[0])), align));
  }
  const heading = Math.atan2(level[1], level[0]) - Math.atan2(top[1], top[0]);
  return normalised(product(turn([0, 0, 1], heading), align));
};

// The angle about the vertical that brings the attitude q closest to another one; none where they are
// nearly upside down to each other and any would do.
const headingTo = (target, q) => {
  const p = product(target, [q[0], -q[1], -q[2], -q[3]]);
  return Math.hypot(p[0], p[3]) > 0.3 ? 2 * Math.atan2(p[3], p[0]) : null;
};

const FACES = ["+x", "-x", "+y", "-y", "+z", "-z"];
const directionOf = face => {
  const axis = "xyz".indexOf(face[1]), d = [0, 0, 0];
  if (axis >= 0) d[axis] = face[0] === "-" ? -1 : 1;
  return d;
};
// A minus is as wide as a plus.
const faceName = face => face.replace("-", "−");
