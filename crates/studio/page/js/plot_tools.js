// The row over the plots: the moment, zoom, and what is seen as files or as a link.

import { byId, make, setText } from "./dom.js";
import { csvOf, pictureOf, save } from "./export.js";
import { linkTo } from "./permalink.js";

export class PlotTools {
  constructor(store, time, view, image, plots) {
    Object.assign(this, { store, time });
    const button = (id, textContent, title, onclick) => make("button", { type: "button", id, textContent, title, onclick });
    this.at = make("span", { className: "at number" });
    this.now = button("to-now", "Now", "Back to what is now (N)", () => time.now());
    this.all = button("zoom-all", "All", "The usual span of time", () => time.showAll());
    this.link = button("permalink", "Link", "Copy a link to this moment", () => this.copy());
    const name = () => `visloc-${store.scene.scene}-${store.state.secs.toFixed(1)}s`.replace(/[^\w.-]+/g, "-");
    const [less, more] = [button("zoom-in", "+", "Less time in the plots", () => time.zoom(0.5)),
      button("zoom-out", "−", "More time in the plots", () => time.zoom(2))];
    for (const sign of [less, more]) sign.ariaLabel = sign.title;
    byId("plot-tools").replaceChildren(this.at, this.now, more, less, this.all, this.link,
      button("save-csv", "CSV", "Save the numbers of the plots as CSV", () => save(`${name()}.csv`, csvOf(plots, time))),
      button("save-png", "PNG", "Save world, image and plots as a picture", async () => {
        save(`${name()}.png`, await pictureOf(view, image, plots, this.at.textContent));
      }));
  }

  draw() {
    const { store, time } = this;
    if (!store.state) return;
    const back = store.isBack ? `, ${(store.latest.secs - store.state.secs).toFixed(1)} s ago` : "";
    const pointed = time.pointed === null ? "" : `, values at ${time.pointed.toFixed(2)} s`;
    setText(this.at, `${store.state.secs.toFixed(2)} s${back}${pointed}`);
    this.now.hidden = !store.isBack;
    this.all.disabled = !time.isZoomed();
    this.link.hidden = !store.recording;
  }

  async copy() {
    const link = linkTo(this.store);
    history.replaceState(null, "", link);
    const address = new URL(link, location.href);
    // Who gets the link has a token of their own.
    address.searchParams.delete("token");
    try {
      await navigator.clipboard.writeText(address.href);
      setText(byId("announce"), "Link copied");
    } catch {
      setText(byId("announce"), "The link is in the address bar");
    }
  }
}
