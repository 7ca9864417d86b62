// A complete subscriber without Unity: sets a style for all performers, then prints the position of each
// performer's head.
using System;
using System.Globalization;
using Styled;

static class Heads {
  const string Usage = "usage: heads [PUBLISHER [CONTROL [STYLE [FRAMES]]]]";

  static int Main(string[] arguments) {
    if (Array.Exists(arguments, a => a == "--help" || a == "-h")) {
      Console.WriteLine(Usage + "\n  PUBLISHER  default: " + Subscriber.DefaultEndpoint + "\n  CONTROL    default: " +
                        Control.DefaultEndpoint + "\n  STYLE      default: old\n  FRAMES     number of frames to show; default: no limit");
      return 0;
    }
    try {
      Func<int, string, string> argument = (i, usual) => arguments.Length > i ? arguments[i] : usual;
      ulong enough;
      if (arguments.Length > 4) throw new ArgumentException("'" + arguments[4] + "' is one argument too many");
      if (!ulong.TryParse(argument(3, "0"), NumberStyles.None, CultureInfo.InvariantCulture, out enough)) {
        throw new ArgumentException("FRAMES is '" + arguments[3] + "', expected a whole number");
      }
      using (var control = new Control(argument(1, Control.DefaultEndpoint)))
      using (var subscriber = new Subscriber(argument(0, Subscriber.DefaultEndpoint), streams: new[] { "canonical" })) {
        SetStyle(control, argument(2, "old"));
        Print(subscriber, enough);
      }
      return 0;
    } catch (Exception error) when (error is ArgumentException || error is DllNotFoundException) {
      bool library = error is DllNotFoundException;
      Console.Error.WriteLine("heads: " + (library ? "libzmq is missing (apt install libzmq5): " : "") + error.Message);
      if (!library) Console.Error.WriteLine(Usage);
      return 2;
    }
  }

  static void SetStyle(Control control, string style) {
    try {
      control.SetStyle("*", style, 0.8f);
    } catch (Exception error) when (error is RefusedException || error is TimeoutException || error is FormatException) {
      Console.Error.WriteLine("style not set: " + error.Message);
    }
  }

  static void Print(Subscriber subscriber, ulong enough) {  // 0: without end
    for (ulong frames = 0; enough == 0 || frames < enough;) {
      Update update = subscriber.Receive(5000);
      if (update == null) break;
      if (update.Frame == null || update.Body == null) continue;
      float[] positions = Kinematics.World(update.Body, update.Frame).Positions;
      int head = 3 * update.Body.IndexOf("head");
      Console.WriteLine(string.Format(CultureInfo.InvariantCulture, "{0} {1:0.00} {2:0.00} {3:0.00} m",
          update.Performer, positions[head], positions[head + 1], positions[head + 2]));
      ++frames;
    }
    Console.Error.WriteLine(subscriber.Counters.Frames + " frames, " + subscriber.Counters.Missed + " missed");
  }
}
