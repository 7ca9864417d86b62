#pragma once

#include <string>
#include <vector>

#include "clients/cpp/doctor/diagnose.h"

namespace styled::doctor {

// The work of Diagnose(): follows each source's way from step to step until one fails.
class Examination {
 public:
  explicit Examination(const Facts& facts) : facts_(facts) {}
  std::vector<Finding> Run();

 private:
  // What arrived where a source listens, or would.
  struct Evidence {
    std::vector<const Flow*> flows;
    Tally tally;
    std::uint64_t arrived = 0;  // with what the daemon counted; more than the tally, then
    std::string Senders() const;
  };

  // diagnose.cpp
  void Daemon();
  void Source(const SourceFacts& source);
  void Silent();
  void Losses();
  void KernelDrops();
  void Unclaimed();
  void Listeners();
  void Report(Severity severity, Step step, const SourceFacts* source, std::string code,
              std::string what, std::string why, std::string change);

  // diagnose_arrival.cpp; true: go on to the next step.
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
  void Performers();
  bool RefusesPerformers(const SourceFacts& source) const;  // which Performers() tells of

  // diagnose_natnet.cpp
  void NatNet(const SourceFacts& source);
  void Unasked(const SourceFacts& source);
  bool Server(const SourceFacts& source);
  bool Group(const SourceFacts& source);
  bool GroupElsewhere(const SourceFacts& source, const std::string& group);

  // What is asked of the facts.
  Evidence EvidenceOf(const SourceFacts& source) const;
  std::vector<const Flow*> Flows() const;  // heard, and seen where nothing like it was heard
  static bool Reaches(const Flow& flow, const Wanted& wanted);
  bool Claimed(const Flow& flow) const;
  bool HasLivePerformer(const SourceFacts& source) const;
  bool TwinWorks(const SourceFacts& source) const;  // another source of the same name
  std::string Label(const SourceFacts& source) const;
  std::string OwnAddresses() const;

  const Facts& facts_;
  std::vector<Finding> findings_;
  std::vector<const Flow*> explained_;  // flows that a finding spoke of
};

// "0.0.0.0:9763/udp".
std::string PlaceOf(const Wanted& wanted);

}  // namespace styled::doctor
