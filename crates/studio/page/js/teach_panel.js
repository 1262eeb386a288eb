// Teaching a place: its map grows while the camera looks around, is saved, and the camera is found in it.

import { byId, make, setText } from "./dom.js";

export class TeachPanel {
  constructor(store, socket) {
    Object.assign(this, { store, socket });
    const button = (textContent, id, title, onclick) => make("button", { type: "button", textContent, id, title, onclick });
    const open = (kind) => () => socket.send("open", { scene: `${kind}-${store.latest.taught.number}` });
    this.grown = make("b", { className: "number" });
    this.save = button("Save the map", "save-taught", "Writes the map so far into a file", () => socket.send("save"));
    this.file = make("b", { className: "number" });
    this.find = button("Find the camera in it", "find-in-taught", "The same images again, in this map", open("taught"));
    this.find.className = "primary";
    this.goOn = button("Go on teaching in it", "teach-more", "The same images again; what is new is added to this map", open("teach"));
    this.next = make("li", {}, make("p", {}, "Saved: ", this.file), make("div", { className: "run-row" }, this.find, this.goOn));
    this.steps = make("ol", { className: "column teach-steps" },
      make("li", {}, make("p", {}, "Let the camera look around, sideways rather than on the spot. Its map grows: ", this.grown, ".")),
      make("li", {}, make("div", { className: "run-row" }, this.save)), this.next);
    this.hands = make("span", {}, make("b", {}, "Kidnap"), " it, cover it: it is found again wherever the map was made.");
    this.found = make("p", {}, "The camera is looked for in a map that stays as it is. ", this.hands);
    this.elsewhere = make("p", { className: "small" }, "Any camera is found in such a file: visloc localize SOURCE --map FILE. Or drop the file on this page, and then a video, a bag or a folder of images.");
    byId("panel-teach").replaceChildren(this.steps, this.found, this.elsewhere);
    store.on("scene", () => this.fit());
    store.on("latest", () => this.follow());
  }

  fit() {
    const isTeaching = this.store.scene.does === "teach";
    this.save.disabled = true;
    this.steps.hidden = !isTeaching;
    this.found.hidden = isTeaching;
    this.hands.hidden = !this.store.scene.has_hands;
    this.elsewhere.hidden = !isTeaching;
  }

  follow() {
    const { taught, facts } = this.store.latest;
    if (this.store.scene?.does !== "teach") return;
    const fact = (label) => facts?.find(([name]) => name === label)?.[1] ?? "0";
    setText(this.grown, `${fact("Keyframes")} keyframes, ${fact("Landmarks")} landmarks`);
    this.save.disabled = fact("Keyframes") === "0";
    this.next.hidden = !taught;
    if (taught) setText(this.file, `${taught.file}, ${taught.num_keyframes} keyframes, ${taught.num_landmarks} landmarks`);
  }
}
