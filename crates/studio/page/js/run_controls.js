// What can be done with a run as a whole: a recording is computed again, a run elsewhere begins anew or is saved.

import { make, setText } from "./dom.js";

export class RunControls {
  constructor(store, socket) {
    Object.assign(this, { store, socket });
    this.seed = make("input", { type: "number", min: 0, max: Number.MAX_SAFE_INTEGER, value: 1, id: "recompute-seed" });
    this.compute = make("button", { type: "button", className: "primary", textContent: "Recompute", id: "recompute",
      title: "The recorded images again, with the algorithms and parameters below" });
    this.compute.onclick = () => this.send("recompute");
    this.back = make("button", { type: "button", textContent: "Recorded only", id: "recorded", title: "Back to what was recorded" });
    this.back.onclick = () => socket.send("recorded");
    this.progress = make("progress", { max: 1, value: 0, hidden: true, "aria-label": "Computed" });
    this.replay = make("div", { className: "run-row" }, this.compute,
      make("label", { className: "seed" }, make("span", { textContent: "seed" }), this.seed), this.back);
    this.restart = button("Start again", "restart", "The run begins anew, with this seed", () => this.send("reset"));
    this.save = button("Save", "save", "Writes the poses so far on the robot's computer", () => socket.send("save"));
    this.seedAway = make("input", { type: "number", min: 0, max: Number.MAX_SAFE_INTEGER, value: 1 });
    this.watch = make("div", { className: "run-row" }, this.restart,
      make("label", { className: "seed" }, make("span", { textContent: "seed" }), this.seedAway), this.save);
    this.note = make("p", { className: "small" });
    this.box = make("div", { className: "run-controls" }, this.replay, this.watch, this.progress, this.note);
    store.on("scene", () => this.fit());
    store.on("latest", () => this.follow());
  }

  send(command) {
    const seed = Math.floor(Number((command === "reset" ? this.seedAway : this.seed).value));
    if (seed >= 0) this.socket.send(command, { seed });
  }

  fit() {
    const { mode, recording, presets, seed } = this.store.scene;
    this.replay.hidden = mode !== "replay";
    this.watch.hidden = mode !== "watch";
    this.box.hidden = this.replay.hidden && this.watch.hidden;
    for (const input of [this.seed, this.seedAway]) {
      if (document.activeElement !== input) input.value = seed ?? 1;
    }
    if (mode === "watch") this.note.textContent = "What is changed here is changed in the run.";
    if (mode !== "replay") return;
    this.compute.disabled = !recording.can_recompute;
    this.back.disabled = !recording.is_recomputed;
    this.note.textContent = recording.can_recompute
      ? `Choose ${presets ? "preset" : "algorithms"} and parameters, then recompute: the result is shown beside what was recorded.`
      : "This recording does not hold what the algorithms were given.";
  }

  follow() {
    const running = this.store.latest.recomputing;
    this.progress.hidden = !running;
    if (running) this.progress.value = running.done / Math.max(running.all, 1);
    setText(this.compute, running ? "Computing" : "Recompute");
  }
}

function button(textContent, id, title, onclick) {
  return make("button", { type: "button", textContent, id, title, onclick });
}
