// Checks of bodies and frames, and forward kinematics: the rules of clients/cpp/transforms.cpp.
using System;

namespace Styled {

/// <summary>World transforms of J joints (world from joint), in the body's units and axes.</summary>
public sealed class WorldPose {
  public float[] Positions;  // 3*J: x, y, z
  public float[] Rotations;  // 4*J: x, y, z, w; unit length
}

public static class Kinematics {
  const int MaxJoints = 1024;  // a larger body is considered a damaged message

  /// <summary>The error of a body; "" if it is valid.</summary>
  public static string Check(Body body) {
    int joints = body.Names.Length;
    if (joints < 1 || joints > MaxJoints) return joints + " joints, expected 1 to " + MaxJoints;
    if (body.Parents.Length != joints || body.Offsets.Length != 3 * joints ||
        (body.Rest.Length != 0 && body.Rest.Length != 4 * joints)) {
      return "parents, offsets or rest are not those of " + joints + " joints";
    }
    for (int joint = 0; joint < joints; ++joint) {
      int parent = body.Parents[joint];
      if (joint == 0 ? parent != -1 : parent < 0 || parent >= joint) {
        return "parent " + parent + " of joint " + joint + " does not precede it";
      }
    }
    return AllFinite(body.Offsets) ? "" : "an offset is not finite";
  }

  /// <summary>The error of a frame on a body that passed Check; "" if it is valid.</summary>
  public static string Check(Frame frame, Body body) {
    if (frame.BodyHash != body.Hash || frame.Output != body.Output) return "the frame is of another body";
    if (frame.RootPosition.Length != 3 || frame.Rotations.Length != 4 * body.Names.Length) {
      return "root position or rotations are not those of " + body.Names.Length + " joints";
    }
    if (!AllFinite(frame.RootPosition)) return "the root position is not finite";
    for (int i = 0; i < frame.Rotations.Length; i += 4) {
      if (!IsRotation(frame.Rotations, i)) return "the rotation of joint " + i / 4 + " is zero or not finite";
    }
    foreach (Prop prop in frame.Props) {
      if (prop.Position.Length != 3 || prop.Rotation.Length != 4 || !AllFinite(prop.Position) ||
          !IsRotation(prop.Rotation, 0)) {
        return "position or rotation of prop \"" + prop.Name + "\" is not 3 and 4 finite numbers";
      }
    }
    return "";
  }

  static bool IsRotation(float[] q, int at) {
    double square = 0;
    for (int k = at; k < at + 4; ++k) square += (double)q[k] * q[k];
    return square >= 1e-12 && square < double.PositiveInfinity;
  }

  /// <summary>Forward kinematics of a frame that passed Check with this body. `into` is reused if its
  /// arrays fit.</summary>
  public static WorldPose World(Body body, Frame frame, WorldPose into = null) {
    int joints = body.Names.Length;
    if (into == null || into.Positions == null || into.Positions.Length != 3 * joints) {
      into = new WorldPose { Positions = new float[3 * joints], Rotations = new float[4 * joints] };
    }
    float[] p = into.Positions, r = into.Rotations, q = frame.Rotations, o = body.Offsets;
    for (int joint = 0; joint < joints; ++joint) {
      int i = 4 * joint;
      double size = Math.Sqrt((double)q[i] * q[i] + (double)q[i + 1] * q[i + 1] +
                              (double)q[i + 2] * q[i + 2] + (double)q[i + 3] * q[i + 3]);
      double x = q[i] / size, y = q[i + 1] / size, z = q[i + 2] / size, w = q[i + 3] / size;
      if (joint == 0) {
        Array.Copy(frame.RootPosition, p, 3);
        Set(r, 0, x, y, z, w);
        continue;
      }
      int a = 4 * body.Parents[joint], from = 3 * body.Parents[joint], to = 3 * joint;
      double px = r[a], py = r[a + 1], pz = r[a + 2], pw = r[a + 3];
      double ox = o[to], oy = o[to + 1], oz = o[to + 2];
      // v + 2 w (u x v) + 2 u x (u x v), u and w of the parent's rotation
      double tx = 2 * (py * oz - pz * oy), ty = 2 * (pz * ox - px * oz), tz = 2 * (px * oy - py * ox);
      p[to] = (float)(p[from] + ox + pw * tx + py * tz - pz * ty);
      p[to + 1] = (float)(p[from + 1] + oy + pw * ty + pz * tx - px * tz);
      p[to + 2] = (float)(p[from + 2] + oz + pw * tz + px * ty - py * tx);
      Set(r, i, pw * x + px * w + py * z - pz * y, pw * y - px * z + py * w + pz * x,
          pw * z + px * y - py * x + pz * w, pw * w - px * x - py * y - pz * z);
    }
    return into;
  }

  static void Set(float[] r, int i, double x, double y, double z, double w) {
    r[i] = (float)x;
    r[i + 1] = (float)y;
    r[i + 2] = (float)z;
    r[i + 3] = (float)w;
  }

  static bool AllFinite(float[] values) {
    foreach (float value in values) {
      if (float.IsNaN(value) || float.IsInfinity(value)) return false;
    }
    return true;
  }
}

}  // namespace Styled
