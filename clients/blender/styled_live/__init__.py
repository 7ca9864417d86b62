"""Drives armatures in Blender with the motion that a styled daemon publishes."""

import os
import sys

import bpy

bl_info = {
    'name': 'Styled',
    'author': 'Styled',
    'version': (0, 2, 0),
    'blender': (3, 4, 0),
    'location': '3D View > Sidebar > Styled',
    'description': 'Live motion, restyled, on armatures',
    'category': 'Animation',
}

try:
    import styled  # prefer an installed Python client
except ImportError:
    _modules = os.path.join(os.path.dirname(__file__), 'modules')
    if _modules not in sys.path:
        sys.path.append(_modules)
    try:
        import styled
    except ImportError as error:  # if protobuf is missing, the client itself names the Debian packages
        raise ImportError(f'Blender\'s Python needs pyzmq and protobuf: on Debian apt install '
                          f'python3-zmq python3-protobuf, otherwise "{sys.executable}" -m pip install pyzmq '
                          f'protobuf ({error})') from error

from . import live, operators, panel, properties

_PARTS = (properties, operators, panel)


# Sockets must not outlive the file whose armatures they drive.
@bpy.app.handlers.persistent
def _before_another_file(_):
    live.live.disconnect()


def register():
    for part in _PARTS:
        part.register()
    bpy.app.handlers.load_pre.append(_before_another_file)


def unregister():
    bpy.app.handlers.load_pre.remove(_before_another_file)
    live.live.disconnect()
    for part in reversed(_PARTS):
        part.unregister()
