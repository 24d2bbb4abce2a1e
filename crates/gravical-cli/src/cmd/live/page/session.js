// What the events say, as one state that each event changes. Nothing here draws, sends or
// knows the time of day; a page that is loaded again gets the same events and is in the same state.
"use strict";

const MARKS = 400;
const LOG = 300;

// The latest event of each type, and what becomes of them.
const fresh = () => ({
  ports: null, connecting: null, session: null, identified: null, status: null, pose_candidate: null, next_pose: null,
  fit: null, verdict: null, saved: null, truth: null, lost: null, end: null,
  notice: null, poses: new Map(), errors: new Map(), marks: [], log: [],
});

// The first sentence of a text, and the rest.
const parts = text => /^(.*?[.!?…])\s+(.*)$/s.exec(text)?.slice(1) ?? [text, ""];

// Events that stand in the history: their sign, and whether they are the notice on top, too.
const TOLD = {
  identified: ["note"], floor: ["note"], verdict: ["note"], gravity: ["note"], saved: ["done"], lost: ["plug"], end: ["note"],
  pose_accepted: ["done", true], pose_rejected: ["cross", true], pose_undone: ["redo", true], warning: ["warning", true], resumed: ["done", true],
};

function mark(state, to, kind, from = to) {
  if (!state.pose_candidate) return;
  state.marks.push({ from: Math.min(from, state.pose_candidate.t_s), to, kind });
  if (state.marks.length > MARKS) state.marks.shift();
  state.pose_candidate = null;
}

// What an event changes beside what it says itself, which is kept under its type.
const EVENTS = {
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
  fit(s, e) { if (e.worst_mg > 0) s.errors.set(e.poses, [e.worst_mg, e.undetected_mg]); },
  gravity(s, { gravity_mps2, gravity_source }) { Object.assign(s.session, { gravity_mps2, gravity_source }); },
  lost(s, e) {
    mark(s, e.t_s, "cross");
    s.notice = null;
  },
  resumed(s) { s.lost = null; },
  end(s) { s.notice = null; },
};

// The state after an event; what comes before a session begins anew.
function after(state, event) {
  const next = ["ports", "connecting", "session"].includes(event.type) ? fresh() : state;
  if (Object.hasOwn(next, event.type)) next[event.type] = event;
  if (Object.hasOwn(EVENTS, event.type)) EVENTS[event.type](next, event);
  const [kind, is_notice] = Object.hasOwn(TOLD, event.type) ? TOLD[event.type] : [];
  if (!kind) return next;
  const told = { t_s: event.t_s, kind, text: event.text };
  next.log.push(told);
  if (next.log.length > LOG) next.log.shift();
  // The page asks for gravity itself.
  if (is_notice && event.kind !== "gravity") next.notice = told;
  return next;
}

// The icon of each grade.
const GRADES = { "good": "done", "fair": "near", "poor": "cross", "not-verifiable": "question" };

// Where the session stands, as one word.
function stage(state) {
  if (state.end) return "end";
  if (!state.session) return "connect";
  if (state.lost) return "lost";
  return state.status?.state ?? "identify";
}
