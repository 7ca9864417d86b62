#include "model/library/styled.h"

#include <dlfcn.h>

#include <algorithm>
#include <cstddef>
#include <cstring>
#include <filesystem>
#include <new>
#include <string>
#include <system_error>
#include <vector>

#include "model/base/checkpoint.h"
#include "model/base/flush_subnormals.h"
#include "model/base/hash.h"
#include "model/base/read_file.h"
#include "model/library/entry.h"
#include "model/library/handles.h"
#include "model/net/shipped_weights.h"
#include "model/trial/trial.h"

using styled::Checkpoint;
using styled::FlushSubnormals;
using styled::Result;
using styled::Status;
using styled::library::Guarded;
using styled::library::ReadBody;

namespace styled::library {

Result<rig::JointNames> ReadJoints(const char* const* joints) {
  std::vector<std::string> texts;
  for (; joints != nullptr && *joints != nullptr; ++joints) texts.emplace_back(*joints);
  return rig::ParseJoints("joints", texts);
}

Result<Described> ReadBody(const styled_body* given) {
  if (given == nullptr) return Status::Error("body: found NULL, expected a styled_body");
  // That of the first headers ended before `joints`.
  constexpr std::size_t kFirst = offsetof(styled_body, joints);
  if (given->size != kFirst && given->size != sizeof(styled_body)) {
    return Status::Error("body: found size " + std::to_string(given->size) + ", expected " +
                         std::to_string(sizeof(styled_body)));
  }
  styled_body body{};
  std::memcpy(&body, given, given->size);
  if (body.joint_count < 1 || body.joint_count > rig::kMaxSourceJoints) {
    return Status::Error("body: found " + std::to_string(body.joint_count) +
                         " joints, expected 1 to " + std::to_string(rig::kMaxSourceJoints));
  }
  if (body.names == nullptr || body.parents == nullptr || body.offsets == nullptr) {
    return Status::Error("body: found NULL, expected names, parents and offsets");
  }
  Described read;
  for (int j = 0; j < body.joint_count; ++j) {
    if (body.names[j] == nullptr) {
      return Status::Error("body: joint " + std::to_string(j) + ": found NULL, expected a name");
    }
    read.body.skeleton.names.emplace_back(body.names[j]);
    read.body.skeleton.parents.push_back(body.parents[j]);
    const float* const offset = body.offsets + std::ptrdiff_t{3} * j;
    read.body.skeleton.offsets.emplace_back(offset[0], offset[1], offset[2]);
    if (body.rest == nullptr) continue;
    const float* const rest = body.rest + std::ptrdiff_t{4} * j;
    read.body.rest.emplace_back(rest[3], rest[0], rest[1], rest[2]);
  }
  if (body.dialect != nullptr && *body.dialect != '\0') read.body.dialect = body.dialect;
  auto joints = ReadJoints(body.joints);
  if (!joints.ok()) return joints.status();
  read.joints = std::move(joints.value());
  return read;
}

std::optional<stylist::Settings> ReadMix(const net::Stylizer& network, const std::int32_t* styles,
                                         const float* weights, int count, float transition_s) {
  if (count < 0 || count > net::kMaxMix) return std::nullopt;
  if (count > 0 && (styles == nullptr || weights == nullptr)) return std::nullopt;
  const auto known = static_cast<int>(network.model().styles.size());
  stylist::Settings settings;
  for (int i = 0; i < count; ++i) {
    if (styles[i] < 0 || styles[i] >= known) return std::nullopt;
    settings.mix[static_cast<std::size_t>(i)] = {styles[i], weights[i]};
  }
  settings.transition_s = transition_s;
  if (stylist::Validate(settings, known) != stylist::SettingsError::kNone) return std::nullopt;
  return settings;
}

}  // namespace styled::library

namespace {

// The folders of weights that belong to this very file: in a Python package, in an installation
// (lib/TRIPLET or lib), in a build tree.
std::vector<std::filesystem::path> FoldersBeside() {
  static const char here = 0;
  Dl_info info{};
  std::error_code error;
  if (dladdr(&here, &info) == 0 || info.dli_fname == nullptr) return {};
  const auto folder = std::filesystem::canonical(info.dli_fname, error).parent_path();
  if (error) return {};
  return {folder / "weights", folder / "../share/styled/weights",
          folder / "../../share/styled/weights", folder / "../../../../model/weights"};
}

Result<styled_network*> Load(const char* weights, const std::string& precision) {
  const auto& known = styled::net::kPrecisions;
  if (std::ranges::find(known, precision) == known.end()) {
    return Status::Error("precision: found \"" + precision + "\", expected int8 or float32");
  }
  const auto file = styled::net::FindWeights(
      weights == nullptr ? "" : weights,
      {FoldersBeside(), "the first argument of styled_load, or STYLED_WEIGHTS"});
  if (!file.ok()) return file.status();
  auto network = styled::trial::Load(file.value(), styled::net::PrecisionNamed(precision));
  if (!network.ok()) return network.status();
  const auto bytes = styled::ReadFile(file.value().string(), std::size_t{1} << 30);
  if (!bytes.ok()) return bytes.status();
  styled::Fnv1a hash;
  hash.Text(bytes.value());
  hash.Text(precision);
  auto terms = styled::net::ReadTerms(file.value(), network.value()->model().licence);
  return new styled_network{std::move(network.value()), hash.value(), std::move(terms), {}};
}

Result<styled_performer*> Create(const styled_network* network, const styled_body* body) {
  if (network == nullptr) return Status::Error("network: found NULL, expected a loaded one");
  auto read = ReadBody(body);
  if (!read.ok()) return read.status();
  auto bound = styled::rig::BindBody(read.value().body, read.value().joints);
  if (!bound.ok()) return bound.status();
  return new styled_performer(network->stylizer, bound.value().binding, network->hash);
}

}  // namespace

void styled_performer::Become(std::uint64_t hash) {
  network_hash = hash;
  const styled::rig::BindingSpec& spec = binding->spec();
  styled::Fnv1a all;
  all.Bytes(&hash, sizeof hash);
  for (std::size_t j = 0; j < spec.skeleton.names.size(); ++j) {
    all.Text(spec.skeleton.names[j]);
    all.Byte(0);
    all.Number(spec.skeleton.parents[j]);
    all.Bytes(spec.skeleton.offsets[j].data(), 3 * sizeof(float));
    all.Bytes(spec.rest_rotations[j].coeffs().data(), 4 * sizeof(float));
  }
  identity = all.value();
}

extern "C" {

const char* styled_version(void) { return STYLED_VERSION; }

styled_network* styled_load_checked(const char* weights, const char* precision, char* error,
                                    std::size_t error_size) {
  return Guarded<styled_network>(
      error, error_size, [&] { return Load(weights, precision == nullptr ? "int8" : precision); });
}

void styled_release(styled_network* network) { delete network; }

int styled_style_count(const styled_network* network) {
  return network == nullptr ? 0 : static_cast<int>(network->styles().size());
}

const char* styled_style_name(const styled_network* network, int style) {
  const auto* const info = network == nullptr ? nullptr : network->Find(style);
  return info == nullptr ? nullptr : info->name.c_str();
}

const char* styled_style_licence(const styled_network* network, int style) {
  const auto* const info = network == nullptr ? nullptr : network->Find(style);
  if (info == nullptr) return nullptr;
  return (info->licence.empty() ? network->terms.licence : info->licence).c_str();
}

const char* styled_style_credit(const styled_network* network, int style) {
  const auto* const info = network == nullptr ? nullptr : network->Find(style);
  if (info == nullptr) return nullptr;
  return (info->licence.empty() ? network->terms.credit : info->credit).c_str();
}

int styled_find_style(const styled_network* network, const char* name) {
  if (network == nullptr || name == nullptr) return -1;
  return styled::net::FindStyle(network->styles(), name);
}

styled_performer* styled_create(const styled_network* network, const styled_body* body, char* error,
                                std::size_t error_size) {
  return Guarded<styled_performer>(error, error_size, [&] { return Create(network, body); });
}

void styled_destroy(styled_performer* performer) { delete performer; }

int styled_set(styled_performer* performer, const std::int32_t* styles, const float* weights,
               int count, float transition_s) {
  if (performer == nullptr) return STYLED_ERROR_ARGUMENT;
  const auto settings =
      styled::library::ReadMix(*performer->network, styles, weights, count, transition_s);
  if (!settings) return STYLED_ERROR_ARGUMENT;
  performer->stylist->Set(*settings);
  return STYLED_OK;
}

int styled_frame(styled_performer* performer, std::int64_t time_ns, const float* root,
                 const float* rotations, float* styled_root, float* styled_rotations,
                 std::uint32_t* flags) {
  if (performer == nullptr || root == nullptr || rotations == nullptr || styled_root == nullptr ||
      styled_rotations == nullptr) {
    return STYLED_ERROR_ARGUMENT;
  }
  styled_performer& p = *performer;
  constexpr std::int64_t kMost_ns = std::int64_t{1} << 61;  // differences of two never overflow
  if (time_ns < -kMost_ns || time_ns > kMost_ns) return STYLED_ERROR_ARGUMENT;
  if (p.started && time_ns <= p.last_ns) return STYLED_ERROR_TIME;
  const FlushSubnormals flush;
  p.in.translations[0] = Eigen::Map<const styled::body::Vec3>(root);
  for (std::size_t j = 0; j < p.in.rotations.size(); ++j) {
    p.in.rotations[j].coeffs() = Eigen::Map<const Eigen::Vector4f>(rotations + 4 * j);
  }
  p.stylist->Process(time_ns, p.in, p.out);
  p.last_ns = time_ns;
  p.started = true;
  Eigen::Map<styled::body::Vec3>{styled_root} = p.out.rig.translations[0];
  for (std::size_t j = 0; j < p.out.rig.rotations.size(); ++j) {
    Eigen::Map<Eigen::Vector4f>(styled_rotations + 4 * j) = p.out.rig.rotations[j].coeffs();
  }
  if (flags != nullptr) *flags = p.out.flags;
  return STYLED_OK;
}

int styled_reset(styled_performer* performer) {
  if (performer == nullptr) return STYLED_ERROR_ARGUMENT;
  performer->stylist->Reset();
  performer->started = false;
  return STYLED_OK;
}

int styled_calibrate(styled_performer* performer, float seconds) {
  if (performer == nullptr || !(seconds == 0 || (seconds >= 1 && seconds <= 60))) {
    return STYLED_ERROR_ARGUMENT;
  }
  if (seconds > 0) {
    performer->stylist->CalibrateNeutral(seconds);
  } else {
    performer->stylist->ForgetNeutral();
  }
  return STYLED_OK;
}

std::size_t styled_save(styled_performer* performer, void* bytes, std::size_t size) {
  if (performer == nullptr) return 0;
  Checkpoint count;
  performer->Carry(count);
  if (bytes != nullptr && size >= count.size()) {
    Checkpoint writer = Checkpoint::Into({static_cast<std::byte*>(bytes), count.size()});
    performer->Carry(writer);
  }
  return count.size();
}

int styled_restore(styled_performer* performer, const void* bytes, std::size_t size) {
  if (performer == nullptr || bytes == nullptr) return STYLED_ERROR_ARGUMENT;
  try {
    performer->Restart();
    Checkpoint reader = Checkpoint::From({static_cast<const std::byte*>(bytes), size});
    performer->Carry(reader);
    if (reader.complete()) return STYLED_OK;
    performer->Restart();  // what has been read in part is of no use
  } catch (const std::bad_alloc&) {
  }
  return STYLED_ERROR_STATE;
}

}  // extern "C"
