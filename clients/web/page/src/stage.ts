// The scene: the performers' places, the camera, the picture.
import {
  CanvasTexture,
  Color,
  DirectionalLight,
  Fog,
  HemisphereLight,
  PerspectiveCamera,
  Raycaster,
  SRGBColorSpace,
  Scene,
  Vector2,
  Vector3,
  WebGLRenderer,
} from 'three';
import { OrbitControls } from 'three/examples/jsm/controls/OrbitControls.js';
import type { Stream, StyledClient } from 'styled-client';

import { clamp, h, setText } from './dom.js';
import { COARSE, COARSEST, FINE, type Detail } from './figure.js';
import { FlatRenderer } from './flat.js';
import type { Framing } from './links.js';
import { PerformerOnStage, type Shown, type View } from './performer.js';
import { Sharpness } from './sharpness.js';

const BACKGROUND = 0x0c0f13;
const SEEN_MS = 3000; // after a longer time between two frames, the page was hidden
const HOME = new Vector3(0, 1.5, 5.05);
const TARGET = new Vector3(0, 0.83, 0);
const TARGET_ALONE = new Vector3(0, 0.93, 0); // from the soles to raised hands
// Of the height from hips to head, what is below the head in a picture of that framing.
const BELOW: Record<Framing, number> = { bust: 0.55, half: 1.1 };
const AIR = 0.12; // above the head, of the picture's height
const LENS_M = 2.8; // of the camera for a framing: from nearby, a face is distorted
const TRUNK_S = 20; // time constant of forgetting another avatar's height
const AIM_S = 0.3; // time constant of its motion
const HOME_ALONE = new Vector3(0, 1.1, 3.9);

// Whether rendering is done in software, where every pixel is expensive.
function isSoftware(renderer: WebGLRenderer): boolean {
  const gl = renderer.getContext();
  const info = gl.getExtension('WEBGL_debug_renderer_info');
  const name = info ? String(gl.getParameter(info.UNMASKED_RENDERER_WEBGL)) : '';
  return /swiftshader|llvmpipe|software|basic render/i.test(name);
}

// Undefined: this browser has no WebGL, or it is switched off.
function webRenderer(alpha: boolean): WebGLRenderer | undefined {
  const context = h('canvas').getContext('webgl2');
  context?.getExtension('WEBGL_lose_context')?.loseContext(); // only asked whether there is one
  return context ? new WebGLRenderer({ antialias: true, alpha, powerPreference: 'high-performance' }) : undefined;
}

// A dark background with a little light behind the stage.
function backdrop(): CanvasTexture {
  const canvas = h('canvas', { width: 64, height: 256 });
  const context = canvas.getContext('2d')!;
  const light = context.createLinearGradient(0, 0, 0, 256);
  for (const [at, color] of [[0, '#0a0d11'], [0.42, '#141a22'], [0.6, '#10151b'], [1, '#0a0c10']] as const) {
    light.addColorStop(at, color);
  }
  context.fillStyle = light;
  context.fillRect(0, 0, 64, 256);
  const texture = new CanvasTexture(canvas);
  texture.colorSpace = SRGBColorSpace;
  return texture;
}

/** A film that is being drawn on `canvas`; `end` returns the stage to the live motion. */
export interface Filming {
  canvas: HTMLCanvasElement;
  draw(of: (stream: Stream) => Shown | undefined, dt_s: number): void;
  end(): void;
}

interface Labels {
  before: HTMLElement;
  after: HTMLElement;
}

export class Stage {
  readonly element = h('div', { className: 'stage' });
  readonly performers = new Map<string, PerformerOnStage>();
  readonly view: View = { overlay: false, trails: true, contacts: true, alone: false, props: true };
  selected = '';
  /** Frames drawn in the last second. */
  fps = 0;
  pictures = 0;
  /** A video is being recorded: the picture keeps its size. */
  steady = false;
  onSelect: (name: string) => void = () => {};
  /** Alone: what of the body the camera follows; unset: it stands still. */
  framing: Framing | undefined;

  /** Without WebGL, bodies are drawn as lines, and avatars are not drawn. */
  readonly flat: boolean;
  private readonly renderer: WebGLRenderer | FlatRenderer;
  private readonly detail: Detail = FINE;
  private readonly sharpness = new Sharpness(1);
  private readonly scene = new Scene();
  private readonly camera = new PerspectiveCamera(34, 1, 0.1, 60);
  private readonly orbit: OrbitControls;
  private readonly labels = new Map<string, Labels>();
  private readonly labelLayer = h('div', { className: 'labels' });
  private filming: PerformerOnStage | undefined; // it stays until its film ends
  private names: string[] = [];
  private last_ms = 0;
  private second_ms = 0;
  private inSecond = 0;
  private trunk_m = 0; // of the framed body
  private aimed_m = 0; // height of the picture where the body is; 0: not aimed yet

  /** `alone`: one performer without floor, labels and background; the page is visible behind it. `props`: the
  objects that the rig tracks are shown. */
  constructor(private readonly client: StyledClient, { alone = false, props = true } = {}) {
    this.view.alone = alone;
    this.view.props = props;
    const wanted = new URLSearchParams(location.search).get('quality');
    let renderer = webRenderer(alone);
    this.flat = renderer === undefined;
    if (!renderer) this.detail = COARSEST;
    else if (wanted !== 'high' && (wanted === 'low' || isSoftware(renderer))) {
      renderer.dispose();
      const canvas = h('canvas');
      // Opaque, so that nothing behind it needs to be drawn.
      const context = canvas.getContext('webgl2', { alpha: alone, antialias: alone });
      renderer = new WebGLRenderer(context ? { canvas, context, alpha: alone } : { alpha: alone });
      renderer.setPixelRatio(1);
      this.detail = COARSE;
    } else {
      renderer.setPixelRatio(Math.min(devicePixelRatio, 2));
    }
    this.renderer = renderer ?? new FlatRenderer(alone ? '' : `#${new Color(BACKGROUND).getHexString()}`, () => this.outlines());
    if (alone) renderer?.setClearColor(BACKGROUND, 0);
    else {
      this.scene.background = this.detail === FINE ? backdrop() : new Color(BACKGROUND);
      this.scene.fog = new Fog(BACKGROUND, 8, 19);
    }
    this.scene.add(new HemisphereLight(0xcfdcf0, 0x20242c, 1.25));
    const key = new DirectionalLight(0xfff1de, 2.3);
    key.position.set(2.5, 5, 4);
    const rim = new DirectionalLight(0x7fa4ff, 1.6);
    rim.position.set(-4, 3, -5);
    this.scene.add(key, rim);
    const { canvas } = this;
    this.orbit = new OrbitControls(this.camera, canvas);
    this.orbit.enableDamping = true;
    this.orbit.minDistance = alone ? 0.2 : 1.5;
    this.orbit.maxDistance = 14;
    this.orbit.maxPolarAngle = 1.62;
    this.home();
    canvas.tabIndex = 0;
    canvas.setAttribute('aria-label', 'Stage: drag to look around, wheel to zoom');
    this.element.append(canvas, this.labelLayer);
    if (this.flat && !alone) {
      this.element.append(h('p', { className: 'flat' }, 'Without WebGL in this browser, bodies are drawn as lines, and avatars are not drawn.'));
    }
    new ResizeObserver(() => this.resize()).observe(this.element);
    if (!alone) canvas.addEventListener('click', (event) => this.pick(event));
    this.renderer.setAnimationLoop((now) => this.draw(now));
  }

  /** Instead of the live motion, one performer's poses are drawn, from the current camera. `alone`: only the styled
  body or its avatar, on a transparent canvas of its own, while the stage stands still. */
  beginFilm(name: string, width: number, height: number, alone = false): Filming | undefined {
    const performer = this.performers.get(name);
    if (!performer || this.filming) return undefined;
    const renderer = alone ? this.transparent() : this.renderer; // first: a browser may refuse another context
    this.filming = performer;
    this.renderer.setAnimationLoop(null);
    this.orbit.enabled = false;
    const view = { ...this.view, alone }, { background, fog } = this.scene;
    const ratio = this.renderer.getPixelRatio(), spot = performer.spot.clone();
    if (alone) this.scene.background = this.scene.fog = null;
    else this.element.classList.add('filming');
    renderer.setPixelRatio(1);
    renderer.setSize(width, height, false);
    this.look(width / height);
    this.labelLayer.hidden = true;
    performer.spot.set(0, 0, 0);
    performer.rewind();
    return {
      canvas: renderer.domElement,
      draw: (of, dt_s) => {
        for (const other of this.performers.values()) other.group.visible = other === performer;
        performer.take(of);
        performer.draw(view, true, dt_s);
        renderer.render(this.scene, this.camera);
      },
      end: () => {
        this.filming = undefined;
        this.orbit.enabled = true;
        this.element.classList.remove('filming');
        this.scene.background = background;
        this.scene.fog = fog;
        if (alone && renderer instanceof WebGLRenderer) {
          renderer.dispose();
          renderer.forceContextLoss(); // a browser has few contexts, and would end the stage's
        }
        performer.spot.copy(spot);
        performer.rewind();
        for (const other of this.performers.values()) other.group.visible = true;
        this.labelLayer.hidden = false;
        this.renderer.setPixelRatio(ratio);
        this.resize();
        this.setPerformers(this.names);
        this.renderer.setAnimationLoop((now) => this.draw(now));
      },
    };
  }

  private transparent(): WebGLRenderer | FlatRenderer {
    if (this.flat) return new FlatRenderer('', () => this.outlines());
    const renderer = new WebGLRenderer({ antialias: this.detail === FINE, alpha: true });
    renderer.setClearColor(BACKGROUND, 0);
    return renderer;
  }

  get canvas(): HTMLCanvasElement {
    return this.renderer.domElement;
  }

  private *outlines() {
    for (const performer of this.performers.values()) yield* performer.outlines();
  }

  home(): void {
    this.camera.position.copy(this.view.alone ? HOME_ALONE : HOME);
    this.orbit.target.copy(this.view.alone ? TARGET_ALONE : TARGET);
    this.orbit.update();
  }

  /** Turns the camera by radians, or moves it closer (factor below 1). */
  turn(around: number, up: number, closer = 1): void {
    const offset = this.camera.position.clone().sub(this.orbit.target).multiplyScalar(closer);
    offset.applyAxisAngle(new Vector3(0, 1, 0), around);
    const side = new Vector3(offset.z, 0, -offset.x).normalize();
    const raised = offset.clone().applyAxisAngle(side, -up);
    const angle = raised.angleTo(new Vector3(0, 1, 0));
    if (angle > 0.15 && angle < this.orbit.maxPolarAngle) offset.copy(raised);
    this.camera.position.copy(this.orbit.target).add(offset);
  }

  /** Sets the performers, in order; others are removed. */
  setPerformers(names: string[]): void {
    this.names = names;
    for (const [name, performer] of this.performers) {
      if (names.includes(name) || performer === this.filming) continue;
      performer.dispose();
      this.performers.delete(name);
      const labels = this.labels.get(name)!;
      labels.before.remove();
      labels.after.remove();
      this.labels.delete(name);
    }
    for (const name of names) {
      if (this.performers.has(name)) continue;
      const performer = new PerformerOnStage(name, this.client, this.detail);
      this.performers.set(name, performer);
      this.scene.add(performer.group);
      const labels = {
        before: h('div', { className: 'label before' }),
        after: h('div', { className: 'label after' }),
      };
      this.labels.set(name, labels);
      this.labelLayer.append(labels.before, labels.after);
    }
    this.place(names);
  }

  /** Places the selected performer in front, the others in rows behind. */
  place(names: string[] = [...this.performers.keys()]): void {
    const others = names.filter((name) => name !== this.selected);
    const perRow = 3;
    const width = 2.75;
    this.performers.get(this.selected)?.spot.set(0, 0, 0);
    others.forEach((name, i) => {
      const row = Math.floor(i / perRow);
      const inRow = Math.min(perRow, others.length - row * perRow);
      const x = ((i % perRow) - (inRow - 1) / 2) * width;
      this.performers.get(name)?.spot.set(x, 0, -4.4 - 2.2 * row);
    });
  }

  private resize(): void {
    const { clientWidth, clientHeight } = this.element;
    if (clientWidth === 0 || clientHeight === 0 || this.filming) return;
    this.renderer.setSize(clientWidth, clientHeight, false);
    this.look(clientWidth / clientHeight);
  }

  private look(aspect: number): void {
    this.camera.aspect = aspect;
    // Two floors side by side must fit into a picture of any width; one body alone is narrow.
    const wide = this.view.alone ? 0.6 : 1.5;
    this.camera.fov = clamp(34 * Math.max(1, wide / this.camera.aspect), 30, 60);
    this.camera.updateProjectionMatrix();
  }

  // The camera follows head and shoulders, however tall the avatar is and whether it sits or stands.
  private aim(dt_s: number): void {
    const marks = this.framing && this.performers.get(this.selected)?.landmarks();
    if (!this.framing || !marks) return;
    const trunk_m = marks.head.distanceTo(marks.hips);
    this.trunk_m = Math.max(this.trunk_m * Math.exp(-dt_s / TRUNK_S), trunk_m); // who bends is not shown larger
    const below_m = BELOW[this.framing] * this.trunk_m;
    const tall_m = (marks.crown_m + below_m) / (1 - AIR);
    const middle = marks.head.clone();
    middle.y += tall_m / 2 - below_m;
    const { target } = this.orbit;
    const way = this.camera.position.clone().sub(target).setLength(LENS_M * tall_m);
    const share = this.aimed_m > 0 ? 1 - Math.exp(-dt_s / AIM_S) : 1;
    target.lerp(middle, share);
    this.aimed_m += (tall_m - this.aimed_m) * share;
    this.camera.position.copy(target).add(way);
    this.camera.fov = 2 * Math.atan(this.aimed_m / 2 / way.length()) * 180 / Math.PI;
    this.camera.updateProjectionMatrix();
  }

  private pick(event: MouseEvent): void {
    const box = this.element.getBoundingClientRect();
    const at = new Vector2(
      ((event.clientX - box.left) / box.width) * 2 - 1,
      1 - ((event.clientY - box.top) / box.height) * 2,
    );
    const ray = new Raycaster();
    ray.setFromCamera(at, this.camera);
    const way = ray.ray;
    let best = '', nearest = Infinity;
    for (const performer of this.performers.values()) {
      for (const role of [performer.roles.before, performer.roles.after]) {
        const foot = role.floor.group.getWorldPosition(new Vector3());
        const head = foot.clone().setY(1.7);
        const hit = new Vector3();
        const off = Math.sqrt(way.distanceSqToSegment(foot, head, hit));
        const far = hit.distanceTo(way.origin);
        if (off < 0.45 && far < nearest) [best, nearest] = [performer.name, far];
      }
    }
    if (best) this.onSelect(best);
  }

  private draw(now_ms: number): void {
    const dt_s = clamp((now_ms - this.last_ms) / 1000, 0.001, 0.25);
    this.last_ms = now_ms;
    for (const performer of this.performers.values()) {
      if (this.detail === COARSE) {
        performer.setDetail(performer.name === this.selected ? COARSE : COARSEST);
      }
      performer.take();
      performer.draw(this.view, performer.name === this.selected, dt_s);
    }
    this.aim(dt_s);
    this.orbit.update();
    this.renderer.render(this.scene, this.camera);
    if (!this.view.alone) this.drawLabels();
    ++this.pictures;
    ++this.inSecond;
    const since_ms = now_ms - this.second_ms;
    if (since_ms >= 1000) {
      this.fps = (this.inSecond * 1000) / since_ms;
      this.second_ms = now_ms;
      this.inSecond = 0;
      if (since_ms < SEEN_MS) this.spare();
    }
  }

  /** With software rendering, adapts the resolution to the achieved frame rate. */
  private spare(): void {
    if (this.steady || this.detail !== COARSE) return;
    const ratio = this.sharpness.next(this.fps);
    if (ratio !== this.renderer.getPixelRatio()) this.renderer.setPixelRatio(ratio);
  }

  private drawLabels(): void {
    const { clientWidth, clientHeight } = this.element;
    const at = new Vector3();
    for (const performer of this.performers.values()) {
      const labels = this.labels.get(performer.name)!;
      const chosen = performer.name === this.selected;
      const { before, after } = performer.roles;
      const styles = [...performer.weights].filter(([, weight]) => weight > 0.005);
      const words = styles.map(([name, weight]) => `${name} ${Math.round(weight * 100)}%`).join(' + ');
      const short = performer.name.split('.').pop()!;
      setText(labels.before, chosen ? 'as captured' : '');
      setText(labels.after, chosen ? words || 'bypass' : this.view.overlay ? short : '');
      if (!chosen && !this.view.overlay) setText(labels.before, short);
      labels.before.classList.toggle('other', !chosen);
      labels.after.classList.toggle('other', !chosen);
      for (const [role, label] of [[before, labels.before], [after, labels.after]] as const) {
        role.floor.group.getWorldPosition(at);
        if (!chosen && !this.view.overlay) at.copy(performer.group.position);
        at.y = 0;
        at.z += chosen ? 1.15 : 0.75;
        const far = at.distanceTo(this.camera.position);
        at.project(this.camera);
        const shown = at.z < 1 && label.textContent !== '' && far < 15 && !!role.figure &&
          !(this.view.overlay && role === before);
        label.style.display = shown ? '' : 'none';
        if (!shown) continue;
        const x = ((at.x + 1) / 2) * clientWidth;
        const y = ((1 - at.y) / 2) * clientHeight;
        label.style.transform = `translate(-50%, 0) translate(${x.toFixed(1)}px, ${y.toFixed(1)}px)`;
      }
    }
  }
}
