// stylemon: input and styled figures of one performer, drawn live in the terminal.
#include <langinfo.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <atomic>
#include <clocale>
#include <csignal>
#include <cstdio>

#include "clients/cpp/key_options.h"
#include "clients/stylemon/monitor.h"
#include "clients/stylemon/terminal.h"
#include "model/base/version.h"

namespace {

using namespace styled::stylemon;  // NOLINT
using Clock = std::chrono::steady_clock;
using std::chrono::milliseconds;

constexpr int kExitUsage = 2;
constexpr int kExitNothing = 3;  // with --seconds: no styled frame arrived in that time
constexpr milliseconds kPicture(33);

std::atomic<bool> stopped = false;

struct Arguments {
  MonitorOptions monitor;
  styled::client::KeyOptions keys;
  bool plain = false, ascii = false, front = false;
  int every_ms = 500, columns = 72, rows = 20;
  double seconds = 0;
};

// Returns false to end the program.
bool PressKey(int key, Monitor& monitor) {
  if (key >= '1' && key <= '9') return monitor.PressStyle(key - '0'), true;
  switch (key) {
    case 'q':
    case 'Q':
      return false;
    case '\t':
    case Terminal::kDown:
    case Terminal::kRight:
      monitor.Press(Key::kNextPerformer);
      break;
    case Terminal::kUp:
    case Terminal::kLeft:
    case Terminal::kBackTab:
      monitor.Press(Key::kPreviousPerformer);
      break;
    case 'n':
      monitor.Press(Key::kMoreStyles);
      break;
    case 's':
      monitor.Press(Key::kSide);
      break;
    case ' ':
      monitor.Press(Key::kPause);
      break;
    case '0':
      monitor.Press(Key::kClear);
      break;
    case '+':
    case '=':
      monitor.Press(Key::kStronger);
      break;
    case '-':
    case '_':
      monitor.Press(Key::kWeaker);
      break;
    default:
      break;
  }
  return true;
}

void RunScreen(Monitor& monitor, Terminal& terminal, bool utf8, Clock::time_point end) {
  while (!stopped && Clock::now() < end) {
    for (int key = terminal.Read(); key != -1; key = terminal.Read()) {
      if (!PressKey(key, monitor)) return;
    }
    monitor.Listen(kPicture);
    Canvas canvas(terminal.columns(), terminal.rows(), utf8);
    DrawScreen(monitor.view(), canvas);
    terminal.Show(canvas);
  }
}

void RunPlain(Monitor& monitor, const Arguments& arguments, bool utf8, Clock::time_point end) {
  while (!stopped && Clock::now() < end) {
    const auto picture = Clock::now() + milliseconds(arguments.every_ms);
    while (!stopped && Clock::now() < std::min(picture, end)) monitor.Listen(milliseconds(20));
    const View& view = monitor.view();
    if (view.styled.here) {
      Canvas canvas(arguments.columns, arguments.rows, utf8);
      DrawFigures(view, 0, 0, arguments.columns, arguments.rows, canvas);
      for (int row = 0; row < canvas.rows(); ++row) std::puts(canvas.RowText(row).c_str());
    }
    std::puts(StatusLine(view).c_str());
    if (std::fflush(stdout) != 0) return;  // the reader has closed the pipe
  }
}

void Declare(CLI::App& app, Arguments& arguments) {
  app.set_version_flag("--version", styled::VersionText("stylemon"));
  app.add_option("--publisher,--endpoint", arguments.monitor.publisher,
                 "the publisher of the frames; for a pair with a standby both, with a comma")
      ->envname("STYLED_PUBLISHER")
      ->capture_default_str();
  app.add_option("--control", arguments.monitor.control, "the control socket, for setting styles")
      ->envname("STYLED_CONTROL")
      ->capture_default_str();
  styled::client::Declare(app, arguments.keys);
  app.add_option("--performer", arguments.monitor.performer, "SOURCE.NAME; default: the first");
  app.add_flag("--front", arguments.front, "begin with the front view");
  app.add_flag("--ascii", arguments.ascii, "no braille, whatever the locale");
  app.add_flag("--plain", arguments.plain, "print pictures one below the other, no curses");
  app.add_option("--every", arguments.every_ms, "with --plain: ms between pictures")
      ->check(CLI::Range(20, 3600000))
      ->capture_default_str();
  app.add_option("--columns", arguments.columns, "with --plain: width of a picture")
      ->check(CLI::Range(16, 500))
      ->capture_default_str();
  app.add_option("--rows", arguments.rows, "with --plain: height of a picture")
      ->check(CLI::Range(6, 200))
      ->capture_default_str();
  app.add_option("--seconds", arguments.seconds, "end by itself; 0 = never")
      ->check(CLI::Range(0.0, 1e9));
  app.footer(
      "Keys: q quit, Tab or arrows next performer, s side/front, space pause, 1-9 style,\n"
      "n the next nine styles, 0 bypass, +/- strength. Left limbs are cyan, right ones yellow; "
      "green: foot planted.\n"
      "Exit codes: 0, 2 usage, 3 with --seconds when no styled frame arrived.");
}

}  // namespace

int main(int argc, char** argv) {
  std::setlocale(LC_ALL, "");
  Arguments arguments;
  CLI::App app{"stylemon: input and styled motion, drawn live in the terminal", "stylemon"};
  Declare(app, arguments);
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    const int code = app.exit(error);
    return code == 0 ? 0 : kExitUsage;
  }
  if (arguments.front) arguments.monitor.side = Side::kFront;
  const bool utf8 = !arguments.ascii && std::string(nl_langinfo(CODESET)) == "UTF-8";
  struct sigaction action {};
  action.sa_handler = [](int) { stopped = true; };
  sigaction(SIGINT, &action, nullptr);
  sigaction(SIGTERM, &action, nullptr);
  std::signal(SIGPIPE, SIG_IGN);

  auto curve = styled::client::ReadKeys(arguments.keys);
  if (!curve.ok()) {
    std::fprintf(stderr, "stylemon: %s\n", curve.status().message().c_str());
    return kExitUsage;
  }
  arguments.monitor.curve = std::move(curve.value());
  auto monitor = Monitor::Start(arguments.monitor);
  if (!monitor.ok()) {
    std::fprintf(stderr, "stylemon: %s\n", monitor.status().message().c_str());
    return kExitUsage;
  }
  const auto end = arguments.seconds > 0
                       ? Clock::now() + milliseconds(static_cast<long>(arguments.seconds * 1000))
                       : Clock::time_point::max();
  if (arguments.plain || isatty(STDOUT_FILENO) == 0) {
    RunPlain(*monitor.value(), arguments, utf8, end);
  } else {
    auto terminal = Terminal::Open();
    if (!terminal.ok()) {
      std::fprintf(stderr, "stylemon: %s\n", terminal.status().message().c_str());
      return kExitUsage;
    }
    RunScreen(*monitor.value(), *terminal.value(), utf8, end);
  }
  return arguments.seconds > 0 && monitor.value()->frames() == 0 ? kExitNothing : 0;
}
