// The robots of a team: what each knows, and what can be done to it.

import { byId, make, setPressed, setText } from "./dom.js";
import { LANES, laneIcon } from "./lanes.js";

const LIES = [["wrong_half", "wrong half"], ["elsewhere", "elsewhere"], ["inventing", "invented sightings"]];
const LIE_WORDS = { wrong_half: "lies: wrong half", elsewhere: "lies: elsewhere", inventing: "lies: invented sightings" };
const NUMBERS = [2, 3, 4, 5];

const percent = (share) => `${Math.round(100 * share)}\u00a0%`;

export class TeamPanel {
  constructor(store, socket) {
    Object.assign(this, { store, socket, rows: [] });
    const choice = (label, entries, title) => {
      const select = make("select", { title });
      select.append(...entries.map(([value, textContent]) => make("option", { value, textContent })));
      return [select, make("label", {}, make("span", { textContent: label }), select)];
    };
    const [count, countBox] = choice("Robots", NUMBERS.map((number) => [number, String(number)]), "How many play; the game begins anew");
    const [lie, lieBox] = choice("Liars", LIES, "How a robot lies that is made a liar");
    this.count = count;
    this.lie = lie;
    count.onchange = () => socket.send("robots", { count: Number(count.value) });
    lie.onchange = () => this.robots().filter((robot) => robot.lie).forEach(({ number }) => socket.send("lie", { robot: number, how: lie.value }));
    this.list = make("ol", { className: "team-rows", "aria-label": "Robots" });
    byId("panel-team").replaceChildren(make("div", { className: "team-head" }, countBox, lieBox), this.list, make("p", { className: "small" },
      "Both goals are white: the same place in both halves looks alike. Robot 1 was told its half at the start; the others learn theirs by seeing each other and the ball."));
    store.on("scene", () => this.fit());
    store.on("state", () => this.follow());
  }

  robots() {
    return this.store.state?.team?.robots ?? [];
  }

  fit() {
    const { team, mode } = this.store.scene;
    if (!team) return;
    this.isLive = mode === "team";
    this.count.value = String(team.num_robots);
    this.count.disabled = this.lie.disabled = !this.isLive;
    this.rows = [];
  }

  follow() {
    const robots = this.robots();
    if (robots.length !== this.rows.length) {
      this.rows = robots.map(({ number }, lane) => this.row(number, lane));
      this.list.replaceChildren(...this.rows.map(({ box }) => box));
    }
    robots.forEach((robot, k) => this.update(this.rows[k], robot, this.store.state.contenders[k]));
    this.rows.forEach(({ look }, k) => setPressed(look, this.store.state.team.look === k));
  }

  row(number, lane) {
    const button = (textContent, label, title, onclick) => make("button", { type: "button", textContent, title, onclick, disabled: !this.isLive, "aria-label": label });
    const of = () => this.robots().find((robot) => robot.number === number);
    const look = button("", `Robot ${number}: show its image`, "Show what its camera sees", () => this.socket.send("look", { robot: number }));
    look.append(laneIcon(lane), make("b", { textContent: String(number) }));
    look.className = "look";
    const cut = button("Cut link", `Cut link of robot ${number}`, "Nobody hears it, and it hears nobody", () => this.socket.send("link", { robot: number, is_on: !of().is_linked }));
    const liar = button("Liar", `Liar: robot ${number}`, "What it tells the others is a lie", () => this.socket.send("lie", { robot: number, how: of().lie ? null : this.lie.value }));
    const kidnap = button("Kidnap", `Kidnap robot ${number}`, "Carry it to another place", () => this.socket.send("kidnap", { robot: number }));
    const [knows, trouble, numbers, trust] = [make("b"), make("em"), make("span", { className: "number" }), make("span", { className: "number" })];
    const box = make("li", { className: "team-row", vars: { "--card": `var(--${LANES[lane]})` } }, look,
      make("div", { className: "told" }, knows, trouble, numbers, trust), make("div", { className: "does" }, cut, liar, kidnap));
    return { box, look, cut, liar, knows, trouble, numbers, trust };
  }

  update(row, robot, contender) {
    const words = {
      half: robot.by ? `knows its half from robot ${robot.by}` : "knows its half",
      mirror: "knows its place up to mirror",
      placed: `lost; robot ${robot.by} sees it`,
      lost: "lost",
    };
    const held = robot.height_m > 0 ? "carried" : words[robot.knows];
    setText(row.knows, held);
    setText(row.trouble, [robot.is_linked ? null : "link cut", LIE_WORDS[robot.lie]].filter(Boolean).join("; "));
    setText(row.numbers, [errorOf(robot, contender), `${(robot.bytes_per_sec / 1000).toFixed(2)} kB/s`].filter(Boolean).join(", "));
    const trust = robot.mates.map((mate) => `${mate.number}:\u00a0${percent(mate.trust)}`);
    setText(row.trust, trust.length ? `trusts ${trust.join(", ")}` : "hears nobody");
    row.box.dataset.knows = robot.knows;
    setPressed(row.cut, !robot.is_linked);
    setPressed(row.liar, robot.lie);
  }
}

/** How far off it is: up to the mirror, if that is what it knows; nothing while it is carried or lost. */
function errorOf({ truth, knows }, { error, hypotheses }) {
  if (!error || !truth || knows === "lost") return null;
  if (knows !== "mirror") return `${error[0].toFixed(2)} m off`;
  const nearest = Math.min(error[0], ...hypotheses.map(([x, y]) => Math.hypot(x - truth[0], y - truth[1])));
  return `${nearest.toFixed(2)} m off`;
}
