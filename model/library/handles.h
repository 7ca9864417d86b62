#pragma once

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <exception>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "model/base/checkpoint.h"
#include "model/base/status.h"
#include "model/clip/clip.h"
#include "model/library/styled.h"
#include "model/net/licence.h"
#include "model/net/stylizer.h"
#include "model/rig/bind_body.h"
#include "model/stylist/settings.h"
#include "model/stylist/stylist.h"

// The library's types, and what its sources share. Names of C are those of styled.h.

namespace styled::library {
inline constexpr std::uint64_t kStateVersion = 1;  // of styled_save
}

struct styled_network {
  std::shared_ptr<const styled::net::Stylizer> stylizer;
  std::uint64_t hash;                 // of the file, the precision, and the styles of styled_like
  styled::net::Terms terms;           // of the file
  std::vector<std::uint64_t> former;  // hashes of the networks that styled_like began with
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
  std::uint64_t network_hash;
  std::uint64_t identity;  // of the network and the skeleton
  std::int64_t last_ns = 0;
  bool started = false;

  styled_performer(std::shared_ptr<const styled::net::Stylizer> the_network,
                   std::shared_ptr<const styled::rig::Binding> the_binding, std::uint64_t the_hash)
      : network(std::move(the_network)),
        binding(std::move(the_binding)),
        in(binding->skeleton()),
        out(binding->skeleton()) {
    Become(the_hash);
    Restart();
  }
  // A state is for a performer of this network and this skeleton alone.
  void Become(std::uint64_t hash);
  void Restart() {
    styled::stylist::Stylist fresh(network, binding, styled::stylist::Options{});  // may throw
    stylist = std::move(fresh);
    started = false;
  }
  void Carry(styled::Checkpoint& c) noexcept {
    c.Same(styled::library::kStateVersion);
    c.Same(identity);
    stylist->Carry(c);
    c.Time(last_ns);
    c(started);
  }
};

struct styled_clip {
  styled::clip::Clip clip;
  std::shared_ptr<const styled::rig::Binding> binding;
  // The arrays of styled_clip_body, made of these two.
  std::vector<const char*> names;
  std::vector<std::int32_t> parents;
  std::vector<float> offsets, rest;
  std::vector<std::string> joint_texts;
  std::vector<const char*> joints;
  styled_body body;
};

namespace styled::library {

inline void Explain(const std::string& what, char* error, std::size_t size) {
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

// A body that was checked as far as its struct goes, and the joints given by hand.
struct Described {
  rig::RigBody body;
  rig::JointNames joints;
};
Result<Described> ReadBody(const styled_body* body);
// A list that ends with NULL; NULL is an empty one.
Result<rig::JointNames> ReadJoints(const char* const* joints);

// The settings that a mix makes for a network; empty if they are not valid.
std::optional<stylist::Settings> ReadMix(const net::Stylizer& network, const std::int32_t* styles,
                                         const float* weights, int count, float transition_s);

}  // namespace styled::library
