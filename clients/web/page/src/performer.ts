// One performer on the stage: before (as captured) and after (styled), each on its patch of floor.
import { Group, Vector3 } from 'three';
import { Output, type Body, type Stream, type StyledClient, type Update } from 'styled-client';

import type { Avatar } from './avatar.js';
import { Figure, type Detail } from './figure.js';
import type { Outline } from './flat.js';
import { Floor, RADIUS_M } from './floor.js';
import { Props } from './props.js';
import { skeletonOf } from './skeleton.js';

export const BEFORE = 0x8b9cb3;
export const AFTER = 0xffb35c;
const APART_M = 1.14; // half the distance between the two floors
const CLOSE_M = 0.62; // ... for performers in the background
const ANCHOR_S = 0.12; // time constant of the floor that follows the hips
const MOVE_S = 0.25; // ... for a performer that moves to another spot

const HEAD_M = 0.14; // of a body without avatar: above the head's joint, per metre up to it

export interface Landmarks {
  head: Vector3;
  hips: Vector3;
  crown_m: number; // of the head above its joint
}

export interface View {
  overlay: boolean;
  trails: boolean;
  contacts: boolean;
  /** The styled body only, without floor. */
  alone: boolean;
  /** The objects that the rig tracks besides the body. */
  props: boolean;
}

/** A pose on its body: live, or of a take. */
export type Shown = Pick<Update, 'frame' | 'body'> & Partial<Pick<Update, 'missed' | 'newEpoch'>>;

interface Role {
  stream: 'source' | 'rig';
  floor: Floor;
  figure: Figure | undefined;
  props: Props;
  update: Shown | undefined;
}

export class PerformerOnStage {
  readonly group = new Group();
  readonly spot = new Vector3();
  readonly roles: { before: Role; after: Role };
  avatar: Avatar | undefined;
  /** Styles in force in the frame shown, by name. */
  weights = new Map<string, number>();
  missed = 0;
  private readonly anchor = new Vector3();
  // The avatar's own: the canonical body, and so its path, has another size than the rig's. Without it, an avatar would
  // leave its floor, or OBS's picture, on a long way.
  private readonly avatarAnchor = new Vector3();
  private readonly wearer = new Group();
  private anchored = false;
  private avatarAnchored = false;
  private readonly end: (() => void)[];
  private endCanonical: (() => void) | undefined;
  private apart = APART_M;
  private settled = false;

  constructor(
    readonly name: string,
    private readonly client: StyledClient,
    private detail: Detail,
  ) {
    this.roles = {
      before: { stream: 'source', floor: new Floor(BEFORE), figure: undefined, props: new Props(), update: undefined },
      after: { stream: 'rig', floor: new Floor(AFTER), figure: undefined, props: new Props(), update: undefined },
    };
    for (const role of [this.roles.before, this.roles.after]) {
      role.floor.world.add(role.props.group);
      this.group.add(role.floor.group);
    }
    this.roles.after.floor.world.add(this.wearer);
    this.end = [client.subscribeLatest(name, 'source'), client.subscribeLatest(name, 'rig')];
  }

  dispose(): void {
    for (const end of this.end) end();
    for (const { props } of [this.roles.before, this.roles.after]) props.dispose();
    this.setAvatar(undefined);
    this.group.removeFromParent();
  }

  /** Replaces the styled body's cones by an avatar, which the canonical stream drives. */
  setAvatar(avatar: Avatar | undefined): void {
    this.takeOff()?.dispose();
    this.avatar = avatar;
    if (!avatar) return;
    this.avatarAnchored = false;
    this.wearer.add(avatar.group);
    this.endCanonical = this.client.subscribeLatest(this.name, 'canonical');
  }

  /** Takes the avatar off without disposing it, so that another performer can wear it. */
  takeOff(): Avatar | undefined {
    const { avatar } = this;
    avatar?.group.removeFromParent();
    this.endCanonical?.();
    this.endCanonical = undefined;
    this.avatar = undefined;
    return avatar;
  }

  /** Sets the level of detail. */
  setDetail(detail: Detail): void {
    if (detail === this.detail) return;
    this.detail = detail;
    for (const role of [this.roles.before, this.roles.after]) {
      if (!role.update?.body) continue;
      this.rebuild(role, role.update.body);
      role.figure!.setPose(role.update.frame);
    }
  }

  /** Applies the newest poses, if there are new ones; `of`: their source, if not the client. */
  take(of: (stream: Stream) => Shown | undefined = (stream) => this.client.latest(this.name, stream)): void {
    for (const role of [this.roles.before, this.roles.after]) {
      const update = of(role.stream);
      if (!update?.body) continue;
      if (role.figure?.skeleton.body !== update.body) this.rebuild(role, update.body);
      role.figure!.setPose(update.frame);
      role.props.show(update.frame, role.figure!.skeleton);
      role.update = update;
      if (update.newEpoch) role.floor.restart();
      role.floor.step(role.figure!.left, role.figure!.right, update.frame.contacts);
      if (role === this.roles.after) {
        this.missed += update.missed ?? 0;
        this.weights = new Map(update.frame.styles.map(({ style, weight }) => [style, weight]));
      }
    }
    if (this.avatar) {
      const update = of('canonical');
      if (update?.body?.output === Output.CANONICAL) this.avatar.setPose(update.body, update.frame);
    }
  }

  /** The next pose is unrelated to the last one. */
  rewind(): void {
    this.settled = this.anchored = this.avatarAnchored = false;
    for (const { floor } of [this.roles.before, this.roles.after]) floor.restart();
    this.avatar?.rewind();
  }

  draw(view: View, selected: boolean, dt_s: number): void {
    const { before, after } = this.roles;
    const hips = before.figure?.hips ?? after.figure?.hips;
    if (hips) {
      const follow = this.anchored && hips.distanceTo(this.anchor) < 2 ? 1 - Math.exp(-dt_s / ANCHOR_S) : 1;
      this.anchor.lerp(hips, follow);
      if (this.avatar?.ready) {
        const { avatarAnchor: own, avatar: { group: { position } } } = this;
        own.lerp(position, this.avatarAnchored && position.distanceTo(own) < 2 ? follow : 1);
        this.wearer.position.set(this.anchor.x - own.x, 0, this.anchor.z - own.z);
        this.avatarAnchored = true;
      }
      this.anchored = true;
    }
    const move = this.settled ? 1 - Math.exp(-dt_s / MOVE_S) : 1;
    this.settled = true;
    this.group.position.lerp(this.spot, move);
    if (view.alone) this.apart = 0;
    else this.apart += ((view.overlay ? 0 : selected ? APART_M : CLOSE_M) - this.apart) * move;
    const reach = view.overlay ? RADIUS_M : Math.min(RADIUS_M, 0.93 * this.apart);
    before.floor.group.position.x = -this.apart;
    after.floor.group.position.x = this.apart;
    before.floor.disc.visible = this.apart > 0.05;
    before.floor.group.visible = after.floor.disc.visible = !view.alone;
    after.figure?.group && (after.figure.group.visible = !this.avatar?.ready);
    before.figure?.setLook(view.overlay
      ? { color: BEFORE, emissive: 0x0a0d12, opacity: 0.45 } : { color: BEFORE });
    for (const role of [before, after]) {
      role.floor.glow = selected ? 1 : 0;
      role.floor.reach = reach;
      role.props.group.visible = view.props && !(view.overlay && role === before);
      role.floor.show(view.trails && !view.alone, view.contacts && !view.alone && !(view.overlay && role === before));
      if (role.figure) {
        const { hips, left, right } = role.figure;
        role.floor.draw(this.anchor, hips, left, right, dt_s);
      }
    }
    this.avatar?.draw(dt_s);
  }

  /** What is visible of it as lines: an avatar's wearer is their body. */
  *outlines(): Generator<Outline> {
    if (!this.group.visible) return;
    for (const { floor, figure } of [this.roles.before, this.roles.after]) {
      if (!floor.group.visible) continue;
      if (floor.disc.visible) yield floor.outline;
      if (figure) yield figure.outline;
    }
  }

  /** Places in the scene by which a picture of the styled body is framed; undefined before it is visible. */
  landmarks(): Landmarks | undefined {
    const { avatar, roles: { after: { figure } } } = this;
    if (avatar?.ready) {
      const head = avatar.place('head'), hips = avatar.place('hips');
      return head && hips && { head, hips, crown_m: avatar.crown_m };
    }
    const head = figure?.head();
    return figure && head && { head, hips: figure.group.localToWorld(figure.hips.clone()), crown_m: HEAD_M * figure.skeleton.height_m };
  }

  private rebuild(role: Role, body: Body): void {
    const color = role === this.roles.before ? BEFORE : AFTER;
    if (role.figure?.skeleton.body !== body) role.floor.restart();
    role.figure?.dispose();
    role.figure = new Figure(skeletonOf(body), { color }, this.detail);
    role.floor.world.add(role.figure.group);
  }
}
