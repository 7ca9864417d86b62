"""The tab "Styled" in the 3D view's sidebar."""

import bpy

from .bake import MAX_FRAMES
from .live import live


class STYLED_PT_live(bpy.types.Panel):
    bl_idname = 'STYLED_PT_live'
    bl_label = 'Styled'
    bl_category = 'Styled'
    bl_space_type = 'VIEW_3D'
    bl_region_type = 'UI'

    def draw(self, context):
        chosen = context.scene.styled_live
        column = self.layout.column()
        if bpy.ops.styled.restyle.poll():
            box = column.box()
            box.label(text=context.object.animation_data.action.name, icon='ACTION')
            box.prop(chosen, 'action_style')
            box.prop(chosen, 'action_strength', slider=True)
            box.prop(chosen, 'stylize')
            box.operator('styled.restyle')
        if not live.active:
            column.prop(chosen, 'publisher')
            column.prop(chosen, 'control')
            column.operator('styled.connect', icon='PLAY')
            return
        column.operator('styled.disconnect', icon='PAUSE')
        if live.problem or not live.reached:
            column.label(text=live.problem or f'no daemon publishes at {chosen.publisher}', icon='ERROR')
        column.prop(chosen, 'performer')
        column.prop(chosen, 'stream')
        row = column.row(align=True)
        row.operator('styled.make_armature', icon='ARMATURE_DATA')
        row.operator('styled.drive', icon='CON_ARMATURE')
        self._draw_styles(chosen)
        if context.object is not None and context.object.styled_live.driven:
            self._draw_driven(context.object)

    def _draw_styles(self, chosen):
        column = self.layout.column()
        column.label(text=f'Style of {chosen.performer or "everyone"}')
        grid = column.grid_flow(columns=2, align=True)
        for style in live.styles:
            grid.operator('styled.style', text=style).style = style
        column.prop(chosen, 'strength', slider=True)
        row = column.row(align=True)
        row.operator('styled.clear')
        row.operator('styled.panic', icon='CANCEL')

    def _draw_driven(self, armature_object):
        driven, link = armature_object.styled_live, live.link(armature_object)
        box = self.layout.box()
        box.label(text=armature_object.name, icon='OUTLINER_OB_ARMATURE')
        box.prop(driven, 'performer')
        box.prop(driven, 'stream')
        if link is not None and link.unfit:
            box.label(text=link.unfit, icon='ERROR')
        elif link is None or link.latest is None:
            box.label(text='no frame yet')
        else:
            box.label(text=f'{len(link.plan.joints)} bones, frame {link.latest.sequence}')
            box.label(text=link.latest.styles or 'as captured')
        if link is not None and link.take is not None:
            full = ' (full)' if len(link.take) >= MAX_FRAMES else ''
            box.label(text=f'recording, {len(link.take)} frames{full}', icon='REC')
            box.operator('styled.bake')
        else:
            box.operator('styled.record', icon='REC')
        box.operator('styled.release')


def register():
    bpy.utils.register_class(STYLED_PT_live)


def unregister():
    bpy.utils.unregister_class(STYLED_PT_live)
