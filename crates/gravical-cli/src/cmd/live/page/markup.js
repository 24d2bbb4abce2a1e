// Parts of the page that are built as a whole when an event changes them.

class Markup extends String {}

// A value in markup: text is always text, whatever a board sends; lists are joined, what is not there is nothing.
function inMarkup(value) {
  if (value instanceof Markup) return value;
  if (Array.isArray(value)) return value.map(inMarkup).join("");
  return value === false || value == null ? "" : String(value).replace(/[&<>"']/g, c => `&#${c.charCodeAt(0)};`);
}
const html = (parts, ...values) => new Markup(String.raw({ raw: parts }, ...values.map(inMarkup)));

// With two digits, as the sentences of the program have them.
const inMg = v => v > 0 ? `${v.toFixed(Math.max(0, Math.min(6, 1 - Math.floor(Math.log10(v)))))} mg` : "–";

const tileMarkup = (face, i) => html`<li>
  <button type="button" data-face="${face}" aria-keyshortcuts="${i + 1}" disabled>
    <b>${faceName(face)} up</b>
    <span class="drawing ${face[1]} ${face[0] === "+" ? "high" : "low"}" aria-hidden="true"></span>
    <span class="mark"></span>
  </button></li>`;

const commandMarkup = line => html`<p class="command"><code>${line}</code><button type="button">Copy</button></p>`;

function portMarkup(port, i) {
  const where = [port.name, port.usb, port.serial && `number ${port.serial}`].filter(Boolean).join(" · ");
  const what = port.device ?? (port.board ? "A board" : "Unknown device");
  const key = i < 9 ? i + 1 : "";
  return html`<button type="button" class="${port.board && "board"}" data-port="${port.name}" aria-keyshortcuts="${key}">
    <span><b>${what}</b><small>${where}</small></span></button>`;
}

const portsMarkup = ({ ports, tried, flash, simulate }) => html`
  <div>
    ${ports.map(portMarkup)}
    ${tried && html`
      <button type="button" id="again" data-port="${tried}" aria-keyshortcuts="Enter">Try ${tried} again</button>`}
  </div>
  <div>
    ${flash.length > 0 && html`<h2>Flash the sketch</h2>
      <p class="note">Ours is for an Uno with an MPU6050. In the folder of gravical:</p>
      ${flash.map(commandMarkup)}`}
    ${simulate && html`<h2>No board at hand?</h2>
      <button type="button" data-command='{"command":"simulate"}' aria-keyshortcuts="S">Try the simulated sensor</button>`}
  </div>`;

const clock = t_s => `${Math.floor(t_s / 60)}:${String(Math.floor(t_s % 60)).padStart(2, "0")}`;
const logMarkup = ({ t_s, mark, text }) => html`
  <li data-mark="${mark}"><time>${clock(t_s)}</time><p class="mark"><span>${text}</span></p></li>`;

// Verdicts judge by these limits, mg.
const GOOD_MG = 5, FAIR_MG = 20;
const range = (from, to) => Array.from({ length: to - from + 1 }, (_, i) => from + i);

// The predicted error after each pose, by a logarithmic scale, and the error that could hide in one pose.
function errorsMarkup(fits) {
  const errors = fits.flatMap(f => [f.worst_mg, f.undetected_mg]).filter(mg => mg > 0);
  const low = Math.floor(Math.log10(Math.min(1, ...errors))), high = Math.log10(Math.max(150, ...errors));
  const most = Math.max(10, ...fits.map(f => f.poses + 1));
  const x = poses => 62 + (poses - 4) / (most - 4) * 246;
  const y = mg => 6 + (high - Math.log10(mg)) / (high - low) * 122;
  const rule = (mg, name) => html`<path class="${name}" d="M50 ${y(mg)}H320"/>`;
  const label = (x, y, text, anchor = "middle", name = "") => html`
    <text class="${name}" x="${x}" y="${y}" dy=".34em" text-anchor="${anchor}">${text}</text>`;
  const curve = (field, sign) => {
    const points = fits.filter(f => f[field] > 0).map(f => [x(f.poses), y(f[field])]);
    return html`<polyline class="${field}" points="${points.join(" ")}"/>
      ${points.map(p => label(...p, sign, "middle", field))}`;
  };
  return html`
    <path class="good-range" d="M50 ${y(GOOD_MG)}H320V128H50z"/>
    ${range(low, Math.floor(high)).map(n => [rule(10 ** n, ""), label(44, y(10 ** n), `${10 ** n} mg`, "end")])}
    ${range(4, most).filter(n => n % Math.ceil(most / 12) === 0).map(n => label(x(n), 141, n))}
    ${label(44, 141, "poses", "end")}
    ${rule(GOOD_MG, "good")} ${label(54, y(GOOD_MG) + 9, "good: 5 mg", "start", "good")}
    ${rule(FAIR_MG, "fair")} ${label(318, y(FAIR_MG) - 8, "fair: 20 mg", "end", "fair")}
    ${fits.length === 0 && label(185, y(60), "from the fourth pose on")}
    ${curve("undetected_mg", "▲")} ${curve("worst_mg", "●")}`;
}

// The mark of each grade.
const GRADES = { "good": "done", "fair": "near", "poor": "cross", "not-verifiable": "question" };

// Where there is no report to say it.
function gradeMarkup({ grade, text }) {
  const [, title, rest] = /^(.*?)(?:: (.*))?$/s.exec(text);
  return html`<div class="grade mark ${grade}" data-mark="${GRADES[grade]}"><p><b>${title}</b><span>${rest}</span></p></div>`;
}

const savedMarkup = ({ file, folder }, grade) => html`
  <p class="saved mark" data-mark="done"><span>Saved as <code>${file}</code>.
    ${folder && html`The raw samples are in <code>${folder}</code>`}</span></p>
  ${folder && grade !== "good" && html`<p><button type="button" class="primary"
    data-command='{"command":"resume"}'>Go on with more poses</button></p>`}`;

const reportMarkup = address => html`
  <iframe src="${address}" title="Calibration report"></iframe>
  <p><a href="${address}" target="_blank" rel="noopener">The report in a new tab</a></p>`;

// The end of a session. One that was stopped has no result yet, whatever the last fit said.
const resultMarkup = ({ verdict, saved, end, truth }, report) => html`
  ${!saved?.report && verdict && (saved || verdict.final) && gradeMarkup(verdict)}
  ${saved && savedMarkup(saved, verdict?.grade)}
  ${end?.resume && html`<section><h2>Go on later</h2>
    <p>Nothing is lost; this goes on where you stopped:</p>${commandMarkup(end.resume)}</section>`}
  ${truth && html`<p class="truth">${truth.text}</p>`}
  ${saved?.report && reportMarkup(report)}
  ${saved?.next.length > 0 && html`<section><h2>What to do next</h2>${saved.next.map(commandMarkup)}</section>`}`;
