// One card for each algorithm, over the world; and the table of numbers.

import { byId, make, setText } from "./dom.js";
import { LANES, laneIcon } from "./lanes.js";

export class Cards {
  constructor(store) {
    this.store = store;
    this.cards = [];
  }

  draw() {
    const { state } = this.store;
    // Robots of a team have rows of their own, with what can be done to them.
    const contenders = state?.team ? [] : state?.contenders ?? [];
    const key = contenders.map((contender) => contender.name).join();
    if (key !== this.key) this.rebuild(contenders, key);
    contenders.forEach((contender, i) => this.update(this.cards[i], contender));
  }

  rebuild(contenders, key) {
    this.key = key;
    this.cards = contenders.map((contender, i) => {
      const status = make("span");
      const bar = make("i");
      const error = make("span", { className: "number", title: "Error of place and heading" });
      const ms = make("span", { className: "number", title: "Time for a frame" });
      const box = make("article", { className: "card", vars: { "--card": `var(--${LANES[i]})` } },
        make("h2", {}, laneIcon(i), make("b", { textContent: contender.name }), status),
        make("div", { className: "meter" }, bar), make("p", {}, error, ms));
      return { box, status, bar, error, ms };
    });
    byId("cards").replaceChildren(...this.cards.map((card) => card.box));
  }

  update(card, contender) {
    const isMirrored = !contender.is_localized && contender.reliability_up_to_symmetry > 0.6;
    const status = contender.is_localized ? "localized" : isMirrored ? "two sides" : "searching";
    setText(card.status, status);
    card.box.dataset.localized = contender.is_localized;
    card.bar.style.transform = `scaleX(${contender.reliability.toFixed(3)})`;
    const { error } = contender;
    setText(card.error, error ? `${error[0].toFixed(2)} m, ${error[1].toFixed(1)}°` : "–");
    setText(card.ms, `${(contender.ms.image + contender.ms.pose).toFixed(2)} ms`);
  }
}

const ROWS = [
  ["Error", (c) => (c.error ? `${c.error[0].toFixed(3)} m` : "–")],
  ["Heading error", (c) => (c.error ? `${c.error[1].toFixed(2)}°` : "–")],
  ["Reliability", (c) => c.reliability.toFixed(3)],
  ["Up to symmetry", (c) => c.reliability_up_to_symmetry.toFixed(3)],
  ["Likelihood", (c) => c.likelihood.toFixed(3)],
  ["Deviation x, y", (c) => `${c.sigma[0].toFixed(3)}, ${c.sigma[1].toFixed(3)} m`],
  ["Deviation heading", (c) => `${(c.sigma[2] * 180 / Math.PI).toFixed(2)}°`],
  ["Hypotheses", (c) => String(c.hypotheses.length)],
  ["Individuals", (c) => String(c.num_individuals)],
  ["Image quality", (c) => c.quality.toFixed(3)],
  ["Pixels kept, dropped", (c) => `${c.num_kept}, ${c.num_dropped}`],
  ["Time for the image", (c) => `${c.ms.image.toFixed(2)} ms`],
  ["Time for the pose", (c) => `${c.ms.pose.toFixed(2)} ms`],
];

/** All numbers of the latest frame. */
export class Facts {
  constructor(store) {
    this.store = store;
    this.panel = byId("panel-facts");
  }

  draw() {
    const { state } = this.store;
    if (this.panel.hidden || !state) return;
    const table = state.contenders ? this.ofContenders(state) : (state.facts ?? []);
    const key = table.map((row) => row[0]).join() + table[0]?.length;
    if (key !== this.key) {
      this.key = key;
      this.cells = table.map((row) => row.slice(1).map(() => make("td")));
      const body = table.map((row, i) => make("tr", {}, make("th", { scope: "row" }, row[0]), ...this.cells[i]));
      this.panel.replaceChildren(make("table", { className: "facts" }, make("tbody", {}, ...body)));
    }
    table.forEach((row, i) => row.slice(1).forEach((text, k) => setText(this.cells[i][k], text)));
  }

  ofContenders(state) {
    // Of a team those of the robot that is looked at.
    const contenders = state.team ? [state.contenders[state.team.look]] : state.contenders;
    const rows = [[state.team ? "Robot" : "Algorithm", ...contenders.map((contender) => contender.name)]];
    for (const [label, read] of ROWS) rows.push([label, ...contenders.map(read)]);
    rows.push(["Frame", String(state.number), ...contenders.slice(1).map(() => "")]);
    if (state.render_ms != null) {
      rows.push([state.team ? "Time to draw all images" : "Time to draw the image", `${state.render_ms.toFixed(2)} ms`, ...contenders.slice(1).map(() => "")]);
    }
    return rows;
  }
}
