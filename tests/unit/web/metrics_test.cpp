#include "clients/web/metrics.h"

#include <gtest/gtest.h>

#include <map>
#include <regex>
#include <set>
#include <sstream>

namespace styled::web {
namespace {

v1::Stats Example() {
  v1::Stats stats;
  for (const auto& [name, value] : {std::pair{"source.bad_crc", 3},
                                    {"pipeline.performers", 2},
                                    {"pipeline.longest_cycle_us", 1500}}) {
    stats.add_counters()->set_name(name);
    stats.mutable_counters(stats.counters_size() - 1)->set_value(static_cast<std::uint64_t>(value));
  }
  for (const char* name : {"rig.a", "rig.b"}) {
    v1::PerformerStats& performer = *stats.add_performers();
    performer.set_performer(name);
    performer.set_rate_hz(119.88F);
    performer.set_latency_p50_us(42);
    performer.set_latency_p99_minute_us(9000);
    performer.set_over_budget(17);
    performer.set_overload_bypass(name == std::string("rig.a"));
    performer.set_live(true);
    if (name == std::string("rig.a")) performer.mutable_shown()->set_right_arm(0.25F);
    v1::LayerStats& layer = *performer.add_layers();
    layer.set_source("gloves");
    layer.set_part("fingers");
    layer.set_live(name == std::string("rig.b"));
    performer.mutable_look()->add_mix()->set_style("odd\"style\\");
  }
  stats.mutable_performers(0)->set_turned_deg(8.25F);
  stats.mutable_performers(0)->mutable_moved()->set_hands(1.25F);
  stats.mutable_performers(0)->set_hardly_styled(true);
  v1::ClockState& clock = *stats.mutable_clock();
  clock.set_locked(true);
  clock.set_max_error_s(0.25);
  clock.mutable_ptp()->set_offset_s(-0.5);
  v1::StandbyState& standby = *stats.mutable_standby();
  standby.set_role("following");
  standby.set_ready(true);
  standby.set_different(3);
  standby.add_without_input("rig.b");
  return stats;
}

TEST(MetricsTest, EveryLineIsWhatPrometheusReads) {
  const v1::Stats stats = Example();
  std::istringstream text(PrometheusText({.sent_messages = 5}, {.daemon_up = true}, &stats));
  const std::regex help("# HELP ([a-z_]+) [^\\n]+"), type("# TYPE ([a-z_]+) (counter|gauge)");
  const std::regex sample(
      R"re(([a-z_]+)(\{[a-z_]+="(?:[^"\\]|\\["\\n])*"(?:,[a-z_]+="(?:[^"\\]|\\["\\n])*")*\})? [-+0-9.e]+)re");
  std::set<std::string> families, series;
  std::map<std::string, std::string> values;
  std::string line, family;
  std::smatch match;
  while (std::getline(text, line)) {
    if (std::regex_match(line, match, help)) {
      family = match[1];
      EXPECT_TRUE(families.insert(family).second) << "a family in two places: " << line;
    } else if (std::regex_match(line, match, type)) {
      EXPECT_EQ(match[1], family);
      EXPECT_EQ(match[2] == "counter", family.ends_with("_total")) << line;
    } else {
      ASSERT_TRUE(std::regex_match(line, match, sample)) << line;
      EXPECT_EQ(match[1], family);
      const std::string key = line.substr(0, line.rfind(' '));
      EXPECT_TRUE(series.insert(key).second) << "twice: " << line;
      values[key] = line.substr(line.rfind(' ') + 1);
    }
  }
  EXPECT_EQ(values["styled_up"], "1");
  EXPECT_EQ(values["styleweb_sent_messages_total"], "5");
  EXPECT_EQ(values["styled_source_bad_crc_total"], "3");
  EXPECT_EQ(values["styled_pipeline_performers"], "2");
  EXPECT_EQ(values["styled_pipeline_longest_cycle_seconds"], "0.0015");
  EXPECT_EQ(values["styled_performer_rate_hertz{performer=\"rig.b\"}"], "119.879997");
  EXPECT_EQ(values["styled_performer_latency_seconds{performer=\"rig.a\",of=\"p50\"}"].substr(0, 3),
            "4.2");
  EXPECT_EQ(values["styled_performer_latency_seconds{performer=\"rig.a\",of=\"p99_minute\"}"],
            "0.009");
  EXPECT_EQ(values["styled_performer_over_budget_total{performer=\"rig.a\"}"], "17");
  EXPECT_EQ(values["styled_performer_overload_bypass{performer=\"rig.a\"}"], "1");
  EXPECT_EQ(values["styled_performer_overload_bypass{performer=\"rig.b\"}"], "0");
  EXPECT_EQ(values["styled_performer_shown_ratio{performer=\"rig.a\",limb=\"right-arm\"}"], "0.25");
  EXPECT_EQ(values["styled_performer_turned_degrees{performer=\"rig.a\"}"], "8.25");
  EXPECT_EQ(values["styled_performer_moved_centimetres{performer=\"rig.a\",limb=\"hands\"}"],
            "1.25");
  EXPECT_EQ(values["styled_performer_hardly_styled{performer=\"rig.a\"}"], "1");
  EXPECT_FALSE(values.contains("styled_performer_hardly_styled{performer=\"rig.b\"}"));
  EXPECT_EQ(values["styled_clock_locked"], "1");
  EXPECT_EQ(values["styled_clock_max_error_seconds"], "0.25");
  EXPECT_EQ(values["styled_ptp_offset_seconds"], "-0.5");
  EXPECT_EQ(values["styled_standby_leads"], "0");
  EXPECT_EQ(values["styled_standby_ready"], "1");
  EXPECT_EQ(values["styled_standby_different_frames_total"], "3");
  EXPECT_EQ(values["styled_standby_without_input_performers"], "1");
  const std::string layer = "styled_performer_layer_live{performer=\"rig.";
  EXPECT_EQ(values[layer + "a\",source=\"gloves\",part=\"fingers\"}"], "0");
  EXPECT_EQ(values[layer + "b\",source=\"gloves\",part=\"fingers\"}"], "1");
  EXPECT_EQ(text.str().find("shown_ratio{performer=\"rig.b\""), std::string::npos)
      << "nothing is styled there";
}

TEST(MetricsTest, WithoutADaemonOnlyTheGatewaySpeaks) {
  const std::string text = PrometheusText({}, {}, nullptr);
  EXPECT_NE(text.find("styled_up 0\n"), std::string::npos);
  EXPECT_EQ(text.find("styled_performer"), std::string::npos);
}

}  // namespace
}  // namespace styled::web
