#include "daemon/styles/style_requests.h"

#include <array>
#include <chrono>
#include <cstdio>
#include <limits>
#include <set>
#include <utility>
#include <vector>

#include "daemon/styles/library.h"
#include "daemon/styles/like.h"
#include "daemon/styles/style_file.h"
#include "daemon/styles/style_list.h"
#include "model/base/hash.h"
#include "model/base/text.h"

namespace styled::pipeline {
namespace {

// The time limit for reading an example. The longest accepted one, 7 MB of BVH, took 0.3 s beside
// four builds. A longer one would delay the requests behind it.
constexpr std::chrono::milliseconds kLongestRead(2000);

// The most bytes that are stored of a clip's example. A take is stored completely.
std::size_t MostKept(const v1::Like& like) {
  constexpr std::size_t kAllowance = std::size_t{64} << 10U;
  return like.clip().empty() ? std::numeric_limits<std::size_t>::max()
                             : 2 * like.clip().size() + kAllowance;
}

Status NotKept(const Status& status) {
  return Refused(v1::CODE_NOT_KEPT, "style.library: " + status.message() + "; nothing was changed");
}

Status Export(const RuntimeConfig& running, const v1::ExportStyle& wanted, v1::StyleFile& file) {
  std::shared_ptr<const MadeStyle> style;
  if (Status status = FindMade(running, wanted.name(), style); !status.ok()) return status;
  file.set_name(style->name);
  file.set_file(FormatStyleFile(*style, running));
  return Status::Ok();
}

}  // namespace

bool IsStyleRequest(const v1::Request& request) {
  switch (request.command_case()) {
    case v1::Request::kLike:
      return request.like().learn_s() == 0;
    case v1::Request::kPreview:
    case v1::Request::kExportStyle:
    case v1::Request::kImportStyle:
    case v1::Request::kRenameStyle:
    case v1::Request::kRemoveStyle:
      return true;
    default:
      return false;
  }
}

std::shared_ptr<const RuntimeConfig> StyleRequests::Do(const RuntimeConfig& running,
                                                       Exchange& exchange) {
  log_line_.clear();
  error_.clear();
  exchange.reply.set_id(exchange.request.id());
  Outcome outcome = Execute(running, exchange);
  if (outcome.ok()) return std::move(outcome.value());
  exchange.reply.clear_preview();
  exchange.reply.clear_style_file();
  FillReply(outcome.status(), exchange.reply);
  return nullptr;
}

StyleRequests::Outcome StyleRequests::Execute(const RuntimeConfig& running, Exchange& exchange) {
  const auto named = [](const char* command, const Outcome& outcome) {
    return outcome.ok() ? outcome : Outcome(Of(command, outcome.status()));
  };
  const auto only = [](const Status& status) {
    return status.ok() ? Outcome(nullptr) : Outcome(status);
  };
  if (exchange.places) return Arrange(running, exchange);
  const v1::Request& request = exchange.request;
  v1::Reply& reply = exchange.reply;
  switch (request.command_case()) {
    case v1::Request::kLike:
      return named(request.like().has_design() ? "design" : "like", Make(running, exchange));
    case v1::Request::kImportStyle:
      return named("import", Import(running, exchange));
    case v1::Request::kRenameStyle:
      return named("rename", Rename(running, exchange));
    case v1::Request::kRemoveStyle:
      return named("remove", Remove(running, exchange));
    case v1::Request::kExportStyle:
      return named("export",
                   only(Export(running, request.export_style(), *reply.mutable_style_file())));
    default:
      return named("preview", only(previews_.Make(running, request.preview().style(),
                                                  *reply.mutable_preview())));
  }
}

StyleRequests::Outcome StyleRequests::Arrange(const RuntimeConfig& running, Exchange& exchange) {
  auto made = std::make_shared<RuntimeConfig>(running);
  if (Status status = ArrangeStyles(*exchange.places, *made); !status.ok()) return status;
  return Outcome(std::move(made));
}

namespace {

// The name of a performer's style by hand: "by-hand-rig-anna". Long ones end in a hash, so that two
// performers never share one.
std::string NameByHand(const std::string& performer) {
  std::string name = "by-hand";
  if (performer != "*" && !performer.empty()) name += "-" + performer;
  for (char& c : name) {
    if (!config::IsName(std::string(1, c)) && c != '-') c = '-';
  }
  if (name.size() <= net::kMaxStyleName) return name;
  std::array<char, 16> hash{};
  std::snprintf(hash.data(), hash.size(), "-%08x", static_cast<unsigned>(HashOf(performer)));
  return name.substr(0, net::kMaxStyleName - 9) + hash.data();
}

}  // namespace

StyleRequests::Outcome StyleRequests::Make(const RuntimeConfig& running, Exchange& exchange) {
  v1::Like& like = *exchange.request.mutable_like();
  if (like.learn_s() != 0 && like.file().empty()) like.set_file(exchange.request.performer());
  if (like.has_design() && like.name().empty()) {
    like.set_name(NameByHand(exchange.request.performer()));
  }
  const bool by_hand = like.has_design();
  const std::size_t most_bytes = MostKept(like);
  std::vector<body::Pose> example;
  const auto limit = WorkLimit::Within(
      kLongestRead, "a clip of at most " + NumberText(clip::kLongestExample_s) + " s");
  v1::LikeReply& reply = *exchange.reply.mutable_like();
  const auto added = AddStyle(running, like, exchange.take, reply, &example, limit);
  if (!added.ok()) {
    exchange.reply.clear_like();
    return added.status();
  }
  const std::shared_ptr<RuntimeConfig>& made = added.value();
  if (made == nullptr) return Outcome(nullptr);
  // A slider that moves would be a line for each of its places.
  if (!by_hand) {
    log_line_ = "style " + reply.name() + " made from an example; nearest to " + reply.nearest() +
                ", at " + NumberText(reply.distance(), 2) + " of the distance of styles";
  }
  if (made->style.library.empty()) {
    // A slider's style is there again as soon as it moves.
    if (!by_hand) reply.add_weak("without a library (style.library) it ends with the daemon");
    return Outcome(made);
  }
  const std::string text =
      ExampleText(example, static_cast<double>(made->network->model().rate_hz), most_bytes);
  MadeStyle style = *made->made.at(reply.name());
  if (!text.empty()) style.example = HashOfExample(text);
  made->made[reply.name()] = std::make_shared<const MadeStyle>(std::move(style));
  // The first place of a slider is written at once, so that a crash loses no style.
  if (by_hand && !designed_.insert(reply.name()).second) {
    KeepLater(reply.name());
  } else {
    Keep(reply.name(), text, *made);
  }
  if (!error_.empty()) reply.add_weak("not in the library: it will not survive a restart");
  return Outcome(made);
}

void StyleRequests::KeepLater(const std::string& name) {
  moved_at_ = std::chrono::steady_clock::now();
  if (moved_.empty()) first_moved_at_ = moved_at_;
  moved_.insert(name);
}

void StyleRequests::Keep(const std::string& name, const std::string& example,
                         RuntimeConfig& config) {
  const Status kept = KeepStyle(name, example, config);
  if (kept.ok()) return;
  error_ = "style.library: " + kept.message() + "; the style will not survive a restart";
}

std::shared_ptr<const RuntimeConfig> StyleRequests::KeepMoved(const RuntimeConfig& running,
                                                              bool now) {
  error_.clear();
  if (moved_.empty()) return nullptr;
  const auto time = std::chrono::steady_clock::now();
  if (!now && time - moved_at_ < kRest && time - first_moved_at_ < kLongest) return nullptr;
  auto kept = std::make_shared<RuntimeConfig>(running);
  for (const std::string& name : std::exchange(moved_, {})) {
    if (kept->made.contains(name)) Keep(name, "", *kept);
  }
  return kept;
}

StyleRequests::Outcome StyleRequests::Import(const RuntimeConfig& running, Exchange& exchange) {
  const v1::ImportStyle& wanted = exchange.request.import_style();
  auto read = ParseStyleFile(wanted.file(), "the file", running);
  if (!read.ok()) return Malformed(read.status().message());
  MadeStyle& style = read.value();
  if (!wanted.name().empty()) style.name = wanted.name();
  const std::string name = style.name;
  Place place;
  if (Status status = CheckNewName(name); !status.ok()) return status;
  if (Status status = FindPlace(running, name, place); !status.ok()) return status;
  if (place.replaced >= 0 && !wanted.replace()) {
    return Malformed("name \"" + name +
                     "\": a style that was made has it; expected another name, or replace");
  }
  auto made = std::make_shared<RuntimeConfig>(running);
  if (Status status = PutStyle(std::move(style), *made, wanted.in_place()); !status.ok()) {
    return status;
  }
  if (wanted.in_place()) {
    KeepLater(name);
  } else if (const Status kept = KeepStyle(name, "", *made); !kept.ok()) {
    return NotKept(kept);
  }
  Describe(*made->network->space(), *made->made.at(name), *exchange.reply.mutable_like());
  log_line_ = "style " + name + " imported";
  return Outcome(std::move(made));
}

StyleRequests::Outcome StyleRequests::Rename(const RuntimeConfig& running, Exchange& exchange) {
  v1::RenameStyle& wanted = *exchange.request.mutable_rename_style();
  std::shared_ptr<const MadeStyle> style;
  auto made = std::make_shared<RuntimeConfig>(running);
  if (Status status = FindMade(running, wanted.name(), style); !status.ok()) return status;
  if (Status status = RenameStyle(*style, wanted.to(), *made); !status.ok()) return status;
  if (const Status kept = KeepRenamed(style->name, wanted.to(), *made); !kept.ok()) {
    return NotKept(kept);
  }
  wanted.set_name(style->name);  // spelled as in looks
  designed_.erase(style->name);
  log_line_ = "style " + style->name + " is called " + wanted.to() + " now";
  return Outcome(std::move(made));
}

StyleRequests::Outcome StyleRequests::Remove(const RuntimeConfig& running, Exchange& exchange) {
  v1::RemoveStyle& wanted = *exchange.request.mutable_remove_style();
  std::shared_ptr<const MadeStyle> style;
  auto made = std::make_shared<RuntimeConfig>(running);
  if (Status status = FindMade(running, wanted.name(), style); !status.ok()) return status;
  if (Status status = RemoveStyle(*style, *made); !status.ok()) return status;
  if (const Status kept = KeepRemoved(style->name, *made); !kept.ok()) return NotKept(kept);
  wanted.set_name(style->name);
  designed_.erase(style->name);
  log_line_ = "style " + style->name + " removed";
  return Outcome(std::move(made));
}

}  // namespace styled::pipeline
