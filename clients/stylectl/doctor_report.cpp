#include "clients/stylectl/doctor_report.h"

#include <algorithm>
#include <array>
#include <cstdio>
#include <iterator>
#include <nlohmann/json.hpp>

#include "clients/stylectl/cli.h"
#include "clients/stylectl/report.h"

namespace styled::stylectl {
namespace {

using doctor::Facts;
using doctor::Finding;
using doctor::Flow;
using doctor::PlaceOf;
using doctor::Severity;
using doctor::SourceFacts;
using nlohmann::json;

constexpr std::size_t kTextWidth = 96;

std::string Rate(double rate_hz) {
  std::array<char, 32> text{};
  std::snprintf(text.data(), text.size(), "%.1f", rate_hz);
  return text.data();
}

bool Healthy(const std::vector<Finding>& findings) {
  return std::ranges::none_of(findings,
                              [](const Finding& f) { return f.severity == Severity::kProblem; });
}

// The closing line if there is no problem; frames arrive in spite of a warning.
std::string Conclusion(const std::vector<Finding>& findings) {
  if (!Healthy(findings)) return "";
  const auto warnings = std::ranges::count_if(
      findings, [](const Finding& f) { return f.severity == Severity::kWarning; });
  if (warnings == 0) return "\nAll is well: frames arrive and are published.\n";
  return "\nFrames arrive and are published, except for " + std::to_string(warnings) +
         (warnings == 1 ? " warning.\n" : " warnings.\n");
}

// `text`, its first line wrapped to kTextWidth, the others as they are: the first line follows
// `head`, the others are indented to the same column.
std::string Paragraph(const std::string& head, const std::string& text) {
  if (text.empty()) return "";
  std::string out = head, line;
  const std::string indent(head.size(), ' ');
  const std::size_t wrapped = std::min(text.find('\n'), text.size());
  std::size_t begin = 0;
  while (begin < wrapped) {
    const std::size_t end = std::min(text.find(' ', begin), wrapped);
    const std::string word = text.substr(begin, end - begin);
    if (!line.empty() && head.size() + line.size() + 1 + word.size() > kTextWidth) {
      out.append(line).append("\n").append(indent);
      line.clear();
    }
    line += (line.empty() ? "" : " ") + word;
    begin = end + 1;
  }
  out += line + "\n";
  for (std::size_t at = wrapped; at < text.size();) {
    const std::size_t end = std::min(text.find('\n', at + 1), text.size());
    out.append(indent).append(text, at + 1, end - at - 1).append("\n");
    at = end;
  }
  return out;
}

std::string DaemonText(const Facts& facts) {
  if (!facts.daemon_answers()) return "no answer at " + facts.daemon.endpoint;
  int live = 0;
  for (const auto& performer : facts.daemon.after.stats().performers()) live += performer.live();
  return "styled " + facts.daemon.after.version() + " at " + facts.daemon.endpoint + ", " +
         std::to_string(live) + " live performer" + (live == 1 ? "" : "s");
}

std::string InterfacesText(const Facts& facts) {
  std::string out;
  for (const auto& interface : facts.interfaces) {
    if (!interface.up) continue;
    std::string row = interface.name;
    for (const auto& address : interface.addresses) row += " " + address;
    if (interface.addresses.empty()) row += " (no address)";
    if (!interface.running) row += " (no link)";
    if (!interface.multicast && !interface.loopback) row += " (no multicast)";
    out += (out.empty() ? "" : ", ") + row;
  }
  return out.empty() ? "none is up" : out;
}

std::string SourcesText(const Facts& facts) {
  std::vector<std::vector<std::string>> rows{{"SOURCE", "TYPE", "LISTENS", "HELD BY", "RECEIVED"}};
  for (const SourceFacts& source : facts.sources) {
    const auto& expected = source.expected;
    std::string holder = source.in_daemon ? "styled" : "nobody";
    if (!source.in_daemon && !source.holders.empty()) holder = source.holders.front().program;
    if (holder.empty()) holder = "another user";
    const std::string asks = doctor::Row(expected.format).asks_server ? "asks " : "";
    rows.push_back({expected.name, expected.type,
                    expected.network ? asks + PlaceOf(expected.listen, expected.stream) : "-",
                    holder, source.received ? std::to_string(*source.received) : "-"});
  }
  return Table(rows);
}

std::string TrafficText(const std::vector<Flow>& flows, const std::string& head) {
  if (flows.empty()) return "";
  std::vector<std::vector<std::string>> rows{
      {head, "FROM", "BY", "DATAGRAMS", "HZ", "BYTES EACH", "FORMAT", "WHAT"}};
  for (const Flow& flow : flows) {
    const auto format = flow.tally.MainFormat();
    const std::string sizes = flow.smallest == flow.largest ? std::to_string(flow.smallest)
                                                            : std::to_string(flow.smallest) + ".." +
                                                                  std::to_string(flow.largest);
    rows.push_back({PlaceOf(flow.to, flow.stream), doctor::ToString(flow.from), flow.interface,
                    std::to_string(flow.datagrams), Rate(flow.rate_hz()), sizes,
                    std::string(doctor::Row(format).name), flow.tally.Kinds(format)});
  }
  return Table(rows);
}

// Flows that arrived at an interface, but at none of this program's sockets.
std::vector<Flow> OnlySeen(const Facts& facts) {
  std::vector<Flow> out;
  std::ranges::copy_if(facts.seen, std::back_inserter(out), [&facts](const Flow& seen) {
    return std::ranges::none_of(facts.heard, [&seen](const Flow& heard) {
      return !heard.stream && heard.to == seen.to && heard.from.host == seen.from.host;
    });
  });
  return out;
}

json FlowJson(const Flow& flow, const char* by) {
  json kinds = json::array();
  for (const auto& kind : flow.tally.kinds) {
    kinds.push_back({{"format", doctor::Row(kind.what.format).word},
                     {"verdict", doctor::Name(kind.what.verdict)},
                     {"kind", kind.what.kind},
                     {"count", kind.count}});
  }
  return {{"by", by},
          {"to", doctor::ToString(flow.to)},
          {"protocol", flow.stream ? "tcp" : "udp"},
          {"from", doctor::ToString(flow.from)},
          {"interface", flow.interface},
          {"datagrams", flow.datagrams},
          {"bytes", flow.bytes},
          {"rate_hz", flow.rate_hz()},
          {"format", doctor::Row(flow.tally.MainFormat()).word},
          {"kinds", kinds}};
}

std::string PerformersText(const Facts& facts) {
  std::vector<std::vector<std::string>> rows{{"PERFORMER", "STATE", "HZ", "RECEIVED", "LOST"}};
  for (const auto& performer : facts.daemon.after.stats().performers()) {
    rows.push_back({performer.performer(), performer.live() ? "live" : "silent",
                    Rate(performer.rate_hz()), std::to_string(performer.received()),
                    std::to_string(performer.lost())});
  }
  return rows.size() > 1 ? Table(rows) : "";
}

json SourceJson(const SourceFacts& source) {
  json out{{"name", source.expected.name},
           {"type", source.expected.type},
           {"listen", doctor::ToString(source.expected.listen)},
           {"in_daemon", source.in_daemon},
           {"kernel_drops", source.drops}};
  if (source.received) out["received"] = *source.received;
  json holders = json::array();
  for (const auto& holder : source.holders) {
    holders.push_back({{"listen", doctor::ToString(holder.local)},
                       {"pid", holder.pid},
                       {"program", holder.program},
                       {"waiting_bytes", holder.waiting_bytes},
                       {"drops", holder.drops}});
  }
  out["holders"] = holders;
  return out;
}

}  // namespace

std::string DoctorText(const Facts& facts, const std::vector<Finding>& findings) {
  std::string out = Paragraph("DAEMON      ", DaemonText(facts)) +
                    Paragraph("INTERFACES  ", InterfacesText(facts)) + "\n" + SourcesText(facts);
  const auto add = [&out](const std::string& text) { out += text.empty() ? "" : "\n" + text; };
  add(PerformersText(facts));
  add(TrafficText(facts.heard, "HEARD AT"));
  add(TrafficText(OnlySeen(facts), "SEEN FOR"));
  if (facts.heard.empty() && facts.seen.empty()) {
    add("Nothing arrived on the free ports in " + doctor::Seconds(facts.seconds) + ".\n");
  }
  if (!facts.capture.empty()) {
    out += Paragraph("",
                     "Only free ports could be examined; with sudo, doctor also sees data "
                     "that arrives at ports of other programs.");
  }
  for (const Finding& finding : findings) {
    std::string head = doctor::Name(finding.severity);
    std::ranges::transform(head, head.begin(), [](unsigned char c) { return std::toupper(c); });
    head.resize(9, ' ');
    out += "\n" + Paragraph(head, finding.what) + Paragraph("  Why:   ", finding.why) +
           Paragraph("  Do:    ", finding.change);
  }
  return out + Conclusion(findings);
}

json DoctorJson(const Facts& facts, const std::vector<Finding>& findings) {
  json found = json::array(), sources = json::array(), traffic = json::array(),
       interfaces = json::array();
  for (const Finding& f : findings) {
    found.push_back({{"severity", doctor::Name(f.severity)},
                     {"step", doctor::Name(f.step)},
                     {"code", f.code},
                     {"source", f.source},
                     {"what", f.what},
                     {"why", f.why},
                     {"change", f.change}});
  }
  for (const SourceFacts& source : facts.sources) sources.push_back(SourceJson(source));
  json performers = json::array();
  for (const auto& performer : facts.daemon.after.stats().performers()) {
    performers.push_back({{"performer", performer.performer()},
                          {"live", performer.live()},
                          {"rate_hz", performer.rate_hz()}});
  }
  for (const Flow& flow : facts.heard) traffic.push_back(FlowJson(flow, "socket"));
  for (const Flow& flow : facts.seen) traffic.push_back(FlowJson(flow, "interface"));
  for (const auto& interface : facts.interfaces) {
    interfaces.push_back({{"name", interface.name},
                          {"up", interface.up},
                          {"running", interface.running},
                          {"multicast", interface.multicast},
                          {"loopback", interface.loopback},
                          {"addresses", interface.addresses}});
  }
  return {{"ok", Healthy(findings)},
          {"seconds", facts.seconds},
          {"daemon",
           {{"endpoint", facts.daemon.endpoint},
            {"answers", facts.daemon_answers()},
            {"version", facts.daemon.after.version()}}},
          {"captured", facts.capture.empty()},
          {"interfaces", interfaces},
          {"sources", sources},
          {"performers", performers},
          {"traffic", traffic},
          {"findings", found}};
}

int RunDoctor(const doctor::Options& options, bool json_wanted, std::ostream& out,
              std::ostream& err) {
  if (!json_wanted) err << "listening for " << doctor::Seconds(options.seconds) << " ...\n";
  err.flush();
  const auto facts = doctor::Examine(options);
  if (!facts.ok()) {
    const std::string& why = facts.status().message();
    err << "stylectl: doctor: " << why << "\n";
    if (json_wanted) {
      out << json{{"ok", false}, {"code", "USAGE"}, {"reason", why}}.dump() << "\n";
    }
    return kExitUsage;
  }
  const auto findings = doctor::Diagnose(facts.value());
  if (json_wanted) {
    out << DoctorJson(facts.value(), findings).dump() << "\n";
  } else {
    out << DoctorText(facts.value(), findings);
  }
  return Healthy(findings) ? kExitOk : kExitRefused;
}

}  // namespace styled::stylectl
