// A complete subscriber without Unity: sets a style for all performers, then prints the position of each
// performer's head: heads [PUBLISHER [CONTROL [STYLE [FRAMES]]]]
using System;
using System.Globalization;
using Styled;

static class Heads {
  static int Main(string[] arguments) {
    Func<int, string, string> argument = (i, usual) => arguments.Length > i ? arguments[i] : usual;
    ulong enough = ulong.Parse(argument(3, "0"));  // 0: never
    try {
      using (var control = new Control(argument(1, Control.DefaultEndpoint))) {
        control.SetStyle("*", argument(2, "old"), 0.8f);
      }
    } catch (Exception error) when (error is RefusedException || error is TimeoutException) {
      Console.Error.WriteLine("style not set: " + error.Message);
    }
    using (var subscriber = new Subscriber(argument(0, Subscriber.DefaultEndpoint), streams: new[] { "canonical" })) {
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
    return 0;
  }
}
