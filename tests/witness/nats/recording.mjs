// A reader of the recording by the NATS project's own package (nats, Apache-2.0).
//   node recording.mjs PORT SUBJECT COUNT
// connects to 127.0.0.1:PORT as the user viewer, and prints as lines of JSON the stream's limits, then
// the first COUNT recorded messages of SUBJECT.
import { AckPolicy, connect, DeliverPolicy } from 'nats';

const [port, subject, count] = process.argv.slice(2);
const connection = await connect({
  servers: `127.0.0.1:${port}`, user: 'viewer', pass: process.env.VIEWER, inboxPrefix: '_INBOX_viewer',
});
const stream = (await connection.request('$JS.API.STREAM.INFO.STYLED_REC')).json();
console.log(`stream ${JSON.stringify(stream.config)}`);

const jetstream = connection.jetstream();
const manager = await connection.jetstreamManager();
const made = await manager.consumers.add('STYLED_REC', {
  ack_policy: AckPolicy.None,
  deliver_policy: DeliverPolicy.All,
  filter_subject: subject,
});
const consumer = await jetstream.consumers.get('STYLED_REC', made.name);
for await (const message of await consumer.fetch({ max_messages: Number(count), expires: 10000 })) {
  console.log(`message ${JSON.stringify({
    subject: message.subject,
    epoch: message.headers?.get('Styled-Epoch'),
    sequence: message.headers?.get('Styled-Sequence'),
    time: message.info.timestampNanos / 1e9,
    payload: Buffer.from(message.data).toString('base64'),
  })}`);
}
await connection.close();
process.exit(0);
