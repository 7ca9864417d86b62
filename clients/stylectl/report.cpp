#include "clients/stylectl/report.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <nlohmann/json.hpp>
#include <utility>

#include "clients/cpp/control.h"
#include "clients/stylectl/licence_report.h"
#include "clients/stylectl/look_options.h"
#include "proto/rigs/types.h"

namespace styled::stylectl {
namespace {

using nlohmann::json;

std::string Fixed(double value, int digits) {
  std::array<char, 64> text{};
  std::snprintf(text.data(), text.size(), "%.*f", digits, value);
  return text.data();
}

std::string Hex(std::uint64_t value) {
  std::array<char, 24> text{};
  std::snprintf(text.data(), text.size(), "%016llx", static_cast<unsigned long long>(value));
  return text.data();
}

std::string Duration(double seconds) {
  const auto whole = static_cast<long long>(std::max(0.0, seconds));
  if (whole < 60) return Fixed(seconds, 1) + " s";
  std::array<char, 64> text{};
  std::snprintf(text.data(), text.size(), "%lld:%02lld:%02lld", whole / 3600, whole / 60 % 60,
                whole % 60);
  return text.data();
}

std::size_t CodePoints(const std::string& text) {
  return static_cast<std::size_t>(std::count_if(text.begin(), text.end(), [](char c) {
    return (static_cast<unsigned>(c) & 0xC0U) != 0x80U;
  }));
}

bool IsNumber(const std::string& text) {
  return !text.empty() && text.find_first_not_of("0123456789.-") == std::string::npos;
}

}  // namespace

std::string Table(const std::vector<std::vector<std::string>>& rows) {
  std::vector<std::size_t> widths;
  std::vector<bool> numbers;
  for (std::size_t row = 0; row < rows.size(); ++row) {
    widths.resize(std::max(widths.size(), rows[row].size()), 0);
    numbers.resize(widths.size(), true);
    for (std::size_t column = 0; column < rows[row].size(); ++column) {
      widths[column] = std::max(widths[column], CodePoints(rows[row][column]));
      if (row > 0 && !IsNumber(rows[row][column])) numbers[column] = false;
    }
  }
  std::string out;
  for (const auto& row : rows) {
    std::string line;
    for (std::size_t column = 0; column < row.size(); ++column) {
      if (column > 0) line += "  ";
      const std::string padding(widths[column] - CodePoints(row[column]), ' ');
      line += numbers[column] ? padding + row[column] : row[column] + padding;
    }
    line.erase(line.find_last_not_of(' ') + 1);
    out += line + "\n";
  }
  return out;
}

namespace {

std::string RecognizedText(const v1::StyleInfo& style) {
  if (style.recognized() <= 0) return "-";
  // Rounded down, so that no style is weak at 0.80.
  return Fixed(std::floor(100 * style.recognized()) / 100, 2) + (style.weak() ? " weak" : "");
}

double Rounded(double value, int digits) { return std::stod(Fixed(value, digits)); }

std::string RecordedText(const v1::StyleInfo& style) {
  if (style.recorded_s() <= 0) return "-";
  return style.recorded_s() < 60 ? Fixed(style.recorded_s(), 0) + " s"
                                 : Fixed(style.recorded_s() / 60, 1) + " min";
}

json LayersJson(const v1::PerformerStats& performer) {
  json out = json::array();
  for (const auto& layer : performer.layers()) {
    out.push_back({{"source", layer.source()}, {"part", layer.part()}, {"live", layer.live()}});
  }
  return out;
}

// The limbs in the order of LimbShares, as people read them.
std::array<std::pair<const char*, float>, 5> Limbs(const v1::LimbShares& shown) {
  return {{{"left arm", shown.left_arm()},
           {"right arm", shown.right_arm()},
           {"trunk", shown.trunk()},
           {"left leg", shown.left_leg()},
           {"right leg", shown.right_leg()}}};
}

// A line about the part of the style that is withheld from the performer; "": nothing noticeable.
std::string HeldBackText(const v1::PerformerStats& performer) {
  constexpr float kMissed = 0.9F;
  if (!performer.live() || !performer.has_turned_deg()) return "";
  if (performer.hardly_styled()) {
    return performer.performer() +
           " is hardly styled now: the weights leave their motion unchanged\n";
  }
  std::string limbs;
  for (const auto& [name, share] : Limbs(performer.shown())) {
    if (share >= kMissed) continue;
    limbs += (limbs.empty() ? "" : ", ") + std::string(name) + " " +
             Fixed(100 * static_cast<double>(share), 0) + " %";
  }
  return limbs.empty() ? "" : performer.performer() + " shows of the style: " + limbs + "\n";
}

// The state of the performer's neutral: "calibrated", or how much of it is learned.
std::string NeutralCell(const v1::PerformerStats& performer) {
  if (!performer.has_neutral()) return "-";
  const v1::NeutralStats& neutral = performer.neutral();
  if (neutral.calibrates_s() > 0) return "calibrates";
  if (neutral.calibrated()) return "calibrated";
  return Fixed(100 * static_cast<double>(neutral.learned()), 0) + " %";
}

// Says that the style of a performer is not yet complete; "": it is.
std::string NeutralText(const v1::PerformerStats& performer) {
  constexpr float kKnown = 0.8F;  // a second
  if (!performer.live() || !performer.has_turned_deg() || !performer.has_neutral()) return "";
  const v1::NeutralStats& neutral = performer.neutral();
  if (neutral.calibrates_s() > 0) {
    return performer.performer() + ": their neutral is being calibrated, " +
           Fixed(static_cast<double>(neutral.calibrates_s()), 0) + " s left\n";
  }
  if (neutral.calibrated() || neutral.learned() >= kKnown) return "";
  return performer.performer() + ": their neutral is learned to " +
         Fixed(100 * static_cast<double>(neutral.learned()), 0) +
         " %; it is learned while they stand and walk, and their style shows in full then\n";
}

json NeutralJson(const v1::NeutralStats& neutral) {
  const auto rounded = [](float number) { return Rounded(static_cast<double>(number), 3); };
  return {{"learned", rounded(neutral.learned())},
          {"body_s", rounded(neutral.body_s())},
          {"arms_s", rounded(neutral.arms_s())},
          {"calibrated", neutral.calibrated()},
          {"calibrates_s", rounded(neutral.calibrates_s())}};
}

json ShownJson(const v1::LimbShares& shown) {
  json out = json::object();
  for (const auto& [name, share] : Limbs(shown)) {
    std::string key = name;
    std::replace(key.begin(), key.end(), ' ', '_');
    out[key] = Rounded(static_cast<double>(share), 3);
  }
  return out;
}

// For the limb that the style moves most.
double Most_cm(const v1::MovedLimbs& moved) {
  return static_cast<double>(
      std::max({moved.head(), moved.hands(), moved.elbows(), moved.knees(), moved.feet()}));
}

json MovedJson(const v1::MovedLimbs& moved) {
  const auto cm = [](float of_limb) { return Rounded(static_cast<double>(of_limb), 1); };
  return {{"head", cm(moved.head())},
          {"hands", cm(moved.hands())},
          {"elbows", cm(moved.elbows())},
          {"knees", cm(moved.knees())},
          {"feet", cm(moved.feet())}};
}

}  // namespace

std::string ListText(const v1::ListReply& list) {
  std::vector<std::vector<std::string>> rows{
      {"STYLE", "RECOGNIZED", "RECORDED", "COMMERCIAL", "ALSO"}};
  for (const auto& style : list.styles()) {
    std::string also;
    for (const std::string& alias : style.aliases()) also += (also.empty() ? "" : ", ") + alias;
    if (style.neutral()) also += also.empty() ? "(neutral)" : "  (neutral)";
    rows.push_back({style.name(), RecognizedText(style), RecordedText(style),
                    CommercialText(style.commercial_use()), also});
  }
  std::string out = Table(rows);
  if (!list.presets().empty()) {
    rows = {{"PRESET", "MIX"}};
    for (const auto& preset : list.presets()) {
      rows.push_back({preset.name(), MixText(preset.mix())});
    }
    out += "\n" + Table(rows);
  }
  if (!list.cues().empty()) {
    rows = {{"CUE", "AT", "PERFORMER"}};
    for (const auto& cue : list.cues()) {
      rows.push_back({cue.name(), cue.at().empty() ? "by name" : cue.at(), cue.performer()});
    }
    out += "\n" + Table(rows);
  }
  return out;
}

std::string StylesText(const v1::ListReply& list) {
  std::vector<std::vector<std::string>> rows{{"STYLE", "OF", "NEAREST", "DISTANCE"}};
  for (const auto& style : list.styles()) {
    if (!style.made()) {
      rows.push_back({style.name(), style.model().empty() ? "the weights" : style.model(), "", ""});
      continue;
    }
    rows.push_back({style.name(), style.source().empty() ? "an example" : style.source(),
                    style.nearest(), Fixed(static_cast<double>(style.distance()), 2)});
  }
  return Table(rows);
}

std::string ClockText(const v1::ClockState& clock) {
  const double error_s = clock.max_error_s();
  const std::string within = "within " + (error_s < 1e-3 ? Fixed(1e6 * error_s, 0) + " us"
                                                         : Fixed(1e3 * error_s, 1) + " ms");
  switch (clock.source()) {
    case v1::ClockState::SOURCE_PTP: {
      const v1::PtpState& ptp = clock.ptp();
      return "clock: PTP domain " + std::to_string(ptp.domain()) + ", leader " + ptp.leader() +
             ", port " + ptp.port_state() + ", offset " + Fixed(1e9 * ptp.offset_s(), 0) +
             " ns, path " + Fixed(1e9 * ptp.mean_path_delay_s(), 0) + " ns" +
             (clock.locked() ? ", " + within
                             : "; the system's clock is not synchronized with it (run phc2sys)") +
             "\n";
    }
    case v1::ClockState::SOURCE_NTP:
      return "clock: synchronized, " + within + "\n";
    default:
      return "clock: not synchronized: the frames' wall times drift (run chrony, or ptp4l and "
             "phc2sys)\n";
  }
}

json ClockJson(const v1::ClockState& clock) {
  json out{{"source", clock.source() == v1::ClockState::SOURCE_PTP   ? "ptp"
                      : clock.source() == v1::ClockState::SOURCE_NTP ? "ntp"
                                                                     : "none"},
           {"locked", clock.locked()},
           {"max_error_s", clock.max_error_s()}};
  if (!clock.has_ptp()) return out;
  const v1::PtpState& ptp = clock.ptp();
  out["ptp"] = {{"domain", ptp.domain()},
                {"leader", ptp.leader()},
                {"port_state", ptp.port_state()},
                {"offset_s", ptp.offset_s()},
                {"mean_path_delay_s", ptp.mean_path_delay_s()},
                {"steps_removed", ptp.steps_removed()},
                {"leader_priorities", {ptp.leader_priority1(), ptp.leader_priority2()}},
                {"leader_clock_class", ptp.leader_clock_class()},
                {"leader_accuracy", ptp.leader_accuracy()},
                {"leader_time_source", ptp.leader_time_source()}};
  return out;
}

// Problems between the two daemons, a line each. Requests for the leader's state that are more
// frequent than a standby's come from another program.
std::string StandbyTrouble(const v1::StandbyState& standby) {
  constexpr std::uint64_t kUsualAsks = 10;
  std::string out;
  if (standby.role() == "leading") {  // a standby says it as its reason not to be ready
    for (const auto& differs : standby.differs()) out += "standby: differs: " + differs + "\n";
    if (!standby.too_large().empty()) {
      out += "standby: " + standby.peer() + " cannot have " + standby.too_large() + "\n";
    }
  }
  if (standby.refused() > 0) {
    out += "standby: " + std::to_string(standby.refused()) + " messages from " + standby.peer() +
           " were ignored; the last: " + standby.refused_why() + "\n";
  }
  if (standby.asked_too_often() > kUsualAsks) {
    out += "standby: the journal was subscribed to " + std::to_string(standby.asked()) +
           " times, " + std::to_string(standby.asked_too_often()) +
           " of them too soon: who else connects to standby.address?\n";
  }
  return out;
}

// Of a daemon with [standby].
std::string StandbyText(const v1::StandbyState& standby) {
  if (standby.role() == "leading") {
    return "standby: this daemon leads (term " + std::to_string(standby.term()) + "); " +
           standby.peer() +
           (!standby.heard() ? " does not answer: no daemon would take over"
                             : " is " + standby.peer_role()) +
           "\n" + StandbyTrouble(standby);
  }
  if (standby.role() != "following") {
    return "standby: checks whether " + standby.peer() + " leads\n" + StandbyTrouble(standby);
  }
  std::string out =
      "standby: follows " + standby.peer() + " (term " + std::to_string(standby.term()) + "); " +
      (standby.ready() ? "ready" : "not ready: " + standby.why_not()) + "; " +
      std::to_string(standby.compared()) + " frames styled in parallel with the leader, " +
      std::to_string(standby.different()) + " of them with a different result, " +
      std::to_string(standby.apart()) + " by more than rounding differences\n" +
      StandbyTrouble(standby);
  for (const auto& performer : standby.without_input()) {
    out += performer +
           ": the leader receives frames, but this daemon does not: after a takeover it could not "
           "continue with them\n";
  }
  return out;
}

json StandbyJson(const v1::StandbyState& standby) {
  return {{"role", standby.role()},
          {"peer", standby.peer()},
          {"heard", standby.heard()},
          {"peer_role", standby.peer_role()},
          {"term", standby.term()},
          {"ready", standby.ready()},
          {"why_not", standby.why_not()},
          {"compared", standby.compared()},
          {"different", standby.different()},
          {"apart", standby.apart()},
          {"differs", std::vector<std::string>(standby.differs().begin(), standby.differs().end())},
          {"refused", standby.refused()},
          {"refused_why", standby.refused_why()},
          {"asked", standby.asked()},
          {"asked_too_often", standby.asked_too_often()},
          {"too_large", standby.too_large()},
          {"fetched", standby.fetched()},
          {"takeovers", standby.takeovers()},
          {"without_input", std::vector<std::string>(standby.without_input().begin(),
                                                     standby.without_input().end())}};
}

std::string StatusText(const v1::StatusReply& status, bool all_counters) {
  const v1::Stats& stats = status.stats();
  int live = 0;
  for (const auto& performer : stats.performers()) live += performer.live() ? 1 : 0;
  std::string out = "styled " + status.version() + "  up " + Duration(status.uptime_s()) +
                    "  weights " + status.weights() + "  epoch " + Hex(status.epoch()) + "\n" +
                    std::to_string(stats.performers_size()) + " performer" +
                    (stats.performers_size() == 1 ? "" : "s") + ", " + std::to_string(live) +
                    " live\n";
  for (const auto& terms : status.terms()) {
    out += terms.file() + ": licence " + (terms.licence().empty() ? "not given" : terms.licence()) +
           (terms.commercial_use() == v1::COMMERCIAL_USE_NO ? ", not for commercial use\n" : "\n");
  }
  if (stats.has_clock()) out += ClockText(stats.clock());
  if (stats.has_standby()) out += StandbyText(stats.standby());
  if (stats.performers_size() > 0) {
    std::vector<std::vector<std::string>> rows{
        {"PERFORMER", "STATE", "HZ", "P50 us", "P99 us", "MAX us", "P99 1 min", "P99 all", "OVER",
         "PUBLISHED", "LOST", "STRENGTH", "STYLE", "MOVES cm", "NEUTRAL", ""}};
    std::string warnings, merged, held_back;
    for (const auto& performer : stats.performers()) {
      std::string notes;
      if (performer.pinned()) notes += "pinned";
      if (const std::string look = NotesText(performer.look()); !look.empty()) {
        notes += (notes.empty() ? "" : ", ") + look;
      }
      const bool refused = !performer.live() && !performer.refused_as().empty();
      if (performer.overload_bypass()) {
        notes += std::string(notes.empty() ? "" : ", ") + "overload: style faded out";
      }
      if (!performer.refused_as().empty()) {
        notes += std::string(notes.empty() ? "" : ", ") + "refused: " + performer.refused_as();
      }
      if (!performer.warning().empty()) {
        warnings += performer.performer() + ": " + performer.warning() + "\n";
      }
      if (const std::string layers = client::LayersText(performer); !layers.empty()) {
        merged += performer.performer() + " gets " + layers + "\n";
      }
      held_back += HeldBackText(performer) + NeutralText(performer);
      rows.push_back({performer.performer(),
                      performer.live() ? "live"
                      : refused        ? "refused"
                                       : "silent",
                      Fixed(performer.rate_hz(), 1), Fixed(performer.latency_p50_us(), 0),
                      Fixed(performer.latency_p99_us(), 0), Fixed(performer.latency_max_us(), 0),
                      Fixed(performer.latency_p99_minute_us(), 0),
                      Fixed(performer.latency_p99_overall_us(), 0),
                      std::to_string(performer.over_budget()),
                      std::to_string(performer.published()), std::to_string(performer.lost()),
                      Fixed(performer.look().strength(), 2),
                      MixText(performer.look().mix(), performer.networks()),
                      performer.has_moved() ? Fixed(Most_cm(performer.moved()), 1) : "-",
                      NeutralCell(performer), notes});
    }
    std::sort(rows.begin() + 1, rows.end());  // by performer
    out += Table(rows) + merged + held_back + warnings;
  }
  for (const auto& source : status.sources()) {
    if (!source.stray().empty()) out += source.name() + ": " + source.stray() + "\n";
    if (source.received() > 0) continue;
    const rigs::SourceType* const type = rigs::FindSourceType(source.type());
    const bool asks = type != nullptr && type->rig->asks_server;
    out += source.name() +
           (source.type() == "usb" ? ": waiting for "
            : asks                 ? ": asking "
                                   : ": listening at ") +
           source.listen() + " (" + source.type() + "), nothing received yet\n";
  }
  std::vector<std::vector<std::string>> delays{
      {"SOURCE", "DELAY ms", "CAME LATE ms", "LEFT LATE ms", "MISSED"}};
  for (const auto& source : status.sources()) {
    if (source.delay_ms() <= 0) continue;
    delays.push_back({source.name() + " " + source.listen(), Fixed(source.delay_ms(), 0),
                      Fixed(source.arrived_ms(), 1), Fixed(source.left_ms(), 1),
                      std::to_string(source.missed())});
  }
  if (delays.size() > 1) out += Table(delays);
  if (stats.stages_size() > 0) {
    std::vector<std::vector<std::string>> stages{{"STAGE", "MEAN us/FRAME", "MAX us"}};
    for (const auto& stage : stats.stages()) {
      stages.push_back({stage.name(), Fixed(stage.mean_us(), 1), Fixed(stage.max_us(), 0)});
    }
    out += Table(stages);
  }
  std::vector<std::vector<std::string>> rows{{"COUNTER", "VALUE"}};
  for (const auto& counter : stats.counters()) {
    if (all_counters || counter.value() != 0) {
      rows.push_back({counter.name(), std::to_string(counter.value())});
    }
  }
  return rows.size() > 1 ? out + Table(rows) : out;
}

std::string AppliedText(const std::vector<v1::Applied>& applied, const std::string& what) {
  if (applied.empty()) return what + ": set, no performer is present yet\n";
  std::vector<std::vector<std::string>> rows;
  rows.reserve(applied.size());
  for (const auto& entry : applied) {
    std::string from = entry.absent()
                           ? "from their first frame: no performer of this name is present"
                           : "from frame " + std::to_string(entry.first_sequence());
    if (entry.no_strength()) from += ", not visible: the strength is 0";
    if (!entry.not_varied().empty()) {
      from += ", " + entry.not_varied() + " as it is: its network has no variations";
    }
    if (!entry.refused().empty()) from = "not changed: " + entry.refused();
    rows.push_back({entry.performer() == "*" ? "others" : entry.performer(), what, from});
  }
  return Table(rows);
}

json ListJson(const v1::ListReply& list) {
  json styles = json::array(), presets = json::array(), cues = json::array();
  for (const auto& style : list.styles()) {
    json aliases = json::array();
    for (const std::string& alias : style.aliases()) aliases.push_back(alias);
    styles.push_back({{"name", style.name()}, {"aliases", aliases}, {"neutral", style.neutral()}});
    // Not measured: null, so that a script does not read it as 0.
    json& entry = styles.back();
    entry["recognized"] = style.recognized() > 0 ? json(Rounded(style.recognized(), 3)) : json();
    entry["recorded_s"] = style.recorded_s() > 0 ? json(Rounded(style.recorded_s(), 1)) : json();
    entry["weak"] = style.weak();
    entry["model"] = style.model();
    entry["varies"] = style.varies();
    entry["made"] = style.made();
    entry["licence"] = style.licence();
    entry["credit"] = style.credit();
    entry["commercial"] = CommercialJson(style.commercial_use());
    if (!style.made()) continue;
    entry["source"] = style.source();
    entry["nearest"] = style.nearest();
    entry["distance"] = Rounded(style.distance(), 3);
  }
  for (const auto& preset : list.presets()) {
    presets.push_back({{"name", preset.name()}, {"mix", MixJson(preset.mix())}});
  }
  for (const auto& cue : list.cues()) {
    cues.push_back({{"name", cue.name()}, {"at", cue.at()}, {"performer", cue.performer()}});
  }
  return {{"styles", styles},
          {"presets", presets},
          {"cues", cues},
          {"weights", LicencesJson(list)["weights"]}};
}

json StatusJson(const v1::StatusReply& status) {
  const v1::Stats& stats = status.stats();
  json counters = json::object(), performers = json::array(), sources = json::array(),
       stages = json::array();
  for (const auto& stage : stats.stages()) {
    stages.push_back(
        {{"name", stage.name()}, {"mean_us", stage.mean_us()}, {"max_us", stage.max_us()}});
  }
  for (const auto& source : status.sources()) {
    sources.push_back({{"name", source.name()},
                       {"type", source.type()},
                       {"listen", source.listen()},
                       {"received", source.received()},
                       {"delay_ms", source.delay_ms()},
                       {"arrived_ms", source.arrived_ms()},
                       {"left_ms", source.left_ms()},
                       {"missed", source.missed()},
                       {"kernel_dropped", source.kernel_dropped()},
                       {"merge_into", source.merge_into()},
                       {"stray", source.stray()}});
  }
  for (const auto& counter : stats.counters()) counters[counter.name()] = counter.value();
  for (const auto& performer : stats.performers()) {
    json row{{"performer", performer.performer()},
             {"sequence", performer.sequence()},
             {"live", performer.live()},
             {"rate_hz", performer.rate_hz()},
             {"latency_p50_us", performer.latency_p50_us()},
             {"latency_p99_us", performer.latency_p99_us()},
             {"latency_max_us", performer.latency_max_us()},
             {"latency_p99_minute_us", performer.latency_p99_minute_us()},
             {"latency_p99_overall_us", performer.latency_p99_overall_us()},
             {"period_ms", performer.period_ms()},
             {"over_budget", performer.over_budget()},
             {"overload_bypass", performer.overload_bypass()},
             {"overload_bypassed", performer.overload_bypassed()},
             {"received", performer.received()},
             {"published", performer.published()},
             {"lost", performer.lost()},
             {"refused", performer.refused()},
             {"refused_as", performer.refused_as()},
             {"warning", performer.warning()},
             {"pinned", performer.pinned()},
             {"joints", performer.joints()},
             {"dialect", performer.dialect()},
             {"layers", LayersJson(performer)}};
    if (performer.has_turned_deg()) {  // while a pose is styled
      row["turned_deg"] = Rounded(static_cast<double>(performer.turned_deg()), 2);
      row["shown"] = ShownJson(performer.shown());
      row["moved_cm"] = MovedJson(performer.moved());
      row["hardly_styled"] = performer.hardly_styled();
    }
    if (performer.has_neutral()) row["neutral"] = NeutralJson(performer.neutral());
    row.update(LookJson(performer.look()));
    performers.push_back(std::move(row));
  }
  json out{{"version", status.version()},
           {"epoch", Hex(status.epoch())},
           {"uptime_s", status.uptime_s()},
           {"weights", status.weights()},
           {"wall_time_ns", stats.wall_time_ns()},
           {"sources", sources},
           {"performers", performers},
           {"stages", stages},
           {"counters", counters}};
  if (stats.has_clock()) out["clock"] = ClockJson(stats.clock());
  if (stats.has_standby()) out["standby"] = StandbyJson(stats.standby());
  return out;
}

json AppliedJson(const std::vector<v1::Applied>& applied) {
  json out = json::array();
  for (const auto& entry : applied) {
    out.push_back({{"performer", entry.performer()},
                   {"first_sequence", entry.first_sequence()},
                   {"absent", entry.absent()},
                   {"no_strength", entry.no_strength()},
                   {"not_varied", entry.not_varied()},
                   {"refused", entry.refused()}});
  }
  return out;
}

}  // namespace styled::stylectl
