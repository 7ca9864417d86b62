#pragma once

#include <filesystem>
#include <memory>
#include <vector>

#include "model/base/status.h"
#include "model/net/phase/style.h"
#include "model/net/stylizer.h"
#include "model/net/weights_file.h"

// A style that is measured, not trained: what distinguishes an example of it from the performer's
// own neutral, joint by joint, as a function of the gait phase. Without a gait, the style's posture
// remains. Its space (net::StyleSpace) makes a style from any clip of a walk or a run of some
// seconds. Relatives: Hsu et al. 2005, Xia et al. 2015, Yumer and Mitra 2016, which search or work
// offline. Format and mathematics: FORMAT.md. Pinned by tests/unit/net/phase/stylizer_test.cpp.
namespace styled::phase {

inline constexpr const char* kFamily = "phase";

// Loads a weights file of this family; consumes its tensors. Errors name the key or tensor.
Result<std::shared_ptr<const net::Stylizer>> Load(net::WeightsFile& file);

// Writes a weights file. styles[s] belongs to model.styles[s], [0] is not used; model.reference
// must have gaits. `model.family` is ignored.
Status Write(const std::filesystem::path& file, const net::Model& model,
             const std::vector<net::StyleCode>& styles);

}  // namespace styled::phase
