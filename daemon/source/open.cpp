#include "daemon/source/open.h"

#include "daemon/source/delay.h"
#include "daemon/source/natnet.h"
#include "daemon/source/rigs/make.h"
#include "daemon/source/tcp.h"
#include "daemon/source/tcp_client.h"
#include "daemon/source/udp.h"
#include "daemon/source/usb/usb.h"
#include "proto/rigs/types.h"

namespace styled::source {

Result<std::unique_ptr<Transport>> Open(const config::Source& config, int source,
                                        runtime::Clock& clock, runtime::Counters& counters) {
  const rigs::SourceType& type = *rigs::FindSourceType(config.type);
  const auto make = type.usb          ? MakeUsb
                    : type.connects() ? MakeTcpClient
                    : type.stream     ? MakeTcp
                                      : MakeUdp;
  // NatNet's client opens a second socket, at an address that its server announces.
  auto opened = type.rig->asks_server && !type.connects()
                    ? MakeNatNetTransport(config, source, clock, counters)
                    : make(config, source, clock, counters, MakeTranslator(config));
  if (!opened.ok() || config.delay_s <= 0) return opened;
  return MakeDelayed(std::move(opened.value()), config.delay_s, clock);
}

}  // namespace styled::source
