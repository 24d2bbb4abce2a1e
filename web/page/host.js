// A session that is guided in this page: what the page of `gravical live` needs of whoever guides it.

const query = new URLSearchParams(location.search);
// The session that is guided; `isSaved`: what is in memory only was saved.
const guided = { folder: "", port: null, files: {}, isMemory: false, isSaved: false, ticking: 0 };
// Where a session is on, nothing else takes its place.
const isGuided = () => document.body.dataset.view === "session" && !state.end;

// Opens one and shows it; with a folder that exists one that goes on.
async function openSession(source, name, folder, seed = 0) {
  folder ||= `session-${new Date().toISOString().slice(0, 19).replace(/[-:]/g, "")}Z`;
  const options = { source, name, seed, speed: Number(query.get("speed")) || 1 };
  const done = await engine.ask({ do: "open", options, folder, now_s: now_s() });
  clearInterval(guided.ticking);
  Object.assign(guided, { folder, files: {}, isMemory: done.isMemory, isSaved: false });
  // In the order of the bytes, so that no silence is seen before what has arrived.
  guided.ticking = setInterval(() => engine.post({ do: "tick", now_s: now_s() }), 25);
  document.body.dataset.view = "session";
  host.page.begin();
  onEvents(done);
}

function onEvents({ events = [], files = [], error }) {
  for (const { name, bytes } of files) guided.files[name] = bytes;
  if (error) events = [{ t_s: 0, type: "end", reason: "failed", poses: 0, text: `What was recorded is kept. ${error.message}` }];
  if (events.some(e => e.type === "end")) {
    clearInterval(guided.ticking);
    board.close();
    // What is in the memory of the worker would end with it.
    if (guided.isMemory) engine.ask({ do: "files", folder: guided.folder }).then(done => onEvents({ files: done.files })).catch(() => {});
  }
  host.page.events(events);
}
engine.onEvents = onEvents;
const isUnsaved = () => document.body.dataset.view !== "door" && guided.isMemory && !guided.isSaved && state.poses.size > 0;
addEventListener("beforeunload", e => { if (isUnsaved() || isFlashing) e.preventDefault(); });

const simulate = (folder = "", seed = Number(query.get("seed")) || Math.floor(1e6 * Math.random())) =>
  openSession("simulate", `simulated MPU6050, seed ${seed}`, folder, seed);

// `name`: of the board that a session goes on with.
async function plug(folder = "", port = null, name = null) {
  port ??= await board.choose();
  if (!port) return;
  if (name && board.nameOf(port) !== name) throw new Error(`This session is of ${name}, and that is ${board.nameOf(port)}.`);
  // What arrives before the session is open belongs to it.
  let early = [];
  const post = (head, files) => early ? early.push([head, files]) : engine.post(head, files);
  try {
    await board.open(port, Number($("#baud").value), {
      bytes: (now_s, bytes) => post({ do: "bytes", now_s }, [{ name: "", bytes }]),
      overflow: now_s => post({ do: "overflow", now_s }),
      lost: now_s => post({ do: "lost", now_s }),
      // The first is that of the session.
      opened: now_s => early || engine.post({ do: "opened", now_s }),
      trouble: text => host.page.complain(text),
    });
    await openSession("port", board.nameOf(port), folder);
    guided.port = port;
  } catch (error) {
    // The next attempt asks for the port.
    guided.port = null;
    await board.close();
    throw error;
  }
  early.splice(0).forEach(([head, files]) => engine.post(head, files));
  early = null;
}

// Goes on with a session that is kept.
async function resume(folder) {
  const { files } = await engine.ask({ do: "files", folder });
  const journal = new TextDecoder().decode(files.find(f => f.name === "session.ndjson")?.bytes);
  const begun = journal.split("\n").find(line => line.includes('"type":"session"'));
  const { source, name } = JSON.parse(begun ?? '{"source":"port"}');
  return source === "simulate" ? simulate(folder, Number(name.split(" ").at(-1))) : plug(folder, guided.port, name);
}

const host = {
  page: null,
  listen(page) { this.page = page; },
  async send(command) {
    try {
      if (command.command === "simulate") await simulate();
      else if (command.command === "port") await plug("", guided.port);
      else if (command.command === "resume") await resume(guided.folder);
      else engine.post({ do: "command", options: { command }, now_s: now_s() });
    } catch (error) {
      return error.message;
    }
  },
  report: () => address(guided.files["calibration.html"]),
  fill(frame) { frame.srcdoc = new TextDecoder().decode(guided.files["calibration.html"]); },
  flashMarkup: () => html`<h2>Does it send rows?</h2>
    <p class="note">Any sketch will do that prints three numbers of the accelerometer a row, and three of the gyroscope if there is one. It has to be as fast as this page:</p>
    <p><label><select data-baud aria-label="Baud rate">${[...$("#baud").options].map(o => html`<option ${o.selected && "selected"}>${o.text}</option>`)}</select> baud</label></p>
    <p class="row"><button type="button" data-plug>Choose another port</button>
      ${$("#firmware") && html`<button type="button" data-flash>Flash our sketch into an Uno</button>`}
      <button type="button" data-sketch>↓ Our sketch, for an MPU6050</button></p>`,
  savedMarkup: (_, grade) => html`<p class="row downloads">${guidedFilesMarkup(true)}
      <button type="button" data-further>Position and orientation of a move</button></p>
    ${grade !== "good" && resumeMarkup("Go on with more poses")}`,
  laterMarkup: () => html`<p class="row downloads">${guidedFilesMarkup(false)}</p>${resumeMarkup("Go on with this session")}`,
};

// What can be saved of a session.
const guidedFilesMarkup = isDone => html`
  ${isDone && html`<button type="button" class="primary" data-keep="calibration.json">↓ calibration.json</button>
    <button type="button" data-keep="calibration.html">↓ calibration.html</button>
    <button type="button" data-keep="gravical_calibration.h">↓ header for Arduino</button>`}
  <button type="button" data-keep="recording.csv">↓ recording.csv</button>
  <button type="button" data-keep="zip">↓ all in one .zip</button>`;

async function filesOfSession(folder) {
  const made = folder === guided.folder ? Object.entries(guided.files).map(([name, bytes]) => ({ name, bytes })) : [];
  const { files } = made.some(f => f.name === "recording.csv") ? { files: [] } : await engine.ask({ do: "files", folder });
  const calibration = made.find(f => f.name === "calibration.json");
  if (calibration) {
    const done = await engine.ask({ do: "export", options: { to: "arduino" } }, [{ ...calibration, role: "calibration" }]);
    made.push(...done.files);
  }
  return [...made, ...files];
}

async function keep(name, folder = guided.folder) {
  const files = await filesOfSession(folder);
  guided.isSaved ||= folder === guided.folder && ["zip", "recording.csv", "calibration.json"].includes(name);
  if (name === "zip") return save(`${folder}.zip`, zip(files.map(f => ({ ...f, name: `${folder}/${f.name}` }))));
  save(name, files.find(f => f.name === name).bytes);
}

// ---- Sessions on this computer ----

async function showKept() {
  const { names } = await engine.ask({ do: "kept" });
  show("#kept", names.length > 0);
  render($("#kept ol"), html`${names.reverse().map(name => html`<li class="row"><b>${name.replace(/^session-(....)(..)(..)T(..)(..)(..)Z$/, "$1-$2-$3 $4:$5 UTC")}</b>
    <button type="button" data-resume="${name}">Go on</button><button type="button" class="quiet" data-zip="${name}">↓ .zip</button>
    <button type="button" class="quiet" data-forget="${name}" aria-label="Delete ${name}">Delete</button></li>`)}`);
}

// ---- The sketch ----

let isFlashing = false;
async function flashSketch(step) {
  const dialog = $("#flashing"), told = $("#flashing .mark");
  const say = (mark, words) => { told.hidden = !words; told.dataset.mark = mark; write(told.firstChild, words); };
  if (step === "close") return dialog.close();
  if (step !== "now") {
    say("note", "");
    return dialog.showModal();
  }
  const port = await board.choose();
  if (!port) return;
  const busy = is => { isFlashing = is; dialog.querySelectorAll(".row button").forEach(button => { button.disabled = is; }); };
  busy(true);
  try {
    await board.close();
    await engine.ask({ do: "close" });
    const pages = await flash(port, $("#firmware").textContent, words => say("note", words));
    say("done", `${pages} pages are written and read back.`);
  } catch (error) {
    return say("poor", error.message);
  } finally {
    busy(false);
  }
  dialog.close();
  $("#baud").value = 115200;
  await plug("", port);
}
// A board is not left half written by a key.
$("#flashing").addEventListener("cancel", e => { if (isFlashing) e.preventDefault(); });
