// Links to a moment of a recording: `#recording=kidnaps.mcap&frame=690`.

/** What stands behind the address of a page that shows what this one shows. */
export function linkTo({ scene, state }) {
  const label = scene.scenes.find(({ id }) => id === scene.scene)?.label ?? scene.scene;
  return `${location.pathname}${location.search}#${new URLSearchParams({ recording: label, frame: state.number })}`;
}

/** Goes where the page's address leads, once the studio has said what there is to see. */
export function followLink(store, socket) {
  const wanted = new URLSearchParams(location.hash.slice(1));
  let label = wanted.get("recording");
  const frame = Number(wanted.get("frame") ?? 0);
  let hasAsked = false;
  store.on("scene", () => {
    if (label === null || store.scene.is_brief) return;
    const entry = store.scene.scenes.find((scene) => scene.label === label);
    if (entry?.id === store.scene.scene) {
      label = null;
      if (Number.isInteger(frame) && frame >= 0) socket.send("seek", { frame });
    } else if (entry && !hasAsked) {
      hasAsked = true;
      socket.send("open", { scene: entry.id });
    }
  });
}
