"""get_data.py converts clips as their makers publish them, and says which folders are as expected."""
import pathlib
import subprocess
import sys
import tarfile
import tempfile
import unittest

ROOT = pathlib.Path(__file__).resolve().parents[2]
RECIPES = ROOT / 'model' / 'train' / 'recipes'
sys.path.insert(0, str(RECIPES))
import get_data  # pylint: disable=wrong-import-position

SIX = 'CHANNELS 6 Xposition Yposition Zposition Zrotation Xrotation Yrotation'
PUBLISHED = f"""HIERARCHY
ROOT joint_Root
{{
  OFFSET 0 0 0
  {SIX}
  JOINT Hips
  {{
    OFFSET 0.04 93.9915 0.06
    {SIX}
    JOINT Spine
    {{
      OFFSET 15.7357 1.87007e-05 0
      {SIX}
      End Site
      {{
        OFFSET 10 0 0
      }}
    }}
  }}
}}
MOTION
Frames:\t2
Frame Time:\t0.0333333
0 0 -0.000146832 0 0 -0 -0.454435 86.083 0 92.4775 -2.52656 -4.7024 15.7357 0 0 71.1359 80.1013 -77.2207
10 0 20 0 0 90 1 86 2 30 20 10 15.7357 0 0 5 6 7
"""
AS_NON_COMMERCIAL = 'Attribution-NonCommercial 4.0 International\n'


def run(*arguments):
    return subprocess.run([RECIPES / 'get_data.sh', *map(str, arguments)], capture_output=True, text=True, check=False,
                          stdin=subprocess.DEVNULL)


class GetData(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.root = pathlib.Path(folder.name)

    def publish(self, number, takes, licence=AS_NON_COMMERCIAL):
        """A folder laid out as Bandai-Namco's repository."""
        at = self.root / 'repository' / 'dataset' / f'Bandai-Namco-Research-Motiondataset-{number}'
        (at / 'data').mkdir(parents=True)
        (at / 'LICENSE').write_text(licence, encoding='utf-8')
        for take in takes:
            (at / 'data' / f'dataset-{number}_{take}.bvh').write_text(PUBLISHED, encoding='utf-8')
        return self.root / 'repository'

    def test_the_root_is_folded_into_the_hips(self):
        lines = get_data.fold_root(PUBLISHED, 'a.bvh').splitlines()
        self.assertEqual(lines[:9], ['HIERARCHY', 'ROOT Hips', '{', 'OFFSET 0 0 0', SIX, 'JOINT Spine', '{',
                                     'OFFSET 15.736 1.8701e-05 0', 'CHANNELS 3 Zrotation Xrotation Yrotation'])
        self.assertEqual(lines[9:17], ['End Site', '{', 'OFFSET 10 0 0', '}', '}', '}', 'MOTION', 'Frames: 2'])
        self.assertEqual(lines[18], '-0.454 86.083 -0 92.478 -2.527 -4.702 71.136 80.101 -77.221')
        # The root turns everything by 90 degrees about y: x becomes -z, and z becomes x.
        numbers = [float(number) for number in lines[19].split()]
        self.assertEqual(numbers[:3], [12, 86, 19])
        self.assertEqual(numbers[6:], [5, 6, 7])
        turn, own, both = (get_data.matrix(angles) for angles in ([0, 0, 90], [30, 20, 10], numbers[3:6]))
        for i in range(3):
            for j in range(3):
                self.assertAlmostEqual(both[i][j], sum(turn[i][k] * own[k][j] for k in range(3)), places=4)

    def test_another_skeleton_is_refused(self):
        with self.assertRaisesRegex(get_data.Refused, 'a.bvh: found another skeleton'):
            get_data.fold_root(PUBLISHED.replace('joint_Root', 'Root'), 'a.bvh')

    def test_takes_go_where_the_cuts_say(self):
        train, first, last = get_data.CUTS['wave-right-hand_normal']
        folders = [get_data.folder_of(f'dataset-2_wave-right-hand_normal_{take:03}.bvh') for take in range(1, last + 2)]
        self.assertEqual(folders.count('bandai-2-train'), train)
        self.assertEqual(folders.count('bandai-2-val'), last - first + 1)
        self.assertIsNone(folders[-1])
        self.assertIsNone(folders[train], 'between the two')
        self.assertEqual(sum(cut[0] for cut in get_data.CUTS.values()), get_data.EXPECTED['bandai-2-train'][0])
        self.assertEqual(sum(cut[2] - cut[1] + 1 for cut in get_data.CUTS.values()), get_data.EXPECTED['bandai-2-val'][0])

    def test_clips_are_converted_and_found_not_as_expected(self):
        source = self.publish(1, ['walk_normal_001', 'dance-long_normal_001'])
        done = run('--from', source, '--accept', 'bandai-1', self.root / 'data', 'bandai-1')
        self.assertEqual(done.returncode, 1, done.stderr)
        self.assertIn('bandai-1: 1 clips, SHA-256', done.stdout)
        self.assertIn('expected 159 clips', done.stdout)
        clip = self.root / 'data' / 'bandai-1' / 'dataset-1_walk_normal_001.bvh'
        self.assertEqual(clip.read_text(encoding='utf-8'), get_data.fold_root(PUBLISHED, ''))

    def test_an_archive_is_unpacked_and_nothing_outside_its_folder(self):
        source = self.publish(1, ['walk_normal_001'])
        archive = self.root / 'master.tar.gz'
        with tarfile.open(archive, 'w:gz') as out:
            out.add(source, 'master')
            out.add(source / 'dataset' / 'Bandai-Namco-Research-Motiondataset-1' / 'LICENSE', '../../../escaped.bvh')
        done = run('--from', archive, '--accept', 'bandai-1', self.root / 'data', 'bandai-1')
        self.assertIn('bandai-1: 1 clips, SHA-256', done.stdout, done.stderr)
        self.assertEqual(list(self.root.rglob('escaped.bvh')), [])
        self.assertFalse((self.root.parent / 'escaped.bvh').exists())

    def test_a_digest_sees_names_and_contents(self):
        (self.root / 'one').mkdir()
        (self.root / 'one' / 'a.bvh').write_text('a', encoding='utf-8')
        first = get_data.digest(self.root / 'one')
        (self.root / 'one' / 'a.bvh').write_text('b', encoding='utf-8')
        second = get_data.digest(self.root / 'one')
        (self.root / 'one' / 'a.bvh').rename(self.root / 'one' / 'c.bvh')
        self.assertEqual(len({first, second, get_data.digest(self.root / 'one')}), 3)

    def test_a_licence_must_be_agreed_to_and_be_the_one_that_is_shown(self):
        source = self.publish(1, ['walk_normal_001'], 'Attribution-NonCommercial-NoDerivatives 4.0 International\n')
        done = run('--from', source, self.root / 'data', 'bandai-1')
        self.assertEqual(done.returncode, 1)
        self.assertIn('give --accept bandai-1', done.stderr)
        done = run('--from', source, '--accept', 'bandai-1', self.root / 'data', 'bandai-1')
        self.assertEqual(done.returncode, 1)
        self.assertIn('found "Attribution-NonCommercial-NoDerivatives', done.stderr)

    def test_what_cannot_be_downloaded_says_where_it_is(self):
        done = run('--accept', 'cmu', self.root / 'data', 'cmu')
        self.assertEqual(done.returncode, 1)
        self.assertIn('get it from http://mocap.cs.cmu.edu', done.stderr)


if __name__ == '__main__':
    unittest.main()
