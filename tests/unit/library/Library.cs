// libstyled from C#: prints what example.c prints, then moves an avatar of Unity's stand-in.
using System;
using System.Collections.Generic;
using System.Globalization;
using Styled;
using Styled.Samples;
using UnityEngine;

static class LibraryTest {
  static readonly string[] Names = {
    "hips", "spine", "head", "leftUpperArm", "leftLowerArm", "leftHand", "rightUpperArm", "rightLowerArm", "rightHand",
    "leftUpperLeg", "leftLowerLeg", "leftFoot", "rightUpperLeg", "rightLowerLeg", "rightFoot"
  };
  static readonly int[] Parents = { -1, 0, 1, 1, 3, 4, 1, 6, 7, 0, 9, 10, 0, 12, 13 };
  static readonly float[] Offsets = {
    0, 0.95f, 0, 0, 0.15f, 0, 0, 0.5f, 0, 0.18f, 0.4f, 0, 0.28f, 0, 0, 0.25f, 0, 0, -0.18f, 0.4f, 0, -0.28f, 0, 0,
    -0.25f, 0, 0, 0.1f, -0.05f, 0, 0, -0.42f, 0, 0, -0.4f, 0, -0.1f, -0.05f, 0, 0, -0.42f, 0, 0, -0.4f, 0
  };

  static void Check(bool holds, string what) {
    if (!holds) throw new Exception(what);
  }

  static float Degrees(float w) { return 114.59f * (float)Math.Acos(Math.Min(1, Math.Abs(w))); }

  static float[] AsInC(string style) {
    float[] root = new float[3], rotations = new float[60];
    using (var network = new Network())
    using (var performer = new Performer(network, Names, Parents, Offsets)) {
      performer.Set(style);
      for (int frame = 0; frame < 240; ++frame) {
        for (int i = 0; i < 60; ++i) rotations[i] = i % 4 == 3 ? 1 : 0;
        root = new[] { 0, 0.95f, 0 };
        Check(performer.Frame(frame * 8333333L, root, rotations), "frame");
      }
      Check(!performer.Frame(0, root, rotations), "a frame of an earlier time");
    }
    for (int j = 0; j < 15; ++j) {
      Console.WriteLine("{0,-14} turned by {1,5} degrees", Names[j],
                        Degrees(rotations[4 * j + 3]).ToString("F1", CultureInfo.InvariantCulture));
    }
    return rotations;
  }

  // The avatar stands in the T-pose, its bones turned against the model and the model turned in the world.
  static void Moves(string style, float[] expected) {
    var animator = new Animator();
    Component.Others[typeof(Animator)] = animator;
    var avatar = new RestyledAnimator { style = style, weights = null };
    avatar.transform.rotation = new Quaternion(0, 0.6f, 0, 0.8f);
    avatar.transform.position = new Vector3(3, 0, -2);
    var bones = new List<Transform>();
    for (int j = 0; j < 15; ++j) {
      var bone = new Transform { parent = j == 0 ? avatar.transform : bones[Parents[j]] };
      Vector3 above = j == 0 ? avatar.transform.position : bone.parent.position;
      bone.position = above + avatar.transform.rotation * new Vector3(-Offsets[3 * j], Offsets[3 * j + 1], Offsets[3 * j + 2]);
      bone.rotation = avatar.transform.rotation * (j % 2 == 0 ? new Quaternion(0.6f, 0, 0, 0.8f) : new Quaternion(0, 0, 1, 0));
      bones.Add(bone);
      var which = (HumanBodyBones)Enum.Parse(typeof(HumanBodyBones), Names[j], true);
      animator.Bones[which] = bone;
    }
    var places = bones.ConvertAll(bone => bone.localPosition);
    var rests = bones.ConvertAll(bone => bone.localRotation);
    avatar.OnEnable();
    for (int frame = 0; frame < 240; ++frame) {
      for (int j = 0; j < 15; ++j) {  // as the Animator writes all bones
        bones[j].localPosition = places[j];
        bones[j].localRotation = rests[j];
      }
      Time.timeAsDouble = frame * 0.008333333;
      avatar.LateUpdate();
    }
    Check(Debug.Said.Count == 0, string.Join("; ", Debug.Said));
    for (int j = 0; j < 15; ++j) {
      float turned = Degrees((Quaternion.Inverse(rests[j]) * bones[j].localRotation).w);
      float wanted = Degrees(expected[4 * j + 3]);
      Check(Math.Abs(turned - wanted) < 1.5, Names[j] + ": turned by " + turned + ", expected " + wanted);
    }
    Check(bones[0].position.y > 0.8f && bones[0].position.y < 1 && Math.Abs(bones[0].position.x - 3) < 0.3,
          "the hips' place");
    avatar.style = "nosuch";
    avatar.LateUpdate();
    Check(!avatar.enabled && Debug.Said[0].Contains("unknown style 'nosuch', expected one of"), "an unknown style");
    avatar.OnDisable();
  }

  static void Refuses(Action action, string text) {
    try {
      action();
    } catch (ArgumentException error) {
      Check(error.Message.Contains(text), error.Message);
      return;
    }
    Check(false, "not refused: " + text);
  }

  static void Main(string[] arguments) {
    Moves(arguments[0], AsInC(arguments[0]));
    Refuses(() => new Network("/nowhere"), "/nowhere");
    using (var network = new Network()) {
      Refuses(() => new Performer(network, new[] { "a", "b" }, new[] { -1, 0 }, new float[6]), "joint");
      Refuses(() => new Performer(network, new[] { "a" }, new[] { -1, 0 }, new float[6]), "for each name");
      Check(network.Licence(arguments[0]) != "" && Network.Version != "", "a licence");
    }
    for (int i = 0; i < 100; ++i) {
      using (var network = i % 50 == 0 ? new Network() : null) {
        if (network != null) new Performer(network, Names, Parents, Offsets).Dispose();
      }
    }
  }
}
