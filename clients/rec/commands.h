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
#include "clients/nats/link_options.h"
#include "model/base/status.h"
#include "model/clip/write.h"
#include "proto/recording/reader.h"

namespace styled::rec {

// The parsed command line; each value has passed its own check.
struct Arguments {
  std::string file;
  client::KeyOptions keys;  // record --from, play --control
  // record, receive
  std::vector<std::string> from{std::string(client::kDefaultPublisher)};
  std::string performer;  // also export
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
  std::uint64_t sequence = 0;  // explain: of this frame; 0: of all
  double rate_hz = 0;          // 0: not given
  // jetstream, fetch
  stylenats::LinkOptions broker;
  std::string action, login, domain, site, from_time, to_time;
  std::vector<std::string> streams{"rig", "canonical"};
  double max_gb = 10, max_hours = 24;
  bool yes = false;
};

// A command's environment besides its arguments: the stop flag and its output streams.
struct Dependencies {
  const std::atomic<bool>& stop;
  std::ostream& out;  // the summary line
  std::ostream& err;  // bound addresses, damage
};

// Each function is one command of stylerec. Errors name the file or the address.
Status RunRecord(const Arguments& arguments, const Dependencies& to);
Status RunReceive(const Arguments& arguments, const Dependencies& to);
Status RunInfo(const Arguments& arguments, const Dependencies& to);
// Checks whether `play` can work with this command line, e.g. a --to for a source that is not in
// the recording. An unreadable file is reported by RunPlay.
Status CheckPlay(const Arguments& arguments);
// Writes what the daemon made of a performer's frames, and why, as it recorded it.
Status RunExplain(const Arguments& arguments, const Dependencies& to);
Status RunPlay(const Arguments& arguments, const Dependencies& to);
Status RunExport(const Arguments& arguments, const Dependencies& to);
// If libnats was missing at build time, these two report that.
Status RunJetStream(const Arguments& arguments, const Dependencies& to);
Status RunFetch(const Arguments& arguments, const Dependencies& to);

Result<std::unique_ptr<recording::Reader>> OpenRecording(const Arguments& arguments);
// Writes the damage to `err`; nothing if the file is intact.
void ReportDamage(const recording::Reader& reader, const Dependencies& to);
// Splits "NAME=ADDRESS": returns NAME and removes it from `address`; "" if there is no name.
std::string CutName(std::string& address);

}  // namespace styled::rec
