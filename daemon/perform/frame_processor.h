#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string_view>

#include "daemon/decide/frame_in_transit.h"
#include "daemon/log/entry.h"
#include "daemon/perform/performance.h"
#include "daemon/perform/postponed.h"
#include "daemon/runtime/helpers.h"
#include "daemon/runtime/realtime.h"
#include "daemon/source/source_frame.h"
#include "daemon/source/transport.h"
#include "model/stylist/stylist.h"

namespace styled::pipeline {

// Frames and bodies of one source that are processed together, at most source::kBatch.
struct Batch {
  int source = 0;
  std::span<const source::SourceFrame> frames;
  bool more_waiting = false;  // the source's socket may hold newer frames
  bool keep_all = false;      // no frame is skipped, and no body waits for a later turn
  // On a standby: the leader's decision for each frame. Empty: this daemon decides.
  std::span<const decide::FrameInTransit> leaders{};
};

// Decisions that were made elsewhere, by the daemon that made a recording. Pipeline thread.
class RecordedDecisions {
 public:
  virtual ~RecordedDecisions() = default;
  // The decision of each of these frames, for Batch::leaders; empty if one of them is unknown.
  virtual std::span<const decide::FrameInTransit> Of(
      int source, std::span<const source::SourceFrame> frames) = 0;
};

// Processes frames from the rig to the subscribers: each frame is decided (decide::Decider), styled
// together with those of other performers, serialized and sent; bodies are bound. From a
// performer's second frame on, nothing between receive and zmq_send allocates, locks, logs or
// throws (tests/realtime). Pipeline thread. Pinned by tests/unit/daemon/pipeline/pipeline_test.cpp
// and tests/golden.
class FrameProcessor {
 public:
  // `logs_poses`: frames in the log carry their styled pose, for a standby to compare. `helpers`
  // style and serialize frames beside the pipeline thread, with the same results bit for bit; null:
  // that thread does it alone. `performance` and `helpers` must outlive it.
  FrameProcessor(Performance& performance, bool logs_poses, runtime::Helpers* helpers)
      : performance_(performance), logs_poses_(logs_poses), helpers_(helpers) {}

  // Returns the fate of each frame, valid until the next call. It is in the log already.
  std::span<const decide::FrameInTransit> Process(const Batch& batch);
  // Begins a turn, and processes the bodies and frames that waited for it. Returns how many.
  int DoPostponed();
  void DropPostponed() { postponed_.Clear(); }
  std::int64_t receive_ns() const { return receive_ns_; }  // of the last batch

 private:
  void ProcessLayer(Layer& layer, const Batch& batch, runtime::HotSection& hot);
  void AcceptLayerBody(FingerLayer& fingers, int source, const source::SourceFrame& body);
  STYLED_REALTIME void NoteNewest(int source, std::size_t at) noexcept;
  bool Postpones(const Batch& batch, const source::SourceFrame& frame, bool behind);
  void ProcessFrame(const Batch& batch, std::size_t at, runtime::HotSection& hot);
  void MakeWay(const Performer& performer, runtime::HotSection& hot);
  STYLED_REALTIME decide::Decision Decide(const Batch& batch, std::size_t at,
                                          Performer& performer) noexcept;
  STYLED_REALTIME void CountArrival(Performer& performer,
                                    const decide::Decision& decision) noexcept;
  STYLED_REALTIME void Refuse(Performer& performer, const decide::FrameInTransit& transit) noexcept;
  STYLED_REALTIME void FillFrame(const Performer& performer,
                                 decide::FrameInTransit& transit) const noexcept;
  void PassCues(Performer& performer, const Timecode& timecode, runtime::HotSection& hot);
  void StyleAccepted(runtime::HotSection& hot);
  template <typename Work>
  void Share(std::size_t count, const Work& work) noexcept;
  std::size_t MostInGroup() const noexcept;
  void LogPoses(std::span<Performer* const> performers);
  STYLED_REALTIME void ShareProps(Performer& performer) noexcept;
  STYLED_REALTIME void MeasureLatencies(const Batch& batch, bool bundled) noexcept;
  void ProcessBody(int source, decide::FrameInTransit& transit);
  void RefuseBody(Performer& performer, decide::FrameInTransit& transit);
  void AdoptBody(Performer& performer, decide::FrameInTransit& transit, bool fresh);
  // Arrival of the frame on the clock's Now_ns(), not later than that of its batch.
  STYLED_REALTIME std::int64_t ArrivalOf(const source::SourceFrame& frame) const noexcept {
    return frame.arrival_ns == 0 ? receive_ns_ : std::min(frame.arrival_ns, receive_ns_);
  }

  Performance& performance_;
  const bool logs_poses_;
  runtime::Helpers* const helpers_;
  std::int64_t receive_ns_ = 0, wall_ns_ = 0;                   // of the current batch, or the last
  std::array<decide::FrameInTransit, source::kBatch> transit_;  // its frames and bodies
  std::array<Performer*, source::kBatch> whose_{};              // null: unknown yet, or a body
  std::array<log::RoundedPose, source::kBatch> rounded_poses_;  // with logs_poses_
  // The group that is styled together, one frame per performer, and their indices in the batch.
  std::array<Performer*, source::kBatch> accepted_{};
  std::array<std::size_t, source::kBatch> accepted_at_{};
  std::size_t accepted_count_ = 0;
  decide::Overload::Batch load_;  // of the current batch
  Postponed postponed_;
};

}  // namespace styled::pipeline
