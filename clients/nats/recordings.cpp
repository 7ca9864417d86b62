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

constexpr std::int64_t kWaitForApi_ms = 3000;
constexpr milliseconds kRefusalComes(3000);  // a broker's second refusal of the login
constexpr milliseconds kLookAgain(50);
// One request asks for at most a quarter of hub.conf's max_pending, 8 MB: the broker closes a
// connection for which more bytes wait. With a latency of 50 ms that is up to 40 MB/s.
constexpr int kBatchMessages = 2000;
constexpr std::int64_t kBatchBytes = std::int64_t{2} << 20U;
constexpr std::int64_t kBatchWait_ns = 2'000'000'000;
constexpr std::int64_t kIdle_ns = 30'000'000'000;  // until the broker drops a reader that is gone
constexpr auto kBrokerComesBack = std::chrono::seconds(10);
constexpr const char* kFull = "; is its disk full? Make room, and start it again";
constexpr double kHour_ns = 3600e9;
constexpr std::string_view kEverybody = "styled.*.*.";
// The interval in which the broker looks for duplicates. It cannot be more than the age of the
// oldest message, and no bridge sends the ids that it would need.
constexpr std::int64_t kUnused_ns = 100'000'000;

using StreamInfo = std::unique_ptr<jsStreamInfo, Destroys<jsStreamInfo_Destroy>>;
using MetaData = std::unique_ptr<jsMsgMetaData, Destroys<jsMsgMetaData_Destroy>>;

const std::string& StreamName() {
  static const std::string name(kRecordings);
  return name;
}

std::uint64_t Number(natsMsg* message, const char* header) {
  const char* text = nullptr;
  if (natsMsgHeader_Get(message, header, &text) != NATS_OK) return 0;
  return std::strtoull(text, nullptr, 10);
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
  // A forbidden request has no answer; the prohibition is reported separately.
  for (const LinkEvent& event : link_->Events()) {
    if (event.kind != LinkEvent::Kind::kError) continue;
    return Status::Error(at + event.text + "; expected the login of a user with that permission");
  }
  if (!link_->connected()) return Status::Error(at + "lost the broker (" + says + ")" + kFull);
  switch (code) {
    case JSStreamNotFoundErr:
      return Status::Error(at + "there is no recording (stream " + StreamName() +
                           "); `stylerec jetstream create` begins one");
    case JSStorageResourcesExceededErr:
    case JSInsufficientResourcesErr:
    case JSAccountResourcesExceededErr:
      return Status::Error(at + "the server does not reserve that much space (" + says +
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
  if (status == NATS_TIMEOUT) {
    return Status::Error(at + "its JetStream does not answer (" + says + ")" + kFull);
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
  texts.reserve(subjects.size());
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
  config.NoAck = true;  // a bridge does not wait for acknowledgements
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

Result<std::unique_ptr<RecordingReader>> Recordings::Read(const std::string& site,
                                                          const std::string& performer,
                                                          std::int64_t from_ns) {
  const auto state = Look();
  if (!state.ok()) return state.status();
  const std::string of =
      "styled." + Escape(site) + (performer.empty() ? std::string(".*") : "." + Escape(performer));
  std::unique_ptr<RecordingReader> reader(new RecordingReader(*this, from_ns));
  for (const std::string& subject : state.value().subjects) {
    if (!subject.starts_with(kEverybody)) continue;  // another program's
    auto& part = reader->parts_.emplace_back();
    part.filter = of + "." + subject.substr(kEverybody.size());
    Status status = reader->Begin(part);
    if (status.ok()) status = reader->Advance(part);
    if (!status.ok()) return status;
  }
  return reader;
}

// From the beginning, or after the last message that arrived.
Status RecordingReader::Begin(Part& part) {
  natsSubscription_Destroy(std::exchange(part.subscription, nullptr));
  jsConsumerConfig config;
  jsConsumerConfig_Init(&config);
  config.FilterSubject = part.filter.c_str();
  config.DeliverPolicy = part.last > 0 ? js_DeliverByStartSequence : js_DeliverByStartTime;
  config.OptStartSeq = part.last > 0 ? part.last + 1 : 0;
  config.OptStartTime = part.last > 0 ? 0 : std::max<std::int64_t>(from_ns_, 1);
  config.AckPolicy = js_AckNone;
  config.InactiveThreshold = kIdle_ns;
  config.MemoryStorage = true;
  jsConsumerInfo* info = nullptr;
  jsErrCode code{};
  natsStatus status =
      js_AddConsumer(&info, recordings_.jetstream_, StreamName().c_str(), &config, nullptr, &code);
  if (status != NATS_OK) return recordings_.Explain(status, code);
  const std::string consumer = info->Name;
  part.pending = info->NumPending;
  jsConsumerInfo_Destroy(info);
  jsSubOptions options;
  jsSubOptions_Init(&options);
  options.Stream = StreamName().c_str();
  options.Consumer = consumer.c_str();
  options.Config.MemoryStorage = true;
  status = js_PullSubscribe(&part.subscription, recordings_.jetstream_, nullptr, nullptr, nullptr,
                            &options, &code);
  return status == NATS_OK ? Status::Ok() : recordings_.Explain(status, code);
}

RecordingReader::~RecordingReader() {
  for (Part& part : parts_) {
    natsMsgList_Destroy(&part.batch);
    natsSubscription_Destroy(part.subscription);
  }
}

// Some messages; empty if none is left.
Status RecordingReader::Fetch(Part& part) {
  const auto end = Steady::now() + kBrokerComesBack;
  for (;;) {
    natsMsgList_Destroy(&part.batch);
    part.at = 0;
    if (part.pending == 0) return Status::Ok();
    jsFetchRequest request;
    jsFetchRequest_Init(&request);
    request.Batch = static_cast<int>(std::min<std::uint64_t>(part.pending, kBatchMessages));
    request.MaxBytes = kBatchBytes;
    request.Expires = kBatchWait_ns;
    const natsStatus status =
        part.subscription == nullptr
            ? NATS_INVALID_SUBSCRIPTION
            : natsSubscription_FetchRequest(&part.batch, part.subscription, &request);
    if (part.batch.Count > 0) return Status::Ok();
    // Nothing arrived: the broker, or its reader's state, is gone. Another reader continues.
    Status failed = recordings_.Explain(status, {});
    if (Steady::now() > end) return failed;
    std::this_thread::sleep_for(kLookAgain);
    if (!recordings_.link_->connected()) continue;
    failed = Begin(part);
    if (!failed.ok() && Steady::now() > end) return failed;
  }
}

// Looks at the next message of a part.
Status RecordingReader::Advance(Part& part) {
  if (part.at >= part.batch.Count) {
    Status status = Fetch(part);
    if (!status.ok()) return status;
  }
  part.sequence = 0;
  if (part.batch.Count == 0) return Status::Ok();
  jsMsgMetaData* raw = nullptr;
  const natsStatus status = natsMsg_GetMetaData(&raw, part.batch.Msgs[part.at]);
  const MetaData meta(raw);
  if (status != NATS_OK) return recordings_.Explain(status, {});
  part.sequence = part.last = meta->Sequence.Stream;
  part.pending = meta->NumPending;
  part.time_ns = meta->Timestamp;
  return Status::Ok();
}

Result<bool> RecordingReader::Next(Recorded& out) {
  Part* first = nullptr;
  for (Part& part : parts_) {
    if (part.sequence == 0) continue;
    if (first == nullptr || part.sequence < first->sequence) first = &part;
  }
  if (first == nullptr) return false;
  natsMsg* const message = first->batch.Msgs[first->at++];
  out.subject = natsMsg_GetSubject(message);
  out.payload.assign(natsMsg_GetData(message),
                     static_cast<std::size_t>(natsMsg_GetDataLength(message)));
  out.time_ns = first->time_ns;
  out.epoch = Number(message, "Styled-Epoch");
  out.sequence = Number(message, "Styled-Sequence");
  const Status status = Advance(*first);
  if (!status.ok()) return status;
  return true;
}

}  // namespace styled::stylenats
