// A robot elsewhere is driven by keys, and stands when nobody holds one or the link is lost.

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
