#pragma once

#include <chrono>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "clients/cpp/curve.h"
#include "clients/cpp/reach.h"
#include "model/base/status.h"
#include "proto/styled/v1/control.pb.h"

namespace styled::client {

inline constexpr std::string_view kDefaultControl = "tcp://127.0.0.1:7002";
inline constexpr std::string_view kEveryone = "*";

// How a call ended.
class [[nodiscard]] CallStatus {
 public:
  enum class Kind {
    kOk,
    kRefused,   // the daemon said no; nothing changed. `code` and its reason
    kNoAnswer,  // nobody answered in time; it may or may not have been applied
    kGarbled,   // something answered that is not our daemon
  };

  CallStatus() = default;
  CallStatus(Kind kind, v1::Code code, std::string reason, Obstacle obstacle = Obstacle::kNone)
      : kind_(kind), code_(code), reason_(std::move(reason)), obstacle_(obstacle) {}

  bool ok() const { return kind_ == Kind::kOk; }
  Kind kind() const { return kind_; }
  v1::Code code() const { return code_; }                // CODE_OK unless kRefused
  const std::string& reason() const { return reason_; }  // empty when ok
  // Of kNoAnswer: what stands between; kNone: the daemon is there, and did not reply in time.
  Obstacle obstacle() const { return obstacle_; }

 private:
  Kind kind_ = Kind::kOk;
  v1::Code code_ = v1::CODE_OK;
  std::string reason_;
  Obstacle obstacle_ = Obstacle::kNone;
};

// The first sequence of each performer that a change is in force for.
using Applied = std::vector<v1::Applied>;

struct ControlOptions {
  std::string endpoint = std::string(kDefaultControl);
  std::chrono::milliseconds timeout{2000};  // of one call; > 0. Without an answer the call takes up
                                            // to 500 ms more, to find out why
  std::optional<Curve> curve;               // for a daemon that asks for keys
};

// Asks a daemon and changes what it does (proto/styled/v1/control.proto says what each field means,
// its range and what is refused). Each call blocks until the reply or the timeout; a reply to a
// change comes after the pipeline has applied it. `performer` is SOURCE.NAME or kEveryone; output
// parameters may be null and are untouched unless the call is ok. A request that timed out before a
// daemon was there is not sent to one that comes later.
//
// One thread at a time. Allocates. Pinned by tests/unit/clients/control_test.cpp.
class Control {
 public:
  // Refuses an endpoint that ZeroMQ cannot parse, a timeout < 1 ms, keys that are none. Nobody
  // there: no error yet.
  static Result<std::unique_ptr<Control>> Connect(const ControlOptions& options);
  ~Control();
  Control(const Control&) = delete;
  Control& operator=(const Control&) = delete;

  CallStatus List(v1::ListReply* out);
  CallStatus Status(v1::StatusReply* out);
  CallStatus Set(std::string_view performer, const v1::Set& change, Applied* applied = nullptr);
  // Set with one style at full weight; `strength` as in v1::Set.
  CallStatus SetStyle(std::string_view performer, std::string_view style, float strength = 1.0F,
                      Applied* applied = nullptr);
  CallStatus Clear(std::string_view performer, Applied* applied = nullptr);
  CallStatus Preset(std::string_view performer, const v1::Preset& preset,
                    Applied* applied = nullptr);
  CallStatus Pin(std::string_view performer, bool pinned, Applied* applied = nullptr);
  CallStatus Reset(std::string_view performer, Applied* applied = nullptr);
  CallStatus Calibrate(std::string_view performer, const v1::Calibrate& calibrate,
                       v1::CalibrateReply* out = nullptr);
  CallStatus Cue(std::string_view name, Applied* applied = nullptr);  // of the configuration
  CallStatus Panic(Applied* applied = nullptr);                       // everyone to bypass

  // Any request; `request.id` is overwritten. `reply` may not be null; it is written when something
  // of ours answered, refusals included.
  CallStatus Call(v1::Request& request, v1::Reply* reply);

 private:
  struct Impl;
  explicit Control(std::unique_ptr<Impl> impl);
  CallStatus Change(v1::Request& request, std::string_view performer, Applied* applied);
  std::unique_ptr<Impl> impl_;
};

// "UNKNOWN_STYLE" for CODE_UNKNOWN_STYLE; "CODE_<number>" for one of a newer daemon.
std::string CodeName(v1::Code code);

}  // namespace styled::client
