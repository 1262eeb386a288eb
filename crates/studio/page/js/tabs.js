// Tabs of the panel at the side.

import { byId, make, setText } from "./dom.js";

/** Id, label, and whether the tab has anything to say about a scene, of which a robot elsewhere may be driven. */
const TABS = [["team", "Team", (scene) => Boolean(scene.team)], ["teach", "Teach", (scene) => scene.mode === "slam" && Boolean(scene.does)],
  ["drive", "Drive", (scene, canDrive) => scene.mode === "playground" || canDrive],
  ["world", "World", (scene) => scene.mode === "playground"],
  ["algorithms", "Algorithms", (scene) => Boolean(scene.pipeline)], ["facts", "Numbers", () => true]];

export class Tabs {
  /** `onShow` is called when another panel is shown. */
  constructor(store, onShow) {
    this.onShow = onShow;
    this.buttons = TABS.map(([id, label, isFor]) => {
      const button = make("button", { type: "button", role: "tab", textContent: label, id: `tab-${id}`, "aria-controls": `panel-${id}` });
      button.onclick = () => {
        this.isChosen = true;
        this.show(id);
      };
      button.onkeydown = (event) => this.key(event, id);
      byId(`panel-${id}`).setAttribute("aria-labelledby", `tab-${id}`);
      return { id, isFor, button };
    });
    byId("tabs").replaceChildren(...this.buttons.map(({ button }) => button));
    const canDrive = () => store.scene.mode === "watch" && Boolean(store.latest?.drive);
    const fit = () => this.fit(store.scene, canDrive());
    store.on("scene", fit);
    store.on("latest", () => canDrive() !== this.canDrive && fit());
    this.show("drive");
  }

  fit(scene, canDrive) {
    // What the tabs are about comes with the rest of the scene.
    if (scene.is_brief) return;
    const canNowDrive = canDrive && !this.canDrive;
    this.canDrive = canDrive;
    const isOther = scene.scene !== this.scene;
    this.scene = scene.scene;
    for (const { button, isFor } of this.buttons) button.hidden = !isFor(scene, canDrive);
    setText(byId("tab-algorithms"), scene.presets ? "Parameters" : "Algorithms");
    const shown = this.buttons.find(({ id }) => id === this.shown);
    if (scene.team && isOther) this.show("team");
    else if (isOther && !this.buttons.find(({ id }) => id === "teach").button.hidden) this.show("teach");
    else if (canNowDrive && !this.isChosen) this.show("drive");
    else if (shown?.button.hidden && scene.mode === "playground") this.show("drive");
    else if (shown?.button.hidden) this.show(["replay", "watch"].includes(scene.mode) && scene.pipeline ? "algorithms" : "facts");
  }

  show(id) {
    this.shown = id;
    for (const { id: other, button } of this.buttons) {
      const isShown = other === id;
      button.setAttribute("aria-selected", String(isShown));
      button.tabIndex = isShown ? 0 : -1;
      byId(`panel-${other}`).hidden = !isShown;
    }
    this.onShow();
  }

  key(event, id) {
    const step = { ArrowRight: 1, ArrowLeft: -1 }[event.code];
    if (!step) return;
    event.preventDefault();
    event.stopPropagation();
    const usable = this.buttons.filter(({ button }) => !button.hidden);
    const next = usable[(usable.findIndex((entry) => entry.id === id) + step + usable.length) % usable.length];
    this.show(next.id);
    next.button.focus();
  }
}
