"""BVH texts with the oddities that model/clip/clip.h lists: texts.py FOLDER writes them.

TEXTS: by name the text, what is expected of our reader, and the encoding unless it is UTF-8:
  'blender'  the same joints at the same places in each frame as Blender's importer
  'blender without Prop'  the same, without that skeleton
  'as NAME'  Blender refuses the text or reads something else; ours reads the motion of that text
  'row before'  the same, of `plain`, whose first row stands for the second
  'reads'    Blender refuses the text; ours reads it
  'refuses: WORDS'  ours refuses it with these words, whatever Blender does
"""
import pathlib
import sys

ROOT = 'CHANNELS 6 Xposition Yposition Zposition Zrotation Xrotation Yrotation'
JOINT = 'CHANNELS 3 Zrotation Xrotation Yrotation'
FRAMES = 3


def hierarchy(root=ROOT, joint=JOINT, offsets=True, end='End Site'):
    """A pelvis with a back of two joints and a leg of two."""
    def node(kind, name, offset, channels, inner):
        place = offset if offsets else '0 0 0'
        return f'{kind} {name}\n{{\nOFFSET {place}\n{channels}\n{inner}}}\n'

    tip = f'{end}\n{{\nOFFSET 0 5.5 0\n}}\n'
    back = node('JOINT', 'Back', '0 10 0.5', joint, node('JOINT', 'Neck', '0 20 -1', joint, tip))
    leg = node('JOINT', 'Thigh', '4 -2 0', joint, node('JOINT', 'Shin', '0.25 -18 0', joint, tip))
    return 'HIERARCHY\n' + node('ROOT', 'Pelvis', '1 2 3', root, back + leg)


def rows(root=6, joint=3, comma=False):
    """FRAMES rows of unlike numbers: positions up to 100, angles up to 170 degrees."""
    lines = []
    for frame in range(FRAMES):
        values = []
        for k in range(root + 4 * joint):
            value = ((k + 1) * 37.25 + frame * 13.5) % 340 - 170
            values.append(f'{value:.4f}')
        lines.append(' '.join(values) + '\n')
    text = ''.join(lines)
    return text.replace('.', ',') if comma else text


def motion(frames=f'Frames: {FRAMES}', time='Frame Time: 0.0333333', values=None):
    """The second half of a file."""
    return f'MOTION\n{frames}\n{time}\n' + (rows() if values is None else values)


def words_of(count):
    """FRAMES tuples of unlike numbers."""
    return [tuple(f'{(k * 31.5 + frame * 17) % 200 - 100:g}' for k in range(count))
            for frame in range(FRAMES)]


def values_of(lines):
    """Rows of tuples of words."""
    return ''.join(' '.join(words) + '\n' for words in lines)


def channels(kinds):
    """CHANNELS of these letters: X Y Z positions, x y z rotations."""
    names = {'X': 'Xposition', 'Y': 'Yposition', 'Z': 'Zposition',
             'x': 'Xrotation', 'y': 'Yrotation', 'z': 'Zrotation'}
    return f'CHANNELS {len(kinds)} ' + ' '.join(names[kind] for kind in kinds)


def wrapped(text):
    """Each row in three lines."""
    lines = []
    for row in text.splitlines():
        words = row.split()
        lines += [' '.join(words[:5]), ' '.join(words[5:11]), ' '.join(words[11:])]
    return '\n'.join(lines) + '\n'


def with_prop(before):
    """A second skeleton of one joint, of whose three channels each row has the values."""
    prop = f'ROOT Prop\n{{\nOFFSET 0 0 0\n{channels("XYZ")}\n}}\n'
    values = ''.join(f'7 8 9 {row}\n' if before else f'{row} 7 8 9\n'
                     for row in rows().splitlines())
    body = hierarchy()
    if before:
        return body.replace('HIERARCHY\n', 'HIERARCHY\n' + prop) + motion(values=values)
    return body + prop + motion(values=values)


def replace_row(index, old, new):
    """The plain rows, with a word of one replaced."""
    lines = rows().splitlines(keepends=True)
    words = lines[index].split()
    words[old] = new
    lines[index] = ' '.join(words) + '\n'
    return ''.join(lines)


PLAIN = hierarchy() + motion()
ROWS_OF_16, ROWS_OF_10 = words_of(16), words_of(10)
ALL = channels('XYZzxy')
POSITIONS = hierarchy(ALL, ALL) + motion(values=rows(6, 6))

TEXTS = {
    'plain': (PLAIN, 'blender'),
    # Line ends, bytes at the begin and at the end, encodings.
    'crlf': (PLAIN.replace('\n', '\r\n'), 'blender'),
    'cr': (PLAIN.replace('\n', '\r'), 'blender'),
    'cr_among_lf': (PLAIN.replace('\n', '\r', 5), 'blender'),
    'cr_cr_lf': (PLAIN.replace('\n', '\r\r\n'), 'blender'),
    'no_line_end_at_the_end': (PLAIN.rstrip('\n'), 'blender'),
    'blank_lines': (PLAIN.replace('\n', '\n\n \t\n'), 'blender'),
    'trailing_blanks': (PLAIN.replace('\n', ' \t \n'), 'blender'),
    'tabs': (PLAIN.replace(' ', '\t'), 'blender'),
    'indented': (PLAIN.replace('\n', '\n\t  '), 'blender'),
    'form_feed': (PLAIN.replace('MOTION', '\fMOTION'), 'blender'),
    'ctrl_z': (PLAIN + '\x1a', 'as plain'),
    'nul': (PLAIN + '\0' * 3, 'as plain'),
    'utf8_mark': ('\ufeff' + PLAIN, 'as plain'),
    'utf16_le': ('\ufeff' + PLAIN, 'as plain', 'utf-16-le'),
    'utf16_be': ('\ufeff' + PLAIN, 'as plain', 'utf-16-be'),
    'latin1_name': (PLAIN.replace('Neck', 'N\xe4ck'), 'reads', 'latin-1'),
    # The hierarchy.
    'lower_case': (PLAIN.lower().replace('pelvis', 'Pelvis').replace('back', 'Back')
                   .replace('neck', 'Neck').replace('thigh', 'Thigh').replace('shin', 'Shin'),
                   'blender'),
    'upper_case': (PLAIN.replace('JOINT ', 'Joint ').replace('OFFSET', 'Offset')
                   .replace('position', 'POSITION').replace('MOTION', 'Motion'), 'blender'),
    'end_site_with_a_name': (PLAIN.replace('End Site', 'End Site Tip'), 'blender'),
    'end_of_any_word': (hierarchy(end='End Effector') + motion(), 'as plain'),
    'end_without_a_word': (hierarchy(end='End') + motion(), 'as plain'),
    'no_end_sites': (PLAIN.replace('End Site\n{\nOFFSET 0 5.5 0\n}\n', ''), 'blender'),
    'brace_on_the_line': (PLAIN.replace('\n{', ' {'), 'as plain'),
    'root_before_a_prop': (with_prop(False), 'blender without Prop'),
    'root_after_a_prop': (with_prop(True), 'blender without Prop'),
    'blank_in_a_name': (PLAIN.replace('Neck', 'Upper Neck'), 'blender'),
    'name_in_utf8': (PLAIN.replace('Neck', '\u9996'), 'blender'),
    'offset_after_channels': (PLAIN.replace('OFFSET 4 -2 0\n' + JOINT, JOINT + '\nOFFSET 4 -2 0'),
                              'as plain'),
    'no_braces_of_a_joint': (PLAIN.replace('JOINT Neck\n{', 'JOINT Neck\n'), 'refuses: expected {'),
    'offsets_in_exponents': (PLAIN.replace('0 10 0.5', '0 1.0e+1 5E-1'), 'blender'),
    # Channels.
    'six_channels_on_each': (POSITIONS, 'blender'),
    'six_channels_no_offsets': (hierarchy(ALL, ALL, False) + motion(values=rows(6, 6)), 'blender'),
    'rotations_first': (hierarchy(channels('zxyXYZ')) + motion(), 'blender'),
    'positions_zyx': (hierarchy(channels('ZYXyxz')) + motion(), 'blender'),
    'orders_xyz_zyx': (hierarchy(channels('XYZxyz'), channels('zyx')) + motion(), 'blender'),
    'orders_yzx_xzy': (hierarchy(channels('XYZyzx'), channels('xzy')) + motion(), 'blender'),
    'orders_yxz_zyx': (hierarchy(channels('XYZyxz'), channels('zyx')) + motion(), 'blender'),
    'mixed_positions_and_rotations': (hierarchy(channels('XzYxZy')) + motion(), 'blender'),
    'root_without_positions': (hierarchy(channels('zxy')) + motion(values=rows(3)), 'blender'),
    # Blender takes 0 for the axes without a channel, we take the OFFSET.
    'root_of_its_offset': (hierarchy() + motion(values=values_of(
        [('1', k[0], '3', *k[1:]) for k in ROWS_OF_16])), 'blender'),
    'height_alone': (hierarchy(channels('Yzxy')) + motion(values=values_of(ROWS_OF_16)),
                     'as root_of_its_offset'),
    'one_rotation_in_three': (hierarchy() + motion(values=values_of(
        [k[:6] + tuple(w for j in k[6:] for w in (j, '0', '0'))
         for k in ROWS_OF_10])), 'blender'),
    'one_rotation': (hierarchy(ROOT, channels('z')) + motion(values=values_of(ROWS_OF_10)),
                     'as one_rotation_in_three'),
    'joints_without_channels': (hierarchy(ROOT, 'CHANNELS 0') + motion(values=rows(6, 0)),
                                'blender'),
    # The header of the motion.
    'fewer_rows_than_frames': (hierarchy() + motion('Frames: 240'), 'blender'),
    'more_rows_than_frames': (hierarchy() + motion('Frames: 1'), 'blender'),
    'frames_zero': (hierarchy() + motion('Frames: 0'), 'blender'),
    'frames_without_blank': (hierarchy() + motion('Frames:3'), 'blender'),
    'frames_blank_before_colon': (hierarchy() + motion('Frames : 3'), 'blender'),
    'time_exact': (hierarchy() + motion(time='Frame Time: 0.03333333333333333'), 'blender'),
    'time_short': (hierarchy() + motion(time='Frame Time: 0.0333'), 'blender'),
    'time_exponent': (hierarchy() + motion(time='Frame Time: 3.33333e-02'), 'blender'),
    'time_point': (hierarchy() + motion(time='Frame Time: .0333333'), 'blender'),
    'time_120': (hierarchy() + motion(time='Frame Time: 0.00833333'), 'blender'),
    'time_ntsc': (hierarchy() + motion(time='Frame Time: 0.0333667'), 'blender'),
    'time_without_blank': (hierarchy() + motion(time='Frame Time:0.0333333'), 'as plain'),
    'time_as_fraction': (hierarchy() + motion(time='Frame Time: 1/30'),
                         'refuses: a frame time of 0.001 to 1 s'),
    'no_frame_time': (PLAIN.replace('Frame Time: 0.0333333\n', ''), 'refuses: expected Frame'),
    'no_frames': (PLAIN.replace('Frames: 3\n', ''), 'refuses: expected Frames:'),
    'time_zero': (hierarchy() + motion(time='Frame Time: 0'),
                  'refuses: a frame time of 0.001 to 1 s'),
    # Rows.
    'exponents': (hierarchy() + motion(values=replace_row(1, 2, '1.25E+01')), 'blender'),
    'plus': (hierarchy() + motion(values=replace_row(1, 2, '+12.5')), 'blender'),
    'angles_beyond_a_turn': (hierarchy() + motion(values=replace_row(1, 7, '-3725.5')), 'blender'),
    'wrapped': (hierarchy() + motion(values=wrapped(rows())), 'as plain'),
    'decimal_commas': (hierarchy() + motion(values=rows(comma=True)), 'as plain'),
    'nan': (hierarchy() + motion(values=replace_row(1, 7, 'nan')), 'row before'),
    'no_number_of_windows': (hierarchy() + motion(values=replace_row(1, 7, '-1.#IND')),
                             'row before'),
    'a_value_too_many': (hierarchy() + motion(values=rows().replace('\n', ' 0\n')),
                         'refuses: more than 18 values'),
    'a_value_too_few': (hierarchy() + motion(values=rows() + '1 2 3\n'), 'refuses: found 3 values'),
    'a_word': (hierarchy() + motion(values=replace_row(1, 7, 'x')),
               'refuses: "x" as value 8 of row 2'),
}


def main():
    """Writes each text into its file."""
    folder = pathlib.Path(sys.argv[1])
    for name, (text, _, *encoding) in TEXTS.items():
        (folder / f'{name}.bvh').write_bytes(text.encode(encoding[0] if encoding else 'utf-8'))


if __name__ == '__main__':
    main()
