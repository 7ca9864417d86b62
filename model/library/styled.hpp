// libstyled in C++20, header only: styled.h's handles as objects that release themselves, and its
// errors as exceptions. What the functions do, their ranges, threads and allocation are in
// styled.h. example.cpp shows a program. Pinned by tests/unit/library/example.sh.
#ifndef STYLED_LIBRARY_STYLED_HPP
#define STYLED_LIBRARY_STYLED_HPP

#include <styled.h>

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

namespace styled::library {

// The text is the library's sentence.
class Error : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

struct Weighted {
  int style;
  float weight = 1;
};

// A skeleton; parents precede their children. `rest` may be empty.
struct Body {
  std::vector<std::string> names;
  std::vector<std::int32_t> parents;
  std::vector<std::array<float, 3>> offsets;
  std::vector<std::array<float, 4>> rest;
  std::string dialect;
  std::vector<std::string> joints;  // by hand, "leftUpperArm=LArm"
};

namespace detail {
template <typename T, auto kRelease>
struct Release {
  void operator()(T* handle) const noexcept { kRelease(handle); }
};
template <typename T, auto kRelease>
using Owned = std::unique_ptr<T, Release<T, kRelease>>;

using ErrorText = std::array<char, 4096>;  // a sentence, also where it lists files

// `call` gets a text to write an error to.
template <typename Call>
auto* Made(const Call& call) {
  ErrorText error{};
  auto* const made = call(error.data(), error.size());
  if (made == nullptr) throw Error(error.data());
  return made;
}
template <typename Call>
int Done(const Call& call) {
  ErrorText error{};
  const int done = call(error.data(), error.size());
  if (done < 0) throw Error(error.data());
  return done;
}
inline void Check(int result, const char* what) {
  if (result != STYLED_OK) throw Error(std::string(what) + " (" + std::to_string(result) + ")");
}

// A mix as two arrays.
struct Mix {
  std::vector<std::int32_t> styles;
  std::vector<float> weights;
  explicit Mix(std::span<const Weighted> mix) {
    for (const auto& [style, weight] : mix) {
      styles.push_back(style);
      weights.push_back(weight);
    }
  }
  int count() const { return static_cast<int>(styles.size()); }
};

// A body as styled.h has it; it refers to `body`.
class BodyView {
 public:
  explicit BodyView(const Body& body) {
    if (body.parents.size() != body.names.size() || body.offsets.size() != body.names.size() ||
        (!body.rest.empty() && body.rest.size() != body.names.size())) {
      throw Error("body: expected as many parents, offsets and rests as names");
    }
    for (const auto& name : body.names) names_.push_back(name.c_str());
    for (const auto& joint : body.joints) joints_.push_back(joint.c_str());
    joints_.push_back(nullptr);
    c_.size = sizeof c_;
    c_.joint_count = static_cast<int>(body.names.size());
    c_.names = names_.data();
    c_.parents = body.parents.data();
    c_.offsets = body.offsets.empty() ? nullptr : body.offsets.front().data();
    c_.rest = body.rest.empty() ? nullptr : body.rest.front().data();
    c_.dialect = body.dialect.c_str();
    c_.joints = joints_.data();
  }
  BodyView(const BodyView&) = delete;
  BodyView& operator=(const BodyView&) = delete;
  const styled_body* get() const { return &c_; }

 private:
  std::vector<const char*> names_, joints_;
  styled_body c_{};
};
}  // namespace detail

class Clip;

class Network {
 public:
  // Empty: as styled_load's NULL.
  explicit Network(const std::string& weights = "", const std::string& precision = "")
      : handle_(detail::Made([&](char* error, std::size_t size) {
          return styled_load(weights.empty() ? nullptr : weights.c_str(),
                             precision.empty() ? nullptr : precision.c_str(), error, size);
        })) {}
  std::vector<std::string> Styles() const {
    std::vector<std::string> names;
    for (int style = 0; style < styled_style_count(get()); ++style) {
      names.emplace_back(styled_style_name(get(), style));
    }
    return names;
  }
  // A style's number, by name or alias. Throws where the network has no such style.
  int Find(const std::string& name) const {
    const int style = styled_find_style(get(), name.c_str());
    if (style >= 0) return style;
    std::string known;
    for (const auto& one : Styles()) known += (known.empty() ? "" : ", ") + one;
    throw Error("unknown style '" + name + "', expected one of " + known);
  }
  std::string Licence(int style) const { return Text(styled_style_licence(get(), style)); }
  std::string Credit(int style) const { return Text(styled_style_credit(get(), style)); }
  // The same styles, and last of them `name` as the example shows it.
  Network Like(const std::string& name, const Clip& example, const Clip* neutral = nullptr) const;
  const styled_network* get() const { return handle_.get(); }

 private:
  explicit Network(styled_network* handle) : handle_(handle) {}
  static std::string Text(const char* text) { return text == nullptr ? "" : text; }
  detail::Owned<styled_network, styled_release> handle_;
};

class Clip {
 public:
  static Clip Read(const std::string& file) {
    return Clip(detail::Made([&](char* error, std::size_t size) {
      return styled_read_clip(file.c_str(), nullptr, error, size);
    }));
  }
  // `root` has 3 numbers a frame, `rotations` 4 a joint and frame.
  Clip(const Body& body, double rate_hz, std::span<const float> root,
       std::span<const float> rotations) {
    const detail::BodyView view(body);
    if (rotations.size() != root.size() / 3 * 4 * body.names.size() || root.size() % 3 != 0) {
      throw Error("frames: expected 3 numbers of root and 4 a joint of rotations in each");
    }
    handle_.reset(detail::Made([&](char* error, std::size_t size) {
      return styled_make_clip(view.get(), rate_hz, root.size() / 3, root.data(), rotations.data(),
                              error, size);
    }));
  }
  Clip Copy() const {
    return Clip(detail::Made([&](char*, std::size_t) { return styled_copy_clip(get()); }));
  }
  std::size_t frames() const { return styled_clip_length(get(), nullptr); }
  double rate_hz() const {
    double rate = 0;
    styled_clip_length(get(), &rate);
    return rate;
  }
  const styled_body& body() const { return *styled_clip_body(get()); }
  void Frames(std::vector<float>& root, std::vector<float>& rotations) const {
    root.resize(3 * frames());
    rotations.resize(4 * frames() * static_cast<std::size_t>(body().joint_count));
    detail::Check(styled_clip_frames(get(), root.data(), rotations.data()), "no clip");
  }
  // Returns how many frames are the performer's own because no sound styled pose was found.
  int Restyle(const Network& network, std::span<const Weighted> styles) {
    const detail::Mix mix(styles);
    return detail::Done([&](char* error, std::size_t size) {
      return styled_restyle(network.get(), handle_.get(), mix.styles.data(), mix.weights.data(),
                            mix.count(), error, size);
    });
  }
  int Restyle(const Network& network, const std::string& style) {
    const Weighted one{network.Find(style)};
    return Restyle(network, std::span(&one, one.style == 0 ? 0 : 1));
  }
  void Write(const std::string& file) const {
    detail::Done([&](char* error, std::size_t size) {
      return styled_write_clip(get(), file.c_str(), error, size);
    });
  }
  const styled_clip* get() const { return handle_.get(); }

 private:
  explicit Clip(styled_clip* handle) : handle_(handle) {}
  detail::Owned<styled_clip, styled_free_clip> handle_;
};

inline Network Network::Like(const std::string& name, const Clip& example,
                             const Clip* neutral) const {
  return Network(detail::Made([&](char* error, std::size_t size) {
    return styled_like(get(), name.c_str(), example.get(),
                       neutral == nullptr ? nullptr : neutral->get(), error, size);
  }));
}

class Performer {
 public:
  Performer(const Network& network, const Body& body)
      : Performer(network, *detail::BodyView(body).get()) {}
  Performer(const Network& network, const styled_body& body)
      : handle_(detail::Made([&](char* error, std::size_t size) {
          return styled_create(network.get(), &body, error, size);
        })),
        joints_(static_cast<std::size_t>(body.joint_count)) {}
  void Set(std::span<const Weighted> styles, float transition_s = 0.1F) {
    const detail::Mix mix(styles);
    detail::Check(
        styled_set(handle_.get(), mix.styles.data(), mix.weights.data(), mix.count(), transition_s),
        "styles: expected 0 to 4 different ones but neutral, weights of 0 to 1.5 that sum "
        "to at most 1.5, and a transition of 0 to 60 s");
  }
  // Allocates nothing unless it throws. The spans have 3, 4 a joint, 3, 4 a joint numbers; the
  // results may be written to the input's. Empty for a time that is not after the last frame's.
  std::optional<std::uint32_t> Frame(std::int64_t time_ns, std::span<const float> root,
                                     std::span<const float> rotations, std::span<float> styled_root,
                                     std::span<float> styled_rotations) {
    if (root.size() != 3 || styled_root.size() != 3 || rotations.size() != 4 * joints_ ||
        styled_rotations.size() != 4 * joints_) {
      throw Error("frame: expected 3 numbers of root and 4 a joint of rotations");
    }
    std::uint32_t flags = 0;
    const int result = styled_frame(handle_.get(), time_ns, root.data(), rotations.data(),
                                    styled_root.data(), styled_rotations.data(), &flags);
    if (result == STYLED_ERROR_TIME) return std::nullopt;
    detail::Check(result, "frame: found a time beyond 2^61 ns");
    return flags;
  }
  void Reset() { detail::Check(styled_reset(handle_.get()), "no performer"); }
  void Calibrate(float seconds) {
    detail::Check(styled_calibrate(handle_.get(), seconds), "seconds: expected 0, or 1 to 60");
  }
  void Learn(const Clip& clip) {
    detail::Check(styled_learn(handle_.get(), clip.get()),
                  "found no standing or walking in the clip, or a network without neutral");
  }
  // By a network that Like has made from this one; the motion continues.
  void Adopt(const Network& network) {
    detail::Check(styled_adopt(handle_.get(), network.get()),
                  "network: expected one that Like has made from the performer's");
  }
  std::vector<std::byte> Save() {
    std::vector<std::byte> bytes(styled_save(handle_.get(), nullptr, 0));
    styled_save(handle_.get(), bytes.data(), bytes.size());
    return bytes;
  }
  void Restore(std::span<const std::byte> bytes) {
    detail::Check(styled_restore(handle_.get(), bytes.data(), bytes.size()),
                  "found a state of another network, skeleton or version");
  }

 private:
  detail::Owned<styled_performer, styled_destroy> handle_;
  std::size_t joints_;
};

}  // namespace styled::library

#endif
