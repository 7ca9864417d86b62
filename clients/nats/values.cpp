#include "clients/nats/values.h"

#include <chrono>
#include <memory>
#include <utility>

#include "clients/nats/subject.h"

namespace styled::stylenats {
namespace {

using Clock = std::chrono::steady_clock;

constexpr std::int64_t kBrokersAnswer_ms = 1000;  // for one request; longer would delay the end
constexpr std::int64_t kLookUp_ms = 100;          // between two looks whether the program ends
constexpr std::chrono::milliseconds kWatchAgain(500);

template <auto kDestroy>
struct Destroyer {
  template <typename T>
  void operator()(T* object) const {
    kDestroy(object);
  }
};
using JetStream = std::unique_ptr<jsCtx, Destroyer<jsCtx_Destroy>>;
using Bucket = std::unique_ptr<kvStore, Destroyer<kvStore_Destroy>>;
using Watcher = std::unique_ptr<kvWatcher, Destroyer<kvWatcher_Destroy>>;
using Entry = std::unique_ptr<kvEntry, Destroyer<kvEntry_Destroy>>;

}  // namespace

Values::Values(Link& link, const std::string& site, std::string domain, OnValue on_value)
    : link_(link),
      keys_(Escape(site) + ".>"),
      domain_(std::move(domain)),
      on_value_(std::move(on_value)),
      thread_([this](const std::stop_token& stop) { Loop(stop); }) {}

Values::~Values() = default;

std::string Values::TakeError() {
  const std::scoped_lock lock(mutex_);
  return std::exchange(error_, {});
}

void Values::Fail(natsStatus status) {
  const char* const detail = nats_GetLastError(nullptr);
  std::string what =
      "the bucket '" + std::string(kBucket) + "' cannot be read: " + natsStatus_GetText(status);
  if (detail != nullptr && *detail != '\0') what += std::string(" (") + detail + ")";
  what += "; without it frames have no bodies, and it is tried again";
  const std::scoped_lock lock(mutex_);
  if (what == last_error_) return;
  error_ = last_error_ = what;
}

void Values::Loop(const std::stop_token& stop) {
  while (!stop.stop_requested()) {
    if (link_.connected() && Watch(stop)) continue;
    std::this_thread::sleep_for(kWatchAgain);
  }
}

// Watches until it is time to watch anew. False: that failed.
bool Values::Watch(const std::stop_token& stop) {
  jsOptions options;
  jsOptions_Init(&options);
  options.Wait = kBrokersAnswer_ms;
  if (!domain_.empty()) options.Domain = domain_.c_str();
  jsCtx* jetstream = nullptr;
  natsStatus status = natsConnection_JetStream(&jetstream, link_.get(), &options);
  const JetStream owned_jetstream(jetstream);
  kvStore* bucket = nullptr;
  if (status == NATS_OK) {
    status = js_KeyValue(&bucket, jetstream, std::string(kBucket).c_str());
  }
  const Bucket owned_bucket(bucket);
  kvWatcher* watcher = nullptr;
  if (status == NATS_OK) status = kvStore_Watch(&watcher, bucket, keys_.c_str(), nullptr);
  const Watcher owned_watcher(watcher);
  if (status == NATS_OK) return Read(watcher, stop);
  Fail(status);
  return false;
}

// The values that there are come first, then an entry that is null, then the changes.
bool Values::Read(kvWatcher* watcher, const std::stop_token& stop) {
  const std::uint64_t generation = link_.generation();
  const auto end = Clock::now() + std::chrono::seconds(kAgain_s);
  std::set<std::string> missing = known_;
  while (!stop.stop_requested() && link_.generation() == generation && Clock::now() < end) {
    kvEntry* entry = nullptr;
    const natsStatus status = kvWatcher_Next(&entry, watcher, kLookUp_ms);
    const Entry owned(entry);
    if (status == NATS_TIMEOUT) continue;
    if (status != NATS_OK) {
      Fail(status);
      return false;
    }
    if (entry == nullptr) {
      for (const std::string& key : std::exchange(missing, {})) {
        known_.erase(key);
        on_value_(key, nullptr);
      }
      const std::scoped_lock lock(mutex_);
      last_error_.clear();
      continue;
    }
    const std::string key = kvEntry_Key(entry);
    missing.erase(key);
    if (kvEntry_Operation(entry) == kvOp_Put) {
      known_.insert(key);
      const std::string value(static_cast<const char*>(kvEntry_Value(entry)),
                              static_cast<std::size_t>(kvEntry_ValueLen(entry)));
      on_value_(key, &value);
    } else if (known_.erase(key) > 0) {
      on_value_(key, nullptr);
    }
  }
  return true;
}

}  // namespace styled::stylenats
