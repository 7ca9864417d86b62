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

// Name of the "checkpoint" for future performers: the first sequence number of their frames.
inline constexpr const char* kJournalSequences = "*";

// The leader's half of [standby]: sends each processed entry, and its whole state when the standby
// requests it. While this daemon follows, it sends nothing. Pipeline thread; allocates. Pinned by
// tests/unit/standby.
class StateSender final : public log::Writer {
 public:
  // Both must outlive it.
  StateSender(Standby& standby, pipeline::Performance& performance)
      : standby_(standby), performance_(performance) {}

  // Sends at most one part of the state, so that frames do not wait for all of them. Requests
  // during the transfer wait for its end. Returns the number of messages read and sent.
  int DoWork();
  // Sends the whole state again, for example after a change of the leader's configuration.
  void Resend() { resend_ = true; }
  // Drops unsent parts, because the role has changed.
  void Clear();
  // Sets the configuration that the peer compares with its own (setup.h). Call again after a
  // change.
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

  // Whether entries are sent; without a connected standby they are only counted.
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
