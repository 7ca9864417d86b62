// Writes what a leader says, one message of each kind, as seeds of journal_fuzz.
#include <map>
#include <span>

#include "proto/styled/v1/journal.pb.h"
#include "tests/fuzz/journal/pair.h"
#include "tests/fuzz/write_seeds.h"

int main(int argc, char** argv) {
  using styled::v1::Journal;
  std::map<int, std::string> said;  // the last of each kind
  styled::fuzz::Pair pair([&](const std::string& message) {
    Journal entry;
    if (entry.ParseFromString(message)) said[entry.what_case()] = message;
  });
  styled::v1::Request request;
  request.set_performer("rig.a");
  auto& mix = *request.mutable_set()->add_mix();
  mix.set_style("style2");
  mix.set_weight(1);
  (void)pair.leader().Ask(request);
  pair.Frames(5);
  pair.Turn(1000);  // nobody sends: a silence
  std::vector<std::vector<std::byte>> seeds;
  for (const auto& [kind, message] : said) {
    const auto bytes = std::as_bytes(std::span(message));
    // In front: whether the header is made the leader's own (journal_fuzz.cpp).
    for (const std::byte first : {std::byte{0}, std::byte{1}}) {
      seeds.emplace_back(1, first).insert(seeds.back().end(), bytes.begin(), bytes.end());
    }
  }
  return styled::fuzz::WriteSeeds(argc, argv, seeds);
}
