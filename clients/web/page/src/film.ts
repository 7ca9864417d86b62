// Records the stage's picture as video, if the browser supports it.
const TYPES = ['video/webm;codecs=vp9', 'video/webm;codecs=vp8', 'video/webm', 'video/mp4'];
const BITS_PER_S = 8e6;
const MAX_BYTES = 512 << 20;

const TYPE = typeof MediaRecorder === 'undefined' ? undefined
  : TYPES.find((type) => MediaRecorder.isTypeSupported(type));

export class Film {
  /** File extension; '' if the browser cannot record video. */
  static readonly extension = TYPE === undefined ? '' : TYPE.startsWith('video/mp4') ? 'mp4' : 'webm';

  private readonly media: MediaRecorder;
  private readonly parts: Blob[] = [];
  private bytes = 0;
  private readonly done: Promise<void>;

  /** Records until `end`; `onBreak` is called if it cannot continue. */
  constructor(canvas: HTMLCanvasElement, onBreak: (reason: string) => void) {
    this.media = new MediaRecorder(canvas.captureStream(), { mimeType: TYPE!, videoBitsPerSecond: BITS_PER_S });
    this.done = new Promise((resolve) => this.media.addEventListener('stop', () => resolve()));
    this.media.addEventListener('error', () => onBreak('the browser cannot continue filming'));
    this.media.addEventListener('dataavailable', ({ data }) => {
      this.parts.push(data);
      this.bytes += data.size;
      if (this.bytes >= MAX_BYTES) onBreak(`${MAX_BYTES >> 20} MiB is the limit of a video here`);
    });
    this.media.start(1000);
  }

  async end(): Promise<Blob> {
    if (this.media.state !== 'inactive') this.media.stop();
    await this.done;
    for (const track of this.media.stream.getTracks()) track.stop();
    return new Blob(this.parts, { type: this.media.mimeType });
  }
}
