// Encodes pictures that are drawn one after the other, as fast as the machine can, as a video file:
// MP4 (H.264) if the browser can encode that, otherwise WebM (VP9 or VP8), with its duration. Transparent pictures need
// WebM: H.264 has none.
import { BufferTarget, CanvasSource, Mp4OutputFormat, Output, WebMOutputFormat, getFirstEncodableVideoCodec } from 'mediabunny';

import { AT_ONCE_MS } from './save.js';

const BITS_PER_S = 14e6;
const KEY_S = 2;

/** A file, its extension, and how many pictures it has. */
export interface Video {
  blob: Blob;
  extension: 'mp4' | 'webm';
  pictures: number;
}

/** `draw`: draws picture i on the canvas, which has its final size. `progress`: receives the completed share;
returning false ends the work, and the result is undefined. `transparent`: the canvas's alpha is kept. Rejects if
the browser cannot encode a video of that size. */
export async function render(
  canvas: HTMLCanvasElement, rate_hz: number, pictures: number, draw: (i: number) => void, progress: (share: number) => boolean,
  transparent = false,
): Promise<Video | undefined> {
  const size = { width: canvas.width, height: canvas.height, bitrate: BITS_PER_S };
  const h264 = transparent ? null : await getFirstEncodableVideoCodec(['avc'], size);
  const codec = h264 ?? await getFirstEncodableVideoCodec(['vp9', 'vp8'], size);
  if (!codec) throw new Error(`this browser encodes no video of ${size.width} x ${size.height}`);
  const target = new BufferTarget();
  const output = new Output({ target, format: h264 ? new Mp4OutputFormat({ fastStart: 'in-memory' }) : new WebMOutputFormat() });
  const source = new CanvasSource(canvas, { codec, bitrate: BITS_PER_S, keyFrameInterval: KEY_S, alpha: transparent ? 'keep' : 'discard' });
  output.addVideoTrack(source, { frameRate: rate_hz, canBeTransparent: transparent });
  await output.start();
  try {
    let begun_ms = performance.now();
    for (let i = 0; i < pictures; ++i) {
      draw(i);
      await source.add(i / rate_hz, 1 / rate_hz);
      if (performance.now() - begun_ms < AT_ONCE_MS) continue;
      if (!progress(i / pictures)) {
        await output.cancel();
        return undefined;
      }
      await new Promise((resolve) => setTimeout(resolve));
      begun_ms = performance.now();
    }
    await output.finalize();
  } catch (error) {
    await output.cancel().catch(() => undefined);
    throw error;
  }
  return { blob: new Blob([target.buffer!], { type: h264 ? 'video/mp4' : 'video/webm' }), extension: h264 ? 'mp4' : 'webm', pictures };
}
