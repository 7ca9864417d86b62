// explain: the fates of the frames of a recording, and their causes.
#include "proto/styled/explain.h"

#include <string>
#include <vector>

#include "clients/rec/commands.h"
#include "proto/styled/v1/frame.pb.h"

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
    for (const v1::Applied& stale : record.decided().silence().stale()) {
      if (stale.performer() != arguments.performer) continue;
      v1::FrameFate fate;
      fate.set_fate(v1::FATE_STYLED);
      fate.set_sequence(stale.first_sequence());
      fate.set_flags(v1::FLAG_STALE);
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
