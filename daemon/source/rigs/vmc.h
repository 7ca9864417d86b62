#pragma once

#include <memory>

#include "daemon/config/config.h"
#include "daemon/source/translator.h"

namespace styled::source {

// The VMC protocol (proto/rigs/vmc): one performer per port, called `config.performer`, else as the
// source. The body are the bones that the sender sends, fingers and eyes among them, where their
// own positions say they are, or as long as ours where those are all zero; it changes with them.
// Root and hips are composed, left and right told apart as in Unity, +X becomes the body's left.
// Source time is the sender's T; where there is none, time of arrival. Of two senders at one port
// the pipeline lets one in. Expressions are not passed on.
std::unique_ptr<Translator> MakeVmc(const config::Source& config);

}  // namespace styled::source
