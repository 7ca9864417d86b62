#include "clients/nats/values.h"

#include <charconv>
#include <chrono>
#include <memory>
#include <utility>

#include "clients/nats/subject.h"

namespace styled::stylenats {
namespace {

using Clock = std::chrono::steady_clock;

constexpr std::int64_t kBrokersAnswer_ms = 1000;  // for one request; longer would delay the end
constexpr std::chrono::milliseconds kReadAgain(500);

using JetStream = std::unique_ptr<jsCtx, Destroys<jsCtx_Destroy>>;
using StreamInfo = std::unique_ptr<jsStreamInfo, Destroys<jsStreamInfo_Destroy>>;
using Answers = std::unique_ptr<natsSubscription, Destroys<natsSubscription_Destroy>>;
using Message = std::unique_ptr<natsMsg, Destroys<natsMsg_Destroy>>;

const std::string kStream = "KV_" + std::string(kBucket);
const std::string kKeys = "$KV." + std::string(kBucket) + ".";  // in front of the key

std::string_view Header(natsMsg* message, const char* name) {
  const char* value = nullptr;
  return natsMsgHeader_Get(message, name, &value) == NATS_OK ? value : "";
}

}  // namespace

Values::Values(Link& link, const std::string& site, std::string domain, OnValue on_value)
    : link_(link),
      filter_(kKeys + Escape(site) + ".>"),
      domain_(std::move(domain)),
      get_((domain_.empty() ? "$JS.API" : "$JS." + domain_ + ".API") + ".DIRECT.GET." + kStream),
      on_value_(std::move(on_value)),
      thread_([this](const std::stop_token& stop) { Loop(stop); }) {}

Values::~Values() = default;

std::string Values::NextError() {
  const std::scoped_lock lock(mutex_);
  return std::exchange(error_, {});
}

bool Values::Fail(natsStatus status) {
  const char* const detail = nats_GetLastError(nullptr);
  std::string what =
      "the bucket '" + std::string(kBucket) + "' cannot be read: " + natsStatus_GetText(status);
  if (detail != nullptr && *detail != '\0') what += std::string(" (") + detail + ")";
  // The broker silently drops a request for which its user has no permission, so this looks like a
  // missing answer.
  const char* refused = nullptr;
  natsConnection_GetLastError(link_.get(), &refused);
  if (refused != nullptr && *refused != '\0')
    what += std::string("; the broker reports: ") + refused;
  if (!domain_.empty() && (status == NATS_TIMEOUT || status == NATS_NO_RESPONDERS)) {
    what += "; expected a JetStream domain \"" + domain_ +
            "\" that this user may use, or no --domain: viewers of the shipped configurations use "
            "their own account's";
  }
  what += "; without it frames have no bodies, and it is retried";
  const std::scoped_lock lock(mutex_);
  if (what != last_error_) error_ = last_error_ = what;
  return false;
}

void Values::Loop(const std::stop_token& stop) {
  std::uint64_t next = 0;
  while (!stop.stop_requested()) {
    if (link_.connected() && ReadAll(next) && Follow(next, stop)) continue;
    std::this_thread::sleep_for(kReadAgain);
  }
}

// All values of the site; `next`: the number of the first message that is not among them.
bool Values::ReadAll(std::uint64_t& next) {
  jsOptions options;
  jsOptions_Init(&options);
  options.Wait = kBrokersAnswer_ms;
  if (!domain_.empty()) options.Domain = domain_.c_str();
  options.Stream.Info.SubjectsFilter = filter_.c_str();
  jsCtx* jetstream = nullptr;
  natsStatus status = natsConnection_JetStream(&jetstream, link_.get(), &options);
  const JetStream owned(jetstream);
  jsStreamInfo* raw = nullptr;
  if (status == NATS_OK) {
    status = js_GetStreamInfo(&raw, jetstream, kStream.c_str(), &options, nullptr);
  }
  const StreamInfo info(raw);
  if (status != NATS_OK) return Fail(status);
  next = info->State.LastSeq + 1;
  std::vector<std::string> subjects;
  std::set<std::string> missing = known_;
  const jsStreamStateSubjects* const listed = info->State.Subjects;
  for (int i = 0; listed != nullptr && i < listed->Count; ++i) {
    subjects.emplace_back(listed->List[i].Subject);
    missing.erase(subjects.back().substr(kKeys.size()));
  }
  for (const std::string& key : missing) {
    known_.erase(key);
    on_value_(key, nullptr);
  }
  if (!Get(subjects)) return false;
  const std::scoped_lock lock(mutex_);
  last_error_.clear();
  return true;
}

// Sends all requests at once, so that a latency of 50 ms occurs twice and not for each.
bool Values::Get(const std::vector<std::string>& subjects) {
  const std::string inbox = link_.NewInbox();
  natsSubscription* raw = nullptr;
  natsStatus status = natsConnection_SubscribeSync(&raw, link_.get(), (inbox + ".*").c_str());
  const Answers answers(raw);
  for (std::size_t i = 0; status == NATS_OK && i < subjects.size(); ++i) {
    status = natsConnection_PublishRequestString(link_.get(), (get_ + "." + subjects[i]).c_str(),
                                                 (inbox + "." + std::to_string(i)).c_str(), "");
  }
  for (std::size_t i = 0; status == NATS_OK && i < subjects.size(); ++i) {
    natsMsg* answer = nullptr;
    status = natsSubscription_NextMsg(&answer, answers.get(), kBrokersAnswer_ms);
    const Message owned(answer);
    if (status == NATS_OK && natsMsg_IsNoResponders(answer)) status = NATS_NO_RESPONDERS;
    if (status == NATS_OK) Apply(answer);
  }
  return status == NATS_OK || Fail(status);
}

// Requests changes until it is time to read everything again. False: a request failed.
bool Values::Follow(std::uint64_t next, const std::stop_token& stop) {
  const std::uint64_t generation = link_.generation();
  const auto end = Clock::now() + std::chrono::seconds(kAgain_s);
  while (!stop.stop_requested() && link_.generation() == generation && Clock::now() < end) {
    const std::string wanted =
        R"({"seq":)" + std::to_string(next) + R"(,"next_by_subj":")" + filter_ + "\"}";
    natsMsg* answer = nullptr;
    const natsStatus status = natsConnection_RequestString(&answer, link_.get(), get_.c_str(),
                                                           wanted.c_str(), kBrokersAnswer_ms);
    const Message owned(answer);
    if (status != NATS_OK) return Fail(status);
    const std::uint64_t number = Apply(answer);
    if (number > 0) {
      next = number + 1;
    } else {
      std::this_thread::sleep_for(std::chrono::milliseconds(kPoll_ms));
    }
  }
  return true;
}

// Reports a value, or its removal. Returns its sequence number in the stream; 0: no value arrived.
std::uint64_t Values::Apply(natsMsg* message) {
  const std::string_view subject = Header(message, "Nats-Subject");
  const std::string_view number = Header(message, "Nats-Sequence");
  std::uint64_t read = 0;
  std::from_chars(number.data(), number.data() + number.size(), read);
  if (read == 0 || !subject.starts_with(kKeys)) return 0;
  const std::string key(subject.substr(kKeys.size()));
  if (Header(message, "KV-Operation").empty()) {
    known_.insert(key);
    const std::string value(natsMsg_GetData(message),
                            static_cast<std::size_t>(natsMsg_GetDataLength(message)));
    on_value_(key, &value);
  } else if (known_.erase(key) > 0) {
    on_value_(key, nullptr);
  }
  return read;
}

}  // namespace styled::stylenats
