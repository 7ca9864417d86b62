// The WebSocket of this environment: the browser's own.
export const Socket = globalThis.WebSocket;
