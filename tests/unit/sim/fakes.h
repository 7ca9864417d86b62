#pragma once

#include <vector>

#include "proto/rigs/native/datagram.h"
#include "proto/styled/v1/body.pb.h"
#include "proto/styled/v1/frame.pb.h"
#include "sim/player/clock.h"
#include "sim/player/link.h"
#include "sim/player/motion.h"

namespace styled::player::testing {

// Time moves when slept, and by `cost_ns` with every look.
class FakeClock final : public Clock {
 public:
  std::int64_t Now_ns() override { return now_ns += cost_ns; }
  void SleepUntil(std::int64_t deadline_ns) override {
    ++sleeps;
    now_ns = std::max(now_ns, deadline_ns + oversleep_ns);
  }
  std::int64_t now_ns = 1'000'000'007, cost_ns = 0, oversleep_ns = 0;
  int sleeps = 0;
};

// Keeps what is sent, with the time.
class FakeLink final : public Link {
 public:
  explicit FakeLink(FakeClock* clock = nullptr) : clock_(clock) {}
  Status Send(std::span<const std::byte> datagram) override {
    sent.emplace_back(datagram.begin(), datagram.end());
    times_ns.push_back(clock_ == nullptr ? 0 : clock_->now_ns);
    return fail ? Status::Error("no link") : Status::Ok();
  }
  std::vector<std::vector<std::byte>> sent;
  std::vector<std::int64_t> times_ns;
  std::uint64_t refused() override { return refusing ? sent.size() : 0; }
  bool fail = false;
  bool refusing = false;  // every datagram

 private:
  FakeClock* clock_;
};

// `count` frames of two joints; root x counts the frames. `parts` bodies one after the other.
class FakeMotion final : public Motion {
 public:
  explicit FakeMotion(int count, int parts = 1) : count_(count), parts_(parts) {
    body_.skeleton = {{"root", "tip"}, {-1, 0}, {rig::Vec3(0, 1, 0), rig::Vec3(0, 0.5F, 0)}};
    body_.dialect = "fake";
  }
  const RigBody& body() const override { return body_; }
  Step Next(rig::RigPose& pose) override {
    if (made_ == count_) {
      if (--parts_ == 0) return Step::kEnd;
      made_ = 0;
      body_.skeleton.names[1] += "x";
      return Step::kNewBody;
    }
    pose = rig::RigPose(body_.skeleton);
    pose.translations[0].x() = static_cast<float>(made_++);
    return Step::kPose;
  }

 private:
  RigBody body_;
  int count_, parts_, made_ = 0;
};

// A datagram taken apart.
struct Received {
  native::Datagram header;
  native::DecodeResult result;  // behind the header that Decode() fills
  v1::Body body;
  v1::SourceFrame frame;

  explicit Received(const std::vector<std::byte>& bytes) : result(native::Decode(bytes, header)) {
    if (result != native::DecodeResult::kOk) return;
    const auto size = static_cast<int>(header.payload.size());
    const bool parsed = header.kind == native::Kind::kBody
                            ? body.ParseFromArray(header.payload.data(), size)
                            : frame.ParseFromArray(header.payload.data(), size);
    if (!parsed) result = native::DecodeResult::kCount;
  }
  bool is_body() const {
    return result == native::DecodeResult::kOk && header.kind == native::Kind::kBody;
  }
  bool is_frame() const {
    return result == native::DecodeResult::kOk && header.kind == native::Kind::kSourceFrame;
  }
};

inline std::vector<Received> Receive(const FakeLink& link) {
  std::vector<Received> all;
  for (const auto& bytes : link.sent) all.emplace_back(bytes);
  return all;
}

}  // namespace styled::player::testing
