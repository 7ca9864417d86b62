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

// Makes a standby's list of styles the leader's: what the leader did to styles is done by this
// daemon's files thread, in the leader's order, and its places are taken over once all styles are
// here. Pipeline thread; allocates. Pinned by tests/unit/standby/following_test.cpp.
class StyleFollower {
 public:
  // All must outlive it.
  StyleFollower(Standby& standby, pipeline::Performance& performance,
                pipeline::Mailboxes& mailboxes)
      : standby_(standby), performance_(performance), mailboxes_(mailboxes) {}

  // The leader's places, which come with the beginning of its state.
  void OnBeginning(const v1::Beginning& beginning);
  // A style of the leader's state. False: it is imported first, and the state then fetched again.
  bool OnStyle(const v1::StylePart& part);
  // A request of the leader's about styles.
  void Follow(const v1::Request& request);
  // Hands what waits to the files thread, as far as its mailbox has room.
  void PassOn();
  // The files thread did one of them, or could not. Returns true once all are done.
  bool OnFollowed(const pipeline::Exchange& exchange);
  // What was not done at the leader's frame makes the state differ: it is fetched again once all
  // styles are done.
  void FetchAfterwards() { fetches_afterwards_ = true; }
  // This daemon follows from now on: what waits is void.
  void Restart();
  void ForgetPlaces() { arrange_.reset(); }

 private:
  bool ImportsMissing(const std::string& file);
  void Import(const std::string& file);
  void Enqueue(v1::Request request);
  bool Push(std::unique_ptr<pipeline::Exchange>& exchange);
  void OnFading(const v1::StylePart& part);
  void ArrangeIfOther();

  Standby& standby_;
  pipeline::Performance& performance_;
  pipeline::Mailboxes& mailboxes_;
  std::deque<v1::Request> requests_;         // that wait for room in the mailbox
  std::optional<pipeline::Places> arrange_;  // the leader's places, to be taken over after those
  std::optional<pipeline::Places> theirs_;   // of the state that is being fetched
  std::size_t fading_to_come_ = 0;           // of theirs_
  int under_way_ = 0;                        // handed to the files thread
  std::vector<std::string> imports_;         // files of styles among both
  bool failed_ = false;                      // one, since all were done
  bool fetches_afterwards_ = false;
};

}  // namespace styled::standby
