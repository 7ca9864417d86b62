#pragma once

#include <cstdint>
#include <memory>
#include <set>
#include <string>
#include <vector>

#include "clients/cpp/doctor/interfaces.h"
#include "clients/cpp/doctor/listener.h"
#include "model/base/status.h"

namespace styled::doctor {

// How a port of this machine could be listened on.
struct PortState {
  enum class Kind {
    kHeard,   // on every address
    kPartly,  // on the addresses that another program left
    kTaken,   // on none: another program has it on every address
    kRefused  // the system says no: `why`
  };
  bool stream = false;
  std::uint16_t port = 0;
  Kind kind = Kind::kHeard;
  std::vector<std::string> hosts;  // kPartly: where we listen
  std::string why;                 // kRefused
};

// A multicast group on one interface.
struct GroupState {
  std::string group;
  std::uint16_t port = 0;
  std::string interface;
  std::string why;  // "": joined
};

// Listens, for seconds, on as many ports as wanted, as a program without privileges can: binds
// them, joins groups on every interface. TCP: takes connections and reads. One thread; allocates.
class Probe {
 public:
  explicit Probe(std::vector<Interface> interfaces) : interfaces_(std::move(interfaces)) {}

  // Once per port.
  PortState Open(bool stream, std::uint16_t port, bool v6);
  // On every interface that is up, each by itself; those that a program joined already, too.
  std::vector<GroupState> Join(const std::string& group, std::uint16_t port);
  void Add(std::unique_ptr<Listener> listener) { listeners_.push_back(std::move(listener)); }

  void Run(double seconds);

  const Traffic& heard() const { return notes_->heard; }
  const Traffic& seen() const { return notes_->seen; }

 private:
  Result<Descriptor> Bind(bool stream, const std::string& host, std::uint16_t port, int* error);

  std::vector<Interface> interfaces_;
  std::vector<std::unique_ptr<Listener>> listeners_;
  std::unique_ptr<Notebook> notes_ = std::make_unique<Notebook>();
};

}  // namespace styled::doctor
