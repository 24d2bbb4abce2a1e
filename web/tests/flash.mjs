// node web/tests/flash.mjs HEX BOARD BOOTLOADER: the sketch is flashed into an emulated Uno by its own bootloader, and runs;
// other chips and boards without an answer are left alone.
import assert from "node:assert";
import { spawn } from "node:child_process";
import { readFileSync } from "node:fs";
import vm from "node:vm";

const [hex, board, bootloader] = process.argv.slice(2), root = new URL("../../", import.meta.url).pathname;
const text = readFileSync(hex, "utf8");
const world = vm.createContext({ Uint8Array, performance, setTimeout, board: { openPort: (port, options) => port.open(options) } });
vm.runInContext(`${readFileSync(`${root}web/page/flash.js`, "utf8")}\nvar exported = { flash, parseHex };`, world);
const { flash, parseHex } = world.exported;

// A port of Web Serial to a clone with the older bootloader: DTR resets the board, which begins anew with an empty flash.
// `changed` alters what it sends.
class Port {
  constructor(changed = bytes => bytes) { this.changed = changed; this.sent = ""; this.baudRates = []; }
  async open({ baudRate }) {
    this.baudRates.push(baudRate);
    this.readable = new ReadableStream({ start: controller => { this.controller = controller; } });
    this.writable = new WritableStream({ write: bytes => { this.child?.stdin.write(bytes); } });
  }
  async setSignals({ dataTerminalReady }) {
    if (!dataTerminalReady || this.baudRates.at(-1) !== 57600) return;
    this.child?.kill();
    this.child = spawn(board, [bootloader], { stdio: ["pipe", "pipe", "inherit"] });
    this.child.stdin.on("error", () => {});
    this.child.stdout.on("data", bytes => {
      this.sent += bytes.toString("latin1");
      try { this.controller.enqueue(this.changed(new Uint8Array(bytes))); } catch { /* it is closed */ }
    });
  }
  async close() { this.readable = this.writable = null; }
}

const began = performance.now();
const port = new Port(), told = [];
const pages = await flash(port, text, words => told.push(words));
assert.equal(pages, Math.ceil(parseHex(text).length / 128));
assert(told.includes(`writing 1 of ${pages} pages`) && told.includes(`reading back ${pages} of ${pages} pages`));
// The sketch runs: it says what it is.
port.sent = "";
for (let i = 0; !port.sent.includes("# gravical mpu6050_logger"); i++) {
  assert(i < 100, `the sketch is silent: ${JSON.stringify(port.sent.slice(0, 200))}`);
  await new Promise(done => setTimeout(done, 100));
}
port.child.kill();
const took = performance.now() - began;

// Another chip: an answer with its signature. Nothing is written.
const other = new Port(bytes => Uint8Array.from(bytes, byte => byte === 0x95 ? 0x94 : byte));
await assert.rejects(flash(other, text, () => {}), /1e 94 0f.*Nothing was written/);
other.child.kill();
// A board without a bootloader: both speeds are tried.
const mute = new Port();
mute.setSignals = async () => {};
await assert.rejects(flash(mute, text, () => {}), /Nothing was written/);
assert.deepEqual(mute.baudRates, [115200, 57600]);
assert.throws(() => parseHex(":10000000FFFF\n"), /damaged/);
console.log(`${pages} pages in ${(took / 1e3).toFixed(1)} s, and the sketch runs`);
