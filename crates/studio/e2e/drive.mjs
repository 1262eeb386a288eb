// A robot elsewhere is driven by keys, and stands when nobody holds one or the link is lost.

import { execFileSync } from "node:child_process";
import { join } from "node:path";

import { RawPage } from "./raw_page.mjs";
import { open as openPage, until } from "./visloc.mjs";

const SPEED = 0.25;
/** The robot stands within this time; beside it the way of a state to the one who looks on. */
const MOST_SECS = 0.5;
const ON_THE_WAY_SECS = 0.1;

const sleep = (secs) => new Promise((resolve) => { setTimeout(resolve, 1000 * secs); });
const way = (a, b) => Math.hypot(a[0] - b[0], a[1] - b[1]);

/** Seconds from a moment until the robot stood, as somebody saw it who looks at the robot itself. */
async function standsAfter(near, at) {
  await sleep(1.5);
  const moves = near.updates.filter(({ pose }, i, all) => i > 0 && way(pose, all[i - 1].pose) > 1e-6);
  return Math.max(0, moves[moves.length - 1].at - at);
}

const nowSecs = () => performance.now() / 1000;
const stands = (check, secs, when) => check(secs < MOST_SECS + ON_THE_WAY_SECS, `${when}, it stands after ${secs.toFixed(2)} s`);

/** Drives by a key of a desk's page, lets go, loses the desk, and meets another driver. */
export async function drives(browser, programs, errors, check, pictures) {
  const run = ["localize", "sim:robocup", "--publish", "127.0.0.1:0", "--allow-drive", "--max-speed", String(SPEED)];
  const [address, token] = (await programs.start(/--connect (.*)/, ...run)).split(" --token ");
  const near = await RawPage.open(`http://${address}/?token=${token}`);
  const desk = await programs.studio("--connect", address, "--token", token);
  const page = await openPage(browser, desk, errors);
  await until(page, () => window.studio.store.latest.drive && window.studio.store.state.contenders?.[0]?.is_localized);
  check(await page.locator("#panel-drive .pad").isVisible() && await page.locator("#driver").isVisible(), "a robot elsewhere that may be driven has a pad");
  const at = near.latest;
  await page.keyboard.down("w");
  await until(page, () => window.studio.store.latest.drive.is_driven);
  await sleep(2);
  const told = await page.locator("#driver").textContent();
  if (pictures) await page.screenshot({ path: join(pictures, "driven.png") });
  const then = near.latest;
  check(way(then.pose, at.pose) > 0.25, `W drives it: ${way(then.pose, at.pose).toFixed(2)} m`);
  const fastest = Math.max(...near.updates.slice(1).map(({ pose, secs }, i) => way(pose, near.updates[i].pose) / Math.max(secs - near.updates[i].secs, 1e-9)));
  check(fastest < 1.01 * SPEED, `no faster than it may: ${fastest.toFixed(3)} m/s`);
  check(/drives, what they see is 0\.\d\d s old/.test(told), `who drives and the lag are told: ${told}`);
  // Somebody else wants to drive meanwhile.
  near.send(JSON.stringify({ type: "drive", forward: -1, left: 0, turn: 0, seen_secs: near.latest.drive.secs }));
  await sleep(0.5);
  const refused = near.texts.find(({ type }) => type === "refused")?.reason;
  check(refused?.includes(`${near.latest.drive.driver} drives`), `a second driver is refused: ${refused}`);
  await page.keyboard.up("w");
  stands(check, await standsAfter(near, nowSecs()), "when the key is let go");
  await page.keyboard.down("d");
  await until(page, () => window.studio.store.latest.drive.is_driven);
  await page.keyboard.up("d");
  await page.keyboard.down("w");
  await sleep(1);
  programs.stall(true);
  stands(check, await standsAfter(near, nowSecs()), "when the desk hangs");
  programs.stall(false);
  await page.keyboard.up("w");
  await until(page, () => document.querySelector("#link").textContent === "live");
  await page.locator("[aria-label='Head to the left']").fill("40");
  await until(page, () => Math.abs((window.studio.store.latest.drive.head_deg?.[0] ?? 0) - 40) < 1e-6);
  check(true, "the head is turned");
  const isStill = near.latest.pose;
  await page.keyboard.down("s");
  await until(page, () => window.studio.store.latest.drive.is_driven);
  await sleep(1);
  const leftAt = nowSecs();
  await page.context().close();
  stands(check, await standsAfter(near, leftAt), "when the page is closed");
  check(way(near.latest.pose, isStill) > 0.05 && near.latest.drive.driver === null, "and nobody is at the wheel");
  near.close();
}

/** A desk's page of a robot that runs with these arguments and may be driven. */
async function deskOf(browser, programs, errors, ...run) {
  const [address, token] = (await programs.start(/--connect (.*)/, ...run, "--publish", "127.0.0.1:0", "--allow-drive")).split(" --token ");
  const page = await openPage(browser, await programs.studio("--connect", address, "--token", token), errors);
  await until(page, () => window.studio.store.latest.drive);
  // The rest of the scene, by which the page knows its tabs, may come after the first state.
  await page.locator("#panel-drive .pad").waitFor();
  await page.locator("#world").focus();
  return page;
}

async function turnsHead(page, deg) {
  await page.locator("[aria-label='Head to the left']").fill(String(deg));
  await until(page, (left) => window.studio.store.latest.drive.head_deg?.[0] === left, deg);
}

/** Holds W until something is true, and lets go. */
async function drivesUntil(page, condition, argument) {
  await page.keyboard.down("w");
  await until(page, () => window.studio.store.latest.drive.is_driven);
  await until(page, condition, argument);
  await page.keyboard.up("w");
  await until(page, () => !window.studio.store.latest.drive.is_driven);
}

/** Drives a robot that is localized in a map of SLAM, and one without a map. */
export async function drivesBySlam(browser, programs, errors, check) {
  const map = join(programs.folder, "walk.vmap");
  execFileSync(programs.visloc, ["slam", "sim:office-walk", "--end", "20s", "--save", map], { stdio: "ignore" });
  let page = await deskOf(browser, programs, errors, "localize", "sim:office-walk", "--map", map);
  check(await page.locator("#panel-drive .pad").isVisible(), "a robot in a map of SLAM has a pad");
  // It looks where it goes: a head that turns sees walls that the map hardly shows.
  await turnsHead(page, 0);
  await page.locator("#world").focus();
  await drivesUntil(page, () => {
    const { trajectory: ways = [] } = window.studio.store.arrays;
    return ways.length >= 6 && Math.hypot(...[1, 2, 3].map((i) => ways[ways.length - i] - ways[3 - i])) > 0.3;
  });
  check(true, "W drives it by 0.3 m of that map, and it stands when the key is let go");
  await page.context().close();
  page = await deskOf(browser, programs, errors, "slam", "sim:office-walk");
  check(await page.locator("#panel-drive .pad").isVisible(), "and so has one that is followed without a map");
  await turnsHead(page, 40);
  // Without a map yet, the image says whether the robot moves.
  await page.evaluate(() => {
    window.look = () => {
      const context = new OffscreenCanvas(64, 48).getContext("2d");
      context.drawImage(window.studio.image.bitmap, 0, 0, 64, 48);
      return context.getImageData(0, 0, 64, 48).data;
    };
    window.differs = (a, b) => a.reduce((sum, value, i) => sum + Math.abs(value - b[i]), 0) / a.length;
  });
  await sleep(2);
  const noise = await page.evaluate(async () => {
    window.before = window.look();
    await new Promise((resolve) => { setTimeout(resolve, 1000); });
    return window.differs(window.before, window.look());
  });
  await page.locator("#world").focus();
  await drivesUntil(page, (least) => window.differs(window.before, window.look()) > least, 4 * noise + 2);
  check(true, `W drives it: its image differs by more than four times of what it did while it stood (${noise.toFixed(2)})`);
  await page.context().close();
}
