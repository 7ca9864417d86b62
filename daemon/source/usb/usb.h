#pragma once

#include <memory>

#include "daemon/config/config.h"
#include "daemon/runtime/clock.h"
#include "daemon/runtime/counters.h"
#include "daemon/source/translator.h"
#include "daemon/source/transport.h"
#include "model/base/status.h"

namespace styled::source {

// What devices on USB send: every device that `config.usb_id` and `config.serial` leave, those that
// are plugged in later too (usb/usb_thread.h). With a translator it is given a rig's reports, each
// with its time of arrival and its device as the peer; a device that was plugged in again is
// another peer. Without, they are our own records (proto/rigs/native/USB.md). Errors: no USB on
// this system.
Result<std::unique_ptr<Transport>> MakeUsb(const config::Source& config, int source,
                                           runtime::Clock& clock, runtime::Counters& counters,
                                           std::unique_ptr<Translator> translator);

}  // namespace styled::source
