// The camera image with what belongs on it.

import { byId, make, setPressed } from "./dom.js";
import { LANES, setDash } from "./lanes.js";
import { css, onTheme } from "./theme.js";

/** One color for each reason to drop a pixel, in the order of the filters. */
const DROP_COLORS = ["#e41a1c", "#ff7f00", "#f781bf", "#b065c9", "#5a9bd4", "#c0743a", "#00c8c8", "#8b74ff", "#b3365f",
  "#6fd35f", "#c9a64a", "#d4a3ff", "#4fb6c9", "#9a9a9a"];
const KEPT_COLORS = ["#ffffff", "#ffd400"];
const FEATURES = {
  landmarks: ["#3ddc97", "landmarks found"],
  candidates: ["#ff9f1c", "candidates found"],
  missed: ["#ff5d5d", "landmarks not found"],
};

/** The legend changes no faster than one can read, milliseconds. */
const LEGEND_MS = 250;

export class ImageView {
  constructor(store) {
    this.store = store;
    this.canvas = byId("image");
    this.context = this.canvas.getContext("2d");
    this.shown = { kept: true, dropped: true, theory: true };
    this.bitmap = null;
    this.isDecoding = false;
    store.on("image", () => this.decode());
    store.on("scene", () => this.chips());
    onTheme(() => this.draw());
  }

  chips() {
    const names = this.store.scene.world.kind === "space"
      ? { landmarks: "landmarks", candidates: "candidates", missed: "not found" }
      : { kept: "kept pixels", dropped: "dropped", theory: "expected map" };
    const key = Object.keys(names).join();
    if (this.chipKey === key) return;
    this.chipKey = key;
    byId("chips").replaceChildren(...Object.entries(names).map(([name, label]) => {
      this.shown[name] ??= true;
      const chip = make("button", { type: "button", textContent: label });
      setPressed(chip, this.shown[name]);
      chip.onclick = () => {
        this.shown[name] = !this.shown[name];
        setPressed(chip, this.shown[name]);
        this.draw();
      };
      return chip;
    }));
  }

  /** Decodes the latest image; those that come meanwhile are left out but the last. */
  async decode() {
    if (this.isDecoding) return;
    this.isDecoding = true;
    const image = this.store.image;
    try {
      const bitmap = await createImageBitmap(new Blob([image.arrays.jpeg], { type: "image/jpeg" }));
      this.bitmap?.close();
      this.bitmap = bitmap;
      this.drawn = image;
      this.draw();
    } catch {
      // A picture that cannot be decoded is left out; the next one comes.
    }
    this.isDecoding = false;
    if (this.store.image !== image) this.decode();
  }

  draw() {
    const { context, canvas, bitmap, drawn } = this;
    if (!bitmap) return;
    const [width, height] = drawn.header.size_px;
    const wanted = [2 * width, 2 * height].map((value) => (width > 500 ? value / 2 : value));
    if (canvas.width !== wanted[0] || canvas.height !== wanted[1]) [canvas.width, canvas.height] = wanted;
    const scale = canvas.width / width;
    // Over a slow link the image has fewer pixels.
    context.imageSmoothingEnabled = bitmap.width < width;
    context.drawImage(bitmap, 0, 0, canvas.width, canvas.height);
    // Pixel centers are whole numbers.
    const at = (value) => (value + 0.5) * scale;
    const { arrays, header } = drawn;
    const counts = [];
    if (this.shown.dropped && arrays.dropped) this.dropped(arrays.dropped, at, counts);
    if (this.shown.theory) this.theories(arrays, at, header);
    if (this.shown.kept && arrays.kept) this.dots(arrays.kept, at, (kind) => KEPT_COLORS[kind], 2.6);
    for (const name of ["missed", "candidates", "landmarks"]) {
      if (this.shown[name] && arrays[name]) this.features(arrays[name], at, FEATURES[name][0], name === "missed");
    }
    this.legend(arrays, counts);
  }

  /** One color after the other: setting a color costs more than a dot. */
  dropped(values, at, counts) {
    const { context } = this;
    for (let i = 2; i < values.length; i += 3) counts[values[i]] = (counts[values[i]] ?? 0) + 1;
    counts.forEach((_, reason) => {
      context.fillStyle = DROP_COLORS[reason];
      for (let i = 0; i + 2 < values.length; i += 3) {
        if (values[i + 2] === reason) context.fillRect(at(values[i]) - 1.2, at(values[i + 1]) - 1.2, 2.4, 2.4);
      }
    });
  }

  dots(values, at, color, radius) {
    const { context } = this;
    context.lineWidth = 1.6;
    context.strokeStyle = "#000";
    for (let i = 0; i + 2 < values.length; i += 3) {
      context.beginPath();
      context.arc(at(values[i]), at(values[i + 1]), radius, 0, 2 * Math.PI);
      context.fillStyle = color(values[i + 2]);
      context.stroke();
      context.fill();
    }
  }

  features(values, at, color, isDot) {
    const { context } = this;
    context.strokeStyle = context.fillStyle = color;
    context.lineWidth = 1.5;
    for (let i = 0; i + 1 < values.length; i += 2) {
      const [x, y] = [at(values[i]), at(values[i + 1])];
      if (isDot) context.fillRect(x - 1.5, y - 1.5, 3, 3);
      else context.strokeRect(x - 3.5, y - 3.5, 7, 7);
    }
  }

  /** The map as each algorithm expects it, and the horizon. */
  theories(arrays, at, header) {
    const { context } = this;
    const draw = (values, color, width) => {
      context.strokeStyle = color;
      context.lineWidth = width;
      context.beginPath();
      let isPen = false;
      for (let i = 0; i + 1 < values.length; i += 2) {
        if (Number.isNaN(values[i])) isPen = false;
        else if (isPen) context.lineTo(at(values[i]), at(values[i + 1]));
        else context.moveTo(at(values[i]), at(values[i + 1]));
        isPen = !Number.isNaN(values[i]);
      }
      context.stroke();
    };
    // Of a team the image is that of one robot, in its lane.
    const first = this.store.state?.team?.look ?? 0;
    LANES.slice(first).forEach((lane, i) => {
      if (!arrays[`theory${i}`]) return;
      setDash(context, first + i, 1.5);
      draw(arrays[`theory${i}`], css(lane), 1.5);
    });
    context.setLineDash([]);
    const [left, right] = header.horizon ?? [null, null];
    if (left !== null && right !== null) {
      context.setLineDash([5, 5]);
      draw([0, left, header.size_px[0], right], "rgba(255,255,255,.35)", 1);
      context.setLineDash([]);
    }
  }

  legend(arrays, counts) {
    clearTimeout(this.legendTimer);
    const waitMs = (this.legendAt ?? -LEGEND_MS) + LEGEND_MS - performance.now();
    if (waitMs > 0) {
      // The last one counts, if none comes after it.
      this.legendTimer = setTimeout(() => this.legend(arrays, counts), waitMs);
      return;
    }
    this.legendAt = performance.now();
    const entry = (color, text) => make("span", {}, make("i", { vars: { "--dot": color } }), text);
    const entries = [];
    if (arrays.kept) entries.push(entry(KEPT_COLORS[0], `kept ${arrays.kept.length / 3}`));
    for (const [name, [color, label]] of Object.entries(FEATURES)) {
      if (arrays[name]) entries.push(entry(color, `${label} ${arrays[name].length / 2}`));
    }
    counts.forEach((count, reason) => {
      entries.push(entry(DROP_COLORS[reason], `${this.store.scene.drop_reasons?.[reason] ?? "dropped"} ${count}`));
    });
    byId("legend").replaceChildren(...entries);
  }
}
