#pragma once

#include <gtest/gtest.h>

#include <functional>
#include <map>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "tests/unit/net/erd/random_weights.h"
#include "tests/unit/standby/node.h"

namespace styled::support {

inline std::shared_ptr<pipeline::RuntimeConfig> MakeConfig() {
  auto config = std::make_shared<pipeline::RuntimeConfig>();
  config->network = erd::RandomStylizer(5, 3);
  config->own_styles = static_cast<int>(config->network->model().styles.size());
  config->weights_name = "random.safetensors";
  config->weights_crc = 0x1234;
  config->stylist.limb_gate = false;  // of random weights little is shown
  return config;
}

// Daemon a, which leads, and b, which a test starts: it follows. And a rig that both may hear.
class PairTest : public testing::Test {
 protected:
  PairTest() { Turn(1200, false); }

  // Runs both for `ms` milliseconds, in steps of 1 ms.
  void Turn(int ms, bool leader = true) {
    for (int i = 0; i < ms; ++i) {
      for (Node* const node : {a_.get(), b_.get()}) {
        if (node == nullptr || (!leader && node == b_.get())) continue;
        node->clock.now_ns += 1'000'000;
        node->Work();
      }
    }
  }
  void StartB(std::shared_ptr<const pipeline::RuntimeConfig> config = nullptr) {
    b_ = std::make_unique<Node>(wire_, false, 9, 77'000'000'000,
                                config == nullptr ? config_ : std::move(config), kTopics);
    wire_.a_asked = true;  // as a new subscription does
    Turn(100);
  }
  // The rig's datagram to both, or to one of them.
  void Send(const Bytes& datagram, bool to_a = true, bool to_b = true) {
    if (to_a && a_ != nullptr) a_->rig->waiting.push_back(datagram);
    if (to_b && b_ != nullptr) b_->rig->waiting.push_back(datagram);
  }
  void Frames(int count) {
    for (int i = 0; i < count; ++i) {
      Send(rig_.Frame());
      Turn(8);
    }
  }
  void Begin() {
    Send(rig_.Body());
    Turn(1);
  }
  static void Set(Node& node, const std::function<void(v1::Look&)>& change) {
    v1::Request request;
    request.set_performer("rig.a");
    change(*request.mutable_set());
    const v1::Reply reply = node.Ask(request);
    EXPECT_EQ(reply.code(), v1::CODE_OK) << reply.reason();
  }
  static void Wear(Node& node, const std::string& style, float transition_ms) {
    Set(node, [&](v1::Look& look) {
      auto& mix = *look.add_mix();
      mix.set_style(style);
      mix.set_weight(1);
      look.set_transition_ms(transition_ms);
    });
  }
  // A third daemon, which receives everything and follows no leader: the expected result.
  struct Alone {
    explicit Alone(PairTest& test)
        : pair(test), node(nowhere, true, 6, 5'000'000'000, test.config_, test.kTopics) {
      nowhere.cut = true;
      for (int i = 0; i < 1200; ++i) Turn(1);
    }
    // The rig's datagram to all three.
    void Send(const Bytes& datagram) {
      pair.Send(datagram);
      node.rig->waiting.push_back(datagram);
      pair.Turn(8);
      Turn(8);
    }
    void Turn(int ms) {
      node.clock.now_ns += ms * std::int64_t{1'000'000};
      node.Work();
    }

    PairTest& pair;
    Wire nowhere{};
    Node node;
  };
  // Frames by sequence as a subscriber of both daemons has them: of each number the first.
  std::map<std::uint64_t, v1::Frame> Seen() {
    std::map<std::uint64_t, v1::Frame> seen;
    for (Node* const node : {a_.get(), b_.get()}) {
      if (node == nullptr) continue;
      for (const v1::Frame& frame : node->publisher.frames) seen.emplace(frame.sequence(), frame);
    }
    return seen;
  }

  const std::vector<std::string> kTopics{"styled/rig.a/rig/"};
  std::shared_ptr<pipeline::RuntimeConfig> config_ = MakeConfig();
  Wire wire_;
  std::unique_ptr<Node> b_;
  std::unique_ptr<Node> a_ =
      std::make_unique<Node>(wire_, true, 5, 1'000'000'000'000, config_, kTopics);
  Rig rig_{"a"};
};

}  // namespace styled::support
