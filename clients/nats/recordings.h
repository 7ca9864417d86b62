#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "clients/nats/link.h"
#include "model/base/status.h"

namespace styled::stylenats {

// The JetStream stream that records what bridges publish.
inline constexpr std::string_view kRecordings = "STYLED_REC";

// How much is kept; what is older, or more, goes, the oldest first.
struct RecordingLimits {
  std::vector<std::string> streams{"rig", "canonical"};  // of all performers of all sites
  double gigabytes = 10;                                 // of 10^9 bytes
  double hours = 24;
};

// What a broker says of its recordings.
struct RecordingState {
  std::vector<std::string> subjects;
  std::int64_t max_bytes = 0, max_age_ns = 0;
  std::uint64_t messages = 0, bytes = 0;
  std::int64_t first_ns = 0, last_ns = 0;         // Unix time of the broker
  std::map<std::string, std::uint64_t> recorded;  // messages by subject
};

// The recordings of a broker: makes them, looks at them, ends them. Calls wait for the
// broker, up to 5 s. Errors say what is missing: the broker, its JetStream, the recordings, room, a
// permission. One thread. Pinned by tests/e2e/nats/recording_test.cpp.
class Recordings {
 public:
  // `domain`: of the JetStream; "": the account's own.
  static Result<std::unique_ptr<Recordings>> Open(const LinkOptions& options,
                                                  const std::string& domain);
  ~Recordings();
  Recordings(const Recordings&) = delete;
  Recordings& operator=(const Recordings&) = delete;

  // Makes the stream, on the broker's disk; of one that is there, changes streams and limits. True:
  // it was made.
  Result<bool> Create(const RecordingLimits& limits);
  Result<RecordingState> Look();
  // The stream and all that it holds.
  Status Delete();

 private:
  Recordings() = default;
  Status Explain(natsStatus status, jsErrCode code);

  std::string brokers_, domain_;
  std::unique_ptr<Link> link_;
  jsCtx* jetstream_ = nullptr;
};

}  // namespace styled::stylenats
