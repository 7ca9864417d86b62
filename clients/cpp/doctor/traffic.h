#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "clients/cpp/doctor/address.h"
#include "clients/cpp/doctor/sniff.h"

// What was heard, put together by where it came from and where it went. Pure; tests/unit/doctor.
namespace styled::doctor {

// Datagrams by what they were.
struct Tally {
  static constexpr std::size_t kMaxKinds = 12;  // further ones are put together as "others"
  struct Kind {
    Sniffed what;
    std::uint64_t count = 0;
  };
  std::vector<Kind> kinds;

  void Add(const Sniffed& what, std::uint64_t count = 1);
  void Add(const Tally& other);
  std::uint64_t Count() const;
  std::uint64_t Count(Format format) const;
  std::uint64_t Count(Format format, Verdict verdict) const;
  // The format most of them have; kUnknown where that is none of ours.
  Format MainFormat() const;
  // "quaternions (02) 180, names (12) 3": of the format, with this verdict where one is given.
  std::string Kinds(Format format) const;
  std::string Kinds(Format format, Verdict verdict) const;
};

// From one machine to one address and port.
struct Flow {
  bool stream = false;    // TCP
  Endpoint to;            // as sent: may be a group or broadcast
  Endpoint from;          // the last port it came from
  std::string interface;  // that it came in by; "" where that is not known
  std::uint64_t datagrams = 0, bytes = 0;
  std::size_t smallest = 0, largest = 0;
  double first_s = 0, last_s = 0;  // since listening began
  Tally tally;

  double rate_hz() const;  // 0 where there is too little to tell
};

struct Arrival {
  bool stream = false;
  Endpoint to, from;
  std::string interface;
  double time_s = 0;
  std::size_t size = 0;
};

class Traffic {
 public:
  static constexpr std::size_t kMaxFlows = 64;  // further ones are counted only

  void Add(const Arrival& arrival, const Sniffed& what);
  const std::vector<Flow>& flows() const { return flows_; }
  std::uint64_t left_out() const { return left_out_; }

 private:
  std::vector<Flow> flows_;
  std::uint64_t left_out_ = 0;
};

}  // namespace styled::doctor
