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

// A translator of a rig whose server the transport connects to: what it adds to the translator.
// Take gets whole records; its answers, by Outbox::Reply, must be small enough for the socket to
// take them at once (kilobytes), one at a time.
class ServerTranslator : public Translator {
 public:
  // How the stream is cut into records, and the largest record, bytes.
  virtual CutReader::Cutter cutter() const = 0;
  virtual std::size_t max_record() const = 0;
  // Why the cutter found the front of these bytes broken, for the log.
  virtual std::string WhyBroken(std::span<const std::byte> received) const = 0;

  // A connection was made; the dialogue begins.
  virtual void Connected(std::int64_t now_ns) = 0;
  // Whether the dialogue of this connection came so far that frames may arrive.
  virtual bool ready() const = 0;
  // Why this connection has to be closed; "" if it need not. Asked after every batch and tick;
  // forgets the reason.
  virtual std::string TakeFault() = 0;
};

// Opens the transport that connects by TCP to `config.server` (IPv4 HOST[:PORT], the default port
// is its type's `server_port`), from `config.listen` (default: any port). A connection that cannot
// be made within 5 s, breaks, stops answering for 10 s (TCP keep-alive), loses its framing, or that
// the translator gives up, is closed and made again: after 1 s, then 2, 4 and 5 s, and after 1 s
// again when one has become ready. A reason is logged when it differs from the last one; becoming
// ready again is logged, too. All its memory is one buffer of `max_record` and 64 KiB.
//
// `translator` must be a ServerTranslator. A recording gets whole records, each once. Errors name
// the key and what was expected. Pinned by tests/unit/daemon/tcp_client_test.cpp.
Result<std::unique_ptr<Transport>> MakeTcpClient(const config::Source& config, int source,
                                                 runtime::Clock& clock, runtime::Counters& counters,
                                                 std::unique_ptr<Translator> translator);

}  // namespace styled::source
