// Short tones at what happens, which can be muted.

// Notes one after the other: [hertz, seconds].
const SOUNDS = {
  pose_accepted: [[660, 0.1], [880, 0.14]],
  pose_rejected: [[196, 0.28]],
  pose_undone: [[440, 0.08]],
  lost: [[330, 0.14], [196, 0.24]],
  resumed: [[330, 0.1], [440, 0.12]],
  saved: [[523, 0.1], [659, 0.1], [784, 0.2]],
};

const sound = {
  context: null,
  silent: false,
  // What was chosen before; a browser may be set to store nothing.
  read() {
    try { this.silent = localStorage.getItem("gravical-silent") === "1"; } catch { /* nothing is kept */ }
  },
  toggle() {
    this.silent = !this.silent;
    try { localStorage.setItem("gravical-silent", this.silent ? "1" : "0"); } catch { /* for this page only */ }
    this.play("pose_undone");
  },
  // Browsers let a page sound after the first key or click on it.
  wake() {
    this.context ??= new AudioContext();
    if (this.context.state === "suspended") this.context.resume();
  },
  play(event) {
    if (this.silent || this.context?.state !== "running") return;
    let at = this.context.currentTime + 0.01;
    for (const [hertz, seconds] of SOUNDS[event] ?? []) {
      const tone = this.context.createOscillator(), gain = this.context.createGain();
      tone.frequency.value = hertz;
      // Rising and falling at once would click.
      gain.gain.setValueAtTime(0, at);
      gain.gain.setTargetAtTime(0.09, at, 0.005);
      gain.gain.setTargetAtTime(0, at + seconds - 0.03, 0.008);
      tone.connect(gain).connect(this.context.destination);
      tone.start(at);
      tone.stop(at + seconds);
      at += seconds;
    }
  },
};
