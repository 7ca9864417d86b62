#include "clients/nats/recordings.h"

#include <algorithm>
#include <chrono>
#include <cstdlib>
#include <thread>
#include <utility>

#include "clients/nats/subject.h"

namespace styled::stylenats {
namespace {

using std::chrono::milliseconds;
using Steady = std::chrono::steady_clock;

constexpr std::int64_t kWaitForApi_ms = 5000;
constexpr milliseconds kRefusalComes(3000);  // a broker's second refusal of the login
constexpr milliseconds kLookAgain(50);
constexpr double kHour_ns = 3600e9;
constexpr std::string_view kEverybody = "styled.*.*.";
// For which the broker looks for messages that come twice: it cannot be more than the age of the
// oldest, and no bridge sends ids by which it would know.
constexpr std::int64_t kUnused_ns = 100'000'000;

template <auto kDestroy>
struct Destroys {
  template <typename T>
  void operator()(T* object) const {
    kDestroy(object);
  }
};
using StreamInfo = std::unique_ptr<jsStreamInfo, Destroys<jsStreamInfo_Destroy>>;

const std::string& StreamName() {
  static const std::string name(kRecordings);
  return name;
}

}  // namespace

Result<std::unique_ptr<Recordings>> Recordings::Open(const LinkOptions& options,
                                                     const std::string& domain) {
  auto link = Link::Open(options);
  if (!link.ok()) return link.status();
  std::unique_ptr<Recordings> recordings(new Recordings());
  recordings->link_ = std::move(link.value());
  recordings->brokers_ = BrokersText(options);
  recordings->domain_ = domain;
  const auto end = Steady::now() + kRefusalComes;
  while (!recordings->link_->connected()) {
    for (const LinkEvent& event : recordings->link_->Events()) {
      if (event.kind == LinkEvent::Kind::kAbsent) {
        return Status::Error("no broker answers at " + recordings->brokers_);
      }
      if (event.kind != LinkEvent::Kind::kClosed) continue;
      return Status::Error("the broker at " + recordings->brokers_ + " refuses the connection: " +
                           event.text + "; expected a login that it knows (--nats-login FILE)");
    }
    if (Steady::now() > end) return Status::Error("no broker answers at " + recordings->brokers_);
    std::this_thread::sleep_for(kLookAgain);
  }
  jsOptions js;
  jsOptions_Init(&js);
  js.Wait = kWaitForApi_ms;
  if (!domain.empty()) js.Domain = recordings->domain_.c_str();
  const natsStatus status =
      natsConnection_JetStream(&recordings->jetstream_, recordings->link_->get(), &js);
  if (status != NATS_OK) return recordings->Explain(status, {});
  return recordings;
}

Recordings::~Recordings() { jsCtx_Destroy(jetstream_); }

Status Recordings::Explain(natsStatus status, jsErrCode code) {
  const char* const detail = nats_GetLastError(nullptr);
  const std::string says = std::string(natsStatus_GetText(status)) +
                           (detail != nullptr && *detail != '\0' ? std::string(": ") + detail : "");
  const std::string at = brokers_ + ": ";
  // A forbidden request has no answer; that it is forbidden is said apart.
  for (const LinkEvent& event : link_->Events()) {
    if (event.kind != LinkEvent::Kind::kError) continue;
    return Status::Error(at + event.text + "; expected the login of a user who may");
  }
  if (!link_->connected()) return Status::Error(at + "lost the broker (" + says + ")");
  switch (code) {
    case JSStreamNotFoundErr:
      return Status::Error(at + "there is no recording (stream " + StreamName() +
                           "); `stylerec jetstream create` begins one");
    case JSStorageResourcesExceededErr:
    case JSInsufficientResourcesErr:
    case JSAccountResourcesExceededErr:
      return Status::Error(at + "the server keeps no room for that much (" + says +
                           "); expected fewer --max-gb, or more max_file in its configuration");
    case JSStreamSubjectOverlapErr:
      return Status::Error(at + "another stream records these subjects already (" + says + ")");
    default:
      break;
  }
  if (status == NATS_NO_RESPONDERS || code == JSNotEnabledErr ||
      code == JSNotEnabledForAccountErr) {
    return Status::Error(at + "no JetStream answers" +
                         (domain_.empty() ? "" : " in the domain " + domain_) + " (" + says +
                         "); expected a server with jetstream {}, and --domain NAME where that "
                         "server is behind a leaf server");
  }
  return Status::Error(at + says);
}

Result<bool> Recordings::Create(const RecordingLimits& limits) {
  std::vector<std::string> subjects;
  for (const std::string& stream : limits.streams) {
    subjects.push_back(std::string(kEverybody) + Escape(stream));
    subjects.push_back(subjects.back() + ".body");
  }
  std::vector<const char*> texts;
  for (const std::string& subject : subjects) texts.push_back(subject.c_str());
  jsStreamConfig config;
  jsStreamConfig_Init(&config);
  config.Name = StreamName().c_str();
  config.Description = "styled: frames and bodies";
  config.Subjects = texts.data();
  config.SubjectsLen = static_cast<int>(texts.size());
  config.Storage = js_FileStorage;
  config.Retention = js_LimitsPolicy;
  config.Discard = js_DiscardOld;
  config.MaxBytes = static_cast<std::int64_t>(limits.gigabytes * 1e9);
  config.MaxAge = static_cast<std::int64_t>(limits.hours * kHour_ns);
  config.Duplicates = std::min(config.MaxAge, kUnused_ns);
  config.NoAck = true;  // a bridge waits for none
  jsErrCode code{};
  natsStatus status = js_AddStream(nullptr, jetstream_, &config, nullptr, &code);
  if (status == NATS_OK) return true;
  if (code != JSStreamNameExistErr) return Explain(status, code);
  status = js_UpdateStream(nullptr, jetstream_, &config, nullptr, &code);
  if (status != NATS_OK) return Explain(status, code);
  return false;
}

Result<RecordingState> Recordings::Look() {
  jsOptions options;
  jsOptions_Init(&options);
  options.Stream.Info.SubjectsFilter = "styled.>";
  jsStreamInfo* raw = nullptr;
  jsErrCode code{};
  const natsStatus status =
      js_GetStreamInfo(&raw, jetstream_, StreamName().c_str(), &options, &code);
  const StreamInfo info(raw);
  if (status != NATS_OK) return Explain(status, code);
  RecordingState state;
  for (int i = 0; i < info->Config->SubjectsLen; ++i) {
    state.subjects.emplace_back(info->Config->Subjects[i]);
  }
  state.max_bytes = info->Config->MaxBytes;
  state.max_age_ns = info->Config->MaxAge;
  state.messages = info->State.Msgs;
  state.bytes = info->State.Bytes;
  state.first_ns = info->State.FirstTime;
  state.last_ns = info->State.LastTime;
  const jsStreamStateSubjects* const subjects = info->State.Subjects;
  for (int i = 0; subjects != nullptr && i < subjects->Count; ++i) {
    state.recorded[subjects->List[i].Subject] = subjects->List[i].Msgs;
  }
  return state;
}

Status Recordings::Delete() {
  jsErrCode code{};
  const natsStatus status = js_DeleteStream(jetstream_, StreamName().c_str(), nullptr, &code);
  return status == NATS_OK ? Status::Ok() : Explain(status, code);
}

}  // namespace styled::stylenats
