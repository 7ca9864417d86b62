#pragma once

#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "daemon/perform/roster.h"
#include "model/base/status.h"
#include "proto/styled/v1/control.pb.h"

namespace styled::pipeline {

// Returns the request that shows a newly made style to the performers that its Like names. Empty if
// it names no performer.
std::optional<v1::Request> SetThatShows(const v1::Request& like);

// Executes control requests (control.proto) between frames, on the pipeline thread. A request is
// checked completely before anything changes. Allocates.
class Commands {
 public:
  explicit Commands(Roster& roster) : roster_(roster) {}

  // Fills the reply's code, reason and result. Returns false for GetStatus, which the pipeline
  // answers.
  bool Apply(const v1::Request& request, v1::Reply& reply);
  // Completes a Like after the files thread has made the style: sets the style for the performers
  // that the request names. Ignores other requests.
  void Show(const v1::Request& request, v1::Reply& reply);
  // Applies RenameStyle and RemoveStyle to the looks of all performers, present and future. Call
  // before the configuration is adopted. Ignores other requests.
  void FollowStyles(const v1::Request& request, v1::Reply& reply);
  // Texts for the log that name cues; "": there was none.
  struct Cues {
    std::string fired;
    std::string refused;  // those that left the performer as they were, with the reasons
  };
  // Fires the cues that the performer's timecode passed since its last frame; they take effect with
  // the current frame.
  Cues FireCues(Performer& performer, const Timecode& timecode);
  // Whether settings changed since the last call and must be saved.
  bool PopChanged() { return std::exchange(changed_, false); }
  void MarkChanged() { changed_ = true; }

 private:
  // The profiles that a request names, one or all.
  struct Targets {
    bool all = false;
    std::vector<Profile*> profiles;
  };
  // Creates a profile for an id that was not seen yet.
  Result<Targets> Find(const std::string& performer);
  void List(v1::Reply& reply) const;
  // Each executes one command and adds to `applied` of the reply; an error has a code. Changes
  // looks; `what` is the name of the command, for errors.
  Status Change(const std::string& performer, v1::Look change, const std::string& what,
                v1::Reply& reply);
  void ForgetMisnamed(const std::string& id);
  Status Pin(const v1::Request& request, v1::Reply& reply);
  void Panic(v1::Reply& reply);
  Status Fire(const v1::Cue& wanted, v1::Reply& reply);
  // Executes the request of one cue, for one performer or "*".
  Status FireOne(const Cue& cue, const std::string& performer, v1::Reply& reply);
  Status Reset(const v1::Request& request, v1::Reply& reply);

  // Copies the mix of the preset that a change names into the change.
  Status FillPreset(v1::Look& change, const std::string& what) const;
  // Applies a change to each target that allows it. With "*" the others stay as they were, and the
  // reply names them; an error means that none changed.
  Status ChangeLooks(const std::string& performer, const v1::Look& change, v1::Reply& reply);
  // `live`: the profile's performer, null if there is none.
  void Applied(const Profile& profile, const Performer* live, v1::Reply& reply) const;

  Roster& roster_;
  bool changed_ = false;
};

}  // namespace styled::pipeline
