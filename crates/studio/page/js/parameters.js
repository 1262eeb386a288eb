// Algorithms, and every parameter with unit, default and meaning.

import { byId, make, setPressed } from "./dom.js";
import { save } from "./export.js";
import { LANES, laneIcon } from "./lanes.js";
import { RunControls } from "./run_controls.js";

const MAX_LANES = 4;

/** What parameters belong to, besides one algorithm. */
const SHARED = "Image, map, tracks";

export class AlgorithmsPanel {
  constructor(store, socket) {
    Object.assign(this, { store, socket });
    this.part = 0;
    /** What was sent last and what of it was refused: `{part, path, value, reason}`. */
    this.sent = null;
    this.refused = null;
    this.lanes = make("div", { className: "lanes" });
    this.filter = make("input", { type: "search", placeholder: "Find a parameter of any algorithm", "aria-label": "Find a parameter of any algorithm" });
    this.filter.oninput = () => this.list();
    this.parts = make("select", { "aria-label": "Whose parameters" });
    this.parts.onchange = () => {
      this.part = this.parts.value === "all" ? null : Number(this.parts.value);
      this.list();
    };
    const button = (id, textContent, title, onclick) => make("button", { type: "button", id, textContent, title, onclick });
    this.reset = button("defaults", "Defaults", "All parameters of this part as they were",
      () => socket.send("defaults", this.part === null ? {} : { algorithm: this.part }));
    this.different = button("changed-only", "Changed", "Everything that differs from its default", () => {
      setPressed(this.different, this.different.ariaPressed !== "true");
      this.list();
    });
    setPressed(this.different, false);
    this.save = button("save-toml", "Save as TOML", "What differs from the defaults, as files for --config and --pipeline", () => this.saveToml());
    this.body = make("div", { id: "parameters" });
    this.runControls = new RunControls(store, socket);
    byId("panel-algorithms").replaceChildren(this.runControls.box, this.lanes,
      make("div", { className: "search" }, this.parts, this.reset, this.filter, this.different, this.save), this.body);
    store.on("scene", () => this.rebuild());
    store.on("latest", () => this.follow());
  }

  /** What was refused stays as it was typed, with the reason. */
  follow() {
    const { notice } = this.store.latest;
    if (!this.sent || !notice) return;
    this.refused = { ...this.sent, reason: notice };
    this.sent = null;
    this.list();
  }

  rebuild() {
    const { scene } = this.store;
    // What was sent has been taken.
    this.sent = this.refused = null;
    if (scene.scene !== this.scene) {
      this.scene = scene.scene;
      this.filter.value = "";
      setPressed(this.different, false);
    }
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
    this.parts.replaceChildren(...[...names, ["all", SHARED]]
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
    const remove = make("button", { type: "button", textContent: "Remove", "aria-label": `Remove ${contender.name}`, disabled: this.names().length === 1 });
    remove.onclick = () => this.choose(this.names().toSpliced(i, 1));
    return make("div", { className: "lane", vars: { "--card": `var(--${LANES[i]})` } }, laneIcon(i), select, remove);
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

  /** All parts with their title and number; `null` is what all algorithms share. */
  everyPart() {
    const { scene } = this.store;
    const own = (scene.contenders ?? []).map((part, i) => ({ part, index: i, title: part.name }));
    return [...own, { part: scene.pipeline, index: null, title: scene.presets ? "SLAM" : SHARED }].filter(({ part }) => part);
  }

  /** The chosen part, or with words or on demand what of all parts has these words or differs. */
  list() {
    const words = this.filter.value.toLowerCase().split(/\s+/).filter(Boolean);
    const isDifferent = this.different.ariaPressed === "true";
    const isWide = words.length > 0 || isDifferent;
    const isWanted = (part, p) => words.every((word) => `${p.path.replaceAll("_", " ")} ${p.path} ${p.meaning}`.toLowerCase().includes(word))
      && (!isDifferent || part.changed.includes(p.path));
    const focus = document.activeElement?.dataset;
    const children = [];
    for (const { part, index, title } of this.everyPart()) {
      if (!isWide && index !== this.part) continue;
      const entries = this.entries(part, index, part.parameters.filter((p) => isWanted(part, p)));
      if (isWide && entries.length) children.push(make("h3", { className: "part-title", textContent: title }));
      children.push(...entries);
    }
    const none = isDifferent && !words.length ? "Everything is at its default." : "No parameter has these words.";
    if (!children.length) children.push(make("p", { className: "small", textContent: none }));
    this.body.replaceChildren(...children);
    if (!focus?.path) return;
    const again = [...this.body.querySelectorAll("[data-path]")].find(({ dataset }) => dataset.path === focus.path && dataset.part === focus.part);
    again?.focus({ preventScroll: true });
  }

  /** Entries with the titles of their tables. */
  entries(part, index, parameters) {
    const children = [];
    let table = "";
    for (const parameter of parameters) {
      const group = parameter.path.includes(".") ? parameter.path.slice(0, parameter.path.lastIndexOf(".")) : "";
      if (group !== table) children.push(make("h4", { className: "group-title", textContent: group }));
      table = group;
      children.push(this.entry(parameter, index, part.changed.includes(parameter.path)));
    }
    return children;
  }

  entry(parameter, index, isChanged) {
    const { path, value, unit, meaning } = parameter;
    const name = path.slice(path.lastIndexOf(".") + 1);
    const refused = this.refused?.path === path && this.refused.part === index ? this.refused : null;
    const input = field(refused ? { ...parameter, value: refused.value } : parameter);
    Object.assign(input.dataset, { path, part: String(index) });
    input.onchange = () => this.send(index, path, read(input, parameter));
    const range = parameter.range ? ` ${parameter.range[0]} to ${parameter.range[1]}.` : "";
    const choice = parameter.choices.find((option) => option.name === value)?.meaning;
    const text = make("p", {}, [meaning, choice, range].filter(Boolean).join(" "), ` Default: ${shown(parameter.default)} `);
    if (isChanged) {
      const undo = make("button", { type: "button", textContent: "default", "aria-label": `${name.replaceAll("_", " ")}: default` });
      undo.onclick = () => this.send(index, path, parameter.default);
      text.append(undo);
    }
    const lines = [text];
    if (refused) {
      const reason = make("p", { className: "refusal", id: "refusal", textContent: `Refused: ${refused.reason}. It is still ${shown(value)}.` });
      input.setAttribute("aria-invalid", "true");
      input.setAttribute("aria-describedby", "refusal");
      lines.unshift(reason);
    }
    return make("div", { className: `parameter${isChanged ? " is-changed" : ""}${refused ? " is-refused" : ""}` },
      make("label", {}, make("span", { textContent: name.replaceAll("_", " "), title: path }), input,
        make("span", { className: "unit", textContent: unit ?? "" })), ...lines);
  }

  send(part, path, value) {
    if (value === undefined || value === null) return;
    this.refused = null;
    this.sent = { part, path, value };
    this.socket.send("parameter", { ...(part === null ? {} : { algorithm: part }), path, value });
  }

  /** A file for each part that differs; nothing differs in an empty one. */
  saveToml() {
    const { run, slam_run: slam, preset } = this.store.scene;
    const parts = slam ? [[preset, slam.parameters, `# visloc slam --preset ${preset} --config ${preset}.toml`]]
      : [...(run?.algorithms ?? []).map(([name, text]) => [name, text, `# visloc localize --algorithm ${name} --config ${name}.toml`]),
        ["pipeline", run?.pipeline ?? "", "# visloc localize --pipeline pipeline.toml"]];
    const differing = parts.filter(([, text]) => text.trim());
    for (const [name, text, use] of differing.length ? differing : parts.slice(0, 1)) {
      save(`${name}.toml`, new Blob([`${use}\n${text}`], { type: "application/toml" }));
    }
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
