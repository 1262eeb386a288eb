// The world on its canvas: draws it, and turns pointers into commands.

import { Actors, ARROW_M } from "./actors.js";
import { OrbitCamera } from "./camera3d.js";
import { CanvasRenderer } from "./renderer_canvas.js";
import { WebGlRenderer } from "./renderer_webgl.js";
import { SpaceActors } from "./space_actors.js";
import { TeamActors } from "./team_actors.js";
import { onTheme, rgba } from "./theme.js";
import { worldMeshes } from "./world_mesh.js";

/** So near to the robot or its arrow a pointer grabs it, meters. */
const GRAB_M = 0.3;
/** A pointer that moves less than this is a click, pixels. */
const CLICK_PX = 5;
/** A finger is less sure, pixels. */
const TAP_PX = 12;
/** A finger covers so much of the ground that it may miss the robot by this, pixels. */
const FINGER_PX = 26;
/** A key zooms by this factor. */
const ZOOM_STEP = 1.25;
/** Most pixels of the world without a graphics card. */
const MAX_SOFTWARE_PIXELS = 2.5e6;

/** Pixels that are drawn for each of the layout: software draws no more of them than a large window has. */
function pixelRatio({ clientWidth, clientHeight, dataset }) {
  const most = dataset.renderer === "2D" ? Math.sqrt(MAX_SOFTWARE_PIXELS / Math.max(clientWidth * clientHeight, 1)) : 2;
  return Math.min(devicePixelRatio, 2, most);
}

const distance = (place, to) => (place ? Math.hypot(place[0] - to[0], place[1] - to[1]) : Infinity);

export class View3d {
  /** `requestDraw` has this view drawn in the next frame. */
  constructor(canvas, store, socket, requestDraw) {
    Object.assign(this, { canvas, store, socket, requestDraw });
    // ?renderer=webgl and ?renderer=2d choose one.
    const wanted = new URLSearchParams(location.search).get("renderer");
    const webgl = wanted === "2d" ? null : WebGlRenderer.create(canvas, wanted === "webgl");
    this.renderer = webgl ?? new CanvasRenderer(canvas);
    canvas.dataset.renderer = this.renderer.name;
    this.camera = new OrbitCamera();
    this.robotActors = new Actors();
    this.spaceActors = new SpaceActors();
    this.teamActors = new TeamActors();
    this.view = "slant";
    this.pointers = new Map();
    this.grab = null;
    this.meshes = worldMeshes(null);
    this.touch();
    store.on("state", () => this.touch());
    store.on("scene", () => this.newScene());
    onTheme(() => this.rebuild());
    new ResizeObserver(() => this.resize()).observe(canvas);
    this.listen();
  }

  /** There is something new to draw. */
  touch() {
    this.isDirty = true;
    this.requestDraw();
  }

  newScene() {
    const key = JSON.stringify(this.store.scene.world);
    if (key === this.worldKey) return;
    this.worldKey = key;
    this.rebuild();
    this.setView(this.view === "follow" ? "slant" : this.view);
    const what = { playground: "arrows drive the robot, X aims at a place", replay: "arrows step through the recording" }[this.store.scene.mode];
    this.canvas.setAttribute("aria-label", `World in 3D${what ? `: ${what}` : ""}; ? tells all keys`);
  }

  rebuild() {
    this.touch();
    this.meshes = worldMeshes(this.store.scene?.world);
  }

  setView(view) {
    this.view = view;
    this.touch();
    const bounds = this.store.scene?.world?.bounds_m;
    if (bounds) this.camera.fit(bounds, view);
    if (view === "follow") this.camera.distance = 3.2;
  }

  resize() {
    const ratio = pixelRatio(this.canvas);
    const { clientWidth, clientHeight } = this.canvas;
    const size = [clientWidth, clientHeight].map((value) => Math.max(1, Math.round(value * ratio)));
    if (size[0] === this.canvas.width && size[1] === this.canvas.height) return;
    [this.canvas.width, this.canvas.height] = size;
    this.touch();
    const before = this.camera.aspect;
    this.camera.aspect = this.canvas.width / this.canvas.height;
    if (Math.abs(before - this.camera.aspect) > 0.05 && this.view !== "follow") this.setView(this.view);
  }

  /** Draws, if there is anything new. */
  draw() {
    if (!this.isDirty) return;
    this.isDirty = false;
    const { state, scene } = this.store;
    const isSpace = scene?.world?.kind === "space";
    const actors = isSpace ? this.spaceActors : state?.team ? this.teamActors : this.robotActors;
    const metersPerPixel = this.camera.metersPerPixel(this.canvas.clientHeight);
    actors.build(this.store, this.grab?.pose, { azimuth: this.camera.azimuth, metersPerPixel });
    const pose = state?.truth?.pose ?? state?.contenders?.[0]?.pose;
    if (this.view === "follow" && pose) {
      this.camera.target = [pose[0], pose[1], 0.2];
      this.camera.azimuth = pose[2] + Math.PI;
    }
    const layers = [
      { mesh: this.meshes.ground },
      { mesh: actors.flat, isFlat: true },
      { mesh: this.meshes.upright },
      { mesh: actors.upright },
    ];
    this.renderer.draw(this.camera.clipFromWorld(), rgba("surface"), layers.concat(actors.layers ?? []));
  }

  listen() {
    const { canvas } = this;
    canvas.addEventListener("pointerdown", (event) => this.down(event));
    canvas.addEventListener("pointermove", (event) => this.move(event));
    for (const end of ["pointerup", "pointercancel"]) canvas.addEventListener(end, (event) => this.up(event));
    canvas.addEventListener("contextmenu", (event) => event.preventDefault());
    canvas.addEventListener("webglcontextrestored", () => this.touch());
    canvas.addEventListener("wheel", (event) => {
      event.preventDefault();
      this.camera.zoom(Math.exp(event.deltaY * 0.001));
      this.touch();
    }, { passive: false });
  }

  /** Takes a key; tells whether it moves the view. */
  key({ key, code, shiftKey }) {
    const { camera } = this;
    const height = this.canvas.clientHeight;
    const pan = shiftKey && { ArrowLeft: [1, 0], ArrowRight: [-1, 0], ArrowUp: [0, 1], ArrowDown: [0, -1] }[code];
    const orbit = { "[": [40, 0], "]": [-40, 0], PageUp: [0, 30], PageDown: [0, -30] }[key];
    const zoom = { "+": 1 / ZOOM_STEP, "-": ZOOM_STEP }[key];
    if (pan && this.store.scene?.mode !== "replay") camera.pan(0.08 * height * pan[0], 0.08 * height * pan[1], height);
    else if (orbit) camera.orbit(...orbit);
    else if (zoom) camera.zoom(zoom);
    else if (key === "Home") this.setView(this.view);
    else return false;
    this.touch();
    return true;
  }

  /** The point of the ground under a pointer. */
  ground(event, height = 0) {
    const box = this.canvas.getBoundingClientRect();
    const x = (event.clientX - box.left) / box.width * 2 - 1;
    const y = 1 - (event.clientY - box.top) / box.height * 2;
    return this.camera.ground(x, y, height);
  }

  /** What of the robot is under a pointer: its body, its arrow, or nothing. */
  under(event) {
    const pose = this.store.latest?.truth?.pose;
    if (!pose || this.store.isBack || this.store.scene.mode !== "playground") return null;
    const tip = [pose[0] + ARROW_M * Math.cos(pose[2]), pose[1] + ARROW_M * Math.sin(pose[2])];
    const onFloor = this.ground(event);
    const body = Math.min(distance(onFloor, pose), distance(this.ground(event, 0.3), pose));
    const fingerM = this.fingerM(event);
    if (distance(onFloor, tip) < Math.min(Math.max(0.14, 0.7 * fingerM), body)) return "arrow";
    return body < Math.max(GRAB_M, fingerM) ? "body" : null;
  }

  /** So far a finger may miss, meters. */
  fingerM({ pointerType }) {
    return pointerType === "touch" ? FINGER_PX * this.camera.metersPerPixel(this.canvas.clientHeight) : 0;
  }

  /** The robot of a team that is under a pointer. */
  teammate(event) {
    const places = [this.ground(event), this.ground(event, 0.3)];
    const off = ({ truth }) => (truth ? Math.min(...places.map((place) => distance(place, truth))) : Infinity);
    const nearest = this.store.latest.team.robots.reduce((a, b) => (off(b) < off(a) ? b : a));
    return off(nearest) < Math.max(GRAB_M, this.fingerM(event)) ? nearest : null;
  }

  down(event) {
    this.canvas.focus({ preventScroll: true });
    this.canvas.setPointerCapture(event.pointerId);
    this.pointers.set(event.pointerId, { x: event.clientX, y: event.clientY });
    this.moved = 0;
    this.clickPx = event.pointerType === "touch" ? TAP_PX : CLICK_PX;
    if (this.pointers.size === 2 && this.grab && !this.grab.hasMoved) this.grab = null;
    const part = this.pointers.size === 1 && event.button === 0 && !event.shiftKey ? this.under(event) : null;
    if (part) this.grab = { part, pose: [...this.store.latest.truth.pose], hasMoved: false };
    this.canvas.dataset.over = part ? "robot" : "drag";
  }

  move(event) {
    const last = this.pointers.get(event.pointerId);
    if (!last) {
      this.canvas.dataset.over = this.under(event) ? "robot" : "";
      return;
    }
    const [dx, dy] = [event.clientX - last.x, event.clientY - last.y];
    this.moved += Math.hypot(dx, dy);
    this.touch();
    if (this.grab) {
      this.drag(event);
    } else if (this.pointers.size === 2) {
      this.pinch(event, dx, dy);
    } else if (this.moved > this.clickPx) {
      if (event.buttons & 2 || event.shiftKey) this.camera.pan(dx, dy, this.canvas.clientHeight);
      else if (this.view !== "top") this.camera.orbit(dx, dy);
      else this.camera.pan(dx, dy, this.canvas.clientHeight);
    }
    this.pointers.set(event.pointerId, { x: event.clientX, y: event.clientY });
  }

  /** Hands hold the robot over the pointer. */
  drag(event) {
    const { grab } = this;
    if (!grab.hasMoved && this.moved <= this.clickPx) return;
    grab.hasMoved = true;
    const place = this.ground(event);
    if (!place) return;
    if (grab.part === "arrow") grab.pose[2] = Math.atan2(place[1] - grab.pose[1], place[0] - grab.pose[0]);
    else [grab.pose[0], grab.pose[1]] = place;
    const [x_m, y_m, yaw_rad] = grab.pose;
    this.socket.send("carry", { x_m, y_m, yaw_rad });
  }

  pinch(event, dx, dy) {
    const [a, b] = [...this.pointers.entries()].sort(([id]) => (id === event.pointerId ? -1 : 1)).map(([, p]) => p);
    const before = Math.hypot(a.x - b.x, a.y - b.y);
    const after = Math.hypot(event.clientX - b.x, event.clientY - b.y);
    if (before > 0 && after > 0) this.camera.zoom(before / after);
    this.camera.pan(dx / 2, dy / 2, this.canvas.clientHeight);
  }

  up(event) {
    if (!this.pointers.delete(event.pointerId)) return;
    this.canvas.dataset.over = "";
    if (this.grab) {
      if (this.grab.hasMoved) this.socket.send("put_down");
      this.grab = null;
    } else if (event.type === "pointerup" && event.button === 0 && this.moved <= this.clickPx) {
      const place = this.ground(event);
      if (place && this.store.scene?.mode === "playground") {
        this.socket.send("walk_to", { x_m: place[0], y_m: place[1] });
      } else if (place && this.store.scene?.mode === "team") {
        const robot = this.teammate(event);
        if (robot) this.socket.send("look", { robot: robot.number });
      }
    }
  }
}
