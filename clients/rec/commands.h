#pragma once

#include <atomic>
#include <limits>
#include <memory>
#include <ostream>
#include <string>
#include <utility>
#include <vector>

#include "clients/cpp/key_options.h"
#include "clients/cpp/subscriber.h"
#include "model/base/status.h"
#include "model/clip/write.h"
#include "proto/recording/reader.h"

namespace styled::rec {

// The command line; each value is checked by itself.
struct Arguments {
  std::string file;
  client::KeyOptions keys;  // record --from, play --control
  // record, receive
  std::vector<std::string> from{std::string(client::kDefaultPublisher)};
  std::string performer;  // export, too
  std::vector<std::string> topics, listen, forward;
  std::string type = "udp";
  double seconds = 0;
  std::string description, config, weights;
  // info, play, export
  bool json = false, salvage = false, overwrite = false;
  std::vector<std::string> to;
  std::string publish, control, speed = "1";
  double wait_s = 0, from_s = 0, until_s = std::numeric_limits<double>::infinity();
  bool loop = false, as_recorded = false;
  std::string what = "rig";
  std::vector<std::pair<const clip::Format*, std::string>> exports;  // the files to write
  double rate_hz = 0;                                                // 0: not given
};

// What a command is given beside its arguments: what ends it, and where it writes.
struct Dependencies {
  const std::atomic<bool>& stop;
  std::ostream& out;  // the summary line
  std::ostream& err;  // what is bound, damage
};

// Each is one command of stylerec. Errors name file or address.
Status RunRecord(const Arguments& arguments, const Dependencies& to);
Status RunReceive(const Arguments& arguments, const Dependencies& to);
Status RunInfo(const Arguments& arguments, const Dependencies& to);
// What `play` cannot do as its command line stands, --to for a source that the recording does not
// have among it. A file that cannot be read is left to RunPlay.
Status CheckPlay(const Arguments& arguments);
Status RunPlay(const Arguments& arguments, const Dependencies& to);
Status RunExport(const Arguments& arguments, const Dependencies& to);

Result<std::unique_ptr<recording::Reader>> OpenRecording(const Arguments& arguments);
// Writes to `err` what is damaged; nothing where the file is whole.
void ReportDamage(const recording::Reader& reader, const Dependencies& to);
// "NAME=ADDRESS" to its name, which is cut off; "" where there is none.
std::string CutName(std::string& address);

}  // namespace styled::rec
