// The patch of floor under one body. It moves under the body like a treadmill, so that the
// performer stays on stage and foot sliding remains visible.
import {
  BufferAttribute,
  BufferGeometry,
  CircleGeometry,
  Color,
  DoubleSide,
  Group,
  InstancedMesh,
  LineSegments,
  LineBasicMaterial,
  Mesh,
  MeshBasicMaterial,
  Object3D,
  RingGeometry,
  ShaderMaterial,
  Vector2,
  Vector3,
  AdditiveBlending,
} from 'three';

import type { Line, Outline } from './flat.js';

export const RADIUS_M = 1.06;
const STAMPS = 20; // contact marks kept
const STAMP_S = 3.5;
const TRAIL = 150; // points per foot
const CORNERS = 48; // of the rim as lines

const RIM: Line[] = Array.from({ length: CORNERS }, (_, i) => ({ from: i, to: (i + 1) % CORNERS, width_m: 0.02, shade: 0.6 }));

const VERTEX = /* glsl */ `
  varying vec2 place;
  void main() {
    place = vec2(position.x, -position.y);
    gl_Position = projectionMatrix * modelViewMatrix * vec4(position, 1.0);
  }`;
const FRAGMENT = /* glsl */ `
  uniform vec2 offset;
  uniform vec3 tint;
  uniform float glow;
  uniform float reach;
  uniform vec3 hips;   // x, z and height
  uniform vec3 feet[2];
  varying vec2 place;
  float lines(vec2 at, float step_m) {
    vec2 near = abs(fract(at / step_m - 0.5) - 0.5) * step_m;
    vec2 wide = fwidth(at) * 1.2;
    vec2 line = 1.0 - smoothstep(vec2(0.0), wide, near);
    return max(line.x, line.y);
  }
  void main() {
    float r = length(place) / reach;
    if (r > 1.0) discard;
    float edge = 1.0 - smoothstep(0.55, 1.0, r);
    vec2 at = place + offset;
    vec3 color = mix(vec3(0.021, 0.026, 0.034), vec3(0.009, 0.011, 0.015), r);
    color += tint * (0.035 * lines(at, 0.25) + 0.10 * lines(at, 1.0)) * edge;
    float rim = smoothstep(0.965, 0.975, r) * (1.0 - smoothstep(0.99, 1.0, r));
    color += tint * rim * (0.10 + 0.55 * glow);
    float shade = 0.55 * exp(-dot(place - hips.xy, place - hips.xy) * 9.0);
    for (int i = 0; i < 2; ++i) {
      vec2 d = place - feet[i].xy;
      float height = max(feet[i].z, 0.0);
      shade += 0.5 * exp(-dot(d, d) * 55.0 / (1.0 + 30.0 * height)) / (1.0 + 8.0 * height);
    }
    color *= 1.0 - min(shade, 0.8);
    gl_FragColor = vec4(color, 1.0 - smoothstep(0.985, 1.0, r));
    #include <colorspace_fragment>
  }`;

class Trail {
  readonly line: LineSegments;
  private readonly points: Vector3[] = [];
  private readonly positions = new Float32Array(6 * TRAIL);
  private readonly colors = new Float32Array(6 * TRAIL);

  constructor(private readonly color: Color) {
    const geometry = new BufferGeometry();
    geometry.setAttribute('position', new BufferAttribute(this.positions, 3));
    geometry.setAttribute('color', new BufferAttribute(this.colors, 3));
    const material = new LineBasicMaterial({
      vertexColors: true, transparent: true, blending: AdditiveBlending, depthWrite: false,
    });
    this.line = new LineSegments(geometry, material);
    this.line.frustumCulled = false;
  }

  add(at: Vector3): void {
    const last = this.points.at(-1);
    if (last && last.distanceToSquared(at) > 1) this.points.length = 0; // a jump
    if (last && last.distanceToSquared(at) < 4e-6) return;
    this.points.push(at.clone());
    if (this.points.length > TRAIL) this.points.shift();
  }

  clear(): void {
    this.points.length = 0;
  }

  /** Fades with age, and towards the edge of the patch. */
  draw(anchor: Vector3, reach: number): void {
    const count = this.points.length;
    const bright = (i: number) => {
      const p = this.points[i]!;
      const far = Math.hypot(p.x - anchor.x, p.z - anchor.z) / reach;
      return Math.max(0, 1 - far ** 4) * ((i + TRAIL - count) / TRAIL) ** 2;
    };
    for (let i = 0; i + 1 < count; ++i) {
      for (let end = 0; end < 2; ++end) {
        this.points[i + end]!.toArray(this.positions, 6 * i + 3 * end);
        const b = bright(i + end);
        this.colors.set([this.color.r * b, this.color.g * b, this.color.b * b], 6 * i + 3 * end);
      }
    }
    const { geometry } = this.line;
    geometry.setDrawRange(0, Math.max(0, 2 * (count - 1)));
    geometry.attributes.position!.needsUpdate = true;
    geometry.attributes.color!.needsUpdate = true;
  }
}

interface Stamp {
  x: number;
  z: number;
  side: number;
  age_s: number;
}

export class Floor {
  /** Placed at the body's spot on the stage. */
  readonly group = new Group();
  /** In the performer's world: objects in it stand on the moving floor. */
  readonly world = new Group();
  readonly disc: Mesh;
  private readonly uniforms;
  private readonly trails: [Trail, Trail];
  private readonly stamps: InstancedMesh;
  private readonly placed: Stamp[] = [];
  private readonly down = [false, false];
  private readonly dummy = new Object3D();

  constructor(private readonly color: number) {
    const tint = new Color(color);
    this.uniforms = {
      offset: { value: new Vector2() },
      tint: { value: tint },
      glow: { value: 0 },
      reach: { value: RADIUS_M },
      hips: { value: new Vector3(0, 0, 1) },
      feet: { value: [new Vector3(), new Vector3()] },
    };
    this.disc = new Mesh(
      new CircleGeometry(RADIUS_M, 64),
      new ShaderMaterial({
        vertexShader: VERTEX, fragmentShader: FRAGMENT, uniforms: this.uniforms, transparent: true,
      }),
    );
    this.disc.rotation.x = -Math.PI / 2;
    this.disc.renderOrder = -1;
    this.trails = [new Trail(tint), new Trail(tint)];
    this.stamps = new InstancedMesh(
      new RingGeometry(0.055, 0.072, 28),
      new MeshBasicMaterial({
        transparent: true, blending: AdditiveBlending, depthWrite: false, side: DoubleSide,
      }),
      STAMPS,
    );
    this.stamps.frustumCulled = false;
    this.stamps.count = 0;
    this.world.add(this.trails[0].line, this.trails[1].line, this.stamps);
    this.group.add(this.disc, this.world);
    this.dummy.rotation.x = -Math.PI / 2;
  }

  set glow(value: number) {
    this.uniforms.glow.value = value;
  }

  /** The radius of the patch, at most RADIUS_M. */
  set reach(value: number) {
    this.uniforms.reach.value = value;
  }

  /** The rim as lines, for a picture without WebGL. */
  get outline(): Outline {
    const reach = this.uniforms.reach.value;
    const points = RIM.flatMap((_, i) => [reach * Math.cos(2 * Math.PI * i / CORNERS), 0, reach * Math.sin(2 * Math.PI * i / CORNERS)]);
    return { points, at: this.group.matrixWorld, lines: RIM, color: this.color, opacity: 0.3 + 0.5 * this.uniforms.glow.value };
  }

  show(trails: boolean, contacts: boolean): void {
    for (const trail of this.trails) trail.line.visible = trails;
    this.stamps.visible = contacts;
  }

  /** A new pose: feet and hips in the performer's world; bits 0 and 1 of `contacts` are left and right. */
  step(left: Vector3, right: Vector3, contacts: number): void {
    [left, right].forEach((foot, side) => {
      this.trails[side]!.add(foot);
      const down = ((contacts >> side) & 1) === 1;
      if (down && !this.down[side]) {
        this.placed.push({ x: foot.x, z: foot.z, side, age_s: 0 });
        if (this.placed.length > STAMPS) this.placed.shift();
      }
      this.down[side] = down;
    });
  }

  restart(): void {
    for (const trail of this.trails) trail.clear();
    this.placed.length = 0;
  }

  /** `anchor`: the position in the performer's world that is shown at the spot. */
  draw(anchor: Vector3, hips: Vector3, left: Vector3, right: Vector3, dt_s: number): void {
    this.world.position.set(-anchor.x, 0, -anchor.z);
    const u = this.uniforms;
    u.offset.value.set(anchor.x, anchor.z);
    u.hips.value.set(hips.x - anchor.x, hips.z - anchor.z, hips.y);
    u.feet.value[0]!.set(left.x - anchor.x, left.z - anchor.z, left.y - 0.08);
    u.feet.value[1]!.set(right.x - anchor.x, right.z - anchor.z, right.y - 0.08);
    for (const trail of this.trails) if (trail.line.visible) trail.draw(anchor, u.reach.value);
    if (this.stamps.visible) this.drawStamps(anchor, dt_s);
  }

  private drawStamps(anchor: Vector3, dt_s: number): void {
    const newest = [-1, -1];
    this.placed.forEach((stamp, i) => (newest[stamp.side] = i));
    const color = new Color();
    let count = 0;
    this.placed.forEach((stamp, i) => {
      const held = this.down[stamp.side] === true && newest[stamp.side] === i;
      stamp.age_s = held ? 0 : stamp.age_s + dt_s;
      const far = Math.hypot(stamp.x - anchor.x, stamp.z - anchor.z) / this.uniforms.reach.value;
      const bright = Math.max(0, 1 - stamp.age_s / STAMP_S) ** 2 * Math.max(0, 1 - far ** 4);
      if (bright <= 0.01) return;
      this.dummy.position.set(stamp.x, 0.006, stamp.z);
      this.dummy.scale.setScalar(held ? 1.25 : 1);
      this.dummy.updateMatrix();
      this.stamps.setMatrixAt(count, this.dummy.matrix);
      color.copy(this.uniforms.tint.value).multiplyScalar(bright * (held ? 1 : 0.6));
      this.stamps.setColorAt(count++, color);
    });
    this.stamps.count = count;
    this.stamps.instanceMatrix.needsUpdate = true;
    if (this.stamps.instanceColor) this.stamps.instanceColor.needsUpdate = true;
  }
}
