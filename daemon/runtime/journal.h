#pragma once

#include <spdlog/sinks/base_sink.h>

#include <cstddef>
#include <initializer_list>
#include <memory>
#include <mutex>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "daemon/runtime/descriptor.h"

namespace styled::runtime {

// A name ([A-Z0-9_]) and any value.
using LogField = std::pair<std::string, std::string>;

// While it lives, what this thread logs carries `fields` in the journal, to be searched by
// (journalctl STYLED_COUNTER=source.malformed). Other logs do without: the text says it, too.
class LogFields {
 public:
  LogFields(std::initializer_list<LogField> fields);
  ~LogFields();
  LogFields(const LogFields&) = delete;
  LogFields& operator=(const LogFields&) = delete;
};

// One entry of the journal's native protocol.
std::string EncodeEntry(const std::vector<LogField>& fields);

// Whether descriptor `fd` is what systemd connected to the journal: `journal_stream` is that one's
// "DEVICE:INODE" ($JOURNAL_STREAM; null: unset).
bool IsJournal(const char* journal_stream, int fd);

// The priority of a level as syslog(3) has them.
int Priority(spdlog::level::level_enum level);

// The longest line of the log, in bytes; the rest is cut off ("...").
inline constexpr std::size_t kLongestLine = 4000;

// Lines for stderr: time, level and text. Here and in the journal, the text is Printable(): what
// others sent and were quoted with cannot make a second line, colour a terminal or break what reads
// the log as UTF-8.
std::unique_ptr<spdlog::formatter> LineFormatter();

// Logs into the journal by its native protocol: MESSAGE, PRIORITY, SYSLOG_IDENTIFIER, `always` and
// LogFields. A journal that is behind does not hold up who logs: lines are lost then, and the next
// one that gets through says how many (STYLED_LINES_LOST). Where there is no such socket, lines go
// to stderr behind <PRIORITY>, which the journal understands, too.
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
