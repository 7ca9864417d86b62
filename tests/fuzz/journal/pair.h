#pragma once

#include <functional>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "proto/styled/v1/control.pb.h"
#include "tests/support/rig.h"
#include "tests/unit/net/erd/random_weights.h"
#include "tests/unit/standby/node.h"

namespace styled::fuzz {

// A leader, its standby, and a rig that sends to both at 120 Hz; both show all frames.
class Pair {
 public:
  // `spy`: hears what the leader says, from the beginning.
  explicit Pair(std::function<void(const std::string&)> spy = nullptr) {
    wire.spy = std::move(spy);
    leader_ = Make(true, 5, 1'000'000'000'000);
    Turn(1200);
    Give(rig_.Body());
    Turn(1);
    standby_ = Make(false, 9, 77'000'000'000);
    wire.a_asked = true;  // as a new subscription does
    Frames(20);
  }

  void Turn(int ms) {
    for (int i = 0; i < ms; ++i) {
      for (support::Node* const node : {leader_.get(), standby_.get()}) {
        if (node == nullptr) continue;
        node->clock.now_ns += 1'000'000;
        node->Work();
        (void)node->Lines();
        std::unique_ptr<std::vector<pipeline::Profile>> kept;
        while (node->mailboxes.profiles.Pop(kept)) {
        }
      }
    }
  }
  void Frames(int count) {
    for (int i = 0; i < count; ++i) {
      if (i % 10 == 0) Give(rig_.Body());
      Give(rig_.Frame());
      Turn(8);
    }
  }
  void Kill() { leader_.reset(); }
  support::Node& leader() { return *leader_; }
  support::Node& standby() { return *standby_; }

  support::Wire wire;

 private:
  std::unique_ptr<support::Node> Make(bool leader, std::uint64_t id, std::int64_t start_ns) {
    static const auto config = [] {
      auto made = std::make_shared<pipeline::RuntimeConfig>();
      made->network = erd::RandomStylizer(5, 3);
      made->own_styles = static_cast<int>(made->network->model().styles.size());
      made->weights_name = "random.safetensors";
      made->weights_crc = 0x1234;
      return made;
    }();
    return std::make_unique<support::Node>(wire, leader, id, start_ns, config, "styled/", leader);
  }
  void Give(const support::Bytes& datagram) {
    for (support::Node* const node : {leader_.get(), standby_.get()}) {
      if (node != nullptr) node->rig->waiting.push_back(datagram);
    }
  }

  std::unique_ptr<support::Node> leader_, standby_;
  support::Rig rig_{"a", 1001};
};

}  // namespace styled::fuzz
