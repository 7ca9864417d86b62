// The messages that a subscriber reads, as proto/styled/v1 documents them: shapes, units and axes are
// stated there. A reader by hand, since Unity has no protobuf.
using System;
using System.Collections.Generic;

namespace Styled {

/// <summary>The kind of a frame's body.</summary>
public enum Output { Unspecified = 0, Rig = 1, Canonical = 2, Avatar = 3 }

/// <summary>Bits of Frame.Flags.</summary>
[Flags]
public enum FrameFlags : uint {
  None = 0, Concealed = 1, Stale = 2, Late = 4, OutOfDomain = 8, Held = 16, Bypass = 32,
  NewSession = 64, Fading = 128, Failed = 256, Backwards = 512
}

/// <summary>SMPTE timecode, if the rig sends one.</summary>
public sealed class Timecode {
  public uint Hours, Minutes, Seconds, Frames;
  public float Rate;
  public bool DropFrame;
}

public struct StyleWeight {
  public string Style;
  public float Weight;
}

/// <summary>A facial expression, by the avatar's name for it; 0 to 1.</summary>
public struct Expression {
  public string Name;
  public float Value;
}

/// <summary>A rigid object that the rig tracks, such as a sword, where it is in this frame's world: in the
/// body's units and axes.</summary>
public struct Prop {
  public string Name;
  public float[] Position;  // 3: x, y, z
  public float[] Rotation;  // 4: x, y, z, w; world from prop
}

/// <summary>A skeleton, to which the rotations of a frame belong.</summary>
public sealed class Body {
  public string Performer = "", Dialect = "", OutputName = "";
  public string[] Names = new string[0];
  public int[] Parents = new int[0];
  public float[] Offsets = new float[0], Rest = new float[0];
  public float MetresPerUnit;
  public ulong Hash;
  public Output Output;

  /// <summary>The joint of this name (the first one), or -1. The canonical humanoid has at least 21
  /// joints, named like VRM 1.0's bones, and fingers, eyes and jaw if the performer has them.</summary>
  public int IndexOf(string name) { return Array.IndexOf(Names, name); }

  /// <summary>Reads the bytes of a Body. Throws FormatException.</summary>
  public static Body Parse(byte[] bytes) {
    var body = new Body();
    var names = new List<string>();
    var parents = new List<int>();
    var offsets = new List<float>();
    var rest = new List<float>();
    var reader = new WireReader(bytes);
    while (reader.Next()) {
      switch (reader.Field) {
        case 1: body.Performer = reader.Text(); break;
        case 2: names.Add(reader.Text()); break;
        case 3: reader.SignedNumbers(parents); break;
        case 4: reader.Floats(offsets); break;
        case 5: reader.Floats(rest); break;
        case 6: body.MetresPerUnit = reader.Float(); break;
        case 7: body.Dialect = reader.Text(); break;
        case 8: body.Hash = reader.Fixed64(); break;
        case 9: body.Output = (Output)(int)reader.Number(); break;
        case 10: body.OutputName = reader.Text(); break;
        default: reader.Skip(); break;
      }
    }
    body.Names = names.ToArray();
    body.Parents = parents.ToArray();
    body.Offsets = offsets.ToArray();
    body.Rest = rest.ToArray();
    return body;
  }
}

/// <summary>One pose of one performer.</summary>
public sealed class Frame {
  public string Performer = "";
  public ulong Epoch, Sequence, SourceTimeNs, ReceiveTimeNs, PublishTimeNs, WallTimeNs, BodyHash,
      SourceSequence;
  public Timecode Timecode;  // null: the rig sends none
  public Output Output;
  public float[] RootPosition = new float[0];  // 3: x, y, z
  public float[] Rotations = new float[0];     // 4*J: x, y, z, w; parent from joint
  public uint[] HeldJoints = new uint[0];
  public uint Contacts;
  public FrameFlags Flags;
  public StyleWeight[] Styles = new StyleWeight[0];
  public Expression[] Expressions = new Expression[0];
  public byte[][] Thru = new byte[0][];  // VMC: whole OSC messages for the renderer of the avatar
  public Prop[] Props = new Prop[0];

  /// <summary>Reads the bytes of a Frame. Throws FormatException.</summary>
  public static Frame Parse(byte[] bytes) {
    var frame = new Frame();
    var root = new List<float>(3);
    var rotations = new List<float>();
    var held = new List<uint>();
    var styles = new List<StyleWeight>();
    var expressions = new List<Expression>();
    var thru = new List<byte[]>();
    var props = new List<Prop>();
    var reader = new WireReader(bytes);
    while (reader.Next()) {
      switch (reader.Field) {
        case 1: frame.Performer = reader.Text(); break;
        case 2: frame.Epoch = reader.Fixed64(); break;
        case 3: frame.Sequence = reader.Number(); break;
        case 4: frame.SourceTimeNs = reader.Number(); break;
        case 5: frame.Timecode = ParseTimecode(reader.Message(), frame.Timecode); break;
        case 6: frame.ReceiveTimeNs = reader.Number(); break;
        case 7: frame.PublishTimeNs = reader.Number(); break;
        case 8: frame.WallTimeNs = reader.Number(); break;
        case 9: frame.BodyHash = reader.Fixed64(); break;
        case 10: frame.Output = (Output)(int)reader.Number(); break;
        case 11: reader.Floats(root); break;
        case 12: reader.Floats(rotations); break;
        case 13: reader.Numbers(held); break;
        case 14: frame.Contacts = (uint)reader.Number(); break;
        case 15: frame.Flags = (FrameFlags)(uint)reader.Number(); break;
        case 16:
          styles.Add(Named(reader.Message(), (name, value) => new StyleWeight { Style = name, Weight = value }));
          break;
        case 17: frame.SourceSequence = reader.Number(); break;
        case 18:
          expressions.Add(Named(reader.Message(), (name, value) => new Expression { Name = name, Value = value }));
          break;
        case 19: thru.Add(reader.Bytes()); break;
        case 20: props.Add(ParseProp(reader.Message())); break;
        default: reader.Skip(); break;
      }
    }
    frame.RootPosition = root.ToArray();
    frame.Rotations = rotations.ToArray();
    frame.HeldJoints = held.ToArray();
    frame.Styles = styles.ToArray();
    frame.Expressions = expressions.ToArray();
    frame.Thru = thru.ToArray();
    frame.Props = props.ToArray();
    return frame;
  }

  // A message of a name and a number.
  static T Named<T>(WireReader reader, Func<string, float, T> make) {
    string name = "";
    float value = 0;
    while (reader.Next()) {
      if (reader.Field == 1) name = reader.Text();
      else if (reader.Field == 2) value = reader.Float();
      else reader.Skip();
    }
    return make(name, value);
  }

  static Prop ParseProp(WireReader reader) {
    string name = "";
    var position = new List<float>(3);
    var rotation = new List<float>(4);
    while (reader.Next()) {
      if (reader.Field == 1) name = reader.Text();
      else if (reader.Field == 2) reader.Floats(position);
      else if (reader.Field == 3) reader.Floats(rotation);
      else reader.Skip();
    }
    return new Prop { Name = name, Position = position.ToArray(), Rotation = rotation.ToArray() };
  }

  // Of several, the later ones' fields count, as in protobuf.
  static Timecode ParseTimecode(WireReader reader, Timecode earlier) {
    Timecode code = earlier ?? new Timecode();
    while (reader.Next()) {
      switch (reader.Field) {
        case 1: code.Hours = (uint)reader.Number(); break;
        case 2: code.Minutes = (uint)reader.Number(); break;
        case 3: code.Seconds = (uint)reader.Number(); break;
        case 4: code.Frames = (uint)reader.Number(); break;
        case 5: code.Rate = reader.Float(); break;
        case 6: code.DropFrame = reader.Number() != 0; break;
        default: reader.Skip(); break;
      }
    }
    return code;
  }
}

}  // namespace Styled
