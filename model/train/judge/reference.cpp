#include "model/train/judge/reference.h"

#include "model/net/weights_file.h"
#include "model/train/judge/evidence.h"
#include "model/train/judge/stream.h"
#include "model/train/reference.h"

namespace styled::judge {

Status WriteReference(const neutral::Reference& reference, const std::filesystem::path& weights) {
  return EditMetadata(weights, [&reference](nlohmann::ordered_json& keys) {
    keys["version"] = net::kWeightsVersion;
    // A file of version 1 has no family.
    if (!keys.contains("family")) keys["family"] = net::kStyleErd;
    keys["reference"] = nlohmann::ordered_json(net::AsJson(reference));
    return Status::Ok();
  });
}

Status MeasureAndWriteReference(const std::filesystem::path& manifest,
                                const std::filesystem::path& folder,
                                const std::filesystem::path& weights) {
  const auto set = ReadTrainingSet(manifest, folder);
  if (!set.ok()) return set.status();
  const auto reference = train::MeasureReference(set.value().clips, set.value().rate_hz);
  if (!reference) {
    return Status::Error(manifest.string() +
                         ": expected neutral clips that show standing and walking, found none");
  }
  return WriteReference(*reference, weights);
}

}  // namespace styled::judge
