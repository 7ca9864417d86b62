#include "clients/rec/info.h"

#include <algorithm>
#include <array>
#include <cstdio>
#include <ctime>
#include <map>
#include <nlohmann/json.hpp>
#include <set>
#include <string>
#include <vector>

#include "model/base/text.h"

namespace styled::rec {
namespace {

using nlohmann::json;

struct Flow {
  std::uint64_t count = 0, bytes = 0;
  std::int64_t first_ns = 0, last_ns = 0;
  std::set<std::string> peers;
  std::string type, listen;

  void Add(std::int64_t time_ns, std::size_t size) {
    if (count++ == 0) first_ns = time_ns;
    last_ns = time_ns;
    bytes += size;
  }
  double rate_hz() const {
    const double seconds = static_cast<double>(last_ns - first_ns) * 1e-9;
    return seconds > 0 ? static_cast<double>(count - 1) / seconds : 0;
  }
};

struct Line {
  std::int64_t time_ns;
  std::string text;
};

struct Summary {
  std::int64_t first_ns = 0, last_ns = 0;
  std::map<std::string, Flow> arrivals, published;
  std::vector<Line> commands, notes;
};

std::string Text(const recording::Command& command) {
  const auto& request = command.request();
  std::string text = request.performer();
  const auto add = [&text](const std::string& word) { text += (text.empty() ? "" : " ") + word; };
  if (request.has_set()) {
    add(request.set().clear() ? "clear" : "set");
    for (const auto& style : request.set().mix()) {
      std::array<char, 32> weight{};
      std::snprintf(weight.data(), weight.size(), "=%g", static_cast<double>(style.weight()));
      add(style.style() + weight.data());
    }
  }
  if (request.has_pin()) add(request.pin().pinned() ? "pin" : "unpin");
  if (request.has_preset()) add("preset " + request.preset().name());
  if (request.has_panic()) add("panic");
  if (request.has_reset()) add("reset");
  if (request.has_cue()) add("cue " + request.cue().name());
  if (request.has_like()) add("like " + request.like().name());
  if (request.has_calibrate()) {
    const v1::Calibrate& calibrate = request.calibrate();
    const char* const pose = calibrate.pose() == v1::Calibrate::POSE_N ? "n" : "t";
    add(std::string("calibrate ") + (calibrate.clear() ? "clear" : pose) +
        (calibrate.neutral() ? " neutral" : ""));
  }
  if (request.has_import_style()) add("import style " + request.import_style().name());
  if (request.has_rename_style()) {
    add("rename style " + request.rename_style().name() + " to " + request.rename_style().to());
  }
  if (request.has_remove_style()) add("remove style " + request.remove_style().name());
  if (request.has_restore_checkpoint()) add("restore checkpoint");
  for (const auto& applied : command.applied()) {
    add("[" + applied.performer() + " from " + std::to_string(applied.first_sequence()) + "]");
  }
  return text;
}

Summary Gather(recording::Reader& reader) {
  Summary summary;
  recording::Record record;
  reader.Rewind();
  while (reader.Next(record)) {
    const std::int64_t time_ns = record.time_ns();
    const bool first = reader.counts().records == 1;
    summary.first_ns = first ? time_ns : std::min(summary.first_ns, time_ns);
    summary.last_ns = first ? time_ns : std::max(summary.last_ns, time_ns);
    if (record.has_arrival()) {
      const auto& arrival = record.arrival();
      Flow& flow = summary.arrivals[arrival.source()];
      flow.Add(time_ns, arrival.datagram().size());
      flow.type = arrival.type();
      flow.listen = arrival.listen();
      if (flow.peers.size() < 1000) flow.peers.insert(arrival.peer());
    } else if (record.has_published()) {
      const auto& published = record.published();
      summary.published[published.topic()].Add(time_ns, published.payload().size());
    } else if (record.has_command()) {
      summary.commands.push_back({time_ns, Text(record.command())});
    } else if (record.has_note()) {
      summary.notes.push_back({time_ns, record.note().text()});
    }
  }
  return summary;
}

double Seconds(std::int64_t from_ns, std::int64_t to_ns) {
  return static_cast<double>(to_ns - from_ns) * 1e-9;
}

// The text may come from an untrusted sender: one line, without escape sequences.
std::string Plain(const std::string& text) {
  constexpr std::size_t kMost = 4000;  // bytes
  return Printable(text, kMost);
}

template <typename... Values>
std::string Format(const char* format, Values... values) {
  std::array<char, 256> text{};
  std::snprintf(text.data(), text.size(), format, values...);
  return text.data();
}

std::string Date(std::int64_t unix_ns) {
  const std::time_t seconds = unix_ns / 1'000'000'000;
  std::tm parts{};
  gmtime_r(&seconds, &parts);
  std::array<char, 64> text{};
  const std::size_t size = std::strftime(text.data(), text.size(), "%Y-%m-%d %H:%M:%S UTC", &parts);
  return {text.data(), size};
}

void WriteText(const recording::Reader& reader, const Summary& summary, std::ostream& out) {
  const auto& header = reader.header();
  const auto& counts = reader.counts();
  out << Plain(reader.name()) << ": "
      << Format("%.3f s, %llu records in %llu blocks\n", Seconds(summary.first_ns, summary.last_ns),
                static_cast<unsigned long long>(counts.records),
                static_cast<unsigned long long>(counts.blocks));
  if (header.created_unix_ns() != 0) {
    out << "begun " << Date(header.created_unix_ns()) << " by " << Plain(header.program()) << " "
        << Plain(header.version()) << "\n";
  }
  if (!header.description().empty()) out << "description: " << Plain(header.description()) << "\n";
  if (!header.weights().empty()) {
    out << "weights: " << Plain(header.weights()) << " " << Plain(header.weights_hash()) << "\n";
  }
  if (!header.config().empty()) out << "configuration: " << header.config().size() << " bytes\n";
  if (!header.state().empty()) out << "state: " << header.state().size() << " bytes\n";
  for (const auto& [source, flow] : summary.arrivals) {
    out << "arrivals: " << Plain(source) << " (" << Plain(flow.type) << ", at "
        << Plain(flow.listen) << ") "
        << Format("%llu datagrams, %llu bytes, %.2f/s, %zu senders\n",
                  static_cast<unsigned long long>(flow.count),
                  static_cast<unsigned long long>(flow.bytes), flow.rate_hz(), flow.peers.size());
  }
  for (const auto& [topic, flow] : summary.published) {
    out << "published: " << Plain(topic) << " "
        << Format("%llu messages, %llu bytes, %.2f/s\n",
                  static_cast<unsigned long long>(flow.count),
                  static_cast<unsigned long long>(flow.bytes), flow.rate_hz());
  }
  const auto lines = [&](const char* word, const std::vector<Line>& all) {
    for (const Line& line : all) {
      out << word << Format("%.3f s: ", Seconds(summary.first_ns, line.time_ns)) << Plain(line.text)
          << "\n";
    }
  };
  lines("command at ", summary.commands);
  lines("note at ", summary.notes);
  const std::string damage = recording::DamageText(counts);
  if (!damage.empty()) out << "damage: " << damage << "\n";
}

json LinesJson(const Summary& summary, const std::vector<Line>& all) {
  json array = json::array();
  for (const Line& line : all) {
    array.push_back({{"at_s", Seconds(summary.first_ns, line.time_ns)}, {"text", line.text}});
  }
  return array;
}

json MakeJson(const recording::Reader& reader, const Summary& summary) {
  const auto& header = reader.header();
  const auto& counts = reader.counts();
  json object{{"file", reader.name()},
              {"seconds", Seconds(summary.first_ns, summary.last_ns)},
              {"records", counts.records},
              {"blocks", counts.blocks},
              {"created_unix_ns", header.created_unix_ns()},
              {"program", header.program()},
              {"version", header.version()},
              {"description", header.description()},
              {"weights", header.weights()},
              {"weights_hash", header.weights_hash()},
              {"config", header.config()},
              {"state", header.state()},
              {"arrivals", json::array()},
              {"published", json::array()},
              {"commands", LinesJson(summary, summary.commands)},
              {"notes", LinesJson(summary, summary.notes)},
              {"skipped_bytes", counts.skipped_bytes},
              {"lost_blocks", counts.lost_blocks},
              {"malformed", counts.malformed},
              {"tail_bytes", counts.tail_bytes}};
  for (const auto& [source, flow] : summary.arrivals) {
    object["arrivals"].push_back({{"source", source},
                                  {"type", flow.type},
                                  {"listen", flow.listen},
                                  {"datagrams", flow.count},
                                  {"bytes", flow.bytes},
                                  {"rate_hz", flow.rate_hz()},
                                  {"senders", flow.peers.size()}});
  }
  for (const auto& [topic, flow] : summary.published) {
    object["published"].push_back({{"topic", topic},
                                   {"messages", flow.count},
                                   {"bytes", flow.bytes},
                                   {"rate_hz", flow.rate_hz()}});
  }
  return object;
}

}  // namespace

void Info(recording::Reader& reader, bool as_json, std::ostream& out) {
  const Summary summary = Gather(reader);
  if (as_json) {
    // Everything but ASCII is escaped, because it includes control characters.
    out << MakeJson(reader, summary).dump(-1, ' ', true, json::error_handler_t::replace) << "\n";
  } else {
    WriteText(reader, summary, out);
  }
}

}  // namespace styled::rec
