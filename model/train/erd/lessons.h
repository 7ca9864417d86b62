#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "model/base/status.h"

namespace styled::train::style_erd {

// A student's lesson from a teacher: the changes to and from a style, with `gain` times the change
// to it.
struct Lesson {
  std::string style;
  std::string content;  // only in windows of it; empty: in all
  double gain = 1;      // (0, 10]
};

// A value of the flag --teacher: FILE or FILE:LESSON,..., a lesson being STYLE[/CONTENT][*GAIN].
// Without lessons, all styles that teacher and student have are imitated.
struct TeacherFlag {
  std::filesystem::path weights;
  std::vector<Lesson> lessons;
};

// A file that exists under the whole text is taken as that file, since a path may have a colon.
// Errors name the part that is wrong. Pinned by tests/unit/train/run_test.cpp.
Result<TeacherFlag> ParseTeacher(const std::string& text);

}  // namespace styled::train::style_erd
