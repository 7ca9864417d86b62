#pragma once

#include <memory>

#include "daemon/config/config.h"
#include "daemon/source/translator.h"

namespace styled::source {

// Sony mocopi (proto/rigs/mocopi): one performer per port, called `config.performer`, else as the
// source. The body is the usual one until the sender describes its own. Source time is the
// sender's, since its stream began; gaps in its frame numbers are losses; numbers or time that go
// back by a second or more, or stay back, a restart. Of two senders at one port the pipeline lets
// one in.
std::unique_ptr<Translator> MakeMocopi(const config::Source& config);

}  // namespace styled::source
