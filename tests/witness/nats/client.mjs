// A viewer by the NATS project's own package (nats, Apache-2.0).
//   node client.mjs PORT SUBJECT COUNT KEY
// connects to 127.0.0.1:PORT as the user viewer, and prints as lines of JSON the first COUNT messages of
// SUBJECT with their headers, then the value of KEY in the bucket `styled`.
import { connect } from 'nats';

const [port, subject, count, key] = process.argv.slice(2);
const base64 = (bytes) => Buffer.from(bytes).toString('base64');
const print = (what, value) => console.log(`${what} ${JSON.stringify(value)}`);

const connection = await connect({
  servers: `127.0.0.1:${port}`, user: 'viewer', pass: process.env.VIEWER, inboxPrefix: '_INBOX_viewer',
});
const subscription = connection.subscribe(subject, { max: Number(count) });
for await (const message of subscription) {
  print('frame', {
    subject: message.subject,
    epoch: message.headers?.get('Styled-Epoch'),
    sequence: message.headers?.get('Styled-Sequence'),
    payload: base64(message.data),
  });
}
const bucket = await connection.jetstream().views.kv('styled', { bindOnly: true });
const entry = await bucket.get(key);
print('value', { key: entry.key, operation: entry.operation, payload: base64(entry.value) });
await connection.close();
process.exit(0);
