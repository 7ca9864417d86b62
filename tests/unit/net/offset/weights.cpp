#include "tests/unit/net/offset/weights.h"

#include <cstdio>
#include <cstdlib>

namespace styled::offset {

net::Model TestModel() {
  net::Model model;
  model.styles = {{"neutral", {"normal"}}, {"bent", {"stooped"}}, {"raised", {}}};
  model.rate_hz = 30;
  model.licence = "CC0-1.0";
  return model;
}

std::vector<Offsets> TestOffsets() {
  Offsets none;
  none.fill(body::Quat::Identity());
  std::vector<Offsets> offsets(3, none);
  offsets[1][body::kSpine] = body::Exp(body::Vec3(kBent_rad, 0, 0));
  offsets[2][body::kLeftUpperArm] = body::Exp(body::Vec3(0, 0, kRaised_rad));
  return offsets;
}

void WriteTestWeights(const std::filesystem::path& file) {
  const Status status = Write(file, TestModel(), TestOffsets());
  if (status.ok()) return;
  std::fprintf(stderr, "%s\n", status.message().c_str());
  std::abort();
}

}  // namespace styled::offset
