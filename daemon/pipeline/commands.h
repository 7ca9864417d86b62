#pragma once

#include <string>
#include <utility>
#include <vector>

#include "daemon/pipeline/roster.h"
#include "proto/styled/v1/control.pb.h"

namespace styled::pipeline {

// What control requests mean (control.proto), applied between frames, on the pipeline thread. A
// request is checked whole before anything changes. Allocates.
class Commands {
 public:
  explicit Commands(Roster& roster) : roster_(roster) {}

  // Fills the reply's code, reason and answer. GetStatus is the pipeline's to answer: false for it.
  bool Apply(const v1::Request& request, v1::Reply& reply);
  // Fires the cues that the performer's timecode passed since his last frame; they are in force
  // from the frame at hand on. True where there was one: `said` then names them for the log.
  bool Pass(Performer& performer, const Timecode& timecode, std::string& said);
  // Whether settings changed since the last call: time to keep them.
  bool PopChanged() { return std::exchange(changed_, false); }
  void MarkChanged() { changed_ = true; }

 private:
  // The profiles that a request names, one or all; empty, and the reply says why, on an error.
  struct Targets {
    bool ok = false, all = false;
    std::vector<Profile*> profiles;
  };
  // An id not yet seen gets its profile.
  Targets Find(const std::string& performer, v1::Reply& reply);
  void List(v1::Reply& reply) const;
  // A change of looks, by the command that `what` names.
  void Change(const std::string& performer, v1::Look change, const std::string& what,
              v1::Reply& reply);
  void ForgetMisnamed(const std::string& id);
  void Pin(const v1::Request& request, v1::Reply& reply);
  void Panic(v1::Reply& reply);
  void Fire(const v1::Cue& wanted, v1::Reply& reply);
  // The request of one cue, for one performer or "*".
  void FireOne(const Cue& cue, const std::string& performer, v1::Reply& reply);
  void Reset(const v1::Request& request, v1::Reply& reply);

  // The mix of the preset that a change names, into the change; false where there is none.
  bool FillPreset(v1::Look& change, const std::string& what, v1::Reply& reply) const;
  // Applies a checked change to each target, all or none.
  void ChangeLooks(const std::string& performer, const v1::Look& change, v1::Reply& reply);
  void Applied(const Profile& profile, v1::Reply& reply) const;

  Roster& roster_;
  bool changed_ = false;
};

}  // namespace styled::pipeline
