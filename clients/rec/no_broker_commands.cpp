// The commands that need libnats, for a stylerec that was built without it.
#include "clients/rec/commands.h"

namespace styled::rec {
namespace {

Status NoLibnats() {
  return Status::Error("this stylerec was built without libnats (Debian: libnats-dev)");
}

}  // namespace

Status RunJetStream(const Arguments& /*a*/, const Dependencies& /*to*/) { return NoLibnats(); }
Status RunFetch(const Arguments& /*a*/, const Dependencies& /*to*/) { return NoLibnats(); }

}  // namespace styled::rec
