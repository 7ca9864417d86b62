using System;
using System.Collections.Generic;
using System.Diagnostics;
using UnityEngine;
using Debug = UnityEngine.Debug;

namespace Styled.Samples {

/// <summary>Moves a humanoid avatar by a performer's canonical stream. Add it to the object with an
/// Animator whose avatar is Humanoid; the model must be in the T-pose at the start. Joints are matched by
/// name: fingers, eyes and jaw move if both have them.</summary>
[RequireComponent(typeof(Animator))]
public sealed class LivePerformer : MonoBehaviour {
  public string endpoint = Subscriber.DefaultEndpoint;
  public string performer = "rig.anna";
  public float warnAfterSeconds = 5;  // without a frame, once

  sealed class Bone {
    public Transform transform;
    public Quaternion rest;  // avatar from bone, in the T-pose
  }

  readonly Dictionary<string, Bone> bones_ = new Dictionary<string, Bone>();
  readonly List<Update> updates_ = new List<Update>();
  Subscriber subscriber_;
  Stopwatch silence_;  // until the first frame or the warning
  WorldPose world_;
  Body body_;           // whose joints boneOfJoint_ has; null before the first frame
  Bone[] boneOfJoint_;  // null if the avatar has no such bone
  float hipsHeight_;

  public void OnEnable() {
    try {
      subscriber_ = new Subscriber(endpoint, performer);
    } catch (Exception error) when (error is ArgumentException || error is DllNotFoundException) {
      Debug.LogError("LivePerformer: " + error.Message, this);  // a wrong field, or no libzmq in Assets/Plugins
      enabled = false;
    }
    silence_ = Stopwatch.StartNew();
  }

  public void OnDisable() {
    if (subscriber_ != null) subscriber_.Dispose();
    subscriber_ = null;
  }

  // After the Animator, which may play a clip on bones that no joint moves.
  public void LateUpdate() {
    if (subscriber_ == null) return;
    subscriber_.Latest(updates_);
    if (updates_.Count > 0) {
      silence_ = null;
    } else if (silence_ != null && silence_.Elapsed.TotalSeconds >= warnAfterSeconds) {
      Debug.LogWarning("LivePerformer: no frame of '" + performer + "' from " + endpoint + " yet: does a daemon " +
                       "publish there, and is a performer of this name present?", this);
      silence_ = null;
    }
    foreach (Update update in updates_) Apply(update);
  }

  /// <summary>Poses the avatar by a frame whose body has arrived.</summary>
  public void Apply(Update update) {
    Body body = update.Body;
    if (bones_.Count == 0) RememberTPose();
    if (body != body_) FindBones(body);
    world_ = Kinematics.World(body, update.Frame, world_);
    float[] q = world_.Rotations, p = world_.Positions;
    for (int joint = 0; joint < body.Names.Length; ++joint) {  // parents come before their children
      Bone bone = boneOfJoint_[joint];
      if (bone == null) continue;
      int i = 4 * joint;
      // The canonical axes are right-handed, +X left; Unity's are the mirror image.
      var turn = new Quaternion(q[i], -q[i + 1], -q[i + 2], q[i + 3]);
      bone.transform.rotation = transform.rotation * turn * bone.rest;
      // At the height of its own hips, and at the performer's place on the floor.
      if (joint == 0) {
        float scale = body.Offsets[1] > 0.1f ? hipsHeight_ / body.Offsets[1] : 1;
        bone.transform.position = transform.TransformPoint(new Vector3(-p[0], p[1] * scale, p[2]));
      }
    }
  }

  void FindBones(Body body) {
    body_ = body;
    boneOfJoint_ = new Bone[body.Names.Length];
    for (int joint = 0; joint < boneOfJoint_.Length; ++joint) {
      bones_.TryGetValue(UnityName(body.Names[joint]), out boneOfJoint_[joint]);
    }
  }

  void RememberTPose() {
    var animator = GetComponent<Animator>();
    foreach (HumanBodyBones which in Enum.GetValues(typeof(HumanBodyBones))) {
      if (which == HumanBodyBones.LastBone) continue;
      Transform found = animator.GetBoneTransform(which);
      if (found == null) continue;
      bones_[which.ToString()] =
          new Bone { transform = found, rest = Quaternion.Inverse(transform.rotation) * found.rotation };
      if (which == HumanBodyBones.Hips) hipsHeight_ = transform.InverseTransformPoint(found.position).y;
    }
  }

  // The bone of a joint, which is named like VRM 1.0's bones; only thumbs are counted differently.
  static string UnityName(string joint) {
    string name = char.ToUpperInvariant(joint[0]) + joint.Substring(1);
    if (name.EndsWith("ThumbProximal")) return name.Replace("Proximal", "Intermediate");
    return name.Replace("ThumbMetacarpal", "ThumbProximal");
  }
}

}  // namespace Styled.Samples
