// A team of robots: chosen on the page, with a link that is cut, a liar, a kidnap, and another robot's image.

import { join } from "node:path";

import { state, until } from "./visloc.mjs";

const know = (page, numbers) => until(page, (all) => {
  const robots = window.studio.store.state.team?.robots ?? [];
  return robots.length > 0 && robots.every(({ number, knows }) => !all.includes(number) || knows === "half");
}, numbers, 120000);
const button = (page, name) => page.getByRole("button", { name, exact: true });
const robot = async (page, number) => (await state(page)).team.robots[number - 1];

export async function team(open, phone, check, pictures) {
  const page = await open();
  await page.selectOption("#scene", "sim:team");
  await know(page, [1, 2, 3, 4]);
  const helped = [2, 3, 4].map(async (number) => (await robot(page, number)).by);
  check((await Promise.all(helped)).every((by) => by === 1), "one that knows its half decides for its team");
  check(await page.locator(".team-row").count() === 4 && await page.locator(".card").count() === 0, "each robot has a row");
  if (pictures) await page.screenshot({ path: join(pictures, "team.png") });

  await button(page, "Cut link of robot 3").click();
  await until(page, () => window.studio.store.state.team.robots.every(({ number, mates }) => (
    number === 3 ? mates.length === 0 : mates.every((mate) => mate.number !== 3))));
  const cut = await page.locator(".team-row").nth(2).textContent();
  check(/link cut/.test(cut) && /hears nobody/.test(cut) && /0.00 kB/.test(cut), `a cut link is told: ${cut}`);
  await button(page, "Cut link of robot 3").press("Enter");
  await until(page, () => window.studio.store.state.team.robots[2].mates.length === 3);
  check(await button(page, "Cut link of robot 3").getAttribute("aria-pressed") === "false", "a key restores it");

  await page.selectOption(".team-head select >> nth=1", "elsewhere");
  await button(page, "Liar: robot 4").click();
  await until(page, () => window.studio.store.state.team.robots[0].mates.find(({ number }) => number === 4)?.trust < 0.3, null, 120000);
  check(/lies: elsewhere/.test(await page.locator(".team-row").nth(3).textContent()), "one that says it is elsewhere loses trust");
  await know(page, [1, 2, 3]);
  check(true, "and drags nobody");
  await button(page, "Liar: robot 4").click();

  await button(page, "Kidnap robot 2").click();
  await until(page, () => window.studio.store.state.team.robots[1].height_m > 0);
  await until(page, () => window.studio.store.state.team.robots[1].height_m === 0);
  await know(page, [1, 2, 3]);
  check(true, "a kidnapped robot finds itself again");
  await button(page, "Robot 2: show its image").click();
  await until(page, () => window.studio.store.state.team.look === 1);
  await page.click("[data-view=top]");
  await page.waitForTimeout(400);
  const at = await page.evaluate(() => {
    const [x, y] = window.studio.store.state.team.robots[0].truth;
    const m = window.studio.view.camera.clipFromWorld();
    const w = m[3] * x + m[7] * y + m[15];
    const box = document.querySelector("#world").getBoundingClientRect();
    return [box.left + ((m[0] * x + m[4] * y + m[12]) / w + 1) * box.width / 2, box.top + (1 - (m[1] * x + m[5] * y + m[13]) / w) * box.height / 2];
  });
  await page.mouse.click(...at);
  await until(page, () => window.studio.store.state.team.look === 0);
  check(true, "a click on a robot shows its image");
  await page.context().close();

  const small = await open(phone);
  await small.tap("text=Cut link >> nth=1");
  await until(small, () => !window.studio.store.state.team.robots[1].is_linked);
  check(true, "on a phone a tap cuts a link");
  await small.selectOption("#scene", "robocup-2010");
  await until(small, () => window.studio.store.scene.mode === "playground" && document.querySelectorAll(".card").length === 2);
  check(await small.locator("#panel-drive").isVisible(), "and there is a way back to one robot");
  await small.context().close();
}
