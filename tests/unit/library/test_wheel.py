"""The wheel with libstyled in it: installed into a virtual environment, it restyles a clip in a fresh folder."""
import glob
import os
import subprocess
import sys
import tempfile
import unittest

ROOT = os.path.abspath(os.path.join(os.path.dirname(__file__), '../../..'))
PROGRAM = '''
import sys, styled
clip = styled.restyle(sys.argv[1], sys.argv[2])
assert styled.restyle(clip, 'zombie', weights='open').own_frames == 0
clip.write('out.bvh')
print(styled.__file__, len(clip))
'''


def run(*command, **options):
    done = subprocess.run(command, capture_output=True, text=True, timeout=200, **options)
    if done.returncode:
        raise AssertionError(f'{command}: {done.returncode}\n{done.stdout}\n{done.stderr}')
    return done.stdout


class WheelTest(unittest.TestCase):
    def test_one_file_is_installed_and_restyles(self):
        self.check(('v2', 'open'), 'elderly', 'Apache-2.0 AND CC-BY-NC-4.0 AND CC-BY-4.0')

    def test_with_the_weights_for_commercial_use_alone(self):
        self.check(('open',), 'zombie', 'Apache-2.0 AND CC-BY-4.0')

    def check(self, names, style, licence):
        weights = [f'{ROOT}/model/weights/{name}.safetensors' for name in names]
        with tempfile.TemporaryDirectory(prefix='styled-wheel-') as folder:
            run(os.environ['STYLED_CMAKE'], f'-DPACKAGE={os.environ["PYTHONPATH"]}', f'-DWORK={folder}/work',
                f'-DTO={folder}/made', f'-DLIBRARY={os.environ["STYLED_LIBRARY"]}', f'-DWEIGHTS={";".join(weights)}',
                '-P', ROOT + '/clients/python/build_wheel.cmake')
            wheel, = glob.glob(folder + '/made/*.whl')
            self.assertRegex(wheel, r'-py3-none-linux_\w+\.whl$')
            run(sys.executable, '-m', 'venv', '--system-site-packages', folder + '/venv')
            python = folder + '/venv/bin/python'
            clean = {k: v for k, v in os.environ.items() if not k.startswith(('PYTHON', 'STYLED'))}
            run(python, '-m', 'pip', 'install', '--no-index', '--quiet', wheel, env=clean)
            found = run('ldd', glob.glob(folder + '/venv/lib/*/site-packages/styled/libstyled.so.0')[0], env=clean)
            outside = [line for line in found.splitlines() if 'libhwy' in line and folder not in line]
            self.assertEqual(outside, [], 'what Debian alone has is in the wheel')
            out = run(python, '-c', PROGRAM, ROOT + '/tests/parity/fixtures/synthetic.bvh', style, cwd=folder,
                      env=clean)
            where, frames = out.split()
            self.assertTrue(where.startswith(folder + '/venv/'), where)
            self.assertEqual(frames, '1002')
            self.assertTrue(os.path.getsize(folder + '/out.bvh'))
            metadata, = glob.glob(folder + '/venv/lib/*/site-packages/styled_mocap-*.dist-info/METADATA')
            with open(metadata, encoding='utf-8') as text:
                self.assertIn(f'License: {licence}\n', text.read())


if __name__ == '__main__':
    try:
        import ensurepip  # noqa: F401
        import setuptools  # noqa: F401
        import wheel  # noqa: F401
    except ImportError as error:
        print(f'skipped, {error}: a wheel is made with python3-setuptools, python3-wheel and python3-venv')
        sys.exit(77)
    unittest.main()
