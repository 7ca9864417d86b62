import { Code } from './gen/proto/styled/v1/control_pb.js';

/** The daemon refused; nothing changed. `message` is its reason. */
export class RefusedError extends Error {
  override name = 'RefusedError';
  constructor(
    readonly code: Code,
    reason: string,
  ) {
    super(reason || Code[code] || `CODE_${code}`);
  }
}

/** No reply in time, or the connection to the gateway was lost; the request may have been applied. */
export class NoAnswerError extends Error {
  override name = 'NoAnswerError';
  constructor(
    message: string,
    /** Whether the request was sent. If not, nothing changed. */
    readonly sent = true,
  ) {
    super(message);
  }
}
