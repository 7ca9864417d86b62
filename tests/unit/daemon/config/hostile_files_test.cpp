// Whatever is in the place of a file that the daemon reads: an error, in time, and nothing else.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/un.h>
#include <toml++/toml.h>
#include <unistd.h>

#include <random>

#include "daemon/config/config.h"
#include "daemon/looks/state_file.h"
#include "model/base/read_file.h"
#include "model/base/text.h"
#include "model/base/toml_nesting.h"
#include "tests/support/child.h"

namespace styled {
namespace {

using testing::HasSubstr;

std::string Times(int count, const std::string& text) {
  std::string all;
  for (int i = 0; i < count; ++i) all += text;
  return all;
}

std::string Complaint(const std::string& text, const std::vector<config::Override>& set = {}) {
  const auto config = config::Parse(text, "stage.toml", set);
  return config.ok() ? "" : config.status().message();
}

class HostileFilesTest : public testing::Test {
 protected:
  // Invalid files, and the messages about them.
  std::vector<std::pair<std::string, std::string>> NoFiles() {
    const std::string pipe = folder_ / "pipe", socket_file = folder_ / "socket";
    EXPECT_EQ(mkfifo(pipe.c_str(), 0600), 0);
    sockaddr_un address{};
    address.sun_family = AF_UNIX;
    socket_file.copy(address.sun_path, sizeof address.sun_path - 1);
    socket_ = socket(AF_UNIX, SOCK_DGRAM | SOCK_CLOEXEC, 0);
    EXPECT_EQ(bind(socket_, reinterpret_cast<sockaddr*>(&address), sizeof address), 0);
    const std::string zeros = folder_ / "zeros.toml";
    EXPECT_EQ(symlink("/dev/zero", zeros.c_str()), 0);
    const std::string huge = folder_ / "huge.toml";
    support::WriteText(huge, "");
    EXPECT_EQ(truncate(huge.c_str(), off_t{1} << 40), 0);  // sparse
    return {{folder_.path().string(), ": is a folder; expected a regular file"},
            {pipe, ": is a pipe; expected a regular file"},
            {socket_file, ": is a socket; expected a regular file"},
            {zeros, ": is a device; expected a regular file"},
            {huge, ": larger than the limit of "}};
  }
  ~HostileFilesTest() override { close(socket_); }

  support::TemporaryFolder folder_;
  int socket_ = -1;
};

TEST_F(HostileFilesTest, OnlyARegularFileUpToTheLimitIsRead) {
  for (const auto& [file, said] : NoFiles()) {
    const auto read = ReadFile(file, 1000);
    ASSERT_FALSE(read.ok()) << file;
    EXPECT_THAT(read.status().message(), HasSubstr(file + said));
  }
  EXPECT_THAT(ReadFile(folder_ / "none", 9).status().message(), HasSubstr("No such file"));
  const std::string file = folder_ / "text";
  support::WriteText(file, Times(100000, "x"));
  EXPECT_EQ(ReadFile(file, 100000).value(), Times(100000, "x"));
  EXPECT_THAT(ReadFile(file, 99999).status().message(), HasSubstr("limit of 99999 bytes"));
  support::WriteText(file, "");
  EXPECT_EQ(ReadFile(file, 0).value(), "");
}

// One that grows while it is read says less when it is opened than is read of it, as these do.
TEST_F(HostileFilesTest, AFileLongerThanItsStatedSizeEndsAtTheLimit) {
  const std::string file = "/proc/self/status";
  struct stat about {};
  ASSERT_EQ(stat(file.c_str(), &about), 0);
  ASSERT_EQ(about.st_size, 0);
  EXPECT_THAT(ReadFile(file, 1 << 20).value(), HasSubstr("Name:"));
  EXPECT_THAT(ReadFile(file, 100).status().message(), HasSubstr("limit of 100 bytes"));
}

TEST_F(HostileFilesTest, AConfigurationIsRefusedForIt) {
  for (const auto& [file, said] : NoFiles()) {
    const auto config = config::Load(file, {});
    ASSERT_FALSE(config.ok()) << file;
    EXPECT_THAT(config.status().message(), HasSubstr(file + said));
  }
}

TEST_F(HostileFilesTest, SettingsOfTheLastRunAreLostForItAndNothingElse) {
  for (const auto& [file, said] : NoFiles()) {
    const auto kept = pipeline::ReadProfiles(file);
    ASSERT_FALSE(kept.ok()) << file;
    EXPECT_THAT(kept.status().message(), HasSubstr(file + said));
  }
  const auto deep = pipeline::ParseProfiles("\n" + Times(200000, "a.") + "a = 1", "state.toml");
  ASSERT_FALSE(deep.ok());
  EXPECT_THAT(deep.status().message(), HasSubstr("state.toml:2: nested too deep"));
}

TEST_F(HostileFilesTest, DeepNestingIsRefusedWithItsLine) {
  constexpr int kDeep = 200000;
  const std::string key = Times(kDeep, "a.") + "a";
  for (const std::string& text :
       {key + " = 1", "[" + key + "]", "[[" + key + "]]", Times(kDeep, "a . ") + "a=1",
        Times(kDeep, "\"a\".") + "a=1", Times(kDeep, "'a\\'.") + "a=1", "x = {" + key + " = 1}",
        "x = " + Times(kDeep, "[") + Times(kDeep, "]"),
        "x = " + Times(kDeep, "{a=") + "1" + Times(kDeep, "}"),
        // 250 brackets are what toml++ itself allows.
        "x = " + Times(250, "{" + Times(400, "a.") + "a=") + "1" + Times(250, "}"),
        "x = \"\\\"\"\n" + key + " = '\"'", "x = \"\"\"\"\"\"\n" + key + " = 1"}) {
    const std::string line = text.starts_with("x = \"") ? "3" : "2";
    EXPECT_EQ(Complaint("# show\n" + text), "stage.toml:" + line + ": " + TooDeepToml());
  }
  EXPECT_THAT(Complaint("", {{"publish.address", "{" + key + "=1}", "--set publish.address"}}),
              HasSubstr("--set publish.address: nested too deep"));
}

TEST_F(HostileFilesTest, BracketsInStringsAndCommentsAreNotDepth) {
  const std::string dots = Times(1000, "."), brackets = Times(1000, "[{");
  for (const std::string& text :
       {"# " + dots + brackets, "file = \"" + dots + brackets + "\"",
        "file = '" + dots + brackets + "' # " + dots,
        "file = \"\"\"a\"\"" + dots + "\n\\\"\"\"" + brackets + "\"\"\"\"\"",
        "file = '''a''" + dots + "\n" + brackets + "'''''"}) {
    EXPECT_EQ(Complaint("[record]\n" + text + "\n"), "") << text.substr(0, 20);
  }
  EXPECT_FALSE(FindTooDeepToml("x = [" + Times(1000, "0.1, ") + "]"));
  EXPECT_FALSE(FindTooDeepToml("x = [\n" + Times(1000, "0.1,\n") + "]"));
  EXPECT_FALSE(FindTooDeepToml(Times(1000, "a.b.c = [[1.5]]\n")));
}

// The deepest texts that pass are parsed, walked, printed and freed on a stack of 256 KiB, a
// thirtieth of a thread's usual one.
TEST_F(HostileFilesTest, AcceptedTextIsNotDeepForToml) {
  std::string array = "[[a]]\n", path = "a";
  for (int i = 0; i < kMaxTomlNesting; ++i) {
    path += ".a";
    array += "[[" + path + "]]\n";
  }
  const std::string key = Times(kMaxTomlNesting, "a.") + "a";
  static std::string text;
  text = array + key + " = " + Times(kMaxTomlNesting, "{" + key + " = ") + "1" +
         Times(kMaxTomlNesting, "}");
  ASSERT_FALSE(FindTooDeepToml(text));
  static std::string said;
  const auto body = +[](void*) -> void* {
    said = Complaint(text);
    return nullptr;
  };
#if defined(__SANITIZE_ADDRESS__)
  constexpr std::size_t kStack = 4 << 20;  // its frames are larger
#else
  constexpr std::size_t kStack = 256 << 10;
#endif
  pthread_attr_t attributes;
  pthread_attr_init(&attributes);
  ASSERT_EQ(pthread_attr_setstacksize(&attributes, kStack), 0);
  pthread_t thread{};
  ASSERT_EQ(pthread_create(&thread, &attributes, body, nullptr), 0);
  pthread_join(thread, nullptr);
  pthread_attr_destroy(&attributes);
  EXPECT_EQ(said, "stage.toml:1: a: unknown section");
}

int DepthOf(const toml::node& node) {
  int deepest = 0;
  if (const toml::table* table = node.as_table()) {
    for (const auto& [key, value] : *table) deepest = std::max(deepest, DepthOf(value));
  } else if (const toml::array* array = node.as_array()) {
    for (const auto& value : *array) deepest = std::max(deepest, DepthOf(value));
  } else {
    return 0;
  }
  return deepest + 1;
}

// toml++ is the judge: no text that it parses may be deeper than the stated limit. The pieces are
// those at which two readers of TOML could disagree about where a string or a comment ends.
TEST_F(HostileFilesTest, TomlAgreesAboutWhereStringsAndCommentsEnd) {
  const std::string deep = Times(400, "b.") + "b=1";
  const std::vector<std::string> pieces{"\n",        "\n",        "\n",
                                        "\r\n",      "a",         "=",
                                        "= 1\n",     "= '''",     "= \"\"\"",
                                        "\"",        "'",         "''",
                                        "\"\"",      "'''",       "\"\"\"",
                                        "\"\"\"\"",  "\\",        "\\\"",
                                        "\\\\",      "\\\n",      "# ",
                                        "#\"\n",     "# '\n",     "= \"#\"\n",
                                        "= '\"'\n",  "[",         "]",
                                        "{",         "}",         ",",
                                        "\n" + deep, deep + "\n", "= {" + deep + "}\n",
                                        "\xC3\xA9",  "x"};
  std::mt19937 random(7);
  int parsed = 0, deep_ones = 0;
  for (int run = 0; run < 60000; ++run) {
    std::string text = run % 3 == 0 ? "" : "k = ";
    const int count = 1 + static_cast<int>(random() % 12);
    for (int i = 0; i < count; ++i) text += pieces[random() % pieces.size()];
    if (run % 2 == 0) text += "\n" + deep;
    try {
      const toml::table table = toml::parse(text);
      ++parsed;
      if (DepthOf(table) <= 350) continue;
      ++deep_ones;
      EXPECT_TRUE(FindTooDeepToml(text)) << text.substr(0, 300);
    } catch (const toml::parse_error&) {
    }
  }
  EXPECT_GT(parsed, 500) << "the test has something to judge";
  EXPECT_GT(deep_ones, 200);
}

TEST_F(HostileFilesTest, BinaryBytesAreRefusedInText) {
  for (const std::string& text :
       {std::string("[publish]\nx = 1\0", 16), std::string("\0", 1),
        std::string("a = \"\xFF\xFE\""), std::string("\xC3"), std::string("\x7f"),
        std::string("[pub\x1b[31mlish]\n"), std::string("\"\\u001b[31m\\n\" = 1"),
        std::string("[style]\ninitial = \"\\u0007\" 1")}) {
    const std::string said = Complaint(text);
    EXPECT_THAT(said, HasSubstr("stage.toml")) << text;
    EXPECT_EQ(Printable(said, 100000), said) << "nothing of it had to be escaped or replaced";
  }
}

TEST_F(HostileFilesTest, QuotedTextIsCutShort) {
  const std::string much = Times(300000, "m");
  for (const std::string& text :
       {"[" + much + "]", "[publish]\n" + much + " = 1", "[log]\nlevel = \"" + much + "\"",
        "[publish]\naddress = \"" + much + "\"", "[presets]\n" + much + " = { a = 1 }",
        "[presets]\nx = { " + much + " = 9 }", "[[cue]]\nname = \"" + much + "\"",
        "[[source]]\nlisten = \"" + much + "\"", "[[source]]\nlisten='" + much + ":1'",
        "[[source]]\nlisten='127.0.0.1:1'\nname = \"" + much + "\"",
        "[osc]\nlisten = \"" + much + "\"", "a = 1\na = \"" + much + "\""}) {
    const std::string said = Complaint(text);
    EXPECT_NE(said, "");
    EXPECT_LT(said.size(), 1000U) << said.substr(0, 100);
  }
}

// A reload happens beside a show. 20 s are far beyond what any of these takes; the checks that
// compare each entry with each took minutes.
TEST_F(HostileFilesTest, AsManyEntriesAsAFileHoldsAreRefused) {
  std::string presets = "[presets]\n", sources, outputs, cues;
  for (int i = 0; i < 5000; ++i) {
    const std::string number = std::to_string(i);
    presets.append("x").append(number).append("={a=1}\n");
    sources.append("[[source]]\nlisten='127.0.0.1:").append(number).append("'\n");
    outputs.append("[[output]]\nname='x").append(number).append("'\navatar='a'\n");
    cues.append("[[cue]]\nname='x").append(number).append("'\npanic=true\n");
  }
  for (const auto& [text, section] : {std::pair(presets, "presets"), std::pair(sources, "source"),
                                      std::pair(outputs, "output"), std::pair(cues, "cue")}) {
    EXPECT_THAT(Complaint(text), HasSubstr(std::string(section) + ": expected at most 4096"));
  }
}

}  // namespace
}  // namespace styled
