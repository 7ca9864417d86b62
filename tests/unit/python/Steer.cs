// Sets styles from the command line: steer CONTROL PERFORMER..., and prints the reply for each.
using System;
using System.Linq;
using Styled;

static class Steer {
  static void Main(string[] arguments) {
    using (var control = new Control(arguments[0])) {
      for (int i = 1; i < arguments.Length; ++i) {
        string said = string.Join(",", control.SetStyle(arguments[i], "old").Keys);
        Console.WriteLine(said + " absent=" + string.Join(",", control.Absent) + " weak=" + string.Join(",", control.NoStrength) +
                          string.Concat(control.NotChanged.Select(one => " kept=" + one.Key + " (" + one.Value + ")")));
      }
      try {
        control.SetStyle("stage.refused", "old");
      } catch (RefusedException error) {
        Console.WriteLine(error.Message + " absent=" + control.Absent.Count);
      }
    }
  }
}
