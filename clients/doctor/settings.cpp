#include "clients/doctor/settings.h"

#include <toml++/toml.h>

#include "clients/doctor/format.h"
#include "model/base/read_file.h"
#include "model/base/toml_nesting.h"

namespace styled::doctor {
namespace {

std::string TextOf(const toml::table& table, std::string_view key, std::string_view otherwise) {
  return table[key].value_or(std::string(otherwise));
}

ExpectedSource ReadSource(const toml::table& table) {
  ExpectedSource out = MakeExpected(ExpectedSource::Origin::kConfig, TextOf(table, "name", "rig"),
                                    TextOf(table, "type", "udp"), TextOf(table, "listen", ""));
  out.merge_into = TextOf(table, "merge_into", "");
  out.server = TextOf(table, "server", "");
  // The queried server, which is all that matters of such a source.
  if (const auto* type = rigs::FindSourceType(out.type);
      type != nullptr && type->rig->asks_server) {
    const bool has_port = out.server.find(':') != std::string::npos;
    out.listen = ParseEndpoint(has_port ? out.server
                                        : out.server + ":" + std::to_string(type->rig->server_port))
                     .value_or(Endpoint{out.server, 0});
    out.network = true;
  }
  out.group = TextOf(table, "group", out.group);
  out.interface = TextOf(table, "interface", "");
  out.multicast = table["multicast"].value_or(true);
  return out;
}

// A face without merge_into is the only performer's of another source; without one, or with a body,
// it is a performer of its own. As the daemon reads it (daemon/config/sources.cpp).
void AssignFaces(const std::vector<std::string>& bodies, std::vector<ExpectedSource>& sources) {
  const auto alone = [&](std::size_t i) {
    return bodies[i] == "standing" || bodies[i] == "seated";
  };
  const auto may = [&](std::size_t i) {
    return sources[i].merge_into.empty() && Row(sources[i].format).face_only && !alone(i);
  };
  bool others = false;
  for (std::size_t i = 0; i < sources.size(); ++i) {
    others = others || (sources[i].merge_into.empty() && !may(i));
  }
  for (std::size_t i = 0; i < sources.size(); ++i) {
    if (may(i) && (others || bodies[i] == "none")) sources[i].merge_into = "*";
  }
}

Settings ReadTable(const toml::table& table) {
  Settings out;
  std::vector<std::string> bodies;
  if (const toml::array* sources = table["source"].as_array()) {
    for (const auto& node : *sources) {
      const toml::table* source = node.as_table();
      if (source == nullptr) continue;
      out.sources.push_back(ReadSource(*source));
      bodies.push_back(TextOf(*source, "body", ""));
    }
  }
  AssignFaces(bodies, out.sources);
  if (const toml::table* control = table["control"].as_table()) {
    out.control = TextOf(*control, "address", "");
  }
  if (out.sources.empty()) out.sources = AssumedSources();
  return out;
}

}  // namespace

ExpectedSource MakeExpected(ExpectedSource::Origin origin, const std::string& name,
                            const std::string& type, const std::string& listen) {
  ExpectedSource out;
  out.origin = origin;
  out.name = name;
  out.type = type;
  out.format = FormatOfType(type);
  out.stream = IsStreamType(type);
  if (const auto endpoint = ParseEndpoint(listen)) {
    out.listen = *endpoint;
  } else if (listen.empty() && out.format != Format::kUnknown) {
    // A client that connects to its server uses any port.
    const auto& rig = Row(out.format);
    out.listen = {"0.0.0.0", rig.asks_server ? std::uint16_t{0} : rig.ports[0]};
  } else {
    out.network = false;
  }
  return out;
}

Result<Settings> ReadSettings(const std::string& file) {
  constexpr std::size_t kMaxBytes = 1 << 20;  // the same limit as the daemon's
  const auto text = ReadFile(file, kMaxBytes);
  if (!text.ok()) return text.status();
  if (const auto line = FindTooDeepToml(text.value())) {
    return Status::Error(file + ":" + std::to_string(*line) + ": " + TooDeepToml());
  }
  try {
    return ReadTable(toml::parse(text.value(), file));
  } catch (const toml::parse_error& e) {
    return Status::Error(file + ":" + std::to_string(e.source().begin.line) + ": " +
                         std::string(e.description()));
  }
}

Result<ExpectedSource> ParseListen(const std::string& text) {
  const std::size_t equals = text.find('=');
  const std::string type = text.substr(0, equals);
  const std::string listen = equals == std::string::npos ? "" : text.substr(equals + 1);
  if (FormatOfType(type) == Format::kUnknown) {
    return Status::Error("'" + text +
                         "': expected TYPE=HOST:PORT, TYPE as a source's: " + NetworkTypes());
  }
  const auto endpoint = ParseEndpoint(listen);
  if (!endpoint || !IsNumeric(endpoint->host)) {
    return Status::Error("'" + text + "': expected TYPE=HOST:PORT, HOST numeric, e.g. " + type +
                         "=0.0.0.0:9763");
  }
  return MakeExpected(ExpectedSource::Origin::kOption, type, type, listen);
}

std::vector<ExpectedSource> AssumedSources() {
  return {MakeExpected(ExpectedSource::Origin::kAssumed, "rig", "udp", "127.0.0.1:7000"),
          MakeExpected(ExpectedSource::Origin::kAssumed, "rig", "tcp", "127.0.0.1:7000")};
}

}  // namespace styled::doctor
