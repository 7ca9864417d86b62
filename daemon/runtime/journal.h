#pragma once

#include <spdlog/sinks/base_sink.h>

#include <cstddef>
#include <initializer_list>
#include <memory>
#include <mutex>
#include <string>
#include <utility>
#include <vector>

#include "model/base/descriptor.h"

namespace styled::runtime {

// A field of a journal entry: its name ([A-Z0-9_]) and any value.
using LogField = std::pair<std::string, std::string>;

// While an object lives, every journal entry of this thread carries `fields`, so that it can be
// found by them (journalctl STYLED_COUNTER=source.malformed). Logs to stderr do not show the
// fields, so the message must contain the facts, too. Objects do not nest.
class LogFields {
 public:
  LogFields(std::initializer_list<LogField> fields);
  ~LogFields();
  LogFields(const LogFields&) = delete;
  LogFields& operator=(const LogFields&) = delete;
};

// One entry of the journal's native protocol.
std::string EncodeEntry(const std::vector<LogField>& fields);

// Whether descriptor `fd` is the one that systemd connected to the journal. `journal_stream` is the
// value of $JOURNAL_STREAM, "DEVICE:INODE"; null when it is unset.
bool IsJournal(const char* journal_stream, int fd);

// The syslog(3) priority of a log level.
int Priority(spdlog::level::level_enum level);

// The longest log message in bytes; the rest is cut off and marked "...".
inline constexpr std::size_t kLongestLine = 4000;

// Formats lines for stderr: time, level and text. Here and in the journal the text is passed
// through Printable(): quoted input of a peer cannot start another line, colour a terminal, or
// break a reader that expects UTF-8.
std::unique_ptr<spdlog::formatter> LineFormatter();

// Logs into the journal by its native protocol: MESSAGE, PRIORITY, SYSLOG_IDENTIFIER, `always` and
// LogFields. Sending never blocks: while the journal is behind, lines are lost, and the next line
// that gets through carries their number (STYLED_LINES_LOST). Where the journal's socket does not
// exist, lines go to stderr with the prefix <PRIORITY>, which the journal understands, too.
class JournalSink final : public spdlog::sinks::base_sink<std::mutex> {
 public:
  explicit JournalSink(std::vector<LogField> always,
                       std::string socket_path = "/run/systemd/journal/socket");

 protected:
  void sink_it_(const spdlog::details::log_msg& message) override;
  void flush_() override {}

 private:
  std::vector<LogField> always_;
  std::string socket_path_;
  Descriptor socket_;
  std::uint64_t lost_ = 0;
};

}  // namespace styled::runtime
