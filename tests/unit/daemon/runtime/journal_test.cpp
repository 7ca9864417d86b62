#include "daemon/runtime/journal.h"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <spdlog/logger.h>
#include <spdlog/sinks/ostream_sink.h>
#include <sys/stat.h>
#include <unistd.h>

#include <sstream>
#include <thread>

#include "tests/support/datagrams.h"

namespace styled::runtime {
namespace {

spdlog::logger LoggerTo(const std::string& path) {
  const std::vector<LogField> always{{"SYSLOG_IDENTIFIER", "styled"}};
  return spdlog::logger("test", std::make_shared<JournalSink>(always, path));
}

TEST(JournalTest, AValueOfSeveralLinesGoesBehindItsLength) {
  EXPECT_EQ(EncodeEntry({{"MESSAGE", "one"}, {"PRIORITY", "6"}}), "MESSAGE=one\nPRIORITY=6\n");
  const std::string entry = EncodeEntry({{"MESSAGE", "a\nPRIORITY=0"}});
  EXPECT_EQ(entry, std::string("MESSAGE\n\x0c\0\0\0\0\0\0\0a\nPRIORITY=0\n", 29));
}

TEST(JournalTest, LinesCarryPriorityAndFields) {
  support::Datagrams journal;
  auto log = LoggerTo(journal.path());
  log.info("ready");
  {
    const LogFields fields{{"STYLED_COUNTER", "source.malformed"}, {"STYLED_MORE", "3"}};
    log.warn("{}: {} more", "source.malformed", 3);
  }
  log.error("cannot");
  EXPECT_EQ(journal.Next(), "MESSAGE=ready\nPRIORITY=6\nSYSLOG_IDENTIFIER=styled\n");
  EXPECT_EQ(journal.Next(),
            "MESSAGE=source.malformed: 3 more\nPRIORITY=4\nSYSLOG_IDENTIFIER=styled\n"
            "STYLED_COUNTER=source.malformed\nSTYLED_MORE=3\n");
  EXPECT_EQ(journal.Next(), "MESSAGE=cannot\nPRIORITY=3\nSYSLOG_IDENTIFIER=styled\n");
}

// A performer's, a file's or a rig's name that is quoted.
TEST(JournalTest, QuotedTextIsOneLineOfUtf8) {
  const std::string strange = "rig \"\xFF\nPRIORITY=0\x1b[31m\"";
  const std::string shown = "rig \"\xEF\xBF\xBD\\nPRIORITY=0\\x1b[31m\"";
  support::Datagrams journal;
  LoggerTo(journal.path()).warn("{}", strange);
  EXPECT_EQ(journal.Next(), "MESSAGE=" + shown + "\nPRIORITY=4\nSYSLOG_IDENTIFIER=styled\n");
  LoggerTo(journal.path()).warn("{}", std::string(kLongestLine + 1, 'x'));
  EXPECT_EQ(journal.Next(), "MESSAGE=" + std::string(kLongestLine, 'x') +
                                "...\nPRIORITY=4\nSYSLOG_IDENTIFIER=styled\n");

  std::ostringstream text;
  spdlog::logger log("test", std::make_shared<spdlog::sinks::ostream_sink_mt>(text));
  log.set_formatter(LineFormatter());
  log.warn("{}", strange);
  EXPECT_EQ(text.str().substr(text.str().find(' ')), " warning " + shown + "\n");
}

TEST(JournalTest, FieldsAreOneThreadsOwn) {
  support::Datagrams journal;
  auto log = LoggerTo(journal.path());
  const LogFields fields{{"STYLED_MORE", "3"}};
  std::thread([&log] { log.info("from another"); }).join();
  EXPECT_EQ(journal.Next(), "MESSAGE=from another\nPRIORITY=6\nSYSLOG_IDENTIFIER=styled\n");
}

TEST(JournalTest, AStalledJournalDelaysNoThreadAndLearnsHowManyLinesItMissed) {
  support::Datagrams journal;
  auto log = LoggerTo(journal.path());
  constexpr int kLines = 20000;  // far more than any queue of datagrams has room for
  for (int i = 0; i < kLines; ++i) log.info("line {}", i);
  int got = 0;
  while (journal.Next()) ++got;
  ASSERT_GT(got, 0);
  ASSERT_LT(got, kLines);
  log.info("later");
  log.info("last");
  EXPECT_EQ(journal.Next(),
            "MESSAGE=later\nPRIORITY=6\nSYSLOG_IDENTIFIER=styled\n"
            "STYLED_LINES_LOST=" +
                std::to_string(kLines - got) + "\n");
  EXPECT_EQ(journal.Next(), "MESSAGE=last\nPRIORITY=6\nSYSLOG_IDENTIFIER=styled\n");
}

TEST(JournalTest, WithoutASocketLinesGoToStderrBehindTheirPriority) {
  auto log = LoggerTo("/nowhere/at/all");
  testing::internal::CaptureStderr();
  log.warn("odd");
  EXPECT_EQ(testing::internal::GetCapturedStderr(), "<4>odd\n");
}

TEST(JournalTest, IsRecognizedByTheStreamThatTheEnvironmentNames) {
  const support::TemporaryFolder folder;
  const int fd = open((folder / "log").c_str(), O_CREAT | O_WRONLY | O_CLOEXEC, 0600);
  struct stat it {};
  ASSERT_EQ(fstat(fd, &it), 0);
  const std::string stream = std::to_string(it.st_dev) + ":" + std::to_string(it.st_ino);
  EXPECT_TRUE(IsJournal(stream.c_str(), fd));
  EXPECT_FALSE(IsJournal((stream + "1").c_str(), fd)) << "redirected since";
  EXPECT_FALSE(IsJournal(nullptr, fd));
  close(fd);
  EXPECT_FALSE(IsJournal(stream.c_str(), fd));
}

}  // namespace
}  // namespace styled::runtime
