// libstyled, the stylizer in this process: no daemon and no socket. Plain C#; its functions, their ranges and threads
// are in model/library/styled.h.
using System;
using System.Collections.Generic;
using System.Runtime.InteropServices;
using System.Text;

namespace Styled {

static class Native {
  // With the library's plain name for Unity's plugins.
#if UNITY_5_3_OR_NEWER
  const string Library = "styled";
#else
  const string Library = "libstyled.so.0";
#endif
  [StructLayout(LayoutKind.Sequential)]
  public struct Body {
    public UIntPtr size;
    public int jointCount;
    public IntPtr names, parents, offsets, rest, dialect, joints;
  }

  [DllImport(Library)] public static extern IntPtr styled_version();
  [DllImport(Library)] public static extern IntPtr styled_load(byte[] weights, byte[] precision, byte[] error, UIntPtr size);
  [DllImport(Library)] public static extern void styled_release(IntPtr network);
  [DllImport(Library)] public static extern int styled_style_count(IntPtr network);
  [DllImport(Library)] public static extern IntPtr styled_style_name(IntPtr network, int style);
  [DllImport(Library)] public static extern IntPtr styled_style_licence(IntPtr network, int style);
  [DllImport(Library)] public static extern int styled_find_style(IntPtr network, byte[] name);
  [DllImport(Library)] public static extern IntPtr styled_create(IntPtr network, ref Body body, byte[] error, UIntPtr size);
  [DllImport(Library)] public static extern void styled_destroy(IntPtr performer);
  [DllImport(Library)] public static extern int styled_set(IntPtr performer, int[] styles, float[] weights, int count, float seconds);
  [DllImport(Library)] public static extern int styled_frame(IntPtr performer, long time_ns, float[] root, float[] rotations,
                                                             float[] styledRoot, float[] styledRotations, out uint flags);
  [DllImport(Library)] public static extern int styled_reset(IntPtr performer);
  [DllImport(Library)] public static extern int styled_calibrate(IntPtr performer, float seconds);

  public static byte[] Utf8(string text) { return text == null ? null : Encoding.UTF8.GetBytes(text + "\0"); }

  public static string Text(byte[] utf8) {
    int end = Array.IndexOf(utf8, (byte)0);
    return Encoding.UTF8.GetString(utf8, 0, end < 0 ? utf8.Length : end);
  }

  public static string Text(IntPtr utf8) {
    if (utf8 == IntPtr.Zero) return "";
    int length = 0;
    while (Marshal.ReadByte(utf8, length) != 0) ++length;
    var bytes = new byte[length];
    Marshal.Copy(utf8, bytes, 0, length);
    return Encoding.UTF8.GetString(bytes);
  }
}

/// <summary>Weights, loaded once for all performers. All threads.</summary>
public sealed class Network : IDisposable {
  IntPtr handle_;

  /// <summary>`weights`: a path, the name of shipped ones ("v2", "open"), or null: STYLED_WEIGHTS, else v2.</summary>
  public Network(string weights = null, string precision = "int8") {
    var error = new byte[512];
    handle_ = Native.styled_load(Native.Utf8(weights), Native.Utf8(precision), error, (UIntPtr)error.Length);
    if (handle_ == IntPtr.Zero) throw new ArgumentException(Native.Text(error));
    var styles = new List<string>();
    for (int i = 0; i < Native.styled_style_count(handle_); ++i) styles.Add(Native.Text(Native.styled_style_name(handle_, i)));
    Styles = styles;
  }

  // Without a handle the library itself may be missing, and an exception here would end the program.
  ~Network() {
    if (handle_ != IntPtr.Zero) Native.styled_release(handle_);
  }

  public void Dispose() {
    Native.styled_release(handle_);
    handle_ = IntPtr.Zero;
    GC.SuppressFinalize(this);
  }

  public static string Version { get { return Native.Text(Native.styled_version()); } }
  public IList<string> Styles { get; private set; }

  /// <summary>The terms under which a style may be used.</summary>
  public string Licence(string style) { return Native.Text(Native.styled_style_licence(Handle, Find(style))); }

  internal IntPtr Handle {
    get {
      if (handle_ == IntPtr.Zero) throw new ObjectDisposedException("the network");
      return handle_;
    }
  }

  internal int Find(string style) {
    int found = style == null ? -1 : Native.styled_find_style(Handle, Native.Utf8(style));
    if (found >= 0) return found;
    throw new ArgumentException("unknown style '" + style + "', expected one of " + string.Join(", ", Styles));
  }
}

/// <summary>One stream of poses of one skeleton, restyled frame by frame. One thread at a time. Right-handed axes;
/// rotations are x, y, z, w, relative to the parent.</summary>
public sealed class Performer : IDisposable {
  readonly Network network_;
  readonly int joints_;
  readonly int[] style_ = new int[1];
  readonly float[] weight_ = new float[1];
  IntPtr handle_;

  /// <summary>`parents` come before their children, -1 for joint 0; `offsets` has three numbers a joint. `rest`, four a
  /// joint, are world rotations in the T-pose; null: the names tell.</summary>
  public Performer(Network network, string[] names, int[] parents, float[] offsets, float[] rest = null) {
    if (parents.Length != names.Length || offsets.Length != 3 * names.Length ||
        (rest != null && rest.Length != 4 * names.Length)) {
      throw new ArgumentException("expected a parent, 3 offsets and 4 numbers of rest for each name");
    }
    network_ = network;
    joints_ = names.Length;
    var pins = new List<GCHandle>();
    var error = new byte[512];
    try {
      var texts = new IntPtr[names.Length];
      for (int i = 0; i < names.Length; ++i) texts[i] = Pin(Native.Utf8(names[i]), pins);
      var body = new Native.Body {
        size = (UIntPtr)Marshal.SizeOf(typeof(Native.Body)), jointCount = joints_, names = Pin(texts, pins),
        parents = Pin(parents, pins), offsets = Pin(offsets, pins), rest = Pin(rest, pins)
      };
      handle_ = Native.styled_create(network.Handle, ref body, error, (UIntPtr)error.Length);
    } finally {
      foreach (GCHandle pin in pins) pin.Free();
    }
    if (handle_ == IntPtr.Zero) throw new ArgumentException(Native.Text(error));
  }

  ~Performer() {
    if (handle_ != IntPtr.Zero) Native.styled_destroy(handle_);
  }

  public void Dispose() {
    Native.styled_destroy(handle_);
    handle_ = IntPtr.Zero;
    GC.SuppressFinalize(this);
  }

  /// <summary>From the next frame on, faded in; "neutral" or a weight of 0: the performer's own motion.</summary>
  public void Set(string style, float weight = 1, float transitionSeconds = 0.1f) {
    style_[0] = network_.Find(style);
    weight_[0] = weight;
    int count = style_[0] == 0 ? 0 : 1;
    if (Native.styled_set(Open(), style_, weight_, count, transitionSeconds) != 0) {
      throw new ArgumentException("found weight " + weight + " and transition " + transitionSeconds +
                                  " s, expected 0 to 1.5 and 0 to 60 s");
    }
  }

  /// <summary>Restyles a frame in place; allocates nothing. False: its time is not after the last frame's.</summary>
  public bool Frame(long time_ns, float[] root, float[] rotations) {
    if (root.Length != 3 || rotations.Length != 4 * joints_) {
      throw new ArgumentException("expected 3 numbers of root and " + 4 * joints_ + " of rotations");
    }
    uint flags;
    return Native.styled_frame(Open(), time_ns, root, rotations, root, rotations, out flags) == 0;
  }

  /// <summary>Before another take: the next frame's time may be anything.</summary>
  public void Reset() { Native.styled_reset(Open()); }

  /// <summary>For 1 to 60 s from now on the performer stands and walks in their own way; 0 forgets that.</summary>
  public void Calibrate(float seconds) {
    if (Native.styled_calibrate(Open(), seconds) != 0) {
      throw new ArgumentException("found " + seconds + " s, expected 0, or 1 to 60");
    }
  }

  IntPtr Open() {
    if (handle_ == IntPtr.Zero) throw new ObjectDisposedException("the performer");
    return handle_;
  }

  static IntPtr Pin(object array, List<GCHandle> pins) {
    if (array == null) return IntPtr.Zero;
    pins.Add(GCHandle.Alloc(array, GCHandleType.Pinned));
    return pins[pins.Count - 1].AddrOfPinnedObject();
  }
}

}  // namespace Styled
