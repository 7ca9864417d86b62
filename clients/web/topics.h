#pragma once

#include <cstdint>
#include <optional>
#include <string_view>

namespace styled::web {

// What the daemon publishes (proto/styled/v1/WIRE.md).
enum class TopicKind : std::uint8_t {
  kStyled,      // "styled/<performer>/rig/", "styled/<performer>/canonical/"
  kSource,      // "source/<performer>/"
  kBody,        // "body/<performer>/"
  kEveryBody,   // "body/": a prefix, of everyone's body; nothing is published under it itself
  kStatistics,  // "stats/"
};

// The kind of `topic`; nothing where it is none of those above, so that a browser cannot subscribe
// to prefixes of its own making. Any thread; allocates nothing.
std::optional<TopicKind> ParseTopic(std::string_view topic) noexcept;

inline constexpr std::string_view kEveryBodyTopic = "body/";
inline constexpr std::string_view kStatisticsTopic = "stats/";

}  // namespace styled::web
