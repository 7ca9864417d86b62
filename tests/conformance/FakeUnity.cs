// As much of UnityEngine as the samples use, with the same mathematics (left-handed axes):
// Unity itself is not here.
using System;
using System.Collections.Generic;

namespace UnityEngine {

public struct Vector3 {
  public float x, y, z;
  public Vector3(float x, float y, float z) { this.x = x; this.y = y; this.z = z; }
  public static Vector3 operator +(Vector3 a, Vector3 b) { return new Vector3(a.x + b.x, a.y + b.y, a.z + b.z); }
  public static Vector3 operator -(Vector3 a, Vector3 b) { return new Vector3(a.x - b.x, a.y - b.y, a.z - b.z); }
}

public struct Quaternion {
  public float x, y, z, w;
  public Quaternion(float x, float y, float z, float w) { this.x = x; this.y = y; this.z = z; this.w = w; }
  public static Quaternion identity { get { return new Quaternion(0, 0, 0, 1); } }
  public static Quaternion Inverse(Quaternion q) { return new Quaternion(-q.x, -q.y, -q.z, q.w); }
  public static Quaternion operator *(Quaternion a, Quaternion b) {
    return new Quaternion(a.w * b.x + a.x * b.w + a.y * b.z - a.z * b.y, a.w * b.y - a.x * b.z + a.y * b.w + a.z * b.x,
                          a.w * b.z + a.x * b.y - a.y * b.x + a.z * b.w, a.w * b.w - a.x * b.x - a.y * b.y - a.z * b.z);
  }
  public static Vector3 operator *(Quaternion q, Vector3 v) {
    Quaternion r = q * new Quaternion(v.x, v.y, v.z, 0) * Inverse(q);
    return new Vector3(r.x, r.y, r.z);
  }
}

// Nothing uses it: it is here for the test of names that both have.
public struct Pose {}

public sealed class Transform {
  public Transform parent;
  public Vector3 localPosition;
  public Quaternion localRotation = Quaternion.identity;
  public Quaternion rotation {
    get { return parent == null ? localRotation : parent.rotation * localRotation; }
    set { localRotation = parent == null ? value : Quaternion.Inverse(parent.rotation) * value; }
  }
  public Vector3 position {
    get { return parent == null ? localPosition : parent.TransformPoint(localPosition); }
    set { localPosition = parent == null ? value : parent.InverseTransformPoint(value); }
  }
  public Vector3 TransformPoint(Vector3 point) { return position + rotation * point; }
  public Vector3 InverseTransformPoint(Vector3 point) { return Quaternion.Inverse(rotation) * (point - position); }
}

public enum HumanBodyBones {
  Hips, LeftUpperLeg, RightUpperLeg, LeftLowerLeg, RightLowerLeg, LeftFoot, RightFoot, Spine, Chest, Neck, Head,
  LeftShoulder, RightShoulder, LeftUpperArm, RightUpperArm, LeftLowerArm, RightLowerArm, LeftHand, RightHand,
  LeftToes, RightToes, LeftEye, RightEye, Jaw, LeftThumbProximal, LeftThumbIntermediate, LeftThumbDistal,
  LeftIndexProximal, UpperChest, LastBone
}

public class Component {
  public Transform transform = new Transform();
  public static readonly Dictionary<Type, object> Others = new Dictionary<Type, object>();
  public T GetComponent<T>() { return (T)Others[typeof(T)]; }
}

public static class Time {
  public static double timeAsDouble;
}

public class MonoBehaviour : Component {
  public bool enabled = true;
}

public static class Debug {
  public static readonly List<string> Said = new List<string>();
  public static void LogError(object message, Component context) { Said.Add("error: " + message); }
  public static void LogWarning(object message, Component context) { Said.Add("warning: " + message); }
}

public sealed class Animator : Component {
  public readonly Dictionary<HumanBodyBones, Transform> Bones = new Dictionary<HumanBodyBones, Transform>();
  public Transform GetBoneTransform(HumanBodyBones bone) { return Bones.ContainsKey(bone) ? Bones[bone] : null; }
}

[AttributeUsage(AttributeTargets.Class)]
public sealed class RequireComponent : Attribute {
  public RequireComponent(Type type) {}
}

}  // namespace UnityEngine
