#include "proto/recording/writer.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <signal.h>
#include <sys/mman.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <atomic>
#include <chrono>
#include <filesystem>
#include <limits>
#include <random>
#include <thread>

#include "proto/recording/reader.h"
#include "tests/support/temporary_folder.h"
#include "tests/unit/recording/samples.h"

namespace styled::recording {
namespace {

using ::testing::HasSubstr;
using testing::MakeRecord;

constexpr std::int64_t kMillisecond_ns = 1'000'000;

class WriterTest : public ::testing::Test {
 protected:
  std::filesystem::path File(const std::string& name = "x.styrec") const { return folder_ / name; }
  static std::vector<Record> ReadAll(const std::filesystem::path& file, ReadCounts* counts) {
    std::vector<Record> records;
    const auto reader = Reader::Open(file);
    EXPECT_TRUE(reader.ok()) << reader.status().message();
    if (!reader.ok()) return records;
    Record record;
    while (reader.value()->Next(record)) records.push_back(record);
    *counts = reader.value()->counts();
    return records;
  }

  support::TemporaryFolder temporary_;
  const std::filesystem::path& folder_ = temporary_.path();
};

TEST_F(WriterTest, AFileThatExistsOrCannotBeMadeIsRefused) {
  ASSERT_TRUE(FileWriter::Create(File(), {}).ok());
  // How people move is not for everybody to read.
  const auto mode = std::filesystem::status(File()).permissions();
  EXPECT_EQ(mode & std::filesystem::perms::others_all, std::filesystem::perms::none);
  EXPECT_EQ(FileWriter::Create(File(), {}).status().message(),
            File().string() + ": exists already; expected the name of a new file");
  EXPECT_THAT(FileWriter::Create(folder_ / "no" / "x", {}).status().message(),
              HasSubstr("cannot be written: No such file or directory"));
}

TEST_F(WriterTest, AFileJustMadeIsARecordingAlready) {
  const auto writer = FileWriter::Create(File(), testing::MakeHeader());
  ASSERT_TRUE(writer.ok());
  const auto reader = Reader::Open(File());
  ASSERT_TRUE(reader.ok()) << reader.status().message();
  EXPECT_EQ(reader.value()->header().program(), "sample");
  Record record;
  EXPECT_FALSE(reader.value()->Next(record));
  EXPECT_EQ(DamageText(reader.value()->counts()), "");
}

TEST_F(WriterTest, ABlockIsWrittenWhenItsFirstRecordHasWaitedTwentyFiveMillisecondsAndNotBefore) {
  auto made = FileWriter::Create(File(), {});
  ASSERT_TRUE(made.ok());
  FileWriter& writer = *made.value();
  const auto begin = std::filesystem::file_size(File());
  EXPECT_EQ(writer.NextDeadline_ns(), std::numeric_limits<std::int64_t>::max());
  ASSERT_TRUE(writer.Add(MakeRecord(0), 1000).ok());
  EXPECT_EQ(writer.NextDeadline_ns(), 1000 + 25 * kMillisecond_ns);
  ASSERT_TRUE(writer.Add(MakeRecord(1), 1000 + 20 * kMillisecond_ns).ok());
  ASSERT_TRUE(writer.Poll(999 + 25 * kMillisecond_ns).ok());
  EXPECT_EQ(std::filesystem::file_size(File()), begin);
  ASSERT_TRUE(writer.Poll(1000 + 25 * kMillisecond_ns).ok());
  EXPECT_GT(std::filesystem::file_size(File()), begin);
  EXPECT_EQ(std::filesystem::file_size(File()), writer.counts().bytes);
  EXPECT_EQ(writer.NextDeadline_ns(), std::numeric_limits<std::int64_t>::max());
}

TEST_F(WriterTest, ABlockIsWrittenWhenItIsFull) {
  auto made = FileWriter::Create(File(), {});
  ASSERT_TRUE(made.ok());
  Record record = MakeRecord(1);
  record.mutable_published()->set_payload(std::string(20'000, 'p'));
  for (int i = 0; i < 3; ++i) ASSERT_TRUE(made.value()->Add(record, 0).ok());
  EXPECT_EQ(made.value()->counts().blocks, 1U) << "the header alone";
  ASSERT_TRUE(made.value()->Add(record, 0).ok());
  EXPECT_EQ(made.value()->counts().blocks, 2U);
}

TEST_F(WriterTest, LargeRecordsAreWrittenAndTooLargeOnesCounted) {
  auto made = FileWriter::Create(File(), {});
  ASSERT_TRUE(made.ok());
  FileWriter& writer = *made.value();
  Record large;
  large.mutable_note()->set_text(std::string(kMaxRecordSize - 16, 'x'));
  ASSERT_TRUE(writer.Add(MakeRecord(0), 0).ok());
  ASSERT_TRUE(writer.Add(large, 0).ok());
  ASSERT_TRUE(writer.Add(large, 0).ok());
  large.mutable_note()->set_text(std::string(kMaxRecordSize, 'x'));
  ASSERT_TRUE(writer.Add(large, 0).ok());
  ASSERT_TRUE(writer.Add(MakeRecord(1), 0).ok());
  ASSERT_TRUE(writer.Flush().ok());
  EXPECT_EQ(writer.counts().records, 4U);
  EXPECT_EQ(writer.counts().too_large, 1U);
  ReadCounts counts;
  EXPECT_EQ(ReadAll(File(), &counts).size(), 4U);
  EXPECT_EQ(DamageText(counts), "");
}

// The limit on a file's size stands in for a full disk: the write that crosses it is cut short.
TEST_F(WriterTest, AFullDiskCostsTheBlocksThatDoNotFitAndLeavesAWholeFile) {
  signal(SIGXFSZ, SIG_IGN);
  rlimit before{};
  getrlimit(RLIMIT_FSIZE, &before);
  auto made = FileWriter::Create(File(), {});
  ASSERT_TRUE(made.ok());
  FileWriter& writer = *made.value();
  std::mt19937 random(1);
  const auto next = [&random](int i) {
    Record record = MakeRecord(3);
    std::string noise(2000, '\0');
    for (char& c : noise) c = static_cast<char>(random());
    record.mutable_note()->set_text(std::to_string(i) + noise);
    return record;
  };
  ASSERT_TRUE(writer.Add(next(0), 0).ok());
  ASSERT_TRUE(writer.Flush().ok());
  const rlimit limit{writer.counts().bytes + 1000, before.rlim_max};
  setrlimit(RLIMIT_FSIZE, &limit);
  ASSERT_TRUE(writer.Add(next(1), 0).ok());
  const Status full = writer.Flush();
  setrlimit(RLIMIT_FSIZE, &before);
  EXPECT_THAT(full.message(), HasSubstr("cannot be written: File too large"));
  EXPECT_EQ(std::filesystem::file_size(File()), writer.counts().bytes) << "the half is taken back";
  ASSERT_TRUE(writer.Add(next(2), 0).ok());
  ASSERT_TRUE(writer.Flush().ok()) << "there is room again";
  EXPECT_EQ(writer.counts().lost, 1U);
  ReadCounts counts;
  const auto records = ReadAll(File(), &counts);
  ASSERT_EQ(records.size(), 2U);
  EXPECT_EQ(records[1].note().text()[0], '2');
  EXPECT_EQ(DamageText(counts), "1 block missing");
}

TEST_F(WriterTest, TheHashOfAFileIsFnv1a) {
  // The test vectors of its authors: "" and "foobar".
  const auto write = [&](const std::string& text) {
    std::FILE* const file = std::fopen(File().c_str(), "wb");
    std::fwrite(text.data(), 1, text.size(), file);
    std::fclose(file);
    return HashOfFile(File()).value();
  };
  EXPECT_EQ(write(""), "fnv1a64:cbf29ce484222325");
  EXPECT_EQ(write("foobar"), "fnv1a64:85944171f73967e8");
  EXPECT_FALSE(HashOfFile(folder_ / "none").ok());
}

// The memory that a killed writer shares with the test.
struct Progress {
  std::atomic<std::int64_t> first_ns;   // when the first record was added
  std::atomic<std::int64_t> polled_ns;  // when the writer last had the occasion to write
  std::atomic<std::int64_t> added;      // records
};

// Records as fast as 2000 a second until it is killed.
[[noreturn]] void WriteUntilKilled(const std::filesystem::path& file, Progress& progress) {
  auto made = FileWriter::Create(file, {});
  if (!made.ok()) _exit(1);
  for (int i = 0;; ++i) {
    Record record = MakeRecord(i);
    const std::int64_t now_ns = MonotonicNow_ns();
    record.set_time_ns(now_ns);
    if (!made.value()->Add(record, now_ns).ok()) _exit(1);
    if (i == 0) progress.first_ns.store(now_ns);
    progress.polled_ns.store(now_ns);
    progress.added.store(i + 1);
    std::this_thread::sleep_for(std::chrono::microseconds(500));
  }
}

TEST_F(WriterTest, KilledAtTwentyRandomMomentsItLosesAtMostTheLastHundredMilliseconds) {
  void* const shared =
      mmap(nullptr, sizeof(Progress), PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS, -1, 0);
  ASSERT_NE(shared, MAP_FAILED);
  std::mt19937 random(20);
  for (int round = 0; round < 20; ++round) {
    auto* const progress = new (shared) Progress{{0}, {0}, {0}};
    const auto file = File(std::to_string(round) + ".styrec");
    const pid_t child = fork();
    if (child == 0) WriteUntilKilled(file, *progress);
    while (progress->added.load() == 0) std::this_thread::yield();
    std::this_thread::sleep_for(std::chrono::microseconds(random() % 300'000));
    kill(child, SIGKILL);
    int status = 0;
    waitpid(child, &status, 0);
    ASSERT_TRUE(WIFSIGNALED(status));

    ReadCounts counts;
    const auto records = ReadAll(file, &counts);
    EXPECT_EQ(counts.damaged_places + counts.lost_blocks + counts.malformed, 0U)
        << DamageText(counts);
    for (std::size_t i = 0; i < records.size(); ++i) {
      Record expected = MakeRecord(static_cast<int>(i));
      expected.set_time_ns(records[i].time_ns());
      ASSERT_EQ(records[i].SerializeAsString(), expected.SerializeAsString()) << "none is missing";
    }
    // By the writer's own clock: what the kernel did not let run is not the writer's loss.
    if (static_cast<std::int64_t>(records.size()) < progress->added.load()) {
      const std::int64_t kept_until_ns =
          records.empty() ? progress->first_ns.load() : records.back().time_ns();
      EXPECT_GT(kept_until_ns, progress->polled_ns.load() - 100 * kMillisecond_ns) << round;
    }
  }
  munmap(shared, sizeof(Progress));
}

}  // namespace
}  // namespace styled::recording
