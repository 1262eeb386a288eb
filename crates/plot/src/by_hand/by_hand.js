// Lays a map over an image: corners of the map are dragged to where they are seen, and pose and camera follow.
"use strict";
const input = window.opener?.studio?.byHand.input() ?? JSON.parse(document.getElementById("input").textContent);
const [width, height] = input.camera.size_px;
const isFisheye = input.camera.model === "kannala-brandt";
const k = [...input.camera.distortion, 0, 0, 0, 0, 0];
const longer = Math.max(width, height);
// name, title, value, from, to, step, spread when a pin pulls, whether a pin may change it
const parameters = [
  ["x", "x, m", input.pose[0], -15, 15, 0.005, 1, true],
  ["y", "y, m", input.pose[1], -15, 15, 0.005, 1, true],
  ["z", "height, m", input.pose[2], 0.02, 3, 0.002, 0.1, true],
  ["heading", "heading, deg", input.pose[3], -180, 180, 0.05, 20, true],
  ["pitch", "pitch down", input.pose[4], -90, 90, 0.05, 10, true],
  ["roll", "roll, deg", input.pose[5], -180, 180, 0.05, 4, true],
  ["fx", "fx, px", input.camera.focal_px[0], 0.1 * longer, 4 * longer, 0.5, 0.05 * longer, false],
  ["fy", "fy, px", input.camera.focal_px[1], 0.1 * longer, 4 * longer, 0.5, 0.05 * longer, false],
  ["cx", "cx, px", input.camera.center_px[0], 0, width, 0.25, 0.02 * width, false],
  ["cy", "cy, px", input.camera.center_px[1], 0, height, 0.25, 0.02 * height, false],
  ...(isFisheye ? ["k1", "k2", "k3", "k4"] : ["k1", "k2", "p1", "p2", "k3"]).map((name, i) =>
    [name, name, k[i], -1, 1, 0.001, name[0] === "p" ? 0.002 : 0.1, false]),
].map(([name, title, value, from, to, step, spread, isFree]) => ({ name, title, value, from, to, step, spread, isFree }));
const by = Object.fromEntries(parameters.map((p) => [p.name, p]));
const value = (name) => by[name].value;

// Geometry -----------------------------------------------------------------------------------------------------------

function distort(x, y) {
  const r2 = x * x + y * y;
  if (isFisheye) {
    const r = Math.sqrt(r2);
    if (r < 1e-9) return [x, y, 1];
    const t = Math.atan(r), t2 = t * t;
    const d = t * (1 + t2 * (value("k1") + t2 * (value("k2") + t2 * (value("k3") + t2 * value("k4")))));
    const slope = 1 + t2 * (3 * value("k1") + t2 * (5 * value("k2") + t2 * (7 * value("k3") + t2 * 9 * value("k4"))));
    return [x * d / r, y * d / r, slope];
  }
  const [k1, k2, p1, p2, k3] = ["k1", "k2", "p1", "p2", "k3"].map(value);
  const radial = 1 + r2 * (k1 + r2 * (k2 + r2 * k3));
  const slope = 1 + r2 * (3 * k1 + r2 * (5 * k2 + r2 * 7 * k3));
  return [x * radial + 2 * p1 * x * y + p2 * (r2 + 2 * x * x), y * radial + p1 * (r2 + 2 * y * y) + 2 * p2 * x * y, slope];
}

// Axes of the camera in the world: right, down, ahead.
function axes() {
  const rad = Math.PI / 180;
  const h = value("heading") * rad, p = value("pitch") * rad, r = value("roll") * rad;
  const ahead = [Math.cos(h) * Math.cos(p), Math.sin(h) * Math.cos(p), -Math.sin(p)];
  const right = [Math.sin(h), -Math.cos(h), 0];
  const down = [ahead[1] * right[2] - ahead[2] * right[1], ahead[2] * right[0] - ahead[0] * right[2],
    ahead[0] * right[1] - ahead[1] * right[0]];
  const turn = (a, b, c, s) => a.map((v, i) => v * c + b[i] * s);
  const [c, s] = [Math.cos(r), Math.sin(r)];
  return [turn(right, down, c, s), turn(down, right, c, -s), ahead];
}

// Pixel of a point of the world; null behind the camera or where the lens folds.
function project(point, frame = axes()) {
  const d = [point[0] - value("x"), point[1] - value("y"), point[2] - value("z")];
  const [x, y, z] = frame.map((axis) => axis[0] * d[0] + axis[1] * d[1] + axis[2] * d[2]);
  if (z < 0.03) return null;
  const [u, v, slope] = distort(x / z, y / z);
  return slope <= 0 ? null : [value("fx") * u + value("cx"), value("fy") * v + value("cy")];
}

// Direction of a pixel in the world.
function ray(px) {
  const [u, v] = [(px[0] - value("cx")) / value("fx"), (px[1] - value("cy")) / value("fy")];
  let [x, y] = [u, v];
  for (let i = 0; i < 30; i += 1) {
    const [a, b] = distort(x, y);
    x += 0.7 * (u - a);
    y += 0.7 * (v - b);
  }
  const [right, down, ahead] = axes();
  return [0, 1, 2].map((i) => right[i] * x + down[i] * y + ahead[i]);
}

const azimuth = (d) => Math.atan2(d[1], d[0]) * 180 / Math.PI;
const elevation = (d) => Math.atan2(d[2], Math.hypot(d[0], d[1])) * 180 / Math.PI;
const wrap = (a) => ((a + 180) % 360 + 360) % 360 - 180;

// Pins ---------------------------------------------------------------------------------------------------------------

const corners = [];
for (const line of input.lines) {
  if (line.length > 20) continue;
  for (const p of line) {
    if (!corners.some((q) => Math.hypot(p[0] - q[0], p[1] - q[1], p[2] - q[2]) < 1e-6)) corners.push(p);
  }
}
const pins = new Map();

function pinErrors() {
  const frame = axes();
  return [...pins].flatMap(([i, px]) => {
    const seen = project(corners[i], frame);
    return seen ? [seen[0] - px[0], seen[1] - px[1]] : [200, 200];
  });
}

// Damped Gauss-Newton over what is ticked; what pins leave open stays near where it is.
function fit(rounds) {
  const free = parameters.filter((p) => p.isFree);
  if (!pins.size || !free.length) return;
  const before = free.map((p) => p.value);
  const residuals = () => [...pinErrors(), ...free.map((p, i) => 0.3 * (p.value - before[i]) / p.spread)];
  const cost = (e) => e.reduce((sum, v) => sum + v * v, 0);
  let damping = 1e-3;
  for (let round = 0; round < rounds; round += 1) {
    const e = residuals();
    const columns = free.map((p) => {
      const step = 1e-4 * p.spread, kept = p.value;
      p.value = kept + step;
      const ahead = residuals();
      p.value = kept;
      return ahead.map((v, i) => (v - e[i]) / step);
    });
    const at = free.map((p) => p.value);
    for (let tries = 0; tries < 8; tries += 1) {
      const step = solve(columns, e, damping);
      free.forEach((p, i) => { p.value = at[i] + step[i]; });
      if (cost(residuals()) < cost(e)) { damping = Math.max(damping * 0.3, 1e-9); break; }
      free.forEach((p, i) => { p.value = at[i]; });
      damping *= 5;
    }
  }
  by.heading.value = wrap(by.heading.value);
}

// Solves (J^T J + damping diag) step = -J^T e by elimination.
function solve(columns, e, damping) {
  const n = columns.length, dot = (a, b) => a.reduce((sum, v, i) => sum + v * b[i], 0);
  const m = columns.map((a, i) => [...columns.map((b, j) => dot(a, b) * (i === j ? 1 + damping : 1)), -dot(a, e)]);
  for (let i = 0; i < n; i += 1) {
    let pivot = i;
    for (let r = i + 1; r < n; r += 1) if (Math.abs(m[r][i]) > Math.abs(m[pivot][i])) pivot = r;
    [m[i], m[pivot]] = [m[pivot], m[i]];
    for (let r = 0; r < n; r += 1) {
      if (r === i) continue;
      const factor = m[r][i] / (m[i][i] || 1e-12);
      for (let c = i; c <= n; c += 1) m[r][c] -= factor * m[i][c];
    }
  }
  return m.map((row, i) => row[n] / (row[i] || 1e-12));
}

// Picture ------------------------------------------------------------------------------------------------------------

const canvas = document.getElementById("view");
const context = canvas.getContext("2d");
const image = new Image();
const scale = Math.max(1, Math.round(1280 / width));
canvas.width = width * scale;
canvas.height = height * scale;
let zoom = 1, offset = [0, 0], luma = null, hovered = null;

const toCanvas = (px) => [((px[0] + 0.5) * scale - offset[0]) * zoom, ((px[1] + 0.5) * scale - offset[1]) * zoom];
const toImage = (p) => [(p[0] / zoom + offset[0]) / scale - 0.5, (p[1] / zoom + offset[1]) / scale - 0.5];
const isInside = (px) => px && px[0] >= 0 && px[1] >= 0 && px[0] <= width - 1 && px[1] <= height - 1;

// The line in short pieces, since the lens bends it.
function* pieces(line, frame, step = 0.04) {
  for (let i = 0; i + 1 < line.length; i += 1) {
    const [a, b] = [line[i], line[i + 1]];
    const count = Math.max(1, Math.ceil(Math.hypot(b[0] - a[0], b[1] - a[1], b[2] - a[2]) / step));
    for (let j = 0; j <= count; j += 1) {
      yield project(a.map((v, axis) => v + (b[axis] - v) * j / count), frame);
    }
  }
}

function draw() {
  const frame = axes();
  context.setTransform(1, 0, 0, 1, 0, 0);
  context.fillStyle = "#333";
  context.fillRect(0, 0, canvas.width, canvas.height);
  context.setTransform(zoom, 0, 0, zoom, -offset[0] * zoom, -offset[1] * zoom);
  context.imageSmoothingEnabled = false;
  context.drawImage(image, 0, 0, width * scale, height * scale);
  context.setTransform(1, 0, 0, 1, 0, 0);
  for (const [style, thick] of [["rgba(0,0,0,0.6)", 3.5], ["#ff2fd0", 1.6]]) {
    context.strokeStyle = style;
    context.lineWidth = thick;
    context.beginPath();
    for (const line of input.lines) {
      let isOpen = false;
      for (const px of pieces(line, frame)) {
        const near = px && Math.abs(px[0]) < 4 * width && Math.abs(px[1]) < 4 * height;
        if (near) context[isOpen ? "lineTo" : "moveTo"](...toCanvas(px));
        isOpen = Boolean(near);
      }
    }
    context.stroke();
  }
  corners.forEach((corner, i) => {
    const px = project(corner, frame);
    if (!isInside(px)) return;
    context.beginPath();
    context.arc(...toCanvas(px), i === hovered ? 8 : 5, 0, 7);
    context.fillStyle = pins.has(i) ? "#e69f00" : "rgba(255,255,255,0.55)";
    context.strokeStyle = "#000";
    context.lineWidth = 1;
    context.fill();
    context.stroke();
  });
  report(frame);
}

// How far the drawn lines lie from the strongest edge across them, pixels: no truth is needed.
function edgeDistance(frame) {
  if (!luma) return null;
  const at = (x, y) => luma[Math.round(Math.min(Math.max(y, 0), height - 1)) * width + Math.round(Math.min(Math.max(x, 0), width - 1))];
  const found = [];
  for (const line of input.lines) {
    let last = null;
    for (const px of pieces(line, frame, 0.08)) {
      if (isInside(px) && isInside(last)) {
        const along = [px[0] - last[0], px[1] - last[1]], length = Math.hypot(...along);
        if (length > 0.5) {
          const n = [-along[1] / length, along[0] / length];
          let best = 0, where = 0;
          for (let s = -10; s <= 10; s += 0.5) {
            const g = Math.abs(at(px[0] + n[0] * (s + 1), px[1] + n[1] * (s + 1)) - at(px[0] + n[0] * (s - 1), px[1] + n[1] * (s - 1)));
            if (g > best) [best, where] = [g, Math.abs(s)];
          }
          if (best > 25) found.push(where);
        }
      }
      last = px;
    }
  }
  found.sort((a, b) => a - b);
  return found.length > 10 ? { median: found[found.length >> 1], count: found.length } : null;
}

function report(frame) {
  const e = pinErrors();
  const rms = Math.sqrt(2 * e.reduce((sum, v) => sum + v * v, 0) / Math.max(e.length, 1));
  document.getElementById("pins").textContent = pins.size ? `${rms.toFixed(2)} px RMS (${pins.size})` : "none";
  const edges = edgeDistance(frame);
  document.getElementById("edges").textContent =
    edges ? `${edges.median.toFixed(1)} px from the nearest edge (median of ${edges.count} places)` : "no edges near";
}

// Controls -----------------------------------------------------------------------------------------------------------

function addRows() {
  const rows = document.getElementById("rows");
  for (const [title, names] of [["Pose", ["x", "y", "z", "heading", "pitch", "roll"]], ["Camera", null]]) {
    rows.insertAdjacentHTML("beforeend", `<h2>${title}</h2>`);
    for (const p of parameters.filter((p) => (names ? names.includes(p.name) : !input_is_pose(p.name)))) {
      const row = document.createElement("div");
      row.className = "row";
      row.innerHTML = `<input type="checkbox" title="a pin may change it" aria-label="a pin may change ${p.title}"><label for="number-${p.name}">${p.title}</label>` +
        `<input type="range" id="range-${p.name}" min="${p.from}" max="${p.to}" step="${p.step}" aria-label="${p.title}">` +
        `<input type="number" id="number-${p.name}" step="${p.step}">`;
      [p.box, , p.range, p.number] = row.children;
      p.box.id = `free-${p.name}`;
      p.box.checked = p.isFree;
      p.box.onchange = () => { p.isFree = p.box.checked; };
      for (const field of [p.range, p.number]) {
        field.oninput = () => { if (Number.isFinite(field.valueAsNumber)) { p.value = field.valueAsNumber; show(field); } };
      }
      rows.append(row);
    }
  }
}
function input_is_pose(name) { return ["x", "y", "z", "heading", "pitch", "roll"].includes(name); }

function show(except) {
  for (const p of parameters) {
    if (p.range !== except) p.range.value = p.value;
    if (p.number !== except) p.number.value = Number(p.value.toFixed(5));
  }
  draw();
}

function pointer(event) {
  const box = canvas.getBoundingClientRect();
  return [(event.clientX - box.left) * canvas.width / box.width, (event.clientY - box.top) * canvas.height / box.height];
}
function cornerAt(p) {
  const frame = axes();
  let best = null, least = 14;
  corners.forEach((corner, i) => {
    const px = project(corner, frame);
    if (!px) return;
    const c = toCanvas(px), d = Math.hypot(c[0] - p[0], c[1] - p[1]);
    if (d < least) [best, least] = [i, d];
  });
  return best;
}

let drag = null;
canvas.onpointerdown = (event) => {
  canvas.setPointerCapture(event.pointerId);
  const p = pointer(event), px = toImage(p), corner = cornerAt(p);
  drag = { corner, wasPinned: corner !== null && pins.has(corner), hasMoved: false, last: px, grab: px,
    seen: corner === null ? null : project(corners[corner]) };
};
canvas.onpointermove = (event) => {
  const p = pointer(event), px = toImage(p);
  if (!drag) {
    const over = cornerAt(p);
    if (over !== hovered) { hovered = over; draw(); }
    return;
  }
  drag.hasMoved ||= Math.hypot(px[0] - drag.grab[0], px[1] - drag.grab[1]) > 1 / zoom;
  if (!drag.hasMoved) return;
  if (drag.corner !== null) {
    // The corner keeps its place under the pointer.
    pins.set(drag.corner, [drag.seen[0] + px[0] - drag.grab[0], drag.seen[1] + px[1] - drag.grab[1]]);
    fit(4);
  } else {
    const [from, to] = [ray(drag.last), ray(px)];
    if (event.shiftKey && from[2] < -1e-3 && to[2] < -1e-3) {
      const ground = (d) => [d[0] * -value("z") / d[2], d[1] * -value("z") / d[2]];
      const [a, b] = [ground(from), ground(to)];
      by.x.value += a[0] - b[0];
      by.y.value += a[1] - b[1];
    } else if (!event.shiftKey) {
      by.heading.value = wrap(by.heading.value + wrap(azimuth(from) - azimuth(to)));
      by.pitch.value += elevation(to) - elevation(from);
    }
    drag.last = px;
  }
  show();
};
canvas.onpointerup = () => {
  if (drag && drag.corner !== null && !drag.hasMoved) {
    if (drag.wasPinned) pins.delete(drag.corner);
    else pins.set(drag.corner, drag.seen);
  } else if (drag && drag.corner !== null) fit(20);
  drag = null;
  show();
};
function zoomAt(p, factor) {
  const next = Math.min(12, Math.max(1, zoom * factor));
  offset = [0, 1].map((i) => offset[i] + p[i] / zoom - p[i] / next);
  zoom = next;
  const most = [canvas.width * (1 - 1 / zoom), canvas.height * (1 - 1 / zoom)];
  offset = offset.map((v, i) => Math.min(Math.max(v, 0), most[i]));
  draw();
}
canvas.onwheel = (event) => {
  event.preventDefault();
  zoomAt(pointer(event), Math.exp(-0.0015 * event.deltaY));
};
for (const [id, factor] of [["zoom-in", 1.5], ["zoom-out", 1 / 1.5]]) {
  document.getElementById(id).onclick = () => zoomAt([canvas.width / 2, canvas.height / 2], factor);
}

function toml() {
  const list = (names) => names.map((name) => Number(value(name).toPrecision(10))).map((v) => (Number.isInteger(v) ? v.toFixed(1) : v)).join(", ");
  const names = isFisheye ? ["k1", "k2", "k3", "k4"] : ["k1", "k2", "p1", "p2", "k3"];
  const isPinhole = !isFisheye && names.every((name) => value(name) === 0);
  const model = isFisheye ? "kannala-brandt" : isPinhole ? "pinhole" : "radial-tangential";
  return `# Laid over ${JSON.stringify(input.name)} by hand.\nmodel = "${model}"\nsize_px = [${width}, ${height}]\n` +
    `focal_px = [${list(["fx", "fy"])}]\ncenter_px = [${list(["cx", "cy"])}]\ndistortion = [${isPinhole ? "" : list(names)}]\n\n` +
    `[pose]\nposition_m = [${list(["x", "y", "z"])}]\nheading_deg = ${list(["heading"])}\npitch_down_deg = ${list(["pitch"])}\n` +
    `roll_clockwise_deg = ${list(["roll"])}\n`;
}

document.getElementById("fit").onclick = () => { fit(40); show(); };
document.getElementById("release").onclick = () => { pins.clear(); show(); };
document.getElementById("save").onclick = () => {
  const link = document.createElement("a");
  link.href = URL.createObjectURL(new Blob([toml()], { type: "application/toml" }));
  link.download = "camera.toml";
  link.click();
};
document.getElementById("name").textContent = `${input.name}, ${width} x ${height} px`;
addRows();
image.onload = () => {
  const copy = document.createElement("canvas");
  [copy.width, copy.height] = [width, height];
  copy.getContext("2d").drawImage(image, 0, 0, width, height);
  const data = copy.getContext("2d").getImageData(0, 0, width, height).data;
  luma = Float32Array.from({ length: width * height }, (_, i) => 0.3 * data[4 * i] + 0.59 * data[4 * i + 1] + 0.11 * data[4 * i + 2]);
  show();
};
image.src = input.image;
show();
// For tests from outside.
window.byHand = { parameters, corners, project, toCanvas, toml, pins };
