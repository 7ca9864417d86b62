// A program that receives VMC, with others' OSCQuery and mDNS (npm: oscquery, @homebridge/ciao).
//   node offer.mjs NAME
// prints its OSC port as "port NUMBER", and each OSC address once that arrives there, "osc ADDRESS".
import dgram from 'node:dgram';
import oscquery from 'oscquery';

const { OSCQueryServer, OSCQAccess, OSCTypeSimple } = oscquery;
const socket = dgram.createSocket('udp4');
await new Promise((done) => socket.bind(0, '0.0.0.0', done));

const floats = Array(7).fill({ type: OSCTypeSimple.FLOAT });
const server = new OSCQueryServer({
  serviceName: process.argv[2], oscQueryHostName: process.argv[2], bindAddress: '0.0.0.0', oscPort: socket.address().port,
});
server.addMethod('/VMC/Ext/Bone/Pos', {
  access: OSCQAccess.WRITEONLY, arguments: [{ type: OSCTypeSimple.STRING }, ...floats],
});
server.addMethod('/status', { access: OSCQAccess.READONLY, arguments: [{ type: OSCTypeSimple.INT }] });
await server.start();
console.log(`port ${socket.address().port}`);

const seen = new Set();
socket.on('message', (bytes) => {
  for (const [address] of bytes.toString('latin1').matchAll(/\/VMC\/[\w/]+/g)) {
    if (!seen.has(address)) console.log(`osc ${address}`);
    seen.add(address);
  }
});
