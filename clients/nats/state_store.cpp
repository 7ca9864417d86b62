#include "clients/nats/state_store.h"

#include <utility>

#include "clients/nats/subject.h"

namespace styled::stylenats {
namespace {

constexpr std::int64_t kAnswer_ms = 1000;  // for one request; longer would delay the end
constexpr std::chrono::milliseconds kRetry(500), kLook(200);
constexpr std::chrono::seconds kCheck(2);
// The limit of the bucket, as JetStream counts: values, keys and headers. Twice our own limit.
constexpr std::int64_t kBucketBytes = std::int64_t{64} << 20U;

}  // namespace

StateStore::StateStore(Link& link, std::string domain)
    : link_(link),
      domain_(std::move(domain)),
      thread_([this](const std::stop_token& stop) { Loop(stop); }) {}

StateStore::~StateStore() {
  Stop();
  Unbind();
}

void StateStore::Stop() {
  thread_.request_stop();
  if (thread_.joinable()) thread_.join();
}

void StateStore::Queue(const std::string& key, Entry& entry) {
  if (std::exchange(entry.waits, true)) return;
  order_.push_back(key);
  wake_.notify_one();
}

void StateStore::Put(const std::string& key, std::string_view value) {
  const std::scoped_lock lock(mutex_);
  const auto known = entries_.find(key);
  const std::size_t freed = known == entries_.end() ? 0 : known->second.value.size();
  if (known != entries_.end() && !known->second.removed && known->second.value == value) return;
  if ((known == entries_.end() && entries_.size() >= kMaxKeys) ||
      bytes_ - freed + value.size() > kMaxBytes) {
    ++counts_.refused;
    return;
  }
  Entry& entry = entries_[key];
  bytes_ += value.size() - freed;
  entry.value.assign(value);
  entry.removed = false;
  ++entry.version;
  Queue(key, entry);
}

void StateStore::Remove(const std::string& key) {
  const std::scoped_lock lock(mutex_);
  const auto known = entries_.find(key);
  if (known == entries_.end() || known->second.removed) return;
  bytes_ -= known->second.value.size();
  known->second.value.clear();
  known->second.removed = true;
  ++known->second.version;
  Queue(key, known->second);
}

std::string StateStore::NextError() {
  const std::scoped_lock lock(mutex_);
  return std::exchange(error_, {});
}

void StateStore::Fail(const std::string& what) {
  ++counts_.failed;
  const std::scoped_lock lock(mutex_);
  if (what == last_error_) return;
  error_ = last_error_ = what;
}

void StateStore::Loop(const std::stop_token& stop) {
  while (!stop.stop_requested()) {
    const bool connected = link_.connected();
    const bool ok = connected && Step();
    std::unique_lock lock(mutex_);
    if (ok) {
      wake_.wait_for(lock, stop, kLook, [this] { return !order_.empty(); });
    } else {
      wake_.wait_for(lock, stop, connected ? kRetry : kLook, [] { return false; });
    }
  }
}

// Binds the bucket if necessary, and writes one value. False: must be retried.
bool StateStore::Step() {
  const std::uint64_t generation = link_.generation();
  if (bucket_ != nullptr && generation == generation_ && Clock::now() >= next_check_ && !Holds()) {
    Unbind();
  }
  if (bucket_ == nullptr || generation != generation_) {
    Unbind();
    if (!Bind()) return false;
    generation_ = generation;
    next_check_ = Clock::now() + kCheck;
    const std::scoped_lock lock(mutex_);
    for (auto& [key, entry] : entries_) Queue(key, entry);
  }
  return WriteNext();
}

// Whether the bucket has as many values as were written: its server may have been restarted behind
// a leaf server to which our connection never broke.
bool StateStore::Holds() {
  next_check_ = Clock::now() + kCheck;
  std::uint64_t expected = 0;
  {
    const std::scoped_lock lock(mutex_);
    for (const auto& [key, entry] : entries_) expected += entry.waits || entry.removed ? 0 : 1;
  }
  kvStatus* status = nullptr;
  if (kvStore_Status(&status, bucket_) != NATS_OK) return false;
  const bool holds = kvStatus_Values(status) >= expected;
  kvStatus_Destroy(status);
  return holds;
}

void StateStore::Unbind() {
  kvStore_Destroy(std::exchange(bucket_, nullptr));
  jsCtx_Destroy(std::exchange(jetstream_, nullptr));
}

// The existing bucket, or a new one.
bool StateStore::Bind() {
  jsOptions options;
  jsOptions_Init(&options);
  options.Wait = kAnswer_ms;
  if (!domain_.empty()) options.Domain = domain_.c_str();
  const std::string name(kBucket);
  natsStatus status = natsConnection_JetStream(&jetstream_, link_.get(), &options);
  if (status == NATS_OK) status = js_KeyValue(&bucket_, jetstream_, name.c_str());
  if (status == NATS_NOT_FOUND) {
    kvConfig config;
    kvConfig_Init(&config);
    config.Bucket = name.c_str();
    config.Description = "styled: bodies and performers";
    config.History = 1;
    config.StorageType = js_MemoryStorage;
    config.MaxBytes = kBucketBytes;
    status = js_CreateKeyValue(&bucket_, jetstream_, &config);
  }
  if (status == NATS_OK) return true;
  const char* detail = nats_GetLastError(nullptr);
  Fail("no bucket '" + name + "': " + natsStatus_GetText(status) +
       (detail != nullptr && *detail != '\0' ? std::string(" (") + detail + ")" : "") +
       "; frames continue without it, and it is retried");
  Unbind();
  return false;
}

// Writes the value that has waited longest. False: the write failed, and the value waits again.
bool StateStore::WriteNext() {
  std::string key, value;
  bool removed = false;
  std::uint64_t version = 0;
  {
    const std::scoped_lock lock(mutex_);
    if (order_.empty()) return true;
    key = order_.front();
    order_.pop_front();
    Entry& entry = entries_.at(key);
    entry.waits = false;
    value = entry.value;
    removed = entry.removed;
    version = entry.version;
  }
  const natsStatus status = removed ? kvStore_Delete(bucket_, key.c_str())
                                    : kvStore_Put(nullptr, bucket_, key.c_str(), value.data(),
                                                  static_cast<int>(value.size()));
  if (status == NATS_OK) {
    ++counts_.written;
    const std::scoped_lock lock(mutex_);
    last_error_.clear();
    const auto entry = entries_.find(key);
    if (removed && entry->second.version == version) entries_.erase(entry);
    return true;
  }
  Fail("key " + key + ": " + natsStatus_GetText(status) +
       (status == NATS_TIMEOUT ? "; no answer, or no permission to write" : ""));
  Unbind();
  const std::scoped_lock lock(mutex_);
  Queue(key, entries_.at(key));
  return false;
}

}  // namespace styled::stylenats
