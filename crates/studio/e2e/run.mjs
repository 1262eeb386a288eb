// End-to-end test of the studio's page in headless Chromium.
//
//     node run.mjs PATH_TO_VISLOC [--all] [FOLDER_FOR_PICTURES]
//
// What takes long (every scene on every small screen, thin links, a whole replay, files by drop) is done with --all.
// `.ci/studio-e2e` installs what this needs. Every check tells what it saw; the first that fails ends the run.

import { execFileSync } from "node:child_process";
import { existsSync, readdirSync } from "node:fs";
import { join, resolve } from "node:path";
import { chromium } from "playwright-core";

import { byHand } from "./by_hand.mjs";
import { goesThrough, looksBack, parameters } from "./course.mjs";
import { drives, drivesBySlam } from "./drive.mjs";
import { drops } from "./drops.mjs";
import { slow, wrongToken } from "./far.mjs";
import { keys, touches } from "./hands.mjs";
import { measure } from "./measure.mjs";
import { SCREENS, look, scenesOf } from "./screens.mjs";
import { team } from "./team.mjs";
import { draws as drawsBuildings, firstMap, firstVisit } from "./visit.mjs";
import { BROWSER, Programs, open as openPage, send, state, until } from "./visloc.mjs";

const isWhole = process.argv.includes("--all");
const [visloc, pictures] = process.argv.slice(2).filter((argument) => argument !== "--all");
const programs = new Programs(visloc);
const { folder } = programs;
const errors = [];
const studio = (...more) => programs.studio(...more);
const open = (browser, url, options) => openPage(browser, url, errors, options);

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
  // The panel is built anew with the algorithms; what is typed before is lost.
  await until(page, () => window.studio.store.scene.contenders[1].name === "mc" && document.querySelector("#parameters input"));
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

/** What the page says of its link. */
const link = (page) => page.locator("#link").textContent();
const isLive = (page) => until(page, () => document.querySelector("#link").textContent === "live");

/** A program that is stopped is stale within 1.5 s, and live when it goes on. */
async function stalls(page, name, which) {
  await isLive(page);
  programs.stall(true, which);
  const stoppedAt = performance.now();
  await until(page, () => document.querySelector("#link").textContent.startsWith("stale for"));
  const secs = (performance.now() - stoppedAt) / 1000;
  check(secs < 1.5, `${name} that is stopped is stale after ${secs.toFixed(2)} s: ${await link(page)}`);
  const told = await page.locator("#stale").textContent();
  check(told.includes("has not answered") && await page.locator("#stale").isVisible(), `and the page says: ${told}`);
  programs.stall(false, which);
  await isLive(page);
  check(await page.locator("#stale").isHidden(), "it is live again");
}

/** A studio and a robot elsewhere that stall; a pause is something else. */
async function stale(browser) {
  const page = await open(browser, await studio("--scene", "robocup-2010"));
  await stalls(page, "a studio", -1);
  await send(page, "pause");
  await until(page, () => document.querySelector("#link").textContent === "paused");
  await page.waitForTimeout(1600);
  check(await link(page) === "paused", "a paused one is not stale");
  await page.context().close();
  const robot = await programs.start(/--connect (\S+)/, "localize", "sim:tour", "--publish", "127.0.0.1:0");
  const desk = await open(browser, await studio("--connect", robot));
  await stalls(desk, "a robot elsewhere", -2);
  await desk.context().close();
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
  await recomputes(page);
  await page.context().close();
  return file;
}

/** A recording is computed again with the same and with other parameters. */
async function recomputes(page) {
  await page.click("#tab-algorithms");
  await page.click("#recompute");
  await until(page, () => window.studio.store.scene.recording.is_recomputed);
  for (const frame of [30, 600, 999]) {
    await send(page, "seek", { frame });
    await until(page, (f) => window.studio.store.state.number === f, frame);
    const [recorded, again] = (await state(page)).contenders;
    check(JSON.stringify(recorded.pose) === JSON.stringify(again.pose) && recorded.likelihood === again.likelihood,
      `computed again, frame ${frame} is the same: ${again.name}, ${again.error?.[0].toFixed(4)} m`);
  }
  await page.selectOption("#panel-algorithms .lane select", "mce");
  await page.click("#recompute");
  await until(page, () => window.studio.store.state.contenders[1]?.name === "mce, again");
  check(await page.locator(".card").count() === 2, "another algorithm is shown beside the recorded one");
  if (pictures) await page.screenshot({ path: join(pictures, "recomputed.png") });
  await page.click("#recorded");
  await until(page, () => window.studio.store.state.contenders.length === 1);
  check(true, "there is a way back");
}

/** A button records; the recording is replayed from the page. */
async function records(browser) {
  const page = await open(browser, await studio("--recordings", "kept"));
  await page.click("#record");
  await until(page, () => window.studio.store.state.recorder?.num_frames > 40);
  await page.click("#record");
  await page.click("#open-recorded");
  await until(page, () => window.studio.store.scene.mode === "replay" && window.studio.store.state.num_frames > 40);
  const files = readdirSync(join(folder, "kept")).filter((name) => name.endsWith(".mcap"));
  check(files.length === 1, `what is shown is recorded and replayed: ${files}`);
  check(!(await page.locator("#recompute").isDisabled()), "and can be computed again");
  await page.context().close();
}

/** A run elsewhere takes commands of those who know its token. */
async function commandsAway(browser) {
  const run = ["localize", "sim:kidnaps", "--publish", "127.0.0.1:0", "--token", "secret"];
  const address = await programs.start(/--connect (\S+)/, ...run);
  const refused = await (await fetch(`http://${address}/access?token=wrong`)).status;
  check(refused === 403, "without the token a run is not to be seen or commanded");
  const page = await open(browser, await studio("--connect", address, "--token", "secret"));
  await until(page, () => window.studio.store.state.contenders?.[0]?.is_localized);
  await page.click("#tab-algorithms");
  await page.selectOption("#panel-algorithms .lane select", "mc");
  await until(page, () => window.studio.store.state.contenders[0].name === "mc");
  const input = page.locator("[data-path=num_particles]");
  await input.fill("700");
  await input.press("Enter");
  await until(page, () => window.studio.store.state.contenders[0].num_individuals === 700);
  check(true, "algorithm and parameter of a run elsewhere are changed: mc, 700 particles");
  await input.fill("-3");
  await input.press("Enter");
  await until(page, () => document.querySelector("#notice")?.textContent.includes("num_particles"));
  check(true, "what it refuses is told");
  await page.click("#save");
  await until(page, () => document.querySelector("#notice")?.textContent.includes("saved on the robot"));
  const saved = readdirSync(join(folder, "out/studio")).filter((name) => name.endsWith(".tum"));
  check(saved.length === 1, `its poses are saved on its side: ${saved}`);
  await page.click("#play");
  await until(page, () => !window.studio.store.state.is_playing);
  const still = (await state(page)).number;
  await page.waitForTimeout(600);
  check((await state(page)).number === still, "the picture pauses");
  await page.click("#play");
  await until(page, (n) => window.studio.store.state.number > n + 10, still);
  check(true, "and goes on where the robot is by now");
  await page.click("#record");
  await until(page, () => window.studio.store.state.recorder?.num_frames > 20);
  await page.click("#record");
  if (pictures) await page.screenshot({ path: join(pictures, "connected.png") });
  await page.click("#open-recorded");
  await until(page, () => window.studio.store.scene.mode === "replay");
  check(true, "a robot elsewhere is recorded and replayed here");
  await page.context().close();
}

/** SLAM: a map, a hand over the camera, a kidnap, other parameters. */
async function maps(browser, url) {
  const page = await open(browser, url);
  await page.selectOption("#scene", "sim:room");
  await until(page, () => window.studio.store.arrays.landmarks?.length > 900);
  check(true, "a camera without a map makes one");
  await until(page, () => window.studio.store.state.number > 110);
  await page.click("#cover");
  await until(page, () => window.studio.store.state.is_lost);
  check(true, "with a hand over it, it is lost");
  await page.click("#cover");
  await until(page, () => !window.studio.store.state.is_lost && !window.studio.store.state.controls.is_covered);
  await page.click("#kidnap");
  await until(page, () => window.studio.store.state.controls.is_held && window.studio.store.state.is_lost);
  await until(page, () => !window.studio.store.state.controls.is_held && !window.studio.store.state.is_lost);
  const error = (await state(page)).values[0][0];
  check(error < 0.2, `carried elsewhere, it finds itself again (${error.toFixed(3)} m)`);
  if (pictures) await page.screenshot({ path: join(pictures, "slam.png") });
  await page.click("#tab-algorithms");
  await page.selectOption("#preset", "orb-sdvl");
  await until(page, () => window.studio.store.scene.preset === "orb-sdvl" && window.studio.store.state.number < 40);
  check(true, "another preset starts it anew");
  await page.click("#record");
  await until(page, () => window.studio.store.state.recorder?.num_frames > 60);
  await page.click("#record");
  await page.click("#open-recorded");
  await until(page, () => window.studio.store.scene.mode === "replay" && window.studio.store.scene.pipeline);
  await page.click("#tab-algorithms");
  await page.selectOption("#preset", "sdvl");
  await page.click("#recompute");
  await until(page, () => window.studio.store.scene.recording.is_recomputed);
  await send(page, "seek", { frame: 60 });
  await until(page, () => window.studio.store.arrays.recorded?.length > 0 && window.studio.store.state.values[0].length === 2);
  check(true, "a recording of SLAM is computed again with another preset");
  if (pictures) await page.screenshot({ path: join(pictures, "slam-parameters.png") });
  await page.context().close();
}

/** A room is taught, and the camera found in its map. */
async function teaches(browser, url) {
  const page = await open(browser, url);
  await page.selectOption("#scene", "sim:room");
  await until(page, () => !document.getElementById("save-taught").disabled && window.studio.store.arrays.keyframes?.length >= 12 * 10);
  const saved = () => window.studio.store.latest.taught;
  await page.click("#save-taught");
  await until(page, saved);
  const { file, num_keyframes } = await page.evaluate(saved);
  check(existsSync(resolve(folder, file)) && file.endsWith(".vmap") && num_keyframes >= 10, `the map of a room is saved: ${num_keyframes} keyframes`);
  if (pictures) await page.screenshot({ path: join(pictures, "teach.png") });
  await page.click("#find-in-taught");
  await until(page, () => window.studio.store.scene.does === "find" && window.studio.store.state.is_lost === false);
  await page.click("#kidnap");
  await until(page, () => window.studio.store.state.controls.is_held);
  await until(page, () => !window.studio.store.state.controls.is_held && window.studio.store.state.is_lost === false);
  const error = (await state(page)).values[0][0];
  check(error < 0.2, `carried elsewhere, the camera is found in that map (${error.toFixed(3)} m)`);
  if (pictures) await page.screenshot({ path: join(pictures, "taught.png") });
  await page.context().close();
}

/** Any source: here a simulation, and a bag. */
async function sources(browser, bag) {
  for (const args of [["sim:robocup"], [bag, "--map", "robocup-spl-2010"]]) {
    const page = await open(browser, await studio(...args));
    await until(page, () => window.studio.store.state.contenders?.[0]?.is_localized);
    check(true, `a robot is followed through ${args[0].startsWith("sim:") ? args[0] : "a bag"}`);
    await page.context().close();
  }
}

/** Every scene on a phone, a phone that lies across, and a tablet. */
async function screens(browser) {
  for (const scene of Object.entries(scenesOf(programs, visloc))) {
    const faults = [];
    for (const [screen, light] of [["360x740", "dark"], ["740x360", "light"], ["1024x768", "light"]]) {
      faults.push(...await look(browser, scene, [screen], [light]));
    }
    check(faults.length === 0, `${scene[0]} fits on small screens, and axe finds nothing serious ${faults.join("\n")}`);
  }
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
    await touches((options) => open(browser, url, options), check);
    await keys(() => open(browser, url), check);
    await looksBack(() => open(browser, url), check);
    await parameters(() => open(browser, url), visloc, folder, check);
    const other = await studio();
    await byHand((options) => open(browser, other, options), check, pictures);
    await renderers(browser, url);
    await maps(browser, url);
    await teaches(browser, url);
    await team((options) => open(browser, url, options), SCREENS["390x844"], check, pictures);
    await stale(browser);
    await wrongToken(browser, programs, check);
    const recording = await replays(browser);
    await records(browser);
    await commandsAway(browser);
    await drives(browser, programs, errors, check, pictures);
    await drivesBySlam(browser, programs, errors, check);
    await sources(browser, recording);
    await firstVisit(browser, programs, errors, check, pictures);
    await firstMap(browser, programs, errors, check, pictures);
    await drawsBuildings(browser, programs, errors, check);
    if (isWhole) {
      await slow(programs, check);
      await goesThrough((address) => open(browser, address), await studio("--replay", recording), check);
      await drops((address) => open(browser, address), programs, visloc, recording, check);
      await screens(browser);
    }
    check(errors.length === 0, `no error on the console ${errors.join("; ")}`);
  } finally {
    await browser.close();
    programs.end();
  }
}

main().catch((error) => {
  console.error(`FAILED: ${error.message}`);
  process.exitCode = 1;
});
