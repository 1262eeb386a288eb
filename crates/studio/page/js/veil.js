// What the page says while there is nothing to show.

import { byId, make } from "./dom.js";

export function showStatus(state, text, socket) {
  const link = byId("link");
  link.dataset.state = state === "refused" ? "closed" : state;
  link.textContent = state === "refused" ? "refused" : text;
  const veil = byId("veil");
  veil.hidden = state === "open";
  if (state === "open") return;
  const say = (...lines) => lines.map((line) => make("p", { textContent: line }));
  if (state === "refused") {
    const input = make("input", { type: "text", autocomplete: "off", "aria-label": "Token", placeholder: "token" });
    const form = make("form", {}, input, make("button", { className: "primary", textContent: "Open" }));
    form.onsubmit = (event) => {
      event.preventDefault();
      socket.useToken(input.value);
    };
    veil.replaceChildren(...say("This studio asks for a token.", "It stands in the address that visloc has printed."), form);
  } else if (state === "closed") {
    veil.replaceChildren(...say("The program does not answer.", "This page reconnects by itself as soon as it is there again."));
  } else {
    veil.replaceChildren(...say("Connecting."));
  }
}
