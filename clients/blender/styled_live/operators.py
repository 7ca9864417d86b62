"""The operators behind the panel's buttons."""

import traceback

import bpy
import styled
from bpy.props import StringProperty
from styled.inbox import Inbox

from .bake import bake, undone_on_failure
from .build import make_armature
from .drive import Plan, Unfit
from .live import live
from .restyle import Failed, restyle


class _Connected:
    @classmethod
    def poll(cls, _context):
        return live.active


def _fail(operator, why) -> set:
    operator.report({'ERROR'}, str(why))
    return {'CANCELLED'}


# An unexpected error: the traceback goes to the console, so that it can be reported.
def _surprised(operator, error: Exception) -> set:
    traceback.print_exc()
    return _fail(operator, f'{type(error).__name__}: {error}')


def _done(operator, done: bool) -> set:
    if not done:
        return _fail(operator, live.problem)
    if live.unseen:
        operator.report({'WARNING'}, live.unseen)
    return {'FINISHED'}


# Why an armature would get no frame; '' if it would.
def _wrong_choice(performer: str, stream: str) -> str:
    if not styled.is_performer_id(performer):
        return (f"performer '{performer}', expected SOURCE.NAME; present:  "
                f"{', '.join(live.performers()) or 'none yet'}")
    if performer in live.performers() and stream not in live.streams(performer):
        return f"no output '{stream}' of {performer}; there are {', '.join(live.streams(performer))}"
    try:
        Inbox(performer, stream)
    except ValueError as error:
        return str(error)
    return ''


class STYLED_OT_connect(bpy.types.Operator):
    """Connect to the daemon at these addresses"""
    bl_idname = 'styled.connect'
    bl_label = 'Connect'

    def execute(self, context):
        at = context.scene.styled_live
        try:
            live.connect(at.publisher, at.control)
        except ValueError as error:
            return _fail(self, error)
        if live.problem:  # the daemon may start later
            self.report({'WARNING'}, live.problem)
        return {'FINISHED'}


class STYLED_OT_disconnect(_Connected, bpy.types.Operator):
    """End the connection; armatures keep their present pose"""
    bl_idname = 'styled.disconnect'
    bl_label = 'Disconnect'

    def execute(self, _context):
        live.disconnect()
        return {'FINISHED'}


class STYLED_OT_make_armature(_Connected, bpy.types.Operator):
    """Make an armature of the performer's body, and drive it"""
    bl_idname = 'styled.make_armature'
    bl_label = 'Make Armature'
    bl_options = {'REGISTER', 'UNDO'}

    def execute(self, context):
        chosen = context.scene.styled_live
        body = live.body(chosen.performer, chosen.stream)
        if body is None:
            return _fail(self, f"no body of '{chosen.performer}', output '{chosen.stream}', is present; "
                               f"performers: {', '.join(live.performers()) or 'none yet'}")
        if context.mode != 'OBJECT':
            bpy.ops.object.mode_set(mode='OBJECT')
        made = make_armature(body, f'{chosen.performer} {chosen.stream}', context.collection)
        _drive(made, chosen)
        return {'FINISHED'}


def _drive(armature_object, chosen) -> None:
    driven = armature_object.styled_live
    driven.performer, driven.stream, driven.driven = chosen.performer, chosen.stream, True


class STYLED_OT_drive(_Connected, bpy.types.Operator):
    """Drive the active armature: bones named like the body's joints, or like a humanoid's"""
    bl_idname = 'styled.drive'
    bl_label = 'Drive Armature'
    bl_options = {'REGISTER', 'UNDO'}

    @classmethod
    def poll(cls, context):
        return live.active and context.object is not None and context.object.type == 'ARMATURE'

    def execute(self, context):
        chosen = context.scene.styled_live
        wrong = _wrong_choice(chosen.performer, chosen.stream)
        if wrong:
            return _fail(self, wrong)
        body = live.body(chosen.performer, chosen.stream)
        if body is not None:  # otherwise the mapping is checked when the body arrives
            try:
                plan = Plan(body, context.object.data)
            except Unfit as error:
                return _fail(self, f'{context.object.name}: {error}')
            self.report({'INFO'}, f'{len(plan.joints)} bones of {context.object.name} follow')
        else:
            self.report({'WARNING'}, f'no performer of the name {chosen.performer} is present yet: '
                                     f'{context.object.name} waits for it')
        _drive(context.object, chosen)
        return {'FINISHED'}


class STYLED_OT_release(bpy.types.Operator):
    """Release the active armature; it keeps its present pose"""
    bl_idname = 'styled.release'
    bl_label = 'Release'
    bl_options = {'REGISTER', 'UNDO'}

    @classmethod
    def poll(cls, context):
        return context.object is not None and context.object.styled_live.driven

    def execute(self, context):
        context.object.styled_live.driven = False
        return {'FINISHED'}


class STYLED_OT_record(bpy.types.Operator):
    """Record every frame of the active armature's performer from now on, until Bake"""
    bl_idname = 'styled.record'
    bl_label = 'Record'

    @classmethod
    def poll(cls, context):
        link = live.link(context.object) if context.object is not None else None
        return link is not None and link.plan is not None and link.take is None

    def execute(self, context):
        live.link(context.object).take = []
        return {'FINISHED'}


class STYLED_OT_bake(bpy.types.Operator):
    """End the take, make it an action of the active armature from the current frame on, and release
    the armature"""
    bl_idname = 'styled.bake'
    bl_label = 'Stop and Bake'
    bl_options = {'REGISTER', 'UNDO'}

    @classmethod
    def poll(cls, context):
        link = live.link(context.object) if context.object is not None else None
        return link is not None and link.take is not None

    def execute(self, context):
        thing, scene = context.object, context.scene
        link = live.link(thing)
        frames, link.take = link.take, None
        if link.plan is None:
            return _fail(self, f'{thing.name}: {link.unfit or "it no longer follows the performer"}')
        frames = [frame for frame in frames if frame.body_hash == link.plan.body.hash]
        if not frames:
            return _fail(self, f'no frame of {thing.styled_live.performer} arrived during the recording')
        fps = scene.render.fps / scene.render.fps_base
        try:
            with undone_on_failure(thing):
                thing.animation_data_create().action = None  # a take is an action of its own
                last = bake(link.plan, frames, thing, fps, scene.frame_current)
        except KeyError as error:  # a bone was renamed
            return _fail(self, error)
        except Exception as error:  # the object is of another file, the action is locked ...
            return _surprised(self, error)
        thing.styled_live.driven = False
        scene.frame_end = max(scene.frame_end, last)
        self.report({'INFO'}, f'{thing.animation_data.action.name}: frames {scene.frame_current} to {last}')
        return {'FINISHED'}


class STYLED_OT_restyle(bpy.types.Operator):
    """Make a copy of the active armature's action in the style"""
    bl_idname = 'styled.restyle'
    bl_label = 'Restyle Action'
    bl_options = {'REGISTER', 'UNDO'}

    @classmethod
    def poll(cls, context):
        thing = context.object
        return (thing is not None and thing.type == 'ARMATURE' and thing.mode != 'EDIT' and
                not thing.styled_live.driven and thing.animation_data is not None and
                thing.animation_data.action is not None)

    def execute(self, context):
        chosen = context.scene.styled_live
        try:
            restyle(context.scene, context.object, chosen.action_style,
                    chosen.action_strength, bpy.path.abspath(chosen.stylize))
        except (Failed, Unfit, ValueError) as error:
            return _fail(self, f'{context.object.name}: {error}')
        except Exception as error:
            return _surprised(self, error)
        return {'FINISHED'}


class STYLED_OT_style(_Connected, bpy.types.Operator):
    """Set this style"""
    bl_idname = 'styled.style'
    bl_label = 'Style'

    style: StringProperty(name='Style')

    def execute(self, context):
        chosen = context.scene.styled_live
        return _done(self, live.set_style(chosen.performer or styled.EVERYONE, self.style,
                                          chosen.strength))


class STYLED_OT_clear(_Connected, bpy.types.Operator):
    """Fade to the performer as captured"""
    bl_idname = 'styled.clear'
    bl_label = 'As Captured'

    def execute(self, context):
        return _done(self, live.clear(context.scene.styled_live.performer or styled.EVERYONE))


class STYLED_OT_panic(_Connected, bpy.types.Operator):
    """Set all performers to bypass, pinned or not"""
    bl_idname = 'styled.panic'
    bl_label = 'Panic'

    def execute(self, _context):
        return _done(self, live.panic())


_CLASSES = (STYLED_OT_connect, STYLED_OT_disconnect, STYLED_OT_make_armature, STYLED_OT_drive,
            STYLED_OT_release, STYLED_OT_record, STYLED_OT_bake,
            STYLED_OT_restyle, STYLED_OT_style, STYLED_OT_clear, STYLED_OT_panic)


def register():
    for operator in _CLASSES:
        bpy.utils.register_class(operator)


def unregister():
    for operator in reversed(_CLASSES):
        bpy.utils.unregister_class(operator)
