// Parts of the page that are built as a whole when an event changes them.
"use strict";

class Markup extends String {}

// A value in markup: text is always text, whatever a board sends; lists are joined, what is not there is nothing.
function inMarkup(value) {
  if (value instanceof Markup) return value;
  if (Array.isArray(value)) return value.map(inMarkup).join("");
  return value === false || value == null ? "" : String(value).replace(/[&<>"']/g, c => `&#${c.charCodeAt(0)};`);
}
const html = (parts, ...values) => new Markup(String.raw({ raw: parts }, ...values.map(inMarkup)));

const TWO_DIGITS = new Intl.NumberFormat("en", { minimumSignificantDigits: 2, maximumSignificantDigits: 2, useGrouping: false });
const inMg = v => v > 0 ? `${TWO_DIGITS.format(v)} mg` : "–";

const tilesMarkup = () => FACES.map((face, i) => html`<li><button type="button" data-face="${face}" data-mark="to_do" aria-keyshortcuts="${i + 1}" disabled>
  <b>${faceName(face)} up</b><span class="drawing ${face[1]} ${face[0] === "+" ? "high" : "low"}" aria-hidden="true"></span><span class="mark"></span></button></li>`);

const commandMarkup = line => html`<p class="command"><code>${line}</code><button type="button" class="copy">Copy</button></p>`;

function portMarkup(port, i) {
  const busy = port.open_in?.length && `open in ${port.open_in.join(", ")}`;
  return html`<button type="button" class="${port.board && "board"}" data-command="${JSON.stringify({ command: "port", name: port.name })}"
    aria-keyshortcuts="${i < 9 ? i + 1 : ""}"><span><b>${port.device ?? (port.board ? "A board" : "Unknown device")}</b>
    <small>${[port.name, port.usb, port.serial && `number ${port.serial}`, busy].filter(Boolean).join(" · ")}</small></span></button>`;
}

const portsMarkup = ({ ports, tried, flash, simulate }) => html`
  <div>${ports.map(portMarkup)}
    ${tried && html`<button type="button" id="again" data-command="${JSON.stringify({ command: "port", name: tried })}" aria-keyshortcuts="Enter"><span>Try ${tried} again</span></button>`}</div>
  <div>${flash.length > 0 && html`<h2>Flash the sketch</h2>
      <p class="note">Ours is for an Uno with an MPU6050. In the folder of gravical:</p>${flash.map(commandMarkup)}`}
    ${simulate && html`<h2>No board at hand?</h2>
      <button type="button" data-command='{"command":"simulate"}' aria-keyshortcuts="S">Try the simulated sensor</button>`}</div>`;

const clock = t_s => `${Math.floor(t_s / 60)}:${String(Math.floor(t_s % 60)).padStart(2, "0")}`;
const historyMarkup = log => log.slice(-60).reverse().map(l => html`<li data-mark="${l.mark}"><time>${clock(l.t_s)}</time><p class="mark"><span>${l.text}</span></p></li>`);

// Verdicts judge by these limits, mg.
const GOOD_MG = 5, FAIR_MG = 20;

// The predicted error after each pose, by a logarithmic scale, and the error that could hide in one pose.
function errorsMarkup(fits) {
  const values = fits.flatMap(f => [f.worst_mg, f.undetected_mg]).filter(mg => mg > 0);
  const low = Math.floor(Math.log10(Math.min(1, ...values))), high = Math.log10(Math.max(150, ...values));
  const least = Math.min(4, ...fits.map(f => f.poses)), most = Math.max(10, ...fits.map(f => f.poses + 1));
  const x = n => (62 + (n - least) / (most - least) * 246).toFixed(1);
  const y = mg => (6 + (high - Math.log10(mg)) / (high - low) * 122).toFixed(1);
  const rule = (mg, name) => html`<path class="${name}" d="M50 ${y(mg)}H320"/>`;
  const decades = Array.from({ length: Math.floor(high) - low + 1 }, (_, i) => 10 ** (low + i));
  const counts = Array.from({ length: most - least + 1 }, (_, i) => least + i).filter(n => (n - least) % Math.ceil((most - least) / 8) === 0);
  const line = (field, name, mark) => {
    const points = fits.filter(f => f[field] > 0).map(f => [x(f.poses), y(f[field])]);
    return html`<polyline class="${name}" points="${points.join(" ")}"/>${points.map(p => html`<text class="${name}" x="${p[0]}" y="${p[1]}" dy=".34em" text-anchor="middle">${mark}</text>`)}`;
  };
  return html`<path class="good-range" d="M50 ${y(GOOD_MG)}H320V128H50z"/>
    ${decades.map(mg => html`${rule(mg, "grid")}<text x="44" y="${y(mg)}" dy=".34em" text-anchor="end">${mg} mg</text>`)}
    ${counts.map(n => html`<text x="${x(n)}" y="145" text-anchor="middle">${n}</text>`)}<text x="44" y="145" text-anchor="end">poses</text>
    ${rule(GOOD_MG, "good")}<text class="good" x="54" y="${y(GOOD_MG)}" dy="1.15em">good: 5 mg</text>
    ${rule(FAIR_MG, "fair")}<text class="fair" x="318" y="${y(FAIR_MG)}" dy="-.4em" text-anchor="end">fair: 20 mg</text>
    ${fits.length === 0 && html`<text x="185" y="${y(60)}" text-anchor="middle">from the fourth pose on</text>`}
    ${line("undetected_mg", "undetected", "▲")}${line("worst_mg", "worst", "●")}`;
}

// The mark of each grade.
const GRADES = { "good": "done", "fair": "near", "poor": "cross", "not-verifiable": "question" };

function truthMarkup({ before_mg, norm_error_mg, rows }) {
  const row = ({ name, unit, truth, found, plus_minus }) => {
    // As many decimals as the uncertainty has with two digits.
    const decimals = plus_minus > 0 ? Math.max(0, Math.min(6, 1 - Math.floor(Math.log10(plus_minus)))) : 2;
    const text = v => v.toFixed(decimals).replace(/^-(?=[0.]*$)/, "").replace("-", "−");
    const is_inside = Math.abs(found - truth) <= plus_minus;
    return html`<tr><th scope="row">${name}, ${unit}</th><td>${text(truth)}</td><td>${text(found)}${plus_minus > 0 && ` ± ${text(plus_minus)}`}</td>
      <td>${plus_minus > 0 ? html`<span class="mark" data-mark="${is_inside ? "done" : "warning"}">${is_inside ? "inside" : "outside"}</span>` : "–"}</td></tr>`;
  };
  return html`<section class="truth"><h2>The truth</h2>
    <p>Error of ‖a‖, rms over all directions: <b>${inMg(before_mg)}</b> before, <b>${inMg(norm_error_mg)}</b> with this calibration.</p>
    <div class="scroll"><table><caption>The errors that this virtual sensor was built with, and what was found (± 2σ: 19 of 20 lie inside)</caption>
      <thead><tr><th>error</th><th>truth</th><th>found</th><th>± 2σ</th></tr></thead><tbody>${rows.map(row)}</tbody></table></div></section>`;
}

// The end of a session: verdict, three numbers, what to do next, and the truth of a simulation.
function resultMarkup({ verdict, fit, saved, end, truth }, report) {
  // A session that was stopped has no result yet, whatever the last fit said.
  const judged = verdict && (saved || verdict.final) && verdict;
  const [, title, rest] = /^(.*?)(?:: (.*))?$/s.exec(judged?.text ?? "");
  return html`
    ${judged && html`<div class="grade mark ${judged.grade}" data-mark="${GRADES[judged.grade]}"><p><b>${title}</b><span>${rest}</span></p></div>
    <div class="numbers">
      <p><b>${inMg(fit?.worst_mg)}</b><span>error of ‖a‖ that remains at most (2σ, worst direction)</span></p>
      <p><b>${inMg(fit?.leave_one_out_mg)}</b><span>leave-one-out error: ${fit?.leave_one_out_mg > 0 ? "at poses that the fit did not use, rms" : "needs more poses than six faces"}</span></p>
      <p><b>${inMg(Math.hypot(...fit?.bias_mg ?? []))}</b><span>length of the bias that was found</span></p></div>`}
    ${saved && html`<p class="saved mark" data-mark="done"><span>Saved as <code>${saved.file}</code>, read back and compared.
      ${saved.folder && html`The raw samples are in <code>${saved.folder}</code>`}</span></p>`}
    ${saved?.folder && html`<p><button type="button" class="${judged?.grade !== "good" && "primary"}" data-command='{"command":"resume"}'>Go on with more poses</button></p>`}
    ${saved?.next.length > 0 && html`<section><h2>What to do next</h2>${saved.next.map(commandMarkup)}</section>`}
    ${end?.resume && html`<section><h2>Go on later</h2><p>Nothing is lost; this goes on where you stopped:</p>${commandMarkup(end.resume)}</section>`}
    ${truth && truthMarkup(truth)}
    ${saved && html`<details class="report"><summary><h2>The report</h2></summary><iframe src="${report}" title="Calibration report" loading="lazy"></iframe></details>
      <p><a href="${report}" target="_blank" rel="noopener">The report in a new tab</a></p>`}
    ${saved && judged?.reasons.length > 0 && html`<details><summary><h2>Reasons</h2></summary><ul>${judged.reasons.map(r => html`<li>${r}</li>`)}</ul></details>`}`;
}
