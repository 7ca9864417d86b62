#include "clients/oscquery/mdns.h"

#include <avahi-client/client.h>
#include <avahi-client/lookup.h>
#include <avahi-client/publish.h>
#include <avahi-common/address.h>
#include <avahi-common/alternative.h>
#include <avahi-common/error.h>
#include <avahi-common/malloc.h>
#include <avahi-common/simple-watch.h>

#include <algorithm>
#include <array>
#include <condition_variable>
#include <list>
#include <mutex>
#include <thread>
#include <utility>

namespace styled::oscquery {
namespace {

constexpr const char* kJsonType = "_oscjson._tcp";
constexpr const char* kOscType = "_osc._udp";
constexpr int kStep_ms = 100;
constexpr std::chrono::seconds kReconnect(1);
constexpr int kMostNames = 16;  // tried for one service
constexpr std::size_t kMaxSightings = 256;

template <auto Free>
struct FreeWith {
  template <typename T>
  void operator()(T* object) const {
    Free(object);
  }
};
using Poll = std::unique_ptr<AvahiSimplePoll, FreeWith<avahi_simple_poll_free>>;
using Client = std::unique_ptr<AvahiClient, FreeWith<avahi_client_free>>;

std::string NoAvahi(int error) {
  return std::string("avahi-daemon, which speaks mDNS, does not answer over D-Bus (") +
         avahi_strerror(error) +
         "); apt-get install avahi-daemon, then systemctl start avahi-daemon";
}

}  // namespace

struct Advertiser::Impl {
  // A service that avahi-daemon has, or is about to have.
  struct Entry {
    Impl* impl = nullptr;
    Announcement announcement;
    std::string name;  // in force
    AvahiEntryGroup* group = nullptr;
  };

  Impl() : thread([this](const std::stop_token& stop) { Loop(stop); }) {}

  void Loop(const std::stop_token& stop);
  void Connect();
  void Disconnect();
  void Update();
  void Publish(Entry& entry, AvahiClient* by);
  int TryName(Entry& entry);
  void Established(const Entry& entry);
  void Report(const std::string& trouble);
  static void OnClient(AvahiClient* by, AvahiClientState now, void* user);
  static void OnGroup(AvahiEntryGroup* group, AvahiEntryGroupState now, void* user);

  // The thread's.
  Poll poll;
  Client client;  // after `poll`, which it uses until its end
  std::list<Entry> entries;
  bool running = false, lost = false, again = false;

  mutable std::mutex mutex;
  std::condition_variable_any wake;
  std::vector<Announcement> requested;
  State state;

  std::jthread thread;  // last: it ends before the rest
};

void Advertiser::Impl::Report(const std::string& trouble) {
  const std::lock_guard lock(mutex);
  state.trouble = trouble;
  if (!trouble.empty()) state.names.clear();
}

void Advertiser::Impl::OnClient(AvahiClient* by, AvahiClientState now, void* user) {
  auto& impl = *static_cast<Impl*>(user);
  impl.running = now == AVAHI_CLIENT_S_RUNNING;
  // While the machine gets another name, its services are not announced.
  if (now == AVAHI_CLIENT_S_COLLISION || now == AVAHI_CLIENT_S_REGISTERING) impl.again = true;
  if (now == AVAHI_CLIENT_CONNECTING) impl.Report(NoAvahi(AVAHI_ERR_NO_DAEMON));
  if (now != AVAHI_CLIENT_FAILURE) return;
  impl.lost = true;
  impl.Report(NoAvahi(avahi_client_errno(by)));
}

void Advertiser::Impl::OnGroup(AvahiEntryGroup* group, AvahiEntryGroupState now, void* user) {
  auto& entry = *static_cast<Entry*>(user);
  AvahiClient* const by = avahi_entry_group_get_client(group);
  if (now == AVAHI_ENTRY_GROUP_ESTABLISHED) entry.impl->Established(entry);
  if (now == AVAHI_ENTRY_GROUP_FAILURE) {
    entry.impl->lost = true;
    entry.impl->Report(NoAvahi(avahi_client_errno(by)));
  }
  if (now != AVAHI_ENTRY_GROUP_COLLISION) return;
  entry.group = group;
  char* const other = avahi_alternative_host_name(entry.name.c_str());
  entry.name = other;
  avahi_free(other);
  entry.impl->Publish(entry, by);
}

void Advertiser::Impl::Established(const Entry& entry) {
  const std::lock_guard lock(mutex);
  state.names[entry.announcement.name] = entry.name;
  if (state.names.size() == requested.size()) state.trouble.clear();
}

// 0, or an error of avahi.
int Advertiser::Impl::TryName(Entry& entry) {
  const Announcement& a = entry.announcement;
  const std::string host = entry.name + ".local";
  avahi_entry_group_reset(entry.group);
  for (const Place& place : a.places) {
    AvahiAddress address;
    if (avahi_address_parse(place.address.c_str(), AVAHI_PROTO_UNSPEC, &address) == nullptr) {
      return AVAHI_ERR_INVALID_ADDRESS;
    }
    // The machine's own name keeps the reverse of its addresses.
    const int error = avahi_entry_group_add_address(
        entry.group, static_cast<AvahiIfIndex>(place.interface), AVAHI_PROTO_UNSPEC,
        AVAHI_PUBLISH_NO_REVERSE, host.c_str(), &address);
    if (error != 0) return error;
  }
  // Once for all interfaces: of services that are added for each, avahi 0.8 announces no end.
  const bool one = std::all_of(a.places.begin(), a.places.end(), [&a](const Place& place) {
    return place.interface == a.places[0].interface;
  });
  const AvahiIfIndex interface =
      one ? static_cast<AvahiIfIndex>(a.places[0].interface) : AVAHI_IF_UNSPEC;
  for (const auto& [type, port] : {std::pair(kJsonType, a.http_port), {kOscType, a.osc_port}}) {
    const int error = avahi_entry_group_add_service(
        entry.group, interface, AVAHI_PROTO_UNSPEC, static_cast<AvahiPublishFlags>(0),
        entry.name.c_str(), type, nullptr, host.c_str(), port, "txtvers=1", nullptr);
    if (error != 0) return error;
  }
  return avahi_entry_group_commit(entry.group);
}

void Advertiser::Impl::Publish(Entry& entry, AvahiClient* by) {
  if (entry.group == nullptr) entry.group = avahi_entry_group_new(by, &Impl::OnGroup, &entry);
  int error = entry.group == nullptr ? avahi_client_errno(by) : TryName(entry);
  // A collision in the network comes through OnGroup, one on this machine at once.
  for (int i = 0; error == AVAHI_ERR_COLLISION && i < kMostNames; ++i) {
    char* const other = avahi_alternative_host_name(entry.name.c_str());
    entry.name = other;
    avahi_free(other);
    error = TryName(entry);
  }
  if (error == 0) return;
  lost = true;
  Report("avahi-daemon refuses the service " + entry.name + ": " + avahi_strerror(error));
}

void Advertiser::Impl::Connect() {
  poll.reset(avahi_simple_poll_new());
  int error = 0;
  client.reset(avahi_client_new(avahi_simple_poll_get(poll.get()), AVAHI_CLIENT_NO_FAIL,
                                &Impl::OnClient, this, &error));
  if (client == nullptr) Report(NoAvahi(error));
}

void Advertiser::Impl::Disconnect() {
  client.reset();  // with its groups
  poll.reset();
  entries.clear();
  running = lost = again = false;
  const std::lock_guard lock(mutex);
  state.names.clear();
}

// Makes the announced services those that are requested.
void Advertiser::Impl::Update() {
  std::vector<Announcement> now;
  {
    const std::lock_guard lock(mutex);
    now = requested;
  }
  for (auto entry = entries.begin(); entry != entries.end();) {
    const bool stays = std::find(now.begin(), now.end(), entry->announcement) != now.end();
    if (stays && !again) {
      ++entry;
      continue;
    }
    if (entry->group != nullptr) avahi_entry_group_free(entry->group);
    const std::lock_guard lock(mutex);
    state.names.erase(entry->announcement.name);
    entry = entries.erase(entry);
  }
  again = false;
  if (!running) return;
  for (const Announcement& announcement : now) {
    const bool known = std::any_of(entries.begin(), entries.end(), [&](const Entry& entry) {
      return entry.announcement == announcement;
    });
    if (known) continue;
    Entry& entry = entries.emplace_back(Entry{this, announcement, announcement.name, nullptr});
    Publish(entry, client.get());
    if (lost) return;
  }
  if (entries.empty()) Report("");
}

void Advertiser::Impl::Loop(const std::stop_token& stop) {
  while (!stop.stop_requested()) {
    if (client == nullptr) Connect();
    if (client != nullptr && !lost) Update();
    if (client != nullptr && !lost) {
      const int ended = avahi_simple_poll_iterate(poll.get(), kStep_ms);
      lost = lost || ended != 0;  // its callbacks set it, too
    }
    if (client != nullptr && !lost) continue;
    Disconnect();
    std::unique_lock lock(mutex);
    wake.wait_for(lock, stop, kReconnect, [] { return false; });
  }
  Disconnect();
}

Advertiser::Advertiser() : impl_(std::make_unique<Impl>()) {}
Advertiser::~Advertiser() = default;

void Advertiser::Set(std::vector<Announcement> announcements) {
  const std::lock_guard lock(impl_->mutex);
  impl_->requested = std::move(announcements);
}

Advertiser::State Advertiser::state() const {
  const std::lock_guard lock(impl_->mutex);
  return impl_->state;
}

namespace {

// One run of Browse().
struct Search {
  AvahiClient* client = nullptr;
  int open = 0;  // browsers and resolvers that have not ended
  bool failed = false;
  std::vector<Sighting> found;
};

void OnResolved(AvahiServiceResolver* resolver, AvahiIfIndex /*interface*/,
                AvahiProtocol /*protocol*/, AvahiResolverEvent event, const char* name,
                const char* type, const char* /*domain*/, const char* host,
                const AvahiAddress* address, std::uint16_t port, AvahiStringList* /*text*/,
                AvahiLookupResultFlags /*flags*/, void* user) {
  auto& search = *static_cast<Search*>(user);
  --search.open;
  if (event == AVAHI_RESOLVER_FOUND && search.found.size() < kMaxSightings) {
    std::array<char, AVAHI_ADDRESS_STR_MAX> text{};
    avahi_address_snprint(text.data(), text.size(), address);
    search.found.push_back({name, std::string_view(type) == kJsonType, host, text.data(), port});
  }
  avahi_service_resolver_free(resolver);
}

void OnSeen(AvahiServiceBrowser* /*browser*/, AvahiIfIndex interface, AvahiProtocol protocol,
            AvahiBrowserEvent event, const char* name, const char* type, const char* domain,
            AvahiLookupResultFlags /*flags*/, void* user) {
  auto& search = *static_cast<Search*>(user);
  if (event == AVAHI_BROWSER_ALL_FOR_NOW) --search.open;
  if (event == AVAHI_BROWSER_FAILURE) search.failed = true;
  if (event != AVAHI_BROWSER_NEW || search.open > static_cast<int>(kMaxSightings)) return;
  if (avahi_service_resolver_new(search.client, interface, protocol, name, type, domain,
                                 AVAHI_PROTO_INET, static_cast<AvahiLookupFlags>(0), &OnResolved,
                                 user) != nullptr) {
    ++search.open;
  }
}

}  // namespace

Result<std::vector<Sighting>> Browse(std::chrono::milliseconds timeout) {
  Search search;
  const Poll poll(avahi_simple_poll_new());
  int error = 0;
  const Client client(avahi_client_new(avahi_simple_poll_get(poll.get()),
                                       static_cast<AvahiClientFlags>(0), nullptr, nullptr, &error));
  if (client == nullptr) return Status::Error(NoAvahi(error));
  search.client = client.get();
  for (const char* type : {kJsonType, kOscType}) {
    if (avahi_service_browser_new(client.get(), AVAHI_IF_UNSPEC, AVAHI_PROTO_UNSPEC, type, nullptr,
                                  static_cast<AvahiLookupFlags>(0), &OnSeen, &search) == nullptr) {
      return Status::Error(NoAvahi(avahi_client_errno(client.get())));
    }
    ++search.open;
  }
  const auto end = std::chrono::steady_clock::now() + timeout;
  while (search.open > 0 && !search.failed && std::chrono::steady_clock::now() < end) {
    if (avahi_simple_poll_iterate(poll.get(), kStep_ms) != 0) search.failed = true;
  }
  if (search.failed) return Status::Error(NoAvahi(avahi_client_errno(client.get())));
  // A service is seen once per interface and protocol; loopback is the last resort.
  std::stable_sort(search.found.begin(), search.found.end(), [](const auto& a, const auto& b) {
    return !a.address.starts_with("127.") && b.address.starts_with("127.");
  });
  std::vector<Sighting> once;
  for (Sighting& sighting : search.found) {
    const bool known = std::any_of(once.begin(), once.end(), [&](const Sighting& other) {
      return other.name == sighting.name && other.has_tree == sighting.has_tree;
    });
    if (!known) once.push_back(std::move(sighting));
  }
  return once;
}

}  // namespace styled::oscquery
