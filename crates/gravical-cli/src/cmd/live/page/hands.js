// The hands of a simulated session: mouse, keys and buttons that lay the virtual board down.
"use strict";

class Hands {
  // `send` sends a command; `attitude()` is how the board lies now.
  constructor(canvas, send, attitude) {
    Object.assign(this, { canvas, send, attitude, on: false, preview: null, until: 0 });
    let last = null;
    canvas.addEventListener("pointerdown", e => {
      if (!this.on) return;
      last = [e.clientX, e.clientY];
      this.take();
      canvas.setPointerCapture(e.pointerId);
      e.preventDefault();
    });
    canvas.addEventListener("pointermove", e => {
      if (!last) return;
      this.turn(VIEW.up, 0.011 * (e.clientX - last[0]));
      this.turn(VIEW.right, 0.011 * (e.clientY - last[1]));
      last = [e.clientX, e.clientY];
    });
    for (const kind of ["pointerup", "pointercancel"]) {
      canvas.addEventListener(kind, () => {
        if (!last) return;
        last = null;
        this.letGo();
      });
    }
    document.getElementById("shake").addEventListener("click", () => this.shake());
    document.getElementById("as-drawn").addEventListener("click", () => this.asDrawn());
  }

  take() {
    this.held = true;
    this.preview ??= this.attitude();
    clearTimeout(this.timer);
  }

  turn(axis, angle) {
    this.preview = normalised(product(turn(axis, angle), this.preview));
  }

  // The board is laid down as it is drawn now, and is drawn so until it is there.
  letGo() {
    this.held = false;
    this.until = performance.now() + 2500;
    this.send({ command: "hand", up: this.up() });
  }

  up() {
    const [w, x, y, z] = this.preview;
    return rotated([w, -x, -y, -z], [0, 0, 1]);
  }

  lay(face) {
    this.forget();
    this.send({ command: "hand", put: face });
  }

  shake() {
    this.forget();
    this.send({ command: "hand", shake: true });
  }

  // Holds it as the next pose is drawn.
  asDrawn() {
    if (!this.next) return;
    this.forget();
    this.send({ command: "hand", up: this.next });
  }

  forget() {
    this.held = false;
    this.preview = null;
    clearTimeout(this.timer);
  }

  // How it is to be drawn in place of how it lies, or null.
  drawn(up) {
    if (!this.preview) return null;
    const there = up && angleDeg(up, this.up()) < 4;
    if (!this.held && (there || performance.now() > this.until)) this.preview = null;
    return this.preview;
  }

  key(key) {
    const flat = unit([VIEW.near[0], VIEW.near[1], 0]), step = Math.PI / 15;
    const turns = { ArrowLeft: [flat, -step], ArrowRight: [flat, step], ArrowUp: [VIEW.right, -step], ArrowDown: [VIEW.right, step] };
    const face = FACES[Number(key) - 1];
    if (turns[key]) {
      this.take();
      this.turn(...turns[key]);
      this.timer = setTimeout(() => this.letGo(), 450);
    } else if (face) this.lay(face);
    else if (key === "s" || key === "S") this.shake();
    else if (key === "n" || key === "N") this.asDrawn();
    else return false;
    return true;
  }
}
