#!/usr/bin/env python3
"""Writes the notebook beside it, executed: `make_notebook.py [CLIP [NOTEBOOK]]`. Needs Debian's python3-nbclient,
python3-ipykernel and python3-matplotlib, and the package styled with libstyled. A cell that fails is an error."""
import os
import sys

import nbformat
from nbclient import NotebookClient

HERE = os.path.dirname(os.path.abspath(__file__))
CELLS = (
    '# A clip in several styles\n\nA BVH file is restyled in this process: no daemon runs. The wheel of `styled` for Linux has '
    'all that is needed.',
    '''import os
import matplotlib.pyplot as plt
import styled

clip = styled.Clip.read(os.environ.get('CLIP', 'walk.bvh'))
print(len(clip), 'frames at', clip.rate_hz, 'Hz,', len(clip.names), 'joints')
by = styled.Network('open')          # styles that a company may use, too
print(', '.join(by.styles))
for style in ('zombie', 'angry'):
    print(style + ':', by.licence(style))''',
    'Each style is a call; the result is another clip of numpy arrays. Frames are drawn from the side.',
    '''def draw(axis, shown, title):
    places = shown.positions()[::25][:12]
    for step, joints in enumerate(places):
        for joint, parent in enumerate(shown.parents):
            if parent >= 0:
                axis.plot(0.9 * 100 * step + joints[[joint, parent], 2] - joints[0, 2], joints[[joint, parent], 1], 'C0', lw=1)
    axis.set_title(title, fontsize=8, loc='left')
    axis.axis('equal')
    axis.axis('off')

figure, axes = plt.subplots(3, 1, figsize=(6, 4.5), dpi=70)
draw(axes[0], clip, 'as captured')
for axis, style in zip(axes[1:], ('zombie', 'mummy')):
    draw(axis, clip.restyled(style, by), style)''',
    'A mix of styles, and how far each joint turns on average; then a file.',
    '''import numpy as np

half = clip.restyled({'angry': 0.5, 'rushed': 0.5}, by)
turned = np.degrees(2 * np.arccos(np.clip(np.abs((half.rotations * clip.rotations).sum(-1)), 0, 1))).mean(0)
for joint in turned.argsort()[::-1][:5]:
    print(f'{half.names[joint]:15} {turned[joint]:5.1f} degrees')
half.write(os.path.join(os.environ.get('OUT', '.'), 'angry-rushed.bvh'))''',
)


def main() -> None:
    clip, to = (sys.argv[1:] + ['walk.bvh', os.path.join(HERE, 'restyle.ipynb')][len(sys.argv) - 1:])[:2]
    os.environ['CLIP'] = os.path.abspath(clip)
    notebook = nbformat.v4.new_notebook()
    for number, source in enumerate(CELLS):
        make = nbformat.v4.new_code_cell if number % 2 else nbformat.v4.new_markdown_cell
        notebook.cells.append(make(source, id=f'cell-{number}'))
    NotebookClient(notebook, timeout=120, kernel_name='python3').execute()
    for cell in notebook.cells:
        cell.metadata.clear()
    notebook.metadata.clear()
    nbformat.write(notebook, to)


if __name__ == '__main__':
    main()
