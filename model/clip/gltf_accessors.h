#pragma once

#include <cstddef>
#include <map>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "model/base/status.h"

// The numbers of a glTF file's animations. Included only by gltf_*.cpp. Errors do not name the
// file. Allocates; one thread at a time. Pinned by tests/unit/clip/gltf_clip_test.cpp,
// hostile_clips_test.cpp.
namespace styled::clip::gltf {

inline constexpr double kLatest_s = 86400;  // of a key: floats tell milliseconds apart until then

// The accessors of a file, read as floats. Each is read and kept once, however many channels share
// it, and all together have no more values than the file has bytes of data: of bytes, the smallest
// type, it cannot have more, unless accessors lie over one another. A file with packed buffer views
// (EXT_meshopt_compression) has an allowance in addition, for the unpacked bytes and their values.
class Accessors {
 public:
  // `data`, the file's binary chunk, and `file` must live as long as this.
  Accessors(const nlohmann::json& file, std::string_view data)
      : file_(file), data_(data), left_(sizeof(float) * data.size()) {}

  // All values of an accessor of `type` ("SCALAR", "VEC3", "VEC4"), one after the other; for
  // SCALAR, increasing times.
  using Values = std::shared_ptr<const std::vector<float>>;
  Result<Values> Read(int index, const std::string& type);

 private:
  struct Rows {
    const char* begin = nullptr;
    std::size_t stride = 0;
  };

  Result<std::vector<float>> ReadNew(int index, const std::string& type);
  const nlohmann::json& At(const char* list, int index) const;
  Result<std::string_view> Unpacked(int number, const nlohmann::json& packed, std::size_t size);
  Result<std::string_view> Bytes(int number, const nlohmann::json& view);
  Result<Rows> View(const nlohmann::json& accessor, std::size_t size, std::size_t count);

  const nlohmann::json& file_;
  std::string_view data_;
  std::size_t left_;  // bytes that unpacked views and values may still take
  std::map<int, std::string> unpacked_;
  std::map<std::pair<int, std::string>, Values> kept_;
};

}  // namespace styled::clip::gltf
