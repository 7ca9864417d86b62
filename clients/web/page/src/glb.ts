// The binary form of glTF 2.0 (section 4.4 of its specification): parsed, extended, written.

const MAGIC = 0x46546c67, JSON_CHUNK = 0x4e4f534a, BINARY_CHUNK = 0x004e4942;
const FLOAT = 5126; // componentType
const WIDTHS = { SCALAR: 1, VEC3: 3, VEC4: 4 };

export interface GltfNode {
  name?: string;
  children?: number[];
  translation?: number[];
  rotation?: number[];
  scale?: number[];
  matrix?: number[];
  [other: string]: unknown;
}
export type Path = 'translation' | 'rotation' | 'weights';
export interface GltfAnimation {
  name?: string;
  samplers: { input: number; output: number; interpolation: 'LINEAR' }[];
  channels: { sampler: number; target: { node: number; path: Path } }[];
}
/** The description in a file; other content stays as it is. */
export interface Gltf {
  asset: { version: string; generator?: string };
  scene?: number;
  scenes?: { name?: string; nodes?: number[] }[];
  nodes?: GltfNode[];
  animations?: GltfAnimation[];
  accessors?: object[];
  bufferViews?: object[];
  buffers?: { byteLength: number; uri?: string }[];
  [other: string]: unknown;
}

/** The description and the buffer of a valid file (vrmFault has found no error). */
export function openGlb(bytes: ArrayBuffer): { gltf: Gltf; buffer: Uint8Array } {
  const view = new DataView(bytes);
  const text = view.getUint32(12, true), at = 20 + text;
  const gltf = JSON.parse(new TextDecoder().decode(new Uint8Array(bytes, 20, text))) as Gltf;
  const binary = at + 8 <= view.getUint32(8, true) && view.getUint32(at + 4, true) === BINARY_CHUNK;
  const size = gltf.buffers?.[0]?.uri === undefined ? gltf.buffers?.[0]?.byteLength ?? 0 : 0;
  if (!binary || size === 0) throw new Error('its data is not inside the file');
  return { gltf, buffer: new Uint8Array(bytes, at + 8, Math.min(size, view.getUint32(at, true))) };
}

/** A file in the making: accessors and an animation are appended to a description and its buffer. */
export class GlbWriter {
  private readonly parts: Uint8Array[] = [];
  private bytes = 0;

  constructor(private readonly gltf: Gltf, buffer = new Uint8Array(0)) {
    this.append(buffer);
  }

  /** `range`: with its least and greatest value, which a sampler's times require. Returns its index. */
  accessor(values: Float32Array, type: keyof typeof WIDTHS, range = false): number {
    const { gltf } = this;
    const views = (gltf.bufferViews ??= []), accessors = (gltf.accessors ??= []);
    views.push({ buffer: 0, byteOffset: this.bytes, byteLength: values.byteLength });
    this.append(new Uint8Array(values.buffer, values.byteOffset, values.byteLength));
    const limits = range ? { min: [values[0]], max: [values.at(-1)] } : {};
    accessors.push({ bufferView: views.length - 1, componentType: FLOAT, count: values.length / WIDTHS[type], type, ...limits });
    return accessors.length - 1;
  }

  /** The animation becomes the first of the file. */
  animation(name: string, times: Float32Array, channels: Iterable<[node: number, path: Path, values: Float32Array]>): void {
    const input = this.accessor(times, 'SCALAR', true);
    const animation: GltfAnimation = { name, samplers: [], channels: [] };
    for (const [node, path, values] of channels) {
      const type = path === 'rotation' ? 'VEC4' : path === 'translation' ? 'VEC3' : 'SCALAR';
      animation.channels.push({ sampler: animation.samplers.length, target: { node, path } });
      animation.samplers.push({ input, output: this.accessor(values, type), interpolation: 'LINEAR' });
    }
    this.gltf.animations = [animation, ...(this.gltf.animations ?? [])];
  }

  file(): Blob {
    const { gltf } = this;
    gltf.buffers = [{ ...gltf.buffers?.[0], byteLength: this.bytes }, ...(gltf.buffers ?? []).slice(1)];
    const text = padded(new TextEncoder().encode(JSON.stringify(gltf)), 0x20);
    const head = (words: number[]) => new Uint8Array(new Uint32Array(words).buffer); // as in the browser: little-endian
    const whole = 12 + 8 + text.length + 8 + this.bytes;
    if (whole > 0xffffffff) throw new Error('a glTF file has at most 4 GiB');
    return new Blob([head([MAGIC, 2, whole]), head([text.length, JSON_CHUNK]), text, head([this.bytes, BINARY_CHUNK]), ...this.parts],
                    { type: 'model/gltf-binary' });
  }

  private append(bytes: Uint8Array): void {
    const part = padded(bytes, 0);
    this.parts.push(part);
    this.bytes += part.length;
  }
}

// Chunks, and the numbers of an accessor, begin at multiples of four bytes.
function padded(bytes: Uint8Array, fill: number): Uint8Array {
  if (bytes.length % 4 === 0) return bytes;
  const whole = new Uint8Array(bytes.length + 4 - (bytes.length % 4)).fill(fill);
  whole.set(bytes);
  return whole;
}
