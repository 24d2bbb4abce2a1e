// gravical itself, in a thread of its own: takes one message after the other, and keeps what a session records. The form
// of a message is in message.rs.
"use strict";

let module, wasm;
const instantiate = () => { wasm = new WebAssembly.Instance(module).exports; };
const answer = () => new Uint8Array(wasm.memory.buffer, wasm.answer() >>> 0, wasm.answer_size() >>> 0).slice();

// An object and files in, an object and files out.
function call(head, files = []) {
  const names = files.map(({ name, role, bytes }) => ({ name, role, size: bytes.length }));
  const text = new TextEncoder().encode(JSON.stringify({ ...head, utc_s: Date.now() / 1e3, files: names }));
  const size = 4 + text.length + files.reduce((sum, { bytes }) => sum + bytes.length, 0);
  try {
    const start = wasm.alloc(size) >>> 0;
    new DataView(wasm.memory.buffer).setUint32(start, text.length, true);
    let at = start + 4;
    for (const bytes of [text, ...files.map(f => f.bytes)]) {
      new Uint8Array(wasm.memory.buffer, at, bytes.length).set(bytes);
      at += bytes.length;
    }
    wasm.call(start, size);
  } catch (error) {
    // A panic, whose words are the answer; without any the memory did not suffice. What was in memory is gone.
    let words = "";
    try { words = /^panicked at [^]*/.exec(new TextDecoder().decode(answer()))?.[0] ?? ""; } catch { /* nothing can be read */ }
    instantiate();
    closeSession();
    return { error: words ? { code: "panic", message: `This is a fault of gravical: ${words}` }
      : { code: "out-of-memory", message: `The memory of this page does not suffice (${error.message}).`, hint: "The program has more: see the README." } };
  }
  const bytes = answer(), length = new DataView(bytes.buffer).getUint32(0, true);
  let at = 4 + length;
  const done = JSON.parse(new TextDecoder().decode(bytes.subarray(4, at)));
  done.files = done.files.map(({ name, size }) => ({ name, bytes: bytes.slice(at, at += size) }));
  return done;
}

// ---- What a session records: in the private file system of this site; where there is none, in memory ----

const KEPT = ["recording.csv", "session.ndjson"];
const memory = new Map();
// The session that is open: its name, its files.
let session = null;
const now_s = () => performance.now() / 1e3;

const folders = async () => (await navigator.storage.getDirectory()).getDirectoryHandle("sessions", { create: true });

async function openFile(folder, name) {
  try {
    const place = await (await folders()).getDirectoryHandle(folder, { create: true });
    const file = await (await place.getFileHandle(name, { create: true })).createSyncAccessHandle();
    return {
      add(bytes) { file.write(bytes, { at: file.getSize() }); },
      read() {
        const bytes = new Uint8Array(file.getSize());
        file.read(bytes, { at: 0 });
        return bytes;
      },
      flush: () => file.flush(), close: () => file.close(),
    };
  } catch (error) {
    if (error.name === "NoModificationAllowedError") throw new Error("This session is open in another tab.");
    const key = `${folder}/${name}`;
    return {
      add(bytes) { memory.set(key, [...memory.get(key) ?? [], bytes]); },
      read: async () => new Uint8Array(await new Blob(memory.get(key) ?? []).arrayBuffer()),
      flush() {}, close() {}, isMemory: true,
    };
  }
}

function closeSession() {
  clearInterval(session?.ticking);
  for (const file of Object.values(session?.files ?? {})) file.close();
  session = null;
}

// A call of the session that is open; what it writes is safe before it is shown.
function guided(head, files) {
  if (!session) return {};
  const done = call({ ...head, now_s: now_s() }, files);
  if (!session) return done;
  const written = done.files.filter(f => session.files[f.name]);
  for (const { name, bytes } of written) session.files[name].add(bytes);
  if (written.some(f => f.name === "session.ndjson")) Object.values(session.files).forEach(file => file.flush());
  if (done.over) clearInterval(session.ticking);
  return { ...done, files: done.files.filter(f => !written.includes(f)) };
}

// What happens in a session is said without a question.
const say = done => (done.error || done.events?.length || done.files?.length || done.commands) && postMessage({ done });

const DOES = {
  // One with a folder that exists goes on.
  async open({ folder, ...head }) {
    closeSession();
    const files = {};
    for (const name of KEPT) files[name] = await openFile(folder, name);
    const before = await Promise.all(KEPT.map(async name => ({ name, bytes: await files[name].read() })));
    session = { folder, files };
    const done = guided({ ...head, do: "open", day_s: Date.now() / 1e3 % 86400 - now_s() }, before.filter(f => f.bytes.length > 0));
    if (done.error) closeSession();
    else session.ticking = setInterval(() => say(guided({ do: "tick" })), 25);
    return { ...done, isMemory: Boolean(files[KEPT[0]].isMemory) };
  },
  bytes: (head, files) => say(guided(head, files)),
  lost: head => say(guided(head)),
  opened: head => say(guided(head)),
  command: head => say(guided(head)),
  close: closeSession,
  async kept() {
    const names = [];
    try {
      for await (const name of (await folders()).keys()) names.push(name);
    } catch { /* nothing is kept here */ }
    return { names: names.sort() };
  },
  async files({ folder }) {
    return { files: await Promise.all(KEPT.map(async name => {
      const own = session?.folder === folder ? session.files[name] : null, file = own ?? await openFile(folder, name);
      const bytes = await file.read();
      if (!own) file.close();
      return { name, bytes };
    })) };
  },
  async forget({ folder }) {
    if (session?.folder === folder) closeSession();
    await (await folders()).removeEntry(folder, { recursive: true });
  },
};

// One after the other.
let last = Promise.resolve();
addEventListener("message", ({ data: { id, head, files, module: compiled } }) => {
  if (compiled) { module = compiled; return instantiate(); }
  const answered = done => id && postMessage({ id, done: done ?? {} });
  if (!Object.hasOwn(DOES, head.do)) return last = last.then(() => answered(call(head, files)));
  last = last.then(() => DOES[head.do](head, files)).then(answered)
    .catch(error => postMessage({ id, done: { error: { code: "fault", message: error.message } } }));
});
