"""The Python client without sockets."""
import math
import random
import unittest
import unittest.mock

import styled
from styled import kinematics
from styled.commands import Commands, _set_request
from styled.inbox import Inbox, Kind, Newest, Stream
from styled.v1 import body_pb2, frame_pb2, stats_pb2

RIG = 'styled/rig.a/rig/'


def make_body(performer='rig.a', hash=11, output=body_pb2.OUTPUT_RIG):
    """hips, two joints above one another, and one at the hips' side."""
    return body_pb2.Body(performer=performer, names=['hips', 'chest', 'head', 'leg'],
                         parents=[-1, 0, 1, 0], offsets=[0, 1, 0, 0, 2, 0, 0, 3, 0, 4, 0, 0],
                         hash=hash, output=output)


def make_frame(sequence, body=None, epoch=1, rotations=None):
    body = body or make_body()
    return frame_pb2.Frame(performer=body.performer, epoch=epoch, sequence=sequence,
                           body_hash=body.hash, output=body.output, root_position=[1, 2, 3],
                           rotations=rotations or [0, 0, 0, 1] * 4)


def message(topic, content):
    return [topic.encode(), content.SerializeToString()]


class InboxTest(unittest.TestCase):
    def setUp(self):
        self.inbox = Inbox('rig.a')

    def body(self, **fields):
        body = make_body(**fields)
        return self.inbox.accept(message(f'body/{body.performer}/', body))

    def frame(self, sequence, **fields):
        return self.inbox.accept(message(RIG, make_frame(sequence, **fields)))

    def test_topics_of_one_performer_and_of_all(self):
        self.assertEqual(Inbox('rig.a', ['rig', Stream.CANONICAL, Stream.SOURCE, 'hero'], True).topics(),
                         ['stats/', 'body/rig.a/', RIG, 'styled/rig.a/canonical/', 'source/rig.a/',
                          'styled/rig.a/hero/'])
        for one in ('canonical', Stream.CANONICAL):
            self.assertEqual(Inbox('rig.a', one).topics(), ['body/rig.a/', 'styled/rig.a/canonical/'])
        self.assertEqual(Inbox('rig.a', 'hero').topics(), ['body/rig.a/', 'styled/rig.a/hero/'])
        everyone = Inbox()
        self.assertEqual(everyone.topics(), ['body/'])
        everyone.accept(message('body/rig.a/', make_body()))
        self.assertEqual(everyone.new_topics, [RIG])

    def test_a_bundle_is_its_frames_one_after_the_other(self):
        inbox = Inbox(streams=['rig', 'hero'], bundled=True)
        self.assertEqual(inbox.topics(), ['frames/rig/', 'body/'])
        for performer in ('rig.a', 'rig.b'):
            inbox.accept(message(f'body/{performer}/', make_body(performer)))
        self.assertEqual(inbox.new_topics, ['styled/rig.a/hero/', 'styled/rig.b/hero/'])
        a, b = (make_body(performer) for performer in ('rig.a', 'rig.b'))
        bad, strange = make_frame(3, a), make_frame(1, a)
        bad.rotations.append(1)
        strange.performer = 'a/b'
        frames = [make_frame(1, a), make_frame(1, b), make_frame(1, a), bad, strange, make_frame(4, a)]
        update = inbox.accept(message('frames/rig/', frame_pb2.Frames(frames=frames)))
        seen = []
        while update is not None:
            seen.append((update.frame.performer, update.frame.sequence, update.missed, update.stream,
                         update.body.performer))
            update = inbox.next()
        self.assertEqual(seen, [('rig.a', 1, 0, Stream.RIG, 'rig.a'), ('rig.b', 1, 0, Stream.RIG, 'rig.b'),
                                ('rig.a', 4, 2, Stream.RIG, 'rig.a')])
        self.assertEqual((inbox.counters.malformed, inbox.counters.repeated_frames), (2, 1))
        for topic in ('frames/hero/', 'frames/rig/x', 'frames/'):
            self.assertIsNone(inbox.accept(message(topic, frame_pb2.Frames(frames=frames))))
        self.assertIsNone(inbox.accept([b'frames/rig/', b'\xff']))
        self.assertEqual(inbox.counters.malformed, 6)
        with self.assertRaisesRegex(ValueError, "performer 'rig.a', expected ''"):
            Inbox('rig.a', bundled=True)

    def test_refuses_a_performer_that_is_none(self):
        for bad in ('rig', 'rig.', '.a', 'a.b.c', 'a b.c', 'rig.a/', '*', 'a.' + 33 * 'x', 'rig.a\n'):
            with self.assertRaisesRegex(ValueError, 'SOURCE.NAME', msg=bad):
                Inbox(bad)

    def test_refuses_a_stream_that_is_none(self):
        for bad in (Stream.AVATAR, '', 'a/b', 3):
            with self.assertRaisesRegex(ValueError, "expected 'rig', 'canonical'", msg=bad):
                Inbox(streams=[bad])
        for bad in (Stream.AVATAR, '', 'rig,canonical'):
            with self.assertRaisesRegex(ValueError, "expected 'rig', 'canonical'", msg=bad):
                Inbox(streams=bad)
        for bad in ('Rig', 'CANONICAL', 'Source'):
            with self.assertRaisesRegex(ValueError, f"streams has '{bad}', expected '{bad.lower()}'"):
                Inbox(streams=bad)

    def test_no_stream_has_to_be_said(self):
        for none in ([], (), iter(())):
            with self.assertRaisesRegex(ValueError, 'streams has none, .* expected one or several'):
                Inbox(streams=none)
        self.assertEqual(Inbox(streams=None).topics(), ['body/'])
        self.assertEqual(Inbox(streams=[], statistics=True).topics(), ['stats/', 'body/'])

    def test_avatars_are_told_apart_by_their_outputs_names(self):
        for name in ('hero', 'villain'):
            body = make_body(output=body_pb2.OUTPUT_AVATAR)
            body.output_name = name
            self.inbox.accept(message('body/rig.a/', body))
            update = self.inbox.accept(message(f'styled/rig.a/{name}/', make_frame(1, body=body)))
            self.assertEqual((update.stream, update.output_name, update.body.output_name),
                             (Stream.AVATAR, name, name))
        self.assertEqual(self.inbox.counters.bodies, 2)

    def test_frames_get_their_body_when_it_is_here(self):
        self.assertIsNone(self.frame(1).body)
        self.assertEqual(self.body().kind, Kind.BODY)
        update = self.frame(2)
        self.assertEqual((update.kind, update.stream, update.body.hash), (Kind.FRAME, Stream.RIG, 11))
        self.assertEqual(self.inbox.performers(), ['rig.a'])

    def test_counts_gaps_repetitions_and_restarts(self):
        self.body()
        self.assertEqual(self.frame(5).missed, 0)
        self.assertEqual(self.frame(9).missed, 3)
        self.assertIsNone(self.frame(9))
        self.assertIsNone(self.frame(4))
        restarted = self.frame(1, epoch=2)
        self.assertEqual((restarted.missed, restarted.new_epoch), (0, True))
        self.assertEqual(self.frame(2, epoch=2).new_epoch, False)
        counters = self.inbox.counters
        self.assertEqual((counters.frames, counters.missed, counters.repeated_frames, counters.epochs),
                         (4, 3, 2, 1))

    def test_knows_replayed_bodies_and_follows_a_change(self):
        self.assertIsNotNone(self.body())
        self.assertIsNone(self.body())
        self.assertIsNotNone(self.body(output=body_pb2.OUTPUT_CANONICAL))
        self.assertEqual(self.inbox.counters.replayed_bodies, 1)
        for hash in range(20, 100):  # no more than a few are kept
            self.assertIsNotNone(self.body(hash=hash))
            self.assertEqual(self.frame(hash, body=make_body(hash=hash)).body.hash, hash)
        self.assertIsNone(self.frame(150).body)

    def test_drops_what_is_malformed(self):
        self.body()
        bodies = [dict(parents=[-1, 0, 3, 0]), dict(parents=[0, 0, 1, 0]), dict(offsets=[0] * 11),
                  dict(offsets=[math.inf] + [0] * 11), dict(rest=[0, 0, 0, 1]), dict(names=[])]
        messages = [[b'body/rig.a/'], [b'body/rig.a/', b'', b''], [b'body/rig.a/', b'\xff\xff'],
                    [b'\xff/', b''], message('nonsense/', make_frame(1)),
                    message('body/rig.b/', make_body()),
                    message('styled/rig.b/rig/', make_frame(1)),
                    message('styled/rig.a/canonical/', make_frame(1)),
                    message('styled/rig/rig/', make_frame(1)),
                    message(RIG, make_frame(1, rotations=[0, 0, 0, 1] * 3)),
                    message(RIG, make_frame(1, rotations=[0] * 16)),
                    message(RIG, make_frame(1, rotations=[math.nan] + [1] * 15))]
        for fields in bodies:
            body = make_body(hash=99)
            for name, value in fields.items():
                body.ClearField(name)
                getattr(body, name).extend(value)
            messages.append(message('body/rig.a/', body))
        for parts in messages:
            self.assertIsNone(self.inbox.accept(parts), parts)
        self.assertEqual(self.inbox.counters.malformed, len(messages))

    def test_takes_any_bytes(self):
        chance = random.Random(1)
        for _ in range(3000):
            parts = [chance.choice([RIG, 'body/rig.a/', 'stats/', 'source/rig.a/']).encode(),
                     bytes(chance.randrange(256) for _ in range(chance.randrange(40)))]
            self.inbox.accept(parts)

    def test_newest_keeps_one_frame_of_each_stream_and_what_was_lost(self):
        self.body()
        newest = Newest()
        for sequence in (1, 2, 5, 6):
            newest.add(self.frame(sequence))
        newest.add(self.inbox.accept(message('stats/', stats_pb2.Stats(epoch=3))))
        frame, statistics = newest.take()
        self.assertEqual((frame.frame.sequence, frame.skipped, frame.missed), (6, 3, 2))
        self.assertEqual(statistics.statistics.epoch, 3)


class KinematicsTest(unittest.TestCase):
    def test_a_quarter_turn_of_the_chest_moves_the_head_alone(self):
        half = math.sqrt(0.5)
        turned = [0, 0, 0, 1] + [half, 0, 0, half] + [0, 0, 0, 1] * 2  # about +X: +Y becomes +Z
        world = kinematics.world_transforms(make_body(), make_frame(1, rotations=turned))
        expected = [(1, 2, 3), (1, 4, 3), (1, 4, 6), (5, 2, 3)]
        for transform, position in zip(world, expected):
            for got, wanted in zip(transform.position, position):
                self.assertAlmostEqual(got, wanted, 6)
        self.assertAlmostEqual(world[2].rotation[0], half, 6)

    def test_joints_have_names(self):
        body = make_body()
        body.names[3] = 'head'  # a second one of this name
        world = kinematics.world_transforms(body, make_frame(1))
        self.assertEqual(world.names, ('hips', 'chest', 'head', 'head'))
        self.assertEqual((world['head'], world[-1].position), (world[2], (5, 2, 3)))
        self.assertEqual((world.get('chest'), world.get('jaw'), world.get('jaw', world[0])),
                         (world[1], None, world[0]))
        self.assertEqual([name in world for name in ('hips', 'jaw')], [True, False])
        self.assertEqual((len(world), list(world)[1], world[1] in world), (4, world[1], True))
        with self.assertRaisesRegex(KeyError, "no joint 'Head'; there is head"):
            world['Head']
        with self.assertRaises(IndexError):
            world[4]

    def test_the_whole_is_numpys_where_numpy_is(self):
        world = kinematics.world_transforms(make_body(), make_frame(1))
        rows = [list(t.position) for t in world], [list(t.rotation) for t in world]
        if kinematics._numpy() is not None:
            self.assertEqual((world.positions.shape, world.rotations.shape), ((4, 3), (4, 4)))
            self.assertEqual((world.positions.tolist(), world.rotations.tolist()), rows)
        with unittest.mock.patch.object(kinematics, '_numpy', lambda: None):
            self.assertEqual(world.positions, [t.position for t in world])
            self.assertEqual(world.rotations, [t.rotation for t in world])

    def test_rotations_are_normalized(self):
        world = kinematics.world_transforms(make_body(), make_frame(1, rotations=[0, 0, 0, 2] * 4))
        self.assertEqual(world[3].rotation, (0, 0, 0, 1))

    def test_refuses_a_frame_of_another_body(self):
        with self.assertRaisesRegex(ValueError, 'another body'):
            kinematics.world_transforms(make_body(hash=12), make_frame(1))


class RequestTest(unittest.TestCase):
    def test_set_says_what_is_given_and_no_more(self):
        request = _set_request('*', 'old', None, {'strength': 0.5, 'parts': ['head', 'left-arm']})
        self.assertEqual([(w.style, w.weight) for w in request.set.mix], [('old', 1)])
        self.assertEqual((request.set.strength, list(request.set.parts)), (0.5, [1, 3]))
        self.assertFalse(request.set.HasField('root'))
        self.assertEqual(_set_request('*', None, None, {'root': 'stride'}).set.root, 1)
        self.assertFalse(request.set.HasField('transition_ms') or request.set.HasField('input_style'))
        varied = _set_request('*', None, None, {'vary': 7, 'vary_amount': 0.5, 'drift_s': 5}).set
        self.assertEqual((varied.vary, varied.vary_amount, varied.drift_s), (7, 0.5, 5))
        self.assertFalse(varied.HasField('vary_each'))
        former = _set_request('*', None, None, {'only': ['head'], 'own_style': 'old'}).set
        self.assertEqual((list(former.parts), former.input_style), ([1], 'old'))

    def test_refuses_wrong_arguments(self):
        for arguments in (('anna', 'old', None, {}), ('*', 'old', {'old': 1}, {}),
                          ('*', 'old', None, {'parts': ['tail']}),
                          ('*', 'old', None, {'root': 'home'})):
            with self.assertRaises(ValueError):
                _set_request(*arguments)
        with self.assertRaisesRegex(TypeError, "no 'strenght', expected style, mix, strength"):
            _set_request('*', 'old', None, {'strenght': 1})

    def test_keys_are_z85_or_raw(self):
        for bad in ('', 'x' * 39, b'x' * 31, '~' * 40):
            with self.assertRaisesRegex(ValueError, 'Z85'):
                styled.Subscriber(curve=styled.Curve(bad))
        with self.assertRaisesRegex(ValueError, 'pair'):
            styled.Control(curve=styled.Curve(b'x' * 32, b'x' * 32))


class ArgumentsTest(unittest.TestCase):
    """Requests that are refused before anything is sent."""

    class Nobody(Commands):
        def _do(self, request, result):
            raise AssertionError('sent')

    def test_seconds_that_are_none(self):
        for seconds in (math.nan, math.inf, -math.inf, -1):
            with self.assertRaisesRegex(ValueError, 'expected 1 to 60'):
                self.Nobody().learn('rig.a', seconds, 'x')
            with self.assertRaisesRegex(ValueError, 'expected 1 to 60'):
                self.Nobody().measure_take('rig.a', seconds)

    def test_a_mix_is_weights_by_style(self):
        for mix in ('x', ['x'], 3):
            with self.assertRaisesRegex(TypeError, 'expected weights by style'):
                self.Nobody().set('rig.a', mix=mix)
        with self.assertRaisesRegex(TypeError, 'expected the name of one'):
            self.Nobody().set('rig.a', style=['x'])

    def test_keys_are_looked_at_at_once(self):
        with self.assertRaisesRegex(ValueError, 'server_key: 1 bytes, expected 40 characters'):
            styled.Curve('x')
        for key in (None, 7):
            with self.assertRaisesRegex(TypeError, 'curve: server_key'):
                styled.Curve(key)
        with self.assertRaisesRegex(ValueError, 'expected both or none'):
            styled.Curve(32 * b'x', public_key=32 * b'y')


if __name__ == '__main__':
    unittest.main()
