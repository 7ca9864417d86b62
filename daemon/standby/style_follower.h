#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <optional>
#include <string>
#include <vector>

#include "daemon/looks/mailboxes.h"
#include "daemon/looks/places.h"
#include "daemon/perform/performance.h"
#include "daemon/standby/standby.h"
#include "proto/styled/v1/journal.pb.h"

namespace styled::standby {

// Keeps a standby's list of styles equal to the leader's. This daemon's files thread repeats the
// leader's changes of styles in order. Once all styles are complete, this daemon adopts the
// leader's places. Pipeline thread; allocates. Pinned by tests/unit/standby/following_test.cpp.
class StyleFollower {
 public:
  // All must outlive it.
  StyleFollower(Standby& standby, pipeline::Performance& performance,
                pipeline::Mailboxes& mailboxes)
      : standby_(standby), performance_(performance), mailboxes_(mailboxes) {}

  // Sets the leader's places, which come with the beginning of its state.
  void OnBeginning(const v1::Beginning& beginning);
  // A style of the leader's state. Returns false if it must be imported first; the state is then
  // fetched again.
  bool OnStyle(const v1::StylePart& part);
  // Repeats a request for styles that the leader has executed.
  void Follow(const v1::Request& request);
  // Passes queued requests to the files thread, as far as its mailbox has room.
  void PassOn();
  // The files thread has executed a request, or failed. Returns true once all are done.
  bool OnFollowed(const pipeline::Exchange& exchange);
  // The state differs because a change was not applied at the leader's frame: fetches it again once
  // all styles are done.
  void FetchAfterwards() { fetches_afterwards_ = true; }
  // This daemon follows from now on: queued requests are void.
  void Restart();
  void ForgetPlaces() { arrange_.reset(); }

 private:
  bool ImportsMissing(const std::string& file);
  void Import(const std::string& file, bool in_place = false);
  void Enqueue(v1::Request request);
  bool Push(std::unique_ptr<pipeline::Exchange>& exchange);
  void OnFading(const v1::StylePart& part);
  void ArrangeIfOther();

  Standby& standby_;
  pipeline::Performance& performance_;
  pipeline::Mailboxes& mailboxes_;
  std::deque<v1::Request> requests_;         // wait for room in the mailbox
  std::optional<pipeline::Places> arrange_;  // the leader's places, adopted after requests_
  std::optional<pipeline::Places> theirs_;   // of the state being fetched
  std::size_t fading_to_come_ = 0;           // of theirs_
  int under_way_ = 0;                        // requests passed to the files thread
  std::vector<std::string> imports_;         // files of styles in both
  bool failed_ = false;                      // a request has failed since all were done
  bool fetches_afterwards_ = false;
};

}  // namespace styled::standby
