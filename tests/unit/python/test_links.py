"""A subscriber comes back although another program broke the protocol at the daemon's address."""
import asyncio
import socket
import threading
import time
import unittest

import zmq

import styled
import styled.aio


def break_protocol(endpoint, seconds):
    """Answers each connection with bytes that are not ZeroMQ; returns their number."""
    host, port = endpoint.removeprefix('tcp://').split(':')
    with socket.create_server((host, int(port)), reuse_port=False) as listener:
        listener.settimeout(0.1)
        came = 0
        end = time.monotonic() + seconds
        while time.monotonic() < end:
            try:
                connection, _ = listener.accept()
            except socket.timeout:
                continue
            came += 1
            connection.sendall(b'\xff' + bytes(200))
            time.sleep(0.05)
            connection.close()
        return came


def free_endpoint():
    with socket.create_server(('127.0.0.1', 0)) as listener:
        return f'tcp://127.0.0.1:{listener.getsockname()[1]}'


class LinksTest(unittest.TestCase):
    def setUp(self):
        self.endpoint = free_endpoint()
        self.came = []
        self.stranger = threading.Thread(
            target=lambda: self.came.append(break_protocol(self.endpoint, 1.0)))
        self.stranger.start()
        self.context = zmq.Context()
        self.addCleanup(self.context.term)

    def publisher(self):
        self.stranger.join()
        self.assertGreater(self.came[0], 0)
        publisher = self.context.socket(zmq.PUB)
        publisher.linger = 0
        publisher.bind(self.endpoint)
        self.addCleanup(publisher.close)

    def test_that_waits(self):
        with styled.Subscriber(self.endpoint) as subscriber:
            subscriber.receive(1.5)
            self.publisher()
            end = time.monotonic() + 10
            while subscriber.connected() == 0 and time.monotonic() < end:
                subscriber.receive(0.1)
            self.assertEqual(subscriber.connected(), 1)

    def test_of_asyncio(self):
        async def run():
            async with styled.aio.Subscriber(self.endpoint) as subscriber:
                await subscriber.receive(1.5)
                self.publisher()
                end = time.monotonic() + 10
                while subscriber.connected() == 0 and time.monotonic() < end:
                    await subscriber.receive(0.1)
                self.assertEqual(subscriber.connected(), 1)
        asyncio.run(run())


if __name__ == '__main__':
    unittest.main()
