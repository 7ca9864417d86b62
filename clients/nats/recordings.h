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

// The limits of a recording; older messages, or those beyond the size, are removed, the oldest
// first.
struct RecordingLimits {
  std::vector<std::string> streams{"rig", "canonical"};  // of all performers of all sites
  double gigabytes = 10;                                 // of 10^9 bytes
  double hours = 24;
};

// A broker's report on its recordings.
struct RecordingState {
  std::vector<std::string> subjects;
  std::int64_t max_bytes = 0, max_age_ns = 0;
  std::uint64_t messages = 0, bytes = 0;
  std::int64_t first_ns = 0, last_ns = 0;         // Unix time of the broker
  std::map<std::string, std::uint64_t> recorded;  // messages by subject
};

// One recorded message.
struct Recorded {
  std::string subject, payload;
  std::int64_t time_ns = 0;               // Unix time at which the broker had it
  std::uint64_t epoch = 0, sequence = 0;  // of a frame
};

class RecordingReader;

// The recordings of a broker: creates, inspects, deletes and reads them. Calls wait for the broker,
// up to 3 s. Errors name what is missing: the broker, its JetStream, the recordings, room, a
// permission. One thread. Pinned by tests/e2e/nats/recording_test.cpp.
class Recordings {
 public:
  // `domain`: of the JetStream; "": the account's own.
  static Result<std::unique_ptr<Recordings>> Open(const LinkOptions& options,
                                                  const std::string& domain);
  ~Recordings();
  Recordings(const Recordings&) = delete;
  Recordings& operator=(const Recordings&) = delete;

  // Creates the stream, on the broker's disk, or changes streams and limits of an existing one.
  // True: it was created.
  Result<bool> Create(const RecordingLimits& limits);
  Result<RecordingState> Look();
  // The stream and all of its messages.
  Status Delete();
  // The frames and bodies of a site ("": of one performer too, if it is not empty) from a Unix time
  // on. The reader must end before this object.
  Result<std::unique_ptr<RecordingReader>> Read(const std::string& site,
                                                const std::string& performer, std::int64_t from_ns);

 private:
  friend class RecordingReader;
  Recordings() = default;
  Status Explain(natsStatus status, jsErrCode code);

  std::string brokers_, domain_;
  std::unique_ptr<Link> link_;
  jsCtx* jetstream_ = nullptr;
};

// Reads recorded messages in order, without blocking the broker: it requests some megabytes at a
// time. A broker that is gone for less than 10 s is waited for.
//
// The broker's readers accept one subject each, which must be one of the stream's. Therefore there
// is one reader for each stream, and one for its bodies; their messages are sorted here.
class RecordingReader {
 public:
  ~RecordingReader();
  RecordingReader(const RecordingReader&) = delete;
  RecordingReader& operator=(const RecordingReader&) = delete;

  // Returns the next message; false while there is none.
  Result<bool> Next(Recorded& out);

 private:
  friend class Recordings;
  struct Part {
    std::string filter;
    natsSubscription* subscription = nullptr;
    natsMsgList batch{};
    int at = 0;                  // the next of the batch
    std::uint64_t sequence = 0;  // of the next message in the stream; 0: no message
    std::uint64_t last = 0;      // of the last message that arrived
    std::uint64_t pending = 0;   // after the batch's last message, as far as known
    std::int64_t time_ns = 0;
  };
  RecordingReader(Recordings& recordings, std::int64_t from_ns)
      : recordings_(recordings), from_ns_(from_ns) {}
  Status Begin(Part& part);
  Status Fetch(Part& part);
  Status Advance(Part& part);

  Recordings& recordings_;
  const std::int64_t from_ns_;
  std::vector<Part> parts_;
};

}  // namespace styled::stylenats
