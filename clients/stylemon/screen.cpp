#include "clients/stylemon/screen.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>

namespace styled::stylemon {
namespace {

constexpr double kSilent_s = 1.0;  // a stream without frames for longer is shown as silent

std::string Fixed(double value, int decimals, int width = 0) {
  std::array<char, 64> text{};
  std::snprintf(text.data(), text.size(), "%*.*f", width, decimals, value);
  return text.data();
}

std::string Milliseconds(double p50, double p99) {
  if (!std::isfinite(p50)) return "-";
  return Fixed(p50, 2) + "/" + Fixed(p99, 2) + " ms";
}

std::string Selected(const View& view) {
  const bool is = view.selected >= 0 && view.selected < static_cast<int>(view.performers.size());
  return is ? view.performers[static_cast<std::size_t>(view.selected)].performer : std::string();
}

std::string Contacts(std::uint32_t contacts) {
  return std::string((contacts & 1U) != 0 ? "L" : "-") + ((contacts & 2U) != 0 ? "R" : "-");
}

void DrawOne(const View& view, const Figure& figure, const std::string& caption, bool contacts,
             const DotRect& area, Canvas& canvas) {
  const int column = area.left / 2, row = area.top / 4, columns = area.width / 2;
  canvas.Text(column + std::max(0, (columns - Width(caption)) / 2), row, caption, Ink::kTitle,
              columns);
  if (!figure.here) {
    const std::string text = "no frame";
    canvas.Text(column + std::max(0, (columns - Width(text)) / 2), row + area.height / 8, text,
                Ink::kDim, columns);
    return;
  }
  Pose pose;
  pose.anatomy = figure.anatomy.get();
  pose.joints = &figure.joints;
  pose.side = view.side;
  pose.yaw_rad = view.yaw_rad;
  pose.height = view.height;
  pose.floor = view.floor;
  pose.travel = view.travel;
  pose.contacts = contacts ? figure.frame.contacts() : 0;
  Draw(pose, {area.left, area.top + 4, area.width, area.height - 4}, canvas);
}

void DrawHeader(const View& view, Canvas& canvas) {
  canvas.Text(0, 0, "stylemon", Ink::kTitle);
  canvas.Text(10, 0, view.publisher, Ink::kPlain);
  const int column = 12 + Width(view.publisher);
  if (view.link == Link::kThere) {
    canvas.Text(column, 0, "connected", Ink::kGood);
  } else {
    canvas.Text(column, 0, view.link == Link::kLost ? "daemon away" : "no daemon yet", Ink::kBad);
  }
  if (view.paused) canvas.Text(column + 15, 0, "paused", Ink::kWarn);
  const char* right = view.side == Side::kSide ? "side view" : "front view";
  canvas.Text(canvas.columns() - Width(right), 0, right, Ink::kDim);
}

// Draws the list at the left, scrolled so that the selected performer is visible. Returns its
// width.
int DrawPerformers(const View& view, int row, int rows, Canvas& canvas) {
  int width = 10;
  for (const PerformerLine& line : view.performers) {
    width = std::max({width, Width(line.performer) + 2, std::min(24, Width(line.note) + 2)});
  }
  width = std::min(width, canvas.columns() / 4);
  if (width < 8) return 0;
  const int fit = std::max(1, rows / 2);
  const int count = static_cast<int>(view.performers.size());
  const int first = std::clamp(view.selected - fit / 2, 0, std::max(0, count - fit));
  for (int i = first; i < std::min(count, first + fit); ++i) {
    const PerformerLine& line = view.performers[static_cast<std::size_t>(i)];
    const bool selected = i == view.selected;
    const int at = row + 2 * (i - first);
    if (selected) canvas.Text(0, at, canvas.utf8() ? "▸" : ">", Ink::kTitle);
    canvas.Text(2, at, line.performer,
                selected    ? Ink::kTitle
                : line.live ? Ink::kPlain
                            : Ink::kDim,
                width - 2);
    canvas.Text(2, at + 1, line.live ? line.note : "silent", Ink::kDim, width - 2);
  }
  for (int i = row; i < row + rows; ++i) {
    canvas.Text(width, i, canvas.utf8() ? "│" : "|", Ink::kDim);
  }
  return width + 2;
}

void DrawNumbers(const View& view, int row, Canvas& canvas) {
  const Meter::Reading& reading = view.reading;
  const bool moving = reading.frames > 1;
  int column = 0;
  const auto put = [&](int line, const char* label, const std::string& value, Ink ink) {
    canvas.Text(column, row + line, label, Ink::kDim);
    column += Width(label) + 1;
    canvas.Text(column, row + line, value, ink);
    column += Width(value) + 3;
  };
  put(0, "rate", Fixed(reading.rate_hz, 1, 5) + " Hz", moving ? Ink::kPlain : Ink::kBad);
  put(0, "in daemon p50/p99", Milliseconds(reading.daemon_p50_ms, reading.daemon_p99_ms),
      Ink::kPlain);
  put(0, "to here", Milliseconds(reading.end_p50_ms, reading.end_p99_ms), Ink::kPlain);
  put(0, "dropped", std::to_string(reading.dropped),
      reading.dropped > 0 ? Ink::kWarn : Ink::kPlain);
  column = 0;
  if (!view.styled.here) return;
  const v1::Frame& frame = view.styled.frame;
  put(1, "style", StylesText(frame), frame.styles().empty() ? Ink::kPlain : Ink::kGood);
  if (!view.set.empty()) put(1, "set", view.set, Ink::kPlain);
  put(1, "contacts", Contacts(frame.contacts()), Ink::kContact);
  if (const std::string flags = FlagNames(frame.flags()); !flags.empty()) {
    put(1, "flags", flags, Ink::kWarn);
  }
}

void DrawKeys(const View& view, int row, Canvas& canvas) {
  std::string styles;
  for (std::size_t i = 0; i < kStyleKeys && view.first_style + i < view.styles.size(); ++i) {
    styles += std::to_string(i + 1) + " " + view.styles[view.first_style + i] + "  ";
  }
  if (view.styles.size() > kStyleKeys) styles += "n more  ";
  canvas.Text(0, row,
              styles.empty() ? "styles: control socket away" : styles + "0 bypass  +/- strength",
              Ink::kDim);
  canvas.Text(0, row + 1, "q quit  Tab next performer  s side/front  space pause", Ink::kDim);
  if (view.message.empty()) return;
  const int column = std::max(56, canvas.columns() - Width(view.message));
  canvas.Text(column, row + 1, view.message, view.message_bad ? Ink::kBad : Ink::kGood);
}

}  // namespace

std::string FlagNames(std::uint32_t flags) {
  constexpr std::array<std::pair<v1::Flag, const char*>, 10> kNames{{
      {v1::FLAG_CONCEALED, "concealed"},
      {v1::FLAG_STALE, "stale"},
      {v1::FLAG_LATE, "late"},
      {v1::FLAG_OUT_OF_DOMAIN, "out-of-domain"},
      {v1::FLAG_HELD, "held"},
      {v1::FLAG_BYPASS, "bypass"},
      {v1::FLAG_NEW_SESSION, "new-session"},
      {v1::FLAG_FADING, "fading"},
      {v1::FLAG_FAILED, "failed"},
      {v1::FLAG_BACKWARDS, "backwards"},
  }};
  std::string out;
  for (const auto& [flag, name] : kNames) {
    if ((flags & static_cast<std::uint32_t>(flag)) == 0) continue;
    out += (out.empty() ? "" : " ") + std::string(name);
  }
  return out;
}

std::string StylesText(const v1::Frame& frame) {
  std::string out;
  for (const auto& entry : frame.styles()) {
    out += (out.empty() ? "" : " + ") + entry.style() + " " + Fixed(entry.weight(), 2);
  }
  return out.empty() ? "bypass" : out;
}

std::string Trouble(const View& view) {
  if (view.link == Link::kNever) {
    return "no daemon answers at " + view.publisher + ": " +
           (view.obstacle.empty() ? "is styled running?" : view.obstacle) + " (--publisher)";
  }
  if (view.link == Link::kLost) {
    return "daemon away for " + Fixed(view.link_s, 0) + " s: reconnecting to " + view.publisher +
           (view.obstacle.empty() ? "" : "; " + view.obstacle);
  }
  if (view.performers.empty())
    return "connected, but no performer yet: is a rig, or stylesim, sending?";
  if (!view.styled.here) return Selected(view) + " sends nothing yet";
  if (view.styled.age_s > kSilent_s) {
    return Selected(view) + " silent for " + Fixed(view.styled.age_s, 0) + " s";
  }
  return "";
}

std::string StatusLine(const View& view) {
  if (std::string trouble = Trouble(view); !trouble.empty()) return trouble;
  const Meter::Reading& reading = view.reading;
  const v1::Frame& frame = view.styled.frame;
  const std::string flags = FlagNames(frame.flags());
  return Selected(view) + " #" + std::to_string(frame.sequence()) + "  " +
         Fixed(reading.rate_hz, 1) + " Hz" + "  daemon " +
         Milliseconds(reading.daemon_p50_ms, reading.daemon_p99_ms) + "  here " +
         Milliseconds(reading.end_p50_ms, reading.end_p99_ms) + "  dropped " +
         std::to_string(reading.dropped) + "  style " + StylesText(frame) + "  contacts " +
         Contacts(frame.contacts()) + (flags.empty() ? "" : "  flags " + flags);
}

void DrawFigures(const View& view, int column, int row, int columns, int rows, Canvas& canvas) {
  const int half = (columns - 1) / 2;
  if (half < 4 || rows < 4) return;
  const DotRect left{2 * column, 4 * row, 2 * half, 4 * rows};
  const DotRect right{2 * (column + half + 1), 4 * row, 2 * half, 4 * rows};
  DrawOne(view, view.input, "input", true, left, canvas);
  DrawOne(view, view.styled,
          view.styled.here ? "styled: " + StylesText(view.styled.frame) : "styled", true, right,
          canvas);
}

void DrawScreen(const View& view, Canvas& canvas) {
  const int rows = canvas.rows();
  DrawHeader(view, canvas);
  const bool small = rows < 16;  // then the figures get all rows
  const int bottom = small ? rows - 1 : rows - 5;
  const std::string trouble = Trouble(view);
  if (view.performers.empty()) {
    canvas.Text(std::max(0, (canvas.columns() - Width(trouble)) / 2), std::max(1, rows / 2),
                trouble, Ink::kWarn);
  } else {
    const int left = small ? 0 : DrawPerformers(view, 1, bottom - 1, canvas);
    DrawFigures(view, left, 1, canvas.columns() - left, bottom - 1, canvas);
  }
  if (small) {
    if (rows > 1) canvas.Text(0, rows - 1, StatusLine(view), Ink::kPlain);
    return;
  }
  for (int column = 0; column < canvas.columns(); ++column) {
    canvas.Text(column, bottom, canvas.utf8() ? "─" : "-", Ink::kDim);
  }
  if (!trouble.empty() && !view.performers.empty()) {
    canvas.Text(2, bottom, " " + trouble + " ", Ink::kWarn);
  }
  DrawNumbers(view, bottom + 1, canvas);
  DrawKeys(view, bottom + 3, canvas);
}

}  // namespace styled::stylemon
