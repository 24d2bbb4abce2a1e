// gravical itself: takes one message after the other. The form of a message is in message.rs.
"use strict";

let module, wasm;
const instantiate = () => { wasm = new WebAssembly.Instance(module).exports; };
const answer = () => new Uint8Array(wasm.memory.buffer, wasm.answer() >>> 0, wasm.answer_size() >>> 0).slice();

// An object and files in, an object and files out.
function call(head, files) {
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
    // A panic, whose words are the answer; without any the memory did not suffice.
    let words = "";
    try { words = new TextDecoder().decode(answer()); } catch { /* nothing can be read */ }
    instantiate();
    return { error: words ? { code: "panic", message: `This is a fault of gravical: ${words}` }
      : { code: "out-of-memory", message: `The memory of this page does not suffice (${error.message}).`, hint: "The program has more: see the README." } };
  }
  const bytes = answer(), length = new DataView(bytes.buffer).getUint32(0, true);
  let at = 4 + length;
  const done = JSON.parse(new TextDecoder().decode(bytes.subarray(4, at)));
  done.files = done.files.map(({ name, size }) => ({ name, bytes: bytes.slice(at, at += size) }));
  return done;
}

addEventListener("message", ({ data: { id, head, files, module: compiled } }) => {
  if (compiled) { module = compiled; return instantiate(); }
  postMessage({ id, done: call(head, files) });
});
