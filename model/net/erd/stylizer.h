#pragma once

#include <memory>

#include "model/base/status.h"
#include "model/net/stylizer.h"
#include "model/net/weights_file.h"

namespace styled::erd {

// Loads Style-ERD (Tao et al., CVPR 2022) from a weights file of the family net::kStyleErd
// (FORMAT.md): features (features.h), network (network.h), and streams with the state of both.
// Errors name the key or tensor. Allocates; start-up and reload only.
Result<std::shared_ptr<const net::Stylizer>> Load(net::WeightsFile& file);

}  // namespace styled::erd
