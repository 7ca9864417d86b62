// libstyled's styles from examples.
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "model/base/hash.h"
#include "model/base/text.h"
#include "model/clip/bind_clip.h"
#include "model/library/handles.h"
#include "model/library/styled.h"
#include "model/net/load.h"
#include "model/net/style_space.h"

using styled::Result;
using styled::Status;
using styled::library::Guarded;
using styled::net::StyleCode;

namespace {

Status CheckName(const styled_network& network, const char* name) {
  if (name == nullptr || *name == '\0') return Status::Error("name: found none, expected a text");
  const std::string text = name;
  if (text.size() > styled::net::kMaxStyleName || styled::Printable(text, text.size()) != text) {
    return Status::Error("name: expected at most " + std::to_string(styled::net::kMaxStyleName) +
                         " bytes that can be printed");
  }
  if (styled::net::FindStyle(network.styles(), text) < 0) return Status::Ok();
  return Status::Error("name: found \"" + text + "\", which the network has; expected another");
}

// The code of what a clip shows; `what` names the argument.
Result<StyleCode> CodeOf(const styled_clip& clip, const styled::net::Stylizer& network,
                         const char* what) {
  const styled::net::StyleSpace& space = *network.space();
  const auto rate_hz = static_cast<double>(network.model().rate_hz);
  const auto poses = styled::clip::ResamplePoses(
      styled::clip::ToCanonical(clip.clip, *clip.binding), clip.clip.rate_hz, rate_hz);
  const std::string name = what;
  if (static_cast<int>(poses.size()) < space.least_frames()) {
    return Status::Error(name + ": found " + std::to_string(poses.size()) + " frames at " +
                         styled::NumberText(rate_hz) + " Hz, expected at least " +
                         std::to_string(space.least_frames()));
  }
  StyleCode code = space.MakeCode({.sources = {{.style = -1, .seed = {}, .reference = poses}}});
  if (space.IsCode(code)) return code;
  return Status::Error(name + ": found no style in it, expected a walk or a run");
}

Result<styled_network*> Like(const styled_network* network, const char* name,
                             const styled_clip* example, const styled_clip* neutral) {
  if (network == nullptr || example == nullptr) {
    return Status::Error("found NULL, expected a network and an example");
  }
  if (Status named = CheckName(*network, name); !named.ok()) return named;
  const styled::net::Stylizer& stylizer = *network->stylizer;
  const styled::net::StyleSpace* const space = stylizer.space();
  if (space == nullptr) {
    return Status::Error("the weights of family \"" + stylizer.model().family +
                         "\" have no style encoder; expected weights of family " +
                         styled::net::SpaceFamilyNames());
  }
  auto code = CodeOf(*example, stylizer, "example");
  if (!code.ok()) return code.status();
  if (neutral != nullptr) {
    const auto own = CodeOf(*neutral, stylizer, "neutral");
    if (!own.ok()) return own.status();
    code.value() = space->Difference(code.value(), own.value());
    if (!space->IsCode(code.value())) {
      return Status::Error(
          "neutral: found nothing in common with the example; expected a walk or a run in both, or "
          "in neither");
    }
  }
  const StyleCode limited = space->Limited(code.value());
  styled::net::StyleInfo info{.name = name};
  // Of a style that is measured, no number comes from the weights.
  if (space->Portable(limited) == limited) info.licence = "that of the example";
  auto made = stylizer.With(static_cast<int>(network->styles().size()), info, limited);
  styled::Fnv1a hash;
  hash.Bytes(&network->hash, sizeof network->hash);
  hash.Text(info.name);
  hash.Bytes(limited.data(), limited.size() * sizeof(float));
  std::vector<std::uint64_t> former = network->former;
  former.push_back(network->hash);
  return new styled_network{std::move(made), hash.value(), network->terms, std::move(former)};
}

}  // namespace

extern "C" {

styled_network* styled_like(const styled_network* network, const char* name,
                            const styled_clip* example, const styled_clip* neutral, char* error,
                            std::size_t error_size) {
  return Guarded<styled_network>(error, error_size,
                                 [&] { return Like(network, name, example, neutral); });
}

int styled_adopt(styled_performer* performer, const styled_network* network) {
  if (performer == nullptr || network == nullptr) return STYLED_ERROR_ARGUMENT;
  const std::uint64_t own = performer->network_hash;
  if (network->hash == own) return STYLED_OK;
  if (std::ranges::find(network->former, own) == network->former.end()) {
    return STYLED_ERROR_ARGUMENT;
  }
  performer->stylist->Adopt(network->stylizer);
  performer->network = network->stylizer;
  performer->Become(network->hash);
  return STYLED_OK;
}

}  // extern "C"
