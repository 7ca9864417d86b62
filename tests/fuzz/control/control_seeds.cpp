// Writes one request of each kind as seeds of control_fuzz.
#include <span>
#include <string>

#include "proto/styled/v1/control.pb.h"
#include "tests/fuzz/write_seeds.h"

int main(int argc, char** argv) {
  using styled::v1::Request;
  std::vector<std::vector<std::byte>> seeds;
  const auto add = [&](const std::string& performer, const auto& fill) {
    Request request;
    request.set_id(seeds.size() + 1);
    request.set_performer(performer);
    fill(request);
    const std::string text = request.SerializeAsString();
    const auto bytes = std::as_bytes(std::span(text));
    seeds.emplace_back(bytes.begin(), bytes.end());
  };
  add("", [](Request& r) { r.mutable_list(); });
  add("", [](Request& r) { r.mutable_status(); });
  for (const std::string performer : {"rig.a", "rig.b", "*"}) {
    add(performer, [](Request& r) {
      for (const char* const style : {"style1", "s2"}) {
        auto& entry = *r.mutable_set()->add_mix();
        entry.set_style(style);
        entry.set_weight(0.5F);
      }
      r.mutable_set()->set_strength(0.8F);
      r.mutable_set()->set_transition_ms(200);
      r.mutable_set()->set_absolute(true);
      r.mutable_set()->add_parts(styled::v1::BODY_PART_ALL);
      r.mutable_set()->set_input_style("style3");
    });
    add(performer, [](Request& r) {
      r.mutable_set()->set_vary(7);
      r.mutable_set()->set_vary_each(true);
      r.mutable_set()->set_vary_amount(0.5F);
      r.mutable_set()->set_drift_s(5);
      r.mutable_set()->set_mirror(true);
    });
    add(performer, [](Request& r) { r.mutable_set()->set_clear(true); });
    add(performer, [](Request& r) { r.mutable_preset()->set_name("both"); });
    add(performer, [](Request& r) { r.mutable_pin()->set_pinned(true); });
    add(performer, [](Request& r) { r.mutable_reset(); });
    add(performer, [](Request& r) { r.mutable_calibrate(); });
  }
  add("", [](Request& r) { r.mutable_panic(); });
  return styled::fuzz::WriteSeeds(argc, argv, seeds);
}
