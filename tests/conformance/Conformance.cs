// The C# client reads the goldens to the same numbers (README.md). conformance GOLDENS: prints a line for
// each test; 1 if one failed.
using System;
using System.Collections.Generic;
using System.Globalization;
using System.IO;
using System.Text;
using Styled;
using UnityEngine;

static class Conformance {
  static string folder;
  static string failure;

  static int Main(string[] arguments) {
    folder = arguments[0];
    var tests = new List<KeyValuePair<string, Action>>();
    foreach (string name in new[] { "canonical", "fifty-five-joints", "centimetres", "hand" }) {
      tests.Add(new KeyValuePair<string, Action>(name + " is read to the same numbers", () => SameNumbers(name)));
    }
    tests.Add(new KeyValuePair<string, Action>("what is to be refused is dropped", Refused));
    tests.Add(new KeyValuePair<string, Action>("wrong arguments are refused", WrongArguments));
    tests.Add(new KeyValuePair<string, Action>("any bytes are taken", AnyBytes));
    tests.Add(new KeyValuePair<string, Action>("gaps, repetitions and restarts are counted", Gaps));
    tests.Add(new KeyValuePair<string, Action>("avatars are told apart by their outputs' names", Avatars));
    tests.Add(new KeyValuePair<string, Action>("Unity's sample turns each bone as the mirrored joint", Sample));
    tests.Add(new KeyValuePair<string, Action>("Unity's sample says once what is wrong", SampleSaysWhatIsWrong));
    tests.Add(new KeyValuePair<string, Action>("no class has the name of one of Unity's", Names));
    tests.Add(new KeyValuePair<string, Action>("a comparison that must fail does", NegativeControl));
    int failed = 0;
    foreach (var test in tests) {
      failure = null;
      try {
        test.Value();
      } catch (Exception error) {
        failure = failure ?? error.ToString();
      }
      Console.WriteLine((failure == null ? "ok: " : "FAILED: ") + test.Key + (failure == null ? "" : ": " + failure));
      if (failure != null) ++failed;
    }
    Console.WriteLine(tests.Count - failed + " passed, " + failed + " failed");
    return failed == 0 ? 0 : 1;
  }

  static void Check(bool good, string what) {
    if (!good && failure == null) failure = what;
  }

  static void SameNumbers(string name) {
    Json golden = Golden(name);
    Body body = Body.Parse(Bytes(golden["body"].Text));
    Same(golden["body_fields"], Fields(body), "body");
    Check(Kinematics.Check(body) == "", "a good body is refused: " + Kinematics.Check(body));
    Check(golden["frames"].List.Count > 0, "no frame");
    WorldPose pose = null;
    foreach (Json entry in golden["frames"].List) {
      Frame frame = Frame.Parse(Bytes(entry["frame"].Text));
      Same(entry["fields"], Fields(frame), "frame");
      Check(Kinematics.Check(frame, body) == "", "a good frame is refused");
      pose = Kinematics.World(body, frame, pose);
      Compare(entry, pose);
    }
  }

  static void Compare(Json entry, WorldPose pose) {
    List<Json> positions = entry["positions"].List, rotations = entry["rotations"].List;
    Check(3 * positions.Count == pose.Positions.Length, "another number of joints");
    double scale = 1;
    foreach (Json position in positions) {
      foreach (Json x in position.List) scale = Math.Max(scale, Math.Abs(x.Number));
    }
    for (int joint = 0; joint < positions.Count; ++joint) {
      double dot = 0;
      for (int i = 0; i < 3; ++i) {
        double off = positions[joint].List[i].Number - pose.Positions[3 * joint + i];
        Check(Math.Abs(off) <= 1e-5 * scale, "position of joint " + joint + " is off by " + off);
      }
      for (int i = 0; i < 4; ++i) dot += rotations[joint].List[i].Number * pose.Rotations[4 * joint + i];
      for (int i = 0; i < 4; ++i) {
        double off = rotations[joint].List[i].Number - Math.Sign(dot) * pose.Rotations[4 * joint + i];
        Check(Math.Abs(off) <= 1e-5, "rotation of joint " + joint + " is off by " + off);
      }
    }
  }

  static void Refused() {
    Json golden = Golden("refused");
    byte[] good = Bytes(golden["body"].Text);
    foreach (string kind in new[] { "body", "frame" }) {
      foreach (Json entry in golden[kind == "body" ? "bodies" : "frames"].List) {
        var inbox = new Inbox("rig.anna", "rig");
        if (kind == "frame") Check(inbox.Accept(Message("body/rig.anna/", good)) != null, "the good body");
        string topic = kind == "body" ? "body/rig.anna/" : "styled/rig.anna/rig/", why = entry["why"].Text;
        Update update = inbox.Accept(Message(topic, Bytes(entry[kind].Text)));
        if (why == "of another body") {  // its body may be still to come
          Check(update != null && update.Body == null, why);
          continue;
        }
        Check(update == null && inbox.Counters.Malformed == 1, kind + ": " + why);
      }
    }
  }

  static void WrongArguments() {
    foreach (string bad in new[] { "rig", "rig.", ".a", "a.b.c", "a b.c", "rig.a/", "*", "rig.a\n" }) {
      Throws(() => new Inbox(bad, "rig"), "SOURCE.NAME");
    }
    foreach (string bad in new[] { "Rig", "CANONICAL" }) {
      Throws(() => new Inbox("", bad), "stream '" + bad + "', expected '" + bad.ToLowerInvariant() + "'");
    }
    Throws(() => new Subscriber("ipc:///tmp/styled-nobody", "", new string[0]).Dispose(), "streams has none");
    foreach (string bad in new[] { null, "", "http://a:1", "inproc://a", "tcp://a", "tcp://:1", "tcp://a:0", "tcp://a:65536", "ws://a:1" }) {
      Throws(() => new Subscriber(bad).Dispose(), "cannot connect to '" + bad + "', expected e.g. tcp://");
      Throws(() => new Control(bad).Dispose(), "cannot connect to '" + bad + "', expected e.g. tcp://");
    }
    foreach (string bad in new[] { "", "a/b", null, "rig\n" }) Throws(() => new Inbox("", bad), "expected rig, canonical");
    Throws(() => new Subscriber("nonsense").Dispose(), "expected e.g. tcp://");
    Throws(() => new Subscriber(queueMessages: 0).Dispose(), "expected 1 or more");
    Throws(() => new Subscriber(curve: new Curve { ServerKey = "short" }).Dispose(), "expected 40 of Z85");
    Throws(() => new Control(timeoutMs: 0).Dispose(), "expected 1 or more");
    using (var control = new Control("ipc:///tmp/styled-nobody", 50)) {
      foreach (string bad in new[] { "anna", "", null }) Throws(() => control.SetStyle(bad, "old"), "SOURCE.NAME");
      try {
        control.Styles();
        Check(false, "somebody answers");
      } catch (TimeoutException error) {
        Check(error.Message.Contains("no daemon answers at ipc:///tmp/styled-nobody"), error.Message);
      }
    }
    new Subscriber("ipc:///tmp/styled-nobody");  // dropped unclosed: the end must come all the same
    GC.Collect();
    GC.WaitForPendingFinalizers();
  }

  static void Throws(Action action, string expected) {
    try {
      action();
      Check(false, "nothing was refused, expected: " + expected);
    } catch (ArgumentException error) {
      Check(error.Message.Contains(expected), error.Message);
    }
  }

  static void AnyBytes() {
    var chance = new Random(1);
    var inbox = new Inbox("", "rig");
    byte[] good = Bytes(Golden("hand")["frames"].List[0]["frame"].Text);
    for (int round = 0; round < 20000; ++round) {
      var bytes = (byte[])good.Clone();
      if (round % 2 == 0) bytes = new byte[chance.Next(60)];
      for (int i = round % 2 == 0 ? bytes.Length : 4; i > 0; --i) {
        bytes[round % 2 == 0 ? i - 1 : chance.Next(bytes.Length)] = (byte)chance.Next(256);
      }
      inbox.Accept(Message(new[] { "body/rig.anna/", "styled/rig.anna/rig/", "source/rig.anna/" }[round % 3], bytes));
    }
    ulong before = inbox.Counters.Malformed;
    inbox.Accept(new[] { new byte[1] });
    inbox.Accept(Message("nonsense", good));
    inbox.Accept(Message("styled/rig.other/rig/", good));
    Check(inbox.Counters.Malformed == before + 3, "a message that is none was not counted");
  }

  static void Gaps() {
    Json golden = Golden("canonical");
    string performer = golden["body_fields"]["performer"].Text, topic = "styled/" + performer + "/canonical/";
    var inbox = new Inbox("", "canonical");
    byte[] body = Bytes(golden["body"].Text);
    Check(inbox.Accept(Message("body/" + performer + "/", body)).Body.IndexOf("head") == 4, "the body");
    Check(inbox.NewTopics.Count == 1 && inbox.NewTopics[0] == topic, "its topic");
    Check(inbox.Accept(Message("body/" + performer + "/", body)) == null, "a body twice");
    Func<ulong, byte, Update> send = (sequence, epoch) => {
      byte[] frame = Bytes(golden["frames"].List[0]["frame"].Text);
      var with = new List<byte>(frame) { 0x18, (byte)sequence, 0x11, epoch, 0, 0, 0, 0, 0, 0, 0 };  // the last of a field counts
      return inbox.Accept(Message(topic, with.ToArray()));
    };
    Check(send(5, 1).Missed == 0 && send(9, 1).Missed == 3, "a gap");
    Check(send(9, 1) == null && send(4, 1) == null, "a repetition");
    Update restarted = send(1, 2);
    Check(restarted.NewEpoch && restarted.Missed == 0 && restarted.Body != null, "a restart");
    Counters c = inbox.Counters;
    Check(c.Frames == 3 && c.Missed == 3 && c.RepeatedFrames == 2 && c.Epochs == 1 && c.Bodies == 1 &&
          c.ReplayedBodies == 1 && c.Malformed == 0, "the counters");
  }

  static void Avatars() {
    Json golden = Golden("canonical");
    string performer = golden["body_fields"]["performer"].Text;
    var inbox = new Inbox("", "hero", "villain");
    foreach (string name in new[] { "hero", "villain" }) {
      var body = new List<byte>(Bytes(golden["body"].Text)) { 0x48, 3, 0x52, (byte)name.Length };
      body.AddRange(Encoding.ASCII.GetBytes(name));
      inbox.Accept(Message("body/" + performer + "/", body.ToArray()));
      var frame = new List<byte>(Bytes(golden["frames"].List[0]["frame"].Text)) { 0x50, 3 };
      Update update = inbox.Accept(Message("styled/" + performer + "/" + name + "/", frame.ToArray()));
      Check(update != null && update.Stream == name && update.Body != null && update.Body.OutputName == name, name);
    }
    Check(inbox.Counters.Bodies == 2, "two bodies");
  }

  // An avatar that stands anywhere, whose bones have any rest rotation, and fingers that the body lacks.
  static void SampleSaysWhatIsWrong() {
    Debug.Said.Clear();
    foreach (string bad in new[] { "nonsense", "" }) {
      var sample = new Styled.Samples.LivePerformer { endpoint = bad };
      sample.OnEnable();
      sample.LateUpdate();
      sample.OnDisable();
      Check(!sample.enabled && Debug.Said.Count == 1, "said " + Debug.Said.Count + " times");
      Check(Debug.Said[0].StartsWith("error: LivePerformer: cannot connect to '" + bad + "'"), Debug.Said[0]);
      Debug.Said.Clear();
    }
    var silent = new Styled.Samples.LivePerformer { endpoint = "ipc:///tmp/styled-nobody", performer = "rig.ann", warnAfterSeconds = 60 };
    silent.OnEnable();
    silent.LateUpdate();
    Check(Debug.Said.Count == 0, "a warning too early");
    silent.warnAfterSeconds = 0;
    for (int i = 0; i < 3; ++i) silent.LateUpdate();
    silent.OnDisable();
    Check(Debug.Said.Count == 1 && Debug.Said[0].StartsWith("warning: LivePerformer: no frame of 'rig.ann'"), "no warning");
  }

  static void Sample() {
    Json golden = Golden("canonical");
    Body body = Body.Parse(Bytes(golden["body"].Text));
    body.Names[20] = "leftThumbProximal";  // instead of rightToes: Unity counts thumbs otherwise
    var chance = new Random(2);
    Func<UnityEngine.Quaternion> any = () => {
      double a = chance.NextDouble() * 6, b = chance.NextDouble() * 6, c = chance.NextDouble();
      double s = Math.Sqrt(1 - c), t = Math.Sqrt(c);
      return new UnityEngine.Quaternion((float)(s * Math.Sin(a)), (float)(s * Math.Cos(a)), (float)(t * Math.Sin(b)),
                                        (float)(t * Math.Cos(b)));
    };
    var animator = new Animator();
    var sample = new Styled.Samples.LivePerformer();
    sample.transform.localPosition = new Vector3(5, 0, 7);
    sample.transform.localRotation = new UnityEngine.Quaternion(0, 0.6f, 0, 0.8f);
    UnityEngine.Component.Others[typeof(Animator)] = animator;
    var rest = new Dictionary<string, UnityEngine.Quaternion>();
    Transform above = sample.transform;
    foreach (string name in new[] { "hips", "spine", "head", "leftUpperArm", "leftHand", "leftThumbIntermediate", "jaw" }) {
      var which = (HumanBodyBones)Enum.Parse(typeof(HumanBodyBones), name, true);
      animator.Bones[which] = new Transform { parent = above, localPosition = new Vector3(0, name == "hips" ? 0.5f : 0.1f, 0),
                                              localRotation = any() };
      if (name != "jaw") above = animator.Bones[which];
      rest[name] = UnityEngine.Quaternion.Inverse(sample.transform.rotation) * animator.Bones[which].rotation;
    }
    Json entry = golden["frames"].List[0];
    Frame frame = Frame.Parse(Bytes(entry["frame"].Text));
    UnityEngine.Quaternion jaw = animator.Bones[HumanBodyBones.Jaw].localRotation;
    sample.Apply(new Update { Frame = frame, Body = body });
    Check(animator.Bones[HumanBodyBones.Jaw].localRotation.Equals(jaw), "the jaw was moved");
    foreach (string name in rest.Keys) {
      int joint = body.IndexOf(name == "leftThumbIntermediate" ? "leftThumbProximal" : name);
      if (joint < 0) continue;
      var bone = animator.Bones[(HumanBodyBones)Enum.Parse(typeof(HumanBodyBones), name, true)];
      // A direction of the joint, and the same one of the bone, mirrored.
      UnityEngine.Quaternion turn = UnityEngine.Quaternion.Inverse(sample.transform.rotation) * bone.rotation *
                                    UnityEngine.Quaternion.Inverse(rest[name]);
      List<Json> r = entry["rotations"].List[joint].List;
      var joint_turn = new UnityEngine.Quaternion((float)r[0].Number, (float)r[1].Number, (float)r[2].Number, (float)r[3].Number);
      Vector3 expected = joint_turn * new Vector3(-0.6f, 0.48f, 0.64f), found = turn * new Vector3(0.6f, 0.48f, 0.64f);
      Check(Math.Abs(found.x + expected.x) + Math.Abs(found.y - expected.y) + Math.Abs(found.z - expected.z) < 1e-4, name);
    }
    Vector3 hips = sample.transform.InverseTransformPoint(animator.Bones[HumanBodyBones.Hips].position);
    float[] root = frame.RootPosition;
    Check(Math.Abs(hips.x + root[0]) + Math.Abs(hips.y - root[1] * 0.5 / body.Offsets[1]) + Math.Abs(hips.z - root[2]) < 1e-5, "hips");
    // Of another body, whose joint at that place has no bone.
    Body other = Body.Parse(Bytes(golden["body"].Text));
    other.Names[other.IndexOf("leftHand")] = "nobody";
    UnityEngine.Quaternion kept = animator.Bones[HumanBodyBones.LeftHand].localRotation = any();
    sample.Apply(new Update { Frame = frame, Body = other });
    Check(animator.Bones[HumanBodyBones.LeftHand].localRotation.Equals(kept), "a joint of the body before moved the hand");
  }

  // Such a name would be ambiguous in every script that uses both namespaces.
  static void Names() {
    Type[] ours = typeof(Subscriber).Assembly.GetExportedTypes();
    Check(ours.Length > 10, "no classes");
    foreach (Type type in ours) {
      Check(typeof(MonoBehaviour).Assembly.GetType("UnityEngine." + type.Name) == null, type.FullName);
    }
  }

  static void NegativeControl() {
    Json golden = Golden("canonical");
    Json entry = golden["frames"].List[0];
    Body body = Body.Parse(Bytes(golden["body"].Text));
    Frame frame = Frame.Parse(Bytes(entry["frame"].Text));
    frame.Rotations[4] += 0.001f;
    Compare(entry, Kinematics.World(body, frame));
    bool noticed = failure != null;
    failure = noticed ? null : "a wrong rotation was not noticed";
  }

  static Dictionary<string, object> Fields(Body b) {
    return new Dictionary<string, object> {
      { "performer", b.Performer }, { "names", b.Names }, { "parents", b.Parents }, { "offsets", b.Offsets },
      { "rest", b.Rest }, { "metres_per_unit", b.MetresPerUnit }, { "dialect", b.Dialect },
      { "hash", b.Hash.ToString() }, { "output", (int)b.Output }, { "output_name", b.OutputName } };
  }

  static Dictionary<string, object> Fields(Frame f) {
    var styles = new List<object>();
    foreach (StyleWeight s in f.Styles) {
      styles.Add(new Dictionary<string, object> { { "style", s.Style }, { "weight", s.Weight } });
    }
    var expressions = new List<object>();
    foreach (Expression e in f.Expressions) {
      expressions.Add(new Dictionary<string, object> { { "name", e.Name }, { "value", e.Value } });
    }
    var props = new List<object>();
    foreach (Prop p in f.Props) {
      props.Add(new Dictionary<string, object> { { "name", p.Name }, { "position", p.Position }, { "rotation", p.Rotation } });
    }
    var thru = new List<object>();
    foreach (byte[] data in f.Thru) thru.Add(Convert.ToBase64String(data));
    Timecode t = f.Timecode;
    return new Dictionary<string, object> {
      { "performer", f.Performer }, { "epoch", f.Epoch.ToString() }, { "sequence", f.Sequence.ToString() },
      { "source_time_ns", f.SourceTimeNs.ToString() }, { "receive_time_ns", f.ReceiveTimeNs.ToString() },
      { "publish_time_ns", f.PublishTimeNs.ToString() }, { "wall_time_ns", f.WallTimeNs.ToString() },
      { "body_hash", f.BodyHash.ToString() }, { "output", (int)f.Output }, { "held_joints", f.HeldJoints },
      { "root_position", f.RootPosition }, { "rotations", f.Rotations },
      { "contacts", f.Contacts }, { "flags", (uint)f.Flags }, { "styles", styles },
      { "expressions", expressions }, { "thru", thru }, { "props", props },
      { "source_sequence", f.SourceSequence.ToString() },
      { "timecode", t == null ? null : new Dictionary<string, object> {
          { "hours", t.Hours }, { "minutes", t.Minutes }, { "seconds", t.Seconds }, { "frames", t.Frames },
          { "rate", t.Rate }, { "drop_frame", t.DropFrame ? 1 : 0 } } } };
  }

  static void Same(Json expected, object found, string where) {
    if (expected.Fields != null) {
      var fields = found as Dictionary<string, object>;
      Check(fields != null, where + ": is missing");
      if (fields == null) return;
      foreach (var field in expected.Fields) {
        if (!fields.ContainsKey(field.Key)) Check(false, where + ": no field " + field.Key);
        else Same(field.Value, fields[field.Key], where + "." + field.Key);
      }
    } else if (expected.List != null) {
      var items = new List<object>();
      if (found is System.Collections.IEnumerable) foreach (object item in (System.Collections.IEnumerable)found) items.Add(item);
      Check(items.Count == expected.List.Count, where + ": " + items.Count + " values, expected " + expected.List.Count);
      for (int i = 0; i < Math.Min(items.Count, expected.List.Count); ++i) Same(expected.List[i], items[i], where + "[" + i + "]");
    } else if (expected.Text != null) {
      Check(expected.Text.Equals(found), where + ": '" + found + "', expected '" + expected.Text + "'");
    } else if (expected.IsNull) {
      Check(found == null, where + ": expected nothing");
    } else {
      Check(found != null && Convert.ToDouble(found, CultureInfo.InvariantCulture) == expected.Number, where + ": " + found + ", expected " + expected.Number);
    }
  }

  static Json Golden(string name) { return new Json.Reader(File.ReadAllText(Path.Combine(folder, name + ".json"))).Read(); }

  static byte[][] Message(string topic, byte[] payload) { return new[] { Encoding.ASCII.GetBytes(topic), payload }; }

  static byte[] Bytes(string hex) {
    var bytes = new byte[hex.Length / 2];
    for (int i = 0; i < bytes.Length; ++i) bytes[i] = Convert.ToByte(hex.Substring(2 * i, 2), 16);
    return bytes;
  }
}

// JSON as make.py writes it; Debian's Mono compiler comes without a reader.
sealed class Json {
  public string Text;
  public double Number;
  public bool IsNull;
  public List<Json> List;
  public Dictionary<string, Json> Fields;

  public Json this[string name] { get { return Fields[name]; } }

  public sealed class Reader {
    readonly string text_;
    int at_;

    public Reader(string text) { text_ = text; }

    public Json Read() {
      Space();
      char c = text_[at_];
      if (c == '"') return new Json { Text = String() };
      if (c == '{' || c == '[') return Container(c == '{');
      int begin = at_;
      while (at_ < text_.Length && ",]} \n".IndexOf(text_[at_]) < 0) ++at_;
      string word = text_.Substring(begin, at_ - begin);
      if (word == "null") return new Json { IsNull = true };
      return new Json { Number = double.Parse(word, CultureInfo.InvariantCulture) };
    }

    Json Container(bool named) {
      var json = new Json();
      if (named) json.Fields = new Dictionary<string, Json>();
      else json.List = new List<Json>();
      ++at_;
      for (Space(); text_[at_] != ']' && text_[at_] != '}'; Space()) {
        if (named) {
          string name = String();
          Space();
          ++at_;  // the colon
          json.Fields[name] = Read();
        } else {
          json.List.Add(Read());
        }
        Space();
        if (text_[at_] == ',') ++at_;
      }
      ++at_;
      return json;
    }

    string String() {
      var out_ = new StringBuilder();
      for (++at_; text_[at_] != '"'; ++at_) {
        if (text_[at_] != '\\') {
          out_.Append(text_[at_]);
        } else if (text_[++at_] == 'u') {
          out_.Append((char)Convert.ToInt32(text_.Substring(at_ + 1, 4), 16));
          at_ += 4;
        } else {
          out_.Append(text_[at_]);
        }
      }
      ++at_;
      return out_.ToString();
    }

    void Space() {
      while (at_ < text_.Length && char.IsWhiteSpace(text_[at_])) ++at_;
    }
  }
}
