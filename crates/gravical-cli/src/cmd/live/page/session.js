// What the events say, as one state that each event changes. Nothing here draws, sends or
// knows the time of day; a page that is loaded again gets the same events and is in the same state.
"use strict";

const MARKS = 400;
const LOG = 300;

const fresh = () => ({
  ports: null, connecting: null, session: null, identified: null, floor: null, status: null, next: null, fit: null, verdict: null,
  saved: null, truth: null, end: null, lost: null, candidate: null, notice: null, gravity: null,
  poses: new Map(), errors: new Map(), marks: [], log: [],
});

// A sentence of its own, whatever it was a part of; the name of an axis stays small.
const asSentence = text => {
  const t = cased(signed(text).trim());
  return t && t + (/[.!?…:]$/.test(t) ? "" : ".");
};
const cased = text => /^[a-z]{2}/.test(text) ? text[0].toUpperCase() + text.slice(1) : text;
// With the sign of a minus before names of faces and numbers, as it stands on the tiles.
const signed = text => String(text ?? "").replace(/(^|[\s(,/])-(?=[xyz]\b|\d)/g, "$1−");
const named = face => face ? faceName(face) : "free pose";

// The notice on top, and the line of the history.
function tell(state, t_s, kind, title, text, only_log) {
  state.log.push({ t_s, kind, title, text });
  if (state.log.length > LOG) state.log.shift();
  if (!only_log) state.notice = { t_s, kind, title, text };
}

function mark(state, to, kind, from = to) {
  if (!state.candidate) return;
  state.marks.push({ from: Math.min(from, state.candidate.t_s), to, kind });
  if (state.marks.length > MARKS) state.marks.shift();
  state.candidate = null;
}

const EVENTS = {
  ports: (_, e) => ({ ...fresh(), ports: e }),
  connecting: (_, e) => ({ ...fresh(), connecting: e }),
  session: (_, e) => ({ ...fresh(), session: e, gravity: e.gravity_mps2 }),
  identified(s, e) {
    s.identified = e;
    for (const note of e.notes || []) tell(s, e.t_s, "note", "", asSentence(note), true);
  },
  floor(s, e) {
    s.floor = e;
    const most = Math.max(...e.noise_mg);
    tell(s, e.t_s, "note", "At rest:", `noise up to ${precise(most)} mg; above ${precise(e.limit_mg)} mg it counts as moving.`, true);
  },
  status(s, e) { s.status = e; },
  // Why the hold before was rejected stays to be read: the next one can begin at once.
  pose_candidate(s, e) { s.candidate = e; },
  pose_accepted(s, e) {
    s.poses.set(e.pose, e);
    mark(s, e.t_s, "done", e.t_s - e.seconds);
    const title = e.face ? `${named(e.face)} is done.` : "Free pose done.";
    const text = `‖a‖ ${e.norm_mps2.toFixed(2)} m/s², noise ${precise(e.noise_mg)} mg. ${asSentence(e.note)}`;
    tell(s, e.t_s, "done", title, text.trim());
  },
  pose_rejected(s, e) {
    mark(s, e.t_s, "cross");
    tell(s, e.t_s, "cross", asSentence(e.message), asSentence(e.remedy));
  },
  pose_undone(s, e) {
    s.poses.delete(e.pose);
    for (const n of [...s.errors.keys()]) if (n > s.poses.size) s.errors.delete(n);
    if (s.poses.size < 4) s.fit = null;
    tell(s, e.t_s, "redo", `Pose ${e.pose} (${named(e.face)}) is taken back.`,
      e.why === "redo" && e.face ? `Put ${named(e.face)} up again.` : "The others are untouched.");
  },
  next_pose(s, e) { s.next = e; },
  fit(s, e) {
    s.fit = e;
    if (e.worst_mg > 0) s.errors.set(e.poses?.length || s.poses.size, [e.worst_mg, e.undetected_mg]);
  },
  verdict(s, e) {
    const before = s.verdict?.grade;
    s.verdict = e;
    if (e.grade !== before || e.final) {
      tell(s, e.t_s, "note", `Verdict: ${GRADES[e.grade]?.[0] ?? e.grade}.`, asSentence(e.sentence), true);
    }
  },
  warning(s, e) {
    // The page asks for gravity itself.
    tell(s, e.t_s, "warning", "", asSentence(e.message), e.kind === "gravity");
  },
  gravity(s, e) {
    s.session = { ...s.session, gravity_mps2: e.gravity_mps2, gravity_source: e.gravity_source };
    s.gravity = e.gravity_mps2;
  },
  saved(s, e) {
    s.saved = e;
    tell(s, e.t_s, "done", "Saved.", `${e.file}, read back and compared.`, true);
  },
  lost(s, e) {
    s.lost = e;
    if (s.candidate) mark(s, e.t_s, "cross");
    tell(s, e.t_s, "plug", "", asSentence(e.message), true);
    s.notice = null;
  },
  resumed(s, e) {
    s.lost = null;
    tell(s, e.t_s, "done", "", asSentence(e.message));
  },
  truth(s, e) { s.truth = e; },
  end(s, e) {
    s.end = e;
    s.notice = null;
    tell(s, e.t_s, e.reason === "finished" ? "done" : "warning", "End.", asSentence(e.message), true);
  },
};

// The state after an event; unknown events change nothing.
function after(state, event) {
  const change = Object.hasOwn(EVENTS, event.type) ? EVENTS[event.type] : null;
  return change?.(state, event) ?? state;
}

const GRADES = {
  "good": ["good", "done"],
  "fair": ["fair", "near"],
  "poor": ["poor", "cross"],
  "not-verifiable": ["not verifiable", "question"],
};

// Where the session stands, as one word.
function stage(state) {
  if (state.end) return "end";
  if (!state.session) return "connect";
  if (state.lost) return "lost";
  return state.status?.state ?? "identify";
}
