// Short tones at what happens, which can be muted.
"use strict";

const sound = {
  context: null,
  silent: false,
  toggle() {
    this.silent = !this.silent;
    // A browser may be set to store nothing.
    try { localStorage.setItem("gravical-silent", this.silent ? "1" : "0"); } catch { /* for this page only */ }
    this.label();
    if (!this.silent) this.play([[660, 0.08]]);
  },
  label() {
    const button = $("#mute");
    button.setAttribute("aria-pressed", String(this.silent));
    button.querySelector("use").setAttribute("href", this.silent ? "#silent" : "#sound");
    write(button.querySelector("span"), this.silent ? "Muted" : "Sound");
  },
  // Browsers let a page sound after the first key or click on it.
  wake() {
    this.context ??= new AudioContext();
    if (this.context.state === "suspended") this.context.resume();
  },
  // Notes one after the other: [hertz, seconds].
  play(notes) {
    if (this.silent || this.context?.state !== "running") return;
    let at = this.context.currentTime + 0.01;
    for (const [hertz, seconds] of notes) {
      const tone = this.context.createOscillator(), gain = this.context.createGain();
      tone.frequency.value = hertz;
      gain.gain.setValueAtTime(0, at);
      gain.gain.linearRampToValueAtTime(0.09, at + 0.012);
      gain.gain.setValueAtTime(0.09, at + seconds - 0.03);
      gain.gain.linearRampToValueAtTime(0, at + seconds);
      tone.connect(gain).connect(this.context.destination);
      tone.start(at);
      tone.stop(at + seconds);
      at += seconds;
    }
  },
};
const SOUNDS = {
  pose_accepted: [[660, 0.1], [880, 0.14]],
  pose_rejected: [[196, 0.28]],
  pose_undone: [[440, 0.08]],
  lost: [[330, 0.14], [196, 0.24]],
  resumed: [[330, 0.1], [440, 0.12]],
  saved: [[523, 0.1], [659, 0.1], [784, 0.2]],
};
