#pragma once

#include <cstdint>
#include <deque>
#include <memory>
#include <vector>

#include "daemon/perform/frame_processor.h"
#include "daemon/perform/performance.h"
#include "daemon/source/transport.h"
#include "daemon/standby/standby.h"
#include "daemon/standby/style_follower.h"
#include "proto/styled/v1/journal.pb.h"

namespace styled::standby {

// The standby's part of [standby]: performs what the leader has handled, entry by entry, with the
// leader's decisions at the leader's times, so that it has the leader's state bit for bit. Pipeline
// thread; allocates. Pinned by tests/unit/standby/following_test.cpp.
class Follower {
 public:
  using Transports = std::vector<std::unique_ptr<source::Transport>>;

  // All must outlive it.
  Follower(Standby& standby, pipeline::Performance& performance, pipeline::FrameProcessor& frames,
           const Transports& transports, StyleFollower& styles)
      : standby_(standby),
        performance_(performance),
        frames_(frames),
        transports_(transports),
        styles_(styles) {}

  // Performs an entry, or keeps it behind a change of styles that is not done here yet. Swaps the
  // entry's content out. `own_ns`: when the leader did it, on this daemon's clock.
  void OnEntry(v1::Journal& entry, std::int64_t own_ns);
  // Performs at most `most` entries of those that wait, if they need not wait any longer. Returns
  // how many.
  int DoWaiting(int most);
  // Performs all that wait, without the styles that are not here yet.
  void EndWait();
  // Drops all that wait.
  void Clear();
  // The changes of styles are done.
  void OnStylesFollowed() { awaits_style_ = false; }

 private:
  // An entry behind a change of styles, so that motions change at the leader's frame.
  struct Waiting {
    v1::Journal entry;
    std::int64_t own_ns = 0;   // as of OnEntry
    std::int64_t read_ns = 0;  // when it was read here
  };

  void PerformFirst();
  void Perform(const v1::Journal& entry, std::int64_t own_ns);
  void OnBeginning(const v1::Journal& entry);
  void OnSettings(const v1::SettingsPart& part);
  void OnCheckpoint(const v1::Checkpoint& checkpoint);
  void OnBatch(const v1::Batch& batch, std::int64_t own_ns);
  void OnSilence(const v1::Silence& silence, std::int64_t own_ns);
  void OnRequest(const v1::Request& request);

  Standby& standby_;
  pipeline::Performance& performance_;
  pipeline::FrameProcessor& frames_;
  const Transports& transports_;
  StyleFollower& styles_;
  bool awaits_style_ = false;
  std::int64_t awaits_since_ns_ = 0;
  std::deque<Waiting> waiting_;
};

}  // namespace styled::standby
