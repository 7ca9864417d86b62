#include "clients/doctor/sockets.h"

#include <dirent.h>
#include <unistd.h>

#include <array>
#include <charconv>
#include <cstring>
#include <fstream>
#include <iterator>
#include <memory>
#include <optional>
#include <sstream>
#include <unordered_map>

namespace styled::doctor {
namespace {

constexpr std::string_view kListening = "0A";

std::string ReadText(const std::string& file) {
  std::ifstream in(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

template <typename T>
std::optional<T> Number(std::string_view text, int base) {
  T value{};
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value, base);
  if (error != std::errc() || end != text.data() + text.size()) return std::nullopt;
  return value;
}

// Parses "0100007F:1B58": 32-bit words in this machine's byte order, the port as a hexadecimal
// number.
std::optional<Endpoint> ParseLocal(std::string_view text) {
  const std::size_t colon = text.find(':');
  if (colon != 8 && colon != 32) return std::nullopt;
  const auto port = Number<std::uint16_t>(text.substr(colon + 1), 16);
  if (!port) return std::nullopt;
  std::array<std::uint32_t, 4> words{};
  for (std::size_t i = 0; i < colon / 8; ++i) {
    const auto word = Number<std::uint32_t>(text.substr(8 * i, 8), 16);
    if (!word) return std::nullopt;
    words[i] = *word;
  }
  sockaddr_storage address{};
  if (colon == 8) {
    address.ss_family = AF_INET;
    std::memcpy(&reinterpret_cast<sockaddr_in&>(address).sin_addr, words.data(), 4);
  } else {
    address.ss_family = AF_INET6;
    std::memcpy(&reinterpret_cast<sockaddr_in6&>(address).sin6_addr, words.data(), 16);
  }
  return Endpoint{FromSocket(address).host, *port};
}

struct Folder {
  explicit Folder(const std::string& path) : handle(opendir(path.c_str()), closedir) {}
  // The next entry; "" at the end.
  std::string Next() const {
    const dirent* entry = handle == nullptr ? nullptr : readdir(handle.get());
    return entry == nullptr ? "" : entry->d_name;
  }
  std::unique_ptr<DIR, int (*)(DIR*)> handle;
};

// The inode of the socket behind a descriptor in /proc/PID/fd; 0: not a socket.
std::uint64_t SocketInode(const std::string& link) {
  std::array<char, 64> target{};
  const ssize_t size = readlink(link.c_str(), target.data(), target.size() - 1);
  std::string_view text(target.data(), size < 0 ? 0 : static_cast<std::size_t>(size));
  if (!text.starts_with("socket:[") || !text.ends_with(']')) return 0;
  text.remove_prefix(8);
  text.remove_suffix(1);
  return Number<std::uint64_t>(text, 10).value_or(0);
}

void FindOwners(std::vector<BoundSocket>& sockets) {
  std::unordered_multimap<std::uint64_t, BoundSocket*> by_inode;
  for (BoundSocket& socket : sockets) by_inode.emplace(socket.inode, &socket);
  const Folder processes("/proc");
  for (std::string name = processes.Next(); !name.empty(); name = processes.Next()) {
    const auto pid = Number<pid_t>(name, 10);
    if (!pid) continue;
    std::string program;
    const std::string folder = "/proc/" + name + "/fd/";
    const Folder descriptors(folder);
    for (std::string fd = descriptors.Next(); !fd.empty(); fd = descriptors.Next()) {
      const std::uint64_t inode = SocketInode(folder + fd);
      if (inode == 0 || !by_inode.contains(inode)) continue;
      if (program.empty()) program = ReadText("/proc/" + name + "/comm");
      while (program.ends_with('\n')) program.pop_back();
      const auto [first, last] = by_inode.equal_range(inode);
      for (auto it = first; it != last; ++it) {
        it->second->pid = *pid;
        it->second->program = Printable(program, 32);
      }
    }
  }
}

}  // namespace

std::vector<BoundSocket> ParseSocketTable(std::string_view text, bool stream) {
  std::vector<BoundSocket> out;
  std::istringstream lines{std::string(text)};
  std::string line;
  std::getline(lines, line);  // skip the column headings
  while (std::getline(lines, line)) {
    std::istringstream words(line);
    const std::vector<std::string> fields{std::istream_iterator<std::string>(words), {}};
    if (fields.size() < 10 || (stream && fields[3] != kListening)) continue;
    const auto local = ParseLocal(fields[1]);
    const std::size_t colon = fields[4].find(':');
    const auto inode = Number<std::uint64_t>(fields[9], 10);
    if (!local || !inode || colon == std::string::npos) continue;
    BoundSocket socket;
    socket.stream = stream;
    socket.local = *local;
    socket.inode = *inode;
    socket.waiting_bytes = Number<std::uint64_t>(fields[4].substr(colon + 1), 16).value_or(0);
    if (!stream && fields.size() > 12) {
      socket.drops = Number<std::uint64_t>(fields[12], 10).value_or(0);
    }
    out.push_back(std::move(socket));
  }
  return out;
}

std::vector<BoundSocket> ListSockets() {
  std::vector<BoundSocket> out;
  for (const std::string name : {"udp", "udp6", "tcp", "tcp6"}) {
    auto rows = ParseSocketTable(ReadText("/proc/net/" + name), name.starts_with("tcp"));
    out.insert(out.end(), std::make_move_iterator(rows.begin()),
               std::make_move_iterator(rows.end()));
  }
  FindOwners(out);
  return out;
}

std::string Holder(const BoundSocket& socket) {
  if (socket.pid > 0) return socket.program + " (pid " + std::to_string(socket.pid) + ")";
  const std::string protocol = socket.stream ? "t" : "u";
  return "a program of another user (sudo ss -" + protocol +
         "lpn 'sport = :" + std::to_string(socket.local.port) + "' names it)";
}

}  // namespace styled::doctor
