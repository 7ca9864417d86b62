// A complete subscriber: sets a style for all performers, then prints the position of each
// performer's head.
//   example [PUBLISHER [CONTROL [STYLE [FRAMES]]]]
#include <cstdio>
#include <cstdlib>

#include "clients/cpp/control.h"
#include "clients/cpp/subscriber.h"
#include "clients/cpp/transforms.h"
#include "model/body/humanoid.h"

int main(int argc, char** argv) {
  namespace client = styled::client;
  client::SubscriberOptions options;
  options.streams = {client::Stream::kStyledCanonical};
  if (argc > 1) options.endpoints = {argv[1]};
  auto subscriber = client::Subscriber::Connect(options);
  auto control =
      client::Control::Connect({.endpoint = argc > 2 ? argv[2] : "tcp://127.0.0.1:7002"});
  if (!subscriber.ok() || !control.ok()) {
    const auto& wrong = subscriber.ok() ? control.status() : subscriber.status();
    std::fprintf(stderr, "%s\n", wrong.message().c_str());
    return 2;
  }
  if (auto s = control.value()->SetStyle("*", argc > 3 ? argv[3] : "old", 0.8F); !s.ok()) {
    std::fprintf(stderr, "style not set: %s\n", s.reason().c_str());
  }
  const std::uint64_t enough = argc > 4 ? std::strtoull(argv[4], nullptr, 10) : ~0ULL;
  const client::SubscriberCounters& counters = subscriber.value()->counters();
  std::vector<client::Update> updates;
  std::vector<client::Transform> joints;
  // Like a renderer: frames that arrive while it draws are skipped.
  while (counters.frames < enough) {
    subscriber.value()->ReceiveLatest(std::chrono::milliseconds(1000), updates);
    for (const client::Update& u : updates) {
      if (u.kind != client::Update::Kind::kFrame || u.body == nullptr) continue;
      if (WorldTransforms(*u.body, u.frame, joints) != client::FrameError::kNone) continue;
      const auto& head = joints[styled::body::kHead].position;
      std::printf("%s %.2f %.2f %.2f m\n", u.frame.performer().c_str(), head[0], head[1], head[2]);
    }
  }
  std::fprintf(stderr, "%llu frames, %llu missed\n",
               static_cast<unsigned long long>(counters.frames),
               static_cast<unsigned long long>(counters.missed));
}
