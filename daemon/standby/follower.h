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

// The standby's half of [standby]: performs the leader's entries in order, with the leader's
// decisions and times, so that its state equals the leader's bit for bit. Pipeline thread;
// allocates. Pinned by tests/unit/standby/following_test.cpp.
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

  // Performs an entry. While a change of styles is unfinished, queues it instead. Swaps out the
  // entry's content. `own_ns`: the time of the entry on this daemon's clock.
  void OnEntry(v1::Journal& entry, std::int64_t own_ns);
  // Performs at most `most` queued entries, unless they still wait for a style. Returns how many.
  int DoWaiting(int most);
  // Performs all queued entries, without the styles that are still missing.
  void EndWait();
  // Drops all queued entries.
  void Clear();
  // All changes of styles are finished.
  void OnStylesFollowed() { awaits_style_ = false; }

 private:
  // An entry queued behind a change of styles, so that motions change at the same frame as the
  // leader's.
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
