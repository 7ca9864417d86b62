#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "clients/doctor/diagnose.h"

namespace styled::doctor {

// Implements Diagnose(): follows each source from stage to stage until one fails.
class Examination {
 public:
  explicit Examination(const Facts& facts) : facts_(facts) {}
  std::vector<Finding> Run();

 private:
  // The data that arrived at the address of a source, or would have arrived if the daemon listened.
  struct Evidence {
    std::vector<const Flow*> flows;
    Tally tally;
    std::uint64_t arrived = 0;  // the daemon's count if there is one, otherwise the tally's sum
    std::string Senders() const;
  };

  // diagnose.cpp
  void Daemon();
  void Source(const SourceFacts& source);
  void Silent();
  void Losses();
  void KernelDrops();
  std::string Losers() const;
  std::string MergeInto(Format format) const;
  bool TwoPhones();
  void Unclaimed();
  void Listeners();
  void Report(Severity severity, Step step, const SourceFacts* source, std::string code,
              std::string what, std::string why, std::string change);

  // diagnose_arrival.cpp. True: continue with the next stage.
  bool Port(const SourceFacts& source);
  bool Arrival(const SourceFacts& source, const Evidence& evidence);
  bool ArrivesElsewhere(const SourceFacts& source);
  void Nothing(const SourceFacts& source);
  bool WrongAddress(const SourceFacts& source);
  bool WrongPort(const SourceFacts& source);
  bool Filtered(const SourceFacts& source, std::uint16_t port);

  // diagnose_content.cpp
  bool Content(const SourceFacts& source, const Evidence& evidence);
  bool Use(const SourceFacts& source, const Tally& tally);
  bool CountersOfContent(const SourceFacts& source, const Evidence& evidence);
  void Frames(const SourceFacts& source, const Evidence& evidence);
  void NoSkeleton(const SourceFacts& source, const std::string& why);

  // diagnose_performers.cpp
  void Clock();
  void Standby();
  void StandbyLinks(const v1::StandbyState& standby);
  void Performers();
  bool RefusesPerformers(const SourceFacts& source) const;  // if so, Performers() reports it

  // diagnose_counters.cpp
  void Counters();
  void Lateness();
  void Recording();
  bool Reported(std::string_view code) const;  // a finding of that code is there

  // diagnose_natnet.cpp
  void NatNet(const SourceFacts& source);
  void Unasked(const SourceFacts& source);
  bool Server(const SourceFacts& source);
  bool Group(const SourceFacts& source);
  bool GroupElsewhere(const SourceFacts& source, const std::string& group);

  // diagnose_qtm.cpp
  void Qtm(const SourceFacts& source);

  // Queries on the facts.
  Evidence EvidenceOf(const SourceFacts& source) const;
  // The part of a counter's growth that must be the source's. The daemon counts all sources
  // together: the growth that the datagrams of other sources may explain is not attributed to this
  // one.
  std::uint64_t GrownOf(const SourceFacts& source, const std::string& counter) const;
  // What to check in the source's sender.
  static std::string InTheSender(const ExpectedSource& expected);
  // Those in `heard`, and those in `seen` that have no counterpart in `heard`.
  std::vector<const Flow*> Flows() const;
  static bool Reaches(const Flow& flow, const ExpectedSource& expected);
  bool Claimed(const Flow& flow) const;
  bool HasLivePerformer(const SourceFacts& source) const;
  // Whether the source has a live performer, or another source of the same name receives datagrams.
  bool TwinWorks(const SourceFacts& source) const;
  std::string Label(const SourceFacts& source) const;
  std::string OwnAddresses() const;

  const Facts& facts_;
  std::vector<Finding> findings_;
  std::vector<const Flow*> explained_;  // flows that a finding has already explained
};

// A counter of the daemon; 0 if it has none of that name.
std::uint64_t ValueOf(const v1::StatusReply& status, const std::string& counter);

// "0.0.0.0:9763/udp".
std::string PlaceOf(const ExpectedSource& expected);

}  // namespace styled::doctor
