// Finds OSCQuery servers and OSC receivers by others' mDNS and OSCQuery (npm: oscquery, bonjour-service).
//   node discover.mjs
// prints each as it comes and goes, as a line "WHAT JSON", and sends one OSC message to each server's OSC
// address, as a program would that has found it.
import dgram from 'node:dgram';
import { Bonjour } from 'bonjour-service';
import oscquery from 'oscquery';

const print = (what, value) => console.log(`${what} ${JSON.stringify(value)}`);

// A message without arguments: text padded to a multiple of four with at least one zero.
const message = Buffer.from('/witness\0\0\0\0,\0\0\0');
const socket = dgram.createSocket('udp4');

const discovery = new oscquery.OSCQueryDiscovery();
discovery.on('up', (service) => {
  const { name, oscIp, oscPort, oscTransport } = service.hostInfo;
  const methods = {};
  for (const method of service.flat()) {
    methods[method.full_path] = { access: method.access, types: (method.arguments ?? []).map((a) => a.type).join('') };
  }
  print('up', { name, address: service.address, port: service.port, oscIp, oscPort, oscTransport, methods });
  socket.send(message, oscPort, oscIp);
});
discovery.on('down', (service) => print('down', { name: service.hostInfo.name }));
discovery.start();

const receivers = new Bonjour().find({ type: 'osc', protocol: 'udp' });
receivers.on('up', (service) => print('osc', { name: service.name, port: service.port, addresses: service.addresses }));
