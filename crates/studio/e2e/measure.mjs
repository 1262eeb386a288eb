// Frames a second and the time from a click to the picture; only with MEASURE=1, since it is never asserted.

const SECONDS = 8;
const CLICKS = 20;

export async function measure(page, send, until) {
  const names = await page.evaluate(() => window.studio.store.state.contenders.map(({ name }) => name));
  await send(page, "algorithms", { names: ["mc"] });
  await send(page, "parameter", { algorithm: 0, path: "num_particles", value: 2000 });
  await until(page, () => window.studio.store.state.contenders[0].num_individuals === 2000);
  const rates = await page.evaluate(async (seconds) => {
    const { store, view } = window.studio;
    const start = store.state.number;
    let [states, images, drawn] = [0, 0, 0];
    store.on("state", () => { states += 1; });
    store.on("image", () => { images += 1; });
    const draw = view.draw;
    view.draw = () => {
      drawn += Number(view.isDirty);
      draw.call(view);
    };
    await new Promise((resolve) => setTimeout(resolve, 1000 * seconds));
    view.draw = draw;
    return { simulated: store.state.number - start, states, images, drawn };
  }, SECONDS);
  const perSecond = Object.entries(rates).map(([name, count]) => `${name} ${(count / SECONDS).toFixed(1)}`);
  console.log(`measured with 2000 particles and the image, a second: ${perSecond.join(", ")}`);
  const times = await page.evaluate(async (clicks) => {
    const { store, view } = window.studio;
    const all = [];
    for (let i = 0; i < clicks; i += 1) {
      await new Promise((resolve) => setTimeout(resolve, 150 + 37 * (i % 5)));
      const before = store.state.controls.is_held;
      const start = performance.now();
      document.querySelector("#lift").click();
      await new Promise((resolve) => {
        const draw = view.draw;
        view.draw = () => {
          draw.call(view);
          if (store.state.controls.is_held === before) return;
          view.draw = draw;
          // The browser shows what has just been drawn and then asks for the next picture.
          requestAnimationFrame(resolve);
        };
      });
      all.push(performance.now() - start);
    }
    return all.sort((a, b) => a - b);
  }, CLICKS);
  await send(page, "algorithms", { names });
  await until(page, (count) => window.studio.store.state.contenders.length === count, names.length);
  console.log(`measured from click to picture, ms: median ${times[CLICKS / 2].toFixed(1)}, most ${times[CLICKS - 1].toFixed(1)}`);
}
