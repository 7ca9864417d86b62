#pragma once

#include <string>
#include <vector>

#include "clients/doctor/address.h"
#include "clients/doctor/format.h"
#include "model/base/status.h"

namespace styled::doctor {

// A source through which frames should arrive.
struct ExpectedSource {
  enum class Origin {
    kDaemon,   // reported by a running daemon
    kConfig,   // from the configuration file
    kAssumed,  // neither: a source of a daemon without configuration
    kOption    // --listen
  };
  Origin origin = Origin::kConfig;
  std::string name, type;
  Format format = Format::kUnknown;  // derived from `type`
  bool stream = false;
  bool network = true;  // false: USB, or an unreadable `listen`
  Endpoint listen;      // the server's, for a rig whose server we connect to
  // The performer that gets face or fingers of this source; "": none, or not known.
  std::string merge_into;
  // OptiTrack only.
  std::string server, group = "239.255.42.99", interface;
  bool multicast = true;
};

struct Settings {
  std::vector<ExpectedSource> sources;
  std::string control;  // "": not given
};

// Reads only those keys of a styled.toml that determine where frames arrive. `styled
// --check-config` checks the whole file. Errors: no such file, not TOML, a source without an
// address.
Result<Settings> ReadSettings(const std::string& file);

// Parses "TYPE=HOST:PORT", the value of --listen.
Result<ExpectedSource> ParseListen(const std::string& text);

// The sources of a daemon that was given no configuration.
std::vector<ExpectedSource> AssumedSources();

// Makes a source from the values of a daemon or a file; an empty `listen` means the type's usual
// address.
ExpectedSource MakeExpected(ExpectedSource::Origin origin, const std::string& name,
                            const std::string& type, const std::string& listen);

}  // namespace styled::doctor
