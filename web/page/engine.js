// The way to gravical: `ask` an object with files, and get an object with files. It works in a thread of its own, which
// can be ended.

const engine = {
  worker: null, module: null, waiting: new Map(), ids: 0,
  // Receives the events of a session.
  onEvents() {},
  // `load` gives the compiled module, `script` is the text of worker.js.
  async start(load, script) {
    this.script = URL.createObjectURL(new Blob([script], { type: "text/javascript" }));
    this.ready = load().then(module => { this.module = module; this.begin(); });
    await this.ready;
  },
  begin() {
    this.worker = new Worker(this.script);
    this.worker.addEventListener("message", ({ data: { id, done } }) => {
      if (!id) return this.onEvents(done);
      this.waiting.get(id)?.(done);
      this.waiting.delete(id);
    });
    // Unexpected errors are reported, too.
    this.worker.addEventListener("error", e => this.onEvents({ error: { message: e.message } }));
    this.worker.postMessage({ module: this.module });
  },
  // Without an answer.
  post(head, files = [], id = 0) {
    this.worker.postMessage({ id, head, files: files.map(({ name, bytes, role }) => ({ name, bytes, role })) });
  },
  async ask(head, files = []) {
    await this.ready;
    const id = ++this.ids;
    const done = await new Promise(resolve => {
      this.waiting.set(id, resolve);
      this.post(head, files, id);
    });
    if (done.error) throw Object.assign(new Error(done.error.message), done.error);
    return done;
  },
  // Ends the thread, whatever it does; the next request starts in a new one.
  cancel() {
    this.worker.terminate();
    for (const answer of this.waiting.values()) answer({ error: { code: "cancelled", message: "Cancelled." } });
    this.waiting.clear();
    this.begin();
  },
};

// Parts of the page are packed, and base64.
const packed = element => Uint8Array.from(atob(element.textContent), c => c.charCodeAt(0));

// The program is part of the page, or it lies beside it.
async function loadModule() {
  if (!$("#wasm")) return WebAssembly.compileStreaming(fetch("gravical.wasm"));
  const unpacked = new Blob([packed($("#wasm"))]).stream().pipeThrough(new DecompressionStream("gzip"));
  return WebAssembly.compile(await new Response(unpacked).arrayBuffer());
}

// A file for the user.
function save(name, bytes) {
  const link = document.createElement("a");
  link.href = URL.createObjectURL(new Blob([bytes]));
  link.download = name;
  link.click();
  setTimeout(() => URL.revokeObjectURL(link.href), 60000);
}

// The address of a page, for a tab; always the same of the same bytes.
const addresses = new WeakMap();
function address(bytes) {
  if (!addresses.has(bytes)) addresses.set(bytes, URL.createObjectURL(new Blob([bytes], { type: "text/html" })));
  return addresses.get(bytes);
}
