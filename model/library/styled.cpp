#include "model/library/styled.h"

#include <algorithm>
#include <cstring>
#include <exception>
#include <functional>
#include <memory>
#include <new>
#include <optional>
#include <span>
#include <string>

#include "model/base/checkpoint.h"
#include "model/base/flush_subnormals.h"
#include "model/base/hash.h"
#include "model/base/read_file.h"
#include "model/net/shipped_weights.h"
#include "model/rig/bind_body.h"
#include "model/stylist/stylist.h"
#include "model/trial/trial.h"

using styled::Checkpoint;
using styled::FlushSubnormals;
using styled::Result;
using styled::Status;

namespace {
constexpr std::uint64_t kStateVersion = 1;  // of styled_save
}

struct styled_network {
  std::shared_ptr<const styled::net::Stylizer> stylizer;
  std::uint64_t hash;  // of the file and the precision
  const styled::net::Styles& styles() const { return stylizer->model().styles; }
  const styled::net::StyleInfo* Find(int style) const {
    const bool known = style >= 0 && static_cast<std::size_t>(style) < styles().size();
    return known ? &styles()[static_cast<std::size_t>(style)] : nullptr;
  }
};

struct styled_performer {
  std::shared_ptr<const styled::net::Stylizer> network;
  std::shared_ptr<const styled::rig::Binding> binding;
  std::optional<styled::stylist::Stylist> stylist;
  styled::rig::RigPose in;
  styled::stylist::Output out;
  std::uint64_t identity;  // of the weights, their precision and the skeleton
  std::int64_t last_ns = 0;
  bool started = false;

  styled_performer(std::shared_ptr<const styled::net::Stylizer> the_network,
                   std::shared_ptr<const styled::rig::Binding> the_binding,
                   std::uint64_t the_identity)
      : network(std::move(the_network)),
        binding(std::move(the_binding)),
        in(binding->skeleton()),
        out(binding->skeleton()),
        identity(the_identity) {
    Restart();
  }
  void Restart() {
    styled::stylist::Stylist fresh(network, binding, styled::stylist::Options{});  // may throw
    stylist = std::move(fresh);
    started = false;
  }
  void Carry(Checkpoint& c) noexcept {
    c.Same(kStateVersion);
    c.Same(identity);
    stylist->Carry(c);
    c.Time(last_ns);
    c(started);
  }
};

namespace {

void Explain(const std::string& what, char* error, std::size_t size) {
  if (error == nullptr || size == 0) return;
  const std::size_t length = std::min(what.size(), size - 1);
  std::memcpy(error, what.data(), length);
  error[length] = '\0';
}

// No exception leaves the library: what is left are failed allocations.
template <typename Made>
Made* Guarded(char* error, std::size_t size, const std::function<Result<Made*>()>& make) noexcept {
  try {
    auto made = make();
    if (made.ok()) return made.value();
    Explain(made.status().message(), error, size);
  } catch (const std::exception& failure) {
    Explain(failure.what(), error, size);
  }
  return nullptr;
}

Result<styled_network*> Load(const char* weights, const std::string& precision) {
  const auto& known = styled::net::kPrecisions;
  if (std::ranges::find(known, precision) == known.end()) {
    return Status::Error("precision: found \"" + precision + "\", expected int8 or float32");
  }
  const auto file = styled::net::FindWeights(weights == nullptr ? "" : weights);
  if (!file.ok()) return file.status();
  auto network = styled::trial::Load(file.value(), styled::net::PrecisionNamed(precision));
  if (!network.ok()) return network.status();
  const auto bytes = styled::ReadFile(file.value().string(), std::size_t{1} << 30);
  if (!bytes.ok()) return bytes.status();
  styled::Fnv1a hash;
  hash.Text(bytes.value());
  hash.Text(precision);
  return new styled_network{std::move(network.value()), hash.value()};
}

// A state is for a performer of this network and this skeleton alone.
std::uint64_t Identity(std::uint64_t network, const styled::rig::BindingSpec& spec) {
  styled::Fnv1a hash;
  hash.Bytes(&network, sizeof network);
  for (std::size_t j = 0; j < spec.skeleton.names.size(); ++j) {
    hash.Text(spec.skeleton.names[j]);
    hash.Byte(0);
    hash.Number(spec.skeleton.parents[j]);
    hash.Bytes(spec.skeleton.offsets[j].data(), 3 * sizeof(float));
    hash.Bytes(spec.rest_rotations[j].coeffs().data(), 4 * sizeof(float));
  }
  return hash.value();
}

Result<styled_performer*> Create(const styled_network* network, const styled_body* body) {
  if (network == nullptr || body == nullptr) {
    return Status::Error("found NULL, expected a network and a body");
  }
  if (body->size != sizeof(styled_body)) {
    return Status::Error("body: found size " + std::to_string(body->size) + ", expected " +
                         std::to_string(sizeof(styled_body)));
  }
  if (body->joint_count < 1 || body->joint_count > styled::rig::kMaxSourceJoints) {
    return Status::Error("body: found " + std::to_string(body->joint_count) +
                         " joints, expected 1 to " + std::to_string(styled::rig::kMaxSourceJoints));
  }
  if (body->names == nullptr || body->parents == nullptr || body->offsets == nullptr) {
    return Status::Error("body: found NULL, expected names, parents and offsets");
  }
  styled::rig::RigBody read;
  for (int j = 0; j < body->joint_count; ++j) {
    if (body->names[j] == nullptr) {
      return Status::Error("body: joint " + std::to_string(j) + ": found NULL, expected a name");
    }
    read.skeleton.names.emplace_back(body->names[j]);
    read.skeleton.parents.push_back(body->parents[j]);
    const float* const offset = body->offsets + std::ptrdiff_t{3} * j;
    read.skeleton.offsets.emplace_back(offset[0], offset[1], offset[2]);
    if (body->rest == nullptr) continue;
    const float* const rest = body->rest + std::ptrdiff_t{4} * j;
    read.rest.emplace_back(rest[3], rest[0], rest[1], rest[2]);
  }
  if (body->dialect != nullptr && *body->dialect != '\0') read.dialect = body->dialect;
  auto bound = styled::rig::BindBody(read);
  if (!bound.ok()) return bound.status();
  return new styled_performer(network->stylizer, bound.value().binding,
                              Identity(network->hash, bound.value().binding->spec()));
}

}  // namespace

extern "C" {

const char* styled_version(void) { return STYLED_VERSION; }

styled_network* styled_load(const char* weights, const char* precision, char* error,
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
  return info->licence.empty() ? network->stylizer->model().licence.c_str() : info->licence.c_str();
}

const char* styled_style_credit(const styled_network* network, int style) {
  const auto* const info = network == nullptr ? nullptr : network->Find(style);
  return info == nullptr ? nullptr : info->credit.c_str();
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
  if (performer == nullptr || count < 0 || count > styled::net::kMaxMix) {
    return STYLED_ERROR_ARGUMENT;
  }
  if (count > 0 && (styles == nullptr || weights == nullptr)) return STYLED_ERROR_ARGUMENT;
  styled::stylist::Settings settings;
  for (int i = 0; i < count; ++i) {
    settings.mix[static_cast<std::size_t>(i)] = {styles[i], weights[i]};
  }
  settings.transition_s = transition_s;
  const auto known = static_cast<int>(performer->network->model().styles.size());
  for (int i = 0; i < count; ++i) {
    if (styles[i] < 0 || styles[i] >= known) return STYLED_ERROR_ARGUMENT;
  }
  if (styled::stylist::Validate(settings, known) != styled::stylist::SettingsError::kNone) {
    return STYLED_ERROR_ARGUMENT;
  }
  performer->stylist->Set(settings);
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
