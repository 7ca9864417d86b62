#pragma once

#include <memory>
#include <string>
#include <vector>

#include "clients/cpp/transforms.h"
#include "clients/stylemon/canvas.h"
#include "clients/stylemon/figure.h"
#include "clients/stylemon/meter.h"
#include "proto/styled/v1/frame.pb.h"

namespace styled::stylemon {

enum class Link : std::uint8_t {
  kNever,  // no daemon has answered yet
  kThere,  // connected
  kLost,   // was connected; now reconnecting
};

// One stream of the selected performer, ready to draw.
struct Figure {
  bool here = false;  // a frame and its body have arrived
  std::shared_ptr<const Anatomy> anatomy;
  std::vector<client::Transform> joints;
  v1::Frame frame;
  double age_s = 0;  // since the frame arrived
};

struct PerformerLine {
  std::string performer;
  bool live = false;
  std::string note;  // style and strength that are set, "pinned"
};

// Everything that the screen shows. Filled by Monitor, or by a test.
struct View {
  std::string publisher, control;
  Link link = Link::kNever;
  double link_s = 0;     // since the last change of `link`
  std::string obstacle;  // why there is no connection, and the remedy; "" = unknown
  std::vector<PerformerLine> performers;
  int selected = -1;  // index into performers
  Figure input, styled;
  Side side = Side::kSide;
  float yaw_rad = 0, height = 0, floor = 0, travel = 0;  // as in Pose; shared by both figures
  Meter::Reading reading;
  std::string set;  // the performer's settings: "old 1.00, strength 0.80"; "" = unknown
  std::vector<std::string> styles;  // keys 1-9 select these, starting at first_style
  std::size_t first_style = 0;
  std::string message;  // outcome of the last key
  bool message_bad = false;
  bool paused = false;
};

inline constexpr std::size_t kStyleKeys = 9;

// Draws the whole terminal: header, performers, both figures, numbers, keys. Any size; parts that
// do not fit are left out, starting at the edges.
void DrawScreen(const View& view, Canvas& canvas);

// Both figures side by side with their captions, in the given cells.
void DrawFigures(const View& view, int column, int row, int columns, int rows, Canvas& canvas);

// One line: performer, rate, latencies, drops, flags, style in force, contacts. Without a stream:
// the cause and the remedy.
std::string StatusLine(const View& view);

// The reason why the picture does not move, with what to check; "" if there is none.
std::string Trouble(const View& view);

std::string FlagNames(std::uint32_t flags);      // "concealed fading"; "" for none
std::string StylesText(const v1::Frame& frame);  // "old 0.80 + proud 0.20", "bypass"

}  // namespace styled::stylemon
