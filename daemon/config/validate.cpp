#include <algorithm>
#include <cctype>
#include <string>
#include <vector>

#include "daemon/config/address.h"
#include "daemon/config/config.h"
#include "daemon/config/shown.h"
#include "daemon/config/sources.h"
#include "daemon/runtime/host_port.h"
#include "model/net/styles.h"
#include "proto/rigs/types.h"
#include "proto/styled/look.h"

namespace styled::config {
namespace {

bool IsStream(const Source& source) { return rigs::FindSourceType(source.type)->stream; }

// Names of the clients' streams, in any case: a user who writes "Rig" means the stream.
bool IsAStreams(std::string name) {
  std::ranges::transform(name, name.begin(), [](unsigned char c) { return std::tolower(c); });
  return name == "rig" || name == "canonical" || name == "source";
}

Status CheckOutputs(const std::vector<Output>& outputs) {
  for (std::size_t i = 0; i < outputs.size(); ++i) {
    const Output& output = outputs[i];
    const std::string place = "output." + std::to_string(i) + ".";
    if (!IsName(output.name) || IsAStreams(output.name)) {
      return Status::Error(place + "name: \"" + Shown(output.name) +
                           "\"; expected 1 to 32 of A-Z a-z 0-9 _ -, and not rig, canonical or "
                           "source in any case");
    }
    if (output.avatar.empty()) {
      return Status::Error(place + "avatar: missing; expected a .vrm, .glb, .gltf or .bvh file");
    }
    for (const auto& performer : output.performers) {
      if (IsPerformerId(performer)) continue;
      return Status::Error(place + "performers: \"" + Shown(performer) +
                           "\"; expected SOURCE.NAME");
    }
    for (std::size_t k = 0; k < i; ++k) {
      if (outputs[k].name == output.name) {
        return Status::Error(place + "name: \"" + Shown(output.name) + "\" is taken by output." +
                             std::to_string(k));
      }
    }
  }
  return Status::Ok();
}

// `section` is a Publish or a Control.
template <typename Socket>
Status CheckSocket(const Config& config, const std::string& name, const Socket& section,
                   const std::string& who) {
  const std::string& address = section.address;
  const Status status = CheckEndpoint(address);
  if (!status.ok()) return Status::Error(name + ".address: " + status.message());
  constexpr int kOthersConnect = 0022;
  if (!section.ipc.users.empty() && (section.ipc.mode & kOthersConnect) == 0) {
    return Status::Error(name + ".ipc_users: no other user is admitted by " + name +
                         ".ipc_mode; expected also e.g. ipc_mode = \"0666\"");
  }
  const bool open = section.allow_unauthenticated_remote;
  if (IsLocal(address) || open || RequiresKeys(config, address, open)) return Status::Ok();
  return Status::Error(name + ".address: " + address + " can be reached from other machines, and " +
                       who +
                       " are not authenticated; expected a loopback or ipc:// address, a folder "
                       "of keys (security.keys), or " +
                       name + ".allow_unauthenticated_remote = true");
}

Status CheckCues(const std::vector<Cue>& cues, const std::vector<Source>& sources) {
  for (std::size_t i = 0; i < cues.size(); ++i) {
    const std::string place = "cue." + std::to_string(i) + ".";
    if (!IsName(cues[i].name)) {
      return Status::Error(place + "name: \"" + Shown(cues[i].name) +
                           "\"; expected 1 to 32 of A-Z a-z 0-9 _ -");
    }
    const std::string& performer = cues[i].performer;
    if (performer != "*" && !IsPerformerId(performer)) {
      return Status::Error(place + "performer: \"" + Shown(performer) +
                           "\"; expected SOURCE.NAME or *");
    }
    const std::string source = performer.substr(0, performer.find('.'));
    if (performer == "*" || std::ranges::count(sources, source, &Source::name) > 0) continue;
    std::string names;
    for (const Source& one : sources) names += " " + one.name;
    return Status::Error(place + "performer: \"" + Shown(performer) +
                         "\": no such source; the sources are" + names);
  }
  return Status::Ok();
}

// An empty address turns OSC off.
Status CheckOsc(const Osc& osc) {
  if (osc.listen.empty()) return Status::Ok();
  const auto address = runtime::ParseHostPort(osc.listen);
  if (!address.ok()) return Status::Error("osc.listen: " + address.status().message());
  if (!IsNumeric(address.value().host)) {
    return Status::Error("osc.listen: \"" + Shown(osc.listen) +
                         "\": expected a numeric address, e.g. \"127.0.0.1:7003\"");
  }
  if (IsLocal("tcp://" + osc.listen) || osc.allow_unauthenticated_remote) return Status::Ok();
  return Status::Error("osc.listen: " + osc.listen +
                       " can be reached from other machines, and operators are not "
                       "authenticated; expected a loopback address, or "
                       "osc.allow_unauthenticated_remote = true");
}

// Without a peer it is off, and the address is not checked.
Status CheckStandby(const Config& config) {
  const Standby& standby = config.standby;
  if (standby.peer.empty()) return Status::Ok();
  Status status = CheckEndpoint(standby.address);
  if (!status.ok()) return Status::Error("standby.address: " + status.message());
  status = CheckEndpoint(standby.peer);
  if (!status.ok()) return Status::Error("standby.peer: " + status.message());
  if (standby.peer == standby.address && !standby.peer.ends_with(":0")) {
    return Status::Error("standby.peer: " + standby.peer +
                         " is this daemon's own standby.address; expected the other daemon's");
  }
  constexpr std::size_t kKeyLength = 40;
  if (!standby.peer_key.empty() && standby.peer_key.size() != kKeyLength) {
    return Status::Error("standby.peer_key: " + std::to_string(standby.peer_key.size()) +
                         " characters, expected the 40 of the other daemon's public key (stylectl "
                         "keys, on its machine)");
  }
  const bool local = IsLocal(standby.address) && IsLocal(standby.peer);
  const bool keys = !config.security.keys.empty() && !standby.peer_key.empty();
  if (local || keys || standby.allow_unauthenticated_remote) return Status::Ok();
  const bool here = !IsLocal(standby.address);
  return Status::Error(std::string(here ? "standby.address: " : "standby.peer: ") +
                       (here ? standby.address : standby.peer) +
                       " is not local to this machine; expected keys (security.keys and "
                       "standby.peer_key), a loopback or ipc:// address, or "
                       "standby.allow_unauthenticated_remote = true on a network that the two "
                       "machines have to themselves");
}

// An address at which the daemon listens.
struct Listener {
  std::string key;       // the configuration's key
  std::string address;   // as it is configured
  bool stream = false;   // TCP; else UDP
  runtime::HostPort at;  // for ipc:// the path with port 0
  bool shares = false;   // the socket shares its port with others (SO_REUSEADDR)
};

void AddSocket(const std::string& key, const std::string& address, std::vector<Listener>& all) {
  constexpr std::string_view kTcp = "tcp://";
  if (!address.starts_with(kTcp)) return all.push_back({key, address, true, {address, 0}});
  const auto at = runtime::ParseHostPort(std::string_view(address).substr(kTcp.size()));
  if (at.ok()) all.push_back({key, address, true, at.value()});
}

std::vector<Listener> Listeners(const Config& config) {
  std::vector<Listener> all;
  for (std::size_t i = 0; i < config.sources.size(); ++i) {
    const Source& source = config.sources[i];
    if (rigs::FindSourceType(source.type)->usb) continue;
    all.push_back({"source." + std::to_string(i) + ".listen", source.listen, IsStream(source),
                   runtime::ParseHostPort(source.listen).value(),
                   rigs::FindSourceType(source.type)->rig->asks_server});
  }
  AddSocket("publish.address", config.publish.address, all);
  AddSocket("control.address", config.control.address, all);
  if (!config.standby.peer.empty()) AddSocket("standby.address", config.standby.address, all);
  if (!config.osc.listen.empty()) {
    all.push_back({"osc.listen", config.osc.listen, false,
                   runtime::ParseHostPort(config.osc.listen).value()});
  }
  return all;
}

// Whether the system, or libzmq, would refuse to bind the second one. An all-interfaces address
// occupies the port on every interface of the same family.
bool Clash(const Listener& a, const Listener& b) {
  if (a.stream != b.stream || a.at.port != b.at.port) return false;
  if (a.address == b.address) return a.at.port != 0 || a.address.starts_with("ipc://");
  if (a.at.port == 0 || a.shares || b.shares) return false;
  const auto is_v6 = [](const std::string& host) { return host.find(':') != std::string::npos; };
  const auto is_all = [](const std::string& host) {
    return host == "*" || host == "0.0.0.0" || host == "::";
  };
  if (is_v6(a.at.host) != is_v6(b.at.host)) return false;
  return a.at.host == b.at.host || is_all(a.at.host) || is_all(b.at.host);
}

// Requires that each address was checked before.
Status CheckClashes(const Config& config) {
  const auto all = Listeners(config);
  const auto is_said = [&](const Listener& l) { return config.places.contains(l.key); };
  for (std::size_t i = 0; i < all.size(); ++i) {
    for (std::size_t k = 0; k < i; ++k) {
      if (!Clash(all[i], all[k])) continue;
      // Reports the address that was set explicitly; the later one if both were.
      const bool first = is_said(all[k]) && !is_said(all[i]);
      const Listener& wrong = first ? all[k] : all[i];
      const Listener& other = first ? all[i] : all[k];
      const auto place = config.places.find(other.key);
      const std::string where =
          place == config.places.end() ? " (its default)" : " (" + place->second + ")";
      return Status::Error(wrong.key + ": " + wrong.address + " is taken by " + other.key +
                           (wrong.address == other.address ? "" : ", " + other.address) + where +
                           "; expected an address of its own");
    }
  }
  return Status::Ok();
}

Status CheckPreset(const Preset& preset) {
  float sum = 0;
  for (const auto& entry : preset.look.mix()) sum += entry.weight();
  if (preset.look.mix_size() > net::kMaxMix) {
    return Status::Error("presets." + preset.name + ": " + std::to_string(preset.look.mix_size()) +
                         " styles; expected at most " + std::to_string(net::kMaxMix));
  }
  if (sum > net::kMaxStrength) {
    return Status::Error("presets." + preset.name + ": weights sum to " + NumberText(sum) +
                         "; expected at most 1.5");
  }
  return Status::Ok();
}

}  // namespace

bool IsName(std::string_view text) noexcept {
  return !text.empty() && text.size() <= 32 && std::all_of(text.begin(), text.end(), [](char c) {
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '_' ||
           c == '-';
  });
}

bool IsPerformerId(std::string_view text) noexcept {
  const std::size_t dot = text.find('.');
  return dot != std::string_view::npos && IsName(text.substr(0, dot)) &&
         IsName(text.substr(dot + 1));
}

bool RequiresKeys(const Config& config, std::string_view address,
                  bool allow_unauthenticated_remote) {
  return !IsLocal(address) && !config.security.keys.empty() && !allow_unauthenticated_remote;
}

Status Validate(const Config& config) {
  Status status = CheckSources(config.sources);
  if (!status.ok()) return status;
  status = CheckOutputs(config.outputs);
  if (!status.ok()) return status;
  status = CheckSocket(config, "publish", config.publish, "subscribers");
  if (!status.ok()) return status;
  status = CheckSocket(config, "control", config.control, "operators");
  if (!status.ok()) return status;
  status = CheckOsc(config.osc);
  if (!status.ok()) return status;
  status = CheckStandby(config);
  if (!status.ok()) return status;
  status = CheckClashes(config);
  if (!status.ok()) return status;
  status = CheckCues(config.cues, config.sources);
  if (!status.ok()) return status;
  if (const auto options = config.model.stylist.Validate(); !options.ok()) {
    return Status::Error("model." + options.message());
  }
  if (config.performers.late_s > config.performers.backlog_s) {
    return Status::Error("performers.late_ms: expected at most performers.backlog_ms");
  }
  for (const auto& preset : config.presets) {
    status = CheckPreset(preset);
    if (!status.ok()) return status;
  }
  return Status::Ok();
}

}  // namespace styled::config
