#include "daemon/config/config.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <regex>

#include "daemon/config/address.h"
#include "daemon/config/machine.h"
#include "proto/styled/look.h"
#include "tests/support/child.h"

namespace styled::config {
namespace {

using testing::HasSubstr;

class ConfigTest : public testing::Test {
 protected:
  Result<Config> LoadText(const std::string& text, const std::vector<std::string>& settings = {}) {
    support::WriteText(file_, text);
    std::vector<Override> overrides;
    for (const auto& setting : settings) overrides.push_back(ParseOverride(setting).value());
    return Load(file_, overrides);
  }
  std::string Complaint(const std::string& text, const std::vector<std::string>& settings = {}) {
    const auto config = LoadText(text, settings);
    return config.ok() ? "" : config.status().message();
  }
  support::TemporaryFolder folder_;
  std::string file_ = folder_ / "c.toml";
};

TEST_F(ConfigTest, DefaultsNeedNoFileAndAreLocal) {
  const auto config = Load("", {});
  ASSERT_TRUE(config.ok()) << config.status().message();
  EXPECT_EQ(config.value().sources.size(), 2U);
  EXPECT_TRUE(IsLocal(config.value().publish.address));
  EXPECT_TRUE(IsLocal(config.value().control.address));
}

TEST_F(ConfigTest, TheManualIsTheDefaultsAndNamesEveryKey) {
  const std::string manual = support::ReadText(STYLED_MANUAL);
  ASSERT_FALSE(manual.empty());
  EXPECT_EQ(Complaint(manual), "");
  // Uncommenting every key gives a valid file with the very same values.
  const std::string all = std::regex_replace(manual, std::regex("\n# ([a-z_]+ = )"), "\n$1");
  const auto config = LoadText(all);
  ASSERT_TRUE(config.ok()) << config.status().message();
  const Config defaults;
  EXPECT_EQ(config.value().sources, defaults.sources);
  EXPECT_TRUE(config.value().publish == defaults.publish);
  EXPECT_TRUE(config.value().control == defaults.control);
  EXPECT_TRUE(config.value().security == defaults.security);
  EXPECT_TRUE(config.value().realtime == defaults.realtime);
  EXPECT_TRUE(config.value().record == defaults.record);
  EXPECT_FLOAT_EQ(config.value().model.stylist.gap_reset_s, defaults.model.stylist.gap_reset_s);
  EXPECT_FLOAT_EQ(config.value().model.stylist.change_tau_s, defaults.model.stylist.change_tau_s);
  const feet::Options& feet = config.value().model.stylist.feet_options;
  const feet::Options& feet_defaults = defaults.model.stylist.feet_options;
  EXPECT_TRUE(config.value().model.stylist.feet);
  EXPECT_FLOAT_EQ(feet.reach_m, feet_defaults.reach_m);
  EXPECT_FLOAT_EQ(feet.blend_in_s, feet_defaults.blend_in_s);
  EXPECT_FLOAT_EQ(feet.blend_out_s, feet_defaults.blend_out_s);
  EXPECT_FLOAT_EQ(feet.return_s, feet_defaults.return_s);
  EXPECT_FLOAT_EQ(feet.hips_drop_m, feet_defaults.hips_drop_m);
  EXPECT_FLOAT_EQ(config.value().performers.stale_s, defaults.performers.stale_s);
  EXPECT_FLOAT_EQ(config.value().performers.late_s, defaults.performers.late_s);
  v1::Look look = InitialLook();
  Apply(config.value().style.look, look);
  EXPECT_TRUE(Equal(look, InitialLook()));
  EXPECT_TRUE(IsEmpty(defaults.style.look));
  for (const std::string key : {"sender_limit_hz",
                                "ipc_mode",
                                "ipc_users",
                                "keys",
                                "receive_buffer_bytes",
                                "max_connections",
                                "max_subscriptions",
                                "weights",
                                "jump_accept_frames",
                                "out_of_domain_fade_ms",
                                "tilt_begin_rad",
                                "ground",
                                "feet",
                                "feet_reach_m",
                                "clock_back_ms",
                                "backlog_ms",
                                "initial",
                                "dir",
                                "level",
                                "cpu"}) {
    EXPECT_THAT(manual, HasSubstr(key));
  }
}

TEST_F(ConfigTest, ComplaintsNameFileLineKeyAndWhatWasExpected) {
  EXPECT_EQ(Complaint("\n[publish]\nadress = 'x'\n"),
            file_ + ":3: publish.adress: unknown key, nearest is \"address\"");
  EXPECT_EQ(Complaint("[perfomers]\n"),
            file_ + ":1: perfomers: unknown section, nearest is \"performers\"");
  EXPECT_THAT(Complaint("[performers]\nstale_ms = 5\n"),
              HasSubstr(":2: performers.stale_ms: expected a number from 20 to 60000, found 5"));
  EXPECT_THAT(Complaint("[performers]\nmax_performers = 1.5\n"),
              HasSubstr("expected a whole number"));
  EXPECT_THAT(Complaint("[log]\nlevel = 'loud'\n"), HasSubstr("expected one of \"trace\""));
  EXPECT_THAT(Complaint("[model]\nground = 1\n"), HasSubstr("expected true or false"));
  EXPECT_THAT(Complaint("[model\n"), HasSubstr(file_ + ":1: "));
  EXPECT_THAT(Complaint("[source]\nname = 'x'\n"), HasSubstr("double brackets"));
  EXPECT_THAT(Complaint("[[source]]\nname = 'x'\n"), HasSubstr("source.listen: missing"));
  EXPECT_THAT(Complaint("[[source]]\nlisten = 'nowhere'\n"), HasSubstr("expected HOST:PORT"));
  EXPECT_THAT(Complaint("[presets]\nx = 3\n"),
              HasSubstr(":2: presets.x: expected styles and weights"));
  EXPECT_THAT(Complaint("[presets]\nx = { a=1, b=1 }\n"), HasSubstr("at most 1.5"));
  EXPECT_THAT(Complaint("[presets]\nx = { a=0.1, b=0.1, c=0.1, d=0.1, e=0.1 }\n"),
              HasSubstr("at most 4"));
  EXPECT_THAT(Complaint("[performers]\nlate_ms = 200\n"),
              HasSubstr("at most performers.backlog_ms"));
  EXPECT_THAT(Complaint("[model]\ntilt_begin_rad = 2\n"),
              HasSubstr("model.tilt_begin_rad: expected 0 or more, less than tilt_end_rad"));
  EXPECT_THAT(Complaint("[model]\nout_of_domain_end_rad = 0.6\n"),
              HasSubstr("model.out_of_domain_begin_rad: expected 0 or more, less than"));
  const auto missing = Load(folder_ / "none.toml", {});
  EXPECT_THAT(missing.status().message(), HasSubstr("none.toml"));
}

TEST_F(ConfigTest, FormerNamesOfKeysAreStillRead) {
  const auto config =
      LoadText("[model]\nforeign_begin_rad = 0.5\nforeign_end_rad = 0.9\nforeign_fade_ms = 100\n");
  ASSERT_TRUE(config.ok()) << config.status().message();
  const stylist::Options& options = config.value().model.stylist;
  EXPECT_FLOAT_EQ(options.out_of_domain_begin_rad, 0.5F);
  EXPECT_FLOAT_EQ(options.out_of_domain_end_rad, 0.9F);
  EXPECT_FLOAT_EQ(options.out_of_domain_fade_s, 0.1F);
}

TEST_F(ConfigTest, OutputsAndJointsAreReadAndChecked) {
  const auto config = LoadText(
      "[[source]]\nlisten = '127.0.0.1:0'\njoints = { leftUpperArm = 'Arm_01', spine = '' }\n"
      "[[output]]\nname = 'hero'\navatar = 'hero.vrm'\nperformers = ['rig.anna']\n"
      "joints = { head = 'Skull' }\n");
  ASSERT_TRUE(config.ok()) << config.status().message();
  ASSERT_EQ(config.value().outputs.size(), 1U);
  EXPECT_EQ(config.value().outputs[0].avatar, "hero.vrm");
  EXPECT_EQ(config.value().outputs[0].performers, std::vector<std::string>{"rig.anna"});
  EXPECT_EQ(config.value().outputs[0].joints, (rig::JointNames{{"head", "Skull"}}));
  EXPECT_EQ(config.value().sources[0].joints,
            (rig::JointNames{{"leftUpperArm", "Arm_01"}, {"spine", ""}}));
  EXPECT_THAT(Complaint("[output]\nname = 'x'\n"), HasSubstr("double brackets"));
  for (const std::string name : {"rig", "Rig", "CANONICAL", "source"}) {
    EXPECT_THAT(Complaint("[[output]]\nname = '" + name + "'\navatar = 'a.glb'\n"),
                HasSubstr("output.0.name: \"" + name + "\"; expected"));
  }
  EXPECT_THAT(Complaint("[[output]]\nname = 'x'\n"), HasSubstr("output.0.avatar: missing"));
  EXPECT_THAT(Complaint("[[output]]\nname = 'x'\navatar = 'a'\n[[output]]\nname = 'x'\n"
                        "avatar = 'b'\n"),
              HasSubstr("is taken by output.0"));
  EXPECT_THAT(Complaint("[[output]]\nname = 'x'\nperformers = 'rig.a'\n"),
              HasSubstr(":3: output.performers: expected a list"));
  EXPECT_THAT(Complaint("[[output]]\nname = 'x'\navatar = 'a'\nperformers = ['anna']\n"),
              HasSubstr("output.0.performers: \"anna\"; expected SOURCE.NAME"));
  EXPECT_THAT(Complaint("[[source]]\nlisten = '127.0.0.1:0'\njoints = { leftUperArm = 'x' }\n"),
              HasSubstr("\"leftUperArm\" is not a joint of the canonical humanoid, nearest is "
                        "\"leftUpperArm\""));
}

TEST_F(ConfigTest, OtherMachinesNeedAKeyThatAdmitsThem) {
  for (const std::string address : {"tcp://0.0.0.0:1", "tcp://*:1", "tcp://192.168.1.2:1",
                                    "tcp://127.example.org:1", "tcp://[::]:1"}) {
    EXPECT_THAT(Complaint("[publish]\naddress = '" + address + "'\n"),
                HasSubstr("not authenticated"))
        << address;
    EXPECT_EQ(
        Complaint("[publish]\naddress = '" + address + "'\nallow_unauthenticated_remote = true\n"),
        "");
    EXPECT_THAT(Complaint("[control]\naddress = '" + address + "'\n"),
                HasSubstr("not authenticated"));
  }
  for (const std::string address : {"tcp://127.0.0.1:0", "tcp://[::1]:9", "ipc:///tmp/x"}) {
    EXPECT_EQ(Complaint("[publish]\naddress = '" + address + "'\n"), "") << address;
  }
}

TEST_F(ConfigTest, AStandbyOnAnotherMachineNeedsKeysOrAnExplicitSetting) {
  const std::string here = "[standby]\npeer = 'tcp://127.0.0.1:7014'\n";
  EXPECT_EQ(Complaint(here), "");
  EXPECT_EQ(Complaint("[standby]\naddress = 'nonsense'\n"), "") << "off: not looked at";
  EXPECT_THAT(Complaint("[standby]\npeer = 'nonsense'\n"), HasSubstr("standby.peer: "));
  EXPECT_THAT(Complaint(here + "address = 'tcp://127.0.0.1:7014'\n"),
              HasSubstr("this daemon's own standby.address"));
  EXPECT_THAT(Complaint(here + "address = 'tcp://127.0.0.1:7001'\n"),
              HasSubstr("is taken by publish.address"));
  EXPECT_THAT(Complaint(here + "hold_ms = 5\n"), HasSubstr("standby.hold_ms"));
  const std::string far = "[standby]\npeer = 'tcp://10.0.0.2:7004'\n";
  const std::string key = "peer_key = '" + std::string(40, 'k') + "'\n";
  const std::string keys = "[security]\nkeys = '/k'\n";
  EXPECT_THAT(Complaint(far),
              HasSubstr("standby.peer: tcp://10.0.0.2:7004 is not local to this machine"));
  EXPECT_THAT(Complaint(far + key), HasSubstr("security.keys"));
  EXPECT_THAT(Complaint(keys + far), HasSubstr("standby.peer_key"));
  EXPECT_THAT(Complaint(keys + far + "peer_key = 'short'\n"), HasSubstr("expected the 40"));
  EXPECT_THAT(Complaint(here + "address = 'tcp://0.0.0.0:7004'\n"), HasSubstr("standby.address"));
  EXPECT_EQ(Complaint(keys + far + key), "");
  EXPECT_EQ(Complaint(far + "allow_unauthenticated_remote = true\n"), "");
}

TEST_F(ConfigTest, KeysAdmitOtherMachinesAndALocalAddressNeedsNone) {
  const std::string keys = "[security]\nkeys = '/k'\n";
  const auto asks = [&](const std::string& text) {
    const auto config = LoadText(text);
    EXPECT_TRUE(config.ok()) << config.status().message();
    const Publish& publish = config.value().publish;
    return RequiresKeys(config.value(), publish.address, publish.allow_unauthenticated_remote);
  };
  EXPECT_TRUE(asks(keys + "[publish]\naddress = 'tcp://0.0.0.0:1'\n"));
  EXPECT_FALSE(asks(keys));
  EXPECT_FALSE(asks(keys + "[publish]\naddress = 'ipc:///tmp/x'\n"));
  EXPECT_FALSE(asks(keys + "[publish]\naddress = 'tcp://0.0.0.0:1'\n"
                           "allow_unauthenticated_remote = true\n"));
  EXPECT_EQ(Complaint(keys + "[control]\naddress = 'tcp://[::]:1'\n"), "");
  EXPECT_THAT(Complaint("[control]\naddress = 'tcp://[::]:1'\n"), HasSubstr("(security.keys)"));
}

TEST_F(ConfigTest, ThePermissionsOfAnIpcPathAreRead) {
  const auto config = LoadText(
      "[publish]\nipc_mode = '0660'\nipc_users = ['anna', 1001]\n[control]\nipc_mode = '600'\n");
  ASSERT_TRUE(config.ok()) << config.status().message();
  EXPECT_EQ(config.value().publish.ipc.mode, 0660);
  EXPECT_EQ(config.value().publish.ipc.users, (std::vector<std::string>{"anna", "1001"}));
  EXPECT_EQ(config.value().control.ipc.mode, 0600);
  for (const std::string mode : {"0668", "66", "1777", "", "432", "rw"}) {
    EXPECT_THAT(
        Complaint("[publish]\nipc_mode = " + (mode == "432" ? mode : "'" + mode + "'") + "\n"),
        HasSubstr("publish.ipc_mode: expected a file's mode in quotes"))
        << mode;
  }
  for (const std::string users : {"'anna'", "[1.5]", "[-1]", "[true]", "[4294967295]"}) {
    EXPECT_THAT(Complaint("[control]\nipc_users = " + users + "\n"),
                HasSubstr("control.ipc_users: expected a list of users"))
        << users;
  }
  EXPECT_THAT(Complaint("[control]\nipc_users = ['anna']\n"),
              HasSubstr("control.ipc_users: no other user is admitted by control.ipc_mode"));
}

TEST_F(ConfigTest, ALimitForEachSenderIsANumberOrNone) {
  EXPECT_EQ(Complaint("", {"source.0.sender_limit_hz=0"}), "");
  EXPECT_THAT(Complaint("", {"source.0.sender_limit_hz=-1"}), HasSubstr("from 0 to 100000000"));
}

TEST_F(ConfigTest, AHostsNameIsRefusedBeforeAnySocketIs) {
  for (const std::string section : {"publish", "control"}) {
    EXPECT_THAT(Complaint("[" + section + "]\naddress = 'tcp://localhost:9'\n"),
                HasSubstr(section + ".address: \"tcp://localhost:9\": ZeroMQ does not bind"));
  }
  const auto listen = [&](const std::string& address) {
    return Complaint("[[source]]\nname='a'\ntype='udp'\nlisten='" + address + "'\n");
  };
  EXPECT_THAT(listen("localhost:9"), HasSubstr("source.0.listen: \"localhost:9\": expected"));
  EXPECT_THAT(listen("256.1.1.1:9"), HasSubstr("numeric"));
  EXPECT_EQ(listen("[::1]:9"), "");
}

TEST_F(ConfigTest, NoPortIsGivenTwice) {
  // Each with the line to change, the program that uses the address, and the line that states it.
  EXPECT_EQ(Complaint("[publish]\naddress = 'tcp://127.0.0.1:7100'\n"
                      "[control]\naddress = 'tcp://127.0.0.1:7100'\n"),
            file_ + ":4: control.address: tcp://127.0.0.1:7100 is taken by publish.address (" +
                file_ + ":2); expected an address of its own");
  EXPECT_EQ(Complaint("\n[publish]\naddress = 'tcp://127.0.0.1:7002'\n"),
            file_ +
                ":3: publish.address: tcp://127.0.0.1:7002 is taken by control.address (its "
                "default); expected an address of its own");
  EXPECT_EQ(Complaint("[control]\nallow_unauthenticated_remote = true\n"
                      "address = 'tcp://*:7001'\n"),
            file_ +
                ":3: control.address: tcp://*:7001 is taken by publish.address, "
                "tcp://127.0.0.1:7001 (its default); expected an address of its own");
  const std::string ipc = "address = 'ipc:///run/x'\n";
  EXPECT_THAT(Complaint("[publish]\n" + ipc + "[control]\n" + ipc),
              HasSubstr(":4: control.address: ipc:///run/x is taken by publish.address"));
  const auto sources = [&](const std::string& type_a, const std::string& a,
                           const std::string& type_b, const std::string& b) {
    return Complaint("[[source]]\ntype = '" + type_a + "'\nlisten = '" + a +
                     "'\n[[source]]\ntype = '" + type_b + "'\nlisten = '" + b + "'\n");
  };
  EXPECT_THAT(
      sources("udp", "127.0.0.1:9", "vmc", "127.0.0.1:9"),
      HasSubstr(":6: source.1.listen: 127.0.0.1:9 is taken by source.0.listen (" + file_ + ":3)"));
  EXPECT_THAT(sources("udp", "0.0.0.0:9", "udp", "127.0.0.1:9"),
              HasSubstr("taken by source.0.listen, 0.0.0.0:9"));
  EXPECT_THAT(sources("tcp", "127.0.0.1:7001", "udp", "127.0.0.1:9"),
              HasSubstr(":3: source.0.listen: 127.0.0.1:7001 is taken by publish.address, "
                        "tcp://127.0.0.1:7001 (its default)"));
  EXPECT_THAT(Complaint("[osc]\nlisten = '127.0.0.1:7000'\n"),
              HasSubstr(":2: osc.listen: 127.0.0.1:7000 is taken by source.0.listen"));
  EXPECT_THAT(Complaint("", {"control.address=tcp://127.0.0.1:7001"}),
              HasSubstr("--set control.address: control.address: tcp://127.0.0.1:7001 is taken"));
  // One port for UDP and TCP, any free port, other addresses and other families are good.
  EXPECT_EQ(sources("udp", "127.0.0.1:9", "tcp", "127.0.0.1:9"), "");
  EXPECT_EQ(sources("udp", "127.0.0.1:0", "udp", "127.0.0.1:0"), "");
  EXPECT_EQ(sources("udp", "127.0.0.1:9", "udp", "127.0.0.2:9"), "");
  EXPECT_EQ(sources("udp", "0.0.0.0:9", "udp", "[::]:9"), "");
  EXPECT_EQ(Complaint("[publish]\naddress = 'tcp://127.0.0.1:0'\n"
                      "[control]\naddress = 'tcp://127.0.0.1:0'\n"),
            "");
}

TEST_F(ConfigTest, BadAddressesAreRefusedWithTheirLine) {
  for (const std::string port : {"65536", "70000", "99999999999999999999"}) {
    EXPECT_EQ(Complaint("[publish]\n\naddress = 'tcp://127.0.0.1:" + port + "'\n"),
              file_ + ":3: publish.address: \"127.0.0.1:" + port + "\": the port is " + port +
                  "; expected 0 to 65535");
    EXPECT_EQ(Complaint("[[source]]\nname = 'a'\nlisten = '127.0.0.1:" + port + "'\n"),
              file_ + ":3: source.0.listen: \"127.0.0.1:" + port + "\": the port is " + port +
                  "; expected 0 to 65535");
    EXPECT_EQ(Complaint("\n[osc]\nlisten = '127.0.0.1:" + port + "'\n"),
              file_ + ":3: osc.listen: \"127.0.0.1:" + port + "\": the port is " + port +
                  "; expected 0 to 65535");
  }
  EXPECT_THAT(Complaint("[control]\naddress = 'tcp://127.0.0.1:-1'\n"),
              HasSubstr(":2: control.address: \"127.0.0.1:-1\" is not an address"));
  EXPECT_THAT(Complaint("[control]\naddress = 'tcp://127.0.0.1'\n"),
              HasSubstr(":2: control.address: \"127.0.0.1\" is not an address"));
  EXPECT_THAT(Complaint("[control]\naddress = 'udp://127.0.0.1:1'\n"),
              HasSubstr(":2: control.address: \"udp://127.0.0.1:1\" is not an endpoint"));
  EXPECT_THAT(Complaint("[[source]]\nname = 'a'\nlisten = 'somewhere:1'\n"),
              HasSubstr(":3: source.0.listen: \"somewhere:1\": expected a numeric address"));
}

TEST_F(ConfigTest, RulesThatSpanKeysNameTheLineToo) {
  EXPECT_THAT(Complaint("[performers]\nlate_ms = 200\n"), HasSubstr(file_ + ":2: performers.late"));
  EXPECT_THAT(Complaint("[presets]\n\nx = { a=1, b=0.7 }\n"),
              HasSubstr(file_ + ":3: presets.x: weights sum to 1.7; expected at most 1.5"));
  EXPECT_EQ(Complaint("[[cue]]\nname = 'a b'\npanic = true\n"),
            file_ + ":2: cue.0.name: \"a b\"; expected 1 to 32 of A-Z a-z 0-9 _ -");
  EXPECT_THAT(Complaint("[[cue]]\nname = 'a'\nperformer = 'rgi.anna'\npanic = true\n"),
              HasSubstr("cue.0.performer: \"rgi.anna\": no such source; the sources are rig"));
  EXPECT_THAT(Complaint("\n[[output]]\nname = 'x'\n"), HasSubstr(file_ + ":2: output.0.avatar"));
  EXPECT_THAT(Complaint("[[cue]]\nname = 'a'\nparts = 'tail'\n"),
              HasSubstr(file_ + ":3: cue.parts: expected in quotes, separated by commas, some of"));
  EXPECT_EQ(Complaint("[[cue]]\nname = 'a'\nonly = 'arms'\nfrom = 'old'\n"), "");
  for (const char* root : {"'home'", "1", "true"}) {
    EXPECT_THAT(Complaint("[style]\nroot = " + std::string(root) + "\n"),
                HasSubstr(file_ + ":2: style.root: expected follow or stride, in quotes"));
  }
  EXPECT_THAT(Complaint("[style]\nstrength = 1.6\n"),
              HasSubstr("expected a number from 0 to 1.5, found 1.6"));
  EXPECT_THAT(Complaint("", {"performers.late_ms=200"}),
              HasSubstr("--set performers.late_ms: performers.late_ms: expected"));
}

TEST_F(ConfigTest, TheCommandLineWinsOverTheEnvironmentAndThatOverTheFile) {
  const char* const environment[] = {"HOME=/", "STYLED_PERFORMERS_STALE_MS=300", "STYLED_DATA=/x",
                                     "STYLED_LOG_LEVEL=debug", nullptr};
  auto overrides = EnvironmentOverrides(environment).value();
  ASSERT_EQ(overrides.size(), 2U);
  overrides.push_back(ParseOverride("log.level=error").value());
  overrides.push_back(ParseOverride("presets.p={a=0.5}").value());
  overrides.push_back(ParseOverride("source.1.listen=127.0.0.1:9").value());
  support::WriteText(file_, "[performers]\nstale_ms = 500\nforget_s = 9\n[log]\nlevel = 'warn'\n");
  const auto config = Load(file_, overrides);
  ASSERT_TRUE(config.ok()) << config.status().message();
  EXPECT_FLOAT_EQ(config.value().performers.stale_s, 0.3F);
  EXPECT_FLOAT_EQ(config.value().performers.forget_s, 9);
  EXPECT_EQ(config.value().log.level, "error");
  EXPECT_EQ(config.value().presets.at(0).name, "p");
  EXPECT_EQ(config.value().sources.at(1).listen, "127.0.0.1:9");
}

TEST_F(ConfigTest, OverridesAreAsStrictAsTheFile) {
  EXPECT_THAT(
      Complaint("", {"publish.adress=x"}),
      HasSubstr("--set publish.adress: publish.adress: unknown key, nearest is \"address\""));
  EXPECT_THAT(Complaint("", {"nothing.at=1"}), HasSubstr("unknown section"));
  EXPECT_THAT(Complaint("", {"source.7.listen=127.0.0.1:1"}), HasSubstr("there are 2 sources"));
  EXPECT_FALSE(ParseOverride("nonsense").ok());
  const char* const typo[] = {"STYLED_PUBLISH_ADRESS=x", nullptr};
  EXPECT_THAT(EnvironmentOverrides(typo).status().message(), HasSubstr("nearest is \"address\""));
}

TEST_F(ConfigTest, NatNetsServerIsValidatedWithoutARequest) {
  const std::string source = "[[source]]\nname = \"o\"\ntype = \"natnet\"\n";
  EXPECT_EQ(Complaint(source + "server = \"192.168.1.10\"\n"), "");
  EXPECT_THAT(Complaint(source), HasSubstr("source.0.server: \"\"; expected an IPv4 address"));
  EXPECT_THAT(Complaint(source + "server = \"motive.local\"\n"),
              HasSubstr("source.0.server: \"motive.local\"; expected an IPv4 address"));
  EXPECT_THAT(Complaint(source + "server = \"10.0.0.1\"\ngroup = \"10.0.0.2\"\n"),
              HasSubstr("source.0.group: \"10.0.0.2\"; expected an IPv4 multicast address"));
}

TEST_F(ConfigTest, QtmsServerIsValidatedWithoutARequest) {
  const std::string source = "[[source]]\nname = \"o\"\ntype = \"qtm\"\n";
  EXPECT_EQ(Complaint(source + "server = \"192.168.1.10\"\n"), "");
  EXPECT_EQ(Complaint(source + "server = \"192.168.1.10:22225\"\n"), "");
  EXPECT_THAT(
      Complaint(source),
      HasSubstr("source.0.server: \"\"; expected an IPv4 address, or an address and a port, e.g. "
                "\"192.168.1.10:22223\""));
}

// The body of the only [[source]], or of the second one, after defaults.
TEST_F(ConfigTest, AFaceAloneIsAPerformerOfItsOwn) {
  const auto source = [](const std::string& text) {
    const auto config = Parse(text, "test", {});
    EXPECT_TRUE(config.ok()) << config.status().message();
    return config.ok() ? config.value().sources.back() : Source();
  };
  const std::string phone = "[[source]]\nname = \"phone\"\ntype = \"ifacialmocap\"\n";
  const std::string rig = "[[source]]\nname = \"stage\"\nlisten = \"127.0.0.1:0\"\n";
  EXPECT_EQ(source(phone).body, "standing");
  EXPECT_EQ(source(phone).merge_into, "");
  EXPECT_EQ(source(phone + "body = \"seated\"\n").body, "seated");
  EXPECT_EQ(source(rig + phone).merge_into, "*") << "the face of the rig's performer";
  EXPECT_FALSE(source(rig + phone).FaceAlone());
  EXPECT_TRUE(source(rig + phone + "body = \"seated\"\n").FaceAlone()) << "beside the rig";
  const std::string other = "[[source]]\nname = \"other\"\ntype = \"livelinkface\"\n";
  EXPECT_EQ(source(phone + other).body, "standing") << "two phones, two performers";
  EXPECT_THAT(Complaint(rig + phone + "body = \"seated\"\nmerge_into = \"*\"\n"),
              HasSubstr("source.1.body: \"seated\" and merge_into: \"*\"; expected one of them"));
  EXPECT_THAT(Complaint("[[source]]\nname = \"s\"\ntype = \"vmc\"\nbody = \"seated\"\n"),
              HasSubstr("source.0.body: a source of type \"vmc\" sends a body"));
  EXPECT_THAT(Complaint(phone + "body = \"lying\"\n"), HasSubstr("standing"));
}

TEST_F(ConfigTest, AFaceIsAPerformersOfAnotherSource) {
  const std::string rig =
      "[[source]]\nname = \"stage\"\ntype = \"udp\"\nlisten = \"127.0.0.1:0\"\n";
  const auto phone = [&rig](const std::string& keys) {
    return rig + "[[source]]\nname = \"phone\"\n" + keys;
  };
  const std::string face = "type = \"livelinkface\"\n";
  EXPECT_EQ(Complaint(phone(face + "merge_into = \"stage.anna\"\nexpressions = \"vrm\"\n")), "");
  EXPECT_EQ(Complaint(phone(face)), "") << "the only performer's";
  EXPECT_EQ(Complaint(phone(face + "merge_into = \"*\"\n")), "");
  const std::string alone = "[[source]]\nname = \"phone\"\n" + face;
  EXPECT_THAT(Complaint(alone + "body = \"none\"\n"),
              HasSubstr("source.0.merge_into: no source has performers; add a [[source]]"));
  EXPECT_THAT(Complaint(phone("type = \"vmc\"\nmerge_into = \"*\"\nparts = [\"fingers\"]\n")),
              HasSubstr("source.1.merge_into: \"*\" is for a face alone"));
  const std::string avatar = "[[source]]\nname = \"stage\"\ntype = \"vmc\"\n";
  const std::string named =
      "[[source]]\nname = \"phone\"\n" + face + "merge_into = \"stage.anna\"\n";
  EXPECT_THAT(Complaint(avatar + named),
              HasSubstr("source.1.merge_into: \"stage.anna\"; the performer of source \"stage\" is "
                        "\"stage.stage\", because type \"vmc\" sends no name; expected that, or "
                        "performer = \"anna\" there"));
  EXPECT_EQ(Complaint(avatar + "performer = \"anna\"\n" + named), "");
  EXPECT_EQ(Complaint(avatar + rig + named), "") << "another source of that name sends names";
  for (const auto* const into : {"anna", "stage.", "stage.a b", "phone.anna", "nobody.anna"}) {
    EXPECT_THAT(Complaint(phone(face + "merge_into = \"" + into + "\"\n")),
                HasSubstr("expected a performer of another source, SOURCE.NAME"))
        << into;
  }
  EXPECT_THAT(Complaint(phone("type = \"mvn\"\nmerge_into = \"stage.anna\"\n")),
              HasSubstr("source.1.parts: missing; a source of type \"mvn\" has no face, expected "
                        "[\"fingers\"]"));
  EXPECT_THAT(Complaint(phone(face + "merge_into = \"stage.anna\"\nexpressions = \"fbx\"\n")),
              HasSubstr("source.expressions: expected one of"));
  const std::string asked = "type = \"ifacialmocap\"\nmerge_into = \"stage.anna\"\n";
  EXPECT_EQ(Complaint(phone(asked + "server = \"192.168.1.20\"\n")), "");
  EXPECT_EQ(Complaint(phone(asked)), "");
  EXPECT_THAT(Complaint(phone(asked + "server = \"phone\"\n")),
              HasSubstr("source.1.server: \"phone\"; expected the phone's IPv4 address"));
  EXPECT_THAT(Complaint(phone(asked + "listen = \"127.0.0.1:49983\"\nserver = \"127.0.0.1\"\n")),
              HasSubstr("is the source's own address"));
  EXPECT_THAT(Complaint(rig + "smooth_hz = 0.01\n"), HasSubstr("expected 0, or 0.1 to 60 Hz"));
}

TEST_F(ConfigTest, AKeyThatATypeDoesNotUseIsRefused) {
  const auto source = [](const std::string& type, const std::string& key) {
    return "[[source]]\nname = \"a\"\ntype = \"" + type + "\"\nlisten = \"127.0.0.1:0\"\n" + key +
           "\n";
  };
  EXPECT_THAT(Complaint(source("udp", "server = \"192.168.1.20\"")),
              HasSubstr("source.0.server: a source of type \"udp\" does not use it; only types "
                        "ifacialmocap, natnet, qtm do"));
  EXPECT_THAT(
      Complaint(source("vmc", "expressions = \"vrm\"")),
      HasSubstr("source.0.expressions: a source of type \"vmc\" does not use it; only types "
                "ifacialmocap, livelinkface, rokoko do"));
  EXPECT_EQ(Complaint(source("rokoko", "expressions = \"vrm\"")), "");
}

TEST_F(ConfigTest, PartsAreOfATypeThatHasThem) {
  const std::string rig =
      "[[source]]\nname = \"stage\"\ntype = \"udp\"\nlisten = \"127.0.0.1:0\"\n";
  const auto gloves = [&rig](const std::string& type, const std::string& parts) {
    return rig + "[[source]]\nname = \"gloves\"\nmerge_into = \"stage.anna\"\ntype = \"" + type +
           "\"\nparts = " + parts + "\n";
  };
  for (const auto* const type : {"vmc", "rokoko"}) {
    EXPECT_EQ(Complaint(gloves(type, "[\"fingers\", \"face\"]")), "") << type;
  }
  EXPECT_EQ(Complaint(gloves("mvn", "[\"leftFingers\"]")), "");
  EXPECT_EQ(Complaint(gloves("usb", "[\"fingers\"]\nusb_id = \"1209:7690\"")), "");
  EXPECT_THAT(
      Complaint(gloves("mvn", "[\"fingers\", \"face\"]")),
      HasSubstr("source.1.parts: \"face\": a source of type \"mvn\" has none; expected one of "
                "udp, tcp, usb, ifacialmocap, livelinkface, rokoko, vmc"));
  EXPECT_THAT(Complaint(gloves("livelinkface", "[\"fingers\"]")),
              HasSubstr("source.1.parts: \"fingers\": a source of type \"livelinkface\" has none"));
  for (const auto* const parts : {"[\"toes\"]", "\"fingers\"", "[3]"}) {
    EXPECT_THAT(Complaint(gloves("vmc", parts)),
                HasSubstr("a list of \"face\", \"fingers\", \"leftFingers\", \"rightFingers\""))
        << parts;
  }
  EXPECT_THAT(Complaint(rig + "parts = [\"fingers\"]\n"),
              HasSubstr("source.0.parts: only for a source with merge_into"));
}

TEST_F(ConfigTest, AMissingInterfaceCausesAWarning) {
  Config config;
  config.sources.resize(4);
  config.sources[0].interface = "127.0.0.1";
  config.sources[1].interface = "no-such-if0";
  config.sources[2].interface = "192.0.2.77";  // of documents alone (RFC 5737)
  const auto warnings = MissingInterfaces(config);
  ASSERT_EQ(warnings.size(), 2U);
  EXPECT_TRUE(warnings[0].starts_with("source.1.interface: \"no-such-if0\"")) << warnings[0];
  EXPECT_TRUE(warnings[1].starts_with("source.2.interface: \"192.0.2.77\"")) << warnings[1];
  config.sources[1].interface = "lo";
  config.sources[2].interface.clear();
  EXPECT_TRUE(MissingInterfaces(config).empty());
}

TEST_F(ConfigTest, ARecordingsFolderIsRefusedWhereItCannotBeMade) {
  support::WriteText(folder_ / "file", "in the way");
  const auto check = [&](const char* file) { return CheckRecordFolder(folder_ / file); };
  EXPECT_TRUE(CheckRecordFolder("").ok());
  EXPECT_TRUE(check("").ok());
  EXPECT_TRUE(check("%F.styrec").ok());
  EXPECT_TRUE(check("new/folder/%F.styrec").ok());
  EXPECT_FALSE(std::filesystem::exists(folder_ / "new")) << "it was only looked at";
  const Status status = check("file/more/%F.styrec");
  EXPECT_FALSE(status.ok());
  EXPECT_NE(status.message().find("/file: is not a folder"), std::string::npos) << status.message();
  if (geteuid() != 0) {  // whom nothing is refused
    std::filesystem::permissions(folder_.path(), std::filesystem::perms::owner_read);
    EXPECT_FALSE(check("new/%F.styrec").ok());
    std::filesystem::permissions(folder_.path(), std::filesystem::perms::owner_all);
  }
}

}  // namespace
}  // namespace styled::config
