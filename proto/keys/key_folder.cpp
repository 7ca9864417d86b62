#include "proto/keys/key_folder.h"

#include <dirent.h>
#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <memory>

namespace styled::keys {
namespace {

constexpr std::string_view kEnding = ".key";
constexpr std::size_t kMaxBytes = 4096;
constexpr mode_t kOthersWrite = 022;

class File {
 public:
  explicit File(int fd) : fd_(fd) {}
  ~File() {
    if (fd_ >= 0) close(fd_);
  }
  File(const File&) = delete;
  File& operator=(const File&) = delete;
  int get() const { return fd_; }

 private:
  int fd_;
};

Status Refuse(const std::string& file, const std::string& what) {
  return Status::Error(file + ": " + what);
}

Status Failed(const std::string& file) { return Refuse(file, std::strerror(errno)); }

std::string Octal(mode_t mode) {
  std::array<char, 8> text{};
  std::snprintf(text.data(), text.size(), "%04o", mode & 07777U);
  return text.data();
}

// The words for a private file in error messages.
struct Secret {
  const char* kind;         // "a file of keys"
  const char* holds;        // "a secret key"
  const char* replacement;  // "a new pair"
};
constexpr Secret kPair{"a file of keys", "a secret key", "a new pair"};
constexpr Secret kToken{"a file with a token", "a token", "a new one"};

Result<std::string> ReadAll(int fd, const std::string& file, const char* kind = kPair.kind) {
  std::string text(kMaxBytes + 1, '\0');
  std::size_t size = 0;
  while (size < text.size()) {
    const ssize_t got = read(fd, text.data() + size, text.size() - size);
    if (got < 0 && errno == EINTR) continue;
    if (got < 0) return Failed(file);
    if (got == 0) break;
    size += static_cast<std::size_t>(got);
  }
  if (size > kMaxBytes)
    return Refuse(file, std::string("larger than 4096 bytes; expected ") + kind);
  text.resize(size);
  return text;
}

Status CheckPrivate(const struct stat& about, const std::string& file, const Secret& secret) {
  const uid_t me = geteuid();
  if (about.st_uid != me && about.st_uid != 0) {
    return Refuse(file, "belongs to user " + std::to_string(about.st_uid) +
                            "; expected it to belong to us (user " + std::to_string(me) + ")");
  }
  const bool handed_over = about.st_uid == 0 && me != 0;
  const mode_t allowed = handed_over ? 0740 : 0700;
  if ((about.st_mode & 0777U & ~allowed) == 0) return Status::Ok();
  return Refuse(file, "others may read it (mode " + Octal(about.st_mode) + "), and it holds " +
                          secret.holds + "; expected 0600: chmod 600 " + file + ", or make " +
                          secret.replacement + " if it may have been read");
}

// Only root and `owner`, the owner of the folder of keys, may own the file.
Status CheckNotWritable(const struct stat& about, const std::string& file, uid_t owner) {
  if ((about.st_mode & kOthersWrite) != 0) {
    return Refuse(file, "others may write to it (mode " + Octal(about.st_mode) +
                            "), and could give themselves access; expected chmod go-w");
  }
  if (about.st_uid != owner && about.st_uid != 0) {
    return Refuse(file, "belongs to user " + std::to_string(about.st_uid) +
                            ", who could give anyone access; expected root or user " +
                            std::to_string(owner));
  }
  return Status::Ok();
}

// O_NONBLOCK: do not wait for a writer if the path is a pipe.
int OpenToRead(const std::string& file) {
  return open(file.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK);
}

Result<KeyFile> ReadKeyFile(int fd, const std::string& file) {
  const auto text = ReadAll(fd, file);
  if (!text.ok()) return text.status();
  auto parsed = Parse(text.value());
  if (!parsed.ok()) return Refuse(file, parsed.status().message());
  return parsed;
}

// Reads the text of a file, which no other user may be able to read.
Result<std::string> ReadPrivate(const std::string& file, const Secret& secret) {
  const File opened(OpenToRead(file));
  if (opened.get() < 0) return Failed(file);
  struct stat about {};
  if (fstat(opened.get(), &about) != 0) return Failed(file);
  if (!S_ISREG(about.st_mode)) return Refuse(file, "expected a file");
  if (const Status status = CheckPrivate(about, file, secret); !status.ok()) return status;
  return ReadAll(opened.get(), file, secret.kind);
}

bool WriteAll(int fd, const std::string& text) {
  std::size_t written = 0;
  while (written < text.size()) {
    const ssize_t got = write(fd, text.data() + written, text.size() - written);
    if (got < 0 && errno == EINTR) continue;
    if (got <= 0) return false;
    written += static_cast<std::size_t>(got);
  }
  return fsync(fd) == 0;
}

// Writes under another name first. Then rename() replaces the file, or, with `replace` false,
// link() fails if the name exists.
Status Write(const std::string& file, const std::string& text, mode_t mode, bool replace) {
  const std::string fresh = file + ".new-" + std::to_string(getpid());
  const File opened(open(fresh.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC | O_NOFOLLOW,
                         static_cast<mode_t>(0600)));
  if (opened.get() < 0) return Failed(fresh);
  bool done = WriteAll(opened.get(), text) && fchmod(opened.get(), mode) == 0;
  if (done && replace) done = rename(fresh.c_str(), file.c_str()) == 0;
  if (done && !replace) done = link(fresh.c_str(), file.c_str()) == 0;
  const int error = errno;
  if (!done || !replace) unlink(fresh.c_str());
  if (done) return Status::Ok();
  return Refuse(file, error == EEXIST ? "exists already; remove it first if it is not needed"
                                      : std::strerror(error));
}

Status CheckFolder(const std::string& folder, uid_t owner) {
  struct stat about {};
  if (stat(folder.c_str(), &about) != 0) return Failed(folder);
  if (!S_ISDIR(about.st_mode)) return Refuse(folder, "expected a folder");
  return CheckNotWritable(about, folder, owner);
}

// The owner of `folder`; root if it cannot be determined.
uid_t OwnerOf(const std::string& folder) {
  struct stat about {};
  return stat(folder.c_str(), &about) == 0 ? about.st_uid : 0;
}

// Creates a missing folder: the owner may write, all may read.
Status MakeFolder(const std::string& folder, uid_t owner) {
  if (mkdir(folder.c_str(), 0755) != 0 && errno != EEXIST) return Failed(folder);
  return CheckFolder(folder, owner);
}

std::string ClientFile(const std::string& folder, const std::string& name) {
  return ClientsFolder(folder) + "/" + name + std::string(kEnding);
}

// The names of the clients' files, sorted.
Result<std::vector<std::string>> ListNames(const std::string& folder) {
  std::vector<std::string> names;
  const std::unique_ptr<DIR, int (*)(DIR*)> opened(opendir(folder.c_str()), closedir);
  if (opened == nullptr) {
    if (errno == ENOENT) return names;
    return Failed(folder);
  }
  errno = 0;
  while (const dirent* entry = readdir(opened.get())) {
    const std::string_view file = entry->d_name;
    if (!file.ends_with(kEnding) || file.starts_with('.')) continue;
    names.emplace_back(file.substr(0, file.size() - kEnding.size()));
  }
  if (errno != 0) return Failed(folder);
  std::sort(names.begin(), names.end());
  return names;
}

// Whether the error is temporary and tells nothing about the file.
bool IsPassing(int error) { return error == EMFILE || error == ENFILE || error == ENOMEM; }

// `passing`: the error is temporary, and not the file's fault.
Result<Client> ReadClient(const std::string& folder, const std::string& name, bool& passing) {
  const std::string file = ClientFile(folder, name);
  if (!IsClientName(name)) {
    return Refuse(file, "a client's name has 1 to 32 of A-Z a-z 0-9 _ -");
  }
  const File opened(OpenToRead(file));
  passing = opened.get() < 0 && IsPassing(errno);
  if (opened.get() < 0) return Failed(file);
  struct stat about {};
  if (fstat(opened.get(), &about) != 0) return Failed(file);
  if (!S_ISREG(about.st_mode)) return Refuse(file, "expected a file");
  if (const Status status = CheckNotWritable(about, file, OwnerOf(folder)); !status.ok())
    return status;
  const auto read = ReadKeyFile(opened.get(), file);
  if (!read.ok()) return read.status();
  if (!read.value().role) {
    return Refuse(file, "says no role; expected subscriber or operator below \"metadata\"");
  }
  return Client{name, read.value().public_key, *read.value().role};
}

}  // namespace

std::string ServerKeyFile(const std::string& folder) { return folder + "/server.key"; }
std::string ServerPublicFile(const std::string& folder) { return folder + "/server.pub"; }
std::string ClientsFolder(const std::string& folder) { return folder + "/clients"; }

bool IsClientName(std::string_view name) noexcept {
  return !name.empty() && name.size() <= 32 && std::all_of(name.begin(), name.end(), [](char c) {
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '_' ||
           c == '-';
  });
}

Result<KeyFile> ReadPair(const std::string& file) {
  const auto text = ReadPrivate(file, kPair);
  if (!text.ok()) return text.status();
  auto pair = Parse(text.value());
  if (!pair.ok()) return Refuse(file, pair.status().message());
  if (pair.value().secret_key.empty()) {
    return Refuse(file, "holds no secret-key; expected a pair, as stylectl keygen makes it");
  }
  return pair;
}

Result<std::string> ReadTokenFile(const std::string& file) { return ReadPrivate(file, kToken); }

Result<std::string> ReadPublicKey(const std::string& file) {
  const File opened(OpenToRead(file));
  if (opened.get() < 0) return Failed(file);
  const auto read = ReadKeyFile(opened.get(), file);
  if (!read.ok()) return read.status();
  return read.value().public_key;
}

Status WritePair(const std::string& file, const KeyFile& pair) {
  return Write(file, Format(pair), 0600, false);
}

Result<KeyFile> ServerPair(const std::string& folder, bool& made) {
  made = false;
  for (const std::string& needed : {folder, ClientsFolder(folder)}) {
    if (const Status status = MakeFolder(needed, geteuid()); !status.ok()) return status;
  }
  const std::string file = ServerKeyFile(folder);
  if (access(file.c_str(), F_OK) != 0 && errno == ENOENT) {
    const auto pair = MakePair();
    if (!pair.ok()) return pair.status();
    if (const Status status = WritePair(file, pair.value()); !status.ok()) return status;
    made = true;
  }
  auto pair = ReadPair(file);
  if (!pair.ok()) return pair.status();
  // For clients. If it cannot be written (a read-only folder), the daemon works nevertheless.
  const KeyFile shown{pair.value().public_key, "", std::nullopt};
  const auto old = ReadPublicKey(ServerPublicFile(folder));
  if (!old.ok() || old.value() != shown.public_key) {
    (void)Write(ServerPublicFile(folder), Format(shown), 0644, true).ok();
  }
  return pair;
}

Result<Clients> ReadClients(const std::string& folder) {
  Clients clients;
  const std::string place = ClientsFolder(folder);
  const auto names = ListNames(place);
  if (!names.ok()) return names.status();
  if (names.value().empty()) return clients;
  if (const Status status = CheckFolder(place, OwnerOf(folder)); !status.ok()) {
    clients.complaints.push_back(status.message());
    return clients;
  }
  for (const std::string& name : names.value()) {
    bool passing = false;
    auto client = ReadClient(folder, name, passing);
    if (passing) return client.status();
    if (!client.ok()) {
      clients.complaints.push_back(client.status().message());
      continue;
    }
    const auto other =
        std::find_if(clients.allowed.begin(), clients.allowed.end(),
                     [&](const Client& known) { return known.key == client.value().key; });
    if (other != clients.allowed.end()) {
      clients.complaints.push_back(ClientFile(folder, name) + ": has the key of " + other->name);
    } else if (clients.allowed.size() == kMaxClients) {
      clients.complaints.push_back(ClientFile(folder, name) + ": more than 1000 clients");
    } else {
      clients.allowed.push_back(std::move(client.value()));
    }
  }
  return clients;
}

Status Allow(const std::string& folder, const Client& client) {
  if (!IsClientName(client.name)) {
    return Status::Error("'" + client.name +
                         "' is not a client's name; expected 1 to 32 of A-Z a-z 0-9 _ -");
  }
  if (!IsKey(client.key)) {
    return Status::Error("'" + client.key + "' is not a public key; expected 40 characters of Z85");
  }
  if (const Status status = CheckFolder(folder, OwnerOf(folder)); !status.ok()) return status;
  const auto known = ReadClients(folder);
  if (!known.ok()) return known.status();
  for (const Client& other : known.value().allowed) {
    if (other.key == client.key && other.name != client.name) {
      return Status::Error("this key is already allowed, as " + other.name);
    }
  }
  if (const Status status = MakeFolder(ClientsFolder(folder), OwnerOf(folder)); !status.ok())
    return status;
  // Readable by all: the daemon may run as another user.
  return Write(ClientFile(folder, client.name), Format({client.key, "", client.role}), 0644, true);
}

Status Revoke(const std::string& folder, const std::string& name) {
  const std::string file = ClientFile(folder, name);
  if (IsClientName(name) && unlink(file.c_str()) == 0) return Status::Ok();
  if (!IsClientName(name) || errno == ENOENT) {
    return Status::Error("'" + name + "' is not allowed at " + folder);
  }
  return Failed(file);
}

}  // namespace styled::keys
