// The objects that a rig tracks, such as a sword or a chair: each a small labelled cross of axes.
import { BufferGeometry, CanvasTexture, Float32BufferAttribute, Group, LineBasicMaterial, LinearFilter, LineSegments, SRGBColorSpace, Sprite, SpriteMaterial } from 'three';
import type { Frame } from 'styled-client';

import { h } from './dom.js';
import type { Skeleton } from './skeleton.js';

const LENGTH_M = 0.16; // of an axis, half of it on the other side
const LABEL_M = 0.1; // height of the letters' line
const LETTERS = 24; // of a name
const PIXELS = 48; // height of a label's picture
const COLORS = [[1, 0.42, 0.37], [0.44, 0.84, 0.66], [0.5, 0.7, 1]]; // of x, y, z

function crossOf(): LineSegments {
  const places: number[] = [], colors: number[] = [];
  COLORS.forEach((color, axis) => {
    for (const end of [-0.5, 1]) {
      places.push(...[0, 1, 2].map((k) => (k === axis ? end * LENGTH_M : 0)));
      colors.push(...color);
    }
  });
  const geometry = new BufferGeometry();
  geometry.setAttribute('position', new Float32BufferAttribute(places, 3));
  geometry.setAttribute('color', new Float32BufferAttribute(colors, 3));
  return new LineSegments(geometry, new LineBasicMaterial({ vertexColors: true }));
}

function labelOf(name: string): Sprite {
  const words = name.length > LETTERS ? `${name.slice(0, LETTERS - 1)}…` : name;
  const font = `600 ${0.62 * PIXELS}px system-ui, 'DejaVu Sans', sans-serif`;
  const canvas = h('canvas', { width: 1, height: PIXELS });
  const context = canvas.getContext('2d')!;
  context.font = font;
  canvas.width = Math.ceil(context.measureText(words).width) + 16;
  context.font = font; // a resized canvas loses its settings
  context.textBaseline = 'middle';
  context.lineWidth = 6;
  context.strokeStyle = '#0c0f13';
  context.strokeText(words, 8, PIXELS / 2);
  context.fillStyle = '#dfe6ef';
  context.fillText(words, 8, PIXELS / 2);
  const map = new CanvasTexture(canvas);
  map.colorSpace = SRGBColorSpace;
  map.minFilter = LinearFilter; // smaller copies of letters are hard to read
  map.generateMipmaps = false;
  const label = new Sprite(new SpriteMaterial({ map, depthTest: false, fog: false }));
  label.scale.set((LABEL_M * canvas.width) / PIXELS, LABEL_M, 1);
  label.center.set(0, 0);
  return label;
}

interface Drawn {
  cross: LineSegments;
  label: Sprite;
}

/** Of one body. `group` is in the performer's world, in metres. */
export class Props {
  readonly group = new Group();
  private readonly drawn = new Map<string, Drawn>();

  /** `skeleton`: of the frame's body. Props that the frame lacks are removed. */
  show({ props }: Pick<Frame, 'props'>, { scene }: Skeleton): void {
    for (const [name, one] of this.drawn) if (!props.some((prop) => prop.name === name)) this.remove(name, one);
    const unit_m = scene.getMaxScaleOnAxis();
    for (const { name, position, rotation } of props) {
      const { cross, label } = this.drawn.get(name) ?? this.add(name);
      cross.position.fromArray(position);
      cross.quaternion.fromArray(rotation).normalize();
      cross.scale.setScalar(1 / unit_m);
      cross.updateMatrix();
      cross.matrix.premultiply(scene);
      label.position.setFromMatrixPosition(cross.matrix);
      cross.matrixWorldNeedsUpdate = true;
    }
  }

  /** The position of a shown prop, in the performer's world; for tests. */
  place(name: string): number[] | undefined {
    return this.drawn.get(name)?.label.position.toArray();
  }

  private add(name: string): Drawn {
    const cross = crossOf(), label = labelOf(name);
    cross.matrixAutoUpdate = false;
    this.group.add(cross, label);
    const one = { cross, label };
    this.drawn.set(name, one);
    return one;
  }

  private remove(name: string, { cross, label }: Drawn): void {
    cross.geometry.dispose();
    (cross.material as LineBasicMaterial).dispose();
    label.material.map?.dispose();
    label.material.dispose();
    this.group.remove(cross, label);
    this.drawn.delete(name);
  }

  dispose(): void {
    for (const [name, one] of this.drawn) this.remove(name, one);
    this.group.removeFromParent();
  }
}
