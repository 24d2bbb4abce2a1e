// The page as texts and elements.

const $ = selector => document.querySelector(selector);
// What did not change is left alone, so that nothing is laid out or said anew.
const write = (element, text) => { if (element.textContent !== text) element.textContent = text; };
const show = (selector, shown) => { $(selector).hidden = !shown; };
function render(element, markup) {
  const text = String(markup);
  if (element.rendered !== text) element.innerHTML = element.rendered = text;
}

class Markup extends String {}

// A value in markup: text is always text, whatever a board sends; lists are joined, what is not there is nothing.
function inMarkup(value) {
  if (value instanceof Markup) return value;
  if (Array.isArray(value)) return value.map(inMarkup).join("");
  return value === false || value == null ? "" : String(value).replace(/[&<>"']/g, c => `&#${c.charCodeAt(0)};`);
}
const html = (parts, ...values) => new Markup(String.raw({ raw: parts }, ...values.map(inMarkup)));

// A report in a frame that is as high as it is: the page scrolls, not the frame. `fill` loads it, once.
function showReport(frame, fill) {
  if (!frame || frame.onload) return;
  frame.onload = () => new ResizeObserver(([{ target }]) => { frame.style.height = `${target.scrollHeight + 4}px`; }).observe(frame.contentDocument.body);
  fill(frame);
}
