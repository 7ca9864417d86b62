#include "clients/web/topics.h"

#include "clients/cpp/subscriber.h"

namespace styled::web {
namespace {

bool IsAbout(std::string_view topic, std::string_view prefix, std::string_view suffix) noexcept {
  if (topic.size() <= prefix.size() + suffix.size()) return false;
  if (!topic.starts_with(prefix) || !topic.ends_with(suffix)) return false;
  topic.remove_prefix(prefix.size());
  topic.remove_suffix(suffix.size());
  return client::IsPerformerId(topic);
}

}  // namespace

std::optional<TopicKind> ParseTopic(std::string_view topic) noexcept {
  if (topic == kStatisticsTopic) return TopicKind::kStatistics;
  if (topic == kEveryBodyTopic) return TopicKind::kEveryBody;
  if (IsAbout(topic, "body/", "/")) return TopicKind::kBody;
  if (IsAbout(topic, "source/", "/")) return TopicKind::kSource;
  if (IsAbout(topic, "styled/", "/rig/") || IsAbout(topic, "styled/", "/canonical/")) {
    return TopicKind::kStyled;
  }
  return std::nullopt;
}

}  // namespace styled::web
