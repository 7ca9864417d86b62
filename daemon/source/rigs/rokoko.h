#pragma once

#include <memory>

#include "daemon/config/config.h"
#include "daemon/source/translator.h"

namespace styled::source {

// Rokoko Studio Live (proto/rigs/rokoko): a performer for each actor of each sender, called as
// Studio calls him, else `config.performer`, else as the source; NAME-2, ... where a name is taken.
// The body is that of the first frame that has a hip, made right-handed, under the dialect
// "rokoko"; it is made anew when joints are added (gloves) or the actor's hip height changes. An
// actor's time that goes back by a second, or stays back, is a restart.
std::unique_ptr<Translator> MakeRokoko(const config::Source& config);

}  // namespace styled::source
