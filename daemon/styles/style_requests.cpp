#include "daemon/styles/style_requests.h"

#include <chrono>
#include <limits>
#include <utility>
#include <vector>

#include "daemon/styles/library.h"
#include "daemon/styles/like.h"
#include "daemon/styles/style_file.h"
#include "daemon/styles/style_list.h"
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

Refusal NotKept(const Status& status) {
  return {v1::CODE_NOT_KEPT, "style.library: " + status.message() + "; nothing was changed"};
}

void Export(const RuntimeConfig& running, const v1::ExportStyle& wanted, v1::Reply& reply) {
  std::shared_ptr<const MadeStyle> style;
  if (!FindMade(running, wanted.name(), style).Accept("export", reply)) return;
  reply.mutable_style_file()->set_name(style->name);
  reply.mutable_style_file()->set_file(FormatStyleFile(*style, running));
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
  if (exchange.places) return Arrange(running, exchange);
  switch (exchange.request.command_case()) {
    case v1::Request::kLike:
      return Make(running, exchange);
    case v1::Request::kImportStyle:
      return Import(running, exchange);
    case v1::Request::kRenameStyle:
      return Rename(running, exchange);
    case v1::Request::kRemoveStyle:
      return Remove(running, exchange);
    case v1::Request::kExportStyle:
      Export(running, exchange.request.export_style(), exchange.reply);
      return nullptr;
    default:
      previews_.Make(running, exchange.request.preview().style(), exchange.reply);
      return nullptr;
  }
}

std::shared_ptr<const RuntimeConfig> StyleRequests::Arrange(const RuntimeConfig& running,
                                                            Exchange& exchange) {
  auto made = std::make_shared<RuntimeConfig>(running);
  const Refusal refusal = ArrangeStyles(*exchange.places, *made);
  exchange.reply.set_code(refusal.ok() ? v1::CODE_OK : refusal.code);
  exchange.reply.set_reason(refusal.reason);
  return refusal.ok() ? made : nullptr;
}

std::shared_ptr<const RuntimeConfig> StyleRequests::Make(const RuntimeConfig& running,
                                                         Exchange& exchange) {
  v1::Like& like = *exchange.request.mutable_like();
  if (like.learn_s() != 0 && like.file().empty()) like.set_file(exchange.request.performer());
  const std::size_t most_bytes = MostKept(like);
  std::vector<body::Pose> example;
  const auto limit =
      WorkLimit::Within(kLongestRead, "a clip of at most " + NumberText(kLongestExample_s) + " s");
  const auto made = AddStyle(running, like, exchange.take, exchange.reply, &example, limit);
  if (made == nullptr) return nullptr;
  const v1::LikeReply& reply = exchange.reply.like();
  log_line_ = "style " + reply.name() + " made from an example; nearest to " + reply.nearest() +
              ", at " + NumberText(reply.distance(), 2) + " of the distance of styles";
  if (made->style.library.empty()) return made;
  const std::string text =
      ExampleText(example, static_cast<double>(made->network->model().rate_hz), most_bytes);
  MadeStyle style = *made->made.at(reply.name());
  if (!text.empty()) style.example = HashOfExample(text);
  made->made[reply.name()] = std::make_shared<const MadeStyle>(std::move(style));
  const Status kept = KeepStyle(reply.name(), text, *made);
  if (!kept.ok()) {
    error_ = "style.library: " + kept.message() + "; the style will not survive a restart";
  }
  return made;
}

std::shared_ptr<const RuntimeConfig> StyleRequests::Import(const RuntimeConfig& running,
                                                           Exchange& exchange) {
  constexpr const char* kCommand = "import";
  v1::Reply& reply = exchange.reply;
  const v1::ImportStyle& wanted = exchange.request.import_style();
  auto read = ParseStyleFile(wanted.file(), "the file", running);
  if (!read.ok()) {
    (void)Malformed(read.status().message()).Accept(kCommand, reply);
    return nullptr;
  }
  MadeStyle& style = read.value();
  if (!wanted.name().empty()) style.name = wanted.name();
  const std::string name = style.name;
  Place place;
  if (!CheckNewName(name).Accept(kCommand, reply) ||
      !FindPlace(running, name, place).Accept(kCommand, reply)) {
    return nullptr;
  }
  if (place.replaced >= 0 && !wanted.replace()) {
    (void)Malformed("name \"" + name +
                    "\": a style that was made has it; expected another name, or replace")
        .Accept(kCommand, reply);
    return nullptr;
  }
  auto made = std::make_shared<RuntimeConfig>(running);
  if (!PutStyle(std::move(style), *made).Accept(kCommand, reply)) return nullptr;
  if (const Status kept = KeepStyle(name, "", *made); !kept.ok()) {
    (void)NotKept(kept).Accept(kCommand, reply);
    return nullptr;
  }
  Describe(*made->made.at(name), *reply.mutable_like());
  log_line_ = "style " + name + " imported";
  return made;
}

std::shared_ptr<const RuntimeConfig> StyleRequests::Rename(const RuntimeConfig& running,
                                                           Exchange& exchange) {
  constexpr const char* kCommand = "rename";
  v1::Reply& reply = exchange.reply;
  v1::RenameStyle& wanted = *exchange.request.mutable_rename_style();
  std::shared_ptr<const MadeStyle> style;
  auto made = std::make_shared<RuntimeConfig>(running);
  if (!FindMade(running, wanted.name(), style).Accept(kCommand, reply) ||
      !RenameStyle(*style, wanted.to(), *made).Accept(kCommand, reply)) {
    return nullptr;
  }
  if (const Status kept = KeepRenamed(style->name, wanted.to(), *made); !kept.ok()) {
    (void)NotKept(kept).Accept(kCommand, reply);
    return nullptr;
  }
  wanted.set_name(style->name);  // spelled as in looks
  log_line_ = "style " + style->name + " is called " + wanted.to() + " now";
  return made;
}

std::shared_ptr<const RuntimeConfig> StyleRequests::Remove(const RuntimeConfig& running,
                                                           Exchange& exchange) {
  constexpr const char* kCommand = "remove";
  v1::Reply& reply = exchange.reply;
  v1::RemoveStyle& wanted = *exchange.request.mutable_remove_style();
  std::shared_ptr<const MadeStyle> style;
  auto made = std::make_shared<RuntimeConfig>(running);
  if (!FindMade(running, wanted.name(), style).Accept(kCommand, reply) ||
      !RemoveStyle(*style, *made).Accept(kCommand, reply)) {
    return nullptr;
  }
  if (const Status kept = KeepRemoved(style->name, *made); !kept.ok()) {
    (void)NotKept(kept).Accept(kCommand, reply);
    return nullptr;
  }
  wanted.set_name(style->name);
  log_line_ = "style " + style->name + " removed";
  return made;
}

}  // namespace styled::pipeline
