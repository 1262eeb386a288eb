// Lays a map over an image by hand, with pointer events in headless Chromium, and tells how far off its lines are.
//
//     visloc camera by-hand IMAGE --map MAP --camera CAMERA --pose X,Y,Z,HEADING,PITCH,ROLL --out page.html
//     node run.mjs /PATH/OF/page.html '{"x":..,"y":..,"z":..,"heading":..,"pitch":..,"roll":..}' [PICTURES]
//
// The second argument is the true pose, as the page names it: meters and degrees. Needs playwright-core and Chromium
// (CHROMIUM, or /usr/bin/chromium). Every drag has 0.5 px of error and 1.5 s of thought. Ends with an error above 2 px.

import { chromium } from "playwright-core";

const NOISE_PX = 0.5;
const THOUGHT_MS = 1500;
const MAX_CORNERS = 12;
const GOAL_PX = 2;

const [pagePath, truthJson, pictures] = process.argv.slice(2);
const truth = JSON.parse(truthJson);
const browser = await chromium.launch({ executablePath: process.env.CHROMIUM ?? "/usr/bin/chromium", args: ["--no-sandbox"] });
const page = await browser.newPage({ viewport: { width: 1500, height: 860 } });
page.on("pageerror", (error) => { throw error; });
await page.goto(`file://${pagePath}`);
await page.waitForTimeout(500);

// Calls `look` with the page's functions, once with the true pose and once with the present one.
const compare = (what) => page.evaluate(([truth, what]) => {
  const { parameters, corners, project } = window.byHand;
  const input = JSON.parse(document.getElementById("input").textContent);
  const [width, height] = input.camera.size_px;
  const between = (a, b) => [0.1, 0.3, 0.5, 0.7, 0.9].map((s) => a.map((v, k) => v + (b[k] - v) * s));
  const points = what === "corners" ? corners : input.lines.flatMap((line) => line.slice(1).flatMap((b, i) => between(line[i], b)));
  const now = points.map((point) => project(point));
  const kept = parameters.map((p) => p.value);
  for (const p of parameters) if (p.name in truth) p.value = truth[p.name];
  const real = points.map((point) => project(point));
  parameters.forEach((p, i) => { p.value = kept[i]; });
  const isSeen = (px) => px && px[0] > 5 && px[1] > 5 && px[0] < width - 5 && px[1] < height - 5;
  return points.map((_, i) => ({ i, real: real[i], now: now[i] })).filter(({ real }) => isSeen(real));
}, [truth, what]);

// Mean distance of the map's lines in the image from where they truly are, pixels.
async function meanErrorPx() {
  const points = await compare("lines");
  const distances = points.map(({ real, now }) => (now ? Math.hypot(real[0] - now[0], real[1] - now[1]) : 500));
  return distances.reduce((sum, d) => sum + d, 0) / distances.length;
}

const onScreen = (px) => page.evaluate((px) => {
  const canvas = document.getElementById("view");
  const box = canvas.getBoundingClientRect();
  const [x, y] = window.byHand.toCanvas(px);
  return [box.left + x * box.width / canvas.width, box.top + y * box.height / canvas.height];
}, px);

let seed = 7;
const uniform = () => { seed = (seed * 16807) % 2147483647; return seed / 2147483647; };
const gaussian = () => Math.sqrt(-2 * Math.log(uniform())) * Math.cos(2 * Math.PI * uniform());

// Corners that are far apart first.
const left = await compare("corners");
const chosen = [];
while (chosen.length < MAX_CORNERS && left.length) {
  const far = (t) => Math.min(...chosen.map((c) => Math.hypot(c.real[0] - t.real[0], c.real[1] - t.real[1])), 1e9);
  const next = left.reduce((a, b) => (far(b) > far(a) ? b : a));
  left.splice(left.indexOf(next), 1);
  chosen.push(next);
}

const start = Date.now();
async function tell(what) {
  const mean = await meanErrorPx();
  const secs = ((Date.now() - start) / 1000).toFixed(1);
  console.log(`${secs} s, ${what}: lines ${mean.toFixed(2)} px off; pins ${await page.textContent("#pins")}; ${await page.textContent("#edges")}`);
  return mean;
}

let mean = await tell("start");
for (const { i, real } of chosen) {
  const from = await page.evaluate((i) => window.byHand.project(window.byHand.corners[i]), i);
  if (!from) continue;
  await page.waitForTimeout(THOUGHT_MS);
  await page.mouse.move(...await onScreen(from));
  await page.mouse.down();
  await page.mouse.move(...await onScreen(real.map((v) => v + NOISE_PX * gaussian())), { steps: 25 });
  await page.mouse.up();
  mean = await tell(`corner ${i}`);
}
if (pictures) await page.screenshot({ path: `${pictures}/by-hand.png` });
const [download] = await Promise.all([page.waitForEvent("download"), page.click("#save")]);
console.log(`saved ${download.suggestedFilename()}`);
await browser.close();
process.exit(mean < GOAL_PX ? 0 : 1);
