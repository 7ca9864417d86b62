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

// Interface of a log: receives all input of the pipeline in order, so that a reader can process it
// again. A recording (recorder.h) or the journal for a standby (standby/state_sender.h). Times are
// on the pipeline's clocks. Pipeline thread; only OnArrival is free of allocations.
class Writer {
 public:
  virtual ~Writer() = default;
  // A datagram arrived; it is not decoded yet.
  STYLED_REALTIME virtual void OnArrival(const source::Arrival& /*arrival*/) noexcept {}
  // Frames and bodies of one source were processed together.
  virtual void OnFrames(int /*source*/, std::span<const decide::FrameInTransit> /*frames*/,
                        std::int64_t /*receive_ns*/, std::int64_t /*wall_ns*/) {}
  // Performers fell silent or were forgotten.
  virtual void OnSilence(std::int64_t /*now_ns*/, const v1::Silence& /*silence*/) {}
  // A request was answered.
  virtual void OnRequest(std::int64_t /*now_ns*/, const v1::Request& /*request*/,
                         const v1::Reply& /*reply*/) {}
  // The configuration was read again; `weights` are in force now.
  virtual void OnReload(std::int64_t /*now_ns*/, std::string_view /*weights*/) {}
};

// Passes each event to all writers of this daemon. Writers must outlive it.
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
