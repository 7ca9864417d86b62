#include "model/clip/gltf_read.h"

#include <algorithm>
#include <charconv>
#include <chrono>
#include <filesystem>
#include <iterator>
#include <nlohmann/json.hpp>
#include <string>
#include <string_view>
#include <utility>

#include "model/base/work_limit.h"
#include "model/clip/gltf_nodes.h"
#include "model/clip/read_file.h"

namespace styled::clip {
namespace {

using gltf::Broken;
using gltf::kMaxJson;
using gltf::kTooMuchJson;
using gltf::Member;
using gltf::Shown;
using nlohmann::json;

constexpr const char* kExpected = ", expected an avatar's .vrm, .glb or .gltf";

// Describes a file that does not begin like glTF; empty if it does.
std::string NotGltf(std::string_view read) {
  if (read.empty()) return "found an empty file";
  std::string_view text = read;
  if (text.starts_with("\xEF\xBB\xBF")) text.remove_prefix(3);
  text.remove_prefix(std::min(text.find_first_not_of(" \t\r\n"), text.size()));
  if (text.starts_with('{')) return "";
  return "found a file that begins with \"" + Shown(read.substr(0, 16)) + "\"";
}

// The daemon reads avatars on the thread that feeds its watchdog (5 s), so a file may take one
// second at most. The JSON may contain images as text: that of a large avatar has 20 MB, and
// reading kMaxJson takes about a second.

// The number of buffers, and of images; an avatar has up to a hundred. Each costs a look at every
// folder on its path.
constexpr std::size_t kMaxUris = 4096;
constexpr std::ptrdiff_t kMaxParts = 16;   // folders on such a path
constexpr std::size_t kMaxUriSize = 1024;  // bytes of such a path
// The time for all of them: a folder may be a link that leads through 40 others, each with a
// thousand folders on its way, and following it takes 20 ms.
constexpr auto kMaxFollowing = std::chrono::seconds(1);

// Decodes URI escapes: "../a%2Fb" becomes "../a/b". A "%" that begins no escape is kept.
std::string Unescaped(std::string_view uri) {
  std::string text;
  for (std::size_t i = 0; i < uri.size(); ++i) {
    unsigned value = 0;
    const char* const digits = uri.data() + i + 1;
    if (uri[i] == '%' && i + 2 < uri.size() &&
        std::from_chars(digits, digits + 2, value, 16).ptr == digits + 2) {
      text += static_cast<char>(value);
      i += 2;
    } else {
      text += uri[i];
    }
  }
  return text;
}

// Why the uri of a buffer or image of an avatar in `home` is refused; empty if it is accepted. The
// file is not opened here; the check protects the next program that opens it (a viewer, an
// exporter) and trusts an avatar that was accepted. A "data:" uri is not a file.
std::string LeadsOut(const std::string& uri, const std::filesystem::path& home) {
  if (uri.starts_with("data:")) return "";
  if (uri.size() > kMaxUriSize) {
    return "has more than " + std::to_string(kMaxUriSize) + " characters";
  }
  std::string text = Unescaped(uri);
  std::replace(text.begin(), text.end(), '\\', '/');
  const std::filesystem::path path(text);
  if (text.find('\0') != std::string::npos || text.find(':') < text.find('/')) {
    return "is not a file beside the avatar";
  }
  if (path.is_absolute()) return "is an absolute path";
  for (const auto& part : path) {
    if (part == "..") return "leads out of the avatar's folder";
  }
  if (std::distance(path.begin(), path.end()) > kMaxParts) {
    return "lies more than " + std::to_string(kMaxParts) + " folders deep";
  }
  std::error_code error;
  const auto real = std::filesystem::weakly_canonical(home / path, error);
  if (error) return "cannot be followed";
  const auto [end, unused] = std::mismatch(home.begin(), home.end(), real.begin(), real.end());
  if (end != home.end()) return "is a link that leads out of the avatar's folder";
  const auto kind = std::filesystem::status(real, error).type();
  if (kind != std::filesystem::file_type::regular &&
      kind != std::filesystem::file_type::not_found) {
    return "is not an ordinary file";
  }
  return "";
}

Status CheckUris(const json& file, const std::filesystem::path& folder) {
  std::error_code error;
  const auto home = std::filesystem::weakly_canonical(folder, error);
  if (error) return Status::Error("the avatar's folder cannot be followed: " + error.message());
  const auto work =
      WorkLimit::Within(kMaxFollowing, "buffers and images at the end of short paths");
  for (const char* const list : {"buffers", "images"}) {
    const json& entries = Member(file, list);
    if (!entries.is_array()) continue;
    if (entries.size() > kMaxUris) {
      return Status::Error("found " + std::to_string(entries.size()) + " " + list +
                           ", expected at most " + std::to_string(kMaxUris));
    }
    for (std::size_t i = 0; i < entries.size(); ++i) {
      const json& uri = Member(entries[i], "uri");
      if (!uri.is_string()) continue;
      if (work.exceeded()) return work.Refusal();
      const auto& text = uri.get_ref<const std::string&>();
      const std::string wrong = LeadsOut(text, home);
      if (wrong.empty()) continue;
      return Status::Error(std::string(list) + "[" + std::to_string(i) + "].uri \"" +
                           Shown(text.substr(0, 64)) + "\" " + wrong +
                           ", expected a file in the avatar's own folder");
    }
  }
  return Status::Ok();
}

// The JSON text of a .gltf file, or of a .glb or .vrm (glTF 2.0, 4.4: a header, then chunks);
// nothing else of the file is read.
Result<std::string> ReadJsonText(const InputFile& file) {
  using gltf::kChunk, gltf::kHeader, gltf::kJsonChunk, gltf::Word;
  const auto start = file.Read(0, 64);
  if (!start.ok()) return start.status();
  const std::string& head = start.value();
  if (!head.starts_with("glTF")) {
    if (const std::string found = NotGltf(head); !found.empty()) {
      return Broken(found);
    }
    if (file.size() > kMaxJson) return Status::Error(kTooMuchJson);
    return file.Read(0, kMaxJson);
  }
  if (head.size() < kHeader) return Broken("it ends early");
  if (const std::uint32_t version = Word(head, 4); version != 2) {
    return gltf::WrongVersion(std::to_string(version) + " in binary form");
  }
  if (head.size() < kHeader + kChunk || Word(head, kHeader + 4) != kJsonChunk) {
    return Broken("its first chunk is not JSON");
  }
  const std::size_t length = Word(head, kHeader);
  if (length > kMaxJson) return Status::Error(kTooMuchJson);
  auto text = file.Read(kHeader + kChunk, length);
  if (text.ok() && text.value().size() < length) {
    return Broken("it ends early");
  }
  return text;
}

Result<GltfSkeleton> ReadFile(const std::filesystem::path& file, const rig::JointNames& given) {
  const auto opened = InputFile::Open(file, kExpected);
  if (!opened.ok()) return opened.status();
  const auto refuse = [&file](const Status& status) {
    const std::string& text = status.message();
    const std::string name = file.string() + ": ";
    return text.starts_with(name) ? status : Status::Error(name + text);
  };
  auto text = ReadJsonText(opened.value());
  if (!text.ok()) return refuse(text.status());
  auto read = gltf::ParseJson(text.value(), opened.value().size());
  if (!read.ok()) return refuse(read.status());
  text.value() = std::string();  // freed, so that it is not in memory together with the nodes
  json& parsed = read.value();
  const auto folder = file.has_parent_path() ? file.parent_path() : std::filesystem::path(".");
  if (const Status status = CheckUris(parsed, folder); !status.ok()) return refuse(status);
  const auto model = gltf::ReadModel(parsed);
  if (!model.ok()) return refuse(model.status());
  const auto nodes = gltf::Nodes::Make(model.value());
  if (!nodes.ok()) return refuse(nodes.status());
  auto bones = gltf::FindBones(model.value(), nodes.value(), given);
  if (!bones.ok()) return refuse(bones.status());
  return std::move(bones.value().skeleton);
}

}  // namespace

Result<GltfSkeleton> ReadGltfSkeleton(const std::filesystem::path& file,
                                      const rig::JointNames& given) {
  return ReadFile(file, given);
}

}  // namespace styled::clip
