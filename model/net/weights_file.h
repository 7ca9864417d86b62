#pragma once

#include <Eigen/Core>
#include <nlohmann/json.hpp>
#include <span>
#include <string>
#include <vector>

#include "model/base/status.h"
#include "model/net/safetensors.h"
#include "model/net/stylizer.h"

// What the weights files of all families have in common (FORMAT.md), and what a family reads the
// rest with. Start-up code: it allocates, and no input makes it throw. Pinned by
// tests/unit/net/erd/load_test.cpp and tests/unit/net/load_test.cpp.
namespace styled::net {

// The first thing found wrong, and the file's name in front of it. Later faults are dropped, so
// that a reader can go on and check once at the end.
class Faults {
 public:
  explicit Faults(const std::string& file) : file_(file) {}
  void Add(const std::string& what) {
    if (first_.empty()) first_ = file_ + ": " + what;
  }
  void Key(const std::string& key, const std::string& expected, const std::string& found) {
    Add("key '" + key + "': expected " + expected + ", found " + found);
  }
  bool none() const { return first_.empty(); }
  Status status() const { return none() ? Status::Ok() : Status::Error(first_); }

 private:
  std::string file_, first_;
};

// The families' names, as they stand in a file.
inline constexpr const char* kStyleErd = "style-erd";  // a file of version 1 is of this one

// A file of any family, its common keys read and checked.
struct WeightsFile {
  std::string name;       // begins every error
  Model model;            // the common keys
  nlohmann::json header;  // all keys, an object
  SafetensorsView view;   // its spans lie in the bytes given to ParseWeights
};

// Reads container and common keys. `bytes` must outlive the result.
Result<WeightsFile> ParseWeights(std::span<const std::byte> bytes, const std::string& name);

// The common keys of a file that holds `model`, of the newest version.
nlohmann::json HeaderOf(const Model& model);

// Keys of a family's own.
const nlohmann::json* FindKey(const nlohmann::json& object, const std::string& key, Faults& faults);
void ExpectEqual(const nlohmann::json& object, const std::string& key,
                 const nlohmann::json& expected, Faults& faults);
struct Range {
  float least, most;
  bool least_allowed = true;
};
// 0 and a fault where there is no such number.
float ReadNumber(const nlohmann::json& object, const std::string& key, Range range, Faults& faults);
// A value as it is shown in an error.
std::string Shown(const nlohmann::json& value);

using RowMajor = Eigen::Matrix<float, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

// Takes tensors out of the file one by one; what is left at the end is unknown.
class TensorReader {
 public:
  TensorReader(SafetensorsView& view, Faults& faults) : view_(view), faults_(faults) {}

  // A matrix [rows, columns]; zeros and a fault if it is not as expected or not finite.
  RowMajor Matrix(const std::string& name, int rows, int columns);
  RowMajor Vector(const std::string& name, int rows);  // [rows]
  void Finish();

 private:
  RowMajor Read(const std::string& name, const std::vector<std::int64_t>& shape, int rows,
                int columns);

  SafetensorsView& view_;
  Faults& faults_;
};

}  // namespace styled::net
