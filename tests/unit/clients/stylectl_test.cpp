#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <iterator>
#include <nlohmann/json.hpp>
#include <sstream>

#include "clients/stylectl/cli.h"
#include "clients/stylectl/report.h"
#include "clients/stylectl/suggest.h"
#include "tests/support/temporary_folder.h"
#include "tests/unit/clients/fake_daemon.h"

namespace styled::stylectl {
namespace {

using client::FakeDaemon;

v1::Reply Refusal(v1::Code code, const std::string& reason) {
  v1::Reply reply;
  reply.set_code(code);
  reply.set_reason(reason);
  return reply;
}

v1::ClockState Clock() {
  v1::ClockState clock;
  clock.set_source(v1::ClockState::SOURCE_PTP);
  clock.set_locked(true);
  clock.set_max_error_s(0.000012);
  auto& ptp = *clock.mutable_ptp();
  ptp.set_port_state("SLAVE");
  ptp.set_domain(127);
  ptp.set_leader("001122.fffe.334455");
  ptp.set_offset_s(-178e-9);
  ptp.set_mean_path_delay_s(2456e-9);
  return clock;
}

// Knows "old" (alias "elderly") and "proud", preset "scene", performer rig.anna.
v1::Reply Answer(const v1::Request& request) {
  v1::Reply reply;
  if (request.has_list()) {
    auto& neutral = *reply.mutable_list()->add_styles();
    neutral.set_name("neutral");
    neutral.set_neutral(true);
    auto& old = *reply.mutable_list()->add_styles();
    old.set_name("old");
    old.add_aliases("elderly");
    old.set_recognized(0.984F);
    old.set_recorded_s(432);
    old.set_licence("CC-BY-NC-4.0");
    old.set_credit("its actors");
    old.set_commercial_use(v1::COMMERCIAL_USE_NO);
    auto& proud = *reply.mutable_list()->add_styles();
    proud.set_name("proud");
    proud.set_recognized(0.312F);
    proud.set_recorded_s(48);
    proud.set_weak(true);
    proud.set_licence("CC0-1.0");
    proud.set_commercial_use(v1::COMMERCIAL_USE_YES);
    auto& terms = *reply.mutable_list()->add_terms();
    terms.set_file("w.safetensors");
    terms.set_licence("CC-BY-NC-4.0");
    terms.set_credit("its actors");
    terms.set_commercial_use(v1::COMMERCIAL_USE_NO);
    reply.mutable_list()->add_presets()->set_name("scene");
    return reply;
  }
  if (request.has_status()) {
    reply.mutable_status()->set_version("1.2.3");
    for (const auto& [name, type, listen, received] :
         {std::tuple{"rig", "udp", "0.0.0.0:7000", 12},
          std::tuple{"vmc", "vmc", "0.0.0.0:39539", 0}, std::tuple{"dongle", "usb", "1209:7690", 0},
          std::tuple{"cameras", "natnet", "192.0.2.7:1510", 0}}) {
      auto& source = *reply.mutable_status()->add_sources();
      source.set_name(name);
      source.set_type(type);
      source.set_listen(listen);
      source.set_received(static_cast<std::uint64_t>(received));
    }
    auto& stats = *reply.mutable_status()->mutable_stats();
    auto& anna = *stats.add_performers();
    anna.set_performer("rig.anna");
    anna.set_sequence(77);
    anna.set_live(true);
    anna.set_rate_hz(120);
    auto& layer = *anna.add_layers();
    layer.set_source("gloves");
    layer.set_part("fingers");
    auto& zed = *stats.add_performers();
    zed.set_performer("cam.zed");
    zed.set_refused(12);
    zed.set_refused_as("pipeline.far_ahead");
    zed.set_warning("the toes point backwards");
    *stats.mutable_clock() = Clock();
    auto& counter = *stats.add_counters();
    counter.set_name("source.bad_crc");
    counter.set_value(3);
    stats.add_counters()->set_name("source.zero");
    return reply;
  }
  if (request.has_preset() && request.preset().name() == "hostile") {
    return Refusal(v1::CODE_UNKNOWN_PRESET, "\x1b[2J\x1b[31mred\a");
  }
  for (const auto& entry : request.set().mix()) {
    if (entry.style() != "old" && entry.style() != "elderly" && entry.style() != "proud") {
      return Refusal(v1::CODE_UNKNOWN_STYLE, "set: unknown style '" + entry.style() + "'");
    }
  }
  if (request.has_reset() && request.performer() == "cam.zed") {
    return Refusal(v1::CODE_UNKNOWN_PERFORMER, "performer \"cam.zed\" was not seen yet");
  }
  if (request.has_preset() && request.preset().name() != "scene") {
    return Refusal(v1::CODE_UNKNOWN_PRESET, "preset: unknown preset");
  }
  if (request.has_like() || request.has_import_style()) {
    reply.mutable_like()->set_name("mine");
    reply.mutable_like()->add_code(0.5F);
    reply.mutable_like()->set_nearest("old");
  }
  if (request.has_export_style()) {
    reply.mutable_style_file()->set_name(request.export_style().name());
    reply.mutable_style_file()->set_file("{}");
  }
  auto& applied = *reply.add_applied();
  applied.set_performer(request.performer());
  applied.set_first_sequence(4711);
  return reply;
}

class StylectlTest : public testing::Test {
 protected:
  v1::Request last_;
  FakeDaemon daemon_{[this](const v1::Request& request) {
    if (!request.has_list() && !request.has_status()) last_ = request;
    return Answer(request);
  }};
  std::ostringstream out_, err_;

  int Run(std::vector<std::string> arguments) {
    out_.str("");
    err_.str("");
    arguments.insert(arguments.begin(), {"--endpoint", daemon_.control()});
    daemon_.Synchronize();  // what was read of the last request, before the handler writes the next
    const int code = stylectl::Run(std::move(arguments), out_, err_);
    daemon_.Synchronize();
    return code;
  }
  bool Says(const std::string& text) const { return out_.str().find(text) != std::string::npos; }
  bool Complains(const std::string& text) const {
    return err_.str().find(text) != std::string::npos;
  }
};

TEST_F(StylectlTest, ListAndStatusAreShortAndAligned) {
  EXPECT_EQ(Run({"list"}), kExitOk);
  EXPECT_EQ(out_.str(),
            "STYLE    RECOGNIZED  RECORDED  COMMERCIAL  ALSO\n"
            "neutral  -           -         -           (neutral)\n"
            "old      0.98        7.2 min   no          elderly\n"
            "proud    0.31 weak   48 s      yes\n\n"
            "PRESET  MIX\nscene   bypass\n");
  EXPECT_EQ(Run({"status"}), kExitOk);
  EXPECT_TRUE(Says("styled 1.2.3"));
  EXPECT_TRUE(Says("rig.anna   live     120.0"));
  EXPECT_TRUE(Says("source.bad_crc      3"));
  EXPECT_FALSE(Says("source.zero"));
  EXPECT_EQ(Run({"status", "--all"}), kExitOk);
  EXPECT_TRUE(Says("source.zero"));
}

TEST_F(StylectlTest, ADesignIsOfTheOnlyLivePerformerWhereNoneIsNamed) {
  for (const auto& named : {std::vector<std::string>{"design"}, {"design", "*"}}) {
    std::vector<std::string> arguments = named;
    arguments.insert(arguments.end(), {"--preset", "sneaky"});
    EXPECT_EQ(Run(arguments), 0) << err_.str();
    EXPECT_EQ(last_.performer(), "rig.anna") << "cam.zed is silent";
    EXPECT_EQ(last_.like().design().preset(), "sneaky");
  }
}

TEST_F(StylectlTest, LicencesSayWhatACompanyMayUseAndWhomItCredits) {
  EXPECT_EQ(Run({"licences"}), kExitOk);
  EXPECT_EQ(out_.str(),
            "for commercial use, with the credits below: proud\n"
            "not for commercial use: old\n\n"
            "WEIGHTS        LICENCE       COMMERCIAL\n"
            "w.safetensors  CC-BY-NC-4.0  no\n\n"
            "credits:\n"
            "  w.safetensors: its actors\n"
            "  proud: licence CC0-1.0\n"
            "The programs are Apache-2.0. A licence's own text counts.\n");
  EXPECT_EQ(Run({"licenses", "--json"}), kExitOk);
  const auto all = nlohmann::json::parse(out_.str());
  EXPECT_TRUE(all["styles"][0]["commercial"].is_null());
  EXPECT_EQ(all["styles"][1]["commercial"], false);
  EXPECT_EQ(all["styles"][2]["licence"], "CC0-1.0");
  EXPECT_EQ(all["weights"][0]["credit"], "its actors");
}

TEST_F(StylectlTest, UnmeasuredValuesOfAStyleAreNullInJson) {
  EXPECT_EQ(Run({"list", "--json"}), kExitOk);
  const auto styles = nlohmann::json::parse(out_.str())["styles"];
  EXPECT_TRUE(styles[0]["recognized"].is_null());
  EXPECT_EQ(styles[1]["recognized"], 0.984);
  EXPECT_EQ(styles[1]["recorded_s"], 432);
  EXPECT_EQ(styles[1]["weak"], false);
  EXPECT_EQ(styles[2]["weak"], true);
}

TEST_F(StylectlTest, RangesAreSaidAsTheyAreWritten) {
  for (const char* wrong : {"2", "abc", "nan"}) {
    EXPECT_EQ(Run({"set", "*", "--strength", wrong}), kExitUsage);
    EXPECT_TRUE(
        Complains("--strength: '" + std::string(wrong) + "': expected a number from 0 to 1.5"))
        << err_.str();
  }
  EXPECT_EQ(Run({"--timeout", "nan", "status"}), kExitUsage);
  EXPECT_TRUE(Complains("expected a number from 0.01 to 600")) << err_.str();
  EXPECT_EQ(Run({"preset", "scene", "--transition", "-1"}), kExitUsage);
  EXPECT_TRUE(Complains("expected a number from 0 to 60000")) << err_.str();
}

TEST_F(StylectlTest, APerformerClearedBeforeArrivalIsForgotten) {
  EXPECT_EQ(Run({"clear", "suit.max"}), kExitOk);
  EXPECT_TRUE(
      Complains("note: suit.max has not been seen yet; its advance settings are "
                "forgotten (here: rig.anna, cam.zed)"))
      << err_.str();
  EXPECT_EQ(Run({"set", "suit.max", "--style", "old"}), kExitOk);
  EXPECT_TRUE(Complains("note: suit.max has not been seen yet and is configured in advance"));
  EXPECT_EQ(Run({"clear", "cam.zed"}), kExitOk) << "the daemon has a place for them still";
  EXPECT_TRUE(Complains("note: cam.zed has not been seen yet and is configured in advance"));
}

TEST_F(StylectlTest, StatusKnowsTheSourcesThatNothingCameTo) {
  EXPECT_EQ(Run({"status"}), kExitOk);
  EXPECT_TRUE(Says("vmc: listening at 0.0.0.0:39539 (vmc), nothing received yet\n")) << out_.str();
  EXPECT_TRUE(Says("dongle: waiting for 1209:7690 (usb), nothing received yet\n")) << out_.str();
  EXPECT_TRUE(Says("cameras: asking 192.0.2.7:1510 (natnet), nothing received yet\n"))
      << out_.str();
  EXPECT_FALSE(Says("rig: ")) << out_.str();
  EXPECT_EQ(Run({"status", "--json"}), kExitOk);
  const auto sources = nlohmann::json::parse(out_.str())["sources"];
  ASSERT_EQ(sources.size(), 4U);
  EXPECT_EQ(sources[0]["received"], 12);
  EXPECT_EQ(sources[1]["received"], 0);
  EXPECT_EQ(sources[1]["listen"], "0.0.0.0:39539");
}

TEST_F(StylectlTest, StatusTellsWhoIsRefusedAndWhatLooksWrong) {
  EXPECT_EQ(Run({"status"}), kExitOk);
  EXPECT_TRUE(Says("cam.zed    refused")) << out_.str();
  EXPECT_TRUE(Says("refused: pipeline.far_ahead")) << out_.str();
  EXPECT_TRUE(Says("\ncam.zed: the toes point backwards\n")) << out_.str();
  EXPECT_EQ(Run({"status", "--json"}), kExitOk);
  const auto zed = nlohmann::json::parse(out_.str())["performers"][1];
  EXPECT_EQ(zed["refused"], 12);
  EXPECT_EQ(zed["refused_as"], "pipeline.far_ahead");
}

TEST_F(StylectlTest, SetSendsWhatWasGivenAndNothingElse) {
  EXPECT_EQ(Run({"set", "*", "--style", "old", "--strength", "0.8"}), kExitOk);
  EXPECT_EQ(last_.performer(), "*");
  EXPECT_EQ(last_.set().mix(0).style(), "old");
  EXPECT_FLOAT_EQ(last_.set().strength(), 0.8F);
  EXPECT_FALSE(last_.set().has_transition_ms());
  EXPECT_FALSE(last_.set().has_absolute());
  EXPECT_TRUE(Says("from frame 4711"));

  EXPECT_EQ(Run({"set", "--mix", "old=0.6", "--mix", "proud=0.25", "rig.anna", "--transition",
                 "1500", "--absolute"}),
            kExitOk);
  ASSERT_EQ(last_.set().mix_size(), 2);
  EXPECT_FLOAT_EQ(last_.set().mix(1).weight(), 0.25F);
  EXPECT_FLOAT_EQ(last_.set().transition_ms(), 1500);
  EXPECT_TRUE(last_.set().absolute());
  EXPECT_FALSE(last_.set().has_strength());

  EXPECT_EQ(Run({"set", "rig.anna", "--detail"}), kExitOk);
  EXPECT_TRUE(last_.set().has_absolute());
  EXPECT_FALSE(last_.set().absolute());
  EXPECT_TRUE(last_.set().parts().empty());
  EXPECT_FALSE(last_.set().has_root());

  EXPECT_EQ(Run({"set", "rig.anna", "--mirror"}), kExitOk);
  EXPECT_TRUE(last_.set().mirror());
  EXPECT_TRUE(Says("mirror on"));
  EXPECT_EQ(Run({"set", "rig.anna", "--no-mirror"}), kExitOk);
  EXPECT_TRUE(last_.set().has_mirror());
  EXPECT_FALSE(last_.set().mirror());

  EXPECT_EQ(Run({"set", "rig.anna", "--root", "stride"}), kExitOk);
  EXPECT_EQ(last_.set().root(), v1::ROOT_STRIDE);
  EXPECT_TRUE(Says("root stride"));
  EXPECT_EQ(Run({"set", "rig.anna", "--root", "follow"}), kExitOk);
  EXPECT_TRUE(last_.set().has_root());
  EXPECT_EQ(last_.set().root(), v1::ROOT_FOLLOW);

  EXPECT_EQ(Run({"set", "--only", "arms,head", "rig.anna"}), kExitOk);
  EXPECT_EQ(last_.performer(), "rig.anna");
  EXPECT_EQ(last_.set().parts_size(), 3);
  EXPECT_TRUE(Says("parts head,left-arm,right-arm"));
  EXPECT_EQ(Run({"set", "rig.anna", "--only", "all"}), kExitOk);
  ASSERT_EQ(last_.set().parts_size(), 1);
  EXPECT_EQ(last_.set().parts(0), v1::BODY_PART_ALL);
  EXPECT_FALSE(last_.set().has_input_style());
  for (const char* option : {"--input-style", "--from"}) {
    EXPECT_EQ(Run({"set", "rig.anna", option, "elderly", "--style", "proud"}), kExitOk);
    EXPECT_EQ(last_.set().input_style(), "elderly");
    EXPECT_TRUE(Says("input style elderly")) << out_.str();
  }
  EXPECT_EQ(Run({"set", "--parts", "head", "rig.anna"}), kExitOk);
  EXPECT_EQ(last_.set().parts_size(), 1);
}

TEST_F(StylectlTest, AVariationIsANumberOrEachAndATimeMayHaveItsUnit) {
  for (const std::vector<std::string>& bad :
       std::vector<std::vector<std::string>>{{"--vary", "100"},
                                             {"--vary", "-1"},
                                             {"--vary", "2.5"},
                                             {"--vary", "all"},
                                             {"--amount", "1.6"},
                                             {"--drift", "5m"},
                                             {"--drift", "s"},
                                             {"--drift", "601"},
                                             {"--transition", "5s"}}) {
    EXPECT_EQ(Run({"set", "rig.anna", bad[0], bad[1]}), kExitUsage) << bad[0] << " " << bad[1];
  }
  EXPECT_TRUE(last_.set().mix().empty() && !last_.set().has_vary()) << "nothing was sent";
  EXPECT_EQ(Run({"set", "rig.anna", "--vary", "all"}), kExitUsage);
  EXPECT_TRUE(Complains("'all': expected a whole number from 0 to 99, or each")) << err_.str();

  EXPECT_EQ(Run({"set", "rig.anna", "--style", "elderly", "--vary", "7", "--amount", "0.8",
                 "--drift", "5s", "--transition", "500ms"}),
            kExitOk);
  EXPECT_EQ(last_.set().vary(), 7);
  EXPECT_TRUE(last_.set().has_vary_each() && !last_.set().vary_each()) << "for everyone the same";
  EXPECT_FLOAT_EQ(last_.set().vary_amount(), 0.8F);
  EXPECT_EQ(last_.set().drift_s(), 5);
  EXPECT_EQ(last_.set().transition_ms(), 500);
  EXPECT_TRUE(Says("vary 7, vary each off, amount 0.8, drift 5 s")) << out_.str();
  EXPECT_EQ(Run({"set", "rig.anna", "--drift", "0"}), kExitOk);
  EXPECT_TRUE(last_.set().has_drift_s());
  EXPECT_FALSE(last_.set().has_vary());
  EXPECT_EQ(Run({"set", "*", "--vary", "each"}), kExitOk);
  EXPECT_TRUE(last_.set().vary_each());
  EXPECT_EQ(last_.set().vary(), 0);
  EXPECT_TRUE(last_.set().has_vary());
}

TEST_F(StylectlTest, EveryOtherCommandSendsItself) {
  EXPECT_EQ(Run({"clear"}), kExitOk);
  EXPECT_TRUE(last_.set().clear());
  EXPECT_EQ(last_.performer(), "*");
  EXPECT_EQ(Run({"preset", "scene", "rig.anna", "--transition", "10"}), kExitOk);
  EXPECT_EQ(last_.preset().name(), "scene");
  EXPECT_FLOAT_EQ(last_.preset().transition_ms(), 10);
  EXPECT_EQ(Run({"pin", "rig.anna"}), kExitOk);
  EXPECT_TRUE(last_.pin().pinned());
  EXPECT_EQ(Run({"unpin", "rig.anna"}), kExitOk);
  EXPECT_TRUE(last_.has_pin());
  EXPECT_FALSE(last_.pin().pinned());
  EXPECT_EQ(Run({"panic"}), kExitOk);
  EXPECT_TRUE(last_.has_panic());
  EXPECT_EQ(Run({"reset", "*"}), kExitOk);
  EXPECT_TRUE(last_.has_reset());
}

TEST_F(StylectlTest, StylesThatWereMadeGoOutAndComeIn) {
  const support::TemporaryFolder folder;
  EXPECT_EQ(Run({"styles", "export", "mine", folder / "none" + "/mine.json"}), kExitUsage);
  EXPECT_TRUE(Complains("mine.json: cannot be written: No such file or directory")) << err_.str();
  EXPECT_EQ(Run({"styles", "import", folder / "mine.json"}), kExitUsage);
  EXPECT_TRUE(Complains("styles import: ")) << err_.str();
  EXPECT_EQ(Run({"styles", "exprot", "mine"}), kExitUsage);
  EXPECT_TRUE(Complains("'exprot' is no command of styles; did you mean 'export'?")) << err_.str();
  EXPECT_EQ(Run({"styles", "rename", "mine"}), kExitUsage);

  EXPECT_EQ(Run({"styles", "export", "mine", folder / "mine.json"}), kExitOk);
  EXPECT_EQ(last_.export_style().name(), "mine");
  std::ifstream in(folder / "mine.json");
  EXPECT_EQ(std::string(std::istreambuf_iterator<char>(in), {}), "{}");
  EXPECT_EQ(Run({"styles", "export", "mine", "-"}), kExitOk);
  EXPECT_EQ(out_.str(), "{}");
  EXPECT_EQ(Run({"styles", "import", folder / "mine.json", "--name", "other", "--replace"}),
            kExitOk);
  EXPECT_EQ(last_.import_style().file(), "{}");
  EXPECT_EQ(last_.import_style().name(), "other");
  EXPECT_TRUE(last_.import_style().replace());
  EXPECT_EQ(Run({"styles", "rename", "mine", "yours"}), kExitOk);
  EXPECT_EQ(last_.rename_style().to(), "yours");
  EXPECT_EQ(Run({"styles", "remove", "mine"}), kExitOk);
  EXPECT_EQ(last_.remove_style().name(), "mine");
  EXPECT_EQ(Run({"styles"}), kExitOk);
  EXPECT_TRUE(Says("STYLE    OF")) << out_.str();
  EXPECT_EQ(Run({"--json", "styles", "list"}), kExitOk);
  EXPECT_EQ(nlohmann::json::parse(out_.str())["styles"][1]["made"], false);
}

TEST_F(StylectlTest, ANeutralClipIsMeasuredFirst) {
  const support::TemporaryFolder folder;
  std::ofstream(folder / "mine.bvh") << "a";
  std::ofstream(folder / "usual.bvh") << "b";
  EXPECT_EQ(
      Run({"like", "rig.anna", "--clip", folder / "mine.bvh", "--neutral", folder / "usual.bvh"}),
      kExitOk);
  EXPECT_EQ(last_.like().clip(), "a");
  EXPECT_FALSE(last_.like().measure());
  ASSERT_EQ(last_.like().neutral_code_size(), 1);
  EXPECT_EQ(last_.like().neutral_code(0), 0.5F);
}

TEST_F(StylectlTest, HowTheClockIsDisciplinedIsShown) {
  EXPECT_EQ(Run({"status"}), kExitOk);
  EXPECT_TRUE(
      Says("clock: PTP domain 127, leader 001122.fffe.334455, port SLAVE, offset -178 ns, "
           "path 2456 ns, within 12 us\n"))
      << out_.str();
  EXPECT_EQ(Run({"--json", "status"}), kExitOk);
  const auto clock = nlohmann::json::parse(out_.str())["clock"];
  EXPECT_EQ(clock["source"], "ptp");
  EXPECT_EQ(clock["locked"], true);
  EXPECT_EQ(clock["ptp"]["domain"], 127);
  v1::StatusReply status;
  const auto shows = [&status](const std::string& text) {
    return StatusText(status, false).find(text) != std::string::npos;
  };
  EXPECT_FALSE(shows("clock:")) << "an older daemon says nothing of it";
  v1::ClockState& free = *status.mutable_stats()->mutable_clock();
  EXPECT_TRUE(shows("clock: not synchronized: the frames' wall times drift"));
  free = Clock();
  free.set_locked(false);
  EXPECT_TRUE(shows("path 2456 ns; the system's clock is not synchronized with it (run phc2sys)"));
  free.Clear();
  free.set_source(v1::ClockState::SOURCE_NTP);
  free.set_locked(true);
  free.set_max_error_s(0.0032);
  EXPECT_TRUE(shows("clock: synchronized, within 3.2 ms\n"));
}

TEST_F(StylectlTest, ADaemonsTextMovesNoCursor) {
  EXPECT_EQ(Run({"preset", "hostile"}), kExitRefused);
  EXPECT_TRUE(Complains("\\x1b[2J\\x1b[31mred\\x07")) << err_.str();
  EXPECT_FALSE(Complains("\x1b"));
}

TEST_F(StylectlTest, TheWithheldShareOfAStyleIsShown) {
  v1::StatusReply status;
  v1::PerformerStats& anna = *status.mutable_stats()->add_performers();
  anna.set_performer("rig.anna");
  anna.set_live(true);
  anna.mutable_look()->set_strength(1);
  anna.mutable_look()->add_parts(v1::BODY_PART_ALL);
  anna.mutable_look()->add_mix()->set_style("old");
  anna.mutable_look()->mutable_mix(0)->set_weight(1);
  const auto shows = [&status](const std::string& text) {
    return StatusText(status, false).find(text) != std::string::npos;
  };
  EXPECT_FALSE(shows("hardly")) << "nothing is known";
  anna.set_turned_deg(8.26F);
  for (const auto set :
       {&v1::LimbShares::set_left_arm, &v1::LimbShares::set_right_arm, &v1::LimbShares::set_trunk,
        &v1::LimbShares::set_left_leg, &v1::LimbShares::set_right_leg}) {
    (anna.mutable_shown()->*set)(1);
  }
  anna.mutable_moved()->set_knees(2.26F);
  anna.mutable_moved()->set_head(1);
  EXPECT_TRUE(shows("2.3"));
  EXPECT_FALSE(shows("shows of the style"));
  anna.mutable_neutral()->set_learned(0.974F);
  EXPECT_TRUE(shows("97 %"));
  EXPECT_FALSE(shows("is learned to")) << "enough of it";
  anna.mutable_neutral()->set_learned(0.5F);
  EXPECT_TRUE(shows("rig.anna: their neutral is learned to 50 %"));
  anna.mutable_neutral()->set_calibrated(true);
  EXPECT_TRUE(shows("calibrated"));
  EXPECT_FALSE(shows("50 %"));
  anna.mutable_shown()->set_left_arm(0.24F);
  anna.mutable_shown()->set_trunk(0.6F);
  EXPECT_TRUE(shows("rig.anna shows of the style: left arm 24 %, trunk 60 %\n"));
  EXPECT_EQ(StatusJson(status)["performers"][0]["shown"]["left_arm"], 0.24);
  EXPECT_EQ(StatusJson(status)["performers"][0]["moved_cm"]["knees"], 2.3);
  anna.set_hardly_styled(true);
  EXPECT_TRUE(shows("rig.anna is hardly styled now: the weights leave their motion unchanged\n"));
  anna.set_live(false);
  EXPECT_FALSE(shows("hardly")) << "they are gone";
}

TEST_F(StylectlTest, AnAbsentPerformerAndAStyleWithoutStrengthAreReported) {
  v1::Applied applied;
  applied.set_performer("rig.an");
  applied.set_first_sequence(598);
  applied.set_absent(true);
  EXPECT_EQ(AppliedText({applied}, "set"),
            "rig.an  set  from their first frame: no performer of this name is present\n");
  applied.set_absent(false);
  applied.set_no_strength(true);
  EXPECT_EQ(AppliedText({applied}, "set"),
            "rig.an  set  from frame 598, not visible: the strength is 0\n");
  EXPECT_EQ(AppliedJson({applied})[0]["no_strength"], true);
  applied.set_no_strength(false);
  applied.set_not_varied("giant");
  EXPECT_EQ(AppliedText({applied}, "set"),
            "rig.an  set  from frame 598, giant as it is: its network has no variations\n");
  v1::Applied kept;
  kept.set_performer("*");
  kept.set_refused("*: too strong");
  EXPECT_EQ(AppliedText({kept}, "set"), "others  set  not changed: *: too strong\n");
  EXPECT_EQ(AppliedJson({kept})[0]["refused"], "*: too strong");
}

TEST_F(StylectlTest, ThePartsFromOtherSourcesAreShown) {
  EXPECT_EQ(Run({"status"}), kExitOk);
  EXPECT_TRUE(Says("rig.anna gets fingers: gloves (silent)\n")) << out_.str();
  EXPECT_EQ(Run({"--json", "status"}), kExitOk);
  const auto layers = nlohmann::json::parse(out_.str())["performers"][0]["layers"];
  ASSERT_EQ(layers.size(), 1U);
  EXPECT_EQ(layers[0]["source"], "gloves");
  EXPECT_EQ(layers[0]["live"], false);
}

TEST_F(StylectlTest, AnExportReplacesNoFileUnlessItIsTold) {
  const support::TemporaryFolder folder;
  const std::string file = folder / "mine.json";
  std::ofstream(file) << "kept";
  EXPECT_EQ(Run({"styles", "export", "mine", file}), kExitUsage);
  EXPECT_TRUE(Complains("mine.json: exists, expected a new file; --overwrite")) << err_.str();
  const auto content = [&file] {
    std::ifstream in(file);
    return std::string(std::istreambuf_iterator<char>(in), {});
  };
  EXPECT_EQ(content(), "kept");
  EXPECT_EQ(Run({"styles", "export", "mine", file, "--overwrite"}), kExitOk);
  EXPECT_EQ(content(), "{}");
}

TEST_F(StylectlTest, ANameMadeOfAFileLooksLikeNoOption) {
  const support::TemporaryFolder folder;
  for (const auto& [file, name] : {std::pair{"-old walk.bvh", "old-walk"}, {"--.bvh", "style"}}) {
    std::ofstream(folder / file) << "a";
    EXPECT_EQ(Run({"like", "rig.anna", "--clip", folder / file}), kExitOk);
    EXPECT_EQ(last_.like().name(), name);
  }
}

TEST_F(StylectlTest, AStyleForAPerformerWhoIsNotThereIsNoted) {
  const support::TemporaryFolder folder;
  std::ofstream(folder / "mine.bvh") << "a";
  EXPECT_EQ(Run({"like", "rig.ana", "--clip", folder / "mine.bvh"}), kExitOk);
  EXPECT_TRUE(Complains("note: rig.ana has not been seen yet")) << err_.str();
  EXPECT_TRUE(Complains("did you mean rig.anna?")) << err_.str();
  EXPECT_EQ(Run({"--json", "vary", "rig.ana", "--style", "old"}), kExitOk);
  EXPECT_TRUE(Says("\"note\":\"rig.ana has not been seen yet")) << out_.str();
  for (const std::vector<std::string>& more :
       {std::vector<std::string>{"rig.anna"}, {"*"}, {"rig.ana", "--unworn"}}) {
    std::vector<std::string> arguments{"like", "--clip", folder / "mine.bvh"};
    arguments.insert(arguments.begin() + 1, more.begin(), more.end());
    EXPECT_EQ(Run(arguments), kExitOk);
    EXPECT_FALSE(Complains("not been seen")) << err_.str();
  }
}

TEST_F(StylectlTest, AMisspeltStyleIsRefusedWithTheNearestName) {
  EXPECT_EQ(Run({"set", "*", "--style", "eldrly"}), kExitRefused);
  EXPECT_TRUE(out_.str().empty());
  EXPECT_TRUE(Complains("unknown style 'eldrly'; did you mean 'elderly'?")) << err_.str();
  EXPECT_TRUE(Complains("styles: old, proud")) << err_.str();
  EXPECT_EQ(Run({"preset", "scnee"}), kExitRefused);
  EXPECT_TRUE(Complains("did you mean 'scene'?")) << err_.str();
}

TEST_F(StylectlTest, AMisspeltPerformerIsNoted) {
  EXPECT_EQ(Run({"set", "rig.ana", "--style", "old"}), kExitOk);
  EXPECT_TRUE(Complains("did you mean rig.anna?")) << err_.str();
  EXPECT_EQ(Run({"set", "rig.anna", "--style", "old"}), kExitOk);
  EXPECT_TRUE(err_.str().empty()) << err_.str();
}

TEST_F(StylectlTest, APerformerConfiguredAheadIsNotSuggestedInItsOwnStead) {
  EXPECT_EQ(Run({"reset", "cam.zed"}), kExitRefused);
  EXPECT_TRUE(Complains("was not seen yet\n  performers: rig.anna\n")) << err_.str();
}

TEST_F(StylectlTest, AnUnknownCommandIsNamed) {
  EXPECT_EQ(Run({"dance"}), kExitUsage);
  EXPECT_TRUE(Complains("'dance' is no command; expected one of list, status, stages"))
      << err_.str();
}

TEST_F(StylectlTest, AMisspeltCommandOrOptionIsAnsweredWithTheNearestOne) {
  EXPECT_EQ(Run({"stauts"}), kExitUsage);
  EXPECT_TRUE(Complains("'stauts' is no command; did you mean 'status'?")) << err_.str();
  EXPECT_EQ(Run({"--json", "sett", "*", "--style", "old"}), kExitUsage);
  EXPECT_TRUE(Complains("'sett' is no command; did you mean 'set'?")) << err_.str();
  EXPECT_EQ(Run({"set", "*", "--stlye", "old"}), kExitUsage);
  EXPECT_TRUE(Complains("'--stlye' is no option of set; did you mean '--style'?")) << err_.str();
  EXPECT_EQ(Run({"--endpont=x", "list"}), kExitUsage);
  EXPECT_TRUE(Complains("'--endpont' is no option of list; did you mean '--endpoint'?"))
      << err_.str();
  EXPECT_EQ(Run({"status", "--zzzzzzzz"}), kExitUsage);
  EXPECT_TRUE(Complains("'--zzzzzzzz' is no option of status\n")) << err_.str();
}

TEST_F(StylectlTest, OptionsOfEveryCommandMayStandBeforeItAndBehindIt) {
  const std::vector<std::vector<std::string>> common = {
      {"--endpoint", daemon_.control()}, {"--timeout", "1.5"}, {"--json"}};
  const std::vector<std::vector<std::string>> commands = {{"list"},
                                                          {"status"},
                                                          {"set", "*", "--style", "old"},
                                                          {"clear", "*"},
                                                          {"pin", "rig.anna"},
                                                          {"unpin", "rig.anna"},
                                                          {"preset", "*", "scene"},
                                                          {"reset", "*"},
                                                          {"panic"}};
  for (const auto& command : commands) {
    for (const auto& option : common) {
      std::vector<std::string> before = option, behind = command;
      before.insert(before.end(), command.begin(), command.end());
      behind.insert(behind.end(), option.begin(), option.end());
      std::ostringstream out, err;
      // Without Run's own --endpoint, where that is the one under test.
      const auto run = [&](std::vector<std::string> words) {
        if (option[0] == "--endpoint") return stylectl::Run(std::move(words), out, err);
        return Run(std::move(words));
      };
      EXPECT_EQ(run(before), kExitOk) << testing::PrintToString(before) << err.str();
      EXPECT_EQ(run(behind), kExitOk) << testing::PrintToString(behind) << err.str();
    }
  }
  const support::TemporaryFolder folder;
  std::filesystem::create_directory(folder / "keys");
  EXPECT_EQ(Run({"--keys", folder / "keys", "keys"}), kExitOk) << err_.str();
  EXPECT_EQ(Run({"keys", "--keys", folder / "keys"}), kExitOk) << err_.str();
  EXPECT_EQ(Run({"--keys=" + (folder / "keys"), "revoke", "anna"}), kExitRefused);
  EXPECT_TRUE(Complains("'anna' is not allowed at " + (folder / "keys"))) << err_.str();
  // Mistaken for --key.
  EXPECT_EQ(Run({"--keys", folder / "keys", "status"}), kExitUsage);
  EXPECT_TRUE(Complains("own pair of keys is --key")) << err_.str();
}

TEST_F(StylectlTest, PresetTakesThePerformerFirstAsEveryCommandAndLastAsItOnceDid) {
  for (const auto& words : std::vector<std::vector<std::string>>{
           {"preset", "rig.anna", "scene"},
           {"preset", "scene", "rig.anna"},
           {"preset", "--transition", "10", "rig.anna", "scene"}}) {
    EXPECT_EQ(Run(words), kExitOk) << testing::PrintToString(words) << err_.str();
    EXPECT_EQ(last_.preset().name(), "scene");
    EXPECT_EQ(last_.performer(), "rig.anna");
  }
  for (const auto& words : std::vector<std::vector<std::string>>{
           {"preset", "scene"}, {"preset", "*", "scene"}, {"preset", "scene", "*"}}) {
    EXPECT_EQ(Run(words), kExitOk) << testing::PrintToString(words) << err_.str();
    EXPECT_EQ(last_.preset().name(), "scene");
    EXPECT_EQ(last_.performer(), "*");
  }
  last_.Clear();
  for (const auto& words : std::vector<std::vector<std::string>>{{"preset", "rig.anna"},
                                                                 {"preset", "rig.anna", "rig.bob"},
                                                                 {"preset", "scene", "anna"},
                                                                 {"preset", "*", "*"}}) {
    EXPECT_EQ(Run(words), kExitUsage) << testing::PrintToString(words);
    EXPECT_TRUE(Complains("preset: ")) << err_.str();
  }
  EXPECT_EQ(last_.command_case(), v1::Request::COMMAND_NOT_SET) << "nobody was asked";
}

TEST_F(StylectlTest, JsonIsOneObjectPerCommandOnFailureToo) {
  EXPECT_EQ(Run({"list", "--json"}), kExitOk);
  EXPECT_EQ(nlohmann::json::parse(out_.str())["styles"][1]["aliases"][0], "elderly");
  EXPECT_EQ(Run({"--json", "status"}), kExitOk);
  auto object = nlohmann::json::parse(out_.str());
  EXPECT_EQ(object["performers"][0]["performer"], "rig.anna");
  EXPECT_EQ(object["counters"]["source.bad_crc"], 3);
  EXPECT_EQ(Run({"--json", "set", "rig.anna", "--style", "old"}), kExitOk);
  EXPECT_EQ(nlohmann::json::parse(out_.str())["applied"][0]["first_sequence"], 4711);
  EXPECT_EQ(Run({"--json", "set", "*", "--style", "prod"}), kExitRefused);
  object = nlohmann::json::parse(out_.str());
  EXPECT_EQ(object["ok"], false);
  EXPECT_EQ(object["code"], "UNKNOWN_STYLE");
  EXPECT_EQ(object["suggestion"], "proud");
}

TEST_F(StylectlTest, AWrongCommandLineIsAUsageErrorAndAsksNobody) {
  const std::vector<std::vector<std::string>> wrong = {
      {},
      {"dance"},
      {"set"},
      {"set", "*"},
      {"set", "nodot", "--style", "old"},
      {"set", "*", "--style", "old", "--strength", "2"},
      {"set", "*", "--mix", "old"},
      {"set", "*", "--mix", "old=x"},
      {"set", "*", "--mix", "old=1", "--style", "old"},
      {"set", "*", "--absolute", "--detail"},
      {"set", "*", "--mirror", "--no-mirror"},
      {"set", "*", "--style", "old", "--transition", "-1"},
      {"set", "*", "--only", "tail"},
      {"set", "*", "--only"},
      {"set", "*", "--root", "home"},
      {"set", "*", "--root", "1"},
      {"preset"},
      {"pin"},
      {"list", "--timeout", "0"},
      {"list", "--timeout", "nan"},
  };
  for (const auto& arguments : wrong) {
    EXPECT_EQ(Run(arguments), kExitUsage) << testing::PrintToString(arguments);
    EXPECT_FALSE(err_.str().empty());
  }
  EXPECT_EQ(last_.command_case(), v1::Request::COMMAND_NOT_SET);
}

TEST(Stylectl, WithoutADaemonItSaysWhereItLookedAndWhatToCheck) {
  std::ostringstream out, err;
  EXPECT_EQ(
      stylectl::Run({"status", "--endpoint", "tcp://127.0.0.1:9", "--timeout", "0.1"}, out, err),
      kExitNoDaemon);
  EXPECT_NE(err.str().find("tcp://127.0.0.1:9"), std::string::npos);
  EXPECT_NE(err.str().find("STYLED_CONTROL"), std::string::npos);
}

TEST(Nearest, FindsWhatWasMeantAndOnlyThat) {
  const std::vector<std::string> names{"old", "proud", "feminine", "masculine", "childlike"};
  EXPECT_EQ(Nearest("OLD", names), "old");
  EXPECT_EQ(Nearest("prodd", names), "proud");
  EXPECT_EQ(Nearest("femnine", names), "feminine");
  EXPECT_EQ(Nearest("child", names), "childlike");
  EXPECT_EQ(Nearest("masculnie", names), "masculine");
  EXPECT_EQ(Nearest("zombie", names), "");
  EXPECT_EQ(Nearest("x", names), "");
}

TEST(Table, AlignsNumbersRightAndWordsLeft) {
  EXPECT_EQ(Table({{"NAME", "N"}, {"é", "10"}, {"long", "9"}}), "NAME   N\né     10\nlong   9\n");
}

}  // namespace
}  // namespace styled::stylectl
