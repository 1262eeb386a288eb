// The camera by hand: the map is laid over the image of the studio, and a camera that was turned is put right by dragging corners.

import { SCREENS, axeOf } from "./screens.mjs";
import { until } from "./visloc.mjs";

const TURNED_DEG = 3;

async function opened(open, options) {
  const page = await open(options);
  await until(page, () => window.studio.store.state.contenders?.[0].is_localized && window.studio.store.state.contenders[0].error?.[0] < 0.05 && window.studio.store.state.lens);
  await page.keyboard.press("Space");
  // The image may come after the state; until then there is nothing to lay a map over.
  await until(page, () => !document.getElementById("by-hand").hidden);
  const [hand] = await Promise.all([page.waitForEvent("popup"), page.keyboard.press("j")]);
  await hand.waitForFunction(() => window.byHand && document.getElementById("edges").textContent.includes("px"));
  return { page, hand };
}

export async function byHand(open, check, pictures) {
  const { page, hand } = await opened(open);
  const distance = await hand.textContent("#edges");
  // The robot's kinematics are off by some tenths of a degree.
  check(Number.parseFloat(distance) < 5, `the map lies on the image of the studio: ${distance}`);

  const pitch = () => hand.evaluate(() => window.byHand.parameters.find((p) => p.name === "pitch").value);
  const right = await pitch();
  const corners = await hand.evaluate((turned) => {
    const { parameters, corners, project } = window.byHand;
    const { width, height } = document.getElementById("view");
    const seen = corners.map((corner, i) => ({ i, real: project(corner) })).filter(({ real }) => real && real[0] > 8 && real[1] > 8);
    const number = document.getElementById("number-pitch");
    number.value = parameters.find((p) => p.name === "pitch").value + turned;
    number.dispatchEvent(new Event("input"));
    const isInside = ([x, y]) => x > 8 && y > 8 && x < width - 8 && y < height - 8;
    return seen.filter(({ i, real }) => isInside(window.byHand.toCanvas(real)) && isInside(window.byHand.toCanvas(project(corners[i])))).slice(0, 4);
  }, TURNED_DEG);
  check(corners.length >= 2, `${corners.length} corners of the map are in the image`);
  const turned = await pitch();
  const onScreen = (px) => hand.evaluate((px) => {
    const canvas = document.getElementById("view"), box = canvas.getBoundingClientRect(), [x, y] = window.byHand.toCanvas(px);
    return [box.left + x * box.width / canvas.width, box.top + y * box.height / canvas.height];
  }, px);
  for (const { i, real } of corners) {
    const from = await hand.evaluate((i) => window.byHand.project(window.byHand.corners[i]), i);
    await hand.mouse.move(...await onScreen(from));
    await hand.mouse.down();
    await hand.mouse.move(...await onScreen(real), { steps: 8 });
    await hand.mouse.up();
  }
  const after = await pitch();
  check(Math.abs(after - right) < 0.5, `a camera turned by ${TURNED_DEG} degrees is put right with ${corners.length} drags: pitch ${turned.toFixed(1)} to ${after.toFixed(1)}, right is ${right.toFixed(1)}`);
  const [download] = await Promise.all([hand.waitForEvent("download"), hand.click("#save")]);
  check(download.suggestedFilename() === "camera.toml", "and saved as camera.toml");
  if (pictures) await hand.screenshot({ path: `${pictures}/by-hand.png` });
  await page.context().close();

  // Axe's script is none of the page's.
  const phone = await opened(open, { ...SCREENS["390x844"], bypassCSP: true });
  const faults = await axeOf(phone.hand);
  const isWide = await phone.hand.evaluate(() => document.documentElement.scrollWidth > innerWidth);
  check(!isWide && faults.length === 0, `the page by hand fits on a phone, and axe finds nothing serious ${faults.join("\n")}`);
  if (pictures) await phone.hand.screenshot({ path: `${pictures}/by-hand-phone.png` });
  await phone.page.context().close();
}
