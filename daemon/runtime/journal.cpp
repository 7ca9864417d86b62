#include "daemon/runtime/journal.h"

#include <spdlog/pattern_formatter.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/un.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <cstring>

#include "model/base/text.h"

namespace styled::runtime {
namespace {

thread_local std::vector<LogField> current_fields;

std::string TextOf(const spdlog::details::log_msg& message) {
  return Printable({message.payload.data(), message.payload.size()}, kLongestLine);
}

class TextFlag final : public spdlog::custom_flag_formatter {
 public:
  void format(const spdlog::details::log_msg& message, const std::tm& /*time*/,
              spdlog::memory_buf_t& line) override {
    const std::string text = TextOf(message);
    line.append(text.data(), text.data() + text.size());
  }
  std::unique_ptr<custom_flag_formatter> clone() const override {
    return std::make_unique<TextFlag>();
  }
};

}  // namespace

LogFields::LogFields(std::initializer_list<LogField> fields) { current_fields = fields; }

LogFields::~LogFields() { current_fields.clear(); }

// A field is NAME=value and a line feed. A value with line breaks is written as NAME, a line feed,
// its length as a 64-bit little-endian number, the value and a line feed.
std::string EncodeEntry(const std::vector<LogField>& fields) {
  std::string entry;
  for (const auto& [name, value] : fields) {
    if (value.find('\n') == std::string::npos) {
      entry.append(name).append("=").append(value).append("\n");
      continue;
    }
    entry += name + "\n";
    for (unsigned shift = 0; shift < 64; shift += 8) {
      entry += static_cast<char>((std::uint64_t{value.size()} >> shift) & 0xffU);
    }
    entry += value + "\n";
  }
  return entry;
}

bool IsJournal(const char* journal_stream, int fd) {
  struct stat it {};
  if (journal_stream == nullptr || fstat(fd, &it) != 0) return false;
  return std::to_string(it.st_dev) + ":" + std::to_string(it.st_ino) == journal_stream;
}

int Priority(spdlog::level::level_enum level) {
  switch (level) {
    case spdlog::level::critical:
      return 2;
    case spdlog::level::err:
      return 3;
    case spdlog::level::warn:
      return 4;
    case spdlog::level::info:
      return 6;
    default:
      return 7;
  }
}

std::unique_ptr<spdlog::formatter> LineFormatter() {
  auto formatter = std::make_unique<spdlog::pattern_formatter>();
  formatter->add_flag<TextFlag>('*').set_pattern("%Y-%m-%dT%H:%M:%S.%e %^%l%$ %*");
  return formatter;
}

JournalSink::JournalSink(std::vector<LogField> always, std::string socket_path)
    : always_(std::move(always)),
      socket_path_(std::move(socket_path)),
      socket_(socket(AF_UNIX, SOCK_DGRAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0)) {}

void JournalSink::sink_it_(const spdlog::details::log_msg& message) {
  const std::string text = TextOf(message);
  std::vector<LogField> fields{{"MESSAGE", text},
                               {"PRIORITY", std::to_string(Priority(message.level))}};
  fields.insert(fields.end(), always_.begin(), always_.end());
  fields.insert(fields.end(), current_fields.begin(), current_fields.end());
  if (lost_ > 0) fields.emplace_back("STYLED_LINES_LOST", std::to_string(lost_));
  const std::string entry = EncodeEntry(fields);
  sockaddr_un to{};
  to.sun_family = AF_UNIX;
  std::strncpy(to.sun_path, socket_path_.c_str(), sizeof to.sun_path - 1);
  if (sendto(socket_.get(), entry.data(), entry.size(), MSG_NOSIGNAL,
             reinterpret_cast<const sockaddr*>(&to), sizeof to) >= 0) {
    lost_ = 0;
  } else if (errno == EAGAIN || errno == ENOBUFS) {
    ++lost_;
  } else {
    std::fprintf(stderr, "<%d>%s\n", Priority(message.level), text.c_str());
  }
}

}  // namespace styled::runtime
