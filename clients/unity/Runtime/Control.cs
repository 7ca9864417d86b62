using System;
using System.Collections.Generic;
using System.Diagnostics;

namespace Styled {

/// <summary>The daemon refused, and changed nothing; Message is its reason.</summary>
public sealed class RefusedException : Exception {
  /// <summary>A number of Code in proto/styled/v1/control.proto: 3 is an unknown style.</summary>
  public readonly int Code;
  public RefusedException(int code, string reason) : base(reason == "" ? "code " + code : reason) { Code = code; }
}

/// <summary>Controls a daemon. Each call blocks until the reply, or for `timeoutMs`; it throws
/// RefusedException, TimeoutException (no daemon answers; the change may or may not have been applied),
/// FormatException (the answer is not a daemon's) or ArgumentException. `performer` is SOURCE.NAME or "*".
/// A change returns the first sequence under it by performer; Absent and NoStrength name the performers
/// for which it is not visible, NotChanged those that a change for "*" left as they were. One thread at a time, in Unity
/// not the main one; Dispose it.</summary>
public sealed class Control : IDisposable {
  public const string DefaultEndpoint = "tcp://127.0.0.1:7002";
  const long MaxReplyBytes = 16 << 20;

  readonly string endpoint_;
  readonly int timeout_ms_;
  readonly Curve curve_;
  ZmqSocket socket_;
  // So that replies to an earlier program do not match.
  ulong id_ = (ulong)Stopwatch.GetTimestamp() & 0xffffffffffff;

  public Control(string endpoint = DefaultEndpoint, int timeoutMs = 2000, Curve curve = null) {
    if (timeoutMs < 1) throw new ArgumentException("timeoutMs is " + timeoutMs + ", expected 1 or more");
    endpoint_ = endpoint;
    timeout_ms_ = timeoutMs;
    curve_ = curve;
    Absent = NoStrength = new string[0];
    NotChanged = new Dictionary<string, string>();
    Open();
  }

  public void Dispose() { socket_.Dispose(); }

  /// <summary>Of the last call that the daemon answered: no performers of these names are present, and the
  /// change waits for them. A mistyped name appears here.</summary>
  public ICollection<string> Absent { get; private set; }

  /// <summary>Of the same call: these have a style set, but the strength 0, so that none is
  /// visible.</summary>
  public ICollection<string> NoStrength { get; private set; }

  /// <summary>Of the same call, for "*": the performers whose settings stayed as they were, and why.</summary>
  public IDictionary<string, string> NotChanged { get; private set; }

  /// <summary>The names of the daemon's styles.</summary>
  public List<string> Styles() {
    var names = new List<string>();
    WireReader list = Ask(Request().Message(3, new byte[0])).List;
    while (list != null && list.Next()) {
      if (list.Field != 1) {
        list.Skip();
        continue;
      }
      WireReader style = list.Message();
      while (style.Next()) {
        if (style.Field == 1) names.Add(style.Text());
        else style.Skip();
      }
    }
    return names;
  }

  /// <summary>`style` alone, with `strength` 0 to 1.5; null keeps the strength, or the fade's
  /// milliseconds.</summary>
  public Dictionary<string, ulong> SetStyle(string performer, string style, float? strength = null,
                                            float? transitionMs = null) {
    if (style == null) throw new ArgumentException("SetStyle: no style, expected its name");
    var look = new WireWriter().Message(1, new WireWriter().Text(1, style).Float(2, 1).Bytes);
    if (strength != null) look.Float(2, strength.Value);
    if (transitionMs != null) look.Float(3, transitionMs.Value);
    return Ask(Request(performer).Message(4, look.Bytes)).Applied;
  }

  /// <summary>Fades to bypass: the performer as captured.</summary>
  public Dictionary<string, ulong> Clear(string performer = "*") {
    return Ask(Request(performer).Message(4, new WireWriter().Number(5, 1).Bytes)).Applied;
  }

  /// <summary>Sets all performers to bypass, pinned or not.</summary>
  public Dictionary<string, ulong> Panic() { return Ask(Request("*").Message(6, new byte[0])).Applied; }

  sealed class Reply {
    public ulong Id;
    public int Code;
    public string Reason = "";
    public WireReader List;
    public readonly Dictionary<string, ulong> Applied = new Dictionary<string, ulong>();
    public readonly List<string> Absent = new List<string>(), NoStrength = new List<string>();
    public readonly Dictionary<string, string> NotChanged = new Dictionary<string, string>();
  }

  WireWriter Request() { return new WireWriter().Number(1, ++id_); }

  WireWriter Request(string performer) {
    if (performer != "*" && (performer == null || !Inbox.IsPerformerId(performer))) {
      throw new ArgumentException("performer '" + performer + "' is not SOURCE.NAME ([A-Za-z0-9_-]{1,32} each) or '*'");
    }
    return Request().Text(2, performer);
  }

  Reply Ask(WireWriter request) {
    Stopwatch clock = Stopwatch.StartNew();
    // The envelope of a REQ socket, which every ROUTER accepts.
    bool sent = socket_.Send(new byte[0], true) && socket_.Send(request.Bytes, false);
    var parts = new List<byte[]>();
    while (sent && socket_.Receive(parts, (int)Math.Max(0, timeout_ms_ - clock.ElapsedMilliseconds))) {
      Reply reply = Parse(parts[parts.Count - 1]);
      // A daemon that could not parse the request replies with id 0.
      if (reply.Id != id_ && (reply.Id != 0 || reply.Code == 0)) continue;
      Absent = reply.Absent;
      NoStrength = reply.NoStrength;
      NotChanged = reply.NotChanged;
      if (reply.Code != 0) throw new RefusedException(reply.Code, reply.Reason);
      return reply;
    }
    // A new socket discards replies that were still on their way to the old one.
    socket_.Dispose();
    Open();
    throw new TimeoutException("no daemon answers at " + endpoint_ + " within " + timeout_ms_ + " ms");
  }

  static Reply Parse(byte[] bytes) {
    var reply = new Reply();
    var reader = new WireReader(bytes);
    while (reader.Next()) {
      if (reader.Field == 1) reply.Id = reader.Number();
      else if (reader.Field == 2) reply.Code = (int)reader.Number();
      else if (reader.Field == 3) reply.Reason = reader.Text();
      else if (reader.Field == 4) ParseApplied(reader.Message(), reply);
      else if (reader.Field == 5) reply.List = reader.Message();
      else reader.Skip();
    }
    return reply;
  }

  static void ParseApplied(WireReader reader, Reply into) {
    string performer = "", refused = "";
    ulong sequence = 0, absent = 0, noStrength = 0;
    while (reader.Next()) {
      if (reader.Field == 1) performer = reader.Text();
      else if (reader.Field == 2) sequence = reader.Number();
      else if (reader.Field == 3) absent = reader.Number();
      else if (reader.Field == 4) noStrength = reader.Number();
      else if (reader.Field == 6) refused = reader.Text();
      else reader.Skip();
    }
    if (refused != "") {
      into.NotChanged[performer] = refused;
      return;
    }
    into.Applied[performer] = sequence;
    if (absent != 0) into.Absent.Add(performer);
    if (noStrength != 0) into.NoStrength.Add(performer);
  }

  void Open() {
    socket_ = new ZmqSocket(Zmq.Dealer, MaxReplyBytes);
    try {
      socket_.Set(Zmq.ReconnectIvl, 50);
      socket_.Set(Zmq.SndTimeO, 0);
      socket_.Use(curve_);
      socket_.Connect(endpoint_);
    } catch {
      socket_.Dispose();
      throw;
    }
  }
}

}  // namespace Styled
