#include "tests/parity/schedule.h"

#include <sstream>

namespace styled::parity {

Result<std::vector<Segment>> ParseSchedule(const std::string& text) {
  std::vector<Segment> schedule;
  std::istringstream parts(text);
  for (std::string part; std::getline(parts, part, ';');) {
    const auto bad = [&part] {
      return Status::Error("schedule: found \"" + part + "\", expected FRAME:STYLE=WEIGHT,...");
    };
    Segment segment;
    std::istringstream in(part);
    char colon = 0;
    if (!(in >> segment.first_frame >> colon) || colon != ':') return bad();
    const bool in_order = schedule.empty() ? segment.first_frame == 0
                                           : segment.first_frame > schedule.back().first_frame;
    if (!in_order) return bad();
    for (std::string entry; std::getline(in, entry, ',');) {
      const std::size_t equals = entry.find('=');
      if (equals == std::string::npos) return bad();
      std::istringstream number(entry.substr(equals + 1));
      float weight = 0;
      if (!(number >> weight)) return bad();
      segment.mix.emplace_back(entry.substr(0, equals), weight);
    }
    if (segment.mix.empty()) return bad();
    schedule.push_back(std::move(segment));
  }
  if (schedule.empty()) return Status::Error("schedule: empty, expected FRAME:STYLE=WEIGHT,...");
  return schedule;
}

const Segment& SegmentAt(const std::vector<Segment>& schedule, int frame) {
  std::size_t i = schedule.size() - 1;
  while (schedule[i].first_frame > frame) --i;
  return schedule[i];
}

}  // namespace styled::parity
