#pragma once

#include <chrono>
#include <memory>
#include <optional>
#include <stop_token>
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
    kRefused,   // the daemon refused the request and changed nothing; see `code` and `reason`
    kNoAnswer,  // no reply in time; the daemon may or may not have applied the request
    kGarbled,   // the reply did not come from a styled daemon
  };

  CallStatus() = default;
  CallStatus(Kind kind, v1::Code code, std::string reason, Obstacle obstacle = Obstacle::kNone)
      : kind_(kind), code_(code), reason_(std::move(reason)), obstacle_(obstacle) {}

  bool ok() const { return kind_ == Kind::kOk; }
  Kind kind() const { return kind_; }
  v1::Code code() const { return code_; }                // CODE_OK unless kRefused
  const std::string& reason() const { return reason_; }  // empty when ok
  // For kNoAnswer: what prevents the connection. kNone means that the daemon is reachable, but did
  // not reply in time.
  Obstacle obstacle() const { return obstacle_; }

 private:
  Kind kind_ = Kind::kOk;
  v1::Code code_ = v1::CODE_OK;
  std::string reason_;
  Obstacle obstacle_ = Obstacle::kNone;
};

// For each performer, the first frame sequence at which a change is in force.
using Applied = std::vector<v1::Applied>;

struct ControlOptions {
  // For a pair with a standby, both addresses, with a comma: a request that one of them does not
  // answer, or refuses as the standby, is sent to the other.
  std::string endpoint = std::string(kDefaultControl);
  // Per call, >= 1 ms. Without a reply, a call takes up to 500 ms more to find out why.
  std::chrono::milliseconds timeout{2000};
  std::optional<Curve> curve;  // for a daemon that requires keys
  std::stop_token stop;        // ends a call early, without an answer
};

// Queries and controls a running daemon. proto/styled/v1/control.proto defines each field, its
// range, and what is refused. Each call blocks until the reply or the timeout. The reply to a
// change is sent after the pipeline has applied the change. `performer` is SOURCE.NAME or
// kEveryone. Output parameters may be null; they are written only when the call is ok. A request
// that times out before a daemon is there is discarded: a daemon that starts later does not receive
// it.
//
// One thread at a time. Allocates. Pinned by tests/unit/clients/control_test.cpp.
class Control {
 public:
  // Connects in the background; a missing daemon is not an error. Refuses an endpoint that ZeroMQ
  // cannot parse, a timeout < 1 ms, and invalid keys.
  static Result<std::unique_ptr<Control>> Connect(const ControlOptions& options);
  ~Control();
  Control(const Control&) = delete;
  Control& operator=(const Control&) = delete;

  CallStatus List(v1::ListReply* out);
  CallStatus Status(v1::StatusReply* out);
  CallStatus Set(std::string_view performer, const v1::Look& change, Applied* applied = nullptr);
  // Set() with one style at full weight; `strength` as in v1::Look.
  CallStatus SetStyle(std::string_view performer, std::string_view style, float strength = 1.0F,
                      Applied* applied = nullptr);
  CallStatus Clear(std::string_view performer, Applied* applied = nullptr);
  CallStatus Preset(std::string_view performer, const v1::Preset& preset,
                    Applied* applied = nullptr);
  CallStatus Pin(std::string_view performer, bool pinned, Applied* applied = nullptr);
  CallStatus Reset(std::string_view performer, Applied* applied = nullptr);
  CallStatus Calibrate(std::string_view performer, const v1::Calibrate& calibrate,
                       v1::CalibrateReply* out = nullptr);
  // Makes a style from an example, for all clients; with `performer` "" no performer is set to it.
  CallStatus Like(std::string_view performer, const v1::Like& like, v1::LikeReply* out = nullptr,
                  Applied* applied = nullptr);
  // For styles that Like or an import has made.
  CallStatus ExportStyle(std::string_view name, v1::StyleFile* out);
  CallStatus ImportStyle(const v1::ImportStyle& file, v1::LikeReply* out = nullptr);
  CallStatus RenameStyle(std::string_view name, std::string_view to, Applied* applied = nullptr);
  CallStatus RemoveStyle(std::string_view name, Applied* applied = nullptr);
  // What became of a performer's last frames, and why.
  CallStatus Explain(std::string_view performer, const v1::Explain& which, v1::ExplainReply* out);
  // A small moving figure of any style.
  CallStatus Preview(std::string_view style, v1::PreviewReply* out);
  // A performer's state, for this daemon or another one (checkpoint.proto). With `performer` "" it
  // is restored under its own name.
  CallStatus TakeCheckpoint(std::string_view performer, v1::Checkpoint* out);
  CallStatus RestoreCheckpoint(std::string_view performer, const v1::Checkpoint& checkpoint,
                               Applied* applied = nullptr);
  // To a standby: makes it the leader.
  CallStatus Lead();
  // `name`: a cue of the daemon's configuration.
  CallStatus Cue(std::string_view name, Applied* applied = nullptr);
  CallStatus Panic(Applied* applied = nullptr);  // all performers to bypass

  // Sends any request and overwrites `request.id`. `reply` must not be null; it is written when the
  // daemon replied, refusals included.
  CallStatus Call(v1::Request& request, v1::Reply* reply);

 private:
  struct Impl;
  CallStatus CallOne(v1::Request& request, v1::Reply* reply);
  explicit Control(std::unique_ptr<Impl> impl);
  CallStatus Change(v1::Request& request, std::string_view performer, Applied* applied);
  template <typename Out>
  CallStatus Ask(v1::Request& request, Out* (v1::Reply::*of)(), Out* out);
  std::unique_ptr<Impl> impl_;
};

// "UNKNOWN_STYLE" for CODE_UNKNOWN_STYLE; "CODE_<number>" for a code of a newer daemon.
std::string CodeName(v1::Code code);

// The parts that other sources provide for the performer: "face: phone (live), fingers: gloves
// (silent)"; "": none.
std::string LayersText(const v1::PerformerStats& performer);

}  // namespace styled::client
