// A subscriber's messages without its socket: topics, the bodies of frames, and gaps
// (proto/styled/v1/WIRE.md).
using System;
using System.Collections.Generic;
using System.Text;
using System.Text.RegularExpressions;

namespace Styled {

/// <summary>One received message: a frame, or a body not seen before.</summary>
public sealed class Update {
  public string Performer = "";
  /// <summary>"rig", "canonical", "source", or the name of an [[output]]; "" for a body.</summary>
  public string Stream = "";
  public Frame Frame;       // null: the update is a body
  public Body Body;         // of the frame, checked; null until it has arrived
  public ulong Missed;      // frames of this stream lost in transit directly before this one
  public ulong Skipped;     // Subscriber.Latest only: older frames that this one superseded
  public bool NewEpoch;     // the daemon restarted since the previous frame of this stream
}

/// <summary>Totals since the subscriber was made; never reset.</summary>
public sealed class Counters {
  public ulong Frames;          // accepted
  public ulong Missed;          // lost in transit, by gaps in `sequence`, summed over streams
  public ulong Epochs;          // restarts of the daemon, counted once per stream
  public ulong Bodies;          // new skeletons
  public ulong ReplayedBodies;  // dropped: already known
  public ulong RepeatedFrames;  // dropped: sequence not greater than the last
  public ulong Malformed;       // dropped: not as in WIRE.md, or a frame that does not fit its body
}

/// <summary>Turns messages into updates. Its owner subscribes to Topics, and to NewTopics as they
/// appear. One thread at a time.</summary>
public sealed class Inbox {
  const int MaxPerformers = 4096;
  const int MaxBodies = 64;  // per performer
  static readonly Regex Name = new Regex(@"\A[A-Za-z0-9_-]{1,32}\z");
  static readonly Regex Id = new Regex(@"\A[A-Za-z0-9_-]{1,32}\.[A-Za-z0-9_-]{1,32}\z");

  sealed class State {
    public ulong Epoch, Sequence;
  }

  readonly string performer_;
  readonly string[] streams_;
  readonly Dictionary<string, List<Body>> bodies_ = new Dictionary<string, List<Body>>();
  readonly Dictionary<string, State> states_ = new Dictionary<string, State>();

  public Counters Counters { get; private set; }
  public List<string> NewTopics { get; private set; }

  /// <summary>`performer`: SOURCE.NAME, or "" for all. Throws ArgumentException.</summary>
  public Inbox(string performer, params string[] streams) {
    Counters = new Counters();
    NewTopics = new List<string>();
    performer_ = performer ?? "";
    streams_ = streams ?? new string[0];
    if (performer_ != "" && !IsPerformerId(performer_)) {
      throw new ArgumentException("performer '" + performer_ + "' is not SOURCE.NAME ([A-Za-z0-9_-]{1,32} each), or \"\" for all");
    }
    if (streams_.Length == 0) {
      throw new ArgumentException("streams has none, so no frame would arrive, expected rig, canonical, source, or " +
                                  "the name of an [[output]]");
    }
    foreach (string stream in streams_) {
      string small = stream == null ? "" : stream.ToLowerInvariant();
      if (small != stream && (small == "rig" || small == "canonical" || small == "source")) {
        throw new ArgumentException("stream '" + stream + "', expected '" + small + "'");
      }
      if (stream == null || !Name.IsMatch(stream)) {
        throw new ArgumentException("stream '" + stream + "', expected rig, canonical, source, or the name of " +
                                    "an [[output]] ([A-Za-z0-9_-]{1,32})");
      }
    }
  }

  public static bool IsPerformerId(string text) { return Id.IsMatch(text); }

  public ICollection<string> Performers { get { return bodies_.Keys; } }

  public List<string> Topics() {
    if (performer_ == "") return new List<string> { "body/" };  // finds the performers; then each one's own
    var topics = new List<string> { "body/" + performer_ + "/" };
    topics.AddRange(FrameTopics(performer_));
    return topics;
  }

  /// <summary>The update for a message, or null if the message is dropped.</summary>
  public Update Accept(IList<byte[]> parts) {
    try {
      if (parts.Count == 2) return Accept(Encoding.ASCII.GetString(parts[0]), parts[1]);
    } catch (FormatException) {
    }
    ++Counters.Malformed;
    return null;
  }

  IEnumerable<string> FrameTopics(string performer) {
    foreach (string stream in streams_) {
      yield return stream == "source" ? "source/" + performer + "/" : "styled/" + performer + "/" + stream + "/";
    }
  }

  Update Accept(string topic, byte[] payload) {
    string[] words = topic.Split('/');
    bool whole = words[words.Length - 1] == "" && words.Length > 2 && IsPerformerId(words[1]);
    if (whole && words.Length == 3 && words[0] == "body") return AcceptBody(words[1], Body.Parse(payload));
    if (whole && words.Length == 3 && words[0] == "source") {
      return AcceptFrame(topic, words[1], "source", Output.Rig, Frame.Parse(payload));
    }
    if (whole && words.Length == 4 && words[0] == "styled" && Name.IsMatch(words[2])) {
      Output output = words[2] == "rig" ? Output.Rig : words[2] == "canonical" ? Output.Canonical : Output.Avatar;
      return AcceptFrame(topic, words[1], words[2], output, Frame.Parse(payload));
    }
    throw new FormatException("an invalid topic");
  }

  Update AcceptBody(string performer, Body body) {
    List<Body> known;
    bool seen = bodies_.TryGetValue(performer, out known);
    if (body.Performer != performer || Kinematics.Check(body) != "" || (!seen && bodies_.Count >= MaxPerformers)) {
      throw new FormatException("an invalid body");
    }
    if (!seen) {
      bodies_[performer] = known = new List<Body>();
      if (performer_ == "") NewTopics.AddRange(FrameTopics(performer));
    }
    if (known.Exists(b => b.Hash == body.Hash && b.Output == body.Output && b.OutputName == body.OutputName)) {
      ++Counters.ReplayedBodies;
      return null;
    }
    if (known.Count >= MaxBodies) known.RemoveAt(0);
    known.Add(body);
    ++Counters.Bodies;
    return new Update { Performer = performer, Body = body };
  }

  Update AcceptFrame(string topic, string performer, string stream, Output output, Frame frame) {
    if (frame.Performer != performer || frame.Output != output) throw new FormatException("of another topic");
    State state;
    bool started = states_.TryGetValue(topic, out state);
    bool same = started && frame.Epoch == state.Epoch;
    if (same && frame.Sequence <= state.Sequence) {
      ++Counters.RepeatedFrames;
      return null;
    }
    string name = output == Output.Avatar ? stream : "";
    List<Body> known;
    Body body = !bodies_.TryGetValue(performer, out known) ? null : known.Find(
        b => b.Hash == frame.BodyHash && b.Output == output && b.OutputName == name);
    if (body != null && Kinematics.Check(frame, body) != "") throw new FormatException("an invalid frame");
    var update = new Update { Performer = performer, Stream = stream, Frame = frame, Body = body,
                              NewEpoch = started && !same };
    if (same) update.Missed = frame.Sequence - state.Sequence - 1;
    states_[topic] = new State { Epoch = frame.Epoch, Sequence = frame.Sequence };
    ++Counters.Frames;
    Counters.Missed += update.Missed;
    if (update.NewEpoch) ++Counters.Epochs;
    return update;
  }
}

}  // namespace Styled
