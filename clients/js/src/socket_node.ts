// The WebSocket implementation: always ws. Node's own (from version 22 on) does not accept request
// headers.
import { WebSocket } from 'ws';

export const Socket = WebSocket as unknown as typeof globalThis.WebSocket;
