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

// The first sentence of a text, and the rest.
const parts = text => /^(.*?[.!?…])\s+(.*)$/s.exec(text)?.slice(1) ?? [text, ""];

// Events that stand in the history: their sign, and whether they are the notice on top, too.
const TOLD = {
  identified: ["note"], floor: ["note"], verdict: ["note"], gravity: ["note"], saved: ["done"], lost: ["plug"], end: ["note"],
  pose_accepted: ["done", true], pose_rejected: ["cross", true], pose_undone: ["redo", true], warning: ["warning", true], resumed: ["done", true],
};

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
  identified(s, e) { s.identified = e; },
  status(s, e) { s.status = e; },
  // Why the hold before was rejected stays to be read: the next one can begin at once.
  pose_candidate(s, e) { s.candidate = e; },
  pose_accepted(s, e) {
    s.poses.set(e.pose, e);
    mark(s, e.t_s, "done", e.t_s - e.seconds);
  },
  pose_rejected(s, e) { mark(s, e.t_s, "cross"); },
  pose_undone(s, e) {
    s.poses.delete(e.pose);
    for (const n of [...s.errors.keys()]) if (n > s.poses.size) s.errors.delete(n);
    if (s.poses.size < 4) s.fit = null;
  },
  next_pose(s, e) { s.next = e; },
  fit(s, e) {
    s.fit = e;
    if (e.worst_mg > 0) s.errors.set(e.poses, [e.worst_mg, e.undetected_mg]);
  },
  verdict(s, e) { s.verdict = e; },
  gravity(s, e) {
    s.session = { ...s.session, gravity_mps2: e.gravity_mps2, gravity_source: e.gravity_source };
    s.gravity = e.gravity_mps2;
  },
  saved(s, e) { s.saved = e; },
  lost(s, e) {
    s.lost = e;
    if (s.candidate) mark(s, e.t_s, "cross");
    s.notice = null;
  },
  resumed(s) { s.lost = null; },
  truth(s, e) { s.truth = e; },
  end(s, e) {
    s.end = e;
    s.notice = null;
  },
};

// The state after an event; unknown events change nothing.
function after(state, event) {
  const change = Object.hasOwn(EVENTS, event.type) ? EVENTS[event.type] : null;
  const next = change?.(state, event) ?? state;
  const [kind, is_notice] = Object.hasOwn(TOLD, event.type) ? TOLD[event.type] : [];
  if (!kind) return next;
  const told = { t_s: event.t_s, kind, text: event.text };
  next.log.push(told);
  if (next.log.length > LOG) next.log.shift();
  // The page asks for gravity itself.
  if (is_notice && event.kind !== "gravity") next.notice = told;
  return next;
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
