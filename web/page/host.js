// A session that is guided in this page: what the page of `gravical live` needs of whoever guides it.

const query = new URLSearchParams(location.search);
const guided = { source: null, folder: "", port: null, files: {}, isMemory: false };
// Where a session is on, nothing else takes its place.
const isGuided = () => document.body.dataset.view === "session" && !state.end;

// Opens one and shows it; with a folder that exists one that goes on.
async function openSession(source, name, folder, seed = 0) {
  folder ||= `session-${new Date().toISOString().slice(0, 19).replace(/[-:]/g, "")}Z`;
  Object.assign(guided, { source, folder, files: {} });
  const done = await engine.ask({ do: "open", options: { source, name, seed, speed: Number(query.get("speed")) || 1 }, folder });
  guided.isMemory = done.isMemory;
  document.body.dataset.view = "session";
  host.page.begin();
  hear(done);
}

function hear({ events = [], files = [], error }) {
  for (const { name, bytes } of files) guided.files[name] = bytes;
  if (error) events = [{ t_s: 0, type: "end", reason: "failed", poses: 0, text: `What was recorded is kept. ${error.message}` }];
  host.page.events(events);
  if (events.some(e => e.type === "end")) board.close();
}
engine.said = hear;
addEventListener("beforeunload", e => { if (isGuided() && (guided.isMemory || state.poses.size === 0) && state.session) e.preventDefault(); });

const simulate = (folder = "", seed = Number(query.get("seed")) || Math.floor(1e6 * Math.random())) =>
  openSession("simulate", `simulated MPU6050, seed ${seed}`, folder, seed);

async function plug(folder = "", port = null) {
  port ??= await board.choose();
  if (!port) return;
  guided.port = port;
  // What arrives before the session is open belongs to it.
  const early = [];
  board.on = { bytes: bytes => early.push(bytes), opened() {}, lost() {} };
  await board.open(port, Number($("#baud").value));
  await openSession("port", board.nameOf(port), folder);
  board.on = {
    bytes: bytes => engine.post({ do: "bytes" }, [{ name: "", bytes }]),
    lost: () => engine.post({ do: "lost", options: { why: "unplugged" } }),
    opened: () => engine.post({ do: "opened" }),
  };
  early.forEach(board.on.bytes);
}

// Goes on with a session that is kept.
async function resume(folder) {
  const { files: [, journal] } = await engine.ask({ do: "files", folder });
  const begun = new TextDecoder().decode(journal.bytes).split("\n").find(line => line.includes('"type":"session"'));
  const { source, name } = JSON.parse(begun ?? '{"source":"port"}');
  return source === "simulate" ? simulate(folder, Number(name.split(" ").at(-1))) : plug(folder, guided.port);
}

const host = {
  page: null,
  listen(page) { this.page = page; },
  async send(command) {
    try {
      if (command.command === "simulate") await simulate();
      else if (command.command === "port") await plug("", guided.port);
      else if (command.command === "resume") await resume(guided.folder);
      else engine.post({ do: "command", options: { command } });
    } catch (error) {
      return error.message;
    }
  },
  report: () => address(guided.files["calibration.html"]),
  fill(frame) { frame.srcdoc = new TextDecoder().decode(guided.files["calibration.html"]); },
  flashMarkup: () => html`<h2>Does it send rows?</h2>
    <p class="note">Any sketch will do that prints three numbers of the accelerometer a row, and three of the gyroscope if there is one. It has to be as fast as this page:</p>
    <p><label><select data-baud aria-label="Baud rate">${[...$("#baud").options].map(o => html`<option ${o.selected && "selected"}>${o.text}</option>`)}</select> baud</label></p>
    <p class="row">${$("#firmware") && html`<button type="button" data-flash>Flash our sketch into an Uno</button>`}
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
  const { files } = await engine.ask({ do: "files", folder });
  const made = folder === guided.folder ? Object.entries(guided.files).map(([name, bytes]) => ({ name, bytes })) : [];
  const calibration = made.find(f => f.name === "calibration.json");
  if (calibration) {
    const done = await engine.ask({ do: "export", options: { to: "arduino" } }, [{ ...calibration, role: "calibration" }]);
    made.push(...done.files);
  }
  return [...made, ...files];
}

async function keep(name, folder = guided.folder) {
  const files = await filesOfSession(folder);
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

async function flashSketch(step) {
  const dialog = $("#flashing"), told = $("#flashing .mark"), buttons = dialog.querySelectorAll(".row button");
  const say = (mark, words) => { told.hidden = !words; told.dataset.mark = mark; write(told.firstChild, words); };
  if (step === "close") return dialog.close();
  if (step !== "now") {
    say("note", "");
    return dialog.showModal();
  }
  const port = await board.choose();
  if (!port) return;
  buttons.forEach(button => { button.disabled = true; });
  try {
    await board.close();
    await engine.ask({ do: "close" });
    const pages = await flash(port, $("#firmware").textContent, words => say("note", words));
    say("done", `${pages} pages are written and read back.`);
    $("#baud").value = 115200;
    dialog.close();
    await plug("", port);
  } catch (error) {
    say("poor", error.message);
  } finally {
    buttons.forEach(button => { button.disabled = false; });
  }
}
