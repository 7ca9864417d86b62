#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "tests/support/daemon.h"
#include "tests/support/rig.h"

namespace styled::support {
namespace {

constexpr const char* kPresets = "[presets]\nmild = { s1 = 0.3, style2 = 0.2 }\n";

v1::Request For(const std::string& performer) {
  v1::Request request;
  request.set_performer(performer);
  return request;
}

v1::Request SetMix(const std::string& performer,
                   const std::vector<std::pair<std::string, float>>& mix) {
  v1::Request request = For(performer);
  request.mutable_set();
  for (const auto& [style, weight] : mix) {
    auto& entry = *request.mutable_set()->add_mix();
    entry.set_style(style);
    entry.set_weight(weight);
  }
  return request;
}

TEST(ControlTest, TwentyKindsOfBadMessagesGetACodeAndAReasonAndChangeNothing) {
  Daemon daemon({}, kPresets);
  ControlClient control(daemon.control);
  const UdpLink link(daemon.udp);
  Rig rig("a");
  link.Send(rig.Body());
  ASSERT_EQ(control.SetStyle("rig.a", "style1", 0.5F).code(), v1::CODE_OK);
  const std::string before = control.Performer("rig.a").SerializeAsString();
  constexpr float kNan = std::numeric_limits<float>::quiet_NaN();

  const auto strength = [](float value) {
    v1::Request request = For("rig.a");
    request.mutable_set()->set_strength(value);
    return request;
  };
  const auto transition = [](float value) {
    v1::Request request = For("rig.a");
    request.mutable_set()->set_transition_ms(value);
    return request;
  };
  const auto preset = [](const std::string& name, float transition_ms) {
    v1::Request request = For("rig.a");
    request.mutable_preset()->set_name(name);
    request.mutable_preset()->set_transition_ms(transition_ms);
    return request;
  };
  v1::Request reset_unseen = For("rig.nobody");
  reset_unseen.mutable_reset();
  v1::Request no_part = For("rig.a");
  no_part.mutable_set()->add_parts(static_cast<v1::BodyPart>(7));
  v1::Request clear_and_mix = SetMix("rig.a", {{"style2", 1}});
  clear_and_mix.mutable_set()->set_clear(true);
  v1::Request no_own_style = For("rig.a");
  no_own_style.mutable_set()->set_input_style("nostyle");

  struct Case {
    v1::Request request;
    v1::Code code;
  };
  const std::vector<Case> cases{
      {For("rig.a"), v1::CODE_UNKNOWN_COMMAND},
      {SetMix("", {{"style2", 1}}), v1::CODE_UNKNOWN_PERFORMER},
      {SetMix("no-dot", {{"style2", 1}}), v1::CODE_UNKNOWN_PERFORMER},
      {SetMix("rig.bad name", {{"style2", 1}}), v1::CODE_UNKNOWN_PERFORMER},
      {SetMix("nosource.a", {{"style2", 1}}), v1::CODE_UNKNOWN_PERFORMER},
      {SetMix("rig.a", {{"nostyle", 1}}), v1::CODE_UNKNOWN_STYLE},
      {no_own_style, v1::CODE_UNKNOWN_STYLE},
      {SetMix("rig.a", {{"neutral", 1}}), v1::CODE_OUT_OF_RANGE},
      {SetMix("rig.a", {{"style1", 0.5F}, {"s1", 0.5F}}), v1::CODE_OUT_OF_RANGE},
      {SetMix("rig.a", {{"style1", -0.5F}}), v1::CODE_OUT_OF_RANGE},
      {SetMix("rig.a", {{"style1", 1}, {"style2", 1}}), v1::CODE_OUT_OF_RANGE},
      {SetMix("rig.a", {{"style1", kNan}}), v1::CODE_OUT_OF_RANGE},
      {SetMix("rig.a", {{"style1", 0.1F},
                        {"style2", 0.1F},
                        {"style3", 0.1F},
                        {"style4", 0.1F},
                        {"style1", 0.1F}}),
       v1::CODE_OUT_OF_RANGE},
      {clear_and_mix, v1::CODE_MALFORMED},
      {no_part, v1::CODE_OUT_OF_RANGE},
      {strength(-1), v1::CODE_OUT_OF_RANGE},
      {strength(2), v1::CODE_OUT_OF_RANGE},
      {strength(kNan), v1::CODE_OUT_OF_RANGE},
      {transition(-1), v1::CODE_OUT_OF_RANGE},
      {transition(60001), v1::CODE_OUT_OF_RANGE},
      {preset("nopreset", 0), v1::CODE_UNKNOWN_PRESET},
      {preset("mild", -1), v1::CODE_OUT_OF_RANGE},
      {reset_unseen, v1::CODE_UNKNOWN_PERFORMER},
  };
  for (std::size_t i = 0; i < cases.size(); ++i) {
    const v1::Reply reply = control.Ask(cases[i].request);
    EXPECT_EQ(reply.code(), cases[i].code) << i << ": " << reply.reason();
    EXPECT_FALSE(reply.reason().empty()) << i;
    EXPECT_EQ(reply.applied_size(), 0) << i;
    EXPECT_NE(reply.id(), 0U) << i;
  }
  // Messages that are not requests.
  EXPECT_EQ(control.AskRaw({"\x12\xFF garbage"}).code(), v1::CODE_MALFORMED);
  EXPECT_EQ(control.AskRaw({"one", "two"}).code(), v1::CODE_MALFORMED);
  EXPECT_EQ(control.AskRaw({"one", "two", "three", "four", "five"}).code(), v1::CODE_MALFORMED);
  EXPECT_EQ(control.AskRaw({std::string(70000, 'x')}).code(), v1::CODE_TOO_LARGE);
  EXPECT_EQ(control.AskRaw({""}).code(), v1::CODE_UNKNOWN_COMMAND);
  EXPECT_EQ(control.AskRaw({std::string("\xF8\x07\x01", 3)}).code(), v1::CODE_UNKNOWN_COMMAND);
  v1::Request long_name = For(std::string(60000, 'p'));
  long_name.mutable_pin();
  EXPECT_EQ(control.Ask(long_name).code(), v1::CODE_UNKNOWN_PERFORMER);

  EXPECT_EQ(control.Counter("control.refused"), cases.size() + 7);
  EXPECT_EQ(control.Performer("rig.a").SerializeAsString(), before) << "nothing changed";
  EXPECT_EQ(control.Status().stats().performers_size(), 1) << "no profile was left behind";
}

TEST(ControlTest, ListNamesStylesAndPresets) {
  Daemon daemon({}, kPresets);
  ControlClient control(daemon.control);
  v1::Request request;
  request.mutable_list();
  const auto list = control.Ask(request).list();
  ASSERT_EQ(list.styles_size(), 5);
  EXPECT_TRUE(list.styles(0).neutral());
  EXPECT_EQ(list.styles(1).name(), "style1");
  EXPECT_EQ(list.styles(1).aliases(0), "s1");
  ASSERT_EQ(list.presets_size(), 1);
  EXPECT_EQ(list.presets(0).name(), "mild");
  EXPECT_EQ(list.presets(0).mix_size(), 2);
}

TEST(ControlTest, WorksWithNoFramesFlowingAndAnswersAReqSocketToo) {
  Daemon daemon;
  ControlClient control(daemon.control);
  const v1::Reply reply = control.SetStyle("rig.later", "STYLE1");
  ASSERT_EQ(reply.code(), v1::CODE_OK);
  ASSERT_EQ(reply.applied_size(), 1);
  EXPECT_EQ(reply.applied(0).performer(), "rig.later");
  EXPECT_EQ(reply.applied(0).first_sequence(), 1U);
  // A REQ socket sends an empty part before its request.
  v1::Request status;
  status.mutable_status();
  EXPECT_EQ(control.AskRaw({"", status.SerializeAsString()}).code(), v1::CODE_OK);
}

TEST(ControlTest, AMistypedPerformerIsForgottenOnceCleared) {
  Daemon daemon;
  ControlClient control(daemon.control);
  const auto listed = [&] {
    std::vector<std::string> ids;
    const auto status = control.Status();
    for (const auto& row : status.stats().performers()) ids.push_back(row.performer());
    std::sort(ids.begin(), ids.end());
    return ids;
  };
  const auto clear = [&](const std::string& id) {
    v1::Request request = For(id);
    request.mutable_set()->set_clear(true);
    return control.Ask(request).code();
  };
  const UdpLink link(daemon.udp);
  Rig rig("a");
  link.Send(rig.Body());
  ASSERT_EQ(control.CounterSoon("pipeline.performers", 1), 1U);
  for (const char* const id : {"rig.a", "rig.nobody", "rig.later"}) {
    ASSERT_EQ(control.SetStyle(id, "style1").code(), v1::CODE_OK);
  }
  v1::Request weak = For("rig.later");
  weak.mutable_set()->set_strength(0.5F);
  ASSERT_EQ(control.Ask(weak).code(), v1::CODE_OK);
  for (const char* const id : {"rig.a", "rig.nobody", "rig.later"}) {
    EXPECT_EQ(clear(id), v1::CODE_OK);
  }
  EXPECT_EQ(listed(), (std::vector<std::string>{"rig.a", "rig.later"}))
      << "who is here stays, and who is to be at half strength when he comes";
}

TEST(ControlTest, PinsPresetsPanicAndResetDoAsControlProtoSays) {
  Daemon daemon({}, kPresets);
  ControlClient control(daemon.control);
  ASSERT_EQ(control.SetStyle("rig.a", "style1").code(), v1::CODE_OK);
  ASSERT_EQ(control.SetStyle("rig.b", "style1").code(), v1::CODE_OK);
  v1::Request pin = For("rig.a");
  pin.mutable_pin()->set_pinned(true);
  ASSERT_EQ(control.Ask(pin).code(), v1::CODE_OK);
  EXPECT_EQ(control.SetStyle("rig.a", "style2").code(), v1::CODE_PINNED);

  v1::Request preset = For("*");
  preset.mutable_preset()->set_name("mild");
  const v1::Reply reply = control.Ask(preset);
  ASSERT_EQ(reply.code(), v1::CODE_OK) << reply.reason();
  ASSERT_EQ(reply.applied_size(), 1) << "the pinned one is passed over";
  EXPECT_EQ(reply.applied(0).performer(), "rig.b");
  EXPECT_EQ(control.Performer("rig.a").styles(0).style(), "style1");
  EXPECT_EQ(control.Performer("rig.b").preset(), "mild");
  EXPECT_EQ(control.Performer("rig.b").styles_size(), 2);

  v1::Request panic;
  panic.mutable_panic();
  EXPECT_EQ(control.Ask(panic).applied_size(), 2);
  EXPECT_EQ(control.Performer("rig.a").styles_size(), 0);
  EXPECT_TRUE(control.Performer("rig.a").pinned());
  EXPECT_EQ(control.Performer("rig.b").preset(), "");

  const UdpLink link(daemon.udp);
  Rig rig("a");
  link.Send(rig.Body());
  EXPECT_EQ(control.CounterSoon("pipeline.performers", 1), 1U);
  v1::Request reset = For("rig.a");
  reset.mutable_reset();
  EXPECT_EQ(control.Ask(reset).code(), v1::CODE_OK);
  v1::Request reset_all = For("*");
  reset_all.mutable_reset();
  EXPECT_EQ(control.Ask(reset_all).code(), v1::CODE_OK);
}

TEST(ControlTest, SettingsSurviveARestartOfTheDaemon) {
  Daemon daemon({}, kPresets);
  const std::string state = "[state]\ndir = \"" + (daemon.folder / "state") + "\"\n";
  daemon.Configure(kPresets + state);
  ASSERT_EQ(daemon.Stop(), 0);
  daemon.Start();
  {
    ControlClient control(daemon.control);
    ASSERT_EQ(control.SetStyle("rig.a", "style3", 0.7F, 250).code(), v1::CODE_OK);
    v1::Request everyone = SetMix("*", {{"style2", 0.4F}});
    everyone.mutable_set()->add_parts(v1::BODY_PART_HEAD);
    everyone.mutable_set()->add_parts(v1::BODY_PART_LEFT_ARM);
    ASSERT_EQ(control.Ask(everyone).code(), v1::CODE_OK);
    v1::Request pin = For("rig.a");
    pin.mutable_pin()->set_pinned(true);
    ASSERT_EQ(control.Ask(pin).code(), v1::CODE_OK);
    v1::Request made_neutral = SetMix("rig.c", {{"neutral", 1}});
    made_neutral.mutable_set()->set_input_style("style3");
    ASSERT_EQ(control.Ask(made_neutral).code(), v1::CODE_OK);
    ASSERT_EQ(control.SetStyle("rig.b", "style4").code(), v1::CODE_OK);
  }
  ASSERT_EQ(daemon.Stop(), 0);
  daemon.Start();
  ControlClient control(daemon.control);
  EXPECT_EQ(control.Performer("rig.a").styles(0).style(), "style2");
  EXPECT_TRUE(control.Performer("rig.a").pinned());
  ASSERT_EQ(control.Performer("rig.a").only_size(), 2);
  EXPECT_EQ(control.Performer("rig.a").look().parts(1), v1::BODY_PART_LEFT_ARM);
  EXPECT_EQ(control.Performer("rig.b").styles(0).style(), "style4");
  EXPECT_EQ(control.Performer("rig.c").look().input_style(), "style3");
  EXPECT_EQ(control.Performer("rig.c").styles(0).style(), "neutral");
  const UdpLink link(daemon.udp);
  Rig fresh("new");
  link.Send(fresh.Body());
  EXPECT_EQ(control.CounterSoon("pipeline.performers", 1), 1U);
  EXPECT_EQ(control.Performer("rig.new").styles(0).style(), "style2") << "as \"*\" was set";
}

}  // namespace
}  // namespace styled::support
