#pragma once

#include <memory>
#include <string>

#include "daemon/config/config.h"
#include "daemon/runtime/clock.h"
#include "daemon/runtime/counters.h"
#include "daemon/source/cut_reader.h"
#include "daemon/source/translator.h"
#include "daemon/source/transport.h"
#include "model/base/status.h"

namespace styled::source {

// A translator for a rig whose server the transport connects to: the additions to Translator. Take
// gets whole records. Its answers, sent by Outbox::Reply, must be small enough for the socket to
// accept them at once (kilobytes), one at a time.
class ServerTranslator : public Translator {
 public:
  // How the stream is cut into records, and the largest record in bytes.
  virtual CutReader::Cutter cutter() const = 0;
  virtual std::size_t max_record() const = 0;
  // Why the cutter considered the front of these bytes invalid, for the log.
  virtual std::string WhyBroken(std::span<const std::byte> received) const = 0;

  // A connection was made; the dialogue begins.
  virtual void Connected(std::int64_t now_ns) = 0;
  // Whether the dialogue of this connection has reached the point where frames may arrive.
  virtual bool ready() const = 0;
  // Why this connection has to be closed; "" if it need not be. Called after every batch and tick;
  // clears the reason.
  virtual std::string NextFault() = 0;
};

// Opens the transport that connects by TCP to `config.server` (IPv4 HOST[:PORT], the default port
// is its type's `server_port`), from `config.listen` (default: any port). A connection is closed
// and made again if it cannot be made within 5 s, breaks, stops answering for 10 s (TCP keep-alive)
// or loses its framing, or if the translator gives it up. The pauses before it is made again are 1,
// 2, 4 and then 5 s, and 1 s again after a connection has become ready. A reason is logged when it
// differs from the last one; becoming ready again is logged, too. All its memory is one buffer of
// `max_record` and 64 KiB.
//
// `translator` must be a ServerTranslator. A recording gets whole records, each once. Errors name
// the key and what was expected. Pinned by tests/unit/daemon/source/tcp_client_test.cpp.
Result<std::unique_ptr<Transport>> MakeTcpClient(const config::Source& config, int source,
                                                 runtime::Clock& clock, runtime::Counters& counters,
                                                 std::unique_ptr<Translator> translator);

}  // namespace styled::source
