#include "model/train/persons.h"

#include <map>
#include <optional>
#include <string>

#include "model/neutral/neutral.h"
#include "model/train/reference.h"

namespace styled::train {
namespace {

// Processes every frame of a clip, the first one as in a new session.
void Follow(const TrainingClip& clip, double rate_hz, const neutral::Reference& reference,
            neutral::Neutral& neutral) {
  const auto dt_s = static_cast<float>(1 / rate_hz);
  for (std::size_t at = 0; at < clip.poses.size(); ++at) {
    neutral.Follow(clip.poses[at], at == 0 ? 0 : dt_s, true, reference);
  }
}

void RemoveCarriage(const neutral::Known& known, double rate_hz,
                    const neutral::Reference& reference, TrainingClip& clip) {
  neutral::Neutral neutral;
  neutral.Know(known, reference);
  const auto dt_s = static_cast<float>(1 / rate_hz);
  for (body::Pose& pose : clip.poses) {
    neutral.Follow(pose, dt_s, false, reference);
    neutral.RemoveCarriage(pose, pose);
  }
}

}  // namespace

Status RemovePersons(double rate_hz, std::vector<TrainingClip>& clips) {
  std::map<std::string, neutral::Neutral> persons;
  for (const TrainingClip& clip : clips) {
    if (!clip.person.empty()) persons.try_emplace(clip.person);
  }
  if (persons.empty()) return Status::Ok();
  const std::optional<neutral::Reference> reference = MeasureReference(clips, rate_hz);
  if (!reference) {
    return Status::Error(
        "persons need neutral clips of the set's own performers that show standing and "
        "walking; the manifest has none");
  }
  for (const TrainingClip& clip : clips) {
    if (!clip.person.empty()) Follow(clip, rate_hz, *reference, persons.at(clip.person));
  }
  std::map<std::string, neutral::Known> known;
  for (const auto& [name, neutral] : persons) {
    known[name] = neutral.Tell(*reference);
    if (!(known[name].body_s > 0)) {
      return Status::Error("person \"" + name +
                           "\": no clip shows them standing or walking upright");
    }
  }
  for (TrainingClip& clip : clips) {
    if (!clip.person.empty()) RemoveCarriage(known.at(clip.person), rate_hz, *reference, clip);
  }
  return Status::Ok();
}

}  // namespace styled::train
