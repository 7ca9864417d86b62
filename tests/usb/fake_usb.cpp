#include "tests/usb/fake_usb.h"

#include <dlfcn.h>
#include <linux/usbdevice_fs.h>
#include <sys/ioctl.h>
#include <umockdev.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstddef>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <deque>
#include <mutex>

#include "tests/support/rig.h"

namespace styled::support {
namespace {

constexpr const char* kPreload = "libumockdev-preload.so.0";
// The device's node is a plain file and always readable: a program that polls it would spin, so an
// answer that there is nothing to reap takes this long.
constexpr unsigned kEmptyReap_ms = 1;

void AddToEnvironment(const char* name, const std::string& value) {
  const char* const others = std::getenv(name);
  setenv(name, others == nullptr ? value.c_str() : (value + ":" + others).c_str(), 1);
}

struct Unref {
  void operator()(void* object) const { g_object_unref(object); }
};
template <typename T>
using Ref = std::unique_ptr<T, Unref>;
template <typename T>
Ref<T> Keep(T* object) {
  return Ref<T>(static_cast<T*>(g_object_ref(object)));
}

using Octets = std::vector<std::uint8_t>;

void Append(Octets& to, std::initializer_list<std::uint8_t> bytes) {
  to.insert(to.end(), bytes.begin(), bytes.end());
}

Octets DeviceDescriptor(FakeDevice::Kind kind, std::uint16_t vendor, std::uint16_t product) {
  const auto low = [](unsigned value) { return static_cast<std::uint8_t>(value & 0xFFU); };
  const auto high = [](unsigned value) { return static_cast<std::uint8_t>(value >> 8U); };
  const bool vendor_class = kind == FakeDevice::Kind::kVendor;
  Octets bytes{18, 1, 0, 2, 0, 0, 0, 64};
  if (!vendor_class) bytes = {18, 1, 0, 2, 0xEF, 2, 1, 64};  // interfaces are associated
  Append(bytes, {low(vendor), high(vendor), low(product), high(product), 0, 1, 0, 0, 3, 1});
  return bytes;
}

Octets Interface(int number, int endpoints, std::array<std::uint8_t, 3> what) {
  return {9,
          4,
          static_cast<std::uint8_t>(number),
          0,
          static_cast<std::uint8_t>(endpoints),
          what[0],
          what[1],
          what[2],
          0};
}

Octets Configuration(FakeDevice::Kind kind) {
  Octets body;
  const auto add = [&body](const Octets& bytes) {
    body.insert(body.end(), bytes.begin(), bytes.end());
  };
  const bool vendor_class = kind == FakeDevice::Kind::kVendor;
  if (vendor_class) {
    add(Interface(0, 2, {0xFF, 'S', 1}));
    Append(body, {7, 5, 0x01, 2, 0, 2, 0});  // bulk OUT, 512
    Append(body, {7, 5, 0x81, 2, 0, 2, 0});  // bulk IN, 512
  } else {
    Append(body, {8, 11, 0, 2, 2, 2, 0, 0});  // interfaces 0 and 1 are CDC-ACM
    add(Interface(0, 1, {2, 2, 0}));
    Append(body, {5, 0x24, 0, 0x10, 1});       // CDC 1.10
    Append(body, {7, 5, 0x82, 3, 16, 0, 10});  // interrupt IN, 16
    add(Interface(1, 2, {10, 0, 0}));
    Append(body, {7, 5, 0x01, 2, 64, 0, 0});
    Append(body, {7, 5, 0x83, 2, 64, 0, 0});
    add(Interface(2, 2, {3, 0, 0}));
    Append(body, {9, 0x21, 0x11, 1, 0, 1, 0x22, 0x22, 0});  // HID 1.11, a report descriptor
    Append(body, {7, 5, 0x81, 3, 64, 0, 1});                // interrupt IN, 64
    Append(body, {7, 5, 0x02, 3, 64, 0, 1});
  }
  const auto total = static_cast<std::uint8_t>(9 + body.size());
  Octets bytes{9, 2, total, 0, static_cast<std::uint8_t>(vendor_class ? 1 : 3), 1, 0, 0x80, 50};
  bytes.insert(bytes.end(), body.begin(), body.end());
  return bytes;
}

std::string Hex(const Octets& bytes) {
  std::string text;
  for (const std::uint8_t byte : bytes) {
    std::array<char, 3> digits{};
    std::snprintf(digits.data(), digits.size(), "%02X", byte);
    text += digits.data();
  }
  return text;
}

}  // namespace

struct FakeUsb::Testbed {
  Ref<UMockdevTestbed> bed{umockdev_testbed_new()};
  std::mutex mutex;
  int next_device = 1;
};

FakeUsb::FakeUsb() : testbed_(std::make_unique<Testbed>()) {
  // umockdev complains of every program that dies with a device open.
  g_log_set_handler(
      nullptr, G_LOG_LEVEL_CRITICAL, [](const char*, GLogLevelFlags, const char*, void*) {},
      nullptr);
}
FakeUsb::~FakeUsb() = default;

void FakeUsb::Preload(char** argv) {
  if (Available()) return;
  if (dlopen(kPreload, RTLD_LAZY) == nullptr) return;
  AddToEnvironment("LD_PRELOAD", kPreload);
  // Sanitizers want to be the first library, and know neither glib's nor udev's ways of waiting.
  AddToEnvironment("ASAN_OPTIONS", "verify_asan_link_order=0");
  AddToEnvironment("TSAN_OPTIONS", "ignore_noninstrumented_modules=1");
  execv("/proc/self/exe", argv);
}

bool FakeUsb::Available() { return dlopen(kPreload, RTLD_LAZY | RTLD_NOLOAD) != nullptr; }

// The device's actions and the programs' requests to it. Each plug-in has its own: programs that
// still hold the unplugged device reap its remaining requests.
struct FakeDevice::Usbfs {
  struct Item {  // to be sent: data, or an error
    Octets data;
    int error = 0;
  };
  struct Urb {
    Ref<UMockdevIoctlData> data;
    Ref<UMockdevIoctlData> buffer;
    usbdevfs_urb& fields() const { return *reinterpret_cast<usbdevfs_urb*>(data->data); }
  };
  struct Reap {  // waits for a transfer to finish, or for its time to be over
    Ref<UMockdevIoctlClient> client;
    Ref<UMockdevIoctlData> pointer;
    GSource* timer = nullptr;
  };
  struct Node {  // of one plug-in
    Usbfs* device = nullptr;
    Ref<UMockdevIoctlBase> handler;
    std::string path, sysfs;
    bool gone = false, halted = false;
    std::deque<Urb> submitted, finished;
    std::unique_ptr<Reap> reap;
  };

  FakeUsb::Testbed& testbed;
  Kind kind;
  std::uint16_t vendor, product;
  std::string serial;
  mutable std::mutex mutex;
  std::deque<Item> items;
  Counts counts;
  int claims_to_refuse = 0;
  std::vector<std::unique_ptr<Node>> nodes;

  Usbfs(FakeUsb::Testbed& bed, Kind what, std::uint16_t vendor_id, std::uint16_t product_id,
        std::string serial_number)
      : testbed(bed),
        kind(what),
        vendor(vendor_id),
        product(product_id),
        serial(std::move(serial_number)) {}

  bool plugged() const { return !nodes.empty() && !nodes.back()->gone; }

  static void Finish(Node& node, int status, std::span<const std::uint8_t> data = {}) {
    Urb urb = std::move(node.submitted.front());
    node.submitted.pop_front();
    Finish(node, std::move(urb), status, data);
  }
  static void Finish(Node& node, Urb urb, int status, std::span<const std::uint8_t> data = {}) {
    const std::size_t size = std::min(
        data.size(), static_cast<std::size_t>(urb.buffer == nullptr ? 0 : urb.buffer->data_len));
    if (size > 0) std::memcpy(urb.buffer->data, data.data(), size);
    urb.fields().actual_length = static_cast<int>(size);
    urb.fields().status = status;
    node.finished.push_back(std::move(urb));
  }

  // Brings together what is to be sent, the transfers that wait for it, and who waits for those.
  void Match() {
    if (!plugged()) return;
    Node& node = *nodes.back();
    while (!items.empty() && !node.submitted.empty() && !node.halted) {
      const Item item = std::move(items.front());
      items.pop_front();
      Finish(node, -item.error, item.data);
      if (item.error == EPIPE) node.halted = true;
    }
    HandOver(node);
  }

  static void HandOver(Node& node) {
    if (node.reap == nullptr || (node.finished.empty() && !node.gone)) return;
    const auto reap = std::move(node.reap);
    g_source_destroy(reap->timer);
    g_source_unref(reap->timer);
    if (node.finished.empty()) {
      umockdev_ioctl_client_complete(reap->client.get(), -1, ENODEV);
      return;
    }
    umockdev_ioctl_data_set_ptr(reap->pointer.get(), 0, node.finished.front().data.get());
    node.finished.pop_front();
    umockdev_ioctl_client_complete(reap->client.get(), 0, 0);
  }

  static gboolean NothingToReap(gpointer data) {
    Node& node = *static_cast<Node*>(data);
    const std::lock_guard lock(node.device->mutex);
    if (node.reap == nullptr) return G_SOURCE_REMOVE;
    const auto reap = std::move(node.reap);
    g_source_destroy(reap->timer);
    g_source_unref(reap->timer);
    umockdev_ioctl_client_complete(reap->client.get(), -1, EAGAIN);
    return G_SOURCE_REMOVE;
  }

  static gboolean OnIoctl(UMockdevIoctlBase*, UMockdevIoctlClient* client, gpointer data) {
    Node& node = *static_cast<Node*>(data);
    const std::lock_guard lock(node.device->mutex);
    return node.device->Answer(node, client) ? TRUE : FALSE;
  }

  bool Answer(Node& node, UMockdevIoctlClient* client) {
    UMockdevIoctlData* const arg = umockdev_ioctl_client_get_arg(client);
    const auto done = [client](int error) {
      umockdev_ioctl_client_complete(client, error == 0 ? 0 : -1, error);
      return true;
    };
    const unsigned long request = umockdev_ioctl_client_get_request(client);
    if (request == USBDEVFS_REAPURBNDELAY) return TakeReap(node, client, arg);
    if (node.gone) return done(ENODEV);
    switch (request) {
      case USBDEVFS_GET_CAPABILITIES: {
        auto* caps = umockdev_ioctl_data_resolve(arg, 0, sizeof(std::uint32_t), nullptr);
        const std::uint32_t bits = USBDEVFS_CAP_ZERO_PACKET | USBDEVFS_CAP_BULK_CONTINUATION |
                                   USBDEVFS_CAP_NO_PACKET_SIZE_LIM |
                                   USBDEVFS_CAP_BULK_SCATTER_GATHER |
                                   USBDEVFS_CAP_REAP_AFTER_DISCONNECT;
        std::memcpy(caps->data, &bits, sizeof bits);
        g_object_unref(caps);
        return done(0);
      }
      case USBDEVFS_DISCONNECT_CLAIM:
        ++counts.driver_detached;
        return done(Claim());
      case USBDEVFS_CLAIMINTERFACE:
        return done(Claim());
      case USBDEVFS_RELEASEINTERFACE:
        counts.claimed = false;
        return done(0);
      case USBDEVFS_IOCTL:  // libusb asks for USBDEVFS_CONNECT alone
        ++counts.driver_attached;
        return done(0);
      case USBDEVFS_CLEAR_HALT:
        ++counts.halts_cleared;
        node.halted = false;
        return done(0);
      case USBDEVFS_SUBMITURB:
        return done(Submit(node, arg));
      case USBDEVFS_DISCARDURB:
        return done(Discard(node, *reinterpret_cast<gulong*>(arg->data)));
      default:
        std::fprintf(stderr, "usbfs: ioctl %08lx is not answered\n", request);
        return done(ENOTTY);
    }
  }

  int Claim() {
    if (claims_to_refuse > 0) {
      --claims_to_refuse;
      ++counts.refused_claims;
      return EBUSY;
    }
    ++counts.claims;
    counts.claimed = true;
    return 0;
  }

  int Submit(Node& node, UMockdevIoctlData* arg) {
    Urb urb{
        Ref<UMockdevIoctlData>(umockdev_ioctl_data_resolve(arg, 0, sizeof(usbdevfs_urb), nullptr)),
        nullptr};
    urb.buffer.reset(umockdev_ioctl_data_resolve(urb.data.get(), offsetof(usbdevfs_urb, buffer),
                                                 static_cast<gsize>(urb.fields().buffer_length),
                                                 nullptr));
    if (urb.fields().type == USBDEVFS_URB_TYPE_CONTROL) {
      Control(node, std::move(urb));
    } else if (node.halted) {
      Finish(node, std::move(urb), -EPIPE);
    } else {
      node.submitted.push_back(std::move(urb));
    }
    Match();
    return 0;
  }

  // GET_DESCRIPTOR of strings: 0 the languages, the rest the serial number.
  void Control(Node& node, Urb urb) const {
    constexpr std::size_t kSetup = 8;
    const std::uint8_t* setup = urb.buffer->data;
    if (setup[1] != 6 || setup[3] != 3) return Finish(node, std::move(urb), -EPIPE);
    Octets string{4, 3, 0x09, 0x04};
    if (setup[2] != 0) {
      string = {static_cast<std::uint8_t>(2 + 2 * serial.size()), 3};
      for (const char c : serial) Append(string, {static_cast<std::uint8_t>(c), 0});
    }
    const auto room = static_cast<std::size_t>(urb.buffer->data_len) - kSetup;
    const std::size_t size = std::min(room, string.size());
    std::memcpy(urb.buffer->data + kSetup, string.data(), size);
    urb.fields().actual_length = static_cast<int>(size);
    urb.fields().status = 0;
    node.finished.push_back(std::move(urb));
  }

  static int Discard(Node& node, gulong address) {
    for (auto urb = node.submitted.begin(); urb != node.submitted.end(); ++urb) {
      if (urb->data->client_addr != address) continue;
      Urb discarded = std::move(*urb);
      node.submitted.erase(urb);
      Finish(node, std::move(discarded), -ENOENT);
      HandOver(node);
      return 0;
    }
    return EINVAL;
  }

  static bool TakeReap(Node& node, UMockdevIoctlClient* client, UMockdevIoctlData* arg) {
    auto reap = std::make_unique<Reap>();
    reap->client = Keep(client);
    reap->pointer.reset(umockdev_ioctl_data_resolve(arg, 0, sizeof(void*), nullptr));
    reap->timer = g_timeout_source_new(kEmptyReap_ms);
    g_source_set_callback(reap->timer, &Usbfs::NothingToReap, &node, nullptr);
    node.reap = std::move(reap);
    if (node.finished.empty() && !node.gone) {
      g_source_attach(node.reap->timer, g_main_context_get_thread_default());
    }
    HandOver(node);
    return true;
  }
};

FakeDevice::FakeDevice(FakeUsb& usb, Kind kind, std::uint16_t vendor, std::uint16_t product,
                       std::string serial)
    : usbfs_(std::make_unique<Usbfs>(*usb.testbed_, kind, vendor, product, std::move(serial))) {}

FakeDevice::~FakeDevice() {
  if (usbfs_->plugged()) Unplug();
}

void FakeDevice::Plug() {
  auto& testbed = usbfs_->testbed;
  const std::lock_guard bed_lock(testbed.mutex);
  const int number = testbed.next_device++;
  auto node = std::make_unique<Usbfs::Node>();
  node->device = usbfs_.get();
  node->handler.reset(umockdev_ioctl_base_new());
  std::array<char, 64> path{};
  std::snprintf(path.data(), path.size(), "/dev/bus/usb/001/%03d", number);
  node->path = path.data();
  node->sysfs = "/sys/devices/usb" + std::to_string(number);
  g_signal_connect(node->handler.get(), "handle-ioctl", G_CALLBACK(&Usbfs::OnIoctl), node.get());

  Octets descriptors = DeviceDescriptor(usbfs_->kind, usbfs_->vendor, usbfs_->product);
  const Octets configuration = Configuration(usbfs_->kind);
  descriptors.insert(descriptors.end(), configuration.begin(), configuration.end());
  const std::string text =
      "P: /devices/usb" + std::to_string(number) + "\nN: " + node->path.substr(5) +
      "\nE: SUBSYSTEM=usb\nE: DRIVER=usb\nE: DEVTYPE=usb_device\nE: BUSNUM=001"
      "\nE: DEVNUM=" +
      node->path.substr(17) + "\nE: DEVNAME=" + node->path +
      "\nA: bConfigurationValue=1\\n\nA: busnum=1\\n\nA: devnum=" + std::to_string(number) +
      "\\n\nA: speed=12\\n\nH: descriptors=" + Hex(descriptors) + "\n";
  const std::string dev = node->path;
  {
    const std::lock_guard lock(usbfs_->mutex);
    usbfs_->nodes.push_back(std::move(node));
  }
  // Answers before the "add" event: a program that gets the event opens the device at once.
  GError* error = nullptr;
  if (umockdev_testbed_attach_ioctl(testbed.bed.get(), dev.c_str(),
                                    usbfs_->nodes.back()->handler.get(), &error) == FALSE ||
      umockdev_testbed_add_from_string(testbed.bed.get(), text.c_str(), &error) == FALSE) {
    std::fprintf(stderr, "%s\n", error->message);
    std::abort();
  }
}

void FakeDevice::Unplug() {
  auto& testbed = usbfs_->testbed;
  const std::lock_guard bed_lock(testbed.mutex);
  std::string sysfs, dev;
  {
    const std::lock_guard lock(usbfs_->mutex);
    Usbfs::Node& node = *usbfs_->nodes.back();
    node.gone = true;
    while (!node.submitted.empty()) Usbfs::Finish(node, -ESHUTDOWN);
    Usbfs::HandOver(node);
    usbfs_->counts.claimed = false;
    usbfs_->items.clear();
    sysfs = node.sysfs;
    dev = node.path;
  }
  umockdev_testbed_uevent(testbed.bed.get(), sysfs.c_str(), "remove");
  umockdev_testbed_remove_device(testbed.bed.get(), sysfs.c_str());
  umockdev_testbed_detach_ioctl(testbed.bed.get(), dev.c_str(), nullptr);
}

void FakeDevice::Send(std::span<const std::byte> bytes) {
  const std::lock_guard lock(usbfs_->mutex);
  const auto* begin = reinterpret_cast<const std::uint8_t*>(bytes.data());
  usbfs_->items.push_back({Octets(begin, begin + bytes.size()), 0});
  usbfs_->Match();
}

void FakeDevice::Stall() { Fail(1, EPIPE); }

void FakeDevice::Fail(int count, int error) {
  const std::lock_guard lock(usbfs_->mutex);
  for (int i = 0; i < count; ++i) usbfs_->items.push_back({{}, error});
  usbfs_->Match();
}

void FakeDevice::RefuseClaims(int count) {
  const std::lock_guard lock(usbfs_->mutex);
  usbfs_->claims_to_refuse = count;
}

FakeDevice::Counts FakeDevice::counts() const {
  const std::lock_guard lock(usbfs_->mutex);
  Counts counts = usbfs_->counts;
  counts.waiting = static_cast<int>(usbfs_->items.size());
  counts.under_way =
      usbfs_->plugged() ? static_cast<int>(usbfs_->nodes.back()->submitted.size()) : 0;
  return counts;
}

bool FakeDevice::WaitForTransfers(int under_way, double seconds) const {
  for (double waited = 0; waited < seconds; waited += 0.005) {
    const Counts now = counts();
    if (now.claimed && now.under_way == under_way && now.waiting == 0) return true;
    Sleep(0.005);
  }
  return false;
}

}  // namespace styled::support
