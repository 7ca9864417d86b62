#pragma once

#include <gtest/gtest.h>

#include <functional>
#include <limits>
#include <string>

#include "model/base/status.h"
#include "tests/unit/net/stgcn/random_weights.h"

namespace styled::stgcn {

// One tensor of a correct file after the other: missing, of another shape, not finite. `load` must
// name the file "file".
inline void ExpectEachTensorIsChecked(WeightsFile file,
                                      const std::function<Status(const WeightsFile&)>& load) {
  for (std::size_t i = 0; i < file.tensors.size(); ++i) {
    const net::NamedTensor whole = file.tensors[i];
    const std::string begin = "file: tensor '" + whole.name + "': expected ";
    const std::string shape = nlohmann::json(whole.shape).dump();

    file.tensors.erase(file.tensors.begin() + static_cast<std::ptrdiff_t>(i));
    EXPECT_EQ(load(file).message(), begin + "F32 " + shape + ", found none");

    net::NamedTensor broken = whole;
    ++broken.shape.front();
    broken.values.resize(broken.values.size() / static_cast<std::size_t>(whole.shape.front()) *
                         static_cast<std::size_t>(broken.shape.front()));
    file.tensors.insert(file.tensors.begin() + static_cast<std::ptrdiff_t>(i), broken);
    EXPECT_EQ(load(file).message(),
              begin + "F32 " + shape + ", found F32 " + nlohmann::json(broken.shape).dump());

    file.tensors[i] = whole;
    file.tensors[i].values.back() = std::numeric_limits<float>::quiet_NaN();
    EXPECT_EQ(load(file).message(),
              begin + "finite values, found nan at " + std::to_string(whole.values.size() - 1));
    file.tensors[i] = whole;
  }
  EXPECT_TRUE(load(file).ok()) << load(file).message();
}

}  // namespace styled::stgcn
