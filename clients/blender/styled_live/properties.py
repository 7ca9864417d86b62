"""The settings in the panel: of the scene, the daemon's addresses; of each armature, its performer."""

import bpy
import styled
from bpy.props import BoolProperty, FloatProperty, PointerProperty, StringProperty

from .live import live


def _performers(_self, _context, _text):
    return live.performers()


def _streams(self, _context, _text):
    return live.streams(self.performer)


def _styles(_self, _context, _text):
    return live.styles


def _strength_changed(self, _context):
    if live.active:
        live.set_strength_soon(self.performer or styled.EVERYONE, self.strength)


class StyledLiveConnection(bpy.types.PropertyGroup):
    publisher: StringProperty(name='Publisher', default=styled.DEFAULT_PUBLISHER,
                              description='Address at which the daemon publishes')
    control: StringProperty(name='Control', default=styled.DEFAULT_CONTROL,
                            description="Address of the daemon's control socket")
    performer: StringProperty(name='Performer', search=_performers,
                              description='SOURCE.NAME; empty: all performers, for styles')
    stream: StringProperty(
        name='Output', default='rig', search=_streams,
        description='rig: styled, on the performer\'s own skeleton. canonical: styled, on the '
                    'humanoid of 21 joints and the rig\'s fingers. source: as captured. Or the name '
                    'of an [[output]]')
    strength: FloatProperty(name='Strength', default=1, min=0, max=1.5, soft_max=1,
                            update=_strength_changed,
                            description='0: as captured, 1: full style')

    action_style: StringProperty(name='Style', default='old', search=_styles,
                                 description='For Restyle Action: a name from `stylize --list`')
    action_strength: FloatProperty(name='Strength', default=1, min=0, max=1.5, soft_max=1,
                                   description='For Restyle Action')
    stylize: StringProperty(name='Program', subtype='FILE_PATH',
                            description='For Restyle Action: the path of stylize; empty: libstyled, or stylize '
                                        'if that is installed')


class StyledLiveDriven(bpy.types.PropertyGroup):
    driven: BoolProperty(name='Driven', default=False)
    performer: StringProperty(name='Performer', search=_performers)
    stream: StringProperty(name='Output', default='rig', search=_streams)


def register():
    bpy.utils.register_class(StyledLiveConnection)
    bpy.utils.register_class(StyledLiveDriven)
    bpy.types.Scene.styled_live = PointerProperty(type=StyledLiveConnection)
    bpy.types.Object.styled_live = PointerProperty(type=StyledLiveDriven)


def unregister():
    del bpy.types.Object.styled_live
    del bpy.types.Scene.styled_live
    bpy.utils.unregister_class(StyledLiveDriven)
    bpy.utils.unregister_class(StyledLiveConnection)
