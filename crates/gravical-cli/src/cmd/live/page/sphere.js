// The sphere of directions that pointed up: faces, poses, the next best one, and up now.
"use strict";

class Sphere {
  constructor(canvas) {
    Object.assign(this, { canvas, azimuth: -50, elevation: 24, wanted: [-50, 24], turned: false, due: true });
    dragged(canvas, (right, down) => {
      this.turned = true;
      this.azimuth -= 0.6 * right;
      this.elevation = Math.max(-85, Math.min(85, this.elevation + 0.6 * down));
      this.due = true;
    });
  }

  // Turns so that this direction is in front, unless somebody has turned the sphere.
  face([x, y, z]) {
    const azimuth = Math.hypot(x, y) > 0.15 ? Math.atan2(y, x) * 180 / Math.PI - 28 : this.wanted[0];
    this.wanted = [azimuth, Math.max(-50, Math.min(50, Math.asin(Math.max(-1, Math.min(1, z))) * 34 + 14))];
  }

  // What is drawn: poses [{ up, face, suspect }], next (a direction or null), up (now).
  show(content) {
    this.content = content;
    this.due = true;
  }

  draw(ink, still) {
    const by = ((this.wanted[0] - this.azimuth + 540) % 360) - 180, up = this.wanted[1] - this.elevation;
    if (!this.turned && Math.abs(by) + Math.abs(up) > 0.3) {
      const share = still ? 1 : 0.06;
      this.azimuth += share * by;
      this.elevation += share * up;
      this.due = true;
    }
    const area = this.due && this.content && prepare(this.canvas);
    if (!area) return;
    this.due = false;
    const { pen, width, height } = area, radius = Math.min(width, height) / 2 - 21, middle = [width / 2, height / 2];
    const view = camera(this.azimuth, this.elevation);
    const at = d => [middle[0] + radius * dot(d, view.right), middle[1] - radius * dot(d, view.up), dot(d, view.near)];
    this.globe(pen, at, middle, radius, ink);
    const faces = FACES.map(face => ({ face, up: directionOf(face) }));
    const { poses, next, up: now } = this.content;
    for (const { face, up } of faces) {
      const [x, y, depth] = at(up), away = [x - middle[0], y - middle[1]], length = Math.hypot(...away) || 1;
      pen.font = `600 12px ${FONT}`;
      pen.textAlign = "center";
      pen.textBaseline = "middle";
      pen.fillStyle = depth < -0.05 ? ink.muted : ink.ink;
      pen.fillText(faceName(face), x + away[0] / length * 15, y + away[1] / length * 13);
    }
    const marks = [
      ...faces.filter(f => !poses.some(p => p.face === f.face)).map(f => ({ up: f.up, kind: "open" })),
      ...poses.map(p => ({ up: p.up, kind: p.suspect ? "suspect" : "pose" })),
      ...(next ? [{ up: next, kind: "next" }] : []),
      ...(now ? [{ up: now, kind: "now" }] : []),
    ].map(m => ({ ...m, at: at(m.up) }));
    // The farthest first.
    for (const m of marks.sort((a, b) => a.at[2] - b.at[2])) this.mark(pen, m, ink);
  }

  globe(pen, at, [x, y], radius, ink) {
    const fill = pen.createRadialGradient(x - radius * 0.4, y - radius * 0.45, radius * 0.1, x, y, radius);
    fill.addColorStop(0, ink.card);
    fill.addColorStop(1, ink.tint);
    pen.fillStyle = fill;
    pen.strokeStyle = ink.strong;
    pen.lineWidth = 1.2;
    pen.beginPath();
    pen.arc(x, y, radius, 0, 2 * Math.PI);
    pen.fill();
    pen.stroke();
    for (const axis of [0, 1, 2]) {
      const circle = Array.from({ length: 73 }, (_, i) => {
        const d = [0, 0, 0];
        d[(axis + 1) % 3] = Math.cos(i * Math.PI / 36);
        d[(axis + 2) % 3] = Math.sin(i * Math.PI / 36);
        return at(d);
      });
      const part = is_seen => circle.map(p => is_seen(p[2]) ? [p[0], p[1]] : null);
      curve(pen, part(depth => depth <= 0.02), ink.line, 1.2, [3, 4]);
      curve(pen, part(depth => depth >= -0.02), ink.strong, 1.2);
    }
  }

  mark(pen, { kind, at: [x, y, depth] }, ink) {
    const is_behind = depth < -0.05, radius = is_behind ? 4.5 : 6;
    const circle = r => `M${x - r},${y} a${r},${r} 0 1 0 ${2 * r},0 a${r},${r} 0 1 0 ${-2 * r},0`;
    const [path, fill, border] = {
      open: [circle(5), ink.card, ink.muted],
      pose: [circle(radius), "#009E73", ink.ink],
      suspect: [circle(radius), "#D55E00", ink.ink],
      next: [`M${x},${y - 9} l9,9 -9,9 -9,-9Z`, "#E69F00", ink.ink],
      now: [`M${x},${y - 8} v16 M${x - 8},${y} h16`, "", ink.accent],
    }[kind];
    const shape = new Path2D(path), is_pose = kind === "pose" || kind === "suspect";
    pen.save();
    if (is_behind && kind !== "open") pen.globalAlpha = 0.5;
    pen.lineWidth = kind === "now" ? 3 : 1.6;
    pen.strokeStyle = border;
    pen.fillStyle = fill;
    if (fill && (is_pose || !is_behind)) pen.fill(shape);
    pen.stroke(shape);
    if (kind === "suspect") {
      pen.globalAlpha = 1;
      pen.font = `700 13px ${FONT}`;
      outlined(pen, "!", x + 10, y - 5, ink.poor, ink.card);
    }
    pen.restore();
  }
}
