#pragma once

#include <cstdint>
#include <optional>
#include <string_view>

namespace styled::web {

// The topics that the daemon publishes (proto/styled/v1/WIRE.md).
enum class TopicKind : std::uint8_t {
  kStyled,      // "styled/<performer>/rig/", "styled/<performer>/canonical/"
  kSource,      // "source/<performer>/"
  kBody,        // "body/<performer>/"
  kEveryBody,   // "body/": a prefix for the bodies of all performers, not a topic of its own
  kStatistics,  // "stats/"
};

// The kind of `topic`; empty for any other text, so that a browser cannot subscribe to arbitrary
// prefixes. Any thread; allocates nothing.
std::optional<TopicKind> ParseTopic(std::string_view topic) noexcept;

inline constexpr std::string_view kEveryBodyTopic = "body/";
inline constexpr std::string_view kStatisticsTopic = "stats/";

}  // namespace styled::web
