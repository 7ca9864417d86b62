"""Wrong arguments of the Python client: each refusal names the argument, what was found and what was
expected, of the blocking client and of that for asyncio."""
import asyncio
import math
import os
import subprocess
import sys
import unittest

import zmq

import styled
import styled.aio
from styled.commands import LOOK_FIELDS
from styled.look_options import LOOK_OPTIONS

HEADS = os.path.join(os.path.dirname(os.path.abspath(__file__)), '../../../clients/python/examples/heads.py')
NOBODY = 'ipc:///tmp/styled-nobody'

ENDPOINTS = [(TypeError, None, 'None'), (TypeError, 7, '7'), (TypeError, b'tcp://a:1', "b'tcp://a:1'"),
             (ValueError, '', "''"), (ValueError, 'nonsense', "'nonsense'"),
             (ValueError, '127.0.0.1:7001', "'127.0.0.1:7001'"), (ValueError, 'http://a:7001', "'http"),
             (ValueError, 'tcp://a', "'tcp://a'"), (ValueError, 'tcp://:7001', "'tcp://:7001'"),
             (ValueError, 'tcp://*:7001', r"'tcp://\*:7001'"), (ValueError, 'tcp://a:0', "'tcp://a:0'"),
             (ValueError, 'tcp://a:99999', "'tcp://a:99999'"), (ValueError, 'TCP://a:1', "'TCP://a:1'"),
             (ValueError, 'tcp://a:1 ', "'tcp://a:1 '"), (ValueError, 'inproc://a', "'inproc://a'"),
             (ValueError, 'ws://a:1', "'ws://a:1'"), (ValueError, 'ipc://', "'ipc://'")]
NO_SECONDS = [(TypeError, 'a', "'a'"), (TypeError, True, 'True'), (TypeError, [1], r'\[1\]'),
              (ValueError, math.nan, 'nan')]

SUBSCRIBER = {
    'performer': ([(TypeError, None, 'None'), (TypeError, 3, '3'), (ValueError, 'anna', "'anna'"),
                   (ValueError, '*', r"'\*'"), (ValueError, ' rig.a', "' rig.a'")],
                  "SOURCE.NAME .*, or '' for all"),
    'streams': ([(TypeError, 7, '7'), (TypeError, b'rig', "b'rig'"), (ValueError, [], 'none'),
                 (ValueError, 'Rig', "'Rig'"), (ValueError, ['rig', 'SOURCE'], "'SOURCE'"),
                 (ValueError, ['rig', None], 'None'), (ValueError, 'rig/', "'rig/'")],
                "(one or several of )?'(rig|source)'"),
    'statistics': ([(TypeError, 'no', "'no'"), (TypeError, None, 'None')], 'True or False'),
    'bundled': ([(TypeError, 0, '0')], 'True or False'),
    'queue_messages': ([(TypeError, 'a', "'a'"), (TypeError, 1.5, '1.5'), (TypeError, True, 'True'),
                        (TypeError, None, 'None'), (ValueError, 0, '0'), (ValueError, -1, '-1'),
                        (ValueError, 1 << 31, '2147483648')], '(a whole number, )?1'),
    'curve': ([(TypeError, 40 * 'x', "'x+'"), (TypeError, {}, '{}')], 'a styled.Curve'),
}
CONTROL = {
    'timeout': (NO_SECONDS + [(TypeError, None, 'None'), (ValueError, 0, '0'), (ValueError, -1, '-1'),
                              (ValueError, math.inf, 'inf')], '(seconds )?above 0'),
    'curve': SUBSCRIBER['curve'],
}


class OptionsTest(unittest.TestCase):
    def test_set_has_an_option_with_help_for_each_field_of_a_look(self):
        self.assertEqual(set(LOOK_OPTIONS), {'mix', *LOOK_FIELDS})
        for field, (word, _, text) in LOOK_OPTIONS.items():
            self.assertTrue(word and text, field)
        shown = subprocess.run([sys.executable, '-m', 'styled', 'set', '--help'], capture_output=True, text=True, check=True).stdout
        for option in ('--transition MS', '--input-style NAME', '--from NAME', '--amount X', '--vary 0..99|each'):
            self.assertIn(option, shown)
        self.assertIn('the variation changes slowly', ' '.join(shown.split()))


class ConstructorsTest(unittest.TestCase):
    def refuses(self, make, kind, argument, found, expected):
        with self.assertRaisesRegex(kind, f'{argument}.*{found}.*[,;] .*expected {expected}'):
            made = make()
            made.close()

    def test_each_argument(self):
        for make, table in ((styled.Subscriber, SUBSCRIBER), (styled.aio.Subscriber, SUBSCRIBER),
                            (styled.Control, CONTROL), (styled.aio.Control, CONTROL)):
            for argument, (cases, expected) in table.items():
                for kind, value, found in cases:
                    with self.subTest(make=make, argument=argument, value=value):
                        self.refuses(lambda: make(NOBODY, **{argument: value}), kind, argument, found,
                                     expected)

    def test_endpoints(self):
        for make in (styled.Subscriber, styled.aio.Subscriber, styled.Control, styled.aio.Control):
            for kind, value, found in ENDPOINTS:
                with self.subTest(make=make, endpoint=value):
                    self.refuses(lambda: make(value), kind, 'endpoint', found, '(one or several, )?e.g. tcp://')
        for make in (styled.Subscriber, styled.aio.Subscriber):
            self.refuses(lambda: make([]), ValueError, 'endpoints', 'none', '')
            self.refuses(lambda: make([NOBODY, 7]), TypeError, 'endpoints', '7', 'e.g. tcp://')

    def test_what_is_right_is_taken(self):
        for endpoint in ('tcp://127.0.0.1:7001', 'tcp://a-b.example:7001', 'tcp://[::1]:7001',
                         'tcp://lo;127.0.0.1:7001', NOBODY):
            styled.Control(endpoint, timeout=1e12).close()
            styled.Subscriber([endpoint], streams=('rig', 'Hero'), queue_messages=5).close()


class Ipv6Test(unittest.TestCase):
    def test_an_address_of_ipv6_is_reached(self):
        with zmq.Context() as context, context.socket(zmq.XPUB) as publisher:
            publisher.linger, publisher.ipv6 = 0, True
            try:
                port = publisher.bind_to_random_port('tcp://[::1]')
            except zmq.ZMQError as error:
                self.skipTest(f'no IPv6 here: {error}')
            with styled.Subscriber(f'tcp://[::1]:{port}'), styled.Control(f'tcp://[::1]:{port}') as control:
                self.assertTrue(publisher.poll(10_000))
                self.assertTrue(control._socket.ipv6)


class CallsTest(unittest.TestCase):
    def test_a_value_of_another_type(self):
        with styled.Control(NOBODY, timeout=0.01) as control:
            for call, text in ((lambda: control.set(None, style='old'), 'performer is None, expected SOURCE'),
                               (lambda: control.set('*', strength='a'), "strength is 'a', expected a number"),
                               (lambda: control.set('*', absolute='no'), "absolute is 'no', expected True"),
                               (lambda: control.set('*', vary='x'), "vary is 'x', expected a number"),
                               (lambda: control.set('*', preset=3), 'preset is 3, expected a name'),
                               (lambda: control.set('*', mix={'old': 'x'}), "mix has 'old': 'x', expected"),
                               (lambda: control.preset('*', 3), 'preset: name is 3, expected a name'),
                               (lambda: control.pin('*', 'no'), "pinned is 'no', expected True or False"),
                               (lambda: control.cue(None), 'cue: name is None, expected a name'),
                               (lambda: control.learn('rig.a', 'x', 'y'), "seconds is 'x', expected 1 to"),
                               (lambda: control.learn('rig.a', 5, 5), 'name is 5, expected a name')):
                with self.assertRaisesRegex(TypeError, text):
                    call()


class ExampleTest(unittest.TestCase):
    def test_says_what_is_wrong_in_one_line_below_its_usage(self):
        for arguments, code, text in ((['--help'], 0, ''), (['nonsense'], 2, "endpoints 'nonsense', expected"),
                                      ([NOBODY, 'nonsense'], 2, "endpoint 'nonsense', expected e.g. tcp"),
                                      ([NOBODY, NOBODY, 'old', 'many'], 2, "invalid int value: 'many'"),
                                      ([NOBODY, NOBODY, 'old', '1', 'x'], 2, 'unrecognized arguments: x')):
            done = subprocess.run([sys.executable, HEADS, *arguments], capture_output=True, text=True,
                                  timeout=60)
            self.assertEqual(done.returncode, code, done.stderr)
            self.assertIn('usage: heads.py', done.stdout + done.stderr)
            self.assertIn(text, done.stderr)
            self.assertNotIn('Traceback', done.stderr)


class WaitingTest(unittest.TestCase):
    def test_a_timeout_that_is_none(self):
        with styled.Subscriber(NOBODY) as subscriber:
            for call in (subscriber.receive, subscriber.receive_latest, lambda t: next(subscriber.frames(t))):
                for kind, value, found in NO_SECONDS:
                    with self.assertRaisesRegex(kind, f'timeout is {found}, expected seconds, or None'):
                        call(value)
            self.assertIsNone(subscriber.receive(-1))

    def test_a_timeout_that_is_none_for_asyncio(self):
        async def go():
            async with styled.aio.Subscriber(NOBODY) as subscriber:
                for call in (subscriber.receive, subscriber.receive_latest):
                    for kind, value, found in NO_SECONDS:
                        with self.assertRaisesRegex(kind, f'timeout is {found}, expected seconds, or None'):
                            await call(value)
                with self.assertRaises(asyncio.TimeoutError):
                    await asyncio.wait_for(subscriber.receive(math.inf), 0.05)
        asyncio.run(go())


if __name__ == '__main__':
    unittest.main()
