"""Changes without a visible effect: the Python client warns, on the line that requested them."""
import asyncio
import inspect
import os
import subprocess
import sys
import time
import unittest
import unittest.mock
import warnings

import zmq

import styled
import styled.aio
from fake_daemon import FakeDaemon
from styled import doubts
from styled.v1 import body_pb2, control_pb2, frame_pb2

ABSENT = "no performer of the name 'stage.ann' is present: the change waits for it"
WEAK = 'the strength of stage.anna is 0: no style is visible'


def answer(request):
    """The status of a daemon where only stage.anna performs, with strength 0 and a style."""
    reply = control_pb2.Reply()
    for name in ['stage.anna', 'stage.old'] if request.performer == '*' else [request.performer]:
        reply.applied.add(performer=name, first_sequence=7, absent=name != 'stage.anna',
                          no_strength=name == 'stage.anna')
    return reply


def here():
    return inspect.currentframe().f_back.f_lineno


class UnseenTest(unittest.TestCase):
    def setUp(self):
        self.daemon = FakeDaemon(answer)
        self.daemon.__enter__()
        self.addCleanup(self.daemon.__exit__)
        caught = warnings.catch_warnings(record=True)
        self.said = caught.__enter__()
        self.addCleanup(caught.__exit__, None, None, None)
        warnings.simplefilter('always')

    def heard(self):
        """The warnings since the last call."""
        said = [(w.category, str(w.message), w.filename, w.lineno) for w in self.said]
        self.said.clear()
        return said

    def test_a_name_under_which_nobody_performs_is_told_at_the_callers_line(self):
        with styled.Control(self.daemon.endpoint) as control:
            for call in (lambda: control.set('stage.ann', style='old'),
                         lambda: control.clear('stage.ann'),
                         lambda: control.preset('stage.ann', 'calm'),
                         lambda: control.pin('stage.ann')):
                applied = call()
                self.assertEqual((applied, applied.absent, applied.no_strength),
                                 ({'stage.ann': 7}, {'stage.ann'}, frozenset()))
                self.assertEqual(self.heard(), [(styled.AbsentPerformer, ABSENT, __file__,
                                                 call.__code__.co_firstlineno)])

    def test_a_style_without_strength_is_told(self):
        with styled.Control(self.daemon.endpoint) as control:
            applied, line = control.set('stage.anna', style='old'), here()
            self.assertEqual(applied.no_strength, {'stage.anna'})
            self.assertEqual(self.heard(), [(styled.NoStrength, WEAK, __file__, line)])
            control.set('stage.anna', style='old', strength=0)  # as requested
            control.pin('stage.anna')
            self.assertEqual(self.heard(), [])

    def test_a_style_without_variations_and_performers_that_did_not_change_are_told(self):
        def partly(request):
            reply = control_pb2.Reply()
            reply.applied.add(performer='stage.bob', refused='stage.bob: too strong')
            reply.applied.add(performer='stage.anna', first_sequence=7, not_varied='giant')
            return reply
        with FakeDaemon(partly) as daemon, styled.Control(daemon.endpoint) as control:
            applied, line = control.set('*', style='giant'), here()
        self.assertEqual((applied, applied.not_varied, applied.refused),
                         ({'stage.anna': 7}, {'stage.anna': 'giant'}, {'stage.bob': 'stage.bob: too strong'}))
        self.assertEqual(self.heard(), [
            (styled.NotVaried, "stage.anna: 'giant' has no variations and is shown as it is", __file__, line),
            (styled.NotChanged, 'not changed: stage.bob: too strong', __file__, line)])

    def test_whom_nobody_has_named_is_not_missed(self):
        with styled.Control(self.daemon.endpoint) as control:
            self.assertEqual(control.set('*', strength=0).absent, {'stage.old'})
            control.panic()
            control.restore_checkpoint(b'', 'stage.ann')
            self.assertEqual(self.heard(), [])

    def test_asyncio_tells_the_line_too_where_a_task_calls(self):
        async def go():
            async with styled.aio.Control(self.daemon.endpoint) as control:
                _, line = await control.set('stage.ann', style='old'), here()
                self.assertEqual(self.heard(), [(styled.AbsentPerformer, ABSENT, __file__, line)])
                _, line = await asyncio.gather(control.set('stage.ann', style='old')), here()
                self.assertEqual(self.heard(), [(styled.AbsentPerformer, ABSENT, __file__, line)])
        asyncio.run(go())

    def test_a_program_that_wants_an_error_has_one(self):
        warnings.simplefilter('error', styled.Unseen)
        with styled.Control(self.daemon.endpoint) as control:
            with self.assertRaisesRegex(styled.AbsentPerformer, 'stage.ann'):
                control.set('stage.ann', style='old')
            self.assertEqual(len(self.daemon.requests), 1)

    def test_the_command_line_says_it_plainly(self):
        self.maxDiff = None
        def run(*arguments):
            done = subprocess.run([sys.executable, '-m', 'styled', *arguments, '--control',
                                   self.daemon.endpoint], capture_output=True, text=True, timeout=60,
                                  env=dict(os.environ))
            return done.returncode, done.stdout, done.stderr
        self.assertEqual(run('set', 'stage.ann', '--style', 'old'),
                         (0, 'stage.ann: set, from their first frame\n', f'python3 -m styled: {ABSENT}\n'))
        self.assertEqual(run('set', 'stage.anna', '--style', 'old'),
                         (0, 'stage.anna: set, from frame 7 on\n', f'python3 -m styled: {WEAK}\n'))
        self.assertEqual(run('like', 'stage.ann', '--clip', __file__, '--name', 'mine')[2],
                         f'python3 -m styled: {ABSENT}\n')


def publish(publisher, performer, names, stream, sequence):
    """A daemon's frames of a performer with these avatars: bodies for new subscriptions, and a
    frame."""
    for name in ('', *names):
        body = body_pb2.Body(performer=performer, names=['hips'], parents=[-1], offsets=[0, 1, 0], hash=7,
                             output=body_pb2.OUTPUT_AVATAR if name else body_pb2.OUTPUT_RIG, output_name=name)
        publisher.send_multipart([f'body/{performer}/'.encode(), body.SerializeToString()])
    frame = frame_pb2.Frame(performer=performer, epoch=1, sequence=sequence, body_hash=7,
                            output=body_pb2.OUTPUT_RIG, root_position=[0, 1, 0], rotations=[0, 0, 0, 1])
    publisher.send_multipart([f'styled/{performer}/{stream}/'.encode(), frame.SerializeToString()])


class SilenceTest(unittest.TestCase):
    def setUp(self):
        context = zmq.Context()
        self.addCleanup(context.term)
        self.publisher = context.socket(zmq.XPUB)
        self.addCleanup(self.publisher.close, 0)
        self.endpoint = f'tcp://127.0.0.1:{self.publisher.bind_to_random_port("tcp://127.0.0.1")}'
        patience = unittest.mock.patch.multiple(doubts, PATIENCE_S=0.3, LOOK_S=0.05)
        patience.start()
        self.addCleanup(patience.stop)

    def hears(self, category, text, seconds=10, **arguments):
        """Reads until a warning, or for this long; frames of rig.a arrive all the while."""
        with warnings.catch_warnings(record=True) as said, \
                styled.Subscriber(self.endpoint, **arguments) as subscriber:
            warnings.simplefilter('always')
            begun = time.monotonic()
            for sequence in range(1, 1_000_000):
                publish(self.publisher, 'rig.a', ['hero'], 'rig', sequence)
                subscriber.receive(0.01)
                if said and seconds == 10:
                    seconds = time.monotonic() - begun + 0.5  # it is not said again
                if time.monotonic() - begun > seconds:
                    break
        self.assertEqual([(w.category, str(w.message), w.filename) for w in said],
                         [(category, text, __file__)] if category else [])

    def test_a_performer_who_does_not_come_is_told_once(self):
        self.hears(styled.AbsentPerformer, "no performer of the name 'rig.b' is present yet: frames arrive once it is",
                   performer='rig.b')

    def test_an_output_that_nobody_has_is_told_once_while_other_frames_come(self):
        self.hears(styled.AbsentOutput, "no performer has an output 'heor' yet, they have canonical, hero, rig, "
                   'source: frames arrive when one has', streams=['rig', 'heor'])

    def test_who_and_what_is_there_is_not_missed(self):
        self.hears(None, '', seconds=1, performer='rig.a', streams=['rig', 'hero'])
        self.hears(None, '', seconds=1, streams='canonical')
        self.publisher.close(0)  # without a daemon no performer is missed
        with warnings.catch_warnings(record=True) as said, \
                styled.Subscriber('ipc:///tmp/styled-nobody', performer='rig.b') as subscriber:
            warnings.simplefilter('always')
            self.assertIsNone(subscriber.receive(0.7))
        self.assertEqual(said, [])

    def test_asyncio_has_the_same(self):
        async def go():
            async with styled.aio.Subscriber(self.endpoint, performer='rig.b') as subscriber:
                with self.assertWarnsRegex(styled.AbsentPerformer, "'rig.b' is present yet"):
                    await subscriber.receive(3)
        asyncio.run(go())


if __name__ == '__main__':
    unittest.main()
