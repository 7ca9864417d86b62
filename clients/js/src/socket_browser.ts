// The WebSocket implementation: the browser's own.
export const Socket = globalThis.WebSocket;
