"""The Python client's wheel, in a virtual environment and a folder that know nothing of the tree."""
import email
import json
import os
import re
import subprocess
import sys
import tempfile
import time
import unittest
import zipfile

import zmq

ROOT = os.path.abspath(os.path.join(os.path.dirname(__file__), '..', '..', '..'))
PACKAGE = os.environ['STYLED_PACKAGE']  # what the target styled_python made
SKIPPED = 77
PATIENCE_S = 120

READER = '''
import sys, styled
with styled.Subscriber(sys.argv[1], streams='canonical') as subscriber:
    update = next(subscriber.frames(timeout=60))
print(styled.__file__)
print(*update.world()['head'].position)
'''


def run(*command, **options):
    done = subprocess.run(command, capture_output=True, text=True, timeout=PATIENCE_S, **options)
    if done.returncode:
        raise AssertionError(f'{command}: {done.returncode}\n{done.stdout}\n{done.stderr}')
    return done.stdout


class WheelTest(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls._folder = tempfile.TemporaryDirectory(prefix='styled-wheel-')
        cls.folder = cls._folder.name
        run(os.environ['STYLED_CMAKE'], f'-DPACKAGE={PACKAGE}', f'-DWORK={cls.folder}/work',
            f'-DTO={cls.folder}', '-P', os.path.join(ROOT, 'clients/python/build_wheel.cmake'))
        cls.wheel, = (os.path.join(cls.folder, f) for f in os.listdir(cls.folder) if f.endswith('.whl'))
        # pyzmq and protobuf are the system's, since a test downloads nothing.
        run(sys.executable, '-m', 'venv', '--system-site-packages', cls.folder + '/venv')
        cls.python = cls.folder + '/venv/bin/python'
        cls.clean = {k: v for k, v in os.environ.items() if not k.startswith('PYTHON')}
        run(cls.python, '-m', 'pip', 'install', '--no-index', '--quiet', cls.wheel, env=cls.clean)

    @classmethod
    def tearDownClass(cls):
        cls._folder.cleanup()

    def test_has_the_client_its_messages_and_their_types_and_no_more(self):
        with zipfile.ZipFile(self.wheel) as wheel:
            names = set(wheel.namelist())
            metadata = wheel.read(next(n for n in names if n.endswith('/METADATA'))).decode()
            tags = wheel.read(next(n for n in names if n.endswith('/WHEEL')))
        for wanted in ('styled/__main__.py', 'styled/py.typed', 'styled/v1/frame_pb2.py',
                       'styled/v1/frame_pb2.pyi'):
            self.assertIn(wanted, names)
        self.assertEqual({n.split('/')[0] for n in names if '.dist-info' not in n}, {'styled'})
        self.assertIn(b'Root-Is-Purelib: true', tags)
        metadata = email.message_from_string(metadata)
        self.assertEqual(metadata['Requires-Python'].replace(' ', ''), '>=3.9')
        required = [re.match('[A-Za-z0-9-]+', line)[0] for line in metadata.get_all('Requires-Dist')]
        self.assertEqual(sorted(required), ['numpy', 'protobuf', 'pyzmq'])
        self.assertIn('Typing :: Typed', metadata.get_all('Classifier'))

    def test_has_the_name_and_the_version_that_the_tree_and_its_readme_say(self):
        with open(os.path.join(ROOT, 'CMakeLists.txt')) as text:
            version = re.search(r'project\(styled VERSION (\S+)', text.read())[1]
        with zipfile.ZipFile(self.wheel) as wheel:
            metadata = email.message_from_bytes(
                wheel.read(next(n for n in wheel.namelist() if n.endswith('/METADATA'))))
        self.assertEqual((metadata['Name'], metadata['Version']), ('styled-mocap', version))
        with open(os.path.join(ROOT, 'clients/python/README.md')) as text:
            self.assertEqual(re.findall(r'pip install (?:\S+/)?(\S+\.whl)', text.read()),
                             [os.path.basename(self.wheel), f'styled_mocap-{version}-py3-none-linux_x86_64.whl'])
        found = run(self.python, '-c', 'import importlib.metadata as m; print(m.version("styled-mocap"))',
                    cwd=self.folder, env=self.clean)
        self.assertEqual(found.strip(), version)

    def test_reads_frames_in_a_fresh_folder(self):
        with open(os.path.join(ROOT, 'tests/conformance/canonical.json')) as text:
            golden = json.load(text)
        body, frame = bytes.fromhex(golden['body']), golden['frames'][0]
        fields, performer = golden['body_fields'], golden['body_fields']['performer']
        with zmq.Context() as context, context.socket(zmq.XPUB) as publisher:
            publisher.linger = 0
            port = publisher.bind_to_random_port('tcp://127.0.0.1')
            reader = subprocess.Popen([self.python, '-c', READER, f'tcp://127.0.0.1:{port}'],
                                      cwd=self.folder, env=self.clean, stdout=subprocess.PIPE, text=True)
            self.addCleanup(reader.kill)
            end = time.monotonic() + PATIENCE_S
            while reader.poll() is None and time.monotonic() < end:
                publisher.send_multipart([f'body/{performer}/'.encode(), body])
                publisher.send_multipart([f'styled/{performer}/canonical/'.encode(),
                                          bytes.fromhex(frame['frame'])])
                time.sleep(0.05)
        where, head = reader.communicate()[0].splitlines()
        self.assertTrue(where.startswith(self.folder + '/venv/'), where)
        expected = frame['positions'][fields['names'].index('head')]
        for got, wanted in zip(map(float, head.split()), expected):
            self.assertAlmostEqual(got, wanted, 5)

    def test_is_a_program(self):
        out = run(self.python, '-m', 'styled', '--help', cwd=self.folder, env=self.clean)
        self.assertIn('tail', out)


if __name__ == '__main__':
    try:
        import ensurepip  # noqa: F401
        import setuptools  # noqa: F401
        import venv  # noqa: F401
        import wheel  # noqa: F401
    except ImportError as error:
        print(f'skipped, {error}: a wheel is made with python3-setuptools, python3-wheel and python3-venv')
        sys.exit(SKIPPED)
    unittest.main()
