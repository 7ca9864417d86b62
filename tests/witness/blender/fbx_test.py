"""Motion that goes through Blender's FBX and clients/blender/fbx_to_bvh.py stays what it was.

fbx_test.py READ_BACK: the distances between all joints, in every frame, are compared, because FBX
has other axes and another unit. 77: skipped.
"""
import itertools
import json
import math
import pathlib
import random
import shutil
import subprocess
import sys
import tempfile

HERE = pathlib.Path(__file__).resolve().parent
CONVERT = HERE.parents[2] / 'clients/blender/fbx_to_bvh.py'
JOINTS = [('Hips', None, (0, 90, 0)), ('Spine', 'Hips', (0, 20, 0)), ('Head', 'Spine', (0, 30, 0)),
          ('LeftArm', 'Spine', (15, 25, 0)), ('LeftForeArm', 'LeftArm', (28, 0, 0)),
          ('LeftUpLeg', 'Hips', (9, -5, 0)), ('LeftLeg', 'LeftUpLeg', (0, -42, 0)),
          ('LeftFoot', 'LeftLeg', (0, -42, 0))]
FRAMES = 20


def bvh():
    """A body that turns its joints at random, as BVH text."""
    def joint(name, offset, depth):
        pad = '  ' * depth
        head = 'JOINT' if depth else 'ROOT'
        channels = '6 Xposition Yposition Zposition ' if not depth else '3 '
        children = [joint(n, o, depth + 1) for n, parent, o in JOINTS if parent == name]
        end = f'{pad}  End Site\n{pad}  {{\n{pad}    OFFSET 0 10 0\n{pad}  }}\n'
        return (f'{pad}{head} {name}\n{pad}{{\n{pad}  OFFSET {offset[0]} {offset[1]} {offset[2]}\n'
                f'{pad}  CHANNELS {channels}Zrotation Xrotation Yrotation\n'
                f"{''.join(children) or end}{pad}}}\n")

    chance = random.Random(1)
    rows = [' '.join(f'{number:.4f}' for number in
                     [3 * frame, 90, 0] + [chance.uniform(-40, 40) for _ in range(3 * len(JOINTS))])
            for frame in range(FRAMES)]
    return (f"HIERARCHY\n{joint(JOINTS[0][0], JOINTS[0][2], 0)}MOTION\nFrames: {FRAMES}\n"
            f'Frame Time: {1 / 30:.7f}\n' + '\n'.join(rows) + '\n')


def blender(script, *arguments):
    """Runs a script in Blender without a window."""
    done = subprocess.run(['blender', '--background', '--factory-startup', '--python-exit-code', '3',
                           '--python', str(script), '--', *map(str, arguments)],
                          capture_output=True, text=True, check=False)
    return done.returncode, done.stdout + done.stderr


def distances(joints):
    """By pair of joints their distance in each frame, in lengths of the shin."""
    unit = math.dist(joints['LeftLeg'][0], joints['LeftFoot'][0])
    return {(a, b): [math.dist(p, q) / unit for p, q in zip(joints[a], joints[b])]
            for a, b in itertools.combinations(sorted(joints), 2)}


def main(read_back):
    """The exit code."""
    if shutil.which('blender') is None:
        print('skipped, no blender')
        return 77
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        (folder / 'before.bvh').write_text(bvh())
        code, log = blender(HERE / 'write_fbx.py', folder / 'before.bvh', folder / 'after.fbx')
        if code == 0:
            code, log = blender(CONVERT, folder / 'after.fbx')
        if code != 0:
            print(log[-2000:])
            return 1
        code, log = blender(CONVERT, folder / 'nothing.fbx')  # the negative control
        if code == 0 or 'nothing.fbx: is not a file' not in log:
            print('a file that is missing: expected exit code 1 and its name, found', code, log)
            return 1
        read = json.loads(subprocess.run([read_back, name], capture_output=True, check=True).stdout)
        before, after = (distances(read[key]['joints']) for key in ('before', 'after'))
        worst = max(abs(a - b) for pair, row in before.items() for a, b in zip(row, after[pair]))
        frames = len(next(iter(after.values())))
        print(f'{frames} frames, joints at most {worst:.4f} shins from where they were')
        return 0 if frames == FRAMES and worst < 0.01 else 1


sys.exit(main(sys.argv[1]))
