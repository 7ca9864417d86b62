#pragma once

#include <cstdint>
#include <span>
#include <string_view>
#include <vector>

#include "daemon/decide/frame_in_transit.h"
#include "daemon/source/transport.h"
#include "model/base/realtime.h"
#include "proto/styled/v1/control.pb.h"
#include "proto/styled/v1/journal.pb.h"

namespace styled::log {

// Writes what the pipeline handles, in the order in which it does, for who performs it again: a
// recording (recorder.h) or a standby (standby/state_sender.h). Times are on the pipeline's clocks.
// Pipeline thread; only OnArrival is free of allocations.
class Writer {
 public:
  virtual ~Writer() = default;
  // A datagram arrived, before it is translated.
  STYLED_REALTIME virtual void OnArrival(const source::Arrival& /*arrival*/) noexcept {}
  // Frames and bodies of one source were handled together.
  virtual void OnFrames(int /*source*/, std::span<const decide::FrameInTransit> /*frames*/,
                        std::int64_t /*receive_ns*/, std::int64_t /*wall_ns*/) {}
  // Performers fell silent, or were forgotten.
  virtual void OnSilence(std::int64_t /*now_ns*/, const v1::Silence& /*silence*/) {}
  // A request was answered.
  virtual void OnRequest(std::int64_t /*now_ns*/, const v1::Request& /*request*/,
                         const v1::Reply& /*reply*/) {}
  // The configuration was read again; `weights` are in force now.
  virtual void OnReload(std::int64_t /*now_ns*/, std::string_view /*weights*/) {}
};

// All writers of this daemon; each must outlive it.
class Log final : public Writer {
 public:
  void Add(Writer* writer) {
    if (writer != nullptr) writers_.push_back(writer);
  }
  STYLED_REALTIME void OnArrival(const source::Arrival& arrival) noexcept override {
    for (Writer* const writer : writers_) writer->OnArrival(arrival);
  }
  void OnFrames(int source, std::span<const decide::FrameInTransit> frames, std::int64_t receive_ns,
                std::int64_t wall_ns) override {
    for (Writer* const writer : writers_) writer->OnFrames(source, frames, receive_ns, wall_ns);
  }
  void OnSilence(std::int64_t now_ns, const v1::Silence& silence) override {
    for (Writer* const writer : writers_) writer->OnSilence(now_ns, silence);
  }
  void OnRequest(std::int64_t now_ns, const v1::Request& request, const v1::Reply& reply) override {
    for (Writer* const writer : writers_) writer->OnRequest(now_ns, request, reply);
  }
  void OnReload(std::int64_t now_ns, std::string_view weights) override {
    for (Writer* const writer : writers_) writer->OnReload(now_ns, weights);
  }

 private:
  std::vector<Writer*> writers_;
};

}  // namespace styled::log
