// The program that serves this page: commands are posted, events are sent by it (server-sent events).

const token = encodeURIComponent(new URLSearchParams(location.search).get("token") ?? "");
const address = name => `${name}?token=${token}`;
// A program that lives says so every second.
const SILENCE_MS = 2500;
let silence = 0;

// What the page needs of whoever guides it; `send` returns what went wrong, in words.
const host = {
  async send(command) {
    try {
      const answer = await fetch(address("command"), {
        method: "POST", headers: { "Content-Type": "application/json" }, body: JSON.stringify(command),
      });
      if (answer.ok) return "";
      const { error } = await answer.json().catch(() => ({}));
      return error ?? `The program refused that (${answer.status}).`;
    } catch {
      return "The program did not answer.";
    }
  },
  listen(page) {
    const stream = new EventSource(address("events"));
    const heard = () => {
      clearTimeout(silence);
      silence = page.hasEnded() ? 0 : setTimeout(page.silence, SILENCE_MS);
    };
    stream.addEventListener("open", () => {
      heard();
      page.begin();
    });
    stream.addEventListener("alive", () => {
      heard();
      page.answers();
    });
    stream.addEventListener("error", () => {
      // After the end the program may go: there is nothing to wait for.
      if (page.hasEnded()) stream.close();
      // A stream that is opened again at once is not worth a word; one that fails again and again is.
      silence ||= setTimeout(page.silence, SILENCE_MS);
      // A refused connection is final for the browser, so it is tried again here.
      if (stream.readyState === EventSource.CLOSED && !page.hasEnded()) setTimeout(() => this.listen(page), 2000);
    });
    stream.addEventListener("message", e => {
      heard();
      page.events(e.data.split("\n").filter(Boolean).map(line => JSON.parse(line)));
    });
  },
  report: () => address("report"),
  fill(frame) { frame.src = address("report"); },
  flashMarkup: ({ flash }) => flash.length > 0 && html`<h2>Flash the sketch</h2>
    <p class="note">Ours is for an Uno with an MPU6050. In the folder of gravical:</p>
    ${flash.map(commandMarkup)}`,
  savedMarkup: ({ file, folder }, grade) => html`
    <p class="saved mark" data-mark="done"><span>Saved as <code>${file}</code>.
      ${folder && html`The raw samples are in <code>${folder}</code>`}</span></p>
    ${folder && grade !== "good" && resumeMarkup("Go on with more poses")}`,
  laterMarkup: ({ resume }) => resume && html`<section><h2>Go on later</h2>
    <p>Nothing is lost; this goes on where you stopped:</p>${commandMarkup(resume)}</section>`,
};
