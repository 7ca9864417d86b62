#include "clients/web/metrics.h"

#include <sys/resource.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <string_view>

namespace styled::web {
namespace {

using std::string;
using std::string_view;

// The daemon's counters that can decrease.
constexpr std::array<string_view, 6> kGaugeNames{
    "pipeline.performers", "pipeline.longest_cycle_us", "publish.subscriptions",
    "publish.stalled_now", "security.clients",          "record.on"};

string Number(double value) {
  if (std::isnan(value)) return "NaN";
  if (std::isinf(value)) return value > 0 ? "+Inf" : "-Inf";
  std::array<char, 32> text{};
  std::snprintf(text.data(), text.size(), "%.9g", value);
  return text.data();
}

string Whole(std::uint64_t value) { return std::to_string(value); }

string Quoted(string_view value) {
  string out = "\"";
  for (const char c : value) {
    if (c == '\\' || c == '"') out += '\\';
    out += c == '\n' ? 'n' : c;
  }
  return out + "\"";
}

class Text {
 public:
  void Family(string_view name, string_view type, string_view help) {
    name_ = name;
    out_.append("# HELP ").append(name).append(" ").append(help).append("\n# TYPE ");
    out_.append(name).append(" ").append(type).append("\n");
  }
  void Sample(string_view value, string_view labels = "") {
    out_ += name_;
    if (!labels.empty()) out_.append("{").append(labels).append("}");
    out_.append(" ").append(value).append("\n");
  }
  void One(string_view name, string_view type, string_view help, string_view value) {
    Family(name, type, help);
    Sample(value);
  }
  string Finish() { return std::move(out_); }

 private:
  string out_, name_;
};

void WriteGateway(const Counters& counters, const Gauges& gauges, Text& text) {
  const auto total = [&text](string_view name, std::uint64_t value, string_view help) {
    text.One(name, "counter", help, Whole(value));
  };
  text.One("styled_up", "gauge", "1 while the daemon publishes", gauges.daemon_up ? "1" : "0");
  text.One("styleweb_browsers", "gauge", "WebSockets open", Whole(gauges.browsers));
  text.One("styleweb_connections", "gauge", "connections open", Whole(gauges.connections));
  text.One("styleweb_subscriptions", "gauge", "distinct topics subscribed at the daemon",
           Whole(gauges.subscriptions));
  total("styleweb_connections_total", counters.connections, "connections accepted");
  text.Family("styleweb_refused_total", "counter", "connections and requests refused");
  text.Sample(Whole(counters.refused_full), "reason=\"full\"");
  text.Sample(Whole(counters.refused_access), "reason=\"access\"");
  total("styleweb_gave_way_total", counters.gave_way,
        "connections closed, their request or reply unfinished, to let a new one in");
  total("styleweb_browsers_total", counters.browsers, "WebSockets opened");
  total("styleweb_sent_messages_total", counters.sent_messages, "messages sent to browsers");
  total("styleweb_sent_bytes_total", counters.sent_bytes, "bytes of those");
  total("styleweb_superseded_messages_total", counters.superseded,
        "messages not sent because a newer one arrived before the browser read");
  total("styleweb_requests_total", counters.requests, "control requests from browsers");
  total("styleweb_unanswered_requests_total", counters.unanswered,
        "control requests that no daemon answered");
  total("styleweb_bad_messages_total", counters.bad_messages,
        "messages from browsers not understood");
  total("styleweb_upstream_messages_total", counters.upstream_messages,
        "messages received from the daemon");
  total("styleweb_upstream_malformed_total", counters.upstream_malformed,
        "messages from the daemon not understood");
  rusage use{};
  getrusage(RUSAGE_SELF, &use);
  const auto seconds = [](const timeval& t) {
    return static_cast<double>(t.tv_sec) + static_cast<double>(t.tv_usec) * 1e-6;
  };
  text.One("process_cpu_seconds_total", "counter", "processor time of the gateway",
           Number(seconds(use.ru_utime) + seconds(use.ru_stime)));
}

void WriteCounters(const v1::Stats& stats, Text& text) {
  for (const v1::Counter& counter : stats.counters()) {
    string name = "styled_" + counter.name();
    const auto odd = [](char c) {
      return (c < 'a' || c > 'z') && (c < 'A' || c > 'Z') && (c < '0' || c > '9');
    };
    std::replace_if(name.begin(), name.end(), odd, '_');
    const bool gauge =
        std::find(kGaugeNames.begin(), kGaugeNames.end(), counter.name()) != kGaugeNames.end();
    string value = Whole(counter.value());
    if (name.ends_with("_us")) {  // Prometheus uses seconds
      name.replace(name.size() - 2, 2, "seconds");
      value = Number(static_cast<double>(counter.value()) * 1e-6);
    }
    if (!gauge) name += "_total";
    text.One(name, gauge ? "gauge" : "counter", "a counter of the daemon", value);
  }
}

void WritePerformers(const v1::Stats& stats, Text& text) {
  const auto each = [&](string_view name, string_view type, string_view help, auto&& value) {
    text.Family(name, type, help);
    for (const auto& performer : stats.performers()) {
      text.Sample(value(performer), "performer=" + Quoted(performer.performer()));
    }
  };
  using P = v1::PerformerStats;
  each("styled_performer_live", "gauge", "1 while frames leave",
       [](const P& p) { return string(p.live() ? "1" : "0"); });
  each("styled_performer_rate_hertz", "gauge", "frames of the last second",
       [](const P& p) { return Number(p.rate_hz()); });
  each("styled_performer_strength_ratio", "gauge", "strength of the style",
       [](const P& p) { return Number(p.look().strength()); });
  each("styled_performer_received_total", "counter", "frames accepted from the rig",
       [](const P& p) { return Whole(p.received()); });
  each("styled_performer_published_total", "counter", "poses published",
       [](const P& p) { return Whole(p.published()); });
  each("styled_performer_lost_total", "counter", "datagrams missing by their sequence",
       [](const P& p) { return Whole(p.lost()); });
  each("styled_performer_refused_total", "counter", "datagrams that changed nothing",
       [](const P& p) { return Whole(p.refused()); });
  each("styled_performer_over_budget_total", "counter",
       "frames that left later than a period of the rig after their arrival",
       [](const P& p) { return Whole(p.over_budget()); });
  each("styled_performer_period_seconds", "gauge", "period of the rig, by its own clock",
       [](const P& p) { return Number(p.period_ms() * 1e-3); });
  each("styled_performer_overload_bypass", "gauge",
       "1 while the style is faded out because the machine is overloaded",
       [](const P& p) { return string(p.overload_bypass() ? "1" : "0"); });
  each("styled_performer_overload_bypassed_total", "counter",
       "frames sent without style because the machine is overloaded",
       [](const P& p) { return Whole(p.overload_bypassed()); });
  text.Family("styled_performer_latency_seconds", "gauge",
              "from arrival to the end of sending, over the last second; p99 also over the last "
              "minute and since the performer appeared");
  for (const auto& p : stats.performers()) {
    const string labels = "performer=" + Quoted(p.performer()) + ",of=";
    text.Sample(Number(p.latency_p50_us() * 1e-6), labels + "\"p50\"");
    text.Sample(Number(p.latency_p99_us() * 1e-6), labels + "\"p99\"");
    text.Sample(Number(p.latency_max_us() * 1e-6), labels + "\"max\"");
    text.Sample(Number(p.latency_p99_minute_us() * 1e-6), labels + "\"p99_minute\"");
    text.Sample(Number(p.latency_p99_overall_us() * 1e-6), labels + "\"p99_overall\"");
  }
  text.Family("styled_performer_shown_ratio", "gauge",
              "share of its style that a limb showed, over the last second");
  for (const auto& p : stats.performers()) {
    if (!p.has_shown()) continue;
    const string labels = "performer=" + Quoted(p.performer()) + ",limb=";
    text.Sample(Number(p.shown().left_arm()), labels + "\"left-arm\"");
    text.Sample(Number(p.shown().right_arm()), labels + "\"right-arm\"");
    text.Sample(Number(p.shown().trunk()), labels + "\"trunk\"");
    text.Sample(Number(p.shown().left_leg()), labels + "\"left-leg\"");
    text.Sample(Number(p.shown().right_leg()), labels + "\"right-leg\"");
  }
  text.Family("styled_performer_turned_degrees", "gauge",
              "angle by which the style turned a joint, mean over the last second");
  for (const auto& p : stats.performers()) {
    if (!p.has_turned_deg()) continue;
    text.Sample(Number(p.turned_deg()), "performer=" + Quoted(p.performer()));
  }
  text.Family("styled_performer_moved_centimetres", "gauge",
              "distance by which the style moved a limb, mean over the last second");
  for (const auto& p : stats.performers()) {
    if (!p.has_moved()) continue;
    const string labels = "performer=" + Quoted(p.performer()) + ",limb=";
    text.Sample(Number(p.moved().head()), labels + "\"head\"");
    text.Sample(Number(p.moved().hands()), labels + "\"hands\"");
    text.Sample(Number(p.moved().elbows()), labels + "\"elbows\"");
    text.Sample(Number(p.moved().knees()), labels + "\"knees\"");
    text.Sample(Number(p.moved().feet()), labels + "\"feet\"");
  }
  text.Family("styled_performer_hardly_styled", "gauge",
              "1 while a strong style is set and almost none of it is visible");
  for (const auto& p : stats.performers()) {
    if (!p.has_moved()) continue;
    text.Sample(p.hardly_styled() ? "1" : "0", "performer=" + Quoted(p.performer()));
  }
  text.Family("styled_performer_neutral_learned_ratio", "gauge",
              "how well the performer's own way of standing and walking is known");
  for (const auto& p : stats.performers()) {
    if (!p.has_neutral()) continue;
    text.Sample(Number(p.neutral().learned()), "performer=" + Quoted(p.performer()));
  }
  text.Family("styled_performer_layer_live", "gauge",
              "1 while a source that is merged into a performer provides its part");
  for (const auto& p : stats.performers()) {
    for (const auto& layer : p.layers()) {
      text.Sample(layer.live() ? "1" : "0", "performer=" + Quoted(p.performer()) +
                                                ",source=" + Quoted(layer.source()) +
                                                ",part=" + Quoted(layer.part()));
    }
  }
  text.Family("styled_stage_seconds", "gauge", "time of a stage per frame, over the last second");
  for (const auto& stage : stats.stages()) {
    text.Sample(Number(stage.mean_us() * 1e-6), "stage=" + Quoted(stage.name()) + ",of=\"mean\"");
    text.Sample(Number(stage.max_us() * 1e-6), "stage=" + Quoted(stage.name()) + ",of=\"max\"");
  }
  text.Family("styled_performer_style_weight_ratio", "gauge", "the mix that is set");
  for (const auto& p : stats.performers()) {
    for (const auto& style : p.look().mix()) {
      text.Sample(Number(style.weight()),
                  "performer=" + Quoted(p.performer()) + ",style=" + Quoted(style.style()));
    }
  }
}

void WriteClock(const v1::ClockState& clock, Text& text) {
  text.One("styled_clock_locked", "gauge",
           "1 while NTP or PTP disciplines the clock of the frames' wall times",
           clock.locked() ? "1" : "0");
  text.One("styled_clock_max_error_seconds", "gauge", "the kernel's bound of that clock's error",
           Number(clock.max_error_s()));
  if (!clock.has_ptp()) return;
  text.One("styled_ptp_offset_seconds", "gauge", "from the PTP leader, as ptp4l measured it",
           Number(clock.ptp().offset_s()));
  text.One("styled_ptp_path_delay_seconds", "gauge", "mean path delay to the PTP leader",
           Number(clock.ptp().mean_path_delay_s()));
}

void WriteStandby(const v1::StandbyState& standby, Text& text) {
  text.One("styled_standby_leads", "gauge",
           "1 while this daemon leads, 0 while it follows its peer",
           standby.role() == "leading" ? "1" : "0");
  text.One("styled_standby_peer_up", "gauge", "1 while the other daemon answers",
           standby.heard() ? "1" : "0");
  text.One("styled_standby_term", "gauge", "number of the leadership",
           std::to_string(standby.term()));
  text.One("styled_standby_takeovers_total", "counter", "how often this daemon has taken over",
           std::to_string(standby.takeovers()));
  if (standby.role() == "leading") return;
  text.One("styled_standby_ready", "gauge", "1 while it could take over without a jump",
           standby.ready() ? "1" : "0");
  text.One("styled_standby_compared_frames_total", "counter",
           "frames styled in parallel with the leader", std::to_string(standby.compared()));
  text.One("styled_standby_different_frames_total", "counter",
           "those of them with a different result", std::to_string(standby.different()));
  text.One("styled_standby_apart_frames_total", "counter",
           "those of them that differ by more than rounding", std::to_string(standby.apart()));
  text.One("styled_standby_without_input_performers", "gauge",
           "performers of the leader whose frames do not reach this daemon",
           std::to_string(standby.without_input_size()));
}

}  // namespace

string PrometheusText(const Counters& counters, const Gauges& gauges, const v1::Stats* daemon) {
  Text text;
  WriteGateway(counters, gauges, text);
  if (daemon != nullptr) {
    WriteCounters(*daemon, text);
    WritePerformers(*daemon, text);
    if (daemon->has_clock()) WriteClock(daemon->clock(), text);
    if (daemon->has_standby()) WriteStandby(daemon->standby(), text);
  }
  return text.Finish();
}

}  // namespace styled::web
