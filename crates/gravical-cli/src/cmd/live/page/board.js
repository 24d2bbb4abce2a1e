// How the board lies, and how it is drawn. Rotations are quaternions [w, x, y, z] from the axes of the sensor
// to level ones with z up.

const dot = (a, b) => a.reduce((sum, v, i) => sum + v * b[i], 0);
const cross = (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
const angleDeg = (a, b) => Math.atan2(Math.hypot(...cross(a, b)), dot(a, b)) * 180 / Math.PI;
const normalised = q => {
  const length = Math.hypot(...q);
  return length > 1e-9 && Number.isFinite(length) ? q.map(v => v / length) : [1, 0, 0, 0];
};
const product = ([a, ...u], [b, ...v]) => [a * b - dot(u, v), ...cross(u, v).map((w, i) => a * v[i] + b * u[i] + w)];
const inverse = ([w, ...v]) => [w, ...v.map(c => -c)];
const rotated = (q, v) => product(product(q, [0, ...v]), inverse(q)).slice(1);
const turn = (axis, angle) => [Math.cos(angle / 2), ...axis.map(v => v * Math.sin(angle / 2))];
const turnedLevel = (angle, q) => normalised(product(turn([0, 0, 1], angle), q));
// The direction in the axes of the sensor that is up.
const upOf = q => rotated(inverse(q), [0, 0, 1]);

// The style sheet looks from this azimuth. Horizontal directions to the right of it, and towards it.
const AZIMUTH = -62 * Math.PI / 180;
const RIGHT = [-Math.sin(AZIMUTH), Math.cos(AZIMUTH), 0], NEAR = [Math.cos(AZIMUTH), Math.sin(AZIMUTH), 0];

const FACES = ["+x", "-x", "+y", "-y", "+z", "-z"];
const directionOf = face => [..."xyz"].map(axis => axis === face[1] ? Number(`${face[0]}1`) : 0);
// A minus is as wide as a plus.
const faceName = face => face.replace("-", "−");

// How a sensor lies whose direction `up` points up. Gravity leaves the heading open: the side with the chip is
// turned to the camera; where it is level, x points to the right.
function lying(up) {
  const [x, y, z] = normalised([0, ...up]).slice(1);
  const level = z > -0.999999 ? normalised([1 + z, y, -x, 0]) : [0, 1, 0, 0];
  const top = rotated(level, [0, 0, 1]), is_flat = Math.hypot(top[0], top[1]) < 0.05;
  const [east, north] = is_flat ? rotated(level, [1, 0, 0]) : top;
  return turnedLevel((is_flat ? 0 : -0.72) - Math.atan2(north, east), level);
}

// The angle about the vertical that brings the attitude q closest to another one; none where they are
// nearly upside down to each other and any would do.
function headingTo(target, q) {
  const [w, , , z] = product(target, inverse(q));
  return Math.hypot(w, z) > 0.3 ? 2 * Math.atan2(z, w) : null;
}

// Puts a drawing of the board into an element.
function draw(place, q) {
  place.append(document.querySelector("#drawing").content.cloneNode(true));
  drawAttitude(place, q);
}

// A rotation in the axes of the page, where y points down, as a matrix: between two the browser turns the short way.
function matrix([w, x, y, z]) {
  const columns = [[1, 0, 0], [0, 1, 0], [0, 0, 1]].map(axis => [...rotated([w, -x, y, -z], axis), 0]);
  return `matrix3d(${columns.join()},0,0,0,1)`;
}

// Turns a drawing. Less than 0.3° is noise.
function drawAttitude(place, q) {
  if (place.drawn && Math.abs(dot(q, place.drawn)) > 1 - 3e-6) return;
  place.drawn = q;
  place.style.setProperty("--attitude", matrix(q));
  place.style.setProperty("--level", matrix(inverse(q)));
}
