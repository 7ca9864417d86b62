#pragma once

#include <memory>

#include "daemon/config/config.h"
#include "daemon/runtime/clock.h"
#include "daemon/runtime/counters.h"
#include "daemon/source/translator.h"
#include "daemon/source/transport.h"
#include "model/base/status.h"

namespace styled::source {

// Opens a transport for USB devices: every device that matches `config.usb_id` and `config.serial`,
// including those plugged in later (usb/usb_thread.h). With a translator, the devices send a rig's
// reports; the translator receives each with its time of arrival and its device as the peer, and a
// device that was plugged in again is another peer. Without one, they send native records
// (proto/rigs/native/USB.md). Errors: no USB on this system.
Result<std::unique_ptr<Transport>> MakeUsb(const config::Source& config, int source,
                                           runtime::Clock& clock, runtime::Counters& counters,
                                           std::unique_ptr<Translator> translator);

}  // namespace styled::source
