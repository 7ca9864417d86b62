"""Runs in_blender.py in Blender, with folders of its own instead of the user's."""
import os
import shutil
import subprocess
import sys
import tempfile

HERE = os.path.dirname(os.path.abspath(__file__))
SKIPPED = 77

blender = shutil.which('blender')
if blender is None:
    print('skipped, no blender (Debian: apt install --no-install-recommends blender python3-zmq '
          'python3-protobuf)')
    sys.exit(SKIPPED)
with tempfile.TemporaryDirectory(prefix='styled-blender-') as folder:
    # Debian's Blender takes the first python3 of PATH for its own, and wants Debian's packages.
    environment = dict(os.environ, PATH='/usr/bin:' + os.environ['PATH'],
                       BLENDER_USER_CONFIG=os.path.join(folder, 'config'),
                       BLENDER_USER_SCRIPTS=os.path.join(folder, 'scripts'),
                       BLENDER_USER_DATAFILES=os.path.join(folder, 'datafiles'))
    done = subprocess.run([blender, '--background', '--factory-startup', '--python-exit-code', '1',
                           '--python', os.path.join(HERE, 'in_blender.py')], env=environment)
sys.exit(done.returncode)
