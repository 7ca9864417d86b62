// libstyled's clips: read, made of arrays, restyled as the program `stylize` does, written.
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <utility>

#include "model/base/flush_subnormals.h"
#include "model/body/humanoid.h"
#include "model/clip/bind_clip.h"
#include "model/library/entry.h"
#include "model/library/handles.h"
#include "model/library/styled.h"
#include "model/offline/frames.h"
#include "model/offline/learn_neutral.h"

using styled::Result;
using styled::Status;
using styled::library::Explain;
using styled::library::Guarded;

namespace {

void Show(styled_clip& made) {
  const styled::rig::Skeleton& skeleton = made.clip.skeleton;
  for (std::size_t j = 0; j < skeleton.names.size(); ++j) {
    made.names.push_back(skeleton.names[j].c_str());
    made.parents.push_back(skeleton.parents[j]);
    const auto& offset = skeleton.offsets[j];
    const auto& rest = made.binding->spec().rest_rotations[j].coeffs();
    made.offsets.insert(made.offsets.end(), offset.begin(), offset.end());
    made.rest.insert(made.rest.end(), rest.begin(), rest.end());
  }
  for (std::size_t c = 0; c < styled::body::kHumanoid.size(); ++c) {
    const int joint = made.binding->spec().source_joint[c];
    made.joint_texts.push_back(std::string(styled::body::kHumanoid[c].name) + "=" +
                               (joint < 0 ? "" : skeleton.names[static_cast<std::size_t>(joint)]));
  }
  for (const std::string& text : made.joint_texts) made.joints.push_back(text.c_str());
  made.joints.push_back(nullptr);
  made.body = {sizeof(styled_body), skeleton.joint_count(), made.names.data(), made.parents.data(),
               made.offsets.data(), made.rest.data(),       nullptr,           made.joints.data()};
}

Result<styled_clip*> Made(styled::clip::Clip clip,
                          std::shared_ptr<const styled::rig::Binding> binding) {
  auto made = std::make_unique<styled_clip>();
  made->clip = std::move(clip);
  made->binding = std::move(binding);
  Show(*made);
  return made.release();
}

Result<styled_clip*> Bound(styled::clip::Clip clip, const styled::clip::BindOptions& options) {
  auto bound = styled::clip::BindClip(clip, options);
  if (!bound.ok()) return bound.status();
  return Made(std::move(clip),
              std::make_shared<const styled::rig::Binding>(std::move(bound.value().binding)));
}

Result<styled_clip*> Read(const char* file, const char* const* joints) {
  if (file == nullptr) return Status::Error("file: found NULL, expected a path");
  auto given = styled::library::ReadJoints(joints);
  if (!given.ok()) return given.status();
  auto clip = styled::clip::ReadBvh(file);
  if (!clip.ok()) return clip.status();
  styled::clip::BindOptions options;
  options.joints = std::move(given.value());
  auto made = Bound(std::move(clip.value()), options);
  if (made.ok()) return made;
  return Status::Error(std::string(file) + ": " + made.status().message());
}

Status ReadFrames(std::size_t frames, const float* root, const float* rotations,
                  styled::clip::Clip& clip) {
  for (std::size_t i = 0; i < frames; ++i) {
    styled::rig::RigPose pose(clip.skeleton);
    pose.translations[0] = Eigen::Map<const styled::body::Vec3>(root + 3 * i);
    const auto refuse = [&](const std::string& what) {
      return Status::Error("frame " + std::to_string(i) + ": " + what);
    };
    if (!pose.translations[0].allFinite()) return refuse("the root is not finite");
    const std::size_t joints = pose.rotations.size();
    for (std::size_t j = 0; j < joints; ++j) {
      pose.rotations[j].coeffs() =
          Eigen::Map<const Eigen::Vector4f>(rotations + 4 * (joints * i + j));
      if (!(std::abs(pose.rotations[j].norm() - 1) < 1e-3F)) {
        return refuse("joint " + std::to_string(j) + ": the rotation is not of unit length");
      }
    }
    clip.frames.push_back(std::move(pose));
  }
  return Status::Ok();
}

Result<styled_clip*> Make(const styled_body* body, double rate_hz, std::size_t frames,
                          const float* root, const float* rotations) {
  auto read = styled::library::ReadBody(body);
  if (!read.ok()) return read.status();
  styled::rig::RigBody& described = read.value().body;
  if (Status sound = styled::rig::CheckBody(described); !sound.ok()) return sound;
  if (!(rate_hz >= 1 && rate_hz <= 1000)) {
    return Status::Error("rate: found " + std::to_string(rate_hz) + " Hz, expected 1 to 1000");
  }
  if (frames == 0 || root == nullptr || rotations == nullptr) {
    return Status::Error("frames: found none, expected at least one, with root and rotations");
  }
  styled::clip::Clip clip;
  clip.skeleton = described.skeleton;
  clip.rate_hz = rate_hz;
  if (Status sound = ReadFrames(frames, root, rotations, clip); !sound.ok()) return sound;
  if (described.rest.empty()) {
    styled::clip::BindOptions options;
    options.dialect = described.dialect;
    options.joints = std::move(read.value().joints);
    return Bound(std::move(clip), options);
  }
  auto bound = styled::rig::BindBody(described, read.value().joints);
  if (!bound.ok()) return bound.status();
  return Made(std::move(clip), bound.value().binding);
}

// As stylize::Restyler: the performer's neutral is that of the whole clip, and the style is there
// from the first frame on.
int Restyle(const styled_network& network, const styled::stylist::Settings& settings,
            styled::clip::Clip& clip, const std::shared_ptr<const styled::rig::Binding>& binding) {
  const styled::FlushSubnormals flush;
  const styled::offline::Frames frames(clip);
  styled::stylist::Stylist stylist(network.stylizer, binding, {});
  stylist.Set(settings);
  if (const auto& reference = network.stylizer->model().reference) {
    stylist.Know(styled::offline::LearnNeutral(clip, *binding, *reference));
  }
  styled::stylist::Output out(clip.skeleton);
  int own = 0;
  for (std::size_t i = 0; i < frames.count; ++i) {
    stylist.Process(frames.Time_ns(i), frames.At(i), out);
    if (!frames.Given(i)) continue;
    own += (out.flags & styled::stylist::kFailed) != 0 ? 1 : 0;
    clip.frames[i / frames.steps] = out.rig;  // the input's data is no longer read
  }
  return own;
}

// Whatever fails in `act` is explained; its status is that of the work.
template <typename Act>
int Tried(char* error, std::size_t size, const Act& act) noexcept {
  try {
    const Status status = act();
    if (status.ok()) return STYLED_OK;
    Explain(status.message(), error, size);
  } catch (const std::exception& failure) {
    Explain(failure.what(), error, size);
  }
  return STYLED_ERROR_FAILED;
}

}  // namespace

extern "C" {

styled_clip* styled_read_clip_checked(const char* file, const char* const* joints, char* error,
                                      std::size_t error_size) {
  return Guarded<styled_clip>(error, error_size, [&] { return Read(file, joints); });
}

styled_clip* styled_make_clip_checked(const styled_body* body, double rate_hz, std::size_t frames,
                                      const float* root, const float* rotations, char* error,
                                      std::size_t error_size) {
  return Guarded<styled_clip>(error, error_size,
                              [&] { return Make(body, rate_hz, frames, root, rotations); });
}

styled_clip* styled_copy_clip(const styled_clip* clip) {
  if (clip == nullptr) return nullptr;
  return Guarded<styled_clip>(nullptr, 0, [&] { return Made(clip->clip, clip->binding); });
}

void styled_free_clip(styled_clip* clip) { delete clip; }

const styled_body* styled_clip_body(const styled_clip* clip) {
  return clip == nullptr ? nullptr : &clip->body;
}

std::size_t styled_clip_length(const styled_clip* clip, double* rate_hz) {
  if (clip == nullptr) return 0;
  if (rate_hz != nullptr) *rate_hz = clip->clip.rate_hz;
  return clip->clip.frames.size();
}

int styled_clip_frames(const styled_clip* clip, float* root, float* rotations) {
  if (clip == nullptr || root == nullptr || rotations == nullptr) return STYLED_ERROR_ARGUMENT;
  for (const styled::rig::RigPose& pose : clip->clip.frames) {
    Eigen::Map<styled::body::Vec3>{root} = pose.translations[0];
    root += 3;
    for (const auto& rotation : pose.rotations) {
      Eigen::Map<Eigen::Vector4f>{rotations} = rotation.coeffs();
      rotations += 4;
    }
  }
  return STYLED_OK;
}

int styled_restyle(const styled_network* network, styled_clip* clip, const std::int32_t* styles,
                   const float* weights, int count, char* error, std::size_t error_size) {
  int own = 0;
  const int done = Tried(error, error_size, [&]() -> Status {
    if (network == nullptr || clip == nullptr) {
      return Status::Error("found NULL, expected a network and a clip");
    }
    const auto settings =
        styled::library::ReadMix(*network->stylizer, styles, weights, count, /*transition_s=*/0);
    if (!settings) {
      return Status::Error(
          "styles: expected 0 to 4 different ones but neutral, with weights of 0 to 1.5 that sum "
          "to at most 1.5");
    }
    own = Restyle(*network, *settings, clip->clip, clip->binding);
    return Status::Ok();
  });
  return done == STYLED_OK ? own : done;
}

int styled_write_clip(const styled_clip* clip, const char* file, char* error,
                      std::size_t error_size) {
  return Tried(error, error_size, [&]() -> Status {
    if (clip == nullptr || file == nullptr) {
      return Status::Error("found NULL, expected a clip and a path");
    }
    return styled::clip::WriteBvh(clip->clip, file);
  });
}

int styled_learn(styled_performer* performer, const styled_clip* clip) {
  if (performer == nullptr || clip == nullptr) return STYLED_ERROR_ARGUMENT;
  const auto& reference = performer->network->model().reference;
  if (!reference) return STYLED_ERROR_FAILED;
  const auto known = styled::offline::LearnNeutral(clip->clip, *clip->binding, *reference);
  if (!(known.body_s > 0)) return STYLED_ERROR_FAILED;
  performer->stylist->Know(known);
  return STYLED_OK;
}

}  // extern "C"
