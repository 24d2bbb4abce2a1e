// The page: events in, what they change on it, keys and buttons back as commands.

let state = fresh();
let answers = true;
// A face is being chosen that is recorded again.
let choosing = false;
let gravity_later = false;
let accepted_until = 0;

// ---- The page after an event ----

let attitude = lying([0, 0, 1]);
// A simulated sensor is moved here.
let is_in_hand = false;

function update() {
  const now = stage(state), { session, verdict } = state;
  const is_asked = now === "connect" && Boolean(state.ports);
  const is_over = now === "end" || Boolean(state.saved) || Boolean(verdict?.final);
  is_in_hand = session?.source === "simulate" && !is_over;
  document.body.dataset.state = now;
  updateWords(now);
  show("#live", !is_over && !is_asked);
  show("#hands", is_in_hand);
  show("#actions", !is_over && !is_asked);
  show("#gravity", session?.gravity_source === "standard" && session.source !== "simulate" && !gravity_later && !is_over);
  show("#ports", is_asked);
  show("#result", is_over);
  if (is_asked) render($("#ports"), portsMarkup(state.ports));
  if (is_over) {
    render($("#result"), resultMarkup(state));
    showReport($("#result iframe"), host.fill);
  }
  updateBoard();
  updateTiles();
  updateButtons(now);
  updateRecord();
  show("#grade", Boolean(verdict) && !is_over);
  $("#grade").dataset.mark = GRADES[verdict?.grade] ?? "";
  write($("#grade span"), verdict ? standing(state) : "");
}

function updateWords(now) {
  const { status, notice } = state, [main, below] = sentence(state, answers);
  write($("#sentence"), main);
  write($("#hint"), below);
  $("#hint").classList.toggle("due", Boolean(status?.hint) && below === status.hint);
  announce(`${main} ${below}`);
  document.title = `${main.length > 60 ? now : main} · gravical live`;
  write($("#device"), state.session?.name ?? "");
  write($("#facts"), facts(state));
  const [mark, word] = connection(state, answers);
  $("#link").dataset.mark = mark;
  write($("#link"), word);
  write($("#mute"), sound.silent ? "♪ Muted" : "♪ Sound");
  $("#mute").setAttribute("aria-pressed", String(sound.silent));
  show("#notice", Boolean(notice));
  $("#notice").dataset.mark = notice?.mark ?? "";
  const [title, rest] = parts(notice?.text ?? "");
  write($("#notice b"), title);
  write($("#notice span span"), rest);
}

function updateBoard() {
  const s = state.status, { face, up } = wanted(state);
  // Gravity leaves the heading open: the board is drawn with that of the next pose, to be compared with it, or as
  // it was.
  const read = lying(s?.up ?? [0, 0, 1]);
  const heading = (up && headingTo(lying(up), read)) ?? headingTo(attitude, read) ?? 0;
  attitude = turned ?? turnedLevel(heading, read);
  drawAttitude($("#board"), attitude);
  const is_accepted = performance.now() < accepted_until;
  const [mark, word] = is_accepted ? ["done", "Done"] : posture(state);
  $("#dial").dataset.mark = mark;
  $("#dial").style.setProperty("--share", is_accepted ? 1 : s?.ring ?? 0);
  write($("#chip"), word);

  show("#next", Boolean(up) && !["floor", "identify", "lost"].includes(stage(state)));
  if (!up) return;
  write($("#next b"), face ? `Next: ${faceName(face)} up` : "Next pose");
  const { faces, hint } = state.next_pose;
  const any = faces.length > 1 ? "or any other face, in any order" : "the last face";
  write($("#next span"), face ? any : hint ?? "");
  if (s) {
    const away_deg = angleDeg(s.up, up);
    write($("#next p"), away_deg < 8 ? "✓ like this: hold it still" : `${away_deg.toFixed(0)}° away`);
    $("#next meter").value = -away_deg;
  }
  drawAttitude($("#next .drawing"), lying(up));
}

// ---- The hand of a simulated session turns the drawing, and lays the board down when it lets go ----

// The attitude that is drawn until the board is there; the last event of the mouse that drags it.
let turned = null, held = null, timer = 0;

function later(milliseconds, what) {
  clearTimeout(timer);
  timer = setTimeout(what, milliseconds);
}

// By these angles to the right and towards the camera.
function turnBoard(right, near) {
  turned = normalised(product(turn(NEAR, -right), product(turn(RIGHT, near), turned ?? attitude)));
  drawAttitude($("#board"), turned);
}

function letGo() {
  held = null;
  if (!turned) return;
  send({ command: "hand", up: upOf(turned) });
  later(2500, () => { turned = null; });
}

const ARROWS = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, -1], ArrowDown: [0, 1] };
function turnByKey(key) {
  turnBoard(...ARROWS[key].map(v => v * Math.PI / 15));
  later(450, letGo);
}

$("#board").addEventListener("pointerdown", e => {
  if (!is_in_hand) return;
  clearTimeout(timer);
  held = e;
  $("#board").setPointerCapture(e.pointerId);
  e.preventDefault();
});
$("#board").addEventListener("pointermove", e => {
  if (!held) return;
  turnBoard(0.011 * (e.clientX - held.clientX), 0.011 * (e.clientY - held.clientY));
  held = e;
});
$("#board").addEventListener("lostpointercapture", letGo);

const WORDS = { to_do: "To do", capturing: "Capturing", done: "Done", redo: "Redo" };
function updateTiles() {
  const s = state.status;
  for (const button of document.querySelectorAll("[data-face]")) {
    const { face } = button.dataset, tile = s?.tiles[face] ?? "to_do";
    button.dataset.mark = tile;
    write(button.querySelector(".mark"), WORDS[tile]);
    button.style.setProperty("--share", tile === "capturing" ? s.ring : 0);
    button.disabled = choosing ? !recorded(state, face) : !is_in_hand;
  }
  $("#tiles").classList.toggle("choosing", choosing);
  $("#tiles").setAttribute("aria-label", choosing ? "Which face is recorded again?" : "Six faces");
}

function updateButtons(now) {
  const n = state.poses.size, is_busy = ["connect", "identify", "floor", "done"].includes(now);
  $("#capture").disabled = is_busy || now === "lost" || now === "capture";
  $("#undo").disabled = $("#redo").disabled = n === 0 || is_busy;
  $("#redo").setAttribute("aria-pressed", String(choosing));
  write($("#redo"), choosing ? "Which face?" : "Redo");
  $("#finish").disabled = n < 4 || is_busy;
  write($("#finish"), n < 4 && !is_busy ? `Finish after ${4 - n} more` : "Finish");
  $("#finish").classList.toggle("primary", state.verdict?.grade === "good");
  $("#cancel").disabled = now === "connect" || now === "done";
  $("#as-drawn").disabled = !wanted(state).up;
}

function updateRecord() {
  render($("#history ol"), html`${[...state.log].reverse().map(logMarkup)}`);
  const { errors } = state;
  render($("#error svg"), errorsMarkup(errors));
  render($("#predicted"), errors.length > 0 ? html`at most <b>${inMg(errors.at(-1).worst_mg)}</b> (${share(errors.at(-1))})` : "");
}

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

async function send(command) {
  if (state.end && command.command !== "resume") return;
  const trouble = await host.send(command);
  if (trouble) complain(trouble);
}

// What went wrong with a command; an event that follows takes its place.
function complain(text) {
  state.notice = { mark: "warning", text };
  write($("#alert"), text);
  update();
}

// Asks once whether a command is meant.
function ask(name, title, text) {
  write($("#sure h2"), `${title} now?`);
  write($("#sure p"), text);
  write($("#sure [value=yes]"), title);
  $("#sure").returnValue = "";
  $("#sure").onclose = () => { if ($("#sure").returnValue === "yes") send({ command: name }); };
  $("#sure").showModal();
}

// What buttons do that is more than a command.
const ACTIONS = {
  mute() { sound.toggle(); },
  later() { gravity_later = true; },
  redo() { choosing = !choosing; },
  "as-drawn"() { send({ command: "hand", up: wanted(state).up }); },
  finish() {
    const { verdict, poses } = state;
    if (verdict?.grade === "good") return send({ command: "finish" });
    ask("finish", "Finish", verdict && poses.size >= 6 ? `${standing(state)} More poses make it better.`
      : `${FACES.filter(face => recorded(state, face)).length} of 6 faces are done: nothing tests the calibration.`);
  },
  cancel() {
    const { session: { folder }, poses: { size } } = state, poses = size === 1 ? "1 pose" : `${size} poses`;
    const kept = folder ? ` ${poses} and all samples stay in ${folder}, and the session can go on later.` : "";
    ask("cancel", "Cancel", `Nothing is calibrated.${kept}`);
  },
};

function press(button) {
  const { command, face, port } = button.dataset;
  if (button.closest("#hands, #tiles")) later(0, () => { turned = null; });
  if (command) send(JSON.parse(command));
  else if (face) send(choosing ? { command: "redo", face } : { command: "hand", put: face });
  else if (port) send({ command: "port", name: port });
  else if (button.closest(".command")) copy(button);
  else ACTIONS[button.id]?.();
  if (face) choosing = false;
  updateSoon();
}

// Without the right to copy, the line is marked, so that one key does it.
function copy(button) {
  getSelection().selectAllChildren(button.previousElementSibling);
  if (document.execCommand("copy")) button.textContent = "Copied";
}

document.addEventListener("click", e => {
  sound.wake();
  const button = e.target.closest("#session button, #mute");
  if (!button) return;
  press(button);
  // A click leaves no focus behind, so that Space goes on meaning "capture".
  if (e.detail > 0) button.blur();
});

document.addEventListener("keydown", e => {
  sound.wake();
  const at = name => e.target.closest?.(name);
  if (e.ctrlKey || e.metaKey || e.altKey || at("input") || $("#sure").open) return;
  // Space and Enter do what the button with the focus says.
  if ((e.key === " " || e.key === "Enter") && at("button, a, summary")) return;
  const key = e.key === " " ? "Space" : e.key.length === 1 ? e.key.toUpperCase() : e.key;
  const button = [...document.querySelectorAll(`[aria-keyshortcuts="${CSS.escape(key)}"]`)].find(b => b.checkVisibility());
  if (key === "Escape") {
    choosing = false;
    updateSoon();
  } else if (button) {
    if (!e.repeat && !button.disabled) press(button);
  } else if (is_in_hand && ARROWS[key]) turnByKey(key);
  else return;
  e.preventDefault();
});

$("#gravity").addEventListener("submit", e => {
  e.preventDefault();
  const read = input => Number(input.value.trim().replace(",", ".") || NaN);
  const { latitude, value } = e.target.elements;
  // A number that is none is null in JSON; the program refuses what it cannot use.
  send({ command: "gravity", latitude: read(latitude), value: read(value) });
});

// ---- Events ----

// What is replayed to a page that connects has been seen and heard before.
let is_replay = true, due = 0;

// Events that come at once are shown at once.
function updateSoon() {
  cancelAnimationFrame(due);
  due = requestAnimationFrame(update);
}

function take(event) {
  state = after(state, event);
  if (event.type === "session") choosing = false;
  if (event.type === "pose_rejected" || event.type === "lost") write($("#alert"), event.text);
  if (!is_replay) {
    if (event.type === "pose_accepted") accepted_until = performance.now() + 1100;
    sound.play(event.type);
  }
  updateSoon();
}

render($("#tiles"), html`${FACES.map(tileMarkup)}`);
for (const tile of document.querySelectorAll("[data-face]")) {
  draw(tile.querySelector(".drawing"), lying(directionOf(tile.dataset.face)));
}
draw($("#board"), attitude);
draw($("#next .drawing"), attitude);
sound.read();
host.listen({
  // All events come, from the first.
  begin() {
    answers = is_replay = true;
    updateSoon();
  },
  events(events) {
    events.forEach(take);
    is_replay = false;
  },
  silence() {
    answers = false;
    updateSoon();
  },
  answers() {
    if (!answers) updateSoon();
    answers = true;
  },
  complain,
  hasEnded: () => Boolean(state.end),
});
