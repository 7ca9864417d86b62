#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "clients/doctor/interfaces.h"
#include "clients/doctor/listener.h"
#include "model/base/status.h"

namespace styled::doctor {

// Whether this program can listen on a port.
struct PortState {
  enum class Kind {
    kHeard,   // on every address
    kPartly,  // only on the addresses that no other program holds
    kInUse,   // on none: another program holds it on every address
    kRefused  // the system refuses; see `why`
  };
  bool stream = false;
  std::uint16_t port = 0;
  Kind kind = Kind::kHeard;
  std::vector<std::string> hosts;  // kPartly: addresses on which the probe listens
  std::string why;                 // kRefused
};

// A multicast group on one interface.
struct GroupState {
  std::string group;
  std::uint16_t port = 0;
  std::string interface;
  std::string why;  // "": joined; else the error
};

// Listens for some seconds on any number of ports, without privileges: binds the ports and joins
// groups on every interface. For TCP it accepts connections and reads from them. One thread;
// allocates.
class Probe {
 public:
  explicit Probe(std::vector<Interface> interfaces) : interfaces_(std::move(interfaces)) {}

  // Call once per port.
  PortState Open(bool stream, std::uint16_t port, bool v6);
  // Joins on every interface that is up, with one socket each, even if another program has already
  // joined.
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
