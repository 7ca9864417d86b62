#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <span>
#include <string>
#include <vector>

#include "daemon/config/config.h"
#include "daemon/log/writer.h"
#include "daemon/perform/performance.h"
#include "daemon/standby/standby.h"
#include "proto/styled/v1/journal.pb.h"

namespace styled::standby {

// The "checkpoint" of performers who are not here: the number with which their frames may begin.
inline constexpr const char* kJournalSequences = "*";

// The leader's part of [standby]: sends what the leader handles, entry by entry, and its whole
// state when the standby asks for it. While this daemon follows, it sends nothing. Pipeline thread;
// allocates. Pinned by tests/unit/standby.
class StateSender final : public log::Writer {
 public:
  // Both must outlive it.
  StateSender(Standby& standby, pipeline::Performance& performance)
      : standby_(standby), performance_(performance) {}

  // Sends at most one part of the state, so that no frame waits for all of them. Whoever asks
  // meanwhile waits for the end. Returns how much was done.
  int DoWork();
  // The standby gets the whole state again, as after a change of the leader's configuration.
  void Resend() { resend_ = true; }
  // Drops what is unsent: the role has changed.
  void Clear();
  // What decides the poses, for the other daemon to compare (setup.h). Call again after a change.
  void AdvertiseSetup(const std::vector<config::Source>& sources);
  void AdvertiseSetup();

  void OnFrames(int source, std::span<const decide::FrameInTransit> frames, std::int64_t receive_ns,
                std::int64_t wall_ns) override;
  void OnSilence(std::int64_t now_ns, const v1::Silence& silence) override;
  void OnRequest(std::int64_t now_ns, const v1::Request& request, const v1::Reply& reply) override;

 private:
  // One part of the state.
  struct Part {
    enum class Kind : std::uint8_t { kSettings, kStyle, kFading, kCheckpoint };
    Kind kind = Kind::kSettings;
    std::string name{};     // a style's, or a performer's id
    std::size_t place = 0;  // of kFading
  };

  // Whether an entry is sent; one that nobody listens for is only counted.
  bool Sends();
  void SendBeginning();
  void SendPart();
  void FillSettings(v1::SettingsPart& part);
  void FillStyle(const std::string& name, v1::StylePart& part);
  void FillFading(const Part& from, v1::StylePart& part);
  void FillCheckpoint(const std::string& id, v1::Checkpoint& checkpoint);
  bool IsNamed(int style) const;

  Standby& standby_;
  pipeline::Performance& performance_;
  bool resend_ = false;
  std::deque<Part> unsent_;
  std::deque<std::string> unsent_settings_;   // ids, of the parts kSettings
  std::vector<v1::Setting> source_settings_;  // of the [[source]] tables
};

}  // namespace styled::standby
