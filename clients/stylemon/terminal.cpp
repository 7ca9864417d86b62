#include "clients/stylemon/terminal.h"

#include <curses.h>

#include <array>
#include <cstdio>
#include <cstdlib>
#include <utility>

namespace styled::stylemon {
namespace {

struct Look {
  short colour;
  attr_t attributes;
};

// Indexed by Ink. -1: the terminal's default colour.
constexpr std::array<Look, static_cast<std::size_t>(Ink::kInkCount)> kLooks{{
    {-1, A_NORMAL},            // kPlain
    {-1, A_DIM},               // kDim
    {-1, A_BOLD},              // kTitle
    {-1, A_BOLD},              // kCentre
    {COLOR_CYAN, A_NORMAL},    // kLeft
    {COLOR_YELLOW, A_BOLD},    // kRight
    {-1, A_DIM},               // kFloor
    {COLOR_GREEN, A_BOLD},     // kContact
    {COLOR_GREEN, A_NORMAL},   // kGood
    {COLOR_YELLOW, A_NORMAL},  // kWarn
    {COLOR_RED, A_BOLD},       // kBad
}};

}  // namespace

struct Terminal::Impl {
  SCREEN* screen = nullptr;
  bool colours = false;
};

Terminal::Terminal(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}

Result<std::unique_ptr<Terminal>> Terminal::Open() {
  SCREEN* screen = newterm(nullptr, stdout, stdin);
  if (screen == nullptr) {
    const char* name = std::getenv("TERM");
    return Status::Error(
        std::string("TERM is '") + (name == nullptr ? "" : name) +
        "', a terminal that curses does not know; expected e.g. xterm, or --plain");
  }
  auto impl = std::make_unique<Impl>();
  impl->screen = screen;
  cbreak();
  noecho();
  curs_set(0);
  keypad(stdscr, TRUE);
  nodelay(stdscr, TRUE);
  set_escdelay(25);
  if (has_colors() && start_color() == OK) {
    use_default_colors();
    for (std::size_t ink = 0; ink < kLooks.size(); ++ink) {
      init_pair(static_cast<short>(ink + 1), kLooks[ink].colour, -1);
    }
    impl->colours = true;
  }
  return std::unique_ptr<Terminal>(new Terminal(std::move(impl)));
}

Terminal::~Terminal() {
  endwin();
  delscreen(impl_->screen);
}

int Terminal::columns() const { return getmaxx(stdscr); }
int Terminal::rows() const { return getmaxy(stdscr); }

void Terminal::Show(const Canvas& canvas) {
  for (int row = 0; row < canvas.rows(); ++row) {
    for (int column = 0; column < canvas.columns(); ++column) {
      const Cell cell = canvas.At(column, row);
      const auto ink = static_cast<std::size_t>(cell.ink);
      const std::array<wchar_t, 2> text{static_cast<wchar_t>(cell.glyph), 0};
      cchar_t glyph{};
      setcchar(&glyph, text.data(), kLooks[ink].attributes,
               impl_->colours ? static_cast<short>(ink + 1) : short{0}, nullptr);
      mvadd_wch(row, column, &glyph);
    }
  }
  refresh();
}

int Terminal::Read() {
  switch (const int key = getch(); key) {
    case ERR:
      return -1;
    case KEY_UP:
      return kUp;
    case KEY_DOWN:
      return kDown;
    case KEY_LEFT:
      return kLeft;
    case KEY_RIGHT:
      return kRight;
    case KEY_BTAB:
      return kBackTab;
    case KEY_RESIZE:
      clear();
      return 0;
    default:
      return key < 256 ? key : 0;
  }
}

}  // namespace styled::stylemon
