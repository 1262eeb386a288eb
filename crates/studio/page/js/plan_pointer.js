// Mouse and fingers on a plan: a click or tap, a drag that moves the view, a wheel or two fingers that zoom.

/** What moves less is a click, pixels. */
const CLICK_PX = 7;
/** What counts as near, pixels: fingers are thicker. */
const REACH_PX = { mouse: 14, pen: 14, touch: 24 };

const middle = ([a, b]) => [(a[0] + b[0]) / 2, (a[1] + b[1]) / 2];
const span = ([a, b]) => Math.max(Math.hypot(a[0] - b[0], a[1] - b[1]), 1);

export class PlanPointer {
  /** `on` has `point(at, reach)`, `press(at, reach)` with places of the plan, `moved()` when the view has, and `left()`. */
  constructor(canvas, view, on) {
    Object.assign(this, { canvas, view, on });
    this.down = new Map();
    canvas.onpointerdown = (event) => this.press(event);
    canvas.onpointermove = (event) => this.move(event);
    canvas.onpointerup = (event) => this.lift(event, true);
    canvas.onpointercancel = (event) => this.lift(event, false);
    canvas.onpointerleave = (event) => event.pointerType === "mouse" && this.down.size === 0 && on.left();
    canvas.oncontextmenu = (event) => event.preventDefault();
    canvas.addEventListener("wheel", (event) => this.wheel(event), { passive: false });
  }

  placeOf({ clientX, clientY }) {
    const { left, top } = this.canvas.getBoundingClientRect();
    return [clientX - left, clientY - top];
  }

  reachOf({ pointerType }) {
    return this.view.reach(REACH_PX[pointerType] ?? REACH_PX.mouse);
  }

  press(event) {
    this.canvas.setPointerCapture(event.pointerId);
    const at = this.placeOf(event);
    this.down.set(event.pointerId, { from: at, at });
    if (this.down.size > 1) this.isDrag = true;
  }

  move(event) {
    const at = this.placeOf(event);
    const finger = this.down.get(event.pointerId);
    if (!finger) {
      this.on.point(this.view.toPlan(at), this.reachOf(event));
      return;
    }
    if (Math.hypot(at[0] - finger.from[0], at[1] - finger.from[1]) > CLICK_PX) this.isDrag = true;
    const before = [...this.down.values()].map((one) => one.at);
    const was = finger.at;
    finger.at = at;
    if (!this.isDrag) return;
    if (before.length === 1) this.view.pan(at[0] - was[0], at[1] - was[1]);
    else {
      const now = [...this.down.values()].map((one) => one.at);
      const [from, to] = [middle(before), middle(now)];
      this.view.pan(to[0] - from[0], to[1] - from[1]);
      this.view.zoom(span(now) / span(before), to);
    }
    this.on.moved();
  }

  lift(event, isClick) {
    const finger = this.down.get(event.pointerId);
    this.down.delete(event.pointerId);
    if (!finger) return;
    if (isClick && !this.isDrag) this.on.press(this.view.toPlan(finger.at), this.reachOf(event));
    if (this.down.size === 0) this.isDrag = false;
  }

  wheel(event) {
    event.preventDefault();
    this.view.zoom(Math.exp(-event.deltaY * 0.0015), this.placeOf(event));
    this.on.moved();
  }
}
