// Draws buildings: walls corner by corner, doors on them. What is drawn is checked by the program as `visloc map check` does, saved as a map
// file, and opened in the playground.

import { byId, make, setPressed, setText } from "./dom.js";
import { save } from "./export.js";
import { setIcon } from "./icons.js";
import { Plan } from "./plan.js";
import { PlanPointer } from "./plan_pointer.js";
import { PlanView } from "./plan_view.js";
import { onTheme } from "./theme.js";

/** After a change the plan is checked, milliseconds. */
const CHECK_MS = 200;
const DRAFT = "visloc-studio-building";
const STEP_M = 0.1;
const FAR_M = 1;
const ARROWS = { ArrowUp: [0, 1], ArrowDown: [0, -1], ArrowRight: [1, 0], ArrowLeft: [-1, 0] };
const HINTS = {
  wall: "Walls: a click for each corner. A click on the first corner closes them; a click on the last one, or Esc, ends them.",
  door: "Doors: a click on a wall puts one there.",
  erase: "Erase: a click takes a door or a wall away, a wall with its doors.",
};
const KEYS = {
  KeyW: "tool-wall", KeyD: "tool-door", KeyE: "tool-erase", KeyU: "undo", KeyY: "redo", KeyO: "load-plan", KeyS: "save-plan",
  KeyP: "try-plan", Home: "fit-plan",
};

function draft() {
  try {
    return JSON.parse(localStorage.getItem(DRAFT));
  } catch {
    return null;
  }
}

export class Editor {
  constructor(token) {
    this.token = token;
    this.dialog = byId("editor");
    this.view = new PlanView(byId("plan"));
    this.view.redraw = () => this.draw();
    this.plan = new Plan(draft() ?? undefined);
    this.tool = "wall";
    this.cursor = null;
    this.answer = null;
    this.pointer = new PlanPointer(byId("plan"), this.view, {
      point: (at, reach) => this.point(at, reach),
      press: (at, reach) => this.act(at, reach),
      moved: () => this.draw(),
      left: () => this.point(null),
    });
    this.wire();
    onTheme(() => this.draw());
    this.learnFiles();
  }

  wire() {
    setIcon(byId("draw"), "draw");
    byId("draw").onclick = () => this.open();
    for (const tool of Object.keys(HINTS)) byId(`tool-${tool}`).onclick = () => this.use(tool);
    byId("undo").onclick = () => this.step(true);
    byId("redo").onclick = () => this.step(false);
    byId("fit-plan").onclick = () => this.fit();
    byId("zoom-plan-in").onclick = () => this.zoom(1.3);
    byId("zoom-plan-out").onclick = () => this.zoom(1 / 1.3);
    byId("new-plan").onclick = () => this.replace({});
    byId("load-plan").onclick = () => byId("plan-file").click();
    byId("plan-file").onchange = () => this.load();
    byId("save-plan").onclick = () => this.save();
    byId("try-plan").onclick = () => this.tryIt();
    byId("close-editor").onclick = () => this.dialog.close();
    byId("plan-name").onchange = () => this.plan.change(() => { this.plan.data.name = byId("plan-name").value.trim() || "my building"; }) ?? this.changed();
    this.dialog.addEventListener("keydown", (event) => this.key(event));
    // Esc ends the walls that are being drawn first.
    this.dialog.addEventListener("cancel", (event) => {
      if (this.plan.chain.length === 0) return;
      event.preventDefault();
      this.plan.end();
      this.draw();
    });
    this.use("wall");
  }

  /** Only a studio that nobody else can reach opens what a page hands over. */
  async learnFiles() {
    const answer = await fetch("/files").then((response) => response.text()).catch(() => "no");
    byId("try-plan").hidden = answer !== "yes";
  }

  get isOpen() {
    return this.dialog.open;
  }

  open() {
    this.dialog.showModal();
    byId("plan").focus();
    this.fit();
    this.changed();
  }

  use(tool) {
    this.tool = tool;
    this.plan.end();
    for (const other of Object.keys(HINTS)) setPressed(byId(`tool-${other}`), other === tool);
    setText(byId("plan-hint"), HINTS[tool]);
    this.point(this.at ?? null, this.reach);
  }

  get reach() {
    return this.view.reach(14);
  }

  get doorWidth() {
    return Math.min(Math.max(Number(byId("door-width").value) || 0.9, 0.3), 5);
  }

  /** Somebody points at a place, or at none. */
  point(at, reach = this.reach) {
    this.at = at;
    this.cursor = at && this.plan.snap(at, reach);
    this.door = at && this.tool === "door" ? this.plan.doorAt(at, this.doorWidth, 2 * reach) : null;
    this.part = at && this.tool === "erase" ? this.plan.partAt(at, 2 * reach) : null;
    this.draw();
  }

  /** A click, a tap, or Enter. */
  act(at, reach = this.reach) {
    this.point(at, reach);
    if (this.tool === "wall") this.plan.corner(this.cursor.at);
    else if (this.tool === "door" && this.door) this.plan.addDoor(this.door, byId("door-color").value);
    else if (this.tool === "erase" && this.part) this.plan.remove(this.part);
    else this.say(this.tool === "door" ? "No wall here with room for this door." : "Nothing to erase here.");
    this.changed();
    this.point(at, reach);
  }

  step(isBack) {
    if (this.plan.step(isBack)) this.changed();
  }

  zoom(factor) {
    this.view.zoom(factor);
    this.draw();
  }

  fit() {
    this.view.fit(this.plan);
    this.draw();
  }

  replace(data) {
    this.plan.replace(data);
    this.fit();
    this.changed();
  }

  key(event) {
    if (event.target.matches("input, select") || event.altKey) return;
    const isOrder = event.ctrlKey || event.metaKey;
    const id = isOrder ? { KeyZ: event.shiftKey ? "redo" : "undo", KeyY: "redo", KeyS: "save-plan", KeyO: "load-plan" }[event.code] : KEYS[event.code];
    const isOnPlan = document.activeElement === byId("plan");
    if (id) byId(id).click();
    else if (isOrder) return;
    else if (ARROWS[event.code] && isOnPlan) this.moveCursor(ARROWS[event.code], event.shiftKey ? FAR_M : STEP_M);
    else if (["Enter", "Space"].includes(event.code) && isOnPlan && this.at) this.act(this.at, STEP_M / 2);
    else if (["Delete", "Backspace"].includes(event.code) && this.at) this.erase();
    else if (["+", "="].includes(event.key)) this.zoom(1.3);
    else if (event.key === "-") this.zoom(1 / 1.3);
    else return;
    event.preventDefault();
    event.stopPropagation();
  }

  /** A cross that keys move, for those without a mouse. */
  moveCursor(way, meters) {
    const from = this.at ?? this.view.center;
    this.point(from.map((v, i) => Math.round((v + way[i] * meters) / STEP_M) * STEP_M), STEP_M / 2);
    const [x, y] = this.view.toPx(this.at);
    const [width, height] = this.view.size;
    if (x < 0 || y < 0 || x > width || y > height) this.view.center = this.at;
    const what = { corner: ", a corner", wall: ", on a wall", grid: "" }[this.cursor.on];
    this.say(`x ${this.at[0].toFixed(1)} m, y ${this.at[1].toFixed(1)} m${what}`);
  }

  erase() {
    const part = this.plan.partAt(this.at, 2 * this.reach);
    if (part) this.plan.remove(part);
    this.changed();
  }

  say(text) {
    setText(byId("plan-state"), text);
  }

  /** The plan is another one: it is drawn, kept and checked. */
  changed() {
    const { data, back, forth, chain } = this.plan;
    if (document.activeElement !== byId("plan-name")) byId("plan-name").value = data.name;
    byId("undo").disabled = back.length === 0 && chain.length === 0;
    byId("redo").disabled = forth.length === 0;
    try {
      localStorage.setItem(DRAFT, JSON.stringify(data));
    } catch {
      // Then only until the page is closed.
    }
    this.draw();
    clearTimeout(this.checkTimer);
    this.checkTimer = setTimeout(() => this.check(), CHECK_MS);
  }

  /** What the program says of a plan, or of the text of a map file: its plan, its text, and what is wrong. */
  async ask(body) {
    const token = encodeURIComponent(this.token);
    const answer = await fetch(`/building?token=${token}`, { method: "POST", body: JSON.stringify(body) });
    if (!answer.ok) throw new Error(await answer.text());
    return answer.json();
  }

  /** Of several checks that are on their way only the last one counts. */
  async check() {
    const turn = this.newTurn();
    const { plan } = this;
    let answer = { error: null, hindrances: [], is_empty: true };
    try {
      if (!plan.isEmpty) answer = await this.ask({ plan: plan.data });
    } catch (error) {
      answer = { error: `cannot be checked: ${error.message}`, hindrances: [] };
    }
    if (turn === this.turn) this.show(answer);
  }

  /** What is asked from here on makes earlier answers out of date. */
  newTurn() {
    clearTimeout(this.checkTimer);
    this.turn = (this.turn ?? 0) + 1;
    return this.turn;
  }

  /** Says what came of a check. */
  show(answer) {
    this.answer = answer;
    const { error, hindrances, floor_m2: floor, num_doors: doors } = answer;
    const lines = error ? [error] : hindrances.map(({ text }) => text);
    const fine = answer.is_empty ? "Nothing is drawn yet." : `Fine: ${floor?.toFixed(1)} m² of floor, ${doors} door${doors === 1 ? "" : "s"}.`;
    byId("plan-findings").replaceChildren(...lines.map((text) => make("li", { textContent: text })));
    byId("plan-findings").hidden = lines.length === 0;
    this.say(lines.length === 0 ? fine : `${lines.length === 1 ? "One thing" : `${lines.length} things`} to look at:`);
    byId("save-plan").disabled = byId("try-plan").disabled = Boolean(error) || Boolean(answer.is_empty);
    this.draw();
  }

  /** The text of the map file as the plan is now; says what is wrong if there is none. */
  async text() {
    await this.check();
    return this.answer.error ? null : this.answer.toml;
  }

  get fileName() {
    return `${this.plan.data.name.replace(/[^\w-]+/g, "-").slice(0, 50) || "building"}.toml`;
  }

  async save() {
    const text = await this.text();
    if (text) save(this.fileName, new Blob([text], { type: "application/toml" }));
  }

  async tryIt() {
    const text = await this.text();
    if (!text) return;
    const answer = await fetch(`/files?as=place&name=${this.fileName}`, { method: "POST", body: text });
    if (answer.ok) this.dialog.close();
    else this.say(await answer.text());
  }

  async load() {
    const [file] = byId("plan-file").files;
    byId("plan-file").value = "";
    if (!file) return;
    this.newTurn();
    try {
      const { plan, error } = await this.ask({ name: file.name, text: await file.text() });
      if (plan) this.replace(plan);
      else this.say(error);
    } catch (error) {
      this.say(`${file.name}: ${error.message}`);
    }
  }

  draw() {
    if (!this.isOpen) return;
    const { cursor, door, part, answer } = this;
    const faults = new Set((answer?.error ?? "").match(/\b(?:walls|doors|corridors)\[\d+\]/g) ?? []);
    const looseEnds = answer?.error ? [] : (answer?.hindrances ?? []).flatMap(({ detail }) => detail.loose_ends_m ?? []);
    this.view.draw(this.plan, { cursor: this.tool === "wall" ? cursor : null, door, part, faults, looseEnds });
  }
}
