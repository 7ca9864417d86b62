// Which settings two daemons of a pair compare.
#include "daemon/standby/setup.h"

#include <gtest/gtest.h>

#include <functional>
#include <map>
#include <set>

namespace styled::pipeline {
namespace {

using Changes = std::map<std::string, std::function<void(RuntimeConfig&)>>;

std::map<std::string, std::string> RowsOf(const v1::Setup& setup) {
  std::map<std::string, std::string> rows;
  for (const auto& row : setup.settings()) {
    EXPECT_TRUE(rows.emplace(row.name(), row.value()).second) << row.name() << " is there twice";
  }
  return rows;
}

// Names of the rows that differ.
std::set<std::string> Between(const v1::Setup& a, const v1::Setup& b) {
  const auto one = RowsOf(a), other = RowsOf(b);
  std::set<std::string> names;
  for (const auto& [name, value] : one) {
    if (!other.contains(name) || other.at(name) != value) names.insert(name);
  }
  for (const auto& [name, value] : other) {
    if (!one.contains(name)) names.insert(name);
  }
  return names;
}

TEST(SetupTest, WhatChangesPosesOrDecisionsHasARowThatNamesIt) {
  const Changes changes{
      {"weights", [](auto& c) { c.weights_crc = 2; }},
      {"model.feet", [](auto& c) { c.stylist.feet = false; }},
      {"model.knees", [](auto& c) { c.stylist.knees = false; }},
      {"model.jump_m", [](auto& c) { c.stylist.jump_m = 3.5F; }},
      {"model.change_tau_ms", [](auto& c) { c.stylist.change_tau_s = 0.011F; }},
      {"model.feet_reach_m", [](auto& c) { c.stylist.feet_options.reach_m = 0.5F; }},
      {"model.feet, others", [](auto& c) { c.stylist.feet_options.stretch = 0.75F; }},
      {"performers.max_performers", [](auto& c) { c.performers.max_performers = 5; }},
      {"performers.stale_ms", [](auto& c) { c.performers.stale_s = 0.3F; }},
      {"performers.backlog_ms", [](auto& c) { c.performers.backlog_s = 0.2F; }},
      {"style.initial", [](auto& c) { c.style.initial = "style1"; }},
      {"style", [](auto& c) { c.style.look.set_strength(0.5F); }},
      {"preset mild",
       [](auto& c) {
         c.presets.push_back({"mild", v1::Look(), "stage.toml:3"});
       }},
      {"cue one",
       [](auto& c) {
         c.cues.push_back({"one", 5, "*", v1::Request()});
       }},
  };
  const RuntimeConfig config;
  EXPECT_TRUE(Between(SetupOf(config, {}), SetupOf(config, {})).empty());
  for (const auto& [name, change] : changes) {
    RuntimeConfig other = config;
    change(other);
    EXPECT_EQ(Between(SetupOf(config, {}), SetupOf(other, {})), std::set{name});
  }
}

TEST(SetupTest, ACueOrAnOutputOfOtherContentDiffers) {
  RuntimeConfig one, other;
  one.cues.push_back({"one", 5, "*", v1::Request()});
  other.cues.push_back({"one", 6, "*", v1::Request()});
  auto avatar = std::make_shared<RetargetOutput>();
  avatar->name = "hero";
  one.outputs.push_back(avatar);
  avatar = std::make_shared<RetargetOutput>(*avatar);
  avatar->performers = {"suit.a"};
  other.outputs.push_back(avatar);
  EXPECT_EQ(Between(SetupOf(one, {}), SetupOf(other, {})),
            (std::set<std::string>{"cue one", "output hero"}));
}

TEST(SetupTest, SourcesMayDifferInWhatIsEachMachinesOwn) {
  const std::vector<config::Source> sources{{"suit", "udp", "127.0.0.1:7000"},
                                            {"suit", "tcp", "127.0.0.1:7000"}};
  const auto differs = [&sources](const std::function<void(config::Source&)>& change) {
    auto others = sources;
    change(others[1]);
    return Between(SetupOf({}, SettingsOf(sources)), SetupOf({}, SettingsOf(others)));
  };
  for (const std::function<void(config::Source&)>& change :
       std::vector<std::function<void(config::Source&)>>{
           [](auto& s) { s.listen = "10.0.0.2:7000"; }, [](auto& s) { s.interface = "10.0.0.2"; },
           [](auto& s) { s.serial = "B"; }, [](auto& s) { s.sender_limit_hz = 10; }}) {
    EXPECT_TRUE(differs(change).empty());
  }
  for (const std::function<void(config::Source&)>& change :
       std::vector<std::function<void(config::Source&)>>{
           [](auto& s) { s.type = "vmc"; }, [](auto& s) { s.up = "z"; },
           [](auto& s) { s.delay_s = 0.1F; }, [](auto& s) { s.smoothing.rest_hz = 3; },
           [](auto& s) { s.merge_into = "suit.a"; },
           [](auto& s) {
             s.joints = {{"hips", "h"}};
           },
           [](auto& s) { s.props["hat"] = rig::Hand::kLeft; }}) {
    EXPECT_EQ(differs(change), std::set<std::string>{"source 1 suit"});
  }
}

TEST(SetupTest, ManyEntriesAreOneRow) {
  RuntimeConfig config;
  for (int i = 0; i < 4096; ++i) {
    config.presets.push_back({"p" + std::to_string(i), v1::Look(), ""});
  }
  RuntimeConfig other = config;
  other.presets.back().look.set_strength(0.5F);
  EXPECT_LT(SetupOf(config, {}).ByteSizeLong(), 8192U);
  EXPECT_EQ(Between(SetupOf(config, {}), SetupOf(other, {})), std::set<std::string>{"presets"});
}

}  // namespace
}  // namespace styled::pipeline
