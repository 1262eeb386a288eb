// The pictures of the documents.
//
//     node pictures.mjs PATH_TO_VISLOC FOLDER_FOR_PICTURES [ONE_OF_THEM]
//
// Needs playwright-core and Chromium, as run.mjs.

import { execFileSync } from "node:child_process";
import { join } from "node:path";
import { chromium } from "playwright-core";

import { SCREENS } from "./screens.mjs";
import { firstMap, firstVisit } from "./visit.mjs";
import { BROWSER, Programs, open as openPage, send, until } from "./visloc.mjs";

const [visloc, folder, only] = process.argv.slice(2);
const programs = new Programs(visloc);
const errors = [];

const localized = (page) => until(page, () => window.studio.store.state.contenders?.every((c) => c.is_localized));

/** A picture of a page that shows whole images; a busy machine may take a while for that. */
async function picture(page, name, more = {}) {
  await until(page, () => {
    const { drawn, bitmap } = window.studio.image;
    return bitmap && bitmap.width === drawn.header.size_px[0];
  });
  await page.screenshot({ path: join(folder, name), ...more });
  await page.context().close();
}

/** A kidnap on a phone. */
async function phone(open) {
  const page = await open(await programs.studio(), SCREENS["390x844"]);
  const shot = (number) => page.screenshot({ path: join(folder, `studio-phone-${number}.jpg`), type: "jpeg", quality: 80 });
  await localized(page);
  await page.waitForTimeout(5000);
  await shot(1);
  await page.tap("#kidnap");
  await until(page, () => window.studio.store.state.contenders.every((c) => !c.is_localized));
  await page.waitForTimeout(600);
  await shot(2);
  await until(page, () => !window.studio.store.state.controls.is_held);
  await page.tap("#tab-algorithms");
  await page.fill("input[type=search]", "num");
  await page.waitForTimeout(500);
  await page.evaluate(() => scrollTo(0, document.querySelector(".tabs").getBoundingClientRect().top - document.querySelector(".stage").getBoundingClientRect().bottom - 8));
  await page.waitForTimeout(500);
  await shot(3);
  await page.context().close();
}

async function field(open) {
  const page = await open(await programs.studio());
  await localized(page);
  await page.waitForTimeout(9000);
  // The plots tell of a kidnap.
  await page.click("#kidnap");
  await until(page, () => window.studio.store.state.contenders.every((c) => !c.is_localized));
  await until(page, () => !window.studio.store.state.controls.is_held);
  await localized(page);
  await page.waitForTimeout(4000);
  await send(page, "pause");
  await page.waitForTimeout(1500);
  await picture(page, "studio-field.png");
}

async function office(open) {
  const page = await open(await programs.studio("--scene", "office"), { colorScheme: "light" });
  await localized(page);
  await page.click("#tab-algorithms");
  await page.waitForTimeout(6000);
  await send(page, "pause");
  await page.waitForTimeout(1500);
  await picture(page, "studio-office.png");
}

async function recording(open) {
  const file = join(programs.folder, "kidnaps.mcap");
  execFileSync(visloc, ["localize", "sim:kidnaps", "--frames", "1000", "--record", file], { stdio: "ignore" });
  const address = await programs.studio("--replay", file);
  const replay = await open(address);
  await send(replay, "seek", { frame: 690 });
  await until(replay, () => window.studio.store.state.number === 690);
  await replay.click("#tab-facts");
  await replay.waitForTimeout(1500);
  await picture(replay, "studio-replay.png");
  const page = await open(address, { colorScheme: "light" });
  await page.click("#tab-algorithms");
  await page.selectOption("#panel-algorithms .lane select", "mc");
  await until(page, () => window.studio.store.scene.contenders[0].name === "mc");
  await page.locator("[data-path=num_particles]").fill("60");
  await page.locator("[data-path=num_particles]").press("Enter");
  await until(page, () => document.querySelector(".parameter.is-changed"));
  await page.click("#recompute");
  await until(page, () => window.studio.store.scene.recording.is_recomputed);
  await send(page, "seek", { frame: 790 });
  await until(page, () => window.studio.store.state.number === 790);
  await page.waitForTimeout(1500);
  await picture(page, "studio-recomputed.png");
}

async function connected(open) {
  const address = await programs.start(/--connect (\S+)/, "localize", "sim:kidnaps", "--publish", "127.0.0.1:0", "--token", "secret");
  const page = await open(await programs.studio("--connect", address, "--token", "secret"));
  await localized(page);
  await page.click("#tab-algorithms");
  await page.click("#record");
  await page.waitForTimeout(4000);
  await page.click("#save");
  await page.waitForTimeout(700);
  await send(page, "pause");
  await page.waitForTimeout(1000);
  await picture(page, "studio-connected.png");
}

async function slam(open) {
  const page = await open(await programs.studio("--scene", "sim:room"));
  await until(page, () => window.studio.store.state.number > 190);
  await page.click("#kidnap");
  await until(page, () => window.studio.store.state.controls.is_held && window.studio.store.state.is_lost);
  await until(page, () => !window.studio.store.state.controls.is_held && !window.studio.store.state.is_lost);
  await page.click("#tab-algorithms");
  await page.waitForTimeout(2500);
  await send(page, "pause");
  await page.waitForTimeout(1000);
  await picture(page, "studio-slam.jpg", { type: "jpeg", quality: 85 });
}

/** A team of which one says that it is elsewhere. */
async function team(open) {
  const page = await open(await programs.studio("sim:team"), { viewport: { width: 1280, height: 870 } });
  await until(page, () => window.studio.store.state.team?.robots.every(({ knows }) => knows === "half"));
  await page.selectOption(".team-head select >> nth=1", "elsewhere");
  await page.getByRole("button", { name: "Liar: robot 4", exact: true }).click();
  await until(page, () => window.studio.store.state.team.robots[0].mates.some(({ number, trust }) => number === 4 && trust < 0.1));
  await until(page, () => window.studio.store.state.team.robots.every(({ knows }) => knows === "half"));
  await send(page, "pause");
  await page.waitForTimeout(1500);
  await picture(page, "studio-team.jpg", { type: "jpeg", quality: 80 });
}

const browser = await chromium.launch(BROWSER);
try {
  const open = (url, options) => openPage(browser, url, errors, options);
  const told = (isTrue, text) => { if (!isTrue) throw new Error(text); };
  const firstMinute = () => firstVisit(browser, programs, errors, told, folder);
  const building = () => firstMap(browser, programs, errors, told, folder);
  const tasks = { firstMinute, building, phone, field, office, recording, connected, slam, team };
  for (const [name, task] of Object.entries(tasks)) if (!only || name === only) await task(open);
  if (errors.length > 0) throw new Error(errors.join("; "));
} finally {
  await browser.close();
  programs.end();
}
