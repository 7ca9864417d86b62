// The few calls of libzmq (4.2 or later) that the clients need.
using System;
using System.Collections.Generic;
using System.Globalization;
using System.Runtime.InteropServices;
using System.Text;
using System.Text.RegularExpressions;

namespace Styled {

static class Zmq {
  // With the library's plain name: for Unity's plugins on Windows and macOS, and for builds that
  // define STYLED_LIBZMQ. Debian's package has the other name.
#if UNITY_EDITOR_WIN || UNITY_STANDALONE_WIN || UNITY_EDITOR_OSX || UNITY_STANDALONE_OSX || STYLED_LIBZMQ
  const string Library = "libzmq";
#else
  const string Library = "libzmq.so.5";
#endif
  public const int Sub = 2, Dealer = 5;
  public const int Subscribe = 6, Linger = 17, ReconnectIvl = 18, ReconnectIvlMax = 21, MaxMsgSize = 22,
      RcvHwm = 24, RcvTimeO = 27, SndTimeO = 28, Ipv6 = 42, CurvePublicKey = 48, CurveSecretKey = 49,
      CurveServerKey = 50, HandshakeIvl = 66, HeartbeatIvl = 75, HeartbeatTimeout = 77;
  public const int SendMore = 2;

  [DllImport(Library)] public static extern IntPtr zmq_ctx_new();
  [DllImport(Library)] public static extern int zmq_ctx_term(IntPtr context);
  [DllImport(Library)] public static extern IntPtr zmq_socket(IntPtr context, int type);
  [DllImport(Library)] public static extern int zmq_close(IntPtr socket);
  [DllImport(Library)] public static extern int zmq_setsockopt(IntPtr socket, int option, byte[] value, UIntPtr size);
  [DllImport(Library)] public static extern int zmq_connect(IntPtr socket, byte[] endpoint);
  [DllImport(Library)] public static extern int zmq_send(IntPtr socket, byte[] bytes, UIntPtr size, int flags);
  [DllImport(Library)] public static extern int zmq_msg_init(IntPtr message);
  [DllImport(Library)] public static extern int zmq_msg_recv(IntPtr message, IntPtr socket, int flags);
  [DllImport(Library)] public static extern IntPtr zmq_msg_data(IntPtr message);
  [DllImport(Library)] public static extern UIntPtr zmq_msg_size(IntPtr message);
  [DllImport(Library)] public static extern int zmq_msg_more(IntPtr message);
  [DllImport(Library)] public static extern int zmq_msg_close(IntPtr message);
  [DllImport(Library)] public static extern int zmq_curve_keypair(byte[] publicKey, byte[] secretKey);
}

/// <summary>Keys of ZeroMQ's CURVE, for daemons that are reached over a network: 40 characters of Z85.
/// Without a pair, a new one is generated.</summary>
public sealed class Curve {
  public string ServerKey, PublicKey, SecretKey;
}

/// <summary>One socket with a context of its own. One thread at a time; the finalizer closes
/// unreferenced sockets.</summary>
sealed class ZmqSocket : IDisposable {
  readonly IntPtr message_ = Marshal.AllocHGlobal(128);  // a zmq_msg_t has 64 bytes
  IntPtr context_, socket_;
  int timeout_ms_ = int.MinValue;

  public ZmqSocket(int type, long max_bytes) {
    context_ = Zmq.zmq_ctx_new();
    socket_ = Zmq.zmq_socket(context_, type);
    if (socket_ == IntPtr.Zero) throw new InvalidOperationException("ZeroMQ has no socket left");
    Set(Zmq.Linger, 0);
    Set(Zmq.HandshakeIvl, 1000);
    SetBytes(Zmq.MaxMsgSize, BitConverter.GetBytes(max_bytes));
  }

  ~ZmqSocket() { Close(); }

  public void Dispose() {
    Close();
    GC.SuppressFinalize(this);
  }

  public void Set(int option, int value) { SetBytes(option, BitConverter.GetBytes(value)); }

  public void SetBytes(int option, byte[] value) {
    CheckOpen();
    if (Zmq.zmq_setsockopt(socket_, option, value, (UIntPtr)value.Length) != 0) {
      throw new ArgumentException("ZeroMQ refuses a value of option " + option);
    }
  }

  public void Use(Curve curve) {
    if (curve == null) return;
    if ((curve.PublicKey == null) != (curve.SecretKey == null)) {
      throw new ArgumentException("curve: one key of the own pair is missing, expected both or none");
    }
    byte[] publicKey = new byte[41], secretKey = new byte[41];
    if (curve.PublicKey == null) {
      Zmq.zmq_curve_keypair(publicKey, secretKey);
    } else {
      publicKey = Key("PublicKey", curve.PublicKey);
      secretKey = Key("SecretKey", curve.SecretKey);
    }
    SetBytes(Zmq.CurveServerKey, Key("ServerKey", curve.ServerKey));
    SetBytes(Zmq.CurvePublicKey, publicKey);
    SetBytes(Zmq.CurveSecretKey, secretKey);
  }

  public void Connect(string endpoint) {
    CheckOpen();
    bool known = endpoint != null && IsEndpoint(endpoint);
    if (known && endpoint.Contains("[")) Set(Zmq.Ipv6, 1);
    if (!known || Zmq.zmq_connect(socket_, Encoding.UTF8.GetBytes(endpoint + "\0")) != 0) {
      throw new ArgumentException("cannot connect to '" + endpoint + "', expected e.g. tcp://127.0.0.1:7001 or ipc://PATH");
    }
  }

  static bool IsEndpoint(string text) {
    Match tcp = Regex.Match(text, @"\Atcp://(\S+;)?(\[[^]\s]+\]|[^\s/:*]+):([0-9]{1,5})\z");
    int port = tcp.Success ? int.Parse(tcp.Groups[3].Value, CultureInfo.InvariantCulture) : 0;
    return (port > 0 && port < 65536) || Regex.IsMatch(text, @"\Aipc://.+\z");
  }

  public bool Send(byte[] bytes, bool more) {
    CheckOpen();
    return Zmq.zmq_send(socket_, bytes, (UIntPtr)bytes.Length, more ? Zmq.SendMore : 0) >= 0;
  }

  /// <summary>Waits up to `timeout_ms` (0: not at all) for a message; false: none
  /// arrived.</summary>
  public bool Receive(List<byte[]> parts, int timeout_ms) {
    CheckOpen();
    parts.Clear();
    if (timeout_ms != timeout_ms_) Set(Zmq.RcvTimeO, timeout_ms_ = timeout_ms);
    for (bool more = true; more;) {
      Zmq.zmq_msg_init(message_);
      if (Zmq.zmq_msg_recv(message_, socket_, 0) < 0) {
        Zmq.zmq_msg_close(message_);
        return false;
      }
      var part = new byte[(int)Zmq.zmq_msg_size(message_).ToUInt64()];
      if (part.Length > 0) Marshal.Copy(Zmq.zmq_msg_data(message_), part, 0, part.Length);
      more = Zmq.zmq_msg_more(message_) != 0;
      Zmq.zmq_msg_close(message_);
      parts.Add(part);
    }
    return true;
  }

  static byte[] Key(string name, string key) {
    if (key == null || key.Length != 40) {
      throw new ArgumentException("curve: " + name + " has " + (key == null ? 0 : key.Length) +
                                  " characters, expected 40 of Z85");
    }
    return Encoding.ASCII.GetBytes(key + "\0");
  }

  void CheckOpen() {
    if (socket_ == IntPtr.Zero) throw new ObjectDisposedException("the socket");
  }

  void Close() {
    if (context_ == IntPtr.Zero) return;
    if (socket_ != IntPtr.Zero) Zmq.zmq_close(socket_);
    Zmq.zmq_ctx_term(context_);
    Marshal.FreeHGlobal(message_);
    socket_ = context_ = IntPtr.Zero;
  }
}

}  // namespace Styled
