#include "model/tools/stylize/report.h"

#include <unistd.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "model/base/terminal_text.h"
#include "model/base/text.h"

namespace styled::stylize {
namespace {

double Share(std::size_t part, std::size_t whole) {
  return whole == 0 ? 0 : static_cast<double>(part) / static_cast<double>(whole);
}

std::string Percent(std::size_t part, std::size_t whole) {
  return NumberText(100 * Share(part, whole), 1) + " %";
}

// The limbs that show visibly less of the style, "left-arm 24 %, trunk 61 %"; "": none.
std::string HeldBack(const Outcome& outcome) {
  constexpr double kMissed = 0.9;
  std::string text;
  for (std::size_t limb = 0; limb < outcome.shown.size(); ++limb) {
    if (outcome.shown[limb] >= kMissed) continue;
    text += (text.empty() ? "" : ", ") + std::string(stylist::kLimbNames[limb]) + " " +
            NumberText(100 * outcome.shown[limb], 0) + " %";
  }
  return text;
}

bool MostlyUnseen(const Outcome& outcome) { return 2 * outcome.unseen_s > outcome.seconds; }

}  // namespace

std::vector<std::string> FigureLines(const Outcome& outcome) {
  std::vector<std::string> lines;
  if (!outcome.styled) return lines;
  lines.push_back("a foot stands in " + Percent(outcome.planted, outcome.input_frames) +
                  " of frames");
  if (outcome.planted > 0) {
    lines.push_back("standing feet slide " + NumberText(outcome.slide_cm_s, 1) + " cm/s (input " +
                    NumberText(outcome.input_slide_cm_s, 1) + ")");
  }
  lines.push_back("out of domain " + Percent(outcome.out_of_domain, outcome.input_frames));
  lines.push_back("joints turned by " + NumberText(outcome.turned_deg, 1) + " degrees");
  if (outcome.unseen_s > 0) {
    lines.push_back("hardly styled for " + std::to_string(outcome.unseen_s) + " of " +
                    std::to_string(outcome.seconds) +
                    " s: the weights leave that motion unchanged");
  }
  const std::string held_back = HeldBack(outcome);
  if (!held_back.empty() && !MostlyUnseen(outcome)) lines.push_back("style shown: " + held_back);
  return lines;
}

std::string SummaryLine(const Outcome& outcome) {
  const bool in_sheet = outcome.out.ends_with(".html") && !outcome.style.empty();
  std::string line = outcome.in + " -> " + outcome.out +
                     (in_sheet ? " (" + outcome.style + ")" : "") + ": " +
                     std::to_string(outcome.frames) + " frames at " +
                     NumberText(outcome.rate_hz, 3) + " Hz, " + outcome.dialect;
  if (!outcome.rest.empty()) line += " (T-pose from its " + outcome.rest + ")";
  for (const std::string& figure : FigureLines(outcome)) line += ", " + figure;
  if (outcome.own > 0) line += ", not styled " + std::to_string(outcome.own);
  if (!outcome.preview.empty()) line += "; " + outcome.preview;
  if (!outcome.note.empty()) line += "; " + outcome.note;
  return line;
}

std::string SlideWarning(const Outcome& outcome) {
  constexpr double kMost = 2, kSeen_cm_s = 2;
  const double slide = outcome.slide_cm_s, input = outcome.input_slide_cm_s;
  if (slide < kSeen_cm_s || slide <= kMost * input) return "";
  return "standing feet slide " + NumberText(slide, 1) + " cm/s, in the input " +
         NumberText(input, 1) +
         (outcome.can_stride ? "; the steps are the style's, the way over the floor is the "
                               "performer's: --root stride scales the way to the steps"
                             : "");
}

std::string JsonLine(const Outcome& outcome) {
  using nlohmann::json;
  json line{{"in", outcome.in}, {"out", outcome.out}, {"written", outcome.written}};
  if (!outcome.style.empty()) line["style"] = outcome.style;
  if (!outcome.error.empty()) line["error"] = outcome.error;
  if (outcome.frames > 0) {
    line["frames"] = outcome.frames;
    line["rate_hz"] = outcome.rate_hz;
    line["seconds"] = static_cast<double>(outcome.frames) / outcome.rate_hz;
    line["dialect"] = outcome.dialect;
  }
  if (!outcome.rest.empty()) line["rest"] = outcome.rest;
  if (outcome.styled) {
    line["feet"] = {{"planted_share", Share(outcome.planted, outcome.input_frames)}};
    if (outcome.planted > 0) {
      line["feet"]["slide_cm_s"] = outcome.slide_cm_s;
      line["feet"]["input_slide_cm_s"] = outcome.input_slide_cm_s;
    }
    line["out_of_domain_share"] = Share(outcome.out_of_domain, outcome.input_frames);
    line["turned_deg"] = outcome.turned_deg;
    for (std::size_t limb = 0; limb < outcome.moved_cm.size(); ++limb) {
      line["moved_cm"][stylist::kVisibleLimbs[limb]] = outcome.moved_cm[limb];
    }
    line["hardly_styled"] = MostlyUnseen(outcome);
    line["hardly_styled_s"] = outcome.unseen_s;
    for (std::size_t limb = 0; limb < outcome.shown.size(); ++limb) {
      line["shown_share"][stylist::kLimbNames[limb]] = outcome.shown[limb];
    }
    line["own_frames"] = outcome.own;
  }
  if (const std::string warning = SlideWarning(outcome); !warning.empty()) {
    line["warning"] = warning;
  }
  if (!outcome.preview.empty()) line["preview"] = outcome.preview;
  if (!outcome.note.empty()) line["note"] = outcome.note;
  return line.dump(-1, ' ', false, json::error_handler_t::replace);
}

void Warn(const std::string& file, const std::string& warning) {
  if (warning.empty()) return;
  std::fprintf(stderr, "stylize: %s: warning: %s\n", ForTerminal(file).c_str(),
               ForTerminal(warning).c_str());
}

ProgressLine::ProgressLine(bool wanted, std::size_t jobs)
    : shown_(wanted && isatty(STDERR_FILENO) == 1), jobs_(jobs) {}

void ProgressLine::Next(const std::string& name) {
  ++job_;
  name_ = name;
  percent_ = -1;
  Show(0);
}

void ProgressLine::Show(double share) {
  const int percent = static_cast<int>(std::lround(100 * share));
  if (!shown_ || percent == percent_) return;
  percent_ = percent;
  there_ = true;
  // Carriage return, the text, and erasing the rest of the line.
  std::fprintf(stderr, "\r%zu of %zu: %.60s %d %%\x1b[K", job_, jobs_, name_.c_str(), percent);
}

void ProgressLine::Clear() {
  if (there_) std::fputs("\r\x1b[K", stderr);
  there_ = false;
}

}  // namespace styled::stylize
