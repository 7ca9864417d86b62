"""Errors in the add-on for Blender: each is reported in a line, and nothing is left half
done. Blender is a stand-in here, as bare as that allows; tests/e2e/blender has the real one."""
import contextlib
import io
import os
import subprocess
import sys
import tempfile
import types
import unittest
import unittest.mock

from styled.v1 import body_pb2, control_pb2, frame_pb2
from fake_daemon import FakeDaemon

ADDON = os.path.join(os.path.dirname(os.path.abspath(__file__)), '../../../clients/blender')
NOBODY = 'ipc:///tmp/styled-nobody'

bpy = unittest.mock.MagicMock()
bpy.types = types.SimpleNamespace(Operator=object, PropertyGroup=object, Panel=object,
                                  Object=type('Object', (), {}), Scene=type('Scene', (), {}))
bpy.app.handlers.persistent = lambda function: function
bpy.path.abspath = lambda path: path
for name, module in (('bpy', bpy), ('bpy.props', bpy.props), ('mathutils', unittest.mock.MagicMock())):
    sys.modules[name] = module
sys.path.insert(0, ADDON)
from styled_live import bake, drive, live, operators, restyle  # noqa: E402


class Named(dict):
    """A collection of Blender's: iterates over its things, finds them by name."""

    def __iter__(self):
        return iter(self.values())


class Actions(list):
    def new(self, name):
        self.append(Action(name))
        return self[-1]


class Action:
    def __init__(self, name, keys=0, frame_range=(1.0, 3.0)):
        self.name, self.frame_range, self.use_fake_user = name, frame_range, False
        self.fcurves = [types.SimpleNamespace(data_path='x', keyframe_points=[0] * keys)]

    def copy(self):
        return bpy.data.actions.new(self.name)


class Bone:
    """Fails at its key number `fails_at`."""
    rotation_mode = 'XYZ'

    def __init__(self, name, fails_at=None):
        self.name, self.keys, self.fails_at = name, 0, fails_at
        self.rotation_quaternion = unittest.mock.MagicMock()

    def keyframe_insert(self, *_, **__):
        self.keys += 1
        if self.keys == self.fails_at:
            raise RuntimeError('the action is locked')


class Armature:
    """An object with two bones."""
    type, mode, name, data = 'ARMATURE', 'OBJECT', 'other', None

    def __init__(self, action=None, fails_at=None):
        self.pose = types.SimpleNamespace(
            bones=Named(hips=Bone('hips'), head=Bone('head', fails_at)))
        self.animation_data = None
        self.styled_live = types.SimpleNamespace(driven=True, performer='rig.a', stream='rig')
        if action is not None:
            self.animation_data_create().action = action

    def animation_data_create(self):
        self.animation_data = self.animation_data or types.SimpleNamespace(action=None)
        return self.animation_data

    def animation_data_clear(self):
        self.animation_data = None


class Plan:
    body = body_pb2.Body(hash=7)
    joints = {'hips': 0, 'head': 1}

    def bones(self, thing):
        return list(thing.pose.bones)

    def moving(self):
        return {'hips'}

    def apply(self, _frame, _thing):
        pass


class Scene:
    def __init__(self):
        self.render = types.SimpleNamespace(fps=24, fps_base=1.0)
        self.frame_current, self.frame_end = 5, 10
        self.styled_live = types.SimpleNamespace(
            publisher=NOBODY, control=NOBODY, performer='rig.a', stream='rig', strength=1.0,
            action_style='old', action_strength=1.0, stylize='stylize')

    def frame_set(self, frame):
        self.frame_current = frame


class ErrorsTest(unittest.TestCase):
    def setUp(self):
        bpy.data.actions = Actions()
        bpy.data.objects = []
        self.addCleanup(live.live.disconnect)
        self.scene = Scene()
        self.chosen = self.scene.styled_live

    def execute(self, kind, thing=None, **fields):
        """Returns what the operator gave, and what it reported."""
        operator, said = kind(), []
        operator.report = lambda levels, text: said.append((*levels, text))
        for name, value in fields.items():
            setattr(operator, name, value)
        context = types.SimpleNamespace(scene=self.scene, object=thing, mode='OBJECT')
        with contextlib.redirect_stderr(io.StringIO()):
            result = operator.execute(context)
        return result, said

    def test_a_wrong_address_is_said_and_leaves_nothing_open(self):
        for field in ('publisher', 'control'):
            for wrong in ('nonsense', '', 'http://a:1', 'tcp://a'):
                self.chosen.publisher = self.chosen.control = NOBODY
                setattr(self.chosen, field, wrong)
                result, ((level, text),) = self.execute(operators.STYLED_OT_connect)
                self.assertEqual((result, level, live.live.active), ({'CANCELLED'}, 'ERROR', False))
                self.assertIn(f"'{wrong}', expected e.g. tcp://", text)

    def test_a_daemon_that_does_not_answer_is_a_warning_and_does_not_block_every_tick(self):
        result, ((level, text),) = self.execute(operators.STYLED_OT_connect)
        self.assertEqual((result, level), ({'FINISHED'}, 'WARNING'))
        self.assertIn('no daemon answers', text)
        asked = []
        live.live.ask_for_styles, ask = lambda: (asked.append(1), ask()), live.live.ask_for_styles
        self.addCleanup(lambda: live.live.__dict__.pop('ask_for_styles', None))
        with unittest.mock.patch.object(live.Live, 'reached', True):
            live.live._retry_at_s = 0
            for _ in range(5):
                live.tick()
        self.assertEqual(len(asked), 1)

    def test_a_mistyped_performer_is_said(self):
        def answer(request):
            reply = control_pb2.Reply(list={})
            reply.applied.add(performer=request.performer, absent=request.performer == 'stage.ann')
            return reply
        with FakeDaemon(answer) as daemon:
            self.chosen.control, self.chosen.performer = daemon.endpoint, 'stage.ann'
            self.execute(operators.STYLED_OT_connect)
            for kind in (operators.STYLED_OT_style, operators.STYLED_OT_clear):
                result, said = self.execute(kind, style='old')
                self.assertEqual((result, said), ({'FINISHED'}, [
                    ('WARNING', "no performer of the name 'stage.ann' is present: the change waits for it")]))
            self.chosen.performer = 'stage.anna'
            self.assertEqual(self.execute(operators.STYLED_OT_style, style='old'), ({'FINISHED'}, []))

    def test_an_output_that_is_none_is_said_before_anything_is_driven(self):
        thing = Armature()
        thing.styled_live.driven = False
        self.execute(operators.STYLED_OT_connect)
        for performer, stream, text in (('anna', 'rig', 'expected SOURCE.NAME'), ('rig.b', '', "''"),
                                        ('rig.b', 'Rig', "'Rig', expected 'rig'"),
                                        ('rig.a', 'heor', "no output 'heor' of rig.a; there are rig, .*, hero")):
            live.live.bodies = {('rig.a', 'rig'): Plan.body, ('rig.a', 'hero'): Plan.body}
            self.chosen.performer, self.chosen.stream = performer, stream
            result, ((level, said),) = self.execute(operators.STYLED_OT_drive, thing)
            self.assertEqual((result, level, thing.styled_live.driven), ({'CANCELLED'}, 'ERROR', False))
            self.assertRegex(said, text)
        self.chosen.performer, self.chosen.stream = 'rig.b', 'rig'
        result, ((level, said),) = self.execute(operators.STYLED_OT_drive, thing)
        self.assertEqual((level, thing.styled_live.driven), ('WARNING', True))
        self.assertIn('no performer of the name rig.b is present yet', said)

    def test_an_armature_that_fails_does_not_end_the_others(self):
        self.execute(operators.STYLED_OT_connect)
        good, bad = Armature(), Armature()
        good.name, bad.name = 'good', 'bad'
        bpy.data.objects = [bad, good]
        stepped = []

        def step(_link, thing):
            stepped.append(thing.name)
            if thing is bad:
                raise ZeroDivisionError('of the pose')
        with unittest.mock.patch.object(live._Link, 'step', step), \
                contextlib.redirect_stderr(io.StringIO()):
            self.assertIsNotNone(live.tick())
        self.assertEqual(stepped, ['bad', 'good'])
        self.assertEqual(live.live.link(bad).unfit, 'ZeroDivisionError: of the pose')

    def bake(self, thing):
        frames = [frame_pb2.Frame(performer='rig.a', body_hash=7, source_time_ns=n * 10**8) for n in range(5)]
        link = types.SimpleNamespace(take=frames, plan=Plan(), unfit='')
        with unittest.mock.patch.dict(live.live._links, {thing.name: link}):
            return self.execute(operators.STYLED_OT_bake, thing)

    def test_a_bake_that_fails_in_the_middle_leaves_all_as_it_was(self):
        mine = bpy.data.actions.new('mine')
        for action in (None, mine):
            thing = Armature(action, fails_at=3)
            self.assertEqual(self.bake(thing), ({'CANCELLED'}, [('ERROR', 'RuntimeError: the action is locked')]))
            self.assertIs(thing.animation_data and thing.animation_data.action, action)
            self.assertEqual([bone.rotation_mode for bone in thing.pose.bones], ['XYZ', 'XYZ'])
            self.assertEqual((bpy.data.actions, self.scene.frame_end), ([mine], 10))
            self.assertTrue(thing.styled_live.driven)
        result, _ = self.bake(Armature(mine))  # a negative control
        self.assertEqual((result, len(bpy.data.actions)), ({'FINISHED'}, 2))

    def restyle(self, thing, program='stylize'):
        self.chosen.stylize = program
        clip = types.SimpleNamespace(positions=[0] * 3)
        with unittest.mock.patch.multiple(
                restyle, _Humanoid=unittest.mock.MagicMock(), Plan=lambda *_: Plan(), _forget=lambda *_: None,
                _messages=lambda *_: (Plan.body, [frame_pb2.Frame(source_time_ns=n * 10**8) for n in range(5)])):
            restyle._Humanoid.return_value.pose.return_value = 0, []
            written = unittest.mock.patch.object(restyle.bvh, 'write', lambda *_: None)
            read = unittest.mock.patch.object(restyle.bvh, 'read', lambda _: clip)
            stylized = unittest.mock.patch.object(restyle, '_stylize', lambda *_: None)
            with contextlib.ExitStack() as stack:
                for patch in (written, *((read, stylized) if program == 'stylize' else ())):
                    stack.enter_context(patch)
                return self.execute(operators.STYLED_OT_restyle, thing)

    @unittest.mock.patch.dict(os.environ, STYLED_LIBRARY='/nonexistent')
    @unittest.mock.patch('shutil.which', lambda _: None)
    def test_an_action_that_cannot_be_restyled_is_said(self):
        with tempfile.TemporaryDirectory() as folder:
            for action, program, text in (
                    (Action('empty'), 'stylize', 'other: the action empty has no keyframes'),
                    (Action('long', 2, (0.0, 1e6)), 'stylize', 'has 1000001 frames, expected at most 100000'),
                    (Action('mine', 2), '/nonexistent', "cannot run '/nonexistent'"),
                    (Action('mine', 2), '', 'found no libstyled'), (Action('mine', 2), folder, 'cannot run'),
                    (Action('mine', 2), '/bin/true', "'/bin/true' has written no clip; is it stylize?"),
                    (Action('mine', 2), '/bin/false', '/bin/false failed')):
                thing = Armature(action)
                result, ((level, said),) = self.restyle(thing, program)
                self.assertEqual((result, level), ({'CANCELLED'}, 'ERROR'))
                self.assertIn(text, said)
                self.assertEqual((thing.animation_data.action, action.use_fake_user, bpy.data.actions,
                                  self.scene.frame_current), (action, False, [], 5))

    def test_a_rig_of_unknown_bones_is_said(self):
        thing = Armature(Action('mine', 2))
        with unittest.mock.patch.object(restyle, '_Humanoid', side_effect=drive.Unfit('not a humanoid: hips')):
            result, said = self.execute(operators.STYLED_OT_restyle, thing)
        self.assertEqual((result, said), ({'CANCELLED'}, [('ERROR', 'other: not a humanoid: hips')]))

    def test_a_restyle_that_fails_in_the_middle_leaves_all_as_it_was(self):
        action = Action('mine', 2)
        thing = Armature(action, fails_at=3)
        self.assertEqual(self.restyle(thing), ({'CANCELLED'}, [('ERROR', 'RuntimeError: the action is locked')]))
        self.assertEqual((thing.animation_data.action, action.use_fake_user, bpy.data.actions,
                          self.scene.frame_current), (action, False, [], 5))
        self.assertEqual([bone.rotation_mode for bone in thing.pose.bones], ['XYZ', 'XYZ'])
        thing = Armature(action)  # a negative control
        self.assertEqual(self.restyle(thing), ({'FINISHED'}, []))
        self.assertEqual((thing.animation_data.action.name, action.use_fake_user), ('mine old', True))


class NothingInstalledTest(unittest.TestCase):
    def test_what_blenders_python_lacks_is_said(self):
        """Without pyzmq, and without protobuf: both are for the same pip."""
        for lacking in ('zmq', 'google'):
            program = (f'import sys; from unittest.mock import MagicMock\n'
                       f'sys.modules["bpy"] = sys.modules["bpy.props"] = sys.modules["mathutils"] = MagicMock()\n'
                       f'sys.modules["{lacking}"] = None\n'
                       f'sys.path.insert(0, {ADDON!r})\n'
                       'try:\n    import styled_live\nexcept ImportError as error:\n    print(error)\n')
            done = subprocess.run([sys.executable, '-c', program], capture_output=True, text=True, timeout=60)
            self.assertIn(f'"{sys.executable}" -m pip install pyzmq protobuf', done.stdout, done.stderr)


if __name__ == '__main__':
    unittest.main()
