// Writes what a leader says, one message of each kind, as seeds of journal_fuzz.
#include <functional>
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
  pair.Turn(1000);  // no sender: a silence
  // What this pair has no cause to say, in the words of its last sign of life.
  const auto add = [&said](const std::function<void(Journal&)>& fill) {
    Journal entry;
    entry.ParseFromString(said[Journal::WHAT_NOT_SET]);
    fill(entry);
    said[entry.what_case() == Journal::WHAT_NOT_SET ? -1 : entry.what_case()] =
        entry.SerializeAsString();
  };
  add([](Journal& entry) {
    entry.mutable_style()->set_name("made");
    entry.mutable_style()->set_file("{\"format\": \"styled style 1\", \"name\": \"made\"}");
  });
  add([](Journal& entry) { entry.set_too_large("style \"made\": 20000000 bytes"); });
  add([](Journal& entry) {
    entry.set_daemon(3);
    entry.set_term(1000);
    entry.set_hears(77);
    auto& setting = *entry.mutable_setup()->add_settings();
    setting.set_name("model.feet");
    setting.set_value("false");
  });
  std::vector<std::vector<std::byte>> seeds;
  for (const auto& [kind, message] : said) {
    const auto bytes = std::as_bytes(std::span(message));
    // In front: whose header it gets, and who hears it (journal_fuzz.cpp).
    for (const std::byte first : {std::byte{0}, std::byte{1}, std::byte{2}, std::byte{3}}) {
      seeds.emplace_back(1, first).insert(seeds.back().end(), bytes.begin(), bytes.end());
    }
  }
  return styled::fuzz::WriteSeeds(argc, argv, seeds);
}
