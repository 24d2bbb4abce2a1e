// node web/tests/wasm.mjs WASM GRAVICAL: the program as WebAssembly, in the worker of the page, computes what the program
// computes; it imports nothing, and a trap is an answer.
import assert from "node:assert";
import { execFileSync } from "node:child_process";
import { mkdtempSync, readFileSync, rmSync } from "node:fs";
import { tmpdir } from "node:os";
import { resolve } from "node:path";
import vm from "node:vm";

const [wasm, gravical] = process.argv.slice(2).map(path => resolve(path)), root = new URL("../../", import.meta.url).pathname;
const bytes = readFileSync(wasm), module = new WebAssembly.Module(bytes);
assert.equal(WebAssembly.Module.imports(module).length, 0);
// As the page carries it.
const size = execFileSync("gzip", ["-9nc", wasm], { maxBuffer: 1e8 }).length;
assert(size <= 1.2e6, `${size} bytes packed`);

// The worker, with its one way in and its one way out.
let listen, hear;
const world = vm.createContext({ WebAssembly, TextEncoder, TextDecoder, DataView, Uint8Array, Date, JSON,
  performance, clearInterval, setInterval,
  addEventListener: (_, f) => { listen = f; }, postMessage: m => hear(m) });
vm.runInContext(readFileSync(`${root}web/page/worker.js`, "utf8"), world);
listen({ data: { module } });
const ask = (head, files = []) => new Promise(answered => {
  hear = ({ done }) => answered(done);
  listen({ data: { id: 1, head, files } });
});

// Equal but for the last digits: sine and exponential are not the same everywhere.
function near(a, b, where = "") {
  if (typeof a === "number" && typeof b === "number") return assert(Math.abs(a - b) <= 1e-6 * Math.max(Math.abs(a), Math.abs(b), 1e-9), `${where}: ${a} ${b}`);
  if (a === null || typeof a !== "object") return assert.equal(a, b, where);
  for (const key of new Set([...Object.keys(a), ...Object.keys(b)])) if (!["created", "command"].includes(key)) near(a[key], b[key], `${where}.${key}`);
}

const folder = mkdtempSync(`${tmpdir()}/gravical-wasm-`);
const names = ["x_axis_pos", "x_axis_neg", "y_axis_pos", "y_axis_neg", "z_axis_pos", "z_axis_neg"].map(n => `${n}.csv`);
const six = names.map(name => ({ name, role: "", bytes: new Uint8Array(readFileSync(`${root}examples/simulated-six-position/${name}`)) }));
const run = (...words) => JSON.parse(execFileSync(gravical, words, { cwd: `${root}examples/simulated-six-position`, maxBuffer: 1e8, stdio: ["ignore", "pipe", "ignore"] }));
const began = performance.now();
const made = await ask({ do: "calibrate", options: { gravity: 9.81 } }, six);
const took = performance.now() - began;
near(JSON.parse(JSON.stringify(made.result)), run("calibrate", ...names, "--gravity", "9.81", "--json"), "calibrate");
assert.deepEqual(made.files.map(f => f.name), ["report.html", "calibration.json"]);
const line = { name: "line.csv", role: "", bytes: new Uint8Array(readFileSync(`${root}examples/demo/line/line.csv`)) };
const moved = await ask({ do: "motion", options: {} }, [line]);
near(JSON.parse(JSON.stringify(moved.result)).moves, run("motion", "../demo/line/line.csv", "-o", `${folder}/t.csv`, "--json").moves, "motion");
rmSync(folder, { recursive: true });

assert.equal((await ask({ do: "calibrate" }, [{ name: "x.csv", role: "", bytes: new Uint8Array(0) }])).error.code, "empty-file");
// A trap: there is no memory at this address. What follows finds a new instance.
const { code } = vm.runInContext(`(() => {
  const { alloc } = wasm, broken = { ...wasm, memory: wasm.memory, alloc: size => (alloc(size), 0x7fffffff) };
  wasm = broken;
  return call({ do: "targets" }, []).error;
})()`, world);
assert.equal(code, "out-of-memory");
assert((await ask({ do: "targets" })).result.length > 5);
console.log(`${size} bytes packed; six files in ${took.toFixed(0)} ms`);
