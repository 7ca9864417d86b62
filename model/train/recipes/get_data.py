#!/usr/bin/env python3
"""Gets the clips that the manifests of model/weights/manifests name, and says whether they are the same.

    get_data.sh --list                      what there is: address, licence
    get_data.sh DATA [SET...]               downloads, converts and checks; all that can be downloaded by default
    get_data.sh --from DOWNLOAD DATA SET    the same from an archive or a folder that is there already
    get_data.sh --check DATA                only says which folders of DATA are as the shipped weights saw them

DATA is the folder for styletrain's --data, or STYLED_DATA. Each licence is shown and must be agreed to, at the
terminal or by --accept SET.
"""
import argparse
import hashlib
import json
import math
import pathlib
import re
import shutil
import sys
import tarfile
import tempfile
import urllib.error
import urllib.request
import zipfile

BANDAI = 'https://github.com/BandaiNamcoResearchInc/Bandai-Namco-Research-Motiondataset'
SETS = {
    'bandai-1': {
        'page': BANDAI, 'archive': BANDAI + '/archive/refs/heads/master.tar.gz',
        'licence': 'CC BY-NC 4.0: non-commercial, and so are networks trained on it. Cite Kobayashi et al. 2023, '
                   'arXiv 2306.08861.',
        'folders': ['bandai-1']},
    'bandai-2': {
        'page': BANDAI, 'archive': BANDAI + '/archive/refs/heads/master.tar.gz',
        'licence': 'CC BY-NC 4.0: non-commercial, and so are networks trained on it. Cite Kobayashi et al. 2023, '
                   'arXiv 2306.08861.',
        'folders': ['bandai-2-train', 'bandai-2-val']},
    '100style': {
        'page': 'https://zenodo.org/records/8127870', 'record': 'https://zenodo.org/api/records/8127870',
        'licence': 'CC BY 4.0. Credit "The 100STYLE Dataset - Ian Mason", doi 10.1145/3522618, and state the changes.',
        'folders': ['100style'],
        'cut': 'The shipped weights saw these takes without their T-poses and without the last 15 s, so whole ones differ.'},
    'cmu': {
        'page': 'http://mocap.cs.cmu.edu, as BVH by Bruce Hahne at www.cgspeed.com',
        'licence': '"This data is free for use in research projects. You may include this data in commercially-sold '
                   'products, but you may not resell this data directly, even in converted form." Acknowledge "The data used '
                   'in this project was obtained from mocap.cs.cmu.edu. The database was created with funding from NSF '
                   'EIA-0196217."',
        'folders': ['cmu']},
    'accad': {
        'page': 'https://accad.osu.edu/research/motion-lab/mocap-system-and-data',
        'licence': 'CC BY 3.0, as stated by the Open Motion Project of ACCAD. Credit "ACCAD, The Ohio State University", and '
                   'state the changes.',
        'folders': ['accad']},
}
# Of each folder as the shipped weights saw it: its number of clips, and the SHA-256 of the lines "SHA-256  NAME" of
# its clips in the order of their names.
FACTS = json.loads(pathlib.Path(__file__).with_name('data.json').read_text(encoding='utf-8'))
EXPECTED = FACTS['folders']
# Set 2's takes of one content and style: 1 to the first number train, between the second and the third validate. One
# between them is left out, because consecutive takes continue one another, and so are those after them.
CUTS = FACTS['bandai-2']


class Refused(Exception):
    """An error for the terminal."""


def digest(folder):
    """The number of clips of a folder, and the SHA-256 of their names and contents."""
    clips = sorted(folder.rglob('*.bvh'), key=lambda clip: str(clip.relative_to(folder)))
    lines = [f'{hashlib.sha256(clip.read_bytes()).hexdigest()}  {clip.relative_to(folder).as_posix()}\n' for clip in clips]
    return len(clips), hashlib.sha256(''.join(lines).encode()).hexdigest()


def check(data, folders):
    """Prints whether each folder is as expected; the number of those that are not."""
    wrong = 0
    for folder in folders:
        clips, found = digest(data / folder)
        wanted = EXPECTED[folder]
        same = [clips, found] == wanted
        wrong += not same
        print(f'{folder}: {clips} clips, ' + ('as the shipped weights saw them' if same else
              f'SHA-256 {found[:16]}; expected {wanted[0]} clips, {wanted[1][:16]}'))
    return wrong


def matrix(degrees):
    """The rotation Z X Y of three angles."""
    z, x, y = map(math.radians, degrees)
    sz, cz, sx, cx, sy, cy = math.sin(z), math.cos(z), math.sin(x), math.cos(x), math.sin(y), math.cos(y)
    return [[cz * cy - sz * sx * sy, -sz * cx, cz * sy + sz * sx * cy],
            [sz * cy + cz * sx * sy, cz * cx, sz * sy - cz * sx * cy],
            [-cx * sy, sx, cx * cy]]


def angles(m):
    """Z, X, Y of a rotation."""
    return [math.degrees(a) for a in (math.atan2(-m[0][1], m[1][1]), math.asin(max(-1.0, min(1.0, m[2][1]))),
                                      math.atan2(-m[2][0], m[2][2]))]


def fold_root(text, name):
    """A clip of Bandai-Namco's with joint_Root folded into Hips, other joints' positions left out, and rounded."""
    head, separator, motion = text.partition('MOTION')
    lines = [line.strip() for line in head.splitlines() if line.strip()]
    if not separator or lines[1:2] != ['ROOT joint_Root'] or lines[5:6] != ['JOINT Hips']:
        raise Refused(f'{name}: found another skeleton, expected joint_Root above Hips')
    out = ['HIERARCHY', 'ROOT Hips', '{', 'OFFSET 0 0 0',
           'CHANNELS 6 Xposition Yposition Zposition Zrotation Xrotation Yrotation']
    for line in lines[9:-1]:  # behind the channels of Hips, before the end of joint_Root
        if line.startswith('OFFSET'):
            line = 'OFFSET ' + ' '.join('%.5g' % float(number) for number in line.split()[1:])
        elif line.startswith('CHANNELS'):
            line = 'CHANNELS 3 Zrotation Xrotation Yrotation'
        out.append(line)
    rows = [line.split() for line in motion.splitlines() if line.strip()]
    frames, seconds = rows[0][-1], rows[1][-1]
    out += ['MOTION', f'Frames: {frames}', f'Frame Time: {seconds}']
    for row in rows[2:]:
        numbers = [float(number) for number in row]
        root, hips = numbers[:6], numbers[6:12]
        turn = matrix(root[3:])
        place = [root[i] + sum(turn[i][k] * hips[k] for k in range(3)) for i in range(3)]
        turned = hips[3:]
        if any(root[3:]):
            own = matrix(turned)
            turned = angles([[sum(turn[i][k] * own[k][j] for k in range(3)) for j in range(3)] for i in range(3)])
        rest = [numbers[i + k] for i in range(12, len(numbers), 6) for k in (3, 4, 5)]
        out.append(' '.join('%.10g' % round(number, 3) for number in place + turned + rest))
    return '\n'.join(out) + '\n'


def folder_of(take):
    """The folder of a take of set 2, by its name; None if it is not used."""
    content, style, number = re.fullmatch(r'dataset-2_(.+)_([a-z]+)_(\d+)\.bvh', take).groups()
    train, first, last = CUTS.get(f'{content}_{style}', [0, 0, -1])
    if 1 <= int(number) <= train:
        return 'bandai-2-train'
    return 'bandai-2-val' if first <= int(number) <= last else None


def convert_bandai(source, data, number):
    """Set `number` of a download in the layout of its repository."""
    found = sorted(source.rglob(f'Bandai-Namco-Research-Motiondataset-{number}'))
    clips = sorted(found[0].rglob('*.bvh')) if found else []
    if not clips:
        raise Refused(f'{source}: found no clips of Bandai-Namco-Research-Motiondataset-{number}')
    licence = (found[0] / 'LICENSE')
    if licence.is_file():
        title = licence.read_text(encoding='utf-8').splitlines()[0]
        if title != 'Attribution-NonCommercial 4.0 International':
            raise Refused(f'{licence}: found "{title}", expected "Attribution-NonCommercial 4.0 International": an earlier '
                          'download, whose licence does not let you share anything made with it')
    for clip in clips:
        if number == 1:
            folder = 'bandai-1' if 'dance-long' not in clip.name else None
        else:
            folder = folder_of(clip.name)
        if folder is None:
            continue
        (data / folder).mkdir(parents=True, exist_ok=True)
        (data / folder / clip.name).write_text(fold_root(clip.read_text(encoding='utf-8'), clip.name), encoding='utf-8')


def copy_clips(source, data, folder):
    """The clips that the folder needs, as they are, from anywhere under the source."""
    wanted = FACTS['names'][folder]
    present = {clip.name: clip for clip in sorted(source.rglob('*.bvh'))}
    found = {name: present[pathlib.Path(name).name] for name in wanted if pathlib.Path(name).name in present}
    if not found:
        raise Refused(f'{source}: found none of the {len(wanted)} clips of {folder}')
    for name, clip in found.items():
        (data / folder / name).parent.mkdir(parents=True, exist_ok=True)
        shutil.copyfile(clip, data / folder / name)
    missing = [name for name in wanted if name not in found]
    if missing:
        print(f'{folder}: {len(missing)} of {len(wanted)} clips are missing: {", ".join(missing[:5])}')


def fetch(address, file, sum_of=None):
    """Downloads; `sum_of`: "md5:..." as the publisher states it."""
    with urllib.request.urlopen(address) as response, open(file, 'wb') as out:
        size = response.headers.get('Content-Length')
        print(f'{address}: ' + (f'{int(size) / 1e6:.0f} MB' if size else 'of unknown size'))
        shutil.copyfileobj(response, out)
    if sum_of:
        kind, _, wanted = sum_of.partition(':')
        found = hashlib.new(kind, file.read_bytes()).hexdigest()
        if found != wanted:
            raise Refused(f'{file}: {kind} {found}, expected {wanted}')


def download(name, folder):
    """The archive of a set in `folder`."""
    if 'archive' in SETS[name]:
        file = folder / f'{name}.tar.gz'
        fetch(SETS[name]['archive'], file)
        return file
    if 'record' in SETS[name]:
        with urllib.request.urlopen(SETS[name]['record']) as response:
            files = json.load(response).get('files', [])
        archive = next((file for file in files if file['key'].endswith('.zip')), None)
        if archive is None:
            raise Refused(f'{SETS[name]["record"]}: found no archive')
        file = folder / archive['key']
        fetch(archive['links']['self'], file, archive.get('checksum'))
        return file
    raise Refused(f'{name} has no address of one archive: get it from {SETS[name]["page"]}, then give --from')


def unpack_tar(archive, folder):
    """Files and folders below `folder`, and nothing else: Debian 12's Python has no filter for that."""
    root = folder.resolve()
    for member in archive.getmembers():
        place = (root / member.name).resolve()
        if (member.isfile() or member.isdir()) and (place == root or root in place.parents):
            archive.extract(member, root)


def unpack(source, folder):
    """A folder with what an archive holds; a folder as it is."""
    if source.is_dir():
        return source
    if zipfile.is_zipfile(source):
        with zipfile.ZipFile(source) as archive:
            archive.extractall(folder)
    elif tarfile.is_tarfile(source):
        with tarfile.open(source) as archive:
            unpack_tar(archive, folder)
    else:
        raise Refused(f'{source}: expected a folder, a .zip or a .tar.gz')
    for inner in sorted(folder.rglob('data.zip')):  # in Bandai-Namco's repository, beside the folder of the same clips
        if zipfile.is_zipfile(inner) and not (inner.parent / 'data').is_dir():
            with zipfile.ZipFile(inner) as archive:
                archive.extractall(inner.parent / 'data')
    return folder


def agree(name, accepted):
    print(f'{name}, {SETS[name]["page"]}\n  {SETS[name]["licence"]}')
    if name in accepted:
        return
    if not sys.stdin.isatty():
        raise Refused(f'{name}: the licence is not agreed to; read it, and give --accept {name}')
    if input('Do you agree? [yes/no] ').strip() != 'yes':
        raise Refused(f'{name}: not agreed to')


def get(name, data, source, accepted):
    agree(name, accepted)
    with tempfile.TemporaryDirectory(dir=data) as scratch:
        scratch = pathlib.Path(scratch)
        source = unpack(pathlib.Path(source) if source else download(name, scratch), scratch / 'unpacked')
        if name.startswith('bandai-'):
            convert_bandai(source, data, int(name[-1]))
        else:
            copy_clips(source, data, name)
    if 'cut' in SETS[name]:
        print(f'{name}: {SETS[name]["cut"]}')
    return check(data, SETS[name]['folders'])


def main():
    parser = argparse.ArgumentParser(description=__doc__.split('\n\n')[0], epilog='\n\n'.join(__doc__.split('\n\n')[1:]),
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument('--list', action='store_true')
    parser.add_argument('--check', action='store_true')
    parser.add_argument('--from', dest='source', metavar='DOWNLOAD')
    parser.add_argument('--accept', action='append', default=[], choices=SETS, metavar='SET')
    parser.add_argument('data', nargs='?', metavar='DATA')
    parser.add_argument('sets', nargs='*', metavar='SET')
    arguments = parser.parse_args()
    if arguments.list:
        for name, one in SETS.items():
            print(f'{name}: {one["page"]}\n  {one["licence"]}')
        return 0
    unknown = [name for name in arguments.sets if name not in SETS]
    if arguments.data is None or unknown or (arguments.source and len(arguments.sets) != 1):
        parser.error('expected DATA' if arguments.data is None else
                     f'found the set {unknown[0]}, expected some of {", ".join(SETS)}' if unknown else
                     'expected one SET with --from')
    data = pathlib.Path(arguments.data)
    if arguments.check:
        return 1 if check(data, [folder for folder in EXPECTED if (data / folder).is_dir()]) else 0
    data.mkdir(parents=True, exist_ok=True)
    sets = arguments.sets or [name for name, one in SETS.items() if 'archive' in one or 'record' in one]
    return 1 if sum(get(name, data, arguments.source, arguments.accept) for name in sets) else 0


if __name__ == '__main__':
    try:
        sys.exit(main())
    except (Refused, OSError, urllib.error.URLError) as error:
        print(f'get_data.sh: {error}', file=sys.stderr)
        sys.exit(1)
