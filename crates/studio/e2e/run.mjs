// End-to-end test of the studio's page in headless Chromium.
//
//     node run.mjs PATH_TO_VISLOC [FOLDER_FOR_PICTURES]
//
// `.ci/studio-e2e` installs what this needs. Every check tells what it saw; the first that fails ends the run.

import { execFileSync, spawn } from "node:child_process";
import { mkdtempSync, rmSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { createInterface } from "node:readline";
import { chromium } from "playwright-core";

import { measure } from "./measure.mjs";

const [visloc, pictures] = process.argv.slice(2);
const folder = mkdtempSync(join(tmpdir(), "visloc-studio-"));
const children = [];
const errors = [];

const BROWSER = {
  executablePath: process.env.CHROMIUM ?? "/usr/bin/chromium",
  args: ["--headless", "--no-sandbox", "--disable-gpu", "--disable-quic", "--no-first-run", "--disable-background-networking",
    "--disable-component-update", "--disable-sync", "--use-gl=angle", "--use-angle=swiftshader", "--enable-unsafe-swiftshader"],
};

/** Starts a studio on any free port; gives its address. */
async function studio(...more) {
  const child = spawn(visloc, ["studio", "--no-open", "--port", "0", ...more], { stdio: ["ignore", "pipe", "inherit"] });
  children.push(child);
  for await (const line of createInterface({ input: child.stdout })) {
    const address = line.match(/http:\S+/)?.[0];
    if (address) return address;
  }
  throw new Error("the studio has not started");
}

async function open(browser, url, options = {}) {
  const context = await browser.newContext({ viewport: { width: 1280, height: 720 }, colorScheme: "dark", ...options });
  const page = await context.newPage();
  page.on("pageerror", (error) => errors.push(String(error)));
  page.on("console", (message) => message.type() === "error" && errors.push(message.text()));
  await page.goto(url);
  await page.waitForFunction(() => window.studio?.store.state?.number >= 0, null, { timeout: 20000 });
  return page;
}

const state = (page) => page.evaluate(() => window.studio.store.state);
const send = (page, type, more) => page.evaluate(([t, m]) => window.studio.socket.send(t, m), [type, more ?? {}]);
const until = (page, condition, argument, timeout = 60000) => page.waitForFunction(condition, argument, { timeout });

function check(isTrue, text) {
  if (!isTrue) throw new Error(`expected: ${text}`);
  console.log(`ok: ${text}`);
}

/** How many different colors an element shows; counted on a page of its own, since the studio's may load nothing. */
async function colorsOf(browser, page, selector) {
  const blank = await browser.newPage();
  const picture = (await page.locator(selector).screenshot()).toString("base64");
  const count = await blank.evaluate(async (data) => {
    const image = new Image();
    image.src = `data:image/png;base64,${data}`;
    await image.decode();
    const canvas = document.createElement("canvas");
    [canvas.width, canvas.height] = [image.width, image.height];
    const context = canvas.getContext("2d");
    context.drawImage(image, 0, 0);
    return new Set(new Uint32Array(context.getImageData(0, 0, image.width, image.height).data.buffer)).size;
  }, picture);
  await blank.close();
  return count;
}

async function localizes(page) {
  await until(page, () => window.studio.store.state.contenders?.every((c) => c.is_localized && c.error?.[0] < 0.2));
  const contenders = (await state(page)).contenders;
  check(contenders.length === 2, `two algorithms localize: ${contenders.map((c) => `${c.name} ${c.error[0].toFixed(3)} m`)}`);
}

async function draws(browser, page) {
  const [world, image] = [await colorsOf(browser, page, "#world"), await colorsOf(browser, page, "#image")];
  check(world > 50 && image > 500, `field and image are drawn (${world} and ${image} colors)`);
}

async function kidnapAndRecover(page) {
  const before = (await state(page)).truth.pose;
  await page.click("#kidnap");
  await until(page, () => {
    const { controls, contenders } = window.studio.store.state;
    return controls.is_held && contenders.some((c) => !c.is_localized);
  });
  check(true, "a kidnap is noticed");
  await until(page, (b) => {
    const s = window.studio.store.state;
    return !s.controls.is_held && Math.hypot(s.truth.pose[0] - b[0], s.truth.pose[1] - b[1]) > 0.3;
  }, before);
  await localizes(page);
}

/** Drags the robot over the canvas as a person does. */
async function dragToKidnap(page) {
  await send(page, "autopilot", { is_on: false });
  await page.click("[data-view=top]");
  await page.waitForTimeout(300);
  const place = await page.evaluate(() => {
    const { camera } = window.studio.view;
    const [x, y] = window.studio.store.state.truth.pose;
    const m = camera.clipFromWorld();
    const w = m[3] * x + m[7] * y + m[15];
    const box = document.querySelector("#world").getBoundingClientRect();
    return [box.left + ((m[0] * x + m[4] * y + m[12]) / w + 1) * box.width / 2,
      box.top + (1 - (m[1] * x + m[5] * y + m[13]) / w) * box.height / 2, x];
  });
  const step = place[2] > 0 ? -15 : 15;
  await page.mouse.move(place[0], place[1]);
  await page.mouse.down();
  for (let i = 1; i <= 10; i += 1) await page.mouse.move(place[0] + i * step, place[1], { steps: 2 });
  await until(page, () => window.studio.store.state.truth.height_m > 0.2);
  await page.mouse.up();
  await until(page, () => window.studio.store.state.truth.height_m === 0);
  const moved = Math.abs((await state(page)).truth.pose[0] - place[2]);
  check(moved > 0.5, `dragging the robot carries it (${moved.toFixed(2)} m)`);
  await localizes(page);
  await page.click("[data-view=slant]");
}

async function parametersAct(page) {
  await send(page, "algorithms", { names: ["evolutionary", "mc"] });
  await page.click("#tab-algorithms");
  await until(page, () => document.querySelector("#parameters input"));
  await page.selectOption("#panel-algorithms .search select", "1");
  const input = page.locator("[data-path=num_particles]");
  await input.fill("2000");
  await input.press("Enter");
  await until(page, () => window.studio.store.state.contenders[1].num_individuals === 2000);
  check(true, "a parameter changes behavior: 2000 particles");
  check(await page.locator(".parameter.is-changed").count() === 1, "the changed parameter is marked, with its default");
  await input.fill("-3");
  await input.press("Enter");
  await page.waitForSelector("#notice:not([hidden])");
  check((await page.locator("#notice").textContent()).includes("num_particles"), "a wrong value is refused and explained");
}

async function twoPages(browser, url, first) {
  const second = await open(browser, url);
  await send(second, "pause");
  await until(first, () => !window.studio.store.state.is_playing);
  check(true, "two pages show the same robot");
  await send(first, "play");
  await until(second, () => window.studio.store.state.is_playing);
  await second.context().close();
}

async function theme(page) {
  await page.locator("#world").focus();
  const before = await page.evaluate(() => getComputedStyle(document.body).backgroundColor);
  await page.keyboard.press("t");
  const after = await page.evaluate(() => getComputedStyle(document.body).backgroundColor);
  check(before !== after, "a key changes between light and dark");
  await page.keyboard.press("t");
}

async function renderers(browser, url) {
  for (const [wanted, name] of [["webgl", "WebGL"], ["2d", "2D"]]) {
    const page = await open(browser, `${url}?renderer=${wanted}`);
    await page.waitForTimeout(500);
    const colors = await colorsOf(browser, page, "#world");
    const renderer = await page.evaluate(() => document.querySelector("#world").dataset.renderer);
    check(renderer === name && colors > 50, `the world is drawn with ${name} (${colors} colors)`);
    await page.context().close();
  }
}

async function replays(browser) {
  const file = join(folder, "kidnaps.mcap");
  execFileSync(visloc, ["localize", "sim:kidnaps", "--frames", "1000", "--record", file], { stdio: "ignore" });
  const page = await open(browser, await studio("--replay", file));
  await until(page, () => document.querySelectorAll(".events button").length > 1);
  const kinds = await page.$$eval(".events button", (buttons) => buttons.map((button) => button.dataset.kind));
  check(kinds.includes("kidnap") && kinds.includes("lost") && kinds.includes("found"), `what happened is marked: ${kinds}`);
  await page.click(".events button[data-kind=kidnap]");
  await until(page, () => !window.studio.store.state.is_playing);
  const first = await state(page);
  await page.locator(".track input").fill("900");
  await until(page, () => window.studio.store.state.number === 900);
  await page.locator("#world").focus();
  await page.keyboard.press(".");
  await until(page, () => window.studio.store.state.number === 901);
  check(first.number < 900, `a recording is scrubbed and stepped (from ${first.number} to 901)`);
  if (pictures) await page.screenshot({ path: join(pictures, "replay.png") });
  await page.context().close();
}

async function maps(browser, url) {
  const page = await open(browser, url);
  await page.selectOption("#scene", "sim:room");
  await until(page, () => window.studio.store.arrays.landmarks?.length > 900);
  check(true, "a camera without a map makes one");
  await page.context().close();
}

async function main() {
  const browser = await chromium.launch(BROWSER);
  try {
    const url = await studio();
    const page = await open(browser, url);
    await localizes(page);
    await draws(browser, page);
    await kidnapAndRecover(page);
    await dragToKidnap(page);
    await parametersAct(page);
    await theme(page);
    await twoPages(browser, url, page);
    if (process.env.MEASURE) await measure(page, send, until);
    await page.context().close();
    await renderers(browser, url);
    await maps(browser, url);
    await replays(browser);
    check(errors.length === 0, `no error on the console ${errors.join("; ")}`);
  } finally {
    await browser.close();
    for (const child of children) child.kill();
    rmSync(folder, { recursive: true, force: true });
  }
}

main().catch((error) => {
  console.error(`FAILED: ${error.message}`);
  process.exitCode = 1;
});
