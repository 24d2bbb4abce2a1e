// The page: events in, drawings out, keys and buttons back as commands.
"use strict";

const token = encodeURIComponent(new URLSearchParams(location.search).get("token") ?? "");
const address = name => `${name}?token=${token}`;

const calm = matchMedia("(prefers-reduced-motion: reduce)");
const dark = matchMedia("(prefers-color-scheme: dark)");

let state = fresh();
// Other tabs have taken all the places.
let full = false;
let answers = true;
let choosing = null;
let flash_until = 0;

// Colours of the style sheet, for drawings.
const INKS = ["card", "tint", "ink", "muted", "line", "strong", "accent", "good", "fair", "poor", "good-tint", "poor-tint", "accent-tint", "table"];
let ink = {};
function readInk() {
  const style = getComputedStyle(document.documentElement);
  const name = ink => ink.replace(/-t/, "T");
  ink = Object.fromEntries(INKS.map(ink => [name(ink), style.getPropertyValue(`--${ink}`).trim()]));
}

// ---- Tiles ----

const WORDS = { to_do: "To do", hold_still: "Hold still", capturing: "Capturing", done: "Done", redo: "Redo" };
const tiles = FACES.map((face, i) => {
  const canvas = make("canvas", {}), word = make("span", {}), bar = make("i", {});
  const button = make("button", { type: "button", disabled: true },
    make("span", { className: "name" }, `${faceName(face)} up`), make("kbd", {}, String(i + 1)), canvas,
    make("span", { className: "state" }, icon("to_do"), word), bar);
  button.addEventListener("click", () => choosing === null ? hand.act({ put: face }) : choose(face));
  canvas.setAttribute("aria-hidden", "true");
  $("#tiles").append(make("li", {}, button));
  return { face, canvas, word, bar, button };
});

function drawTiles() {
  for (const t of tiles) drawBoard(t.canvas, lying(directionOf(t.face)), ink, { span: 35, low: t.face[0] === "+" ? 0.61 : 0.41, axes: ["xyz".indexOf(t.face[1])] });
}

// ---- Drawings ----

const sphere = new Sphere($("#sphere canvas"));
const strip = new Strip($("#strip canvas"));
const chart = new ErrorChart($("#error canvas"));
const hand = new SimulatedHand($("#board"), send, () => attitude);
let attitude = lying([0, 0, 1]);
let dial_seen = "", heading = 0;

function drawDial(now) {
  const s = state.status;
  const preview = hand.on ? hand.drawn(s?.up) : null;
  // Gravity leaves the heading open: the board is drawn with that of the next pose, to be compared with it.
  const read = normalised(s?.attitude ?? [1, 0, 0, 0]), { up } = wanted();
  heading = (up && headingTo(lying(up), read)) ?? heading;
  const goal = preview ?? (s?.attitude ? product(turn([0, 0, 1], heading), read) : attitude);
  // Ten readings a second become a steady movement.
  attitude = between(attitude, goal, calm.matches || hand.held ? 1 : 0.2);
  const [kind, text, share, colour] = ring(state, ink, performance.now() < flash_until);
  const chip = $("#chip");
  write(chip, text);
  if (chip.className !== kind) chip.className = kind;
  const seen = [attitude.map(v => v.toFixed(4)), share.toFixed(3), colour].join();
  const area = seen !== dial_seen && prepare($("#board"));
  if (!area) return;
  dial_seen = seen;
  const { pen, width, height } = area, size = Math.min(width, height), radius = size / 2 - 10, centre = [width / 2, height / 2];
  pen.lineWidth = 9;
  pen.lineCap = "round";
  for (const [part, colour_of] of [[1, ink.line], [share, colour]]) {
    pen.strokeStyle = colour_of;
    pen.beginPath();
    pen.arc(...centre, radius, -Math.PI / 2, -Math.PI / 2 + 2 * Math.PI * part);
    if (part > 0) pen.stroke();
  }
  const drawing = new BoardDrawing(pen, [centre[0], centre[1] - size * 0.03], size / 44, attitude, ink);
  drawing.shadow(13);
  drawing.draw();
}

// What is wanted next: its face or null, and its direction or null.
function wanted() {
  const { next_pose: next, status: s } = state;
  if (next?.kind === "free" && next.up) return { face: null, up: unit(next.up) };
  if (next?.kind !== "face" || !next.faces?.length) return { face: null, up: null };
  // In any order: a face that is nearly up already is the next one.
  const face = next.faces.includes(s?.face) && s.tilt_deg < 25 ? s.face : next.faces[0];
  return { face, up: directionOf(face) };
}

let next_seen = "";
function drawNext(now) {
  const s = state.status, figure = $("#next"), { face, up } = wanted();
  show(figure, Boolean(up) && now !== "floor" && now !== "identify");
  if (figure.hidden) return;
  write(figure.querySelector("b"), face ? `Next: ${faceName(face)} up` : "Next pose");
  write(figure.querySelector("span"), !face ? state.next_pose.hint ?? "" : state.next_pose.faces.length > 1 ? "or any other face, in any order" : "the last face");
  const away = s?.up && unit(s.up) ? angleDeg(s.up, up) : null;
  write($("#remaining"), away === null ? "" : away < 8 ? "✓ like this: hold it still" : `${away.toFixed(0)}° away`);
  if (next_seen === up.join()) return;
  next_seen = up.join();
  drawBoard(figure.querySelector("canvas"), lying(up), ink, { span: 40, shadow: 11 });
}

function showSphere() {
  const suspect = state.fit?.suspect;
  const poses = [...state.poses.values()].map(p => ({ up: unit(p.up) ?? [0, 0, 1], face: p.face, suspect: p.pose === suspect }));
  const next = !state.end && state.next_pose?.kind === "free" && state.next_pose.up ? unit(state.next_pose.up) : null;
  sphere.show({ poses, next, up: state.end ? null : state.status?.up && unit(state.status.up) });
  const free = poses.filter(p => !p.face).length, faces = FACES.filter(recorded).length;
  write($("#poses"), `${faces} of 6 faces${free ? `, ${free} free` : ""}`);
  $("#sphere canvas").setAttribute("aria-label", `Directions that pointed up: ${faces} of 6 faces, ${free} free poses`);
}

// ---- The page after an event ----

let result_seen = "", log_seen = null;

function update() {
  const now = stage(state), s = state.status;
  document.body.dataset.state = now;
  const [main, below] = sentence(state, answers, full);
  write($("#sentence"), main);
  write($("#hint"), below);
  $("#hint").classList.toggle("due", Boolean(s?.hint) && below === s.hint);
  announce(`${main} ${below}`);
  document.title = `${main.length > 60 ? now : main} · gravical live`;

  write($("#device"), state.session?.name ?? "");
  write($("#facts"), facts(state));
  const [tone, word] = pill(state, answers);
  $("#link").className = `pill ${tone}`;
  write($("#link span"), word);

  const { notice } = state;
  show($("#notice"), Boolean(notice));
  if (notice) {
    $("#notice").className = notice.kind;
    setIcon($("#notice"), notice.kind);
    const [title, rest] = parts(notice.text);
    write($("#notice strong"), title);
    write($("#notice span"), rest);
  }

  const ended = now === "end" || Boolean(state.saved) || Boolean(state.verdict?.final);
  hand.on = state.session?.source === "simulate" && !ended;
  for (const t of tiles) {
    const kind = s?.tiles[t.face] ?? "to_do";
    t.button.className = kind;
    setIcon(t.button, kind);
    write(t.word, WORDS[kind]);
    t.bar.style.setProperty("--share", kind === "capturing" || kind === "hold_still" ? s?.ring ?? 0 : 0);
    t.button.disabled = choosing === null ? !hand.on : !recorded(t.face);
    t.button.title = t.button.disabled ? "" : choosing === null ? `Put ${faceName(t.face)} up` : `Record ${faceName(t.face)} again`;
  }
  $("#tiles").classList.toggle("choosing", choosing !== null);
  $("#tiles").setAttribute("aria-label", choosing !== null ? "Which face is recorded again?" : hand.on ? "Which face is put up?" : "Six faces");

  write($("#nearest"), s?.face ? `Nearest ${faceName(s.face)}` : "Nearest face");
  write($("#tilt"), Number.isFinite(s?.tilt_deg) ? `${s.tilt_deg.toFixed(1)}°` : "");
  $("#needle").style.setProperty("--share", Math.max(0, Math.min(1, (s?.tilt_deg ?? 0) / 45)));

  show($("#result"), ended);
  const asked = isAsked(now);
  showPorts(asked);
  show($("#live"), !ended && !asked);
  show($("#strip"), !ended);
  const result = ended ? [state.verdict?.grade, state.fit?.t_s, state.saved?.t_s, state.truth?.t_s, state.end?.t_s].join() : "";
  if (result !== result_seen) {
    result_seen = result;
    if (ended) fillResult($("#result"), state, address("report"), () => send({ command: "resume" }));
  }
  show($("#hands"), hand.on);
  const { verdict } = state, grade = GRADES[verdict?.grade];
  show($("#grade"), Boolean(grade) && !ended);
  if (grade) {
    $("#grade").className = verdict.grade;
    setIcon($("#grade"), grade);
    write($("#grade span"), verdict.text);
  }
  hand.next = wanted().up;
  $("#as-drawn").disabled = !hand.next;
  $("#board").classList.toggle("grab", hand.on);
  show($("#actions"), !ended && !asked && !full);
  buttons(now);
  show($("#gravity"), state.session?.gravity_source === "standard" && state.session.source !== "simulate"
    && !later && !ended);
  listHistory();
}

// ---- The port ----

// Which port it is has to be chosen.
const isAsked = now => now === "connect" && Boolean(state.ports) && !full;
const choosePort = name => send({ command: "port", name });

let ports_seen = null;
function showPorts(asked) {
  show($("#ports"), asked);
  if (!asked || ports_seen === state.ports) return;
  ports_seen = state.ports;
  const { ports, tried, flash, simulate } = state.ports;
  const had = document.activeElement?.closest?.("#ports li button")?.dataset.name;
  $("#ports ol").replaceChildren(...(ports ?? []).map((port, i) => {
    const [what, where] = portWords(port);
    const button = make("button", { type: "button" }, icon("plug"),
      make("span", {}, make("b", {}, what), make("small", {}, where)), i < 9 ? make("kbd", {}, String(i + 1)) : null);
    button.dataset.name = port.name;
    button.classList.toggle("board", Boolean(port.board));
    button.addEventListener("click", () => choosePort(port.name));
    return make("li", {}, button);
  }));
  // What is plugged in meanwhile takes the focus from nothing.
  [...$("#ports ol").querySelectorAll("button")].find(b => had && b.dataset.name === had)?.focus();
  show($("#again"), Boolean(tried));
  write($("#again span"), `Try ${tried} again`);
  show($("#flash"), Boolean(flash?.length));
  $("#flash div").replaceChildren(...(flash ?? []).map(command));
  show($("#simulate"), Boolean(simulate));
}
$("#again").addEventListener("click", () => choosePort(state.ports.tried));
$("#simulate button").addEventListener("click", () => send({ command: "simulate" }));

function keyOfPorts(key) {
  const button = key === "Enter" ? $("#again") : key === "s" ? $("#simulate button")
    : $("#ports ol").children[Number(key) - 1]?.firstChild;
  if (button?.checkVisibility()) button.click();
  return Boolean(button);
}

function buttons(now) {
  const button = name => $(`[data-command=${name}]`), n = state.poses.size;
  const busy = ["connect", "identify", "floor", "done"].includes(now);
  button("capture").disabled = busy || now === "lost" || now === "capture";
  button("undo").disabled = n === 0 || busy;
  button("redo").disabled = n === 0 || busy;
  button("redo").setAttribute("aria-pressed", String(choosing !== null));
  write(button("redo").querySelector("span"), choosing === null ? "Redo" : "Which face?");
  button("finish").disabled = n < 4 || busy;
  button("cancel").disabled = now === "connect" || now === "done";
  button("finish").classList.toggle("primary", state.verdict?.grade === "good");
}

function listHistory() {
  const list = $("#log"), { log } = state;
  if (log.at(-1) === log_seen) return;
  log_seen = log.at(-1);
  list.replaceChildren(...log.slice(-60).reverse().map(l => make("li", { className: l.kind },
    make("time", {}, clock(l.t_s)), icon(l.kind), make("span", {}, l.text))));
  write($("#count"), `${log.length}`);
}

const clock = t_s => `${Math.floor(t_s / 60)}:${String(Math.floor(t_s % 60)).padStart(2, "0")}`;

// A reader of the screen hears what is new, not every tenth of a second that is left.
let said = "", announcing = 0;
function announce(text) {
  const key = text.replace(/\d[\d.,]*/g, "#");
  if (key === said) return;
  said = key;
  // What lasts for less than a moment is not said.
  clearTimeout(announcing);
  announcing = setTimeout(() => write($("#announcement"), text), 500);
}

// ---- Commands ----

let later = false;

async function send(command) {
  if (full || state.end && command.command !== "resume") return false;
  try {
    const answer = await fetch(address("command"), {
      method: "POST", headers: { "Content-Type": "application/json" }, body: JSON.stringify(command),
    });
    if (answer.ok) return true;
    const { error } = await answer.json().catch(() => ({}));
    complain(error ?? `The program refused that (${answer.status}).`);
  } catch {
    complain("The program did not answer.");
  }
  return false;
}

// What went wrong with a command; an event that follows takes its place.
function complain(text) {
  state.notice = { t_s: 0, kind: "warning", text };
  write($("#alert"), text);
  update();
}

const recorded = face => [...state.poses.values()].some(p => p.face === face);

function choose(face) {
  if (choosing === null || !recorded(face)) return;
  choosing = null;
  send({ command: "redo", face });
  update();
}

const finish = () => {
  const { verdict, poses } = state;
  if (verdict?.grade === "good") return send({ command: "finish" });
  ask("finish", verdict && poses.size >= 6 ? verdict.text : `${FACES.filter(recorded).length} of 6 faces are done: nothing tests the calibration.`);
};

const cancel = () => {
  const { session, poses } = state, n = poses.size === 1 ? "1 pose" : `${poses.size} poses`;
  ask("cancel", session.folder ? `Nothing is calibrated. ${n} and all samples stay in ${session.folder}, and the session can go on later.`
    : "Nothing is calibrated.");
};

// Asks once whether a command is meant.
let asked_for = "";
function ask(name, text) {
  const title = name === "finish" ? "Finish" : "Cancel";
  asked_for = name;
  write($("#sure h2"), `${title} now?`);
  write($("#sure p"), text);
  write($("#sure [value=yes] span"), title);
  $("#sure").returnValue = "";
  $("#sure").showModal();
}
$("#sure").addEventListener("close", () => { if ($("#sure").returnValue === "yes") send({ command: asked_for }); });

const COMMANDS = {
  capture: () => send({ command: "capture" }),
  undo: () => send({ command: "undo" }),
  redo: () => {
    choosing = choosing === null ? "" : null;
    update();
  },
  finish,
  cancel,
};
const run = name => { if (!$(`[data-command=${name}]`).disabled && !$("#actions").hidden) COMMANDS[name](); };
for (const name of Object.keys(COMMANDS)) $(`[data-command=${name}]`).addEventListener("click", () => run(name));

// After R: the number of a tile, or + or − and the name of the axis.
function chooseByKey(key) {
  if (key === "Escape") choosing = null;
  else if (FACES[Number(key) - 1]) return choose(FACES[Number(key) - 1]);
  else if (key === "+" || key === "-") choosing = key;
  else if ("xyz".includes(key) && choosing) return choose(choosing + key);
  else if (key === "r") choosing = null;
  else return;
  update();
}

document.addEventListener("keydown", e => {
  sound.wake();
  const target = e.target, at = name => target.closest?.(name);
  if (e.ctrlKey || e.metaKey || e.altKey || at("input") || $("#sure").open) return;
  const key = e.key.length === 1 ? e.key.toLowerCase() : e.key;
  // Space and Enter do what the button with the focus says.
  if ((key === " " || key === "Enter") && at("button, a, summary")) return;
  if (!$("#ports").hidden && keyOfPorts(key)) return e.preventDefault();
  if (choosing !== null && key !== "m") {
    if (key.length === 1 || key === "Escape") e.preventDefault();
    return chooseByKey(key);
  }
  const name = { " ": "capture", u: "undo", r: "redo", c: "cancel", Enter: "finish" }[key];
  if (name) {
    e.preventDefault();
    if (!e.repeat) run(name);
  } else if (key === "m") sound.toggle();
  else if (hand.on && hand.key(key)) e.preventDefault();
});
// A click leaves no focus behind, so that Space goes on meaning "capture".
document.addEventListener("click", e => {
  sound.wake();
  if (e.detail > 0) e.target.closest("button")?.blur();
});
$("#mute").addEventListener("click", () => sound.toggle());

$("#gravity").addEventListener("submit", e => {
  e.preventDefault();
  const read = id => Number($(id).value.trim().replace(",", ".") || NaN);
  // A number that is none is null in JSON; the program refuses what it cannot use.
  send({ command: "gravity", latitude: read("#latitude"), value: read("#value") });
});
$("#later").addEventListener("click", () => {
  later = true;
  update();
});

// ---- Events ----

let live_from = 0;
function take(event) {
  if (event.type === "full") {
    full = true;
  } else {
    state = after(state, event);
    if (event.type === "session") {
      choosing = null;
      sphere.turned = false;
    }
    if (event.type === "status") strip.push(event.t_s, event.norm_g, event.noise_mg, event.limit_mg);
    if (event.type === "next_pose") {
      sphere.turned = false;
      const look = state.poses.get(state.fit?.suspect)?.up ?? event.up;
      if (look) sphere.face(unit(look) ?? [0, 0, 1]);
    }
    // What is replayed at the start has been seen and heard before.
    if (performance.now() > live_from) {
      if (event.type === "pose_accepted") flash_until = performance.now() + 1100;
      if (SOUNDS[event.type]) sound.play(SOUNDS[event.type]);
    }
    if (event.type === "pose_rejected" || event.type === "lost") write($("#alert"), event.text);
  }
  if (event.type !== "status") {
    const mg = [...state.errors].map(([n, e]) => [n, ...e]).sort((a, b) => a[0] - b[0]), last = mg.at(-1);
    chart.show(mg);
    $("#predicted").replaceChildren(...last ? ["at most ", make("b", {}, `${precise(last[1])} mg`), " (95 %)"] : []);
    $("#error canvas").setAttribute("aria-label", last ? `Predicted error ${precise(last[1])} mg after ${last[0]} poses` : "Predicted error: no poses yet");
  }
  dirty = true;
}

let dirty = true, silence = 0;
function listen() {
  const stream = new EventSource(address("events"));
  stream.addEventListener("open", () => {
    answers = true;
    clearTimeout(silence);
    silence = 0;
    full = false;
    live_from = performance.now() + 700;
    dirty = true;
  });
  stream.addEventListener("error", () => {
    // After the end the program may go: there is nothing to wait for.
    if (state.end) stream.close();
    // A stream that is opened again at once is not worth a word; one that fails again and again is.
    silence ||= setTimeout(() => {
      answers = full;
      dirty = true;
    }, 1500);
    // A refused connection is final for the browser, so it is tried again here.
    if (stream.readyState === EventSource.CLOSED && !state.end) setTimeout(listen, 2000);
  });
  stream.addEventListener("message", e => {
    let event;
    try {
      event = JSON.parse(e.data);
    } catch {
      return;
    }
    if (event && typeof event === "object") take(event);
  });
}

// ---- Frames ----

let last_frame = 0;
function frame(now_ms) {
  requestAnimationFrame(frame);
  // Thirty a second are enough for the eye, and leave the machine to the measurement.
  if (now_ms - last_frame < 30) return;
  last_frame = now_ms;
  if (dirty) {
    dirty = false;
    update();
    showSphere();
  }
  const now = stage(state);
  if (!$("#live").hidden) {
    drawDial(now);
    drawNext(now);
  }
  sphere.draw(ink, calm.matches);
  if (!$("#strip").hidden) {
    const open = state.pose_candidate ? [{ from: state.pose_candidate.t_s, to: state.status?.t_s ?? state.pose_candidate.t_s, kind: "open" }] : [];
    strip.draw(ink, [...state.marks, ...open], state.session?.gravity_mps2 ?? 9.80665);
  }
  chart.draw(ink);
}

function redraw() {
  readInk();
  dial_seen = next_seen = "";
  sphere.due = strip.due = chart.due = true;
  drawTiles();
}
dark.addEventListener("change", redraw);
addEventListener("resize", redraw);
new ResizeObserver(redraw).observe($("main"));

readInk();
sound.read();
update();
redraw();
listen();
requestAnimationFrame(frame);
