// Algorithms, and every parameter with unit, default and meaning.

import { LANES } from "./actors.js";
import { byId, make } from "./dom.js";
import { RunControls } from "./run_controls.js";

const MAX_LANES = 4;

export class AlgorithmsPanel {
  constructor(store, socket) {
    Object.assign(this, { store, socket });
    this.part = 0;
    this.lanes = make("div", { className: "lanes" });
    this.filter = make("input", { type: "search", placeholder: "Find a parameter", "aria-label": "Find a parameter" });
    this.filter.oninput = () => this.list();
    this.parts = make("select", { "aria-label": "Whose parameters" });
    this.parts.onchange = () => {
      this.part = this.parts.value === "all" ? null : Number(this.parts.value);
      this.list();
    };
    this.reset = make("button", { type: "button", textContent: "Defaults", title: "All parameters of this part as they were" });
    this.reset.onclick = () => socket.send("defaults", this.part === null ? {} : { algorithm: this.part });
    this.body = make("div", { id: "parameters" });
    this.runControls = new RunControls(store, socket);
    byId("panel-algorithms").replaceChildren(this.runControls.box, this.lanes,
      make("div", { className: "search" }, this.parts, this.reset, this.filter), this.body);
    store.on("scene", () => this.rebuild());
  }

  rebuild() {
    const { scene } = this.store;
    if (!scene.pipeline) return;
    this.parts.hidden = Boolean(scene.presets);
    if (scene.presets) {
      this.part = null;
      this.lanes.replaceChildren(this.preset(scene));
      this.list();
      return;
    }
    this.lanes.replaceChildren(...scene.contenders.map((contender, i) => this.lane(contender, i)), this.adder());
    const names = scene.contenders.map((contender, i) => [String(i), contender.name]);
    this.parts.replaceChildren(...[...names, ["all", "Image, map, tracks"]]
      .map(([value, textContent]) => make("option", { value, textContent })));
    if (this.part !== null && this.part >= names.length) this.part = 0;
    this.parts.value = this.part === null ? "all" : String(this.part);
    this.list();
  }

  /** Sets of parameters to start from. */
  preset({ presets, preset }) {
    const select = make("select", { "aria-label": "Preset", id: "preset" });
    select.append(...presets.map(({ name, summary }) => (
      make("option", { value: name, textContent: `${name}: ${summary}`, selected: name === preset }))));
    select.onchange = () => this.choose([select.value]);
    return make("label", { className: "lane" }, make("span", { textContent: "Preset" }), select);
  }

  names() {
    return this.store.scene.contenders.map((contender) => contender.name);
  }

  lane(contender, i) {
    const select = make("select", { "aria-label": `Algorithm ${i + 1}` });
    select.append(...this.store.scene.algorithms.map(({ name, summary }) => (
      make("option", { value: name, textContent: name, title: summary, selected: name === contender.name }))));
    select.title = this.store.scene.algorithms.find(({ name }) => name === contender.name)?.summary ?? "";
    select.onchange = () => this.choose(this.names().with(i, select.value));
    const remove = make("button", { type: "button", textContent: "Remove", disabled: this.names().length === 1 });
    remove.onclick = () => this.choose(this.names().toSpliced(i, 1));
    return make("div", { className: "lane", vars: { "--card": `var(--${LANES[i]})` } }, make("i"), select, remove);
  }

  adder() {
    const add = make("button", { type: "button", textContent: "Add an algorithm" });
    add.disabled = this.names().length >= MAX_LANES;
    const next = this.store.scene.algorithms.map(({ name }) => name).find((name) => !this.names().includes(name));
    add.onclick = () => this.choose([...this.names(), next]);
    const forget = make("button", { type: "button", textContent: "Forget the place", title: "All algorithms begin anywhere again" });
    forget.onclick = () => this.socket.send("forget");
    forget.hidden = this.store.scene.mode === "replay";
    return make("div", { className: "lane" }, add, forget);
  }

  choose(names) {
    this.socket.send("algorithms", { names });
  }

  list() {
    const { scene } = this.store;
    const part = this.part === null ? scene.pipeline : scene.contenders[this.part];
    if (!part) return;
    const words = this.filter.value.toLowerCase().split(/\s+/);
    const isWanted = (p) => words.every((word) => `${p.path} ${p.meaning}`.toLowerCase().includes(word));
    const shown = part.parameters.filter(isWanted);
    const focus = document.activeElement?.dataset?.path;
    let table = "";
    const children = [];
    for (const parameter of shown) {
      const group = parameter.path.includes(".") ? parameter.path.slice(0, parameter.path.lastIndexOf(".")) : "";
      if (group !== table) children.push(make("h4", { className: "group-title", textContent: group }));
      table = group;
      children.push(this.entry(parameter, part.changed.includes(parameter.path)));
    }
    if (!shown.length) children.push(make("p", { className: "small", textContent: "No parameter has these words." }));
    this.body.replaceChildren(...children);
    if (focus) this.body.querySelector(`[data-path="${CSS.escape(focus)}"]`)?.focus({ preventScroll: true });
  }

  entry(parameter, isChanged) {
    const { path, value, unit, meaning } = parameter;
    const name = path.slice(path.lastIndexOf(".") + 1);
    const input = field(parameter);
    input.dataset.path = path;
    input.onchange = () => this.send(path, read(input, parameter));
    const range = parameter.range ? ` ${parameter.range[0]} to ${parameter.range[1]}.` : "";
    const choice = parameter.choices.find((option) => option.name === value)?.meaning;
    const text = make("p", {}, [meaning, choice, range].filter(Boolean).join(" "), ` Default: ${shown(parameter.default)} `);
    if (isChanged) {
      const undo = make("button", { type: "button", textContent: "default" });
      undo.onclick = () => this.send(path, parameter.default);
      text.append(undo);
    }
    return make("div", { className: `parameter${isChanged ? " is-changed" : ""}` },
      make("label", {}, make("span", { textContent: name.replaceAll("_", " "), title: path }), input,
        make("span", { className: "unit", textContent: unit ?? "" })), text);
  }

  send(path, value) {
    if (value === undefined || value === null) return;
    this.socket.send("parameter", { ...(this.part === null ? {} : { algorithm: this.part }), path, value });
  }
}

function field({ value, choices, range }) {
  if (choices.length) {
    const select = make("select");
    select.append(...choices.map(({ name, meaning }) => (
      make("option", { value: name, textContent: name, title: meaning, selected: name === value }))));
    return select;
  }
  if (typeof value === "boolean") return make("input", { type: "checkbox", checked: value });
  if (typeof value === "number" || value === null) {
    const input = make("input", { type: "number", step: "any", value: value ?? "" });
    if (range) [input.min, input.max] = range;
    return input;
  }
  return make("input", { type: "text", value: Array.isArray(value) ? value.join(", ") : shown(value) });
}

/** What an input says, in the kind of its default; undefined if it is none. */
function read(input, { value }) {
  if (input.type === "checkbox") return input.checked;
  if (input.type === "number") return input.value === "" ? undefined : Number(input.value);
  if (!Array.isArray(value)) return input.value;
  try {
    return JSON.parse(`[${input.value}]`);
  } catch {
    return undefined;
  }
}

function shown(value) {
  if (value === null || value === undefined) return "none";
  return Array.isArray(value) ? value.join(", ") : typeof value === "object" ? JSON.stringify(value) : String(value);
}
