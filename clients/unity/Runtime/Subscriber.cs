using System;
using System.Collections.Generic;
using System.Diagnostics;
using System.Text;

namespace Styled {

/// <summary>Subscribes to a daemon. Connects in the background, and reconnects whenever the daemon
/// returns, while it is being read. Frames arrive as published, in order per stream; gaps are counted.
/// One thread at a time; Dispose it.</summary>
public sealed class Subscriber : IDisposable {
  public const string DefaultEndpoint = "tcp://127.0.0.1:7001";
  const long MaxMessageBytes = 1 << 20;  // a body of 1024 long names fits
  const int MaxDrain = 10000;            // limit of messages per Latest

  readonly Inbox inbox_;
  readonly ZmqSocket socket_;
  readonly List<byte[]> parts_ = new List<byte[]>();

  /// <summary>`performer`: SOURCE.NAME, or "" for all, including later ones. `streams`: "rig",
  /// "canonical", "source" or the name of an [[output]]. Throws ArgumentException; a missing daemon is
  /// not an error.</summary>
  public Subscriber(string endpoint = DefaultEndpoint, string performer = "", string[] streams = null,
                    int queueMessages = 1000, Curve curve = null) {
    inbox_ = new Inbox(performer, streams ?? new[] { "canonical" });
    if (queueMessages < 1) throw new ArgumentException("queueMessages is " + queueMessages + ", expected 1 or more");
    socket_ = new ZmqSocket(Zmq.Sub, MaxMessageBytes);
    try {
      socket_.Set(Zmq.RcvHwm, queueMessages);
      socket_.Set(Zmq.ReconnectIvl, 100);
      socket_.Set(Zmq.ReconnectIvlMax, 1000);
      socket_.Set(Zmq.HeartbeatIvl, 1000);  // also detects an unplugged cable
      socket_.Set(Zmq.HeartbeatTimeout, 3000);
      socket_.Use(curve);
      SubscribeTo(inbox_.Topics());
      socket_.Connect(endpoint);
    } catch {
      socket_.Dispose();
      throw;
    }
  }

  public void Dispose() { socket_.Dispose(); }

  public Counters Counters { get { return inbox_.Counters; } }

  /// <summary>Ids of the performers whose bodies were seen.</summary>
  public ICollection<string> Performers { get { return inbox_.Performers; } }

  /// <summary>Every frame, for recorders: the next update, or null if none arrives within `timeoutMs` (0:
  /// only updates that have already arrived).</summary>
  public Update Receive(int timeoutMs) {
    Stopwatch clock = Stopwatch.StartNew();
    for (;;) {
      int left = (int)Math.Max(0, timeoutMs - clock.ElapsedMilliseconds);
      if (!socket_.Receive(parts_, left)) return null;
      Update update = inbox_.Accept(parts_);
      SubscribeTo(inbox_.NewTopics);
      inbox_.NewTopics.Clear();
      if (update != null) return update;
    }
  }

  /// <summary>The newest frame of each performer and stream, for renderers: reads the waiting messages and
  /// does not block. `into` is cleared first, and gets frames whose body has arrived, in no
  /// order.</summary>
  public void Latest(List<Update> into) {
    into.Clear();
    for (int i = 0; i < MaxDrain; ++i) {
      Update update = Receive(0);
      if (update == null) return;
      if (update.Frame == null || update.Body == null) continue;
      int older = into.FindIndex(u => u.Stream == update.Stream && u.Performer == update.Performer);
      if (older < 0) {
        into.Add(update);
        continue;
      }
      update.Missed += into[older].Missed;
      update.Skipped = into[older].Skipped + 1;
      update.NewEpoch |= into[older].NewEpoch;
      into[older] = update;
    }
  }

  void SubscribeTo(List<string> topics) {
    foreach (string topic in topics) socket_.SetBytes(Zmq.Subscribe, Encoding.ASCII.GetBytes(topic));
  }
}

}  // namespace Styled
