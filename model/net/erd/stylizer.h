#pragma once

#include <memory>

#include "model/base/status.h"
#include "model/net/stylizer.h"
#include "model/net/weights_file.h"

namespace styled::erd {

// Style-ERD (Tao et al., ACM TOG 2022) of a weights file of the family net::kStyleErd (FORMAT.md):
// features (features.h), network (network.h), and a stream with the memories of both.
Result<std::shared_ptr<const net::Stylizer>> Load(net::WeightsFile& file);

}  // namespace styled::erd
