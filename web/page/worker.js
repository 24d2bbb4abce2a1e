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
    void closeSession();
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

// The folder of all sessions; none where the browser has no private files, or refuses them.
async function folders() {
  try {
    const root = await navigator.storage.getDirectory();
    return await root.getDirectoryHandle("sessions", { create: true });
  } catch {
    return null;
  }
}

// A file of a session: on the disk or in memory.
async function openFile(folder, name) {
  const all = await folders(), key = `${folder}/${name}`;
  if (!all) {
    return {
      isMemory: true, flush() {}, close() {},
      size: () => (memory.get(key) ?? []).reduce((sum, part) => sum + part.length, 0),
      add(bytes) { memory.set(key, [...memory.get(key) ?? [], bytes]); },
      read: async () => new Uint8Array(await new Blob(memory.get(key) ?? []).arrayBuffer()),
    };
  }
  const place = await all.getDirectoryHandle(folder, { create: true });
  let file;
  try {
    file = await (await place.getFileHandle(name, { create: true })).createSyncAccessHandle();
  } catch (error) {
    throw error.name === "NoModificationAllowedError" ? new Error("This session is open in another tab.") : error;
  }
  return {
    flush: () => file.flush(), close: () => file.close(), size: () => file.getSize(),
    add(bytes) {
      const at = file.getSize();
      let written = 0;
      try {
        written = file.write(bytes, { at });
      } finally {
        // Half of it would be no line.
        if (written < bytes.length) file.truncate(at);
      }
      if (written < bytes.length) throw new Error("there is no room");
    },
    // Whole lines: what a crash has cut off is dropped.
    async read() {
      const bytes = new Uint8Array(file.getSize());
      file.read(bytes, { at: 0 });
      const whole = bytes.lastIndexOf(10) + 1;
      if (whole < bytes.length) file.truncate(whole);
      return bytes.subarray(0, whole);
    },
  };
}

async function closeSession() {
  const closed = session;
  session = null;
  const files = Object.values(closed?.files ?? {}), isEmpty = files.every(file => file.size() === 0);
  for (const file of files) file.close();
  if (files.length > 0 && isEmpty) await (await folders())?.removeEntry(closed.folder, { recursive: true });
}

// A call of the session that is open; what it writes is safe before it is shown.
function guided(head, files) {
  if (!session) return {};
  const done = call(head, files);
  if (!session) return done;
  const written = done.files.filter(f => session.files[f.name]);
  try {
    for (const { name, bytes } of written) session.files[name].add(bytes);
    if (written.some(f => f.name === "session.ndjson")) KEPT.forEach(name => session.files[name].flush());
  } catch (error) {
    closeSession();
    return { error: { code: "storage", message: `The browser cannot keep more (${error.message}).` } };
  }
  return { ...done, files: done.files.filter(f => !written.includes(f)) };
}

// Events of a session are posted without a request.
const publish = done => (done.error || done.events?.length || done.files?.length) && postMessage({ done });
const happened = (head, files) => publish(guided(head, files));

const HANDLERS = {
  // One with a folder that exists goes on.
  async open({ folder, ...head }) {
    await closeSession();
    const files = {};
    try {
      for (const name of KEPT) files[name] = await openFile(folder, name);
      // The browser is asked to keep it.
      await navigator.storage.persist?.();
      const before = await Promise.all(KEPT.map(async name => ({ name, bytes: await files[name].read() })));
      session = { folder, files };
      const day_s = Date.now() / 1e3 % 86400 - head.now_s;
      const done = guided({ ...head, do: "open", day_s }, before.filter(f => f.bytes.length > 0));
      if (done.error) throw Object.assign(new Error(done.error.message), done.error);
      return { ...done, isMemory: Boolean(files[KEPT[0]].isMemory) };
    } catch (error) {
      session = { folder, files };
      await closeSession();
      throw error;
    }
  },
  tick: happened, bytes: happened, overflow: happened, lost: happened, opened: happened, command: happened,
  close: closeSession,
  async kept() {
    const names = [];
    for await (const name of (await folders())?.keys() ?? []) names.push(name);
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
    if (session?.folder === folder) await closeSession();
    await (await folders()).removeEntry(folder, { recursive: true });
  },
};

// One after the other.
let last = Promise.resolve();
addEventListener("message", ({ data: { id, head, files, module: compiled } }) => {
  if (compiled) { module = compiled; return instantiate(); }
  const answered = done => id && postMessage({ id, done: done ?? {} });
  if (!Object.hasOwn(HANDLERS, head.do)) return last = last.then(() => answered(call(head, files)));
  last = last.then(() => HANDLERS[head.do](head, files)).then(answered)
    .catch(error => postMessage({ id, done: { error: { code: "fault", message: error.message } } }));
});
