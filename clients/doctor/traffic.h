#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "clients/doctor/address.h"
#include "clients/doctor/sniff.h"

// Received traffic, grouped by sender and destination. Pure; pinned by tests/unit/doctor.
namespace styled::doctor {

// Counts datagrams by their kind.
struct Tally {
  static constexpr std::size_t kMaxKinds = 12;  // further kinds are counted together as "others"
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
  // The most frequent format; kUnknown if the datagrams without a known format are the most.
  Format MainFormat() const;
  // "quaternions (02) 180, names (12) 3": the kinds of `format`, optionally with `verdict` only.
  std::string Kinds(Format format) const;
  std::string Kinds(Format format, Verdict verdict) const;
};

// The traffic from one machine to one address and port.
struct Flow {
  bool stream = false;    // TCP
  Endpoint to;            // destination as sent; may be a group or broadcast address
  Endpoint from;          // with the last source port seen
  std::string interface;  // by which it arrived; "" if unknown
  std::uint64_t datagrams = 0, bytes = 0;
  std::size_t smallest = 0, largest = 0;
  double first_s = 0, last_s = 0;  // since listening began
  Tally tally;

  double rate_hz() const;  // 0 if there are too few datagrams to tell
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
  static constexpr std::size_t kMaxFlows = 64;  // further flows are only counted, in left_out()

  void Add(const Arrival& arrival, const Sniffed& what);
  const std::vector<Flow>& flows() const { return flows_; }
  std::uint64_t left_out() const { return left_out_; }

 private:
  std::vector<Flow> flows_;
  std::uint64_t left_out_ = 0;
};

}  // namespace styled::doctor
