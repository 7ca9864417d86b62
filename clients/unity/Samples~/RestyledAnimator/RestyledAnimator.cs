using System;
using System.Collections.Generic;
using UnityEngine;

namespace Styled.Samples {

/// <summary>Restyles in this process what an Animator plays, without a daemon. Add it to the object with the
/// Animator, whose avatar is Humanoid; the model must be in the T-pose at the start.</summary>
[RequireComponent(typeof(Animator))]
public sealed class RestyledAnimator : MonoBehaviour {
  public string weights = "open";
  public string style = "zombie";
  public float strength = 1;

  // The joints that a style changes; the parent of each is the nearest of these above it.
  static readonly HumanBodyBones[] Bones = {
    HumanBodyBones.Hips, HumanBodyBones.Spine, HumanBodyBones.Chest, HumanBodyBones.Neck, HumanBodyBones.Head,
    HumanBodyBones.LeftShoulder, HumanBodyBones.LeftUpperArm, HumanBodyBones.LeftLowerArm, HumanBodyBones.LeftHand,
    HumanBodyBones.RightShoulder, HumanBodyBones.RightUpperArm, HumanBodyBones.RightLowerArm, HumanBodyBones.RightHand,
    HumanBodyBones.LeftUpperLeg, HumanBodyBones.LeftLowerLeg, HumanBodyBones.LeftFoot, HumanBodyBones.LeftToes,
    HumanBodyBones.RightUpperLeg, HumanBodyBones.RightLowerLeg, HumanBodyBones.RightFoot, HumanBodyBones.RightToes
  };

  readonly List<Transform> bones_ = new List<Transform>();
  readonly List<Quaternion> rests_ = new List<Quaternion>();  // in the T-pose, relative to the avatar
  readonly float[] root_ = new float[3];
  int[] parents_;
  float[] rotations_;
  Quaternion[] turns_;
  Network network_;
  Performer performer_;
  string set_;
  float setStrength_;

  public void OnEnable() {
    try {
      network_ = new Network(weights);
      performer_ = Make(network_);
    } catch (Exception error) when (error is ArgumentException || error is DllNotFoundException) {
      Debug.LogError("RestyledAnimator: " + error.Message, this);
      enabled = false;
    }
    set_ = null;
  }

  public void OnDisable() {
    if (performer_ != null) performer_.Dispose();
    if (network_ != null) network_.Dispose();
    performer_ = null;
    network_ = null;
  }

  // After the Animator, which writes all bones again in the next frame.
  public void LateUpdate() {
    if (performer_ == null || !Chosen()) return;
    Read();
    if (!performer_.Frame((long)(Time.timeAsDouble * 1e9), root_, rotations_)) return;  // the game is paused
    for (int i = 0; i < bones_.Count; ++i) {  // parents come before their children
      Quaternion turn = Mirrored(rotations_[4 * i], rotations_[4 * i + 1], rotations_[4 * i + 2], rotations_[4 * i + 3]);
      turns_[i] = parents_[i] < 0 ? turn : turns_[parents_[i]] * turn;
      bones_[i].rotation = turns_[i] * rests_[i];
    }
    bones_[0].position = new Vector3(-root_[0], root_[1], root_[2]);
  }

  // Whether the fields name a style.
  bool Chosen() {
    if (style == set_ && strength == setStrength_) return true;
    try {
      performer_.Set(style, strength);
    } catch (ArgumentException error) {
      if (set_ != style || setStrength_ != strength) Debug.LogError("RestyledAnimator: " + error.Message, this);
      enabled = false;
      return false;
    }
    set_ = style;
    setStrength_ = strength;
    return true;
  }

  // The pose that the Animator made, in the world's axes with x mirrored: the library's are right-handed.
  void Read() {
    for (int i = 0; i < bones_.Count; ++i) {
      turns_[i] = bones_[i].rotation * Quaternion.Inverse(rests_[i]);
      Quaternion turn = parents_[i] < 0 ? turns_[i] : Quaternion.Inverse(turns_[parents_[i]]) * turns_[i];
      rotations_[4 * i] = turn.x;
      rotations_[4 * i + 1] = -turn.y;
      rotations_[4 * i + 2] = -turn.z;
      rotations_[4 * i + 3] = turn.w;
    }
    Vector3 hips = bones_[0].position;
    root_[0] = -hips.x;
    root_[1] = hips.y;
    root_[2] = hips.z;
  }

  Performer Make(Network network) {
    var animator = GetComponent<Animator>();
    var names = new List<string>();
    var parents = new List<int>();
    var offsets = new List<float>();
    bones_.Clear();
    rests_.Clear();
    Quaternion upright = Quaternion.Inverse(transform.rotation);
    foreach (HumanBodyBones which in Bones) {
      Transform bone = animator.GetBoneTransform(which);
      if (bone == null) continue;
      int parent = -1;
      for (Transform above = bone.parent; above != null && parent < 0; above = above.parent) parent = bones_.IndexOf(above);
      Vector3 offset = upright * (bone.position - (parent < 0 ? transform.position : bones_[parent].position));
      offsets.AddRange(new[] { -offset.x, offset.y, offset.z });
      names.Add(char.ToLowerInvariant(which.ToString()[0]) + which.ToString().Substring(1));
      parents.Add(parent);
      bones_.Add(bone);
      rests_.Add(upright * bone.rotation);
    }
    parents_ = parents.ToArray();
    rotations_ = new float[4 * names.Count];
    turns_ = new Quaternion[names.Count];
    return new Performer(network, names.ToArray(), parents_, offsets.ToArray());
  }

  static Quaternion Mirrored(float x, float y, float z, float w) { return new Quaternion(x, -y, -z, w); }
}

}  // namespace Styled.Samples
