#!/usr/bin/env python3
"""Makes small WebP files of the pictures of tests/pictures.sh, and the film of its frames: pictures.py FROM TO."""
import glob
import os
import sys

from PIL import Image

FILM = (800, 450)
RATE = 10  # pictures a second: more make the file larger, and are hardly seen


def main():
    source, target = sys.argv[1:]
    for picture in glob.glob(os.path.join(source, '*.png')):
        name = os.path.splitext(os.path.basename(picture))[0]
        Image.open(picture).convert('RGB').save(os.path.join(target, f'{name}.webp'), quality=80, method=6)
    times = sorted(float(os.path.basename(name)[:-4]) for name in glob.glob(os.path.join(source, 'film', '*.jpg')))
    if len(times) < 20:
        sys.exit(f'pictures: {len(times)} frames of a film, expected at least 20: is the machine busy?')
    ticks = [i / RATE for i in range(int(times[-1] * RATE) + 1)]
    chosen = [max((time for time in times if time <= tick + 1e-6), default=times[0]) for tick in ticks]
    frames = [Image.open(os.path.join(source, 'film', f'{time:07.3f}.jpg')).convert('RGB').resize(FILM, Image.LANCZOS) for time in chosen]
    frames[0].save(os.path.join(target, 'film.webp'), save_all=True, append_images=frames[1:], duration=1000 // RATE, loop=0, quality=60, method=6)
    print(f'film: {len(set(chosen))} pictures in {ticks[-1]:.1f} s')


main()
