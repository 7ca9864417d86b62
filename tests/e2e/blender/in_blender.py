"""Runs inside Blender, without a window. The add-on is installed from its zip as a user would do it, and
its armatures are compared with the Python client's own forward kinematics of the same frames. Blender
runs no timers without a window, so the tests call the timer's function themselves."""
import math
import os
import subprocess
import sys
import time
import unittest
import unittest.mock

import bpy
from mathutils import Euler, Matrix, Vector

HERE = os.path.dirname(os.path.abspath(__file__))
sys.path.insert(0, os.path.join(HERE, '..', 'python'))
from daemon import BIN, PATIENCE_S, Daemon, wait_for  # noqa: E402

bpy.ops.preferences.addon_install(filepath=os.environ['STYLED_ADDON'])
bpy.ops.preferences.addon_enable(module='styled_live')
import styled  # noqa: E402  (the add-on's own, from the zip)
import styled_live  # noqa: E402
from styled_live import humanoid  # noqa: E402
from styled_live.live import live, tick  # noqa: E402

TOLERANCE_M = 0.001
DANCE = 'walk:2,wave-left:1,run:3'
LIMBS = [(side + start, side + end) for side in ('left', 'right')
         for start, end in (('UpperArm', 'LowerArm'), ('LowerArm', 'Hand'), ('UpperLeg', 'LowerLeg'),
                            ('LowerLeg', 'Foot'))]
MIXAMO = {'hips': 'Hips', 'spine': 'Spine', 'chest': 'Spine1', 'neck': 'Neck', 'head': 'Head',
          'Shoulder': 'Shoulder', 'UpperArm': 'Arm', 'LowerArm': 'ForeArm', 'Hand': 'Hand',
          'UpperLeg': 'UpLeg', 'LowerLeg': 'Leg', 'Foot': 'Foot', 'Toes': 'ToeBase'}


def in_blender(position):
    """From the canonical humanoid's axes (+Y up, +Z forward) to Blender's (+Z up, -Y forward)."""
    x, y, z = position
    return Vector((x, -z, y))


def mixamo(name):
    for side in ('left', 'right'):
        if name.startswith(side):
            return 'mixamorig:' + side.capitalize() + MIXAMO[name[len(side):]]
    return 'mixamorig:' + MIXAMO[name]


class AddonTest(unittest.TestCase):
    def setUp(self):
        bpy.ops.wm.read_factory_settings(use_empty=True)
        bpy.ops.preferences.addon_enable(module='styled_live')
        self.addCleanup(live.disconnect)
        self.chosen = bpy.context.scene.styled_live
        self.use(Daemon())

    def use(self, daemon):
        self.daemon = daemon
        self.addCleanup(daemon.close)
        self.chosen.publisher, self.chosen.control = self.daemon.publish, self.daemon.control
        self.chosen.performer, self.chosen.stream = 'rig.sim', 'canonical'

    def connect(self, *options, **motion):
        self.assertEqual(bpy.ops.styled.connect(), {'FINISHED'})
        self.daemon.simulate(*options, **motion)
        self.tick_until(lambda: live.body('rig.sim', self.chosen.stream), 'the body')

    def tick_until(self, condition, what):
        def met():
            self.assertIsNotNone(tick())
            return condition()
        return wait_for(met, what)

    def listen(self, stream='canonical'):
        """The test's own subscriber, which receives every frame."""
        subscriber = styled.Subscriber(self.daemon.publish, performer='rig.sim', streams=[stream])
        self.addCleanup(subscriber.close)
        next(subscriber.frames(timeout=PATIENCE_S))
        return subscriber

    def shown(self, thing):
        link = live.link(thing)
        return link.latest.sequence if link is not None and link.latest is not None else -1

    def show_another(self, thing, subscriber, at_least=8):
        """Ticks until the armature shows another frame; returns it from the test's own subscriber."""
        before = self.shown(thing)
        self.tick_until(lambda: self.shown(thing) > before + at_least, 'another frame')
        shown = self.shown(thing)
        bpy.context.view_layer.update()
        return next(u for u in subscriber.frames(timeout=PATIENCE_S) if u.frame.sequence == shown)

    def compare(self, thing, subscriber, place=in_blender, bone_of=lambda joint: joint, poses=12,
                hand='leftHand'):
        """After each of `poses` ticks, every joint's bone starts at the client's joint position."""
        worst_m, travelled_m, last = 0.0, 0.0, None
        for _ in range(poses):
            update = self.show_another(thing, subscriber)
            for name, joint in zip(update.body.names, update.world()):
                bone = bone_of(name)
                if bone is None:
                    continue
                head = thing.matrix_world @ thing.pose.bones[bone].head
                worst_m = max(worst_m, (head - place(joint.position)).length)
                if name == hand:
                    travelled_m += (head - last).length if last is not None else 0.0
                    last = head
        print(f'{thing.name}: {worst_m * 1000:.4f} mm at worst, the hand went {travelled_m:.2f} m')
        self.assertLess(worst_m, TOLERANCE_M)
        self.assertGreater(travelled_m, 0.1, 'the performer stood still: nothing was tested')

    def make_humanoid(self, name=mixamo, roll=None, lowered_deg=0.0, turn=Matrix.Identity(3), scale=1.0):
        """An armature with the canonical humanoid's proportions, not made by the add-on: with other
        names and rolls, lowered arms, other axes or another size."""
        body = live.body('rig.sim', 'canonical')
        names, places, lowered = list(body.names), {}, {}
        armature = bpy.data.armatures.new('other')
        thing = bpy.data.objects.new('other', armature)
        bpy.context.collection.objects.link(thing)
        bpy.context.view_layer.objects.active = thing
        bpy.ops.object.mode_set(mode='EDIT')
        for joint, joint_name in enumerate(names):
            parent = names[body.parents[joint]] if joint else None
            down = lowered.get(parent, Matrix.Identity(3))
            step = down @ in_blender(body.offsets[3 * joint:3 * joint + 3])
            places[joint_name] = step + places.get(parent, Vector())
            if joint_name.endswith('UpperArm'):
                sign = 1 if joint_name.startswith('left') else -1
                down = Matrix.Rotation(math.radians(sign * lowered_deg), 3, 'Y')
            lowered[joint_name] = down
            bone = armature.edit_bones.new(name(joint_name))
            bone.head = turn @ places[joint_name] * scale
            bone.tail = bone.head + turn @ Vector((0.02, 0.03, 0.07)) * scale
            if roll is not None:
                bone.roll = roll(joint)
            if parent is not None:
                bone.parent = armature.edit_bones[name(parent)]
        bpy.ops.object.mode_set(mode='OBJECT')
        return thing

    def drive(self, thing):
        bpy.context.view_layer.objects.active = thing
        self.assertEqual(bpy.ops.styled.drive(), {'FINISHED'})

    def test_an_armature_of_the_body_moves_as_the_client_says(self):
        self.connect(script=DANCE)
        self.assertEqual(bpy.ops.styled.make_armature(), {'FINISHED'})
        thing = bpy.context.object
        self.assertEqual([b.name for b in thing.data.bones], list(live.body('rig.sim', 'canonical').names))
        self.assertTrue(bpy.app.timers.is_registered(tick))
        self.compare(thing, self.listen())

    def test_so_does_one_of_the_rigs_own_skeleton_styled_and_as_captured(self):
        self.connect()
        for stream in ('rig', 'source'):
            self.chosen.stream = stream
            self.assertEqual(bpy.ops.styled.make_armature(), {'FINISHED'})
            self.compare(bpy.context.object, self.listen(stream), poses=6)
        self.assertEqual(len(bpy.data.objects), 2)

    def test_bones_with_other_names_and_rolls_do(self):
        self.connect(script=DANCE)
        thing = self.make_humanoid(roll=lambda joint: 0.7 * joint)
        self.drive(thing)
        self.compare(thing, self.listen(), bone_of=mixamo)

    def test_so_does_an_a_pose(self):
        self.connect()
        thing = self.make_humanoid(lowered_deg=45, roll=lambda joint: -0.4 * joint)
        low, high = (thing.data.bones[mixamo(name)].head_local.z for name in ('leftHand', 'leftUpperArm'))
        self.assertLess(low, high - 0.3)
        self.drive(thing)
        self.compare(thing, self.listen(), bone_of=mixamo)

    def test_so_does_one_in_centimetres_with_y_up_that_stands_elsewhere(self):
        self.connect()
        turn = Matrix(((1, 0, 0), (0, 0, 1), (0, -1, 0)))  # as FBX and glTF have it
        thing = self.make_humanoid(turn=turn, scale=100, roll=lambda joint: joint)
        stands = Matrix.LocRotScale(Vector((3, -2, 1)), Euler((0, 0, 0.5)), Vector((1, 1, 1)))
        thing.matrix_world = stands @ turn.transposed().to_4x4() @ Matrix.Scale(0.01, 4)
        self.drive(thing)
        self.compare(thing, self.listen(), place=lambda p: stands @ in_blender(p), bone_of=mixamo)

    def test_a_rig_with_z_up_makes_an_armature_and_drives_one_of_other_size(self):
        self.use(Daemon(source='mvn'))
        self.chosen.stream = 'rig'
        self.connect('--as', 'mvn', script=DANCE)
        self.assertEqual(bpy.ops.styled.make_armature(), {'FINISHED'})
        mine = self.listen('rig')
        # MVN has +X ahead, +Y left, +Z up.
        self.compare(bpy.context.object, mine, place=lambda p: Vector((p[1], -p[0], p[2])), poses=6,
                     hand='LeftHand')
        canonical = styled.Subscriber(self.daemon.publish, performer='rig.sim', streams=['canonical'])
        with canonical:
            self.tick_until(lambda: live.body('rig.sim', 'canonical'), 'the canonical body')
        thing = self.make_humanoid(scale=1.5, lowered_deg=30, roll=lambda joint: 0.3 * joint)
        self.drive(thing)
        worst_deg = 0.0
        for _ in range(6):
            update = self.show_another(thing, mine)
            names = humanoid.map_names(list(update.body.names))
            at = dict(zip(update.body.names, update.world()))
            for start, end in LIMBS:
                rig = [Vector(at[names[joint]].position) for joint in (start, end)]
                bones = [thing.pose.bones[mixamo(joint)].head for joint in (start, end)]
                expected, found = rig[1] - rig[0], bones[1] - bones[0]
                expected = Vector((expected.y, -expected.x, expected.z))
                worst_deg = max(worst_deg, math.degrees(expected.angle(found)))
            hips = thing.pose.bones[mixamo('hips')].head
            self.assertAlmostEqual(hips.z, 1.5 * at['Pelvis'].position[2], delta=0.05)
        print(f'limbs: {worst_deg:.4f} degrees at worst')
        self.assertLess(worst_deg, 0.1)

    def test_a_rig_of_unknown_unit_is_as_tall_as_a_human(self):
        self.chosen.stream = 'rig'
        clip = os.path.join(self.daemon.folder, 'walk.bvh')
        subprocess.run([os.path.join(BIN, 'stylesim'), '--write', clip, '--seconds', '6', '--script',
                        'walk:6'], check=True, stdout=subprocess.DEVNULL)
        self.connect('--bvh', clip, '--loop', script='')
        body = live.body('rig.sim', 'rig')
        self.assertEqual(body.metres_per_unit, 0)
        self.assertGreater(body.offsets[1], 80)  # centimetres
        self.assertEqual(bpy.ops.styled.make_armature(), {'FINISHED'})
        bones = bpy.context.object.data.bones
        hips_m, toes_m = bones['hips'].head_local.z, bones['leftToes'].head_local.z
        self.assertAlmostEqual(hips_m - toes_m, 0.96, delta=0.01)
        unit_m = (hips_m - toes_m) / -sum(body.offsets[3 * list(body.names).index(name) + 1] for name in (
            'leftUpperLeg', 'leftLowerLeg', 'leftFoot', 'leftToes'))
        self.compare(bpy.context.object, self.listen('rig'), place=lambda p: unit_m * in_blender(p), poses=6)

    def test_a_bone_between_two_that_follow_goes_with_its_parent(self):
        self.connect()
        self.chosen.stream = 'canonical'
        self.assertEqual(bpy.ops.styled.make_armature(), {'FINISHED'})
        thing = bpy.context.object
        thing.data.bones['neck'].name = 'between'
        bpy.ops.object.mode_set(mode='EDIT')
        extra = thing.data.edit_bones.new('room')  # above the hips
        extra.head, extra.tail = (0, 0, 0), (0, 0.3, 0)
        thing.data.edit_bones['hips'].parent = extra
        bpy.ops.object.mode_set(mode='OBJECT')
        thing.pose.bones['room'].location = (0.1, 0.2, 0.3)
        thing.pose.bones['room'].rotation_quaternion = (0.8, 0.2, 0.1, 0.55)
        # The head moves with its parent; all other joints are unchanged.
        self.compare(thing, self.listen(), bone_of=lambda n: None if n in ('neck', 'head') else n, poses=6)

    def test_the_newest_frame_wins_and_release_keeps_the_pose(self):
        self.connect()
        self.assertEqual(bpy.ops.styled.make_armature(), {'FINISHED'})
        thing, mine = bpy.context.object, self.listen()
        self.tick_until(lambda: self.shown(thing) > 0, 'a frame')
        for _ in range(3):
            time.sleep(0.3)
            newest = next(mine.frames(timeout=PATIENCE_S)).frame.sequence
            while True:
                update = mine.receive(0)
                if update is None:
                    break
                newest = update.frame.sequence if update.frame else newest
            before = self.shown(thing)
            tick()
            self.assertGreaterEqual(self.shown(thing), newest)
            self.assertGreater(self.shown(thing), before + 5)
        self.assertEqual(bpy.ops.styled.release(), {'FINISHED'})
        tick()
        pose = thing.pose.bones['hips'].matrix_basis.copy()
        time.sleep(0.1)
        tick()
        self.assertEqual(thing.pose.bones['hips'].matrix_basis, pose)
        self.assertIsNone(live.link(thing))

    def test_a_take_is_baked_to_keyframes(self):
        self.connect(script=DANCE)
        self.assertFalse(bpy.ops.styled.record.poll())
        thing = self.make_humanoid(roll=lambda joint: 0.7 * joint)
        self.drive(thing)
        mine = self.listen()
        self.tick_until(lambda: self.shown(thing) > 0, 'a frame')
        self.assertFalse(bpy.ops.styled.bake.poll())
        self.assertEqual(bpy.ops.styled.record(), {'FINISHED'})
        link = live.link(thing)
        self.tick_until(lambda: len(link.take) > 200, 'a take of 200 frames')
        taken = [frame.sequence for frame in link.take]
        self.assertEqual(taken, list(range(taken[0], taken[0] + len(taken))), 'every frame is in it')
        scene = bpy.context.scene
        scene.frame_current, scene.render.fps, scene.frame_end = 10, 24, 12
        self.assertEqual(bpy.ops.styled.bake(), {'FINISHED'})
        self.assertFalse(thing.styled_live.driven)
        last = 10 + int((len(taken) - 1) / 120 * 24 + 1e-3)
        self.assertEqual(tuple(thing.animation_data.action.frame_range), (10, last))
        self.assertEqual(scene.frame_end, last)
        frames = {}
        while len(frames) < len(taken):
            update = next(mine.frames(timeout=PATIENCE_S))
            if update.frame.sequence >= taken[0]:
                frames[update.frame.sequence - taken[0]] = update
        worst_m, heads = 0.0, set()
        for at in range(10, last + 1):
            scene.frame_set(at)
            update = frames[round((at - 10) * 5)]  # 120 Hz to 24
            for name, joint in zip(update.body.names, update.world()):
                head = thing.matrix_world @ thing.pose.bones[mixamo(name)].head
                worst_m = max(worst_m, (head - in_blender(joint.position)).length)
            heads.add(round(thing.pose.bones[mixamo('leftHand')].head.x, 4))
        print(f'baked: {worst_m * 1000:.4f} mm at worst, {len(heads)} places of the hand')
        self.assertLess(worst_m, TOLERANCE_M)
        self.assertGreater(len(heads), 20, 'the performer stood still: nothing was tested')
        for curve in thing.animation_data.action.fcurves:  # no turn the long way round
            values = [key.co[1] for key in curve.keyframe_points]
            self.assertEqual(len(values), last - 9)
            if curve.data_path.endswith('rotation_quaternion'):
                self.assertLess(max(abs(a - b) for a, b in zip(values, values[1:])), 0.9)

    def test_a_take_without_a_frame_is_refused(self):
        self.connect()
        bpy.ops.styled.make_armature()
        thing = bpy.context.object
        self.tick_until(lambda: self.shown(thing) > 0, 'a frame')
        bpy.ops.styled.record()
        live.link(thing).take.clear()
        with self.assertRaisesRegex(RuntimeError, 'no frame of rig.sim arrived'):
            bpy.ops.styled.bake()
        self.assertIsNone(live.link(thing).take)
        self.assertTrue(thing.styled_live.driven)

    def test_a_take_whose_bone_was_renamed_leaves_the_action_as_it_is(self):
        self.connect()
        thing = self.make_humanoid()
        action = thing.animation_data_create().action = bpy.data.actions.new('mine')
        self.drive(thing)
        self.tick_until(lambda: self.shown(thing) > 0, 'a frame')
        bpy.ops.styled.record()
        self.tick_until(lambda: len(live.link(thing).take) > 10, 'a take')
        thing.data.bones[mixamo('head')].name = 'skull'
        with self.assertRaisesRegex(RuntimeError, mixamo('head')):
            bpy.ops.styled.bake()
        self.assertEqual(thing.animation_data.action, action)
        self.assertEqual(list(bpy.data.actions), [action])
        self.assertEqual(len(action.fcurves), 0)

    def test_a_full_take_says_so(self):
        self.connect()
        bpy.ops.styled.make_armature()
        thing = bpy.context.object
        self.tick_until(lambda: self.shown(thing) > 0, 'a frame')
        with unittest.mock.patch('styled_live.live.MAX_FRAMES', 30), \
                unittest.mock.patch('styled_live.panel.MAX_FRAMES', 30):
            bpy.ops.styled.record()
            self.assertNotIn('(full)', self.drawn())
            shown = self.shown(thing)
            self.tick_until(lambda: self.shown(thing) > shown + 60, 'more frames than a take has')
            self.assertEqual(len(live.link(thing).take), 30)
            self.assertIn('recording, 30 frames (full)', self.drawn())

    def bake_a_walk(self, **other):
        """A humanoid with an action of a walk; released."""
        self.connect(script='walk:20')
        thing = self.make_humanoid(**other)
        self.drive(thing)
        self.tick_until(lambda: self.shown(thing) > 0, 'a frame')
        bpy.ops.styled.record()
        self.tick_until(lambda: len(live.link(thing).take) > 400, 'a take of 400 frames')
        bpy.context.scene.frame_current, bpy.context.scene.render.fps = 5, 30
        self.assertEqual(bpy.ops.styled.bake(), {'FINISHED'})
        return thing

    def places(self, thing):
        """Each bone's place at each frame of the action."""
        first, last = (int(x) for x in thing.animation_data.action.frame_range)
        seen = []
        for at in range(first, last + 1):
            bpy.context.scene.frame_set(at)
            seen.append([bone.head.copy() for bone in thing.pose.bones])
        return seen

    def test_an_action_is_restyled(self):
        for other in (dict(roll=lambda joint: 0.7 * joint), dict(name=lambda joint: joint, scale=0.01)):
            with self.subTest(other):
                thing = self.bake_a_walk(**other)
                size = thing.data.bones[0].head_local.z
                before, action = self.places(thing), thing.animation_data.action
                thing.pose.bones[3].keyframe_insert('scale', frame=7)
                self.chosen.stylize = os.path.join(BIN, 'stylize')
                worst = {}
                for style, strength in (('elderly', 0.0), ('elderly', 1.0)):
                    thing.animation_data.action = action
                    self.chosen.action_style, self.chosen.action_strength = style, strength
                    self.assertEqual(bpy.ops.styled.restyle(), {'FINISHED'})
                    made = thing.animation_data.action
                    self.assertEqual(tuple(made.frame_range), tuple(action.frame_range))
                    self.assertIn(style, made.name)
                    self.assertEqual(sum(c.data_path.endswith('scale') for c in made.fcurves), 3, 'other keys stay')
                    after = self.places(thing)
                    worst[strength] = max((a - b).length for row, then in zip(before, after)
                                          for a, b in zip(row, then)) / size
                print(f'restyled: {worst} of the hips\' height')
                self.assertLess(worst[0.0], 0.002, 'without strength it is the same motion')
                self.assertGreater(worst[1.0], 0.05)
                self.assertTrue(action.use_fake_user)
                live.disconnect()
                self.setUp()

    def test_what_cannot_be_restyled_is_said(self):
        thing = self.bake_a_walk()
        action = thing.animation_data.action
        self.chosen.stylize = '/nonexistent/stylize'
        with self.assertRaisesRegex(RuntimeError, "cannot run '/nonexistent/stylize'"):
            bpy.ops.styled.restyle()
        self.chosen.stylize, self.chosen.action_style = os.path.join(BIN, 'stylize'), 'olf'
        with self.assertRaisesRegex(RuntimeError, 'olf'):
            bpy.ops.styled.restyle()
        self.assertEqual(thing.animation_data.action, action)
        thing.data.bones[mixamo('hips')].name = 'middle'
        with self.assertRaisesRegex(RuntimeError, 'not a humanoid'):
            bpy.ops.styled.restyle()
        thing.animation_data.action = None
        self.assertFalse(bpy.ops.styled.restyle.poll())

    def test_styles_and_strength_reach_the_daemon(self):
        self.connect()
        self.assertIn('elderly', live.styles)
        self.assertEqual(bpy.ops.styled.style(style='elderly'), {'FINISHED'})
        with styled.Control(self.daemon.control) as control:
            def performer():
                return control.status().stats.performers[0]
            self.assertEqual(performer().styles[0].style, 'elderly')
            for strength in (0.9, 0.5, 0.25):
                self.chosen.strength = strength
            self.assertEqual(performer().strength, 1)
            tick()
            self.assertEqual(performer().strength, 0.25)
            self.assertEqual(bpy.ops.styled.clear(), {'FINISHED'})
            self.assertFalse(performer().styles)
            bpy.ops.styled.style(style='old')
            self.assertEqual(bpy.ops.styled.panic(), {'FINISHED'})
            self.assertFalse(performer().styles)
        with self.assertRaisesRegex(RuntimeError, 'olf'):
            bpy.ops.styled.style(style='olf')

    def drawn(self):
        """All calls that draw the panel, as text."""
        panel = bpy.types.STYLED_PT_live

        class Drawn:
            bl_rna = panel.bl_rna
            _draw_styles, _draw_driven = panel._draw_styles, panel._draw_driven
            layout = unittest.mock.MagicMock()

        panel.draw(Drawn(), bpy.context)
        return str(Drawn.layout.mock_calls)

    def test_the_panel_offers_what_there_is(self):
        self.assertIn('styled.connect', self.drawn())
        self.connect()
        bpy.ops.styled.make_armature()
        self.tick_until(lambda: self.shown(bpy.context.object) > 0, 'a frame')
        bpy.ops.styled.style(style='elderly')
        self.tick_until(lambda: 'elderly' in live.link(bpy.context.object).latest.styles, 'the style')
        text = self.drawn()
        for expected in ('styled.disconnect', 'styled.record', 'styled.make_armature', 'styled.panic', "text='elderly'",
                         'strength', '21 bones, frame', "text='elderly "):
            self.assertIn(expected, text)
        self.assertNotIn('ERROR', text)
        self.daemon.stop()
        self.tick_until(lambda: not live.reached, 'the loss')
        self.assertIn('no daemon publishes at ipc://', self.drawn())

    def test_what_is_wrong_is_said(self):
        self.chosen.publisher = 'nonsense'
        with self.assertRaisesRegex(RuntimeError, 'expected e.g. tcp://'):
            bpy.ops.styled.connect()
        self.assertFalse(live.active)
        self.chosen.publisher, self.chosen.control = f'ipc://{self.daemon.folder}/nobody', 'ipc:///nobody'
        self.assertEqual(bpy.ops.styled.connect(), {'FINISHED'})  # the daemon may start later
        self.assertIn('no daemon answers', live.problem)
        with self.assertRaisesRegex(RuntimeError, "no body of 'rig.sim'"):
            bpy.ops.styled.make_armature()
        self.assertEqual(bpy.ops.styled.disconnect(), {'FINISHED'})
        self.assertFalse(bpy.app.timers.is_registered(tick))
        self.assertFalse(bpy.ops.styled.drive.poll())

        self.chosen.publisher, self.chosen.control = self.daemon.publish, self.daemon.control
        self.connect()
        self.assertEqual(live.problem, '')
        thing = self.make_humanoid(name=lambda joint: f'bone{len(joint)}{joint[::-1]}')
        bpy.context.view_layer.objects.active = thing
        with self.assertRaisesRegex(RuntimeError, 'no bone has the name'):
            bpy.ops.styled.drive()
        self.assertFalse(thing.styled_live.driven)

    def test_a_daemon_that_comes_again_is_followed_again(self):
        self.connect()
        self.assertEqual(bpy.ops.styled.make_armature(), {'FINISHED'})
        thing = bpy.context.object
        self.tick_until(lambda: self.shown(thing) > 0, 'a frame')
        epoch = live.link(thing).latest.epoch
        self.daemon.stop()
        self.tick_until(lambda: not live.reached, 'the loss')
        self.daemon.start()
        self.daemon.simulate()
        self.tick_until(lambda: live.link(thing).latest.epoch != epoch, 'a frame of the new daemon')

    def test_objects_may_be_renamed_deleted_and_files_loaded_meanwhile(self):
        self.connect()
        bpy.ops.styled.make_armature()
        thing = bpy.context.object
        self.tick_until(lambda: self.shown(thing) > 0, 'a frame')
        thing.name = 'renamed'
        self.tick_until(lambda: self.shown(thing) > 0, 'a frame under the new name')
        thing.data.bones['head'].name = 'skull'
        shown = self.shown(thing)
        self.tick_until(lambda: self.shown(thing) > shown + 5, 'frames for those that are left')
        bpy.data.objects.remove(thing)
        tick()
        bpy.ops.wm.read_factory_settings(use_empty=True)
        self.assertFalse(live.active)
        self.assertIsNone(tick())


class NamesTest(unittest.TestCase):
    def test_the_habits_of_the_field(self):
        limbs = {side + limb for side in ('left', 'right') for limb in (
            'Shoulder', 'UpperArm', 'LowerArm', 'Hand', 'UpperLeg', 'LowerLeg', 'Foot', 'Toes')}
        everything = limbs | {'hips', 'spine', 'chest', 'neck', 'head'}
        beyond = ['Armature', 'IK_Hand_L', 'UpperArm_Twist_L', 'HandThumb1.L', 'LeftHandIndex1']
        for centre, parts, sided in (
                ('J_Bip_C_Hips J_Bip_C_Spine J_Bip_C_Chest J_Bip_C_Neck J_Bip_C_Head',
                 'Shoulder UpperArm LowerArm Hand UpperLeg LowerLeg Foot ToeBase', 'J_Bip_{L}_{part}'),
                ('pelvis spine_01 spine_02 neck_01 head',
                 'clavicle upperarm lowerarm hand thigh calf foot ball', '{part}_{l}'),
                ('hips spine chest neck head',
                 'shoulder upper_arm forearm hand thigh shin foot toe', '{part}.{L}'),
                ('Hips Spine Spine1 Neck Head',
                 'Shoulder Arm ForeArm Hand UpLeg Leg Foot ToeBase', 'mixamorig:{Left}{part}'),
                ('Pelvis L5 T12 Neck Head',
                 'Shoulder UpperArm ForeArm Hand UpperLeg LowerLeg Foot Toe', '{Left}{part}'),
                ('root torso_2 torso_4 neck_1 head',
                 'shoulder up_arm low_arm hand up_leg low_leg foot toes', '{l}_{part}')):
            names = beyond + centre.split()
            names += ['torso_1'] if 'torso_2' in names else ['Root']
            for word in ('Left', 'Right'):
                names += [sided.format(part=part, Left=word, L=word[0], l=word[0].lower())
                          for part in parts.split()]
            found = humanoid.map_names(names)
            self.assertEqual(set(found), everything, names)
            self.assertEqual([found[joint] for joint in ('hips', 'spine', 'chest', 'neck', 'head')],
                             centre.split())
            self.assertFalse(set(found.values()) & set(beyond))

    def test_fingers_eyes_and_jaw(self):
        for names, expected in (
                (['mixamorig:LeftHandThumb1', 'mixamorig:LeftHandThumb2', 'mixamorig:LeftEye'],
                 ['leftThumbMetacarpal', 'leftThumbProximal', 'leftEye']),
                (['leftThumbMetacarpal', 'leftThumbProximal', 'jaw'],
                 ['leftThumbMetacarpal', 'leftThumbProximal', 'jaw']),
                (['RightThumbProximal', 'RightThumbIntermediate', 'RightThumbDistal'],
                 ['rightThumbMetacarpal', 'rightThumbProximal', 'rightThumbDistal']),
                (['f_pinky.01.R', 'f_pinky.02.R'],
                 ['rightLittleProximal', 'rightLittleIntermediate']),
                (['LeftSecondPP', 'LeftSecondMP', 'LeftSecondDP'],
                 ['leftIndexProximal', 'leftIndexIntermediate', 'leftIndexDistal']),
                (['LeftFingerBase', 'LeftHandIndex1', 'LThumb'], [])):  # one stiff joint
            self.assertEqual(humanoid.map_names(['Hips'] + names),
                             dict(zip(expected, names), hips='Hips'))


if __name__ == '__main__':
    result = unittest.main(argv=['in_blender'], exit=False, verbosity=2).result
    sys.exit(0 if result.wasSuccessful() and result.testsRun else 1)
