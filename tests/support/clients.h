#pragma once

#include <atomic>
#include <cstdint>
#include <functional>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "proto/styled/v1/body.pb.h"
#include "proto/styled/v1/control.pb.h"
#include "proto/styled/v1/frame.pb.h"
#include "proto/styled/v1/stats.pb.h"

namespace styled::support {

// One message of the publisher, as received.
struct Message {
  std::string topic, payload;
};

// For a daemon that requires keys (Z85); empty: none.
struct CurveKeys {
  std::string server_key, public_key, secret_key;
};

// A subscriber that collects everything it receives on its own thread. Call its functions on the
// test's thread.
class Subscriber {
 public:
  Subscriber(const std::string& endpoint, const std::vector<std::string>& topics,
             const CurveKeys& keys = {});
  ~Subscriber();
  Subscriber(const Subscriber&) = delete;
  Subscriber& operator=(const Subscriber&) = delete;

  // Frames and bodies received so far, on topics that begin with `prefix`.
  std::vector<v1::Frame> Frames(const std::string& prefix = "") const;
  std::vector<Message> Messages(const std::string& prefix) const;  // as they came
  std::size_t Count(const std::string& prefix) const;              // of messages
  std::vector<v1::Body> Bodies() const;
  std::optional<v1::Stats> LastStats() const;
  // Waits until `done` returns true; false after `seconds`.
  bool WaitFor(const std::function<bool()>& done, double seconds) const;
  bool WaitForFrames(std::size_t count, const std::string& prefix = "", double seconds = 10) const;
  // Waits for any body: afterwards the publisher certainly knows the subscriptions.
  bool WaitForBody(double seconds = 10) const;

 private:
  void Run();
  void* context_;
  void* socket_;
  std::atomic<bool> stop_{false};
  mutable std::mutex mutex_;
  std::vector<Message> messages_;
  std::thread thread_;
};

// A control client: DEALER, one request at a time.
class ControlClient {
 public:
  explicit ControlClient(const std::string& endpoint, const CurveKeys& keys = {});
  ~ControlClient();
  ControlClient(const ControlClient&) = delete;
  ControlClient& operator=(const ControlClient&) = delete;

  // The reply. If none arrives within 5 s (SetPatience), one with CODE_BUSY and reason "no reply".
  v1::Reply Ask(v1::Request request);
  // Sends the parts unchanged.
  v1::Reply AskRaw(const std::vector<std::string>& parts);

  void SetPatience(double seconds);

  v1::Reply SetStyle(const std::string& performer, const std::string& style, float weight = 1,
                     float transition_ms = -1);
  v1::StatusReply Status();
  std::uint64_t Counter(const std::string& name);
  // Waits until the counter has `value`; returns its last value.
  std::uint64_t CounterSoon(const std::string& name, std::uint64_t value);
  v1::PerformerStats Performer(const std::string& id);

 private:
  void* context_;
  void* socket_;
  std::uint64_t next_id_ = 1;
};

}  // namespace styled::support
