// Files from this computer: dropped on the page, or chosen in a dialog.

import { byId, make } from "./dom.js";

export class Files {
  /** `notice(text)` tells what came of it. */
  constructor(notice) {
    this.notice = notice;
    this.input = make("input", { type: "file", hidden: true, multiple: true, "aria-label": "Files to open" });
    this.input.onchange = () => {
      this.open([...this.input.files]);
      this.input.value = "";
    };
    document.body.append(this.input);
    byId("open-file").onclick = () => this.input.click();
    this.begin();
  }

  /** Only a studio that nobody else can reach takes files. */
  async begin() {
    const answer = await fetch("/files").then((response) => response.text()).catch(() => "no");
    if (answer !== "yes") return;
    byId("open-file").hidden = false;
    addEventListener("dragover", (event) => {
      if (!event.dataTransfer?.types.includes("Files")) return;
      event.preventDefault();
      document.body.dataset.drop = "";
    });
    addEventListener("dragleave", (event) => { if (!event.relatedTarget) delete document.body.dataset.drop; });
    addEventListener("drop", (event) => {
      delete document.body.dataset.drop;
      if (!event.dataTransfer?.files.length) return;
      event.preventDefault();
      this.open([...event.dataTransfer.files]);
    });
  }

  /** Maps and calibrations first, since they say how the rest is to be opened. */
  async open(files) {
    const isText = ({ name }) => /\.(toml|ya?ml|svg|dxf|json)$/i.test(name);
    for (const file of files.sort((a, b) => Number(isText(b)) - Number(isText(a)))) {
      this.notice(`Opening ${file.name}, ${(file.size / 1e6).toFixed(1)} MB`);
      try {
        const name = encodeURIComponent(file.name.replace(/[^\w.-]+/g, "-"));
        const answer = await fetch(`/files?name=${name}`, { method: "POST", body: file });
        if (!answer.ok) this.notice(await answer.text());
      } catch {
        this.notice(`${file.name} could not be handed over`);
      }
    }
  }
}
