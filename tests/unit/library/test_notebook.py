"""The notebook of styled.restyle runs, draws a picture, and is the one that make_notebook.py writes."""
import json
import os
import subprocess
import sys
import tempfile
import unittest

ROOT = os.path.abspath(os.path.join(os.path.dirname(__file__), '../../..'))
EXAMPLES = ROOT + '/clients/python/examples'


def sources(notebook):
    with open(notebook, encoding='utf-8') as text:
        cells = json.load(text)['cells']
    return [''.join(cell['source']) for cell in cells], cells


class NotebookTest(unittest.TestCase):
    def test_it_runs_and_draws(self):
        with tempfile.TemporaryDirectory() as folder:
            subprocess.run([sys.executable, EXAMPLES + '/make_notebook.py', ROOT + '/tests/parity/fixtures/synthetic.bvh',
                            folder + '/made.ipynb'], check=True, timeout=200,
                           env=dict(os.environ, OUT=folder, IPYTHONDIR=folder, JUPYTER_CONFIG_DIR=folder,
                                    MPLCONFIGDIR=folder))
            made, cells = sources(folder + '/made.ipynb')
            self.assertTrue(os.path.getsize(folder + '/angry-rushed.bvh'))
        outputs = [output for cell in cells for output in cell.get('outputs', ())]
        self.assertTrue(any(len(output.get('data', {}).get('image/png', '')) > 5000 for output in outputs))
        self.assertIn('1002 frames at 30.0 Hz, 21 joints', ''.join(''.join(output.get('text', '')) for output in outputs))
        self.assertEqual(made, sources(EXAMPLES + '/restyle.ipynb')[0])


if __name__ == '__main__':
    try:
        import ipykernel  # noqa: F401
        import matplotlib  # noqa: F401
        import nbclient  # noqa: F401
    except ImportError as error:
        print(f'skipped, {error}: apt install python3-nbclient python3-ipykernel python3-matplotlib')
        sys.exit(77)
    unittest.main()
