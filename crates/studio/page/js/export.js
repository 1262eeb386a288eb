// What is seen as files: numbers of the plots as CSV, and everything as a picture.

import { seriesOf } from "./plots.js";
import { firstFrom } from "./store.js";
import { css } from "./theme.js";

/** Hands a file to the browser. */
export function save(name, content) {
  const url = URL.createObjectURL(content);
  const link = Object.assign(document.createElement("a"), { href: url, download: name });
  link.click();
  setTimeout(() => URL.revokeObjectURL(url), 10000);
}

const quoted = (text) => (/[",\n]/.test(text) ? `"${text.replaceAll('"', '""')}"` : text);

/** All curves over the time that the plots show; a row for each frame, empty where a value is missing. */
export function csvOf({ charts }, time) {
  const rows = time.rows();
  const [from, to] = time.range();
  const first = firstFrom(rows, from, (row) => row.secs);
  const shown = rows.slice(first).filter((row) => row.secs >= from && row.secs <= to);
  const columns = charts.flatMap(({ definition, index }) => seriesOf(definition, index, shown).map(({ name, values }) => {
    const unit = definition.unit ? ` [${definition.unit}]` : "";
    return { head: `${definition.title.split(",")[0]} ${name}${unit}`, values };
  }));
  const frame = (row, i) => row.number ?? first + i;
  const lines = [["frame", "time [s]", ...columns.map(({ head }) => quoted(head))].join()];
  shown.forEach((row, i) => {
    lines.push([frame(row, i), row.secs.toFixed(6), ...columns.map(({ values }) => values[i] ?? "")].join());
  });
  return new Blob([`${lines.join("\n")}\n`], { type: "text/csv" });
}

/** World, image, cards and plots as one PNG. */
export function pictureOf(view, image, { charts }, title) {
  const ratio = Math.min(devicePixelRatio, 2);
  const world = view.canvas;
  const gap = 12 * ratio;
  const text = 13 * ratio;
  const side = Math.round(world.height * image.canvas.width / image.canvas.height / 2);
  const width = Math.max(world.width + gap + side, 900 * ratio);
  const columns = Math.min(charts.length, 4);
  const plotWidth = (width - gap * (columns - 1)) / Math.max(columns, 1);
  const plotHeight = charts[0] ? plotWidth * charts[0].canvas.height / charts[0].canvas.width : 0;
  const canvas = document.createElement("canvas");
  const top = 2 * text;
  const numRows = Math.ceil(charts.length / Math.max(columns, 1));
  [canvas.width, canvas.height] = [width + 2 * gap, top + world.height + gap + numRows * (plotHeight + 2 * text) + gap];
  const context = canvas.getContext("2d");
  context.fillStyle = css("surface");
  context.fillRect(0, 0, canvas.width, canvas.height);
  context.fillStyle = css("text");
  context.font = `${text}px system-ui, sans-serif`;
  context.fillText(title, gap, 1.4 * text);
  // A drawing of WebGL is there only in the task that has drawn it.
  view.touch();
  view.draw();
  context.drawImage(world, gap, top);
  context.drawImage(image.canvas, 2 * gap + world.width, top, side, side * image.canvas.height / image.canvas.width);
  cards(context, 2 * gap + world.width, top + side * image.canvas.height / image.canvas.width + 2 * text, text);
  charts.forEach(({ canvas: plot, definition, now }, i) => {
    const x = gap + (i % columns) * (plotWidth + gap);
    const y = top + world.height + gap + Math.floor(i / columns) * (plotHeight + 2 * text);
    context.fillStyle = css("soft");
    context.fillText(`${definition.title}   ${now.textContent}`, x, y + text, plotWidth);
    context.drawImage(plot, x, y + 1.4 * text, plotWidth, plotHeight);
  });
  return new Promise((resolve) => { canvas.toBlob(resolve, "image/png"); });
}

function cards(context, x, y, text) {
  document.querySelectorAll(".card, .team-row").forEach((card, i) => {
    context.fillStyle = getComputedStyle(card).getPropertyValue("--card");
    const words = [...card.querySelectorAll("h2 b, h2 span, p span, .look b, .told *")].map((part) => part.textContent);
    context.fillText(words.join("  "), x, y + 1.6 * text * i);
  });
}
