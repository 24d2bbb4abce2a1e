// What the events say, as one state, and in words. Nothing here draws, sends or knows the time of day; a page
// that is loaded again gets the same events and is in the same state.

// The latest event of each type, and what becomes of them.
const fresh = () => ({
  ports: null, connecting: null, session: null, identified: null, status: null, next_pose: null,
  fit: null, verdict: null, saved: null, truth: null, lost: null, end: null,
  notice: null, poses: new Map(), errors: [], log: [],
});

// Events of the history with their marks; the first five are the notice on top, too.
const NOTICES = { pose_accepted: "done", pose_rejected: "cross", pose_undone: "redo", warning: "warning", resumed: "done" };
const MARKS = {
  ...NOTICES, identified: "note", floor: "note", verdict: "note", gravity: "note", saved: "done", lost: "warning", end: "note",
};

// What an event changes beside what it says itself, which is kept under its type.
const EFFECTS = {
  pose_accepted(s, e) { s.poses.set(e.pose, e); },
  pose_undone(s, e) {
    s.poses.delete(e.pose);
    s.errors = s.errors.filter(f => f.poses <= s.poses.size);
    if (s.poses.size < 4) s.fit = null;
  },
  fit(s, e) { if (e.worst_mg > 0) s.errors = [...s.errors.filter(f => f.poses < e.poses), e]; },
  gravity(s, { gravity_source }) { s.session.gravity_source = gravity_source; },
  lost(s) { s.notice = null; },
  resumed(s) { s.lost = null; },
  end(s) { s.notice = null; },
};

// The state after an event; what comes before a session begins anew.
function after(state, event) {
  const next = ["ports", "connecting", "session"].includes(event.type) ? fresh() : state;
  if (Object.hasOwn(next, event.type)) next[event.type] = event;
  if (Object.hasOwn(EFFECTS, event.type)) EFFECTS[event.type](next, event);
  if (!Object.hasOwn(MARKS, event.type)) return next;
  const entry = { t_s: event.t_s, mark: MARKS[event.type], text: event.text };
  next.log.push(entry);
  if (Object.hasOwn(NOTICES, event.type)) next.notice = entry;
  return next;
}

// Where the session stands, as one word.
function stage(state) {
  if (state.end) return "end";
  if (!state.session) return "connect";
  if (state.lost) return "lost";
  return state.status?.state ?? "identify";
}

const recorded = (state, face) => [...state.poses.values()].some(p => p.face === face);

// What is wanted next: its face or null, and its direction or null.
function wanted({ next_pose: next, status: s }) {
  if (next?.kind === "free" && next.up) return { face: null, up: next.up };
  if (next?.kind !== "face" || !next.faces.length) return { face: null, up: null };
  // In any order: a face that is nearly up already is the next one.
  const face = next.faces.includes(s?.face) && s.tilt_deg < 25 ? s.face : next.faces[0];
  return { face, up: directionOf(face) };
}

// The first sentence of a text, and the rest.
const parts = text => /^(.*?[.!?…])\s+(.*)$/s.exec(text)?.slice(1) ?? [text, ""];

// The one sentence, and the line below it.
function sentence(state, answers) {
  const now = stage(state);
  if (!answers && !state.end) {
    const folder = state.session?.folder;
    return ["The program does not answer.", folder
      ? `If it has ended: gravical live --resume ${folder} goes on, and no pose is lost.`
      : "Is gravical live still running? This page connects again by itself."];
  }
  if (now === "connect") return state.ports ? parts(state.ports.text) : ["Connecting …", state.connecting?.text ?? ""];
  if (now === "end") return parts(state.end.text);
  if (now === "lost") return parts(state.lost.text);
  const [main, rest] = parts(state.status?.text ?? "Reading the first samples …");
  // What was found out about the board is said while there is nothing else to do.
  const found = now === "floor" && state.identified ? parts(state.identified.text)[1] : "";
  return [main, state.status?.hint ?? (rest || found)];
}

const LOST = { unplugged: "Unplugged", silent: "No samples" };

// What the board does now, as mark and word.
function posture(state) {
  const s = state.status, now = stage(state);
  if (now === "lost") return ["cross", LOST[state.lost.why] ?? "Lost"];
  if (now === "floor") return ["hold_still", "Hands off"];
  if (now === "capture") return ["capturing", "Capturing"];
  if (now !== "wait") return ["", ""];
  return s.still ? ["note", "At rest"] : ["to_do", "Moving"];
}

// The connection, as mark and word.
function connection(state, answers) {
  const now = stage(state);
  if (now === "end") return ["note", "Ended"];
  if (!answers) return ["cross", "No answer"];
  if (now === "connect") return state.ports ? ["warning", "No board yet"] : ["to_do", "Connecting"];
  if (now === "lost") return posture(state);
  return ["done", { port: "Connected", simulate: "Simulated" }[state.session.source] ?? "Replay"];
}

// What was found out about the board, and its temperature now.
function facts({ identified, status }) {
  const found = parts(identified?.text ?? "")[0].replace(/\.$/, "");
  return Number.isFinite(status?.temperature_c) ? `${found} · ${status.temperature_c.toFixed(1)} °C` : found;
}

// How often a limit holds: of six faces, which nothing tests, less often.
const share = fit => fit.leave_one_out_mg == null ? "90 %" : "95 %";

// The grade, with the error by now: a verdict is said when the grade changes, and its numbers grow old.
function standing({ verdict, errors }) {
  const grade = verdict.text.split(":")[0];
  return errors.length > 0 ? `${grade}: at most ${inMg(errors.at(-1).worst_mg)} (${share(errors.at(-1))}) in the worst direction.` : verdict.text;
}
