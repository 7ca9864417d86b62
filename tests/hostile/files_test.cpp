// Each file that the daemon reads is replaced by what is none: cut, damaged, repeated, nested,
// huge. The daemon ends with an error, or starts without it; it does not crash, and neither takes
// long nor much memory nor says much.
#include <fcntl.h>
#include <gtest/gtest.h>
#include <spawn.h>
#include <sys/resource.h>
#include <sys/wait.h>

#include <filesystem>
#include <fstream>
#include <functional>
#include <random>

#include "sim/player/performer_motion.h"
#include "tests/e2e/examples.h"
#include "tests/hostile/attacks.h"
#include "tests/hostile/stage.h"

namespace styled::hostile {
namespace {

constexpr std::size_t kHuge = std::size_t{8} << 20U;
constexpr std::int64_t kSlack = std::int64_t{64} << 20;
constexpr double kMost_s = 10;  // on a machine that runs other tests
constexpr std::size_t kMostSaid = 16'384;

struct Ended {
  int code = -1;
  double seconds = 0;
  std::int64_t memory = 0;  // peak, bytes
  std::string said;
};

Ended RunToEnd(const std::vector<std::string>& arguments, const std::string& log) {
  std::vector<char*> argv;
  for (const auto& argument : arguments) argv.push_back(const_cast<char*>(argument.c_str()));
  argv.push_back(nullptr);
  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  posix_spawn_file_actions_addopen(&actions, 1, log.c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0600);
  posix_spawn_file_actions_adddup2(&actions, 1, 2);
  const auto begin = Clock::now();
  pid_t pid = 0;
  EXPECT_EQ(posix_spawn(&pid, argv[0], &actions, nullptr, argv.data(), environ), 0);
  posix_spawn_file_actions_destroy(&actions);
  int status = 0;
  rusage usage{};
  EXPECT_EQ(wait4(pid, &status, 0, &usage), pid);
  Ended ended;
  ended.seconds = std::chrono::duration<double>(Clock::now() - begin).count();
  ended.memory = std::int64_t{usage.ru_maxrss} * 1024;
  ended.code = WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
  ended.said = support::ReadText(log);
  return ended;
}

// A file of the daemon's: its name in the test's folder, a true content, and how it is read.
struct FileFormat {
  std::string name;
  std::function<std::string(const support::TemporaryFolder&)> valid;
  std::function<std::vector<std::string>(const support::TemporaryFolder&)> arguments;
};
inline void PrintTo(const FileFormat& format, std::ostream* out) { *out << format.name; }

std::vector<std::string> Check(const support::TemporaryFolder& folder) {
  return {support::Binary(), "--check-config", folder / "config.toml", "--weights",
          folder / "weights.safetensors"};
}

std::string Config(const support::TemporaryFolder& folder, const std::string& more = "") {
  return "[style]\nlibrary = \"" + (folder / "library") +
         "\"\n[[source]]\nname = \"rig\"\ntype = \"udp\"\nlisten = \"127.0.0.1:0\"\n" + more;
}

std::string Weights(const support::TemporaryFolder& folder) {
  const std::string file = folder / "valid.safetensors";
  support::CausalWeights(file);
  return support::ReadText(file);
}

std::string OutputTable(const support::TemporaryFolder& folder, const std::string& file) {
  return "[[output]]\nname = \"hero\"\navatar = \"" + (folder / file) + "\"\n";
}

std::vector<FileFormat> Formats() {
  return {
      {"config.toml", [](const auto& folder) { return Config(folder); }, Check},
      {"weights.safetensors", Weights, Check},
      {"library/mine.json",
       [](const auto&) {
         return std::string(
             R"({"format":"styled style 1","name":"mine","weights":"x","code":[0,1]})");
       },
       Check},
      {"hero.bvh", [](const auto&) { return support::WalkBvh(30, 1); }, Check},
      {"hero.glb",
       [](const auto&) { return Glb(R"({"asset":{"version":"2.0"},"nodes":[{"name":"Hips"}]})"); },
       Check},
      {"take.styrec",
       [](const auto&) {
         return support::ReadText(STYLED_SOURCE_DIR "/tests/golden/recordings/vmc.styrec");
       },
       [](const auto& folder) {
         return std::vector<std::string>{
             support::Binary(),       "--replay",  folder / "take.styrec",        "--replay-to",
             folder / "again.styrec", "--weights", folder / "weights.safetensors"};
       }},
  };
}

std::string UpTo(std::size_t bytes, const std::string& text) {
  std::string all;
  while (all.size() + text.size() <= bytes) all += text;
  return all;
}

// The content in place of a valid file, with a word for it. Made when it is written: the peak
// memory reported for a child process is at least that of its parent.
struct Content {
  std::string word;
  std::function<std::string()> make;
};

std::vector<Content> Contents(const std::string& valid) {
  std::vector<Content> contents{
      {"nothing", [] { return std::string(); }},
      {"a byte", [] { return std::string("\xFF"); }},
      {"zeros", [] { return std::string(kHuge, '\0'); }},
      {"letters", [] { return std::string(kHuge, 'x'); }},
      {"brackets", [] { return std::string(kHuge, '['); }},
      {"braces", [] { return UpTo(kHuge, "{\"a\":"); }},
      {"dots", [] { return "a" + UpTo(kHuge, ".a") + " = 1"; }},
      {"lines", [] { return UpTo(kHuge, "a\n"); }},
      {"tables", [] { return UpTo(kHuge, "[[a]]\n"); }},
      {"again and again", [&valid] { return UpTo(std::min(kHuge, 50 * valid.size()), valid); }},
  };
  for (const std::size_t quarter : {1U, 2U, 3U}) {
    contents.push_back(
        {"cut", [&valid, quarter] { return valid.substr(0, valid.size() * quarter / 4); }});
  }
  for (unsigned seed = 0; seed < 4; ++seed) {
    contents.push_back({"damaged " + std::to_string(seed), [&valid, seed] {
                          std::mt19937 random(seed);
                          std::string damaged = valid;
                          for (int i = 0; i < 8; ++i) {
                            damaged[random() % damaged.size()] ^=
                                static_cast<char>(1U << random() % 8);
                          }
                          return damaged;
                        }});
  }
  return contents;
}

class FileTest : public testing::TestWithParam<FileFormat> {};

TEST_P(FileTest, HarmsNobody) {
  const FileFormat& format = GetParam();
  const support::TemporaryFolder folder;
  std::filesystem::create_directory(folder / "library");
  const auto put = [&folder](const std::string& name, const std::string& text) {
    std::ofstream(folder / name, std::ios::binary) << text;
  };
  put("weights.safetensors", Weights(folder));
  const bool output = format.name.starts_with("hero.");
  put("config.toml", Config(folder, output ? OutputTable(folder, format.name) : ""));
  const std::string valid = format.valid(folder);
  ASSERT_FALSE(valid.empty());
  put(format.name, valid);
  const Ended sane = RunToEnd(format.arguments(folder), folder / "log");
  for (const Content& content : Contents(valid)) {
    SCOPED_TRACE(format.name + ": " + content.word);
    put(format.name, content.make());
    const auto bytes = static_cast<std::int64_t>(std::filesystem::file_size(folder / format.name));
    const Ended ended = RunToEnd(format.arguments(folder), folder / "log");
    EXPECT_LT(ended.code, 128) << "killed by a signal: " << ended.said;
    EXPECT_LT(ended.seconds, kMost_s);
    EXPECT_LE(ended.memory, sane.memory + 8 * bytes + kSlack);
    EXPECT_LE(ended.said.size(), kMostSaid);
    EXPECT_FALSE(ended.said.empty()) << "an error, or that all is well";
    EXPECT_EQ(ended.said.find('\x1B'), std::string::npos) << "control characters reach a terminal";
  }
}

INSTANTIATE_TEST_SUITE_P(All, FileTest, testing::ValuesIn(Formats()), [](const auto& row) {
  std::string name = row.param.name;
  for (char& c : name) {
    if (std::isalnum(static_cast<unsigned char>(c)) == 0) c = '_';
  }
  return name;
});

}  // namespace
}  // namespace styled::hostile
