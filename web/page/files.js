// Files that are dropped: what is in them, and what can be computed of them.

// Each has name, bytes, kind (recording, calibration, noise, sections) and what was found, or the error; `use` says what a
// calibration takes it for: pose, gyro or nothing.
let dropped = [];
let chosen = null, result = null;
let isFolder = false;

const ofKind = kind => dropped.filter(entry => entry.kind === kind);
const recordings = () => ofKind("recording");
// The recording that verbs of one recording take.
const current = () => recordings().includes(chosen) ? chosen : recordings().find(entry => entry.use !== "gyro");
// Those that a calibration is computed from.
const poses = () => recordings().filter(entry => entry.use === "pose");
const gyro = () => dropped.findLast(entry => entry.use === "gyro");
const latest = () => ofKind("calibration").at(-1);
const as = (role, ...entries) => entries.filter(Boolean).map(entry => ({ ...entry, role }));

// What can be pressed: its name, which files it takes, null where they are not there.
const one = () => current() ? as("", current()) : null;
const withCalibration = files => latest() && files?.length ? [...files, ...as("calibration", latest())] : null;
const VERBS = {
  calibrate: ["Calibrate", () => poses().length ? [...as("", ...poses()), ...as("gyro", gyro()), ...as("sections", ofKind("sections").at(-1))] : null],
  motion: ["Position", () => one() && [...one(), ...as("gyro", gyro()), ...as("calibration", latest())]],
  orient: ["Orientation", () => one() && [...one(), ...as("gyro", gyro()), ...as("calibration", latest())]],
  check: ["Check", () => withCalibration(as("", ...(recordings().some(e => e.use !== "pose") ? recordings().filter(e => e.use !== "pose") : recordings())))],
  apply: ["Apply", () => withCalibration(one())],
  denoise: ["Denoise", one],
  noise: ["Noise", one],
  convert: ["Convert", one],
  compare: ["Compare", () => ofKind("calibration").length === 2 ? as("calibration", ...ofKind("calibration")) : null],
};

async function addFiles(list, folder = false, silently = false) {
  if (isGuided()) throw new Error("A session is on: finish or cancel it, then drop files.");
  // What comes when there is a calibration is not meant for it.
  const isLate = Boolean(latest());
  document.body.dataset.view = "files";
  if (dropped.length === 0) isFolder = folder;
  for (const file of list) {
    const entry = { name: file.name, size: file.size, use: isLate ? "" : "pose" };
    dropped.push(entry);
    updateFiles();
    try {
      entry.bytes = new Uint8Array(await file.arrayBuffer());
      await look(entry);
    } catch (error) {
      entry.error = error;
      entry.use = "";
    }
    updateFiles();
  }
  if (silently) return;
  // Without a calibration among them they are a session.
  const verb = latest() ? recordings().length ? "motion" : ofKind("calibration").length === 2 ? "compare" : null : recordings().length ? "calibrate" : null;
  if (verb) await compute(verb);
}

async function look(entry) {
  const { result: found, files } = await engine.ask({ do: "inspect", options: options() }, [entry]);
  Object.assign(entry, found, { page: files[0]?.bytes, error: null });
}

// The form as options of gravical, by their names; what is empty is not given.
function options() {
  const given = {};
  for (const { name, value, inputMode } of $("#options").elements) {
    const text = value?.trim();
    if (!name || !text) continue;
    const number = Number(text.replace(",", "."));
    if (inputMode === "decimal" && !Number.isFinite(number)) throw new Error(`“${text}” is no number.`);
    given[name] = inputMode === "decimal" ? number : name === "filter" ? text.split(/\s+/) : text;
  }
  return given;
}

async function compute(verb) {
  const files = VERBS[verb][1]();
  if (!files || result?.isBusy) return;
  result = { verb, isBusy: true, began: performance.now() };
  updateFiles();
  const clock = setInterval(updateFiles, 1000);
  try {
    const given = { ...options(), of_folder: isFolder || files.length > 1 && verb === "calibrate" };
    if (verb === "denoise") given.filter ??= ["hampel:7,3", "butter:4,5Hz"];
    const done = await engine.ask({ do: verb, options: given }, files);
    const report = done.files.find(f => f.name === "report.html");
    result = { verb, done, files: done.files.map(f => f === report ? { ...f, name: `${verb}.html` } : f), report: report?.bytes };
    if (verb === "calibrate") {
      const { bytes } = done.files.find(f => f.name === "calibration.json"), { result: found } = await engine.ask({ do: "inspect" }, [{ name: "calibration.json", bytes }]);
      dropped = [...dropped.filter(entry => !entry.isMade), { name: "calibration.json", bytes, ...found, isMade: true }];
    }
  } catch (error) {
    result = { verb, error };
  }
  clearInterval(clock);
  updateFiles();
}

// ---- The view ----

const inWords = {
  recording({ inspection: { timing, row_counts, accelerometer, gyroscope, findings } }) {
    const rate = timing.median_rate_hz ?? timing.rate_hz;
    return [`${row_counts.rows.toLocaleString("en")} rows`, rate && `${rate.toFixed(1)} Hz`, accelerometer.unit.replace("^2", "²"),
      gyroscope && "gyroscope", findings.length > 0 && `${findings.length} ${findings.length === 1 ? "finding" : "findings"}`].filter(Boolean).join(" · ");
  },
  calibration: ({ verdict, isMade }) => `calibration: ${verdict.grade.replace("-", " ")}${isMade ? ", of these recordings" : ""}`,
  noise: () => "noise of a sensor, for export",
  sections: () => "sections of the recording, for the calibration",
};

const USES = [["pose", "for the calibration"], ["", "to be computed"], ["gyro", "gyroscope of the other"]];
const entryMarkup = (entry, i) => html`<li data-mark="${entry.error ? "poor" : entry.kind ? "good" : "note"}" class="${entry === current() && recordings().length > 1 && "chosen"}">
  <p class="mark">${entry.kind === "recording" ? html`<button type="button" class="text" data-pick="${i}" aria-pressed="${entry === current()}">${entry.name}</button>` : html`<b>${entry.name}</b>`}</p>
  ${entry.page && html`<button type="button" class="quiet" data-inspect="${i}">Look inside</button>`}
  ${(entry.kind === "recording" ? recordings().length > 1 : entry.error && entry.bytes) && html`<label class="quiet">
    <select data-use="${i}" aria-label="Use of ${entry.name}">${USES.map(([use, words]) => html`<option value="${use}" ${entry.use === use && "selected"}>${words}</option>`)}</select></label>`}
  <button type="button" class="quiet" data-drop="${i}" aria-label="Remove ${entry.name}">×</button>
  <small>${entry.error ? entry.error.message : entry.kind ? inWords[entry.kind](entry) : `reading ${(entry.size / 1e6).toFixed(1)} MB …`}</small>
  ${entry.error && remedyMarkup(entry.error)}</li>`;

// What helps: a hint, and for each option that the form has a button that sets it.
const remedyMarkup = ({ hint, options: helps = [] }) => html`
  ${hint && html`<small class="hint">${hint}</small>`}
  ${helps.filter(o => o.value && $("#options").elements[o.name]).map(o => html`<button type="button" data-option="${o.name}" data-value="${o.value}">Take ${o.name.replace("_", " ")} as ${o.value}</button>`)}`;

function computedMarkup({ verb, isBusy, began, error, done, files, report }) {
  if (isBusy) return html`<p class="mark" data-mark="note"><span>Computing … ${Math.round((performance.now() - began) / 1e3)} s</span></p>
    <p><button type="button" data-cancel>Cancel</button></p>`;
  if (error) return html`<div class="fault mark" data-mark="poor"><p><b>${error.code === "cancelled" ? "Cancelled" : "This cannot be computed"}</b> <span>${error.code !== "cancelled" && error.message}</span></p></div>
    ${remedyMarkup(error)}`;
  const forExport = verb === "calibrate" ? "calibration" : verb === "noise" ? "noise" : null;
  const targets = forExport && TARGETS.filter(t => t.is_noise === (forExport === "noise"));
  return html`<div class="row downloads">
      ${files.map((f, i) => html`<button type="button" data-save="${i}" class="${i === 0 && "primary"}">↓ ${f.name}</button>`)}
      ${targets && html`<label>Export to <select data-export="${forExport}"><option value="">…</option>${targets.map(t => html`<option value="${t.name}" title="${t.holds}">${t.name}</option>`)}</select></label>`}</div>
    ${done.result.notes && done.result.notes.map(note => html`<p class="note">${note}</p>`)}
    ${report ? html`<iframe title="Report"></iframe><p><a href="${address(report)}" target="_blank" rel="noopener">The report in a new tab</a></p>` : html`<p class="mark" data-mark="good"><span>${done.result.rows?.toLocaleString("en")} rows: ${files[0].name} is ready.</span></p>`}`;
}

function updateFiles() {
  const isBusy = result?.isBusy || dropped.some(e => !e.kind && !e.error);
  render($("#list"), html`${dropped.map(entryMarkup)}`);
  render($(".verbs"), html`${Object.entries(VERBS).map(([verb, [name, files]]) => html`<button type="button" data-verb="${verb}" aria-pressed="${result?.verb === verb}" ${(isBusy || !files()) && "disabled"}>${name}</button>`)}`);
  render($("#computed"), result ? computedMarkup(result) : "");
  showReport($("#computed iframe"), frame => { frame.srcdoc = new TextDecoder().decode(result.report); });
}

function trouble(error) {
  write($("#trouble"), error?.message ?? String(error));
  show("#trouble", true);
}

// The files of what is dropped: of folders those inside.
async function filesOf(items) {
  const files = [];
  let folder = false;
  async function walk(entry) {
    if (entry.isFile) return files.push(await new Promise((done, fail) => entry.file(done, fail)));
    folder = true;
    const reader = entry.createReader();
    for (let some; (some = await new Promise((done, fail) => reader.readEntries(done, fail))).length;) for (const inner of some) if (inner.isFile) await walk(inner);
  }
  for (const entry of [...items].map(item => item.webkitGetAsEntry()).filter(Boolean)) await walk(entry);
  return [files.sort((a, b) => a.name.localeCompare(b.name)), folder];
}

// What buttons do, by their data.
const HANDLERS = {
  choose: what => $(what === "folder" ? "#folder" : "#chosen").click(),
  async example() {
    const [poses, ...others] = [...document.querySelectorAll("script.example")].map(e => new File([packed(e)], e.id));
    await addFiles([poses]);
    await addFiles(others, false, true);
  },
  simulate: () => simulate(),
  plug: () => plug(),
  resume: folder => resume(folder),
  keep: name => keep(name),
  zip: folder => keep("zip", folder),
  async forget(folder, _, button) {
    if (button.textContent === "Delete") return write(button, "Delete for good?");
    await engine.ask({ do: "forget", folder });
    await showKept();
  },
  // With the calibration of the session, to what is recorded with it.
  async further() { await addFiles([new File([guided.files["calibration.json"]], "calibration.json")], false, true); },
  flash: flashSketch,
  sources: () => save("firmware-sources.tar.gz", packed($("#sources"))),
  sketch: () => save("mpu6050_logger.ino", $("#sketch").textContent),
  verb: compute,
  cancel: () => engine.cancel(),
  pick(i) { chosen = dropped[i]; updateFiles(); },
  save: i => save(result.files[i].name, result.files[i].bytes),
  inspect(i) { result = { verb: "inspect", done: { result: {} }, files: [{ name: "inspection.html", bytes: dropped[i].page }], report: dropped[i].page }; updateFiles(); },
  drop(i) { dropped.splice(Number(i), 1); updateFiles(); },
  async option(name, { value }) { $("#options").elements[name].value = value; await again(); },
};

// With the options as they are now: files that could not be read, and the result.
async function again() {
  for (const entry of dropped.filter(e => e.error && e.bytes)) await look(entry).catch(error => { entry.error = error; });
  updateFiles();
  await compute(result?.verb in VERBS ? result.verb : "calibrate");
}

async function exportTo(target, kind) {
  const bytes = result.files.find(f => f.name === (kind === "noise" ? "noise.json" : "calibration.json")).bytes;
  const done = await engine.ask({ do: "export", options: { to: target } }, [{ name: "calibration.json", bytes, role: "calibration" }]);
  save(done.files[0].name, done.files[0].bytes);
  result.done = { ...result.done, result: { ...result.done.result, notes: done.result.notes } };
  updateFiles();
}

let TARGETS = [];
document.addEventListener("click", e => {
  const button = e.target.closest("button");
  const [name, value] = Object.entries(button?.dataset ?? {}).find(([name]) => name in HANDLERS) ?? [];
  show("#trouble", false);
  if (name) Promise.resolve(HANDLERS[name](value, button.dataset, button)).catch(trouble);
});
document.addEventListener("change", e => {
  if (e.target.matches("[data-export]") && e.target.value) exportTo(e.target.value, e.target.dataset.export).catch(trouble).finally(() => { e.target.value = ""; });
  if (e.target.matches("[data-use]")) { dropped[e.target.dataset.use].use = e.target.value; updateFiles(); }
  if (e.target.matches("[data-baud]")) $("#baud").value = e.target.value;
  if (e.target.matches("[type=file]")) {
    addFiles([...e.target.files], e.target.id === "folder").catch(trouble);
    e.target.value = "";
  }
});
$("#options").addEventListener("submit", e => { e.preventDefault(); again().catch(trouble); });
for (const type of ["dragenter", "dragover", "dragleave", "drop"]) {
  document.addEventListener(type, e => {
    e.preventDefault();
    document.body.classList.toggle("dragging", type === "dragenter" || type === "dragover");
    if (type === "drop") filesOf(e.dataTransfer.items).then(([files, folder]) => files.length > 0 && addFiles(files, folder)).catch(trouble);
  });
}

show("#door [data-flash]", board.isPossible() && Boolean($("#firmware")));
show("#plugs", board.isPossible());
show("#no-serial", !board.isPossible());
engine.start(loadModule, $("#worker").textContent).then(() => engine.ask({ do: "targets" })).then(done => {
  TARGETS = done.result;
  return showKept();
}).catch(trouble);
updateFiles();
