import { Code } from './gen/proto/styled/v1/control_pb.js';

/** The daemon said no; nothing changed. `message` is its reason. */
export class RefusedError extends Error {
  override name = 'RefusedError';
  constructor(
    readonly code: Code,
    reason: string,
  ) {
    super(reason || Code[code] || `CODE_${code}`);
  }
}

/** Nobody answered in time, or the gateway went away; it may or may not have been applied. */
export class NoAnswerError extends Error {
  override name = 'NoAnswerError';
  constructor(
    message: string,
    /** The request was sent. If not, nothing changed. */
    readonly sent = true,
  ) {
    super(message);
  }
}
