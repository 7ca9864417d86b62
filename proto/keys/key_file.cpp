#include "proto/keys/key_file.h"

#include <zmq.h>

#include <array>

namespace styled::keys {
namespace {

constexpr std::size_t kKeyBytes = 32;

std::string_view Trim(std::string_view text) {
  const std::size_t begin = text.find_first_not_of(" \t\r");
  if (begin == std::string_view::npos) return {};
  return text.substr(begin, text.find_last_not_of(" \t\r") - begin + 1);
}

// Splits `name = "value"` or `name = value`. A quoted value may hold anything but its quote.
bool Split(std::string_view line, std::string_view& name, std::string_view& value) {
  const std::size_t sign = line.find('=');
  if (sign == std::string_view::npos) return false;
  name = Trim(line.substr(0, sign));
  value = Trim(line.substr(sign + 1));
  const char quote = value.empty() ? '\0' : value.front();
  if (quote == '"' || quote == '\'') {
    if (value.size() < 2 || value.back() != quote) return false;
    value = value.substr(1, value.size() - 2);
  }
  return !name.empty() && !value.empty();
}

class Reader {
 public:
  Status Line(std::string_view line) {
    ++number_;
    const std::string_view text = Trim(line);
    if (text.empty() || text.front() == '#') return Status::Ok();
    const bool indented = line.front() == ' ' || line.front() == '\t';
    if (!indented) {
      section_ = text;
      return Status::Ok();
    }
    std::string_view name, value;
    if (!Split(text, name, value)) return Refuse("expected NAME = \"VALUE\"");
    if (section_ == "metadata" && name == "role") return Role(value);
    if (section_ != "curve") return Status::Ok();  // other sections hold other programs' data
    if (name == "public-key") return Key(value, file.public_key);
    if (name == "secret-key") return Key(value, file.secret_key);
    return Refuse("expected public-key or secret-key");
  }

  Status Role(std::string_view value) {
    file.role = ParseRole(value);
    return file.role ? Status::Ok() : Refuse("role: expected subscriber or operator");
  }

  // An error never repeats a key: it may be the secret one in the wrong place.
  Status Key(std::string_view value, std::string& key) {
    if (!key.empty()) return Refuse("a second key of this kind");
    if (!IsKey(value)) return Refuse("expected a key, 40 characters of Z85");
    key = value;
    return Status::Ok();
  }

  Status Refuse(const std::string& what) const {
    return Status::Error("line " + std::to_string(number_) + ": " + what);
  }

  KeyFile file;

 private:
  int number_ = 0;
  std::string section_;
};

}  // namespace

std::string_view Name(Role role) noexcept {
  return role == Role::kOperator ? "operator" : "subscriber";
}

std::optional<Role> ParseRole(std::string_view text) noexcept {
  for (const Role role : {Role::kSubscriber, Role::kOperator}) {
    if (text == Name(role)) return role;
  }
  return std::nullopt;
}

bool IsKey(std::string_view text) {
  std::array<std::uint8_t, kKeyBytes> bytes{};
  // libzmq measures the text up to the first zero byte.
  return text.size() == kKeyCharacters && text.find('\0') == std::string_view::npos &&
         zmq_z85_decode(bytes.data(), std::string(text).c_str()) != nullptr;
}

std::string ToText(std::string_view bytes) {
  std::array<char, kKeyCharacters + 1> text{};
  if (bytes.size() != kKeyBytes ||
      zmq_z85_encode(text.data(), reinterpret_cast<const std::uint8_t*>(bytes.data()),
                     bytes.size()) == nullptr) {
    return "";
  }
  return text.data();
}

Result<KeyFile> Parse(std::string_view text) {
  Reader reader;
  while (!text.empty()) {
    const std::size_t end = text.find('\n');
    const Status status = reader.Line(text.substr(0, end));
    if (!status.ok()) return status;
    text.remove_prefix(end == std::string_view::npos ? text.size() : end + 1);
  }
  const KeyFile& file = reader.file;
  if (file.public_key.empty()) {
    return Status::Error("holds no public-key below a line \"curve\"");
  }
  if (file.secret_key.empty()) return file;
  std::array<char, kKeyCharacters + 1> derived{};
  if (zmq_curve_public(derived.data(), file.secret_key.c_str()) != 0 ||
      file.public_key != derived.data()) {
    return Status::Error("its two keys do not belong together");
  }
  return file;
}

std::string Format(const KeyFile& file) {
  std::string text;
  if (file.role) text.append("metadata\n    role = \"").append(Name(*file.role)).append("\"\n");
  text.append("curve\n    public-key = \"").append(file.public_key).append("\"\n");
  if (!file.secret_key.empty()) {
    text.append("    secret-key = \"").append(file.secret_key).append("\"\n");
  }
  return text;
}

// Keys are arguments of command lines, where a leading "-" would make them an option.
Result<KeyFile> MakePair() {
  std::array<char, kKeyCharacters + 1> public_key{'-'}, secret_key{};
  while (public_key[0] == '-') {
    if (zmq_curve_keypair(public_key.data(), secret_key.data()) != 0) {
      return Status::Error(std::string("no key can be made: ") + zmq_strerror(zmq_errno()));
    }
  }
  return KeyFile{public_key.data(), secret_key.data(), std::nullopt};
}

}  // namespace styled::keys
