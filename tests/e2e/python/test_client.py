"""The Python client against the real daemon."""
import asyncio
import os
import subprocess
import sys
import time
import unittest
import warnings

import zmq

import styled
import styled.aio
from daemon import PATIENCE_S, Daemon, wait_for
from fake_daemon import FakeDaemon
from styled.v1 import control_pb2

STREAMS = (styled.RIG, styled.CANONICAL, styled.SOURCE)
ROOT = os.path.join(os.path.dirname(__file__), '..', '..', '..')


def run(*arguments, **options):
    """Runs python3 -m styled; returns (exit code, output, errors)."""
    done = subprocess.run([sys.executable, '-m', 'styled', *arguments], capture_output=True, text=True,
                          timeout=PATIENCE_S, **options)
    return done.returncode, done.stdout, done.stderr


class ClientTest(unittest.TestCase):
    def setUp(self):
        self.daemon = Daemon()
        self.addCleanup(self.daemon.close)

    def test_every_frame_comes_in_its_order_with_its_body_and_style(self):
        self.check_every_frame(bundled=False)

    def test_every_frame_comes_in_bundles_too(self):
        self.check_every_frame(bundled=True)

    def check_every_frame(self, bundled):
        with styled.Subscriber(self.daemon.publish, streams=STREAMS, statistics=True,
                               bundled=bundled) as subscriber, \
                styled.Control(self.daemon.control) as control:
            control.set('rig.sim', style='elderly', transition_ms=0)
            self.daemon.simulate()
            sequences = {stream: [] for stream in STREAMS}
            for update in subscriber.frames(timeout=PATIENCE_S):
                sequences[update.stream].append(update.frame.sequence)
                self.assertEqual(len(update.world()), len(update.body.names))
                if min(map(len, sequences.values())) > 120:
                    break
            for stream, seen in sequences.items():
                self.assertEqual(seen, list(range(seen[0], seen[0] + len(seen))), stream)
            self.assertEqual(update.frame.styles[0].style, 'elderly')
            self.assertEqual(subscriber.counters.missed, 0)
            self.assertEqual(subscriber.counters.malformed, 0)
            self.assertEqual(subscriber.performers(), ['rig.sim'])
            self.assertEqual(subscriber.connected(), 1)
            statistics = wait_for(lambda: (subscriber.receive(1) or update).statistics, 'statistics')
            self.assertTrue(any(c.value for c in statistics.counters))

    def test_a_slow_reader_gets_the_newest(self):
        with styled.Subscriber(self.daemon.publish, performer='rig.sim') as subscriber:
            self.daemon.simulate()
            last = next(subscriber.frames(timeout=PATIENCE_S)).frame.sequence
            for _ in range(3):
                time.sleep(0.3)
                updates = subscriber.receive_latest(PATIENCE_S)
                frame = next(u for u in updates if u.kind is styled.Kind.FRAME)
                self.assertEqual(sum(u.kind is styled.Kind.FRAME for u in updates), 1)
                self.assertGreater(frame.skipped, 5)
                self.assertEqual(frame.missed, 0)
                self.assertEqual(frame.frame.sequence, last + frame.skipped + 1)
                last = frame.frame.sequence
            self.assertEqual(subscriber.receive_latest(0), [])

    def test_goes_on_when_the_daemon_is_started_again(self):
        with styled.Subscriber(self.daemon.publish) as subscriber, \
                styled.Control(self.daemon.control) as control:
            simulator = self.daemon.simulate()
            next(subscriber.frames(timeout=PATIENCE_S))
            self.daemon.stop()
            wait_for(lambda: subscriber.receive(0.01) is None and subscriber.connected() == 0,
                     'the disconnection')
            self.daemon.start()
            simulator.kill()
            self.daemon.simulate()
            update = next(subscriber.frames(timeout=PATIENCE_S))
            self.assertTrue(update.new_epoch)
            self.assertEqual(subscriber.counters.epochs, 1)
            self.assertTrue(control.list().styles)

    def test_control_changes_and_asks(self):
        with styled.Control(self.daemon.control) as control:
            names = [style.name for style in control.list().styles]
            self.assertIn('elderly', names)
            self.daemon.simulate()
            wait_for(lambda: control.status().stats.performers, 'the performer')
            applied = control.set('rig.sim', mix={'elderly': 0.5, 'feminine': 0.25}, strength=0.8,
                                  parts=['left-arm'], transition_ms=0)
            self.assertEqual(list(applied), ['rig.sim'])
            performer = control.status().stats.performers[0]
            self.assertEqual([(s.style, round(s.weight, 3)) for s in performer.styles],
                             [('elderly', 0.5), ('feminine', 0.25)])
            self.assertEqual((round(performer.strength, 3), list(performer.only)), (0.8, [3]))
            self.assertEqual((round(performer.look.strength, 3), list(performer.look.parts)), (0.8, [3]))
            control.pin('rig.sim')
            self.assertTrue(control.status().stats.performers[0].pinned)
            with self.assertRaises(styled.Refused) as refused:
                control.set('rig.sim', style='old')
            self.assertEqual(refused.exception.code, 'PINNED')
            state = control.take_checkpoint('rig.sim')
            control.panic()
            self.assertFalse(control.status().stats.performers[0].styles)
            self.assertEqual(list(control.restore_checkpoint(state)), ['rig.sim'])
            with self.assertRaises(ValueError):
                control.restore_checkpoint(b'no checkpoint')
            control.pin('rig.sim', False)
            control.reset('rig.sim')

    def test_control_says_why_not(self):
        with styled.Control(self.daemon.control) as control:
            for call, code in ((lambda: control.set('*', style='olf'), 'UNKNOWN_STYLE'),
                               (lambda: control.set('*', strength=9), 'OUT_OF_RANGE'),
                               (lambda: control.preset('*', 'none'), 'UNKNOWN_PRESET'),
                               (lambda: control.cue('none'), 'UNKNOWN_CUE'),
                               (lambda: control.like('*', __file__, 'mine'), 'MALFORMED'),
                               (lambda: control.measure(__file__), 'MALFORMED'),
                               (lambda: control.learn('rig.anna', 2, 'mine'), 'UNKNOWN_PERFORMER'),
                               (lambda: control.measure_take('rig.anna', 2), 'UNKNOWN_PERFORMER'),
                               (lambda: control.export_style('mine'), 'UNKNOWN_STYLE'),
                               (lambda: control.import_style(__file__), 'MALFORMED'),
                               (lambda: control.rename_style('old', 'new'), 'MALFORMED'),
                               (lambda: control.remove_style('mine'), 'UNKNOWN_STYLE'),
                               (lambda: control.preview('mine'), 'UNKNOWN_STYLE'),
                               (lambda: control.take_checkpoint('rig.nobody'), 'UNKNOWN_PERFORMER'),
                               (lambda: control.restore_checkpoint(b'', 'rig.nobody'), 'MALFORMED'),
                               (lambda: control.reset('rig.nobody'), 'UNKNOWN_PERFORMER'),
                               (lambda: control.calibrate('rig.nobody'), 'UNKNOWN_PERFORMER')):
                with self.assertRaises(styled.Refused) as refused:
                    call()
                self.assertEqual(refused.exception.code, code)
                self.assertTrue(str(refused.exception))

    def test_what_nobody_will_see_is_told(self):
        with styled.Control(self.daemon.control) as control, warnings.catch_warnings(record=True) as told:
            warnings.simplefilter('always')
            self.assertEqual(control.set('rig.ann', style='old').absent, {'rig.ann'})
            self.assertIs(told.pop().category, styled.AbsentPerformer)
            self.daemon.simulate()
            wait_for(lambda: any(p.live for p in control.status().stats.performers), 'the performer')
            self.assertEqual(control.set('rig.sim', style='old', strength=0).no_strength, {'rig.sim'})
            self.assertEqual(told, [])
            control.set('rig.sim', style='elderly')
            self.assertIs(told.pop().category, styled.NoStrength)
            self.assertEqual(control.set('rig.sim', strength=1).no_strength, frozenset())
            control.set('*', style='old')
            self.assertEqual(told, [])

    def test_a_preview_is_a_moving_figure(self):
        with styled.Control(self.daemon.control) as control:
            preview = control.preview('old')
            self.assertEqual(preview.joints, 21)
            frames = len(preview.positions_mm) // (3 * preview.joints)
            self.assertAlmostEqual(frames / preview.rate_hz, 2.2, delta=0.3)

    def test_asyncio_has_the_same(self):
        async def go():
            async with styled.aio.Subscriber(self.daemon.publish) as subscriber, \
                    styled.aio.Control(self.daemon.control) as control:
                await asyncio.gather(control.set('*', style='old'), control.list())
                self.daemon.simulate()
                count = 0
                async for update in subscriber.frames(timeout=PATIENCE_S):
                    count += 1
                    if count == 200:
                        break
                self.assertEqual(subscriber.counters.missed, 0)
                await asyncio.sleep(0.3)
                latest = await subscriber.receive_latest(PATIENCE_S)
                self.assertGreater(latest[-1].skipped, 5)
                self.assertEqual(subscriber.connected(), 1)
                with self.assertRaises(styled.Refused):
                    await control.set('*', style='olf')
                self.daemon.stop()
                with self.assertRaises(styled.NoAnswer):
                    async with styled.aio.Control(self.daemon.control, timeout=0.2) as nobody:
                        await nobody.status()
        asyncio.run(go())

    def test_the_command_line(self):
        environment = dict(os.environ, STYLED_PUBLISHER=self.daemon.publish,
                           STYLED_CONTROL=self.daemon.control)
        self.assertIn('elderly', run('list', env=environment)[1])
        code, out, err = run('set', 'rig.sim', '--style', 'olf', env=environment)
        self.assertEqual(code, 1)
        self.assertIn("olf", err)
        self.assertEqual(run('clear', 'rig.sim', env=environment)[0], 0)
        code, out, err = run('set', 'rig.sim', '--vary', '100', env=environment)
        self.assertEqual(code, 1)
        self.assertIn('whole number from 0 to 99', err)
        for vary, shown in (('each', (0, True, 0.5, 5)), ('7', (7, False, 0.5, 5)), ('0', (0, False, 0.5, 5))):
            self.assertEqual(run('set', 'rig.sim', '--vary', vary, '--amount', '0.5', '--drift', '5s',
                                 env=environment)[0], 0)
            with styled.Control(self.daemon.control) as control:
                look = next(p.look for p in control.status().stats.performers if p.performer == 'rig.sim')
            self.assertEqual((look.vary, look.vary_each, look.vary_amount, look.drift_s), shown)
        self.assertEqual(run('set', 'rig.sim', '--drift', '0', env=environment)[0], 0)
        self.assertEqual(run('set', 'rig.sim', '--style', 'old', '--strength', '0.5', env=environment)[0], 0)
        self.daemon.simulate()
        code, out, err = run('tail', '--seconds', '3', env=environment)
        self.assertEqual((code, err), (0, ''))
        self.assertRegex(out, r'Hz rig\.sim rig \d+ elderly=0\.\d\d .* missed=0\n')
        code, out, err = run('tail', '--frames', '--stream', 'canonical', '--seconds', '1', env=environment)
        self.assertRegex(out, r'(?m)^rig\.sim canonical \d+ .* hips \S+ \S+ \S+ missed=0$')
        self.assertIn('rig.sim: live', run('status', env=environment)[1])
        self.assertEqual(run('panic', env=environment)[0], 0)

    def test_the_command_line_makes_styles(self):
        environment = dict(os.environ, STYLED_CONTROL=self.daemon.control)
        clip = os.path.join(ROOT, 'tests', 'parity', 'fixtures', 'synthetic.bvh')
        for arguments, code, text in (
                (('like', '*', '--clip', __file__, '--name', 'mine'), 1, 'expected HIERARCHY'),
                (('like', 'rig.anna', '--clip', clip, '--neutral', __file__), 1, 'expected HIERARCHY'),
                (('like', 'rig.anna', '--clip', clip, '--name', 'a b'), 1, 'a b'),
                (('learn', 'rig.anna', '--name', 'mine', '--seconds', '1', '--countdown', '0'), 1, 'rig.anna')):
            found, out, err = run(*arguments, env=environment)
            self.assertEqual((found, out), (code, ''), arguments)
            self.assertIn(text, err)
        code, out, err = run('like', '*', '--unworn', '--clip', clip, '--neutral', clip, env=environment)
        self.assertEqual((code, err), (0, ''))
        self.assertRegex(out, r'(?s)\Astyle synthetic, of \d+\.\d\d s: nearest to \S+, at \d+\.\d\d of the mean [^\n]*\n  found  walk: .*\n\Z')
        self.daemon.simulate()
        with styled.Control(self.daemon.control) as control:
            wait_for(lambda: control.status().stats.performers, 'the performer')
            code, out, err = run('like', 'rig.sim', '--clip', clip, '--name', 'mine', env=environment)
            self.assertEqual((code, err), (0, ''))
            self.assertRegex(out, r'(?s)\Astyle mine, .*\nrig\.sim: mine\n\Z')
            self.assertEqual(control.status().stats.performers[0].styles[0].style, 'mine')
            code, out, err = run('learn', 'rig.sim', '--name', 'shown', '--seconds', '1s', '--neutral', '1',
                                 '--countdown', '1', env=environment)
            self.assertEqual((code, err), (0, 'as usual: 1... now, for 1 s\nin the style: 1... now, for 1 s\n'))
            self.assertRegex(out, r'(?s)\Astyle shown, of 1\.\d\d s: .*\nrig\.sim: shown\n\Z')
            self.assertIn('shown', [style.name for style in control.list().styles])


class AvatarTest(unittest.TestCase):
    def test_an_avatar_is_a_stream_like_the_others(self):
        clip = os.path.abspath(os.path.join(ROOT, 'tests', 'parity', 'fixtures', 'synthetic.bvh'))
        daemon = Daemon(extra=f'[[output]]\nname = "hero"\navatar = "{clip}"\n')
        self.addCleanup(daemon.close)
        daemon.simulate()
        with styled.Subscriber(daemon.publish, streams=['hero', styled.RIG]) as subscriber:
            seen = {}
            for update in subscriber.frames(timeout=PATIENCE_S):
                seen[update.stream] = update
                if len(seen) == 2:
                    break
        hero = seen[styled.Stream.AVATAR]
        self.assertEqual((hero.output_name, hero.body.output_name), ('hero', 'hero'))
        self.assertEqual(len(hero.world()), len(hero.body.names))
        self.assertEqual(seen[styled.RIG].output_name, '')


class WithoutADaemonTest(unittest.TestCase):
    def test_nobody_answers(self):
        with styled.Control('ipc:///tmp/styled-nobody', timeout=0.1) as control:
            with self.assertRaisesRegex(styled.NoAnswer, 'no daemon answers at ipc:///tmp/styled-nobody'):
                control.status()
        with styled.Subscriber('ipc:///tmp/styled-nobody') as subscriber:
            self.assertIsNone(subscriber.receive(0.05))
            self.assertEqual(subscriber.connected(), 0)

    def test_a_client_that_is_dropped_unclosed_ends(self):
        nobody = "'ipc:///tmp/styled-nobody'"
        for made in (f'styled.Subscriber({nobody})', f'styled.Control({nobody}, timeout=0.1)',
                     f'styled.aio.Subscriber({nobody})', f'styled.aio.Control({nobody})'):
            for dropped in ('def use():\n    client = {0}\nuse()', '[{0} for _ in range(3)]',
                            'client = {0}\nclient = {0}', 'cycle = [{0}]\ncycle.append(cycle)\ndel cycle',
                            'client = {0}\nclient.close()\nclient.close()\ndel client',
                            'import threading\nthreading.Thread(target=lambda: {0}).start()'):
                program = ('import gc, styled, styled.aio\n' + dropped.format(made) +
                           '\ngc.collect()\nprint("ended")')
                done = subprocess.run([sys.executable, '-c', program], capture_output=True, text=True,
                                      timeout=PATIENCE_S)
                self.assertEqual((done.stdout, done.stderr), ('ended\n', ''), program)

    def test_a_client_that_is_dropped_is_no_longer_connected(self):
        with zmq.Context() as context, context.socket(zmq.XPUB) as publisher:
            publisher.linger = 0
            publisher.rcvtimeo = 1000 * PATIENCE_S
            port = publisher.bind_to_random_port('tcp://127.0.0.1')
            subscriber = styled.Subscriber(f'tcp://127.0.0.1:{port}')
            wait_for(lambda: subscriber.connected() == 1, 'the handshake')
            self.assertEqual(publisher.recv(), b'\1body/')
            del subscriber
            self.assertEqual(publisher.recv(), b'\0body/')

    def test_something_else_answers(self):
        with zmq.Context() as context, context.socket(zmq.ROUTER) as router:
            router.linger = 0
            port = router.bind_to_random_port('tcp://127.0.0.1')
            with styled.Control(f'tcp://127.0.0.1:{port}', timeout=PATIENCE_S) as control:
                # The reply is queued before the client waits for it.
                control._socket.send(b'hello')
                router.send_multipart([router.recv_multipart()[0], b'\xff\xff\xff'])
                with self.assertRaisesRegex(styled.Garbled, 'not a styled daemon'):
                    control.status()

    def test_a_style_by_hand(self):
        found = control_pb2.LikeReply(name='by-hand-rig-a', nearest='old', distance=2, found=['walk: 7 strides'],
                                      weak=['walk: only 2 s'])
        lists = control_pb2.ListReply(
            sliders=[dict(name='stoop', unit='degrees', least=-30, most=60, what='Rounds the back.')],
            designs=[dict(name='sneaky', sliders={'stoop': 28, 'energy': 0.5})])

        def answer(request):
            fields = {'like': found, 'list': lists}
            command = request.WhichOneof('command')
            return control_pb2.Reply(**{command: fields[command]} if command in fields else {})

        with FakeDaemon(answer) as daemon:
            with styled.Control(daemon.endpoint, timeout=PATIENCE_S) as control:
                self.assertEqual(control.list().designs[0].sliders['stoop'], 28)
                reply = control.design('rig.a', {'stoop': 28, 'energy': 0.5})
                self.assertEqual((list(reply.found), list(reply.weak)), (['walk: 7 strides'], ['walk: only 2 s']))
                control.design(None, name='mine', from_='pirate', preset='sneaky', transition_ms=500)
                clip = os.path.join(ROOT, 'tests', 'parity', 'fixtures', 'synthetic.bvh')
                control.like('rig.a', clip, 'mine', network='phase', add=True)
                control.learn('rig.a', 1, 'mine', network='phase', add=True)
                for bad, text in (((3,), 'sliders is 3, expected numbers by slider'),
                                  (({'stoop': 'x'},), "'stoop': 'x', expected the name of a slider and a number")):
                    with self.assertRaisesRegex(TypeError, text):
                        control.design('rig.a', *bad)
                for name in ('name', 'from_', 'preset'):
                    with self.assertRaisesRegex(TypeError, f'design: {name} is 3, expected'):
                        control.design('rig.a', **{name: 3})
                with self.assertRaisesRegex(ValueError, 'SOURCE.NAME'):
                    control.design('anna')

            async def go():
                async with styled.aio.Control(daemon.endpoint, timeout=PATIENCE_S) as control:
                    return (await control.design('rig.a', {'stoop': 3})).name
            self.assertEqual(asyncio.run(go()), 'by-hand-rig-a')
            environment = dict(os.environ, STYLED_CONTROL=daemon.endpoint)
            code, out, err = run('design', 'rig.a', 'stoop=28', '--name', 'mine', '--from', 'pirate',
                                 'energy=.5', '--preset', 'sneaky', env=environment)
            self.assertEqual((code, out, err), (0, 'style by-hand-rig-a, by hand\nrig.a: by-hand-rig-a\n', ''))
            self.assertEqual(run('list', env=environment)[1],
                             'slider stoop: -30 to 60 degrees, usually 0. Rounds the back.\n'
                             'design sneaky: energy=0.5 stoop=28\n')
            code, out, err = run('like', 'rig.a', '--clip', clip, '--add', '--network', 'phase', env=environment)
            self.assertEqual((code, out.splitlines()), (0, [
                'style by-hand-rig-a: nearest to old, at 2.00 of the mean distance between styles',
                '  found  walk: 7 strides', '  weak   walk: only 2 s', 'rig.a: by-hand-rig-a']))
        likes = [(r.performer, r.like) for r in daemon.requests if r.WhichOneof('command') == 'like']
        self.assertEqual([(performer, like.name, dict(like.design.sliders)) for performer, like in likes[::4]],
                         [('rig.a', '', {'stoop': 28, 'energy': 0.5}), ('rig.a', '', {'stoop': 3})])
        self.assertEqual([like.HasField('design') for _, like in likes], [True, True, False, False, True, True, False])
        performer, kept = likes[1]
        self.assertEqual((performer, kept.name, getattr(kept.design, 'from'), kept.design.preset, kept.transition_ms),
                         ('', 'mine', 'pirate', 'sneaky', 500))
        for _, like in likes[2:4] + likes[6:]:
            self.assertEqual((like.network, like.add), ('phase', True))
        shell = likes[5][1]
        self.assertEqual((shell.name, getattr(shell.design, 'from'), shell.design.preset, dict(shell.design.sliders)),
                         ('mine', 'pirate', 'sneaky', {'stoop': 28, 'energy': 0.5}))

    def test_wrong_arguments(self):
        for make in (lambda: styled.Subscriber('nonsense'), lambda: styled.Subscriber([]),
                     lambda: styled.Subscriber(queue_messages=0), lambda: styled.Control('nonsense'),
                     lambda: styled.Control(timeout=0), lambda: styled.Subscriber(performer='anna')):
            with self.assertRaises(ValueError):
                make()

    def test_the_command_line_says_what_was_expected(self):
        for arguments, code, text in (
                (['set', 'rig.a'], 2, 'nothing to change'),
                (['set', 'anna', '--style', 'old'], 2, 'SOURCE.NAME'),
                (['set', 'rig.a', '--vary', 'all'], 2, "invalid variation value: 'all'"),
                (['set', 'rig.a', '--drift', '5m'], 2, "invalid number value: '5m'"),
                (['set', 'rig.a', '--mix', 'old'], 2, 'STYLE=WEIGHT'),
                (['like', 'rig.a', '--clip', '/nonexistent.bvh'], 2, '/nonexistent.bvh: No such file'),
                (['like', 'rig.a', '--clip', '/'], 2, '/: Is a directory'),
                (['like', 'rig.a'], 2, '--clip'),
                (['design', 'rig.a', 'stoop'], 2, "'stoop', expected SLIDER=NUMBER"),
                (['design', 'rig.a', 'stoop=x'], 2, "'stoop=x', expected SLIDER=NUMBER"),
                (['design', 'rig.a', '--name', 'x', 'stoop'], 2, "'stoop', expected SLIDER=NUMBER"),
                (['design', 'rig.a', '--nam', 'x', '--from', 'y', '--stoop=3'], 2, 'unrecognized arguments: --stoop=3'),
                (['clear', 'rig.a', 'stoop=3'], 2, 'unrecognized arguments: stoop=3'),
                (['design', 'rig.a', '=1'], 2, "'=1', expected SLIDER=NUMBER"),
                (['learn', 'rig.a'], 2, '--name'),
                (['learn', 'rig.a', '--name', 'x', '--seconds', '61'], 2, '61, expected 1 to 60 s'),
                (['learn', 'rig.a', '--name', 'x', '--seconds', 'nan'], 2, 'nan, expected 1 to 60 s'),
                (['tail', '--publisher', 'nonsense'], 2, 'expected e.g. tcp://'),
                (['list', '--control', 'ipc:///tmp/styled-nobody', '--timeout', '0.1'], 3, 'no daemon answers'),
                (['tail', '--publisher', 'ipc:///tmp/styled-nobody', '--seconds', '0.2'], 3, '')):
            found, _, err = run(*arguments)
            self.assertEqual(found, code, arguments)
            self.assertIn(text, err)

    def test_with_keys_a_daemon_is_heard_and_without_them_it_is_not(self):
        public, secret = zmq.curve_keypair()
        own_public, own_secret = zmq.curve_keypair()
        with zmq.Context() as context, context.socket(zmq.XPUB) as publisher:
            publisher.linger = 0
            publisher.curve_server = True
            publisher.curve_secretkey = secret
            port = publisher.bind_to_random_port('tcp://127.0.0.1')
            endpoint = f'tcp://127.0.0.1:{port}'
            for curve in (styled.Curve(public), styled.Curve(public.decode(), own_public, own_secret)):
                with styled.Subscriber(endpoint, curve=curve) as subscriber:
                    wait_for(lambda: subscriber.connected() == 1, 'the handshake')
            with styled.Subscriber(endpoint) as subscriber:
                end = time.monotonic() + 0.5
                while time.monotonic() < end:
                    subscriber.receive(0.05)
                    self.assertEqual(subscriber.connected(), 0)


if __name__ == '__main__':
    unittest.main()
