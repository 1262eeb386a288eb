// Curves over time.

import { byId, make, setText } from "./dom.js";
import { LANES, drawMark, setDash } from "./lanes.js";
import { firstFrom } from "./store.js";
import { css, onTheme } from "./theme.js";

/** Titles, values of a lane, and scales. */
const ROBOT = [
  { title: "Position error", unit: "m", value: (lane) => lane.error, least: 0.2, digits: 2 },
  { title: "Reliability", unit: "", value: (lane) => lane.reliability, fixed: 1, digits: 2, threshold: 0.6 },
  { title: "Image quality", unit: "", value: (lane) => lane.quality, fixed: 1, digits: 2 },
  { title: "Time, thin: image", unit: "ms", value: (lane) => lane.ms, thin: (lane) => lane.image, least: 1, digits: 2 },
];
const EVENT_COLORS = { kidnap: "warn", lost: "danger", found: "accent", jump: "c2" };
/** Marks of a curve stand so far apart, pixels. */
const MARK_PX = 70;
/** Places for times on the axis stand at least so far apart, in sizes of the text. */
const TICK_EMS = 5;

export class Plots {
  constructor(store, time) {
    Object.assign(this, { store, time });
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
      const canvas = make("canvas", { "aria-label": `${definition.title}, moment that is shown`, tabIndex: 0, role: "slider" });
      const box = make("section", { className: "plot", "aria-label": definition.title },
        make("h2", {}, make("span", { textContent: definition.title }), now), canvas);
      const chart = { definition, canvas, now, box, index: i };
      this.listen(chart);
      return chart;
    });
    byId("plots").replaceChildren(...this.charts.map((chart) => chart.box));
  }

  listen({ canvas }) {
    const { time } = this;
    const at = (event) => {
      const { left, right } = this.frame(canvas);
      const [from, to] = time.range();
      const share = (event.clientX - canvas.getBoundingClientRect().left - left) / (right - left);
      return from + Math.min(Math.max(share, 0), 1) * (to - from);
    };
    canvas.onpointerdown = (event) => {
      canvas.setPointerCapture(event.pointerId);
      time.goTo(at(event));
    };
    canvas.onpointermove = (event) => {
      time.pointAt(at(event));
      if (event.buttons & 1) time.goTo(at(event));
    };
    canvas.onpointerleave = canvas.onpointercancel = () => time.pointAt(null);
    canvas.addEventListener("wheel", (event) => {
      event.preventDefault();
      time.zoom(Math.exp(event.deltaY * 0.002), at(event));
    }, { passive: false });
    canvas.onkeydown = (event) => {
      const step = { ArrowLeft: -1, ArrowRight: 1, PageUp: -30, PageDown: 30, Home: -Infinity, End: Infinity }[event.key];
      const zoom = { "+": 0.5, "-": 2 }[event.key];
      if (!step && !zoom) return;
      event.preventDefault();
      event.stopPropagation();
      if (zoom) time.zoom(zoom);
      else time.step(step * (event.shiftKey ? 30 : 1));
    };
  }

  draw() {
    const rows = this.time.rows();
    if (rows.length === 0) return;
    const [from, to] = this.time.range();
    const first = Math.max(0, firstFrom(rows, from, (row) => row.secs) - 1);
    const past = rows.slice(first, firstFrom(rows, to, (row) => row.secs) + 1);
    const isHeld = this.store.recording || this.store.isBack;
    const shown = isHeld ? this.time.shown() : null;
    const told = this.time.pointed ?? this.time.shown();
    const row = rows[this.time.indexOf(told)];
    for (const chart of this.charts) this.chart(chart, past, [from, to], shown, row);
  }

  /** Where a plot's curves are. */
  frame({ clientWidth, clientHeight }) {
    const size = fontSize();
    return { left: 3.4 * size, right: clientWidth - 0.5 * size, top: 0.5 * size, bottom: clientHeight - 1.5 * size };
  }

  chart({ definition, canvas, now, index }, rows, [from, to], shown, told) {
    const ratio = Math.min(devicePixelRatio, 2);
    const [width, height] = [canvas.clientWidth, canvas.clientHeight];
    if (canvas.width !== Math.round(width * ratio)) canvas.width = Math.round(width * ratio);
    if (canvas.height !== Math.round(height * ratio)) canvas.height = Math.round(height * ratio);
    const context = canvas.getContext("2d");
    context.setTransform(ratio, 0, 0, ratio, 0, 0);
    context.clearRect(0, 0, width, height);
    const series = seriesOf(definition, index, rows);
    const top = definition.fixed ?? nice(Math.max(definition.least ?? 1e-3, percentile(series)));
    const frame = this.frame(canvas);
    const x = (secs) => frame.left + (secs - from) / Math.max(to - from, 1e-3) * (frame.right - frame.left);
    const y = (value) => frame.bottom - Math.min(value / top, 1.04) * (frame.bottom - frame.top);
    grid(context, frame, top, y, definition);
    times(context, frame, [from, to], x);
    context.save();
    context.beginPath();
    context.rect(frame.left, 0, frame.right - frame.left, height);
    context.clip();
    this.carried(context, frame, rows, x);
    this.events(context, frame, [from, to], x);
    for (const one of series) curve(context, rows, one, x, y);
    context.restore();
    const upright = (secs, color) => {
      if (secs === null || secs < from || secs > to) return;
      context.fillStyle = css(color);
      context.fillRect(Math.round(x(secs)) - 0.5, frame.top, 1, frame.bottom - frame.top);
    };
    upright(shown, "text");
    if (this.time.pointed !== null) upright(this.time.pointed, "soft");
    const values = valuesOf(definition, index, told).map((value) => (value == null ? "–" : value.toFixed(definition.digits ?? 2)));
    setText(now, `${values.join("  ")} ${definition.unit}`.trim());
    canvas.setAttribute("aria-valuemin", from.toFixed(2));
    canvas.setAttribute("aria-valuemax", to.toFixed(2));
    canvas.setAttribute("aria-valuenow", Math.min(Math.max(told.secs, from), to).toFixed(2));
    canvas.setAttribute("aria-valuetext", `${told.secs.toFixed(1)} s: ${values.join(", ")} ${definition.unit}`);
  }

  /** Somebody carried the robot. */
  carried(context, frame, rows, x) {
    context.fillStyle = css("line");
    context.globalAlpha = 0.6;
    rows.forEach((row, i) => {
      if (row.isCarried) context.fillRect(x(row.secs), frame.top, Math.max(1, x((rows[i + 1] ?? row).secs) - x(row.secs)), frame.bottom - frame.top);
    });
    context.globalAlpha = 1;
  }

  events(context, frame, [from, to], x) {
    for (const { kind, secs } of this.time.events()) {
      if (secs < from || secs > to) continue;
      context.fillStyle = css(EVENT_COLORS[kind] ?? "soft");
      context.fillRect(x(secs) - 0.5, frame.bottom - 5, 1.5, 7);
      drawMark(context, 2, x(secs), frame.bottom + 1, 3);
    }
  }
}

/** Curves of a plot: their lane, width and values. */
export function seriesOf(definition, index, rows) {
  const lanes = rows[rows.length - 1]?.lanes ?? [];
  if (!definition.value) {
    return definition.series.map((name, k) => (
      { name, lane: k, color: LANES[(k + 1) % 4], line: 1.6, values: rows.map((row) => row.values?.[index]?.[k] ?? null) }));
  }
  return lanes.flatMap((lane, k) => {
    const values = (read) => rows.map((row) => (row.lanes[k]?.name === lane.name ? read(row.lanes[k]) : null));
    const thin = definition.thin ? [{ name: `${lane.name} image`, lane: k, color: LANES[k], line: 0.8, values: values(definition.thin) }] : [];
    return [...thin, { name: lane.name, lane: k, color: LANES[k], line: 1.6, values: values(definition.value) }];
  });
}

/** What a plot says of one frame. */
function valuesOf(definition, index, row) {
  return seriesOf(definition, index, [row]).filter(({ line }) => line > 1).map(({ values }) => values[0]);
}

const fontSize = () => Math.max(10, 0.82 * Number.parseFloat(getComputedStyle(document.documentElement).fontSize));

function grid(context, frame, top, y, definition) {
  context.font = `${fontSize()}px system-ui, sans-serif`;
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
    context.fillStyle = css("soft");
    context.fillText(String(Number((share * top).toPrecision(3))), frame.left - 4, row);
  }
  if (!definition.threshold) return;
  context.strokeStyle = css("soft");
  context.setLineDash([3, 4]);
  context.beginPath();
  context.moveTo(frame.left, y(definition.threshold));
  context.lineTo(frame.right, y(definition.threshold));
  context.stroke();
  context.setLineDash([]);
}

/** The axis of time. */
function times(context, frame, [from, to], x) {
  const size = fontSize();
  const most = Math.max(1, Math.floor((frame.right - frame.left) / (TICK_EMS * size)));
  const step = nice((to - from) / most);
  context.fillStyle = context.strokeStyle = css("soft");
  context.textAlign = "center";
  context.textBaseline = "alphabetic";
  const digits = Math.max(0, -Math.floor(Math.log10(step) + 1e-9));
  for (let secs = Math.ceil(from / step) * step; secs <= to; secs += step) {
    if (secs < -1e-9) continue;
    context.fillRect(Math.round(x(secs)), frame.bottom, 1, 3);
    const text = secs.toFixed(digits);
    const half = context.measureText(text).width / 2;
    if (x(secs) + half > frame.right + 0.4 * size) continue;
    context.fillText(text, x(secs), frame.bottom + 1.35 * size);
  }
}

function curve(context, rows, { color, line, lane, values }, x, y) {
  context.strokeStyle = context.fillStyle = css(color);
  const scale = fontSize() / 10.7;
  context.lineWidth = line * scale;
  context.lineJoin = "round";
  setDash(context, lane, line * scale);
  context.beginPath();
  let isPen = false;
  const marks = [];
  const step = Math.max(1, Math.floor(rows.length / 1500));
  // Marks stand at the same frames as the time goes on.
  const perFrame = rows.length > 1 ? (x(rows[rows.length - 1].secs) - x(rows[0].secs)) / (rows.length - 1) : 1;
  const every = Math.max(1, Math.round(MARK_PX / Math.max(perFrame, 1e-6)));
  for (let i = 0; i < rows.length; i += step) {
    if (values[i] == null) {
      isPen = false;
      continue;
    }
    if (isPen) context.lineTo(x(rows[i].secs), y(values[i]));
    else context.moveTo(x(rows[i].secs), y(values[i]));
    isPen = true;
    const number = rows[i].number ?? i;
    if (line > 1 && Math.floor((number + lane * every / 4) / every) !== Math.floor((number - step + lane * every / 4) / every)) {
      marks.push([x(rows[i].secs), y(values[i])]);
    }
  }
  context.stroke();
  context.setLineDash([]);
  for (const [px, py] of marks) drawMark(context, lane, px, py, 3.2 * scale);
}

/** Nearly the largest value: single peaks may be cut off. */
function percentile(series) {
  const all = series.flatMap(({ values }) => values.filter((value) => value != null)).sort((a, b) => a - b);
  return all.length ? all[Math.ceil(0.985 * (all.length - 1))] * 1.1 : 0;
}

/** The next of 1, 2, 5, 10, ... */
function nice(value) {
  const power = 10 ** Math.floor(Math.log10(value));
  return [1, 2, 5, 10].map((k) => k * power).find((k) => k >= value) ?? value;
}
