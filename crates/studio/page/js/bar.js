// The bar at the top, the buttons over the world, and the keys.

import { byId, make, setPressed, setText } from "./dom.js";
import { setIcon } from "./icons.js";
import { toggleTheme } from "./theme.js";

/** The hint stays so long, milliseconds. */
const HINT_MS = 25000;

/** What is drawn of a team. */
const TEAM_KEY = [["--text", "where a robot is", "figure"], ["--text", "where it believes to be", "ring"], ["--text", "what it sees", "line"],
  ["--text", "who hears whom", "dots"]];

export class Bar {
  constructor(store, socket, view, drive, aim, time) {
    Object.assign(this, { store, socket, view, drive, aim, time });
    setIcon(byId("step"), "step");
    setIcon(byId("theme"), "theme");
    setIcon(byId("more"), "more");
    setIcon(byId("open-file"), "open");
    byId("more").onclick = () => this.more();
    byId("play").onclick = () => this.toggle("is_playing", "pause", "play");
    byId("step").onclick = () => socket.send("step");
    byId("speed").onchange = (event) => socket.send("speed", { factor: Number(event.target.value) });
    byId("scene").onchange = (event) => socket.send("open", { scene: event.target.value });
    byId("reset").onclick = () => this.reset();
    byId("seed").onchange = () => this.reset();
    byId("record").onclick = () => socket.send("record", { is_on: !this.store.latest?.recorder?.is_on });
    byId("theme").onclick = toggleTheme;
    byId("help").onclick = () => byId("help-dialog").showModal();
    byId("kidnap").onclick = () => socket.send("kidnap");
    byId("lift").onclick = () => socket.send(this.store.latest?.controls?.is_held ? "put_down" : "lift");
    byId("cover").onclick = () => this.flip("cover", "is_covered");
    byId("likelihood").onclick = () => this.flip("likelihood", "has_likelihood");
    byId("autopilot").onclick = () => this.flip("autopilot", "is_autopilot");
    for (const button of document.querySelectorAll("[data-view]")) {
      button.onclick = () => this.setView(button.dataset.view);
    }
    store.on("scene", () => this.scenes());
    store.on("latest", () => this.follow());
    store.on("state", () => setText(byId("time"), `${store.state.secs.toFixed(1)} s`));
    const hide = () => { byId("hint").dataset.done = ""; };
    byId("world").addEventListener("pointerdown", hide, { once: true });
    setTimeout(hide, HINT_MS);
    addEventListener("keydown", (event) => this.onKey(event, true));
    addEventListener("keyup", (event) => this.onKey(event, false));
  }

  toggle(name, whenSet, otherwise) {
    this.socket.send(this.store.latest?.[name] ? whenSet : otherwise);
  }

  flip(command, name) {
    this.socket.send(command, { is_on: !this.store.latest?.controls?.[name] });
  }

  /** On small screens a part of the bar is shown on demand. */
  more() {
    const isOpen = byId("bar").toggleAttribute("data-more");
    byId("more").setAttribute("aria-expanded", String(isOpen));
  }

  reset() {
    const seed = Math.floor(Number(byId("seed").value));
    if (seed >= 0) this.socket.send("reset", { seed });
  }

  setView(view) {
    this.view.setView(view);
    for (const button of document.querySelectorAll("[data-view]")) setPressed(button, button.dataset.view === view);
  }

  scenes() {
    const { scene } = this.store;
    document.body.dataset.mode = scene.mode;
    document.body.dataset.world = scene.world?.kind ?? "";
    document.body.toggleAttribute("data-hands", this.hasHands());
    this.mapKey(scene.team ? TEAM_KEY : scene.world?.kind === "space" ? this.spaceKey() : null);
    const key = JSON.stringify(scene.scenes);
    const select = byId("scene");
    if (key !== this.listed) {
      this.listed = key;
      const groups = new Map();
      for (const entry of scene.scenes) {
        if (!groups.has(entry.group)) groups.set(entry.group, make("optgroup", { label: entry.group }));
        groups.get(entry.group).append(make("option", { value: entry.id, textContent: entry.label }));
      }
      select.replaceChildren(...groups.values());
    }
    select.value = scene.scene;
    if (document.activeElement !== byId("seed")) byId("seed").value = scene.seed ?? 1;
  }

  /** Whether people can take what is shown into their hands. */
  hasHands() {
    const { scene } = this.store;
    return scene?.mode === "playground" || Boolean(scene?.has_hands);
  }

  /** What is drawn in the world: its color, words, and its shape if the color does not tell. */
  mapKey(entries) {
    const key = byId("map-key");
    key.hidden = !entries;
    key.replaceChildren(...(entries ?? []).map(([color, label, shape = ""]) => (
      make("li", {}, make("i", { vars: { "--mark": `var(${color})` }, data: { shape } }), label))));
  }

  /** Those of a map of landmarks. */
  spaceKey() {
    const recorded = this.store.scene.recording?.is_recomputed ? [["--c3", "its way as it was recorded"]] : [];
    return [["--c1", "camera and its way"], ...recorded, ["--accent", "its way in truth"], ["--text", "landmarks"],
      ["--c0", "candidates: depth still uncertain"], ["--c2", "keyframes and links"]];
  }

  follow() {
    const state = this.store.latest;
    const isPlaying = state.is_playing;
    setIcon(byId("play"), isPlaying ? "pause" : "play");
    byId("play").setAttribute("aria-label", isPlaying ? "Pause" : "Play");
    if (document.activeElement !== byId("speed")) byId("speed").value = String(state.speed ?? 1);
    this.notice(state.is_waiting ? "Waiting for the first image of the source." : state.notice);
    this.recorder(state.recorder);
    const controls = state.controls;
    if (!controls) return;
    setPressed(byId("lift"), controls.is_held);
    setText(byId("lift"), controls.is_held ? "Put down" : "Lift");
    setPressed(byId("cover"), controls.is_covered);
    setPressed(byId("likelihood"), controls.has_likelihood);
    setPressed(byId("autopilot"), controls.is_autopilot);
  }

  /** What is being recorded, or was recorded last. */
  recorder(recorder) {
    const isOn = Boolean(recorder?.is_on);
    setPressed(byId("record"), isOn);
    setText(byId("record-label"), isOn ? `Stop, ${recorder.num_frames}` : "Record");
    const box = byId("recorded-file");
    const isDone = recorder && !isOn && recorder.file !== this.dismissed && this.store.scene?.scene !== recorder.scene;
    box.hidden = !isDone;
    if (!isDone || box.dataset.file === recorder.file) return;
    box.dataset.file = recorder.file;
    const dismiss = () => {
      this.dismissed = recorder.file;
      box.hidden = true;
    };
    const open = make("button", { type: "button", className: "primary", textContent: "Replay", id: "open-recorded" });
    open.onclick = () => this.socket.send("open", { scene: recorder.scene });
    const close = make("button", { type: "button", textContent: "Close", onclick: dismiss });
    box.replaceChildren(make("span", { textContent: recorder.file }), open, close);
  }

  notice(text) {
    if (!text) return;
    const element = byId("notice");
    element.textContent = text;
    element.hidden = false;
    clearTimeout(this.noticeTimer);
    this.noticeTimer = setTimeout(() => { element.hidden = true; }, 6000);
  }

  onKey(event, isDown) {
    const { target } = event;
    const isTyping = target.matches?.("input:not([type=range]):not([type=checkbox]), select, textarea");
    if (isTyping || event.ctrlKey || event.metaKey || event.altKey || document.querySelector("dialog[open]")) return;
    const isPlayground = this.store.scene?.mode === "playground";
    if (target.matches?.("input[type=range], [role=tab], [role=tabpanel]") && /^(Arrow|Page|Home|End)/.test(event.code)) return;
    const isPress = target.matches?.("button, input") && ["Enter", "Space"].includes(event.code);
    if (isDown && !isPress && (this.aim.key(event, this.view.camera.azimuth) || this.view.key(event))) {
      event.preventDefault();
      return;
    }
    if (this.drive.isUsable && !event.shiftKey && this.drive.press(event.code, isDown)) {
      event.preventDefault();
      return;
    }
    if (!isDown || event.repeat) return;
    const view = { Digit1: "slant", Digit2: "top", Digit3: "follow" }[event.code];
    if (view) this.setView(view);
    if (event.code === "Comma") this.time.step(-1);
    const ids = { Space: "play", Period: "step", KeyT: "theme", KeyN: "to-now", KeyO: "open-file", KeyB: "draw", KeyJ: "by-hand" };
    const inHands = { KeyK: "kidnap", KeyC: "cover" };
    const onPlayground = { KeyL: "lift", KeyP: "autopilot", KeyM: "likelihood" };
    const isReplay = this.store.scene?.mode === "replay";
    const id = event.key === "?" ? "help" : ids[event.code] ?? (this.hasHands() ? inHands[event.code] : undefined)
      ?? (isPlayground ? onPlayground[event.code] : undefined)
      ?? (isReplay ? undefined : { KeyR: "reset", KeyV: "record" }[event.code]);
    if (!id || byId(id).hidden || (event.code === "Space" && isPress)) return;
    event.preventDefault();
    byId(id).click();
  }
}
