// The connection to styleweb: opens, reconnects when it is lost, and reports its state.
import { Socket } from '#socket';

export type LinkState =
  | { kind: 'connecting'; reason: string }
  | { kind: 'open' }
  /** The gateway refused the connection; it is retried after a while. */
  | { kind: 'refused'; reason: string; status: number }
  | { kind: 'closed' };

export interface LinkHandlers {
  state(state: LinkState): void;
  text(text: string): void;
  binary(bytes: Uint8Array): void;
}

const FIRST_RETRY_MS = 250;
const LONGEST_RETRY_MS = 3000;
const GIVE_UP_MS = 5000; // limit of one attempt

// The address for display, without the token.
function address(url: string): string {
  return url.replace(/\?.*$/, '');
}

export class Link {
  private socket: WebSocket | undefined;
  private timer: ReturnType<typeof setTimeout> | undefined;
  private retry_ms = FIRST_RETRY_MS;
  private closed = false;
  private reason = '';
  private refused = false;

  constructor(
    private readonly url: string,
    private readonly handlers: LinkHandlers,
  ) {
    this.open();
  }

  get isOpen(): boolean {
    return this.socket?.readyState === 1;
  }

  send(data: string | Uint8Array): boolean {
    if (!this.isOpen) return false;
    this.socket!.send(data as string);
    return true;
  }

  close(): void {
    this.closed = true;
    clearTimeout(this.timer);
    this.drop();
    this.handlers.state({ kind: 'closed' });
  }

  private drop(): void {
    const socket = this.socket;
    this.socket = undefined;
    if (!socket) return;
    socket.onopen = socket.onmessage = socket.onclose = null;
    socket.onerror = () => {}; // closing a socket that is connecting causes an error event
    socket.close();
  }

  private open(): void {
    // A refusal remains the state until another result is known.
    if (!this.refused) this.handlers.state({ kind: 'connecting', reason: this.reason });
    let socket: WebSocket;
    try {
      socket = new Socket(this.url);
    } catch (error) {
      this.closed = true;
      throw error; // an invalid address: retrying would not help
    }
    this.socket = socket;
    socket.binaryType = 'arraybuffer';
    this.timer = setTimeout(() => this.broke(socket), GIVE_UP_MS);
    let opened = false;
    socket.onopen = () => {
      opened = true;
      clearTimeout(this.timer);
      this.retry_ms = FIRST_RETRY_MS;
      this.reason = '';
      this.refused = false;
      this.handlers.state({ kind: 'open' });
    };
    socket.onmessage = (event: MessageEvent) => {
      if (typeof event.data === 'string') this.handlers.text(event.data);
      else this.handlers.binary(new Uint8Array(event.data as ArrayBuffer));
    };
    socket.onerror = () => {};
    socket.onclose = () => {
      if (opened) this.broke(socket);
      else void this.explain().then(() => this.broke(socket));
    };
  }

  private broke(socket: WebSocket): void {
    if (this.closed || socket !== this.socket) return;
    clearTimeout(this.timer);
    this.drop();
    if (this.reason === '') {
      this.reason = 'connection lost';
      this.handlers.state({ kind: 'connecting', reason: this.reason });
    }
    this.timer = setTimeout(() => this.open(), this.retry_ms);
    this.retry_ms = Math.min(2 * this.retry_ms, LONGEST_RETRY_MS);
  }

  // A WebSocket does not report why it was refused; the same address over HTTP does.
  private async explain(): Promise<void> {
    const before = this.reason;
    this.reason = `no reply from ${address(this.url)}`;
    this.refused = false;
    try {
      const response = await fetch(this.url.replace(/^ws/, 'http'), {
        signal: AbortSignal.timeout(GIVE_UP_MS / 2),
      });
      if (response.status === 426) this.reason = ''; // reachable again: it only requires the upgrade
      else if (!this.closed) {
        this.reason = (await response.text()).trim() || `HTTP ${response.status}`;
        this.refused = true;
        this.handlers.state({ kind: 'refused', reason: this.reason, status: response.status });
      }
    } catch {
      if (!this.closed && before !== this.reason) {
        this.handlers.state({ kind: 'connecting', reason: this.reason });
      }
    }
  }
}
