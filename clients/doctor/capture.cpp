#include "clients/doctor/capture.h"

#include <linux/filter.h>
#include <linux/if_ether.h>
#include <linux/if_packet.h>
#include <sys/socket.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <utility>

namespace styled::doctor {
namespace {

constexpr std::size_t kUdpHeader = 8, kIpv6Header = 40;
constexpr std::uint8_t kUdp = 17;

std::uint16_t Read16(std::span<const std::byte> bytes, std::size_t at) {
  return static_cast<std::uint16_t>(std::to_integer<unsigned>(bytes[at]) << 8U |
                                    std::to_integer<unsigned>(bytes[at + 1]));
}

std::string HostOf(int family, std::span<const std::byte> address) {
  sockaddr_storage storage{};
  storage.ss_family = static_cast<sa_family_t>(family);
  void* to = family == AF_INET
                 ? static_cast<void*>(&reinterpret_cast<sockaddr_in&>(storage).sin_addr)
                 : static_cast<void*>(&reinterpret_cast<sockaddr_in6&>(storage).sin6_addr);
  std::memcpy(to, address.data(), address.size());
  return FromSocket(storage).host;
}

// Parses the part behind the IP header; the hosts of `out` are already set.
bool ParseUdp(std::span<const std::byte> udp, Captured& out) {
  if (udp.size() < kUdpHeader) return false;
  const std::size_t length = Read16(udp, 4);
  if (length < kUdpHeader) return false;
  out.from.port = Read16(udp, 0);
  out.to.port = Read16(udp, 2);
  out.cut |= length > udp.size();
  out.payload = udp.subspan(kUdpHeader, std::min(length, udp.size()) - kUdpHeader);
  return true;
}

// The kernel filters for UDP; otherwise every TCP packet would be copied as well.
Descriptor OpenSocket(std::uint16_t protocol, unsigned protocol_at) {
  Descriptor fd(socket(AF_PACKET, SOCK_DGRAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0));
  if (fd.get() < 0) return fd;
  std::array<sock_filter, 4> code{{
      BPF_STMT(BPF_LD | BPF_B | BPF_ABS, protocol_at),
      BPF_JUMP(BPF_JMP | BPF_JEQ | BPF_K, kUdp, 0, 1),
      BPF_STMT(BPF_RET | BPF_K, kMaxReceived),
      BPF_STMT(BPF_RET | BPF_K, 0),
  }};
  const sock_fprog program{code.size(), code.data()};
  const int bytes = 8 << 20;
  setsockopt(fd.get(), SOL_SOCKET, SO_ATTACH_FILTER, &program, sizeof program);
  setsockopt(fd.get(), SOL_SOCKET, SO_RCVBUFFORCE, &bytes, sizeof bytes);
  sockaddr_ll address{};
  address.sll_family = AF_PACKET;
  address.sll_protocol = htons(protocol);
  if (bind(fd.get(), reinterpret_cast<const sockaddr*>(&address), sizeof address) != 0) return {};
  return fd;
}

class CaptureListener final : public Listener {
 public:
  CaptureListener(Descriptor fd, const std::vector<Interface>& interfaces,
                  const std::set<std::uint16_t>& ports)
      : fd_(std::move(fd)), interfaces_(interfaces), ports_(ports) {}

  int fd() const override { return fd_.get(); }

  void Listen(Notebook& notes) override {
    for (int i = 0; i < kBatch; ++i) {
      sockaddr_ll link{};
      socklen_t length = sizeof link;
      const ssize_t size = recvfrom(fd_.get(), notes.buffer.data(), notes.buffer.size(), 0,
                                    reinterpret_cast<sockaddr*>(&link), &length);
      if (size <= 0) return;
      // Skip packets that this machine sent, or that are for another machine.
      if (link.sll_pkttype > PACKET_MULTICAST) continue;
      const auto packet =
          ParsePacket(std::span(notes.buffer).first(static_cast<std::size_t>(size)));
      if (packet) Note(*packet, static_cast<unsigned>(link.sll_ifindex), notes);
    }
  }

 private:
  void Note(const Captured& packet, unsigned interface, Notebook& notes) {
    const Sniffed what =
        packet.cut ? notes.sniffer.SniffStart(packet.payload) : notes.sniffer.Sniff(packet.payload);
    if (what.format == Format::kUnknown && !ports_.contains(packet.to.port)) return;
    const Interface* found = FindInterface(interfaces_, interface);
    notes.seen.Add({false, packet.to, packet.from, found == nullptr ? "" : found->name, notes.now_s,
                    packet.payload.size()},
                   what);
  }

  Descriptor fd_;
  std::vector<Interface> interfaces_;
  std::set<std::uint16_t> ports_;
};

}  // namespace

std::optional<Captured> ParsePacket(std::span<const std::byte> packet) {
  if (packet.size() < 20) return std::nullopt;
  Captured out;
  const unsigned version = std::to_integer<unsigned>(packet[0]) >> 4U;
  if (version == 4) {
    const std::size_t header = 4UL * (std::to_integer<unsigned>(packet[0]) & 0xFU);
    const std::size_t total = Read16(packet, 2);
    const unsigned fragment = Read16(packet, 6);
    if (header < 20 || total < header || packet.size() < header) return std::nullopt;
    if (std::to_integer<std::uint8_t>(packet[9]) != kUdp || (fragment & 0x1FFFU) != 0) {
      return std::nullopt;
    }
    out.cut = (fragment & 0x2000U) != 0;
    out.from.host = HostOf(AF_INET, packet.subspan(12, 4));
    out.to.host = HostOf(AF_INET, packet.subspan(16, 4));
    packet = packet.first(std::min(packet.size(), total));
    if (!ParseUdp(packet.subspan(header), out)) return std::nullopt;
    return out;
  }
  if (version != 6 || packet.size() < kIpv6Header ||
      std::to_integer<std::uint8_t>(packet[6]) != kUdp) {
    return std::nullopt;
  }
  out.from.host = HostOf(AF_INET6, packet.subspan(8, 16));
  out.to.host = HostOf(AF_INET6, packet.subspan(24, 16));
  packet = packet.first(std::min<std::size_t>(packet.size(), kIpv6Header + Read16(packet, 4)));
  if (!ParseUdp(packet.subspan(kIpv6Header), out)) return std::nullopt;
  return out;
}

Result<std::vector<std::unique_ptr<Listener>>> MakeCapture(const std::vector<Interface>& interfaces,
                                                           const std::set<std::uint16_t>& ports) {
  std::vector<std::unique_ptr<Listener>> listeners;
  constexpr std::array<std::pair<std::uint16_t, unsigned>, 2> kProtocols{
      {{ETH_P_IP, 9}, {ETH_P_IPV6, 6}}};
  for (const auto& [protocol, at] : kProtocols) {
    Descriptor fd = OpenSocket(protocol, at);
    if (fd.get() < 0) return Status::Error(std::strerror(errno));
    listeners.push_back(std::make_unique<CaptureListener>(std::move(fd), interfaces, ports));
  }
  return listeners;
}

}  // namespace styled::doctor
