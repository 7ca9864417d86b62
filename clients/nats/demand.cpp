#include "clients/nats/demand.h"

#include <algorithm>
#include <vector>

#include "clients/nats/subject.h"

namespace styled::stylenats {
namespace {

constexpr std::string_view kStyled = "styled/";

std::vector<std::string_view> Tokens(std::string_view text) {
  std::vector<std::string_view> tokens;
  for (;;) {
    const std::size_t dot = text.find('.');
    tokens.push_back(text.substr(0, dot));
    if (dot == std::string_view::npos) return tokens;
    text.remove_prefix(dot + 1);
  }
}

// The name in an escaped token. Empty if the token is not valid in a topic.
std::string Name(std::string_view token) {
  std::string name = Unescape(token).value_or("");
  return name.find('/') == std::string::npos ? name : "";
}

}  // namespace

std::set<std::string> Demand::Subjects() const {
  const std::string all = "styled." + Escape(site_) + ".*.*";
  std::set<std::string> performers, streams;
  for (const std::string& topic : topics_) {
    const std::string_view text = topic;
    if (kStyled.starts_with(text)) return {all};
    if (!text.starts_with(kStyled)) continue;
    const std::size_t slash = text.find('/', kStyled.size());
    if (slash == std::string_view::npos) return {all};  // the beginning of some names
    const std::string_view performer = text.substr(kStyled.size(), slash - kStyled.size());
    const std::string_view stream = text.substr(slash + 1);
    if (stream.ends_with('/')) {
      streams.insert(FrameSubject(site_, performer, stream.substr(0, stream.size() - 1)));
    } else {
      performers.insert("styled." + Escape(site_) + "." + Escape(performer) + ".*");
    }
  }
  std::erase_if(streams, [&performers](const std::string& subject) {
    return performers.contains(subject.substr(0, subject.rfind('.') + 1) + "*");
  });
  performers.merge(streams);
  if (performers.size() > kMostSubjects) return {all};
  return performers;
}

bool Demand::IsSubscribed(std::string_view topic) const {
  return std::ranges::any_of(
      topics_, [topic](const std::string& wanted) { return topic.starts_with(wanted); });
}

std::string TopicOf(std::string_view subject) {
  const auto tokens = Tokens(subject);
  if (tokens.size() != 4 || tokens[0] != "styled") return "";
  const std::string performer = Name(tokens[2]), stream = Name(tokens[3]);
  if (performer.empty() || stream.empty() || stream == kAudienceStream) return "";
  return std::string(kStyled) + performer + "/" + stream + "/";
}

std::string BodyTopicOf(std::string_view key) {
  const auto tokens = Tokens(key);
  if (tokens.size() != 4 || tokens[1] != "body") return "";
  const std::string performer = Name(tokens[2]);
  return performer.empty() ? "" : "body/" + performer + "/";
}

}  // namespace styled::stylenats
