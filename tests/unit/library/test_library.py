"""styled.library: clips and frames restyled in this process, from files and from arrays."""
import faulthandler
import os
import sys
import tempfile
import threading
import types
import unittest
import unittest.mock

import numpy as np

import styled
from styled import library

HERE = os.path.dirname(os.path.abspath(__file__))
CLIP = os.path.join(HERE, '../../parity/fixtures/synthetic.bvh')


def angles(a, b):
    """Degrees between rotations. By the chord: the arc cosine of a float32 near 1 is 0.1 degrees off."""
    a, b = a.astype(float), b.astype(float)
    chord = np.minimum(np.linalg.norm(a - b, axis=-1), np.linalg.norm(a + b, axis=-1))
    return np.degrees(4 * np.arcsin(np.minimum(chord / 2, 1)))


class LibraryTest(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.clip = styled.Clip.read(CLIP)

    def test_a_file_is_restyled_and_written(self):
        made = styled.restyle(CLIP, 'elderly')
        self.assertEqual((len(made), made.rate_hz, made.names[0], made.own_frames), (1002, 30, 'hips', 0))
        self.assertEqual(made.names, self.clip.names)
        turned = angles(made.rotations, self.clip.rotations)
        self.assertTrue(5 < turned.mean() < 40, turned.mean())
        with tempfile.TemporaryDirectory() as folder:
            made.write(folder + '/out.bvh')
            again = styled.Clip.read(folder + '/out.bvh')
        self.assertLess(angles(made.rotations, again.rotations).max(), 0.001)
        self.assertLess(np.abs(made.root - again.root).max(), 1e-3)

    def test_arrays_are_restyled_as_the_file_is(self):
        c = self.clip
        made = styled.Clip(c.names, c.parents, c.offsets, c.rate_hz, c.root, c.rotations, c.rest)
        self.assertTrue((made.rotations == c.rotations).all())
        one, other = styled.restyle(made, 'elderly'), styled.restyle(c, 'elderly')
        self.assertLess(angles(one.rotations, other.rotations).max(), 0.001)
        self.assertTrue((made.rotations == c.rotations).all(), 'the input does not change')
        with self.assertRaises(ValueError):
            c.rotations[0] = 0

    def test_a_frame_alone_is_a_clip(self):
        c = self.clip
        made = styled.restyle(styled.Clip(c.names, c.parents, c.offsets, 30, c.root[0], c.rotations[0], c.rest),
                              'elderly')
        self.assertEqual(made.rotations.shape, (1, len(c.names), 4))
        self.assertGreater(angles(made.rotations[0], c.rotations[0]).max(), 5)

    def test_a_mix_lies_between_and_neutral_is_the_performers_own(self):
        def far(style):
            return angles(styled.restyle(self.clip, style).rotations, self.clip.rotations).mean()
        self.assertLess(far({'elderly': 0.5}), 0.8 * far('elderly'))
        own = styled.restyle(self.clip, 'neutral').rotations
        self.assertTrue((own == self.clip.rotations).all())
        self.assertGreater(far({'elderly': 0.5, 'happy': 0.5}), 1)

    def test_positions_are_those_of_the_skeleton(self):
        places = self.clip.positions()
        for joint, parent in enumerate(self.clip.parents[1:], 1):
            lengths = np.linalg.norm(places[:, joint] - places[:, parent], axis=-1)
            self.assertLess(np.abs(lengths - np.linalg.norm(self.clip.offsets[joint])).max(), 0.01)
        head, foot = (places[:, self.clip.names.index(name), 1] for name in ('head', 'leftFoot'))
        self.assertTrue((head > foot + 100).all(), 'centimetres, +Y up')

    def test_frames_are_those_of_the_clip(self):
        by = styled.library.network()
        performer = styled.Performer(self.clip, 'elderly', by)
        performer.learn(self.clip)
        whole = self.clip.restyled('elderly', by)
        for i in range(60):
            root, rotations = performer.frame(i / 30, self.clip.root[i], self.clip.rotations[i])
            self.assertLess(angles(rotations, whole.rotations[i]).max(), 0.001, i)
        with self.assertRaisesRegex(ValueError, "after the last frame's"):
            performer.frame(0, self.clip.root[0], self.clip.rotations[0])
        performer.reset()
        performer.frame(0, self.clip.root[0], self.clip.rotations[0])
        with self.assertRaisesRegex(ValueError, 'seconds: found 99'):
            performer.calibrate(99)

    def test_an_example_becomes_a_style(self):
        by = styled.Network('open')
        example = self.clip.restyled('zombie', by)
        made = by.like('mine', example, CLIP)
        self.assertEqual(made.styles, by.styles + ['mine'])
        self.assertEqual(made.licence('mine'), 'that of the example')
        styled_clip = self.clip.restyled('mine', made)
        self.assertGreater(angles(styled_clip.rotations, self.clip.rotations).mean(), 5)
        performer = styled.Performer(self.clip, 'zombie', by)
        performer.frame(0, self.clip.root[0], self.clip.rotations[0])
        with self.assertRaisesRegex(ValueError, "unknown style 'mine'"):
            performer.set('mine')
        performer.adopt(made)
        performer.set('mine')
        performer.frame(1 / 30, self.clip.root[1], self.clip.rotations[1])
        with self.assertRaisesRegex(ValueError, "that like\\(\\) has made from the performer's"):
            performer.adopt(by)
        with self.assertRaisesRegex(styled.LibraryError, 'found "zombie", which the network has'):
            by.like('zombie', example)
        with self.assertRaisesRegex(styled.LibraryError, 'no style encoder'):
            styled.Network('v2').like('mine', example)

    def test_other_threads_run_meanwhile(self):
        # The file is a pipe, which a second thread writes while the library waits for it.
        with tempfile.TemporaryDirectory() as folder, open(CLIP, 'rb') as file:
            pipe, text = folder + '/in.bvh', file.read()
            os.mkfifo(pipe)

            def write():
                with open(pipe, 'wb') as to:
                    to.write(text)

            thread = threading.Thread(target=write)
            faulthandler.dump_traceback_later(60, exit=True)  # with the GIL held neither thread would end
            thread.start()
            self.assertEqual(len(styled.Clip.read(pipe)), len(self.clip))
            thread.join()
            faulthandler.cancel_dump_traceback_later()

    def test_clips_and_performers_are_released(self):
        def resident():
            with open('/proc/self/statm', encoding='ascii') as statm:
                return int(statm.read().split()[1])
        for turn in range(150):
            styled.Performer(self.clip, 'elderly')
            self.clip.restyled('neutral')
            if turn == 50:
                before = resident()
        self.assertLess(resident() - before, 2500, 'pages; a hundred of either would be 25,000')

    def test_what_is_wrong_is_said(self):
        c = self.clip
        for error, text, call in (
                (library.LibraryError, 'nosuch.bvh', lambda: styled.restyle('nosuch.bvh', 'elderly')),
                (ValueError, "unknown style 'olf', expected one of neutral, active", lambda: styled.restyle(c, 'olf')),
                (library.LibraryError, 'expected 0 to 4 different ones', lambda: styled.restyle(c, {'elderly': 2})),
                (library.LibraryError, r'no weights file: expected .*STYLED_WEIGHTS\), looked for nowhere, .*/nowhere.safetensors$',
                 lambda: styled.restyle(c, 'old', weights='nowhere')),
                (library.LibraryError, 'found "half", expected int8', lambda: styled.Network(precision='half')),
                (library.LibraryError, 'rate: found 0.0', lambda: styled.Clip(c.names, c.parents, c.offsets, 0, c.root,
                                                                             c.rotations)),
                (ValueError, r'rotations: found shape \(1002, 20, 4\), expected \(1002, 21, 4\)',
                 lambda: styled.Clip(c.names, c.parents, c.offsets, 30, c.root, c.rotations[:, 1:])),
                (library.LibraryError, 'give one side by hand|no joint',
                 lambda: styled.Clip(['a', 'b'], [-1, 0], np.ones((2, 3)), 30, c.root, c.rotations[:, :2])),
                (library.LibraryError, 'the rig has no joint "x"',
                 lambda: styled.Clip.read(CLIP, joints=['leftFoot=x'])),
                (library.LibraryError, '/nowhere/out.bvh', lambda: c.write('/nowhere/out.bvh'))):
            with self.assertRaisesRegex(error, text):
                call()

    def test_blenders_add_on_restyles_in_its_process(self):
        bpy = unittest.mock.MagicMock()
        bpy.types = types.SimpleNamespace(Operator=object, PropertyGroup=object, Panel=object)
        bpy.app.handlers.persistent = lambda function: function
        with unittest.mock.patch.dict(sys.modules, {'bpy': bpy, 'bpy.props': bpy.props,
                                                    'mathutils': unittest.mock.MagicMock()}):
            sys.path.insert(0, os.path.join(HERE, '../../../clients/blender'))
            from styled_live import restyle  # pylint: disable=import-outside-toplevel
        with tempfile.TemporaryDirectory() as folder:
            restyle._stylize('', 'elderly', 1.0, CLIP, folder + '/out.bvh')
            turned = angles(styled.Clip.read(folder + '/out.bvh').rotations, self.clip.rotations)
            self.assertGreater(turned.mean(), 5)
            with self.assertRaisesRegex(restyle.Failed, "unknown style 'olf'"):
                restyle._stylize('', 'olf', 1.0, CLIP, folder + '/out.bvh')
            with unittest.mock.patch.object(library, 'library_version', side_effect=library.LibraryError('none')), \
                    unittest.mock.patch.dict(os.environ, PATH='/nonexistent'), \
                    self.assertRaisesRegex(restyle.Failed, 'none; or give the path of the program stylize'):
                restyle._stylize('', 'elderly', 1.0, CLIP, folder + '/out.bvh')

    def test_styles_have_their_terms(self):
        by = styled.Network('open')
        self.assertIn('zombie', by.styles)
        self.assertTrue(by.licence('zombie'))
        self.assertRegex(library.library_version(), r'^\d+\.\d+\.\d+$')


if __name__ == '__main__':
    unittest.main()
