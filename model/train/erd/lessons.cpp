#include "model/train/erd/lessons.h"

#include <charconv>
#include <sstream>

namespace styled::train::style_erd {
namespace {

constexpr double kMaxGain = 10;  // a larger one is a typing error: 1.25 is the largest that helped

// The text after the * of a lesson.
Result<double> ParseGain(const std::string& lesson, std::size_t star) {
  double gain = 0;
  const char* const first = lesson.data() + star + 1;
  const char* const last = lesson.data() + lesson.size();
  const auto [end, error] = std::from_chars(first, last, gain);
  if (error == std::errc() && end == last && gain > 0 && gain <= kMaxGain) return gain;
  return Status::Error("found the gain \"" + lesson.substr(star + 1) + "\" in \"" + lesson +
                       "\", expected a number above 0, at most 10");
}

Result<Lesson> ParseLesson(std::string text) {
  Lesson lesson;
  const std::size_t star = text.find('*');
  if (star != std::string::npos) {
    const Result<double> gain = ParseGain(text, star);
    if (!gain.ok()) return gain.status();
    lesson.gain = gain.value();
    text.resize(star);
  }
  const std::size_t slash = text.find('/');
  lesson.style = text.substr(0, slash);
  if (slash == std::string::npos) return lesson;
  lesson.content = text.substr(slash + 1);
  if (!lesson.content.empty()) return lesson;
  return Status::Error("found no content after the / of \"" + text + "\"");
}

}  // namespace

Result<TeacherFlag> ParseTeacher(const std::string& text) {
  TeacherFlag flag;
  const std::size_t colon = std::filesystem::exists(text) ? std::string::npos : text.rfind(':');
  flag.weights = text.substr(0, colon);
  if (colon == std::string::npos) return flag;
  const std::string list = text.substr(colon + 1);
  std::istringstream parts(list + ',');  // so that an empty list or an empty end is a part, too
  for (std::string part; std::getline(parts, part, ',');) {
    if (part.empty()) return Status::Error("found no style in \"" + list + "\"");
    Result<Lesson> lesson = ParseLesson(part);
    if (!lesson.ok()) return lesson.status();
    flag.lessons.push_back(std::move(lesson.value()));
  }
  return flag;
}

}  // namespace styled::train::style_erd
