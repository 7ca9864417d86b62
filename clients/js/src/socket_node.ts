// The WebSocket of this environment: Node has one of its own from version 22 on, but none that takes
// headers; so always ws.
import { WebSocket } from 'ws';

export const Socket = WebSocket as unknown as typeof globalThis.WebSocket;
