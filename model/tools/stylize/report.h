#pragma once

#include <array>
#include <cstddef>
#include <string>
#include <vector>

#include "model/stylist/limb_gate.h"
#include "model/stylist/visible.h"

// The report of stylize about its outputs: a line of text or JSON each, and progress.
namespace styled::stylize {

// One output, written or not.
struct Outcome {
  std::string in, out, style;
  std::string error;          // the error; "": none
  bool written = false;       // the output; an error may be that of its preview
  std::string dialect, rest;  // of the input's skeleton; rest as clip::BoundClip has it
  std::string preview;        // the file; "": none
  std::string note;           // a note for the user; "": none
  std::size_t frames = 0;     // of the output
  // Of the input's frames; own: could not be styled.
  std::size_t input_frames = 0, planted = 0, out_of_domain = 0, own = 0;
  double rate_hz = 0, slide_cm_s = 0, input_slide_cm_s = 0;
  double turned_deg = 0;  // as stylize::Styled has them
  std::array<double, stylist::kLimbCount> shown{};
  std::array<double, stylist::kVisibleLimbs.size()> moved_cm{};
  int seconds = 0, unseen_s = 0;
  bool can_stride = false;  // --root stride is possible and was not requested
  bool styled = false;      // the network ran, so its figures are known
};

// The figures of a styled output, a clause each; none without a style.
std::vector<std::string> FigureLines(const Outcome& outcome);
// "in.bvh -> out.bvh: 171 frames at 60 Hz, cmu, a foot stands in 71 % of frames, standing feet
// slide 0.4 cm/s (input 0.3), ..."
std::string SummaryLine(const Outcome& outcome);
// The warning about an output whose standing feet slide more than twice as fast as the input's, and
// visibly; "": they do not.
std::string SlideWarning(const Outcome& outcome);
// An object: in, out, style, written, error, frames, rate_hz, seconds, dialect, rest, feet
// {planted_share, slide_cm_s, input_slide_cm_s}, out_of_domain_share, turned_deg, moved_cm {head,
// ...}, hardly_styled (in most seconds), hardly_styled_s, shown_share {left-arm, ...}, own_frames,
// warning, preview, note. Unknown values are absent. Bytes that are not UTF-8 are replaced.
std::string JsonLine(const Outcome& outcome);

// Prints a warning about a file on standard error; "": nothing.
void Warn(const std::string& file, const std::string& warning);

// The progress line at the bottom of a terminal; nothing for other outputs.
class ProgressLine {
 public:
  // `wanted` false: never shown.
  ProgressLine(bool wanted, std::size_t jobs);
  ~ProgressLine() { Clear(); }
  ProgressLine(const ProgressLine&) = delete;
  ProgressLine& operator=(const ProgressLine&) = delete;

  void Next(const std::string& name);  // the next job begins
  void Show(double share);             // how much of it is done
  void Clear();                        // before other text is written to the terminal

 private:
  bool shown_, there_ = false;
  std::size_t jobs_, job_ = 0;
  int percent_ = -1;
  std::string name_;
};

}  // namespace styled::stylize
