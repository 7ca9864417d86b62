#include "daemon/config/sources.h"

#include <arpa/inet.h>

#include <algorithm>

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
                         "\" has no address; usb_id and serial say which devices it means");
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

// `server` of a phone that is asked: a daemon that asks itself would never hear of the phone.
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
                         "\" is where the source itself listens; expected the phone's address");
  }
  return Status::Ok();
}

// Below this a body would hardly follow its performer.
constexpr float kLeastSmooth_hz = 0.1F;

// `merge_into` of source `i`: a performer of another source that has performers.
Status CheckMerge(const std::vector<Source>& sources, std::size_t i, const rigs::RigType& rig) {
  const std::string& into = sources[i].merge_into;
  if (into.empty()) {
    if (!rig.face_only) return Status::Ok();
    return Status::Error("merge_into: missing; a source of type \"" + sources[i].type +
                         "\" is the face of a performer, SOURCE.NAME, e.g. \"stage.anna\"");
  }
  if (!rig.has_face) {
    return Status::Error("merge_into: a source of type \"" + sources[i].type +
                         "\" has no face; expected one of " + rigs::FaceTypes());
  }
  const std::size_t dot = into.find('.');
  const bool named = dot != std::string::npos && IsName(into.substr(dot + 1));
  const auto is_source = [&](const Source& source) {
    return named && source.merge_into.empty() && source.name == into.substr(0, dot);
  };
  if (std::ranges::any_of(sources, is_source)) return Status::Ok();
  return Status::Error("merge_into: \"" + Shown(into) +
                       "\"; expected a performer of another source, SOURCE.NAME, whose source has "
                       "no merge_into");
}

}  // namespace

Status CheckTrackers(const std::vector<Tracker>& trackers) {
  std::vector<slimevr::TrackerId> ids;
  std::vector<int> parts;
  for (const auto& [id_text, part_text] : trackers) {
    const auto id = slimevr::ParseTrackerId(id_text);
    const int part = body::FindJoint(part_text);
    std::string place = "trackers: \"";
    place.append(id_text).append("\" = \"").append(part_text).append("\": ");
    if (!id) {
      return Status::Error(place +
                           "expected a tracker's address of 12 hexadecimal digits, or its "
                           "IPv4 address, and /N for its sensor N");
    }
    if (part < 0) {
      return Status::Error(place + "expected a joint, e.g. \"hips\", \"chest\", \"leftUpperLeg\"");
    }
    if (std::ranges::find(ids, *id) != ids.end()) return Status::Error(place + "given twice");
    if (std::ranges::find(parts, part) != parts.end()) {
      return Status::Error(place + "another tracker is on that part");
    }
    ids.push_back(*id);
    parts.push_back(part);
  }
  return Status::Ok();
}

Result<sockaddr_in> ParseServer(const std::string& text, std::uint16_t default_port) {
  const auto refuse = [&text, default_port] {
    return Status::Error("server: \"" + text +
                         "\"; expected an IPv4 address, or one and a port, e.g. "
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
  if (sources.empty()) return Status::Error("no [[source]]: nothing could come in");
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
    if (const Status status = CheckTrackers(sources[i].trackers); !status.ok()) {
      return Status::Error(place + status.message());
    }
    const rigs::SourceType& type = *rigs::FindSourceType(sources[i].type);
    if (type.usb) {
      Status status = CheckUsb(sources[i], place);
      if (!status.ok()) return status;
      continue;
    }
    if (const Status status = CheckMerge(sources, i, *type.rig); !status.ok()) {
      return Status::Error(place + status.message());
    }
    if (const float hz = sources[i].smoothing.rest_hz; hz > 0 && hz < kLeastSmooth_hz) {
      return Status::Error(place + "smooth_hz: found " + NumberText(hz) +
                           ", expected 0, or 0.1 to 60 Hz");
    }
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
