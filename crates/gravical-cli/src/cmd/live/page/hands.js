// The hand of a simulated session: mouse, keys and buttons that lay the virtual board down.
"use strict";

class SimulatedHand {
  // `send` sends a command; `attitude()` is how the board lies now.
  constructor(canvas, send, attitude) {
    Object.assign(this, { send, attitude, on: false, preview: null, until: 0 });
    dragged(canvas, (right, down) => {
      this.turn(VIEW.up, 0.011 * right);
      this.turn(VIEW.right, 0.011 * down);
    }, () => this.on && this.take(), () => this.letGo());
    $("#shake").addEventListener("click", () => this.act({ shake: true }));
    $("#as-drawn").addEventListener("click", () => this.asDrawn());
  }

  take() {
    this.held = true;
    this.preview ??= this.attitude();
    clearTimeout(this.timer);
    return true;
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

  // Does something else with the board than what is drawn.
  act(what) {
    this.held = false;
    this.preview = null;
    clearTimeout(this.timer);
    this.send({ command: "hand", ...what });
  }

  // Holds it as the next pose is drawn.
  asDrawn() {
    if (this.next) this.act({ up: this.next });
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
    } else if (face) this.act({ put: face });
    else if (key === "s") this.act({ shake: true });
    else if (key === "n") this.asDrawn();
    else return false;
    return true;
  }
}
