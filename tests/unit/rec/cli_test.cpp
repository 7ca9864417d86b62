#include "clients/rec/cli.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>
#include <nlohmann/json.hpp>
#include <sstream>
#include <thread>

#include "clients/rec/publish_outlet.h"
#include "model/base/terminal_text.h"
#include "model/clip/clip.h"
#include "proto/styled/v1/stats.pb.h"
#include "tests/unit/rec/fakes.h"

namespace styled::rec {
namespace {

using testing::Arrival;
using ::testing::HasSubstr;
using testing::kSecond_ns;
using testing::Published;

class CliTest : public ::testing::Test {
 protected:
  int Run(const std::vector<std::string>& arguments) {
    out_.str("");
    err_.str("");
    return rec::Run(arguments, stop_, out_, err_);
  }
  std::string Write(const std::string& name, const std::vector<recording::Record>& records) const {
    recording::FileHeader header = recording::BeginningNow("test", "1.2");
    header.set_created_unix_ns(1'700'000'000 * kSecond_ns);
    header.set_description("a \x1B[31mred\nfile");
    header.set_weights("v1.safetensors");
    header.set_weights_hash("fnv1a64:0123");
    header.set_config("[publish]\n");
    std::string file = folder_ / name;
    const auto writer = recording::FileWriter::Create(file, header);
    EXPECT_TRUE(writer.ok());
    for (const auto& record : records) EXPECT_TRUE(writer.value()->Add(record, 0).ok());
    EXPECT_TRUE(writer.value()->Flush().ok());
    return file;
  }
  // Half a second at 100 Hz.
  std::vector<recording::Record> Motion() const {
    const auto body = testing::MakeBody("rig.a", styled::v1::OUTPUT_RIG, 5);
    std::vector<recording::Record> records{Published(0, "body/rig.a/", body.SerializeAsString())};
    for (int i = 0; i < 50; ++i) {
      const auto frame = testing::MakeFrame(body, static_cast<std::uint64_t>(i + 1),
                                            static_cast<std::uint64_t>(i) * 10'000'000 + 1);
      for (const char* topic : {"source/rig.a/", "styled/rig.a/rig/"}) {
        records.push_back(Published(i * 10'000'000LL, topic, frame.SerializeAsString()));
      }
    }
    return records;
  }

  testing::TemporaryFolder folder_;
  std::ostringstream out_, err_;
  std::atomic<bool> stop_{false};
};

TEST_F(CliTest, BadCommandLinesEndWithTwoAndSayWhatWasExpected) {
  const auto expect = [&](const std::vector<std::string>& arguments, const std::string& text) {
    EXPECT_EQ(Run(arguments), kExitUsage) << ::testing::PrintToString(arguments);
    EXPECT_THAT(err_.str(), HasSubstr(text));
    EXPECT_THAT(err_.str(), HasSubstr("see stylerec --help"));
  };
  expect({}, "a command is required");
  expect({"rewind"}, "rewind");
  expect({"info"}, "FILE is required");
  expect({"play", "x"}, "play: nothing to play to; expected --to or --publish");
  expect({"export", "x", "--performer", "rig.a"}, "expected --out FILE, of .bvh, .glb");
  expect({"export", "x", "--performer", "rig.a", "--out", "y.fbx"},
         "y.fbx: found extension .fbx, expected one of .bvh, .glb");
  expect({"export", "x", "--glb", "y"}, "--performer is required");
  expect({"export", "x", "--performer", "rig.a", "--glb", "y", "--what", "a/b"}, "a/b");
  expect({"export", "x", "--performer", "rig.a", "--glb", "y", "--rate", "0"}, "--rate");
  expect({"record", "--performer", "anna", "x"}, "'anna' is not SOURCE.NAME");
  expect({"record", "--performer", "rig.a", "--topics", "stats/", "x"}, "excludes");
  expect({"record", "--seconds", "nan", "x"}, "nan");
  expect({"receive", "x"}, "--listen is required");
  expect({"receive", "--listen", "udp://127.0.0.1:0", "--forward", "a:1,b:2", "x"},
         "found 2 addresses in --forward");
}

TEST_F(CliTest, AnImpossiblePlayEndsWithTwoAndSendsNothing) {
  testing::Listener listener;
  const std::string published = Write("published", Motion());
  const std::string arrived =
      Write("arrived", {Arrival(0, "12345", "suit"), Arrival(1000, "12345", "glove")});
  const auto expect = [&](const std::string& file, std::vector<std::string> arguments,
                          const std::string& text) {
    arguments.insert(arguments.begin(), {"play", file});
    EXPECT_EQ(Run(arguments), kExitUsage) << ::testing::PrintToString(arguments);
    EXPECT_THAT(err_.str(), HasSubstr(text));
  };
  expect(published, {"--to", "ftp://x"}, "ftp://x");
  expect(published, {"--to", listener.url(), "--to", "udp://127.0.0.1:8"},
         "expected one address per source");
  expect(published, {"--to", "original"}, "has no arrivals");
  expect(published, {"--to", "zz=" + listener.url()}, "has no source of that name; it has: rig\n");
  expect(arrived, {"--to", listener.url(), "--to", "zz=" + listener.url()},
         "--to zz=...: " + arrived + " has no source of that name; it has: glove, suit\n");
  for (const char* speed : {"0", "-1", "fast", "nan", "1e9", ""}) {
    expect(published, {"--to", listener.url(), "--speed", speed}, "--speed");
  }
  for (const char* url :
       {"tcp://nowhere", "tcp://:7001", "tcp://a:b", "tcp://a:70000", "x", "ipc://"}) {
    expect(published, {"--publish", url}, std::string("--publish ") + url);
  }
  EXPECT_EQ(listener.Receive(0), "none");
  EXPECT_EQ(Run({"play", arrived, "--to", "suit=" + listener.url()}), kExitOk) << err_.str();
  EXPECT_EQ(listener.Receive(), "12345");
}

TEST_F(CliTest, HelpAndVersionAreNoErrors) {
  EXPECT_EQ(Run({"--help"}), kExitOk);
  EXPECT_THAT(out_.str(), HasSubstr("stylerec play"));
  EXPECT_EQ(Run({"play", "--help"}), kExitOk);
  EXPECT_EQ(Run({"--version"}), kExitOk);
  EXPECT_THAT(out_.str(), HasSubstr("stylerec "));
}

TEST_F(CliTest, FilesAndAddressesThatAreWrongEndWithOneAndTheirName) {
  const auto expect = [&](const std::vector<std::string>& arguments, const std::string& text) {
    EXPECT_EQ(Run(arguments), kExitFailed) << ::testing::PrintToString(arguments);
    EXPECT_THAT(err_.str(), HasSubstr(text));
  };
  const std::string motion = Write("motion", Motion());
  const std::string none = folder_ / "none";
  for (const char* command : {"info", "play", "export"}) {
    std::vector<std::string> arguments{command, none};
    if (arguments[0] == "play") arguments.insert(arguments.end(), {"--to", "udp://127.0.0.1:9"});
    if (arguments[0] == "export") {
      arguments.insert(arguments.end(), {"--performer", "rig.a", "--glb", none});
    }
    expect(arguments, none + ": cannot be read");
  }
  expect({"record", motion}, motion + ": exists already");
  expect({"record", "--from", "nonsense", none}, "--from nonsense");
  expect({"record", "--config", none, folder_ / "a"}, none + ": cannot be read");
  expect({"record", "--weights", none, folder_ / "a"}, none + ": cannot be read");
  expect({"receive", "--listen", "tcp://127.0.0.1:0", folder_ / "a"}, "udp://HOST:PORT");
  expect({"play", motion, "--to", "udp://127.0.0.1:9", "--from", "3"}, "expected --from within");
  expect({"play", motion, "--publish", "tcp://192.0.2.1:7001"}, "--publish tcp://192.0.2.1:7001");
  expect({"play", motion, "--publish", "tcp://127.0.0.1:*", "--wait", "0.05"},
         "found no subscriber");
  expect({"export", motion, "--performer", "rig.b", "--glb", none}, "source/rig.a/");
  expect({"export", motion, "--performer", "rig.a", "--glb", "/nonexistent/x.glb"},
         "/nonexistent/x.glb");
  const std::string note = Write("note", {recording::Record()});
  expect({"play", note, "--to", "udp://127.0.0.1:9"}, "found neither arrivals nor");
}

TEST_F(CliTest, InfoSaysWhichCueAndWhatElseWasAsked) {
  const auto said = [this](auto&& ask) {
    recording::Record record;
    record.set_time_ns(kSecond_ns);
    v1::Request& request = *record.mutable_command()->mutable_request();
    request.set_performer("rig.a");
    ask(request);
    std::filesystem::remove(folder_ / "asked");
    EXPECT_EQ(Run({"info", Write("asked", {record})}), kExitOk) << err_.str();
    const std::string text = out_.str(), head = "command at 0.000 s: ";
    const std::size_t at = text.find(head);
    if (at == std::string::npos) return text;
    return text.substr(at + head.size(), text.find('\n', at) - at - head.size());
  };
  using R = v1::Request;
  EXPECT_EQ(said([](R& r) { r.mutable_cue()->set_name("storm"); }), "rig.a cue storm");
  EXPECT_EQ(said([](R& r) { r.mutable_like()->set_name("pirate"); }), "rig.a like pirate");
  EXPECT_EQ(said([](R& r) { r.mutable_calibrate(); }), "rig.a calibrate t");
  EXPECT_EQ(said([](R& r) { r.mutable_calibrate()->set_clear(true); }), "rig.a calibrate clear");
  EXPECT_EQ(said([](R& r) { r.mutable_remove_style()->set_name("old"); }),
            "rig.a remove style old");
  EXPECT_EQ(said([](R& r) {
              r.mutable_rename_style()->set_name("a");
              r.mutable_rename_style()->set_to("b");
            }),
            "rig.a rename style a to b");
}

TEST_F(CliTest, InfoSaysWhatIsInAFile) {
  std::vector<recording::Record> records = Motion();
  for (int i = 0; i < 3; ++i) records.push_back(Arrival(i * kSecond_ns, "12345", "suit"));
  recording::Record command;
  command.set_time_ns(kSecond_ns);
  auto& request = *command.mutable_command()->mutable_request();
  request.set_performer("rig.a");
  request.mutable_set()->add_mix()->set_style("old");
  request.mutable_set()->mutable_mix(0)->set_weight(0.5F);
  auto& applied = *command.mutable_command()->add_applied();
  applied.set_performer("rig.a");
  applied.set_first_sequence(42);
  records.push_back(command);
  const std::string file = Write("x", records);
  ASSERT_EQ(Run({"info", file}), kExitOk) << err_.str();
  for (const char* text :
       {"2.000 s, 105 records", "begun 2023-11-14 22:13:20 UTC by test 1.2",
        "description: a \\x1b[31mred\\nfile\n", "weights: v1.safetensors fnv1a64:0123",
        "arrivals: suit (udp, at ) 3 datagrams, 15 bytes, 1.00/s, 1 senders",
        "published: source/rig.a/ 50 messages",
        "command at 1.000 s: rig.a set old=0.5 [rig.a from 42]"}) {
    EXPECT_THAT(out_.str(), HasSubstr(text));
  }
  EXPECT_THAT(out_.str(), ::testing::Not(HasSubstr("damage")));
  ASSERT_EQ(Run({"info", file, "--json"}), kExitOk);
  const auto json = nlohmann::json::parse(out_.str());
  EXPECT_EQ(json["records"], 105);
  EXPECT_EQ(json["arrivals"][0]["datagrams"], 3);
  EXPECT_EQ(json["config"], "[publish]\n");
  EXPECT_EQ(json["commands"][0]["text"], "rig.a set old=0.5 [rig.a from 42]");
  EXPECT_EQ(json["skipped_bytes"], 0);
}

TEST_F(CliTest, NothingInARecordingReachesTheTerminalUnescaped) {
  // Escape, the CSI of C1, a change of direction, a line separator.
  const std::string hostile = "a\x1b]0;x\x07\xc2\x9b2J\xe2\x80\xae\xe2\x80\xa8\r\n";
  std::vector<recording::Record> records{Arrival(0, "12345", hostile),
                                         Published(1, "styled/" + hostile + "/rig/", "x")};
  records[0].mutable_arrival()->set_type(hostile);
  records[0].mutable_arrival()->set_listen(hostile);
  records.emplace_back().mutable_note()->set_text("ok");
  recording::Record command;
  command.mutable_command()->mutable_request()->set_performer("\x1b[2J\xc2\x9b");
  records.push_back(command);
  const std::string file = Write("x", records);
  for (const std::vector<std::string>& arguments :
       {std::vector<std::string>{"info", file},
        {"info", file, "--json"},
        {"export", file, "--performer", "rig.b", "--glb", file + ".glb"}}) {
    (void)Run(arguments);
    const std::string said = out_.str() + err_.str();
    EXPECT_THAT(said, HasSubstr("rig")) << arguments[0];
    EXPECT_EQ(said, ForTerminal(said)) << arguments[0];
  }
}

TEST_F(CliTest, DamageIsSaidAndIsNoErrorAndAFileWithoutItsBeginningIsSalvaged) {
  const std::string file = Write("x", Motion());
  std::filesystem::resize_file(file, std::filesystem::file_size(file) - 5);
  ASSERT_EQ(Run({"info", file}), kExitOk);
  EXPECT_THAT(out_.str(), HasSubstr("damage: the last block is cut short"));
  {
    std::fstream stream(file, std::ios::in | std::ios::out | std::ios::binary);
    stream.put('x');
  }
  EXPECT_EQ(Run({"info", file}), kExitFailed);
  EXPECT_THAT(err_.str(), HasSubstr("offset 0: found 78 53"));
  EXPECT_EQ(Run({"info", file, "--salvage"}), kExitOk);
}

TEST_F(CliTest, ARecordingOfNothingIsSaidWhileItIsMadeAndAtItsEnd) {
  const std::string place = "ipc://" + (folder_ / "pub"), file = folder_ / "new";
  EXPECT_EQ(Run({"record", "--from", place, "--seconds", "3.3", file}), kExitOk);
  EXPECT_THAT(err_.str(), HasSubstr("nothing has arrived from " + place +
                                    " for 3 s; is styled running there?\n"));
  EXPECT_THAT(err_.str(), HasSubstr(file + " is empty: nothing arrived\n"));
}

// A daemon of which only the statistics come, and rig.b.
TEST_F(CliTest, APerformerWhoIsNotThereIsSaidWithThoseWhoAre) {
  const std::string place = "ipc://" + (folder_ / "pub");
  styled::v1::Stats stats;
  stats.add_performers()->set_performer("rig.b");
  stats.add_performers()->set_performer("rig.a");
  const auto daemon = PublishOutlet::Bind(place, true);
  ASSERT_TRUE(daemon.ok()) << daemon.status().message();
  const std::jthread thread([&](const std::stop_token& token) {
    while (!token.stop_requested()) {
      daemon.value()->Idle();
      EXPECT_TRUE(daemon.value()->Play(Published(0, "stats/", stats.SerializeAsString())).ok());
      EXPECT_TRUE(daemon.value()->Play(Published(0, "body/rig.b/", "body")).ok());
      std::this_thread::sleep_for(std::chrono::milliseconds(20));
    }
  });
  const auto record = [&](const std::string& id, const char* seconds) {
    return Run({"record", "--from", place, "--performer", id, "--seconds", seconds, folder_ / id});
  };
  EXPECT_EQ(record("rig.zz", "4"), kExitOk);
  EXPECT_THAT(err_.str(), HasSubstr("nothing of rig.zz has arrived from " + place +
                                    " for 3 s; there are rig.a, rig.b\n"));
  EXPECT_THAT(err_.str(), HasSubstr("has nothing of rig.zz, only statistics; there are"));
  EXPECT_EQ(record("rig.b", "4"), kExitOk);
  EXPECT_EQ(err_.str(), "stylerec: recording\n");
}

TEST_F(CliTest, PlayingEndsWithASummary) {
  const testing::Listener listener;
  const std::string file = Write("x", Motion());
  ASSERT_EQ(Run({"play", file, "--to", listener.url(), "--speed", "max"}), kExitOk) << err_.str();
  EXPECT_THAT(out_.str(), HasSubstr(file + ": records=101 passes=1 seconds=0.49"));
  EXPECT_THAT(out_.str(), HasSubstr("datagrams=51 elsewhere=0"));
  ASSERT_EQ(Run({"play", file, "--to", listener.url(), "--speed", "max", "--from", "0.2",
                 "--to-time", "0.3"}),
            kExitOk);
  EXPECT_THAT(out_.str(), HasSubstr("records=22 passes=1 seconds=0.1"));
  EXPECT_THAT(out_.str(), HasSubstr("datagrams=12"));
}

TEST_F(CliTest, AStopBeforeItBeganIsAnOrderlyEnd) {
  stop_ = true;
  const testing::Listener listener;
  EXPECT_EQ(Run({"play", Write("x", Motion()), "--to", listener.url(), "--loop"}), kExitOk);
  EXPECT_THAT(out_.str(), HasSubstr("records=0"));
  EXPECT_EQ(Run({"record", folder_ / "new"}), kExitOk) << err_.str();
  EXPECT_THAT(out_.str(), HasSubstr("messages=0 missed=0"));
  EXPECT_EQ(Run({"info", folder_ / "new"}), kExitOk);
  EXPECT_EQ(Run({"receive", "--listen", "rig=udp://127.0.0.1:0", folder_ / "other"}), kExitOk);
  EXPECT_THAT(err_.str(), HasSubstr("listening on udp://127.0.0.1:"));
}

TEST_F(CliTest, AnOutputIsExportedByItsName) {
  std::vector<recording::Record> records = Motion();
  auto body = testing::MakeBody("rig.a", styled::v1::OUTPUT_AVATAR, 6);
  body.set_output_name("hero");
  // Another output's body comes under the same topic, and is not taken for it.
  auto other = body;
  other.set_output_name("zero");
  other.set_hash(7);
  for (const auto& one : {body, other}) {
    records.push_back(Published(0, "body/rig.a/", one.SerializeAsString()));
  }
  for (std::uint64_t i = 0; i < 30; ++i) {
    const auto frame = testing::MakeFrame(body, i + 1, i * 10'000'000 + 1);
    records.push_back(Published(0, "styled/rig.a/hero/", frame.SerializeAsString()));
  }
  const std::string file = Write("x", records), glb = folder_ / "hero.glb";
  const auto run = [&](const char* what) {
    return Run({"export", file, "--performer", "rig.a", "--what", what, "--glb", glb});
  };
  EXPECT_EQ(run("feet"), kExitFailed);
  EXPECT_THAT(err_.str(), HasSubstr("found no frames of styled/rig.a/feet/; it holds: "
                                    "source/rig.a/, styled/rig.a/hero/, styled/rig.a/rig/"));
  EXPECT_EQ(run("hero"), kExitOk) << err_.str();
  EXPECT_THAT(out_.str(), HasSubstr("rig.a hero: frames=30 "));
}

TEST_F(CliTest, AnExportIsReadBackAsItWasRecorded) {
  const std::string file = Write("x", Motion()), bvh = folder_ / "x.bvh", glb = folder_ / "x.glb";
  ASSERT_EQ(Run({"export", file, "--performer", "rig.a", "--bvh", bvh, "--glb", glb}), kExitOk)
      << err_.str();
  EXPECT_THAT(out_.str(), HasSubstr("rig.a rig: frames=50 seconds=0.49 joints=21"));
  const auto clip = clip::ReadBvh(bvh);
  ASSERT_TRUE(clip.ok()) << clip.status().message();
  EXPECT_EQ(clip.value().rate_hz, 100);
  ASSERT_EQ(clip.value().frames.size(), 50U);
  for (int i = 0; i < 50; ++i) {
    EXPECT_EQ(clip.value().frames[static_cast<std::size_t>(i)].translations[0].y(), i + 1);
  }
  EXPECT_GT(std::filesystem::file_size(glb), 10'000U);
  ASSERT_EQ(Run({"export", file, "--performer", "rig.a", "--bvh", bvh, "--rate", "25"}),
            kExitFailed);
  EXPECT_THAT(err_.str(), HasSubstr(bvh + ": exists already; expected a new file, or --overwrite"));
  EXPECT_EQ(clip::ReadBvh(bvh).value().frames.size(), 50U) << "left as it was";
  ASSERT_EQ(
      Run({"export", file, "--performer", "rig.a", "--bvh", bvh, "--rate", "25", "--overwrite"}),
      kExitOk);
  EXPECT_EQ(clip::ReadBvh(bvh).value().frames.size(), 13U);
}

TEST_F(CliTest, AnExportHasTheFormatOfItsFilesExtension) {
  const std::string file = Write("x", Motion());
  const auto run = [&](std::vector<std::string> files) {
    files.insert(files.begin(), {"export", file, "--performer", "rig.a"});
    return Run(files);
  };
  ASSERT_EQ(run({"--bvh", folder_ / "one", "--glb", folder_ / "two"}), kExitOk) << err_.str();
  ASSERT_EQ(run({"--out", folder_ / "x.BVH", "--out", folder_ / "x.glb"}), kExitOk) << err_.str();
  const auto text = [&](const char* name) {
    std::ifstream in(folder_ / name, std::ios::binary);
    return std::string(std::istreambuf_iterator<char>(in), {});
  };
  EXPECT_THAT(text("x.BVH"), HasSubstr("HIERARCHY"));
  EXPECT_EQ(text("x.BVH"), text("one"));
  EXPECT_EQ(text("x.glb").substr(0, 4), "glTF");
  EXPECT_EQ(text("x.glb"), text("two"));
}

recording::Record Decided(std::int64_t time_ns, const v1::FrameFate& fate) {
  recording::Record record;
  record.set_time_ns(time_ns);
  record.mutable_decided()->set_source("rig");
  *record.mutable_decided()->add_frames() = fate;
  return record;
}

TEST_F(CliTest, ExplainSaysWhatTheDaemonMadeOfEachFrame) {
  std::vector<recording::Record> records = Motion();
  for (std::uint64_t i = 1; i <= 20; ++i) {
    v1::FrameFate fate;
    fate.set_performer("rig.a");
    fate.set_source_sequence(i);
    fate.set_fate(i == 7 ? v1::FATE_REFUSED : v1::FATE_STYLED);
    if (i == 7) fate.set_reason("pipeline.duplicate");
    if (i != 7) fate.set_sequence(100 + i);
    if (i == 20) fate.set_flags(v1::FLAG_BYPASS);
    records.push_back(Decided(static_cast<std::int64_t>(i), fate));
  }
  const std::string file = Write("decided.styrec", records);
  ASSERT_EQ(Run({"explain", file, "rig.a"}), kExitOk) << err_.str();
  EXPECT_EQ(
      out_.str(),
      "frames 101 to 106 (6): published.\n"
      "frame 7 of the sender: refused. The frame was refused because the sequence number was "
      "received before: check whether a device on the way sends everything twice, or whether two "
      "senders use one session.\n"
      "frames 108 to 119 (12): published.\n"
      "frame 120: published. No style is set: stylectl set rig.a --style NAME.\n");
  ASSERT_EQ(Run({"explain", file, "rig.a", "110"}), kExitOk) << err_.str();
  EXPECT_EQ(out_.str(), "frame 110: published.\n");
  EXPECT_NE(Run({"explain", file, "rig.a", "7"}), kExitOk);
  EXPECT_THAT(err_.str(), HasSubstr("found no frame of rig.a with number 7"));
  EXPECT_NE(Run({"explain", Write("motion.styrec", Motion()), "rig.a"}), kExitOk);
  EXPECT_THAT(err_.str(), HasSubstr("expected a recording of the daemon ([record])"));
}

}  // namespace
}  // namespace styled::rec
