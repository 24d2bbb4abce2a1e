// Elements: found, written, made. What did not change is left alone, so that nothing is laid out anew.
"use strict";

const $ = selector => document.querySelector(selector);
const write = (element, text) => { if (element.textContent !== text) element.textContent = text; };
const show = (element, shown) => { if (element.hidden === shown) element.hidden = !shown; };

// An element with properties and children; text is always text, never markup.
function make(name, properties, ...children) {
  const e = Object.assign(document.createElement(name), properties);
  e.append(...children.filter(c => c !== null && c !== undefined));
  return e;
}

function icon(name) {
  const svg = document.createElementNS("http://www.w3.org/2000/svg", "svg");
  const use = document.createElementNS("http://www.w3.org/2000/svg", "use");
  svg.setAttribute("class", "icon");
  svg.setAttribute("aria-hidden", "true");
  use.setAttribute("href", `#${name}`);
  svg.append(use);
  return svg;
}

// Calls `move(right, down)` in pixels while an element is dragged, and `end()` after; it is not dragged where
// `begin()` is false.
function dragged(element, move, begin = () => true, end = () => {}) {
  let last = null;
  element.addEventListener("pointerdown", e => {
    if (!begin()) return;
    last = [e.clientX, e.clientY];
    element.setPointerCapture(e.pointerId);
    e.preventDefault();
  });
  element.addEventListener("pointermove", e => {
    if (!last) return;
    move(e.clientX - last[0], e.clientY - last[1]);
    last = [e.clientX, e.clientY];
  });
  for (const kind of ["pointerup", "pointercancel"]) element.addEventListener(kind, () => {
    if (last) end();
    last = null;
  });
}

const setIcon = (element, name) => element.querySelector("use").setAttribute("href", `#${name}`);
