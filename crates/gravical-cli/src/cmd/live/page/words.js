// What the page says: the one sentence, the ring, the board, the connection.
"use strict";


// The one sentence, and the line below it.
function sentence(state, answers, full) {
  const now = stage(state);
  if (full) return ["This session is open in too many tabs.", "Close one of them, and this tab shows the session."];
  if (!answers && !state.end) {
    const folder = state.session?.folder;
    return ["The program does not answer.", folder
      ? `If it has ended: gravical live --resume ${folder} goes on, and no pose is lost.`
      : "Is gravical live still running? This page connects again by itself."];
  }
  if (now === "connect") return state.ports ? parts(state.ports.text) : ["Connecting …", state.connecting?.text ?? ""];
  if (now === "end") return parts(state.end.text);
  if (now === "lost") return parts(state.lost.text);
  const [main, rest] = parts(state.status?.text ?? "Reading the first samples …");
  // What was found out about the board is said while there is nothing else to do.
  const found = now === "floor" && state.identified ? parts(state.identified.text)[1] : "";
  return [main, state.status?.hint ?? (rest || found)];
}

// A port in two lines: what it is, and where.
function portWords(port) {
  const what = port.device ?? (port.board ? "A board" : "Unknown device");
  const busy = port.open_in?.length ? `open in ${port.open_in.join(", ")}` : "";
  return [what, [port.name, port.usb, port.serial && `number ${port.serial}`, busy].filter(Boolean).join(" · ")];
}

const LOST = { unplugged: "Unplugged", silent: "No samples" };

// What the ring says: [class, text, share, colour]; `accepted` for a moment after a pose.
function ring(state, ink, accepted) {
  const s = state.status, now = stage(state);
  if (accepted) return ["done", "Done", 1, "#009E73"];
  if (now === "lost") return ["lost", LOST[state.lost.why] ?? "Lost", 0, "#D55E00"];
  if (now === "wait") {
    const word = !s.still ? "Moving" : s.welcome === "duplicate" ? `${faceName(s.face)} is done already`
      : s.welcome === "between" ? "Between two faces" : "At rest";
    return ["", word, 0, ink.line];
  }
  const word = { floor: "Hands off", settle: "Hold still", capture: "Capturing" }[now];
  return word ? [now, word, s.ring, now === "capture" ? ink.accent : "#E69F00"] : ["", "", 0, ink.line];
}

// What was found out about the board, and its temperature now.
function facts({ identified, status }) {
  const found = parts(identified?.text ?? "")[0].replace(/\.$/, "");
  return Number.isFinite(status?.temperature_c) ? `${found} · ${status.temperature_c.toFixed(1)} °C` : found;
}

function pill(state, answers) {
  const now = stage(state);
  if (now === "end") return ["", "Ended"];
  if (!answers) return ["poor", "No answer"];
  if (now === "connect") return state.ports ? ["fair", "No board yet"] : ["", "Connecting"];
  if (now === "lost") return ["poor", LOST[state.lost.why] ?? "Lost"];
  return ["good", state.session.source === "port" ? "Connected" : state.session.source === "simulate" ? "Simulated" : "Replay"];
}
