#include "daemon/config/sources.h"

#include <arpa/inet.h>

#include <algorithm>
#include <array>

#include "daemon/config/address.h"
#include "daemon/config/shown.h"
#include "daemon/runtime/host_port.h"
#include "model/base/text.h"
#include "model/body/find_joint.h"
#include "proto/rigs/slimevr/tracker_id.h"
#include "proto/rigs/types.h"

namespace styled::config {
namespace {

// `place` is the prefix of errors, e.g. "source.0.".
Status CheckUsb(const Source& source, const std::string& place) {
  if (!source.listen.empty()) {
    return Status::Error(place + "listen: a source of type \"" + source.type +
                         "\" has no address; usb_id and serial select its devices");
  }
  if (source.usb_id.empty() && source.type == "usb") {
    return Status::Error(place + "usb_id: missing; expected VENDOR:PRODUCT of the device");
  }
  if (source.usb_id.empty()) return Status::Ok();
  const auto id = ParseUsbId(source.usb_id);
  return id.ok() ? Status::Ok() : Status::Error(place + "usb_id: " + id.status().message());
}

Status CheckServer(const Source& source, const rigs::RigType& rig) {
  const auto server = ParseServer(source.server, rig.server_port);
  return server.ok() ? ParseGroup(source.group).status() : server.status();
}

// `server` of a phone: a daemon that names its own address would send the start text to itself.
Status CheckPhone(const Source& source, const rigs::RigType& rig) {
  const auto phone = ParseServer(source.server, rig.ports[0]);
  if (!phone.ok()) {
    return Status::Error("server: \"" + Shown(source.server) +
                         "\"; expected the phone's IPv4 address, or it and a port, e.g. "
                         "\"192.168.1.20\"");
  }
  const auto own = runtime::ParseHostPort(source.listen);
  in_addr listens{};
  if (own.ok() && own.value().port == ntohs(phone.value().sin_port) &&
      inet_pton(AF_INET, own.value().host.c_str(), &listens) == 1 &&
      listens.s_addr == phone.value().sin_addr.s_addr) {
    return Status::Error("server: \"" + Shown(source.server) +
                         "\" is the source's own address; expected the phone's address");
  }
  return Status::Ok();
}

// Keys that would have no effect. A key with its default value is not known to be set.
Status CheckMeaning(const Source& source, const rigs::RigType& rig) {
  const auto refuse = [&source](const char* key, const std::string& types) {
    return Status::Error(std::string(key) + ": a source of type \"" + source.type +
                         "\" does not use it; only types " + types + " do");
  };
  if (!source.server.empty() && !rig.takes_server) return refuse("server", rigs::ServerTypes());
  if (source.expressions != Source().expressions && !rig.takes_expressions) {
    return refuse("expressions", rigs::ExpressionTypes());
  }
  return Status::Ok();
}

// Below this a body would follow its performer too slowly.
constexpr float kLeastSmooth_hz = 0.1F;

// The name of the only performer of a source whose rig sends no name; "": the rig sends names.
std::string OnlyName(const Source& source, const rigs::RigType& rig) {
  const auto sends_none = {rigs::kIFacialMocap.word, rigs::kLiveLinkFace.word, rigs::kMocopi.word,
                           rigs::kSlimeVr.word,      rigs::kVmc.word,          rigs::kVrChat.word};
  if (std::ranges::find(sends_none, rig.word) == sends_none.end()) return "";
  return source.performer.empty() ? source.name : source.performer;
}

// A performer that another source can have.
Status CheckTarget(const std::vector<Source>& sources, const Source& merged) {
  const std::string& into = merged.merge_into;
  const std::string expected =
      "expected a performer of another source, SOURCE.NAME, whose source has no merge_into";
  if (into == kOnlyPerformer) {
    if (merged.Merges("leftFingers") || merged.Merges("rightFingers")) {
      return Status::Error("merge_into: \"*\" is for a face alone; " + expected);
    }
    if (std::ranges::any_of(sources, [](const Source& s) { return s.merge_into.empty(); })) {
      return Status::Ok();
    }
    return Status::Error("merge_into: no source has performers; add a [[source]] of the rig");
  }
  const std::size_t dot = into.find('.');
  const std::string name = dot == std::string::npos ? "" : into.substr(dot + 1);
  const Source* source = nullptr;  // several may have one name
  std::string only;
  for (const Source& one : sources) {
    if (!IsName(name) || !one.merge_into.empty() || one.name != into.substr(0, dot)) continue;
    source = &one;
    only = OnlyName(one, *rigs::FindSourceType(one.type)->rig);
    if (only.empty() || only == name) return Status::Ok();
  }
  if (source == nullptr) return Status::Error("merge_into: \"" + Shown(into) + "\"; " + expected);
  return Status::Error("merge_into: \"" + into + "\"; the performer of source \"" + source->name +
                       "\" is \"" + source->name + "." + only + "\", because type \"" +
                       source->type + "\" sends no name; expected that, or performer = \"" + name +
                       "\" there");
}

// `merge_into` of source `i`.
Status CheckMerge(const std::vector<Source>& sources, std::size_t i, const rigs::RigType& rig) {
  if (sources[i].body != Source().body && !rig.face_only) {
    return Status::Error("body: a source of type \"" + sources[i].type +
                         "\" sends a body; only types livelinkface and ifacialmocap get one");
  }
  if (sources[i].FaceAlone() && !sources[i].merge_into.empty()) {
    return Status::Error(
        "body: \"" + sources[i].body + "\" and merge_into: \"" + sources[i].merge_into +
        "\"; expected one of them: a body of its own, or another performer's face");
  }
  if (sources[i].merge_into.empty()) {
    if (!sources[i].parts.empty()) {
      return Status::Error(
          "parts: only for a source with merge_into, the performer that gets them");
    }
    return Status::Ok();
  }
  if (sources[i].Merges("face") && !rig.has_face) {
    return Status::Error(sources[i].parts.empty()
                             ? "parts: missing; a source of type \"" + sources[i].type +
                                   "\" has no face" +
                                   (rig.has_fingers ? ", expected [\"fingers\"]" : "")
                             : "parts: \"face\": a source of type \"" + sources[i].type +
                                   "\" has none; expected one of " + rigs::FaceTypes());
  }
  const bool fingers = sources[i].Merges("leftFingers") || sources[i].Merges("rightFingers");
  if (fingers && !rig.has_fingers) {
    return Status::Error("parts: \"fingers\": a source of type \"" + sources[i].type +
                         "\" has none; expected one of " + rigs::FingerTypes());
  }
  return CheckTarget(sources, sources[i]);
}

// The prefix of errors of a row of `trackers`.
std::string Place(const Tracker& row) {
  return "trackers: \"" + Shown(row.id) + "\" = \"" + Shown(row.part) + "\": ";
}

// Checks the keys that all rows must have; adds the row's part to `parts`.
Status CheckRow(const Tracker& row, bool twice, std::vector<int>& parts) {
  const int part = body::FindJoint(row.part);
  if (part < 0) {
    return Status::Error(Place(row) +
                         "expected a joint, e.g. \"hips\", \"chest\", \"leftUpperLeg\"");
  }
  if (twice) return Status::Error(Place(row) + "given twice");
  if (std::ranges::find(parts, part) != parts.end()) {
    return Status::Error(Place(row) + "another tracker is on that part");
  }
  parts.push_back(part);
  return Status::Ok();
}

}  // namespace

bool Source::Merges(std::string_view part) const {
  if (merge_into.empty()) return false;
  if (parts.empty()) return part == "face";
  return std::ranges::any_of(parts, [part](const std::string& word) {
    return word == part || (word == "fingers" && part.ends_with("Fingers"));
  });
}

void AssignFaces(std::vector<Source>& sources) {
  const auto face_only = [](const Source& source) {
    const rigs::SourceType* const type = rigs::FindSourceType(source.type);
    return type != nullptr && type->rig->face_only;
  };
  const bool others = std::ranges::any_of(sources, [&](const Source& source) {
    return source.merge_into.empty() && (!face_only(source) || source.FaceAlone());
  });
  for (Source& source : sources) {
    if (!face_only(source) || !source.merge_into.empty() || source.FaceAlone()) continue;
    if (others || source.body == "none") {
      source.merge_into = kOnlyPerformer;
    } else {
      source.body = "standing";
    }
  }
}

Status CheckTrackers(const std::vector<Tracker>& trackers) {
  std::vector<slimevr::TrackerId> ids;
  std::vector<int> parts;
  for (const Tracker& row : trackers) {
    const auto id = slimevr::ParseTrackerId(row.id);
    if (!id) {
      return Status::Error(Place(row) +
                           "expected a tracker's address of 12 hexadecimal digits, or its "
                           "IPv4 address, and /N for its sensor N");
    }
    if (const Status status = CheckRow(row, std::ranges::find(ids, *id) != ids.end(), parts);
        !status.ok()) {
      return status;
    }
    ids.push_back(*id);
  }
  return Status::Ok();
}

Status CheckDevices(const std::vector<Tracker>& trackers, const rigs::RigType& rig) {
  constexpr std::array<std::string_view, 12> kOfVrChat{"1",
                                                       "2",
                                                       "3",
                                                       "4",
                                                       "5",
                                                       "6",
                                                       "7",
                                                       "8",
                                                       "head",
                                                       "vrsystem/head",
                                                       "vrsystem/leftwrist",
                                                       "vrsystem/rightwrist"};
  constexpr std::size_t kLongest = 64;
  const bool serials = rig.word == rigs::kVmc.word;
  std::vector<std::string_view> names;
  std::vector<int> parts;
  for (const Tracker& row : trackers) {
    if (serials && (row.id.empty() || row.id.size() > kLongest || !IsUtf8(row.id))) {
      return Status::Error(Place(row) + "expected a device's serial of 1 to 64 bytes");
    }
    if (!serials && std::ranges::find(kOfVrChat, row.id) == kOfVrChat.end()) {
      return Status::Error(Place(row) +
                           "expected a tracker, 1 to 8 or head, or vrsystem/head, "
                           "vrsystem/leftwrist, vrsystem/rightwrist");
    }
    if (const Status status = CheckRow(row, std::ranges::find(names, row.id) != names.end(), parts);
        !status.ok()) {
      return status;
    }
    names.push_back(row.id);
  }
  return Status::Ok();
}

Result<sockaddr_in> ParseServer(const std::string& text, std::uint16_t default_port) {
  const auto refuse = [&text, default_port] {
    return Status::Error("server: \"" + text +
                         "\"; expected an IPv4 address, or an address and a port, e.g. "
                         "\"192.168.1.10:" +
                         std::to_string(default_port) + "\"");
  };
  std::string host = text;
  std::uint16_t port = default_port;
  if (text.find(':') != std::string::npos) {
    const auto parsed = runtime::ParseHostPort(text);
    if (!parsed.ok() || parsed.value().port == 0) return refuse();
    host = parsed.value().host;
    port = parsed.value().port;
  }
  sockaddr_in server{};
  server.sin_family = AF_INET;
  server.sin_port = htons(port);
  if (inet_pton(AF_INET, host.c_str(), &server.sin_addr) != 1) return refuse();
  return server;
}

Result<in_addr> ParseGroup(const std::string& text) {
  in_addr group{};
  if (inet_pton(AF_INET, text.c_str(), &group) == 1 && IN_MULTICAST(ntohl(group.s_addr))) {
    return group;
  }
  return Status::Error("group: \"" + text +
                       "\"; expected an IPv4 multicast address, e.g. \"239.255.42.99\"");
}

Status CheckSources(const std::vector<Source>& sources) {
  if (sources.empty()) return Status::Error("no [[source]]: the daemon would receive nothing");
  for (std::size_t i = 0; i < sources.size(); ++i) {
    const std::string place = "source." + std::to_string(i) + ".";
    if (!IsName(sources[i].name)) {
      return Status::Error(place + "name: \"" + Shown(sources[i].name) +
                           "\"; expected 1 to 32 of A-Z a-z 0-9 _ -");
    }
    if (!sources[i].performer.empty() && !IsName(sources[i].performer)) {
      return Status::Error(place + "performer: \"" + Shown(sources[i].performer) +
                           "\"; expected 1 to 32 of A-Z a-z 0-9 _ -");
    }
    const rigs::SourceType& type = *rigs::FindSourceType(sources[i].type);
    const bool named = type.rig->word == rigs::kVmc.word || type.rig->word == rigs::kVrChat.word;
    if (const Status status = named ? CheckDevices(sources[i].trackers, *type.rig)
                                    : CheckTrackers(sources[i].trackers);
        !status.ok()) {
      return Status::Error(place + status.message());
    }
    if (const Status status = CheckMeaning(sources[i], *type.rig); !status.ok()) {
      return Status::Error(place + status.message());
    }
    if (type.usb) {
      Status status = CheckUsb(sources[i], place);
      if (!status.ok()) return status;
    }
    if (const Status status = CheckMerge(sources, i, *type.rig); !status.ok()) {
      return Status::Error(place + status.message());
    }
    if (const float hz = sources[i].smoothing.rest_hz; hz > 0 && hz < kLeastSmooth_hz) {
      return Status::Error(place + "smooth_hz: found " + NumberText(hz) +
                           ", expected 0, or 0.1 to 60 Hz");
    }
    if (type.usb) continue;
    if (type.rig->asks_server) {
      const Status status = CheckServer(sources[i], *type.rig);
      if (!status.ok()) return Status::Error(place + status.message());
    }
    if (type.rig->face_only && !sources[i].server.empty()) {
      const Status status = CheckPhone(sources[i], *type.rig);
      if (!status.ok()) return Status::Error(place + status.message());
    }
    const auto address = runtime::ParseHostPort(sources[i].listen);
    if (!address.ok()) return Status::Error(place + "listen: " + address.status().message());
    if (!IsNumeric(address.value().host)) {
      return Status::Error(place + "listen: \"" + Shown(sources[i].listen) +
                           "\": expected a numeric address, e.g. \"127.0.0.1:7000\"");
    }
  }
  return Status::Ok();
}

}  // namespace styled::config
