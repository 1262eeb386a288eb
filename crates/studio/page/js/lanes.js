// How what runs side by side is told apart: by color, by dash and by mark, so that no color is needed.

export const LANES = ["c0", "c1", "c2", "c3", "c4"];
/** Lengths of lines and gaps, in widths of the line. */
export const DASHES = [[], [6, 3], [2, 2.5], [8, 2.5, 2, 2.5], [12, 4]];
/** Outlines of the marks around the origin, with corners at a distance of 1; the first is a circle. */
const CORNERS = [
  Array.from({ length: 16 }, (_, i) => [Math.cos(Math.PI * i / 8), Math.sin(Math.PI * i / 8)]),
  [[-0.85, -0.85], [0.85, -0.85], [0.85, 0.85], [-0.85, 0.85]],
  [[0, -1.1], [1, 0.75], [-1, 0.75]],
  [[0, -1.2], [1.05, 0], [0, 1.2], [-1.05, 0]],
  [[0, 1.1], [-1, -0.75], [1, -0.75]],
];
const NAMES = ["circle, solid line", "square, dashed line", "triangle, dotted line", "diamond, dashes and dots",
  "triangle upside down, long dashes"];

export const markOf = (lane) => CORNERS[lane % CORNERS.length];

/** Has a canvas draw the lines of a lane, which are so wide. */
export function setDash(context, lane, width) {
  context.setLineDash(DASHES[lane % DASHES.length].map((length) => length * Math.max(width, 1)));
}

/** Adds the mark of a lane to a canvas. */
export function drawMark(context, lane, x, y, radius) {
  context.beginPath();
  markOf(lane).forEach(([dx, dy], i) => (i ? context.lineTo(x + radius * dx, y + radius * dy) : context.moveTo(x + radius * dx, y + radius * dy)));
  context.closePath();
  context.fill();
}

/** Mark and line of a lane, in the color `--card` around it. */
export function laneIcon(lane) {
  const space = "http://www.w3.org/2000/svg";
  const svg = document.createElementNS(space, "svg");
  svg.setAttribute("viewBox", "-13 -6 26 12");
  svg.setAttribute("class", "mark");
  svg.setAttribute("role", "img");
  svg.setAttribute("aria-label", NAMES[lane % NAMES.length]);
  const line = document.createElementNS(space, "path");
  line.setAttribute("d", "M-13 0H13");
  line.setAttribute("stroke-width", "2");
  line.setAttribute("stroke-dasharray", DASHES[lane % DASHES.length].map((length) => 1.3 * length).join(" "));
  const mark = document.createElementNS(space, "path");
  mark.setAttribute("d", `M${markOf(lane).map(([x, y]) => `${4 * x} ${4 * y}`).join("L")}Z`);
  mark.setAttribute("stroke", "none");
  svg.append(line, mark);
  return svg;
}
