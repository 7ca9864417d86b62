// A fake styleweb: sends what a test specifies, and stores what it receives.
import { existsSync, readFileSync } from 'node:fs';
import http from 'node:http';
import path from 'node:path';
import { WebSocketServer } from 'ws';
import { create, fromBinary, toBinary } from '@bufbuild/protobuf';
import { BodySchema, FrameSchema, Output, ReplySchema, RequestSchema } from 'styled-client';

const TYPES = { '.html': 'text/html', '.js': 'text/javascript', '.css': 'text/css', '.svg': 'image/svg+xml' };

export class Gateway {
  topics = new Set();
  heard = []; // texts
  token = '';
  page = ''; // folder of files that it serves
  answer = () => undefined; // Request -> Reply's fields, or a notice, or nothing; or a promise of them

  static async start(port = 0) {
    const gateway = new Gateway();
    gateway.http = http.createServer((request, response) => {
      const { pathname } = new URL(request.url, 'http://x');
      const file = path.join(gateway.page, pathname === '/' ? 'index.html' : pathname);
      if (gateway.page && existsSync(file)) {
        response.writeHead(200, { 'Content-Type': TYPES[path.extname(file)] ?? 'application/octet-stream' });
        return response.end(readFileSync(file));
      }
      response.writeHead(gateway.allows(request) ? 426 : 401);
      response.end('the token is missing or wrong\n');
    });
    gateway.sockets = new WebSocketServer({ noServer: true });
    gateway.http.on('upgrade', (request, socket, head) => {
      if (!gateway.allows(request)) {
        socket.end('HTTP/1.1 401 Unauthorized\r\nContent-Length: 0\r\nConnection: close\r\n\r\n');
        return;
      }
      gateway.sockets.handleUpgrade(request, socket, head, (client) => gateway.#join(client));
    });
    await new Promise((resolve) => gateway.http.listen(port, '127.0.0.1', resolve));
    gateway.port = gateway.http.address().port;
    gateway.url = `http://127.0.0.1:${gateway.port}`;
    return gateway;
  }

  allows(request) {
    return new URL(request.url, 'http://x').searchParams.get('token') === (this.token || null);
  }

  onSubscribe() {}
  onJoin() {}

  #join(client) {
    this.onJoin();
    client.on('message', (data, binary) => {
      if (binary) {
        const request = fromBinary(RequestSchema, new Uint8Array(data));
        const send = (answer) => {
          if (answer?.notice) client.send(JSON.stringify(answer.notice));
          else if (answer) {
            const reply = create(ReplySchema, { id: request.id, ...answer });
            client.send(packed('', toBinary(ReplySchema, reply)));
          }
        };
        const answer = this.answer(request);
        if (answer instanceof Promise) void answer.then(send);
        else send(answer);
        return;
      }
      this.heard.push(String(data));
      const message = JSON.parse(String(data));
      for (const topic of message.subscribe ?? []) {
        this.topics.add(topic);
        this.onSubscribe(topic);
      }
      for (const topic of message.unsubscribe ?? []) this.topics.delete(topic);
    });
  }

  notice(notice) {
    for (const client of this.sockets.clients) client.send(JSON.stringify(notice));
  }
  publish(topic, bytes) {
    for (const client of this.sockets.clients) client.send(packed(topic, bytes));
  }
  drop() {
    this.topics.clear();
    for (const client of this.sockets.clients) client.terminate();
  }
  async stop() {
    this.drop();
    this.http.closeAllConnections();
    await new Promise((resolve) => this.http.close(resolve));
  }
}

function packed(topic, bytes) {
  return Buffer.concat([Buffer.from([topic.length]), Buffer.from(topic), bytes]);
}

export async function until(condition, what) {
  for (let i = 0; i < 1000; ++i) {
    if (condition()) return;
    await new Promise((resolve) => setTimeout(resolve, 10));
  }
  throw new Error(`waited in vain for ${what}`);
}

// Two joints, one above the other.
export const body = (fields = {}) =>
  toBinary(BodySchema, create(BodySchema, {
    performer: 'rig.a', names: ['hips', 'head'], parents: [-1, 0], offsets: [0, 1, 0, 0, 0.6, 0],
    metresPerUnit: 1, hash: 7n, output: Output.RIG, ...fields,
  }));

export const frame = (sequence, fields = {}) =>
  toBinary(FrameSchema, create(FrameSchema, {
    performer: 'rig.a', epoch: 1n, sequence: BigInt(sequence), bodyHash: 7n, output: Output.RIG,
    rootPosition: [0, 1, 0], rotations: [0, 0, 0, 1, 0, 0, 0, 1], ...fields,
  }));
