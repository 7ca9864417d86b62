// A client of QTM RT by Qualisys' own package (qualisys-rt, MIT).
//   node client.mjs PORT MINOR FRAMES
// connects to 127.0.0.1:PORT as version 1.MINOR, asks for everything that it can ask for, and prints each
// answer as a line "WHAT JSON"; then FRAMES frames of markers, streamed.
import qtmrt from 'qualisys-rt';

const [port, minor, count] = process.argv.slice(2).map(Number);
const api = new qtmrt.Api({ debug: false });
const print = (what, value) => console.log(`${what} ${JSON.stringify(value)}`);

await api.connect(port, '127.0.0.1', 1, minor);
print('version', await api.qtmVersion());
print('byteOrder', await api.byteOrder());
print('state', await api.getState());
print('general', await api.getParameters('General'));
print('space', await api.getParameters('3D'));
print('skeleton', await api.getParameters('Skeleton'));
print('current', await api.getCurrentFrame('3D'));
await api.setQtmEvent('x').catch((error) => print('error', { type: error.typeName, text: error.data }));
let left = count;
await new Promise((done) => {
  api.on('frame', (frame) => {
    if (left-- > 0) print('frame', frame);
    if (left === 0) done();
  });
  api.streamFrames({ components: ['3D'], frequency: 'AllFrames' });
});
api.on('event', (event) => print('event', event));
api.disconnect();
process.exit(0);
