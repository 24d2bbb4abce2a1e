// The sphere of directions that pointed up: faces, poses, the next best one, and up now.
"use strict";

class Sphere {
  constructor(canvas) {
    this.canvas = canvas;
    this.azimuth = -50;
    this.elevation = 24;
    this.wanted = { azimuth: -50, elevation: 24 };
    this.turned = false;
    let last = null;
    canvas.addEventListener("pointerdown", e => {
      last = [e.clientX, e.clientY];
      canvas.setPointerCapture(e.pointerId);
    });
    canvas.addEventListener("pointermove", e => {
      if (!last) return;
      this.turned = true;
      this.azimuth -= 0.6 * (e.clientX - last[0]);
      this.elevation = Math.max(-85, Math.min(85, this.elevation + 0.6 * (e.clientY - last[1])));
      last = [e.clientX, e.clientY];
      this.due = true;
    });
    for (const kind of ["pointerup", "pointercancel"]) canvas.addEventListener(kind, () => { last = null; });
    this.due = true;
  }

  // Turns so that this direction is in front, unless somebody has turned the sphere.
  face(direction) {
    if (this.turned) return;
    const flat = Math.hypot(direction[0], direction[1]);
    this.wanted = {
      azimuth: flat > 0.15 ? Math.atan2(direction[1], direction[0]) * 180 / Math.PI - 28 : this.wanted.azimuth,
      elevation: Math.max(-50, Math.min(50, Math.asin(Math.max(-1, Math.min(1, direction[2]))) * 57.3 * 0.6 + 14)),
    };
  }

  // What is drawn: poses [{ up, face, suspect }], next (a direction or null), up (now).
  show(content) {
    this.content = content;
    this.due = true;
  }

  draw(ink, still) {
    if (!this.turned) {
      const by = ((this.wanted.azimuth - this.azimuth + 540) % 360) - 180, up = this.wanted.elevation - this.elevation;
      if (Math.abs(by) + Math.abs(up) > 0.3) {
        const share = still ? 1 : 0.06;
        this.azimuth += share * by;
        this.elevation += share * up;
        this.due = true;
      }
    }
    if (!this.due || !this.content) return;
    const area = prepare(this.canvas);
    if (!area) return;
    this.due = false;
    const { pen, width, height } = area, radius = Math.min(width, height) / 2 - 21;
    const view = camera(this.azimuth, this.elevation);
    const at = d => [width / 2 + radius * dot(d, view.right), height / 2 - radius * dot(d, view.up), dot(d, view.near)];
    this.globe(pen, at, width / 2, height / 2, radius, ink);
    const faces = FACES.map(face => ({ face, up: directionOf(face) }));
    const { poses, next, up } = this.content;
    for (const f of faces) this.name(pen, f, at, ink);
    const marks = [
      ...faces.filter(f => !poses.some(p => p.face === f.face)).map(f => ({ ...f, kind: "open" })),
      ...poses.map(p => ({ ...p, kind: "pose" })),
      ...(next ? [{ up: next, kind: "next" }] : []),
      ...(up ? [{ up, kind: "now" }] : []),
    ].map(m => ({ ...m, at: at(m.up) }));
    marks.sort((a, b) => a.at[2] - b.at[2]);
    for (const m of marks) this.mark(pen, m, ink);
  }

  globe(pen, at, x, y, radius, ink) {
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
      for (const front of [false, true]) {
        pen.strokeStyle = front ? ink.strong : ink.line;
        pen.setLineDash(front ? [] : [3, 4]);
        pen.beginPath();
        let down = false;
        for (let i = 0; i <= 72; i++) {
          const a = i * Math.PI / 36, d = [0, 0, 0];
          d[(axis + 1) % 3] = Math.cos(a);
          d[(axis + 2) % 3] = Math.sin(a);
          const p = at(d);
          const seen = front ? p[2] >= -0.02 : p[2] <= 0.02;
          if (seen && down) pen.lineTo(p[0], p[1]);
          else if (seen) pen.moveTo(p[0], p[1]);
          down = seen;
        }
        pen.stroke();
      }
    }
    pen.setLineDash([]);
  }

  name(pen, { face, up }, at, ink) {
    const p = at(scaled(up, 1.001)), middle = at([0, 0, 0]);
    const away = [p[0] - middle[0], p[1] - middle[1]], length = Math.hypot(...away) || 1;
    const x = p[0] + away[0] / length * 15, y = p[1] + away[1] / length * 13;
    pen.font = "600 12px system-ui, 'DejaVu Sans', sans-serif";
    pen.textAlign = "center";
    pen.textBaseline = "middle";
    pen.fillStyle = p[2] < -0.05 ? ink.muted : ink.ink;
    pen.fillText(faceName(face), x, y);
  }

  mark(pen, { kind, at: [x, y, depth], suspect }, ink) {
    const behind = depth < -0.05;
    pen.save();
    pen.lineWidth = 1.6;
    pen.strokeStyle = behind ? ink.muted : ink.ink;
    pen.beginPath();
    if (kind === "open") {
      pen.strokeStyle = ink.muted;
      pen.arc(x, y, 5, 0, 2 * Math.PI);
      if (!behind) { pen.fillStyle = ink.card; pen.fill(); }
      pen.stroke();
    } else if (kind === "pose") {
      pen.arc(x, y, behind ? 4.5 : 6, 0, 2 * Math.PI);
      pen.fillStyle = suspect ? "#D55E00" : "#009E73";
      if (behind) pen.globalAlpha = 0.45;
      pen.fill();
      pen.stroke();
      if (suspect) {
        pen.globalAlpha = 1;
        pen.font = "700 13px system-ui, 'DejaVu Sans', sans-serif";
        pen.fillStyle = ink.poor;
        pen.textAlign = "left";
        pen.fillText("!", x + 8, y - 5);
      }
    } else if (kind === "next") {
      pen.moveTo(x, y - 9);
      pen.lineTo(x + 9, y);
      pen.lineTo(x, y + 9);
      pen.lineTo(x - 9, y);
      pen.closePath();
      if (behind) pen.setLineDash([3, 2]);
      else { pen.fillStyle = "#E69F00"; pen.fill(); }
      pen.stroke();
    } else {
      pen.lineWidth = 3;
      pen.strokeStyle = ink.accent;
      if (behind) { pen.globalAlpha = 0.55; pen.lineWidth = 2; }
      pen.moveTo(x, y - 8);
      pen.lineTo(x, y + 8);
      pen.moveTo(x - 8, y);
      pen.lineTo(x + 8, y);
      pen.stroke();
    }
    pen.restore();
  }
}
