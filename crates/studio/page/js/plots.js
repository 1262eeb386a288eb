// Curves over time.

import { LANES } from "./actors.js";
import { byId, make, setText } from "./dom.js";
import { css, onTheme } from "./theme.js";

const WINDOW_SECS = 30;

/** Titles, values of a lane, and scales. */
const ROBOT = [
  { title: "Position error", unit: "m", value: (lane) => lane.error, least: 0.2, digits: 2 },
  { title: "Reliability", unit: "", value: (lane) => lane.reliability, fixed: 1, digits: 2, threshold: 0.6 },
  { title: "Image quality", unit: "", value: (lane) => lane.quality, fixed: 1, digits: 2 },
  { title: "Time, thin: image", unit: "ms", value: (lane) => lane.ms, thin: (lane) => lane.image, least: 1, digits: 2 },
];

export class Plots {
  constructor(store) {
    this.store = store;
    this.charts = [];
    store.on("scene", () => this.prepare());
    onTheme(() => this.draw());
  }

  prepare() {
    const definitions = this.store.scene.plots ?? ROBOT;
    const key = definitions.map(({ title, series }) => [title, series].join()).join(";");
    if (key === this.key) return;
    this.key = key;
    this.charts = definitions.map((definition, i) => {
      const now = make("span", { className: "number" });
      const canvas = make("canvas", { "aria-label": definition.title });
      const box = make("section", { className: "plot" }, make("h3", {}, definition.title, now), canvas);
      return { definition, canvas, now, box, index: i };
    });
    byId("plots").replaceChildren(...this.charts.map((chart) => chart.box));
  }

  draw() {
    const full = this.store.recording;
    const past = full?.rows ?? this.store.past;
    const last = full ? { secs: full.secs } : past[past.length - 1];
    if (!last) return;
    const range = full ? [past[0].secs, past[past.length - 1].secs] : [last.secs - WINDOW_SECS, last.secs];
    const rows = full ? past : past.slice(firstFrom(past, range[0]));
    for (const chart of this.charts) this.chart(chart, rows, range, full ? full.secs : null);
  }

  chart({ definition, canvas, now, index }, rows, [from, to], cursor) {
    const ratio = Math.min(devicePixelRatio, 2);
    const [width, height] = [canvas.clientWidth, canvas.clientHeight];
    if (canvas.width !== Math.round(width * ratio)) canvas.width = Math.round(width * ratio);
    if (canvas.height !== Math.round(height * ratio)) canvas.height = Math.round(height * ratio);
    const context = canvas.getContext("2d");
    context.setTransform(ratio, 0, 0, ratio, 0, 0);
    context.clearRect(0, 0, width, height);
    const series = this.series(definition, index, rows);
    const top = definition.fixed ?? nice(Math.max(definition.least ?? 1e-3, percentile(series)));
    const frame = { left: 34, right: width - 4, top: 6, bottom: height - 6 };
    const x = (secs) => frame.left + (secs - from) / Math.max(to - from, 1e-3) * (frame.right - frame.left);
    const y = (value) => frame.bottom - Math.min(value / top, 1.04) * (frame.bottom - frame.top);
    this.grid(context, frame, top, y, definition);
    context.fillStyle = css("line");
    context.globalAlpha = 0.6;
    rows.forEach((row, i) => {
      if (row.isCarried) context.fillRect(x(row.secs), frame.top, Math.max(1, x((rows[i + 1] ?? row).secs) - x(row.secs)), frame.bottom - frame.top);
    });
    context.globalAlpha = 1;
    for (const { color, line, values } of series) curve(context, rows, values, x, y, css(color), line);
    if (cursor !== null) {
      context.fillStyle = css("text");
      context.fillRect(x(cursor) - 0.5, frame.top, 1, frame.bottom - frame.top);
    }
    const latest = series.filter(({ line }) => line > 1).map(({ values }) => values[values.length - 1]);
    const texts = latest.map((value) => (value == null ? "–" : value.toFixed(definition.digits)));
    setText(now, cursor === null ? `${texts.join("  ")} ${definition.unit}` : definition.unit);
  }

  series(definition, index, rows) {
    const lanes = rows[rows.length - 1]?.lanes ?? [];
    if (!definition.value) {
      return definition.series.map((_, k) => (
        { color: LANES[(k + 1) % 4], line: 1.6, values: rows.map((row) => row.values?.[index]?.[k] ?? null) }));
    }
    return lanes.flatMap((lane, k) => {
      const values = (read) => rows.map((row) => (row.lanes[k]?.name === lane.name ? read(row.lanes[k]) : null));
      const thin = definition.thin ? [{ color: LANES[k], line: 0.8, values: values(definition.thin) }] : [];
      return [...thin, { color: LANES[k], line: 1.6, values: values(definition.value) }];
    });
  }

  grid(context, frame, top, y, definition) {
    context.font = "10.5px system-ui, sans-serif";
    context.textAlign = "right";
    context.textBaseline = "middle";
    context.lineWidth = 1;
    for (const share of [0, 0.5, 1]) {
      const row = Math.round(y(share * top)) + 0.5;
      context.strokeStyle = css("line");
      context.beginPath();
      context.moveTo(frame.left, row);
      context.lineTo(frame.right, row);
      context.stroke();
      context.fillStyle = css("faint");
      context.fillText(String(Number((share * top).toPrecision(3))), frame.left - 4, row);
    }
    if (definition.threshold) {
      context.strokeStyle = css("soft");
      context.setLineDash([3, 4]);
      context.beginPath();
      context.moveTo(frame.left, y(definition.threshold));
      context.lineTo(frame.right, y(definition.threshold));
      context.stroke();
      context.setLineDash([]);
    }
  }
}

function curve(context, rows, values, x, y, color, line) {
  context.strokeStyle = color;
  context.lineWidth = line;
  context.lineJoin = "round";
  context.beginPath();
  let isPen = false;
  const step = Math.max(1, Math.floor(rows.length / 1500));
  for (let i = 0; i < rows.length; i += step) {
    if (values[i] == null) {
      isPen = false;
      continue;
    }
    if (isPen) context.lineTo(x(rows[i].secs), y(values[i]));
    else context.moveTo(x(rows[i].secs), y(values[i]));
    isPen = true;
  }
  context.stroke();
}

function firstFrom(past, secs) {
  let [low, high] = [0, past.length];
  while (low < high) {
    const middle = (low + high) >> 1;
    if (past[middle].secs < secs) low = middle + 1;
    else high = middle;
  }
  return low;
}

/** Nearly the largest value: single peaks may be cut off. */
function percentile(series) {
  const all = series.flatMap(({ values }) => values.filter((value) => value != null)).sort((a, b) => a - b);
  return all.length ? all[Math.floor(0.985 * (all.length - 1))] * 1.1 : 0;
}

/** The next of 1, 2, 5, 10, ... */
function nice(value) {
  const power = 10 ** Math.floor(Math.log10(value));
  return [1, 2, 5, 10].map((k) => k * power).find((k) => k >= value) ?? value;
}
