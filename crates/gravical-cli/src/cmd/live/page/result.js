// The end of a session: verdict, three numbers, what to do next, and the truth of a simulation.
"use strict";

const minus = text => text.replace(/^-(?=[0.]*$)/, "").replace(/-/g, "−");
// As many decimals as the uncertainty has with two digits.
const within = (value, sigma) => {
  const decimals = sigma > 0 ? Math.max(0, Math.min(6, 1 - Math.floor(Math.log10(sigma)))) : 2;
  return [minus(value.toFixed(decimals)), sigma > 0 ? sigma.toFixed(decimals) : null];
};

function command(line) {
  const button = make("button", { type: "button" }, "Copy");
  button.addEventListener("click", async () => {
    try {
      await navigator.clipboard.writeText(line);
      button.textContent = "Copied";
    } catch {
      // Without the right to copy, the line is marked, so that one key does it.
      getSelection().selectAllChildren(button.previousElementSibling);
    }
  });
  return make("div", { className: "command" }, make("code", {}, line), button);
}

function number(value, unit, what) {
  return make("div", {}, make("b", {}, value, unit ? make("small", {}, ` ${unit}`) : null), make("span", {}, what));
}

function numbers(fit) {
  const mg = v => v > 0 ? [precise(v), "mg"] : ["–", ""];
  const bias = fit?.bias_mg ? Math.hypot(...fit.bias_mg) : null;
  return make("div", { className: "numbers" },
    number(...mg(fit?.worst_mg), "error of ‖a‖ that remains at most (2σ, worst direction)"),
    number(...mg(fit?.leave_one_out_mg), fit?.leave_one_out_mg > 0
      ? "leave-one-out error: at poses that the fit did not use, rms"
      : "leave-one-out error: needs more poses than six faces"),
    number(...mg(bias), "length of the bias that was found"));
}

function truth(event) {
  const rows = event.rows.map(row => {
    const sigma = row.plus_minus > 0 ? row.plus_minus : null;
    const digits = v => within(v, sigma)[0];
    const inside = sigma ? Math.abs(row.found - row.truth) <= sigma : null;
    const word = inside === null ? ["–"] : inside ? [icon("done"), " inside"] : [icon("warning"), " outside"];
    return make("tr", {}, make("th", { scope: "row" }, `${row.name}, ${row.unit}`), make("td", {}, digits(row.truth)),
      make("td", {}, sigma ? `${digits(row.found)} ± ${within(0, sigma)[1]}` : digits(row.found)),
      make("td", { className: inside === null ? "" : inside ? "in" : "out" }, ...word));
  });
  return make("section", { className: "truth" }, make("h2", {}, "The truth"),
    make("p", {}, "Error of ‖a‖, rms over all directions: ", make("b", {}, `${precise(event.before_mg)} mg`),
      " before, ", make("b", {}, `${precise(event.norm_error_mg)} mg`), " with this calibration."),
    make("div", { className: "scroll" }, make("table", {},
      make("caption", {}, "The errors that this virtual sensor was built with, and what was found (± 2σ: 19 of 20 lie inside)"),
      make("thead", {}, make("tr", {}, make("th", {}, "error"), make("th", {}, "truth"), make("th", {}, "found"), make("th", {}, "± 2σ"))),
      make("tbody", {}, ...rows))));
}

function reportOf(address) {
  const show = make("button", { type: "button" }, "Show the report here");
  const place = make("div", {});
  show.setAttribute("aria-expanded", "false");
  show.addEventListener("click", () => {
    const open = show.getAttribute("aria-expanded") !== "true";
    show.setAttribute("aria-expanded", String(open));
    show.textContent = open ? "Hide the report" : "Show the report here";
    place.replaceChildren(...open ? [make("iframe", { src: address, title: "Calibration report" })] : []);
  });
  return make("section", {}, make("div", { className: "row" }, show,
    make("a", { className: "button", href: address, target: "_blank", rel: "noopener" }, "Open it in a new tab")), place);
}

// Everything about the end, built anew when one of its events comes.
function fillResult(place, state, reportAddress, goOn) {
  const { verdict, fit, saved, end } = state;
  const blocks = [];
  // A session that was stopped has no result yet, whatever the last fit said.
  if (verdict && (saved || verdict.final)) {
    const [, title, rest] = /^(.*?)(?:: (.*))?$/s.exec(verdict.text);
    blocks.push(make("div", { className: `grade ${verdict.grade}` }, icon(GRADES[verdict.grade]),
      make("p", {}, make("b", {}, title), make("span", {}, rest ?? ""))));
    blocks.push(numbers(fit));
  }
  if (saved) {
    blocks.push(make("p", { className: "saved" }, icon("done"), make("span", {}, "Saved as ", make("code", {}, saved.file),
      ", read back and compared.", saved.folder ? " The raw samples are in " : null, saved.folder ? make("code", {}, saved.folder) : null)));
  }
  if (saved?.folder) {
    const button = make("button", { type: "button", className: verdict?.grade === "good" ? "" : "primary" }, "Go on with more poses");
    button.addEventListener("click", goOn);
    blocks.push(make("div", { className: "row" }, button));
  }
  if (saved?.next?.length) {
    blocks.push(make("section", {}, make("h2", {}, "What to do next"), ...saved.next.map(command)));
  }
  if (end?.resume) {
    blocks.push(make("section", {}, make("h2", {}, "Go on later"), make("p", {}, "Nothing is lost; this goes on where you stopped:"), command(end.resume)));
  }
  if (state.truth) blocks.push(truth(state.truth));
  if (saved) blocks.push(reportOf(reportAddress));
  if (saved && verdict?.reasons.length) {
    blocks.push(make("details", {}, make("summary", {}, make("h2", {}, "Reasons")),
      make("ul", { className: "reasons" }, ...verdict.reasons.map(r => make("li", {}, r)))));
  }
  place.replaceChildren(...blocks);
}
