#pragma once

#include <Eigen/Core>
#include <nlohmann/json.hpp>
#include <span>
#include <string>
#include <vector>

#include "model/base/status.h"
#include "model/net/kernels/kernel.h"
#include "model/net/safetensors.h"
#include "model/net/stylizer.h"

// The common part of all families' weights files (FORMAT.md), and functions with which a family
// reads the rest. Start-up code: it allocates, and no input makes it throw. Pinned by
// tests/unit/net/erd/load_test.cpp and tests/unit/net/load_test.cpp.
namespace styled::net {

// Keeps the first fault, prefixed with the file's name. Later faults are dropped, so a reader can
// continue and check once at the end.
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

// The families' names as written in a file.
inline constexpr const char* kStyleErd = "style-erd";  // also every file of version 1

inline constexpr unsigned kWeightsVersion = 3;  // of what is written

// A file of any family, with its common keys read and checked.
struct WeightsFile {
  std::string name;       // begins every error
  Model model;            // the common keys
  nlohmann::json header;  // all keys, an object
  // The precision to which the family rounds its weights. ParseWeights leaves it as it is.
  Precision precision = Precision::kFloat32;
  SafetensorsView view;  // its spans lie in the bytes given to ParseWeights
};

// Reads container and common keys. `bytes` must outlive the result.
Result<WeightsFile> ParseWeights(std::span<const std::byte> bytes, const std::string& name);

// The values of the keys "gate", "posture" and "reference" (FORMAT.md).
nlohmann::json AsJson(const GateBounds& gate);
nlohmann::json AsJson(const Posture& posture);
nlohmann::json AsJson(const neutral::Reference& reference);

// The header of a file that holds `model`: the common keys, in the newest version.
nlohmann::json HeaderOf(const Model& model);

// The value of a required key; nullptr and a fault if there is none.
const nlohmann::json* FindKey(const nlohmann::json& object, const std::string& key, Faults& faults);
// Adds a fault if the key's value is not `expected`, type included.
void ExpectEqual(const nlohmann::json& object, const std::string& key,
                 const nlohmann::json& expected, Faults& faults);
struct Range {
  float least, most;
  bool least_allowed = true;
};
// A required number within `range`; 0 and a fault if there is no such number.
float ReadNumber(const nlohmann::json& object, const std::string& key, Range range, Faults& faults);
// A value as text for an error message, shortened.
std::string Shown(const nlohmann::json& value);

using RowMajor = Eigen::Matrix<float, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

// Reads tensors one by one and removes them from the view. Finish() reports a tensor that is left
// as unknown.
class TensorReader {
 public:
  TensorReader(SafetensorsView& view, Faults& faults) : view_(view), faults_(faults) {}

  // A finite matrix [rows, columns]; zeros and a fault if the tensor is missing, of another type or
  // shape, or not finite.
  RowMajor Matrix(const std::string& name, int rows, int columns);
  RowMajor Vector(const std::string& name, int rows);  // [rows]
  // The same for any shape, its last dimensions side by side: [shape[0], shape[1] * ...].
  RowMajor Tensor(const std::string& name, const std::vector<std::int64_t>& shape);
  void Finish();

 private:
  RowMajor Read(const std::string& name, const std::vector<std::int64_t>& shape, int rows,
                int columns);

  SafetensorsView& view_;
  Faults& faults_;
};

}  // namespace styled::net
