#include "clients/nats/bridge.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace styled::stylenats {
namespace {

TEST(NatsBridge, RefusesEachBadOption) {
  Options options;
  EXPECT_THAT(Bridge::Open(options).status().message(), testing::HasSubstr("--site ''"));
  options.site = std::string(kMaxSite + 1, 'x');
  EXPECT_THAT(Bridge::Open(options).status().message(), testing::HasSubstr("1 to 64 bytes"));
  options.site = "s";
  options.publisher = "nonsense";
  EXPECT_THAT(Bridge::Open(options).status().message(), testing::HasSubstr("nonsense"));
  options.publisher = "tcp://127.0.0.1:1";
  options.control = "nonsense";
  EXPECT_THAT(Bridge::Open(options).status().message(), testing::HasSubstr("control: "));
}

// A value that changes every second would be a write every second, for each performer.
TEST(NatsBridge, KeepsOfAPerformerWhatLasts) {
  v1::PerformerStats first;
  first.set_performer("rig.a");
  first.set_live(true);
  first.set_dialect("canonical");
  first.mutable_look()->set_strength(0.5F);
  first.mutable_look()->add_mix()->set_style("old");
  v1::PerformerStats later = first;
  later.set_sequence(120);
  later.set_rate_hz(119.9F);
  later.set_latency_p50_us(1);
  later.set_latency_p99_us(2);
  later.set_latency_max_us(3);
  later.set_latency_p99_minute_us(3);
  later.set_latency_p99_overall_us(3);
  later.set_period_ms(8);
  later.set_over_budget(3);
  later.set_overload_bypassed(3);
  later.set_received(120);
  later.set_published(120);
  later.set_lost(1);
  later.set_refused(1);
  later.set_refused_as("pipeline.duplicate");
  later.mutable_shown()->set_trunk(1);
  later.set_turned_deg(8);
  later.mutable_moved()->set_head(3);
  later.set_hardly_styled(true);
  EXPECT_EQ(Lasting(later).SerializeAsString(), first.SerializeAsString());
  later.mutable_look()->set_strength(1);
  EXPECT_NE(Lasting(later).SerializeAsString(), first.SerializeAsString());
}

}  // namespace
}  // namespace styled::stylenats
