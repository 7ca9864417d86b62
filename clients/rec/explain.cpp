// explain: what the daemon made of the frames of a recording.
#include "proto/styled/explain.h"

#include <map>
#include <string>
#include <vector>

#include "clients/rec/commands.h"
#include "clients/rec/time_text.h"

namespace styled::rec {
namespace {

// Fates of the chosen performer and frame, in the order of the recording.
std::vector<v1::FrameFate> Read(recording::Reader& reader, const Arguments& arguments) {
  std::vector<v1::FrameFate> fates;
  recording::Record record;
  reader.Rewind();
  while (reader.Next(record)) {
    for (const v1::FrameFate& fate : record.decided().frames()) {
      if (fate.performer() != arguments.performer) continue;
      if (arguments.sequence == 0 || arguments.sequence == fate.sequence()) fates.push_back(fate);
    }
  }
  return fates;
}

}  // namespace

Status RunExplain(const Arguments& arguments, const Dependencies& to) {
  auto opened = OpenRecording(arguments);
  if (!opened.ok()) return opened.status();
  recording::Reader& reader = *opened.value();
  const std::vector<v1::FrameFate> fates = Read(reader, arguments);
  if (fates.empty()) {
    return Status::Error(
        arguments.file + ": found no frame of " + arguments.performer +
        (arguments.sequence == 0 ? "" : " with number " + std::to_string(arguments.sequence)) +
        " that a daemon decided; expected a recording of the daemon ([record]) from version " +
        STYLED_VERSION + " on");
  }
  to.out << ExplainLines(fates);
  ReportDamage(reader, to);
  return Status::Ok();
}

}  // namespace styled::rec
