#include "tests/golden/golden.h"

#include <filesystem>
#include <fstream>
#include <limits>
#include <sstream>

#include "proto/recording/writer.h"

namespace styled::golden {
namespace {

constexpr std::size_t kEvery = 10;

}  // namespace

std::vector<Entry> ReadList(const std::string& file) {
  std::vector<Entry> entries;
  std::ifstream in(file);
  for (std::string line; std::getline(in, line);) {
    if (line.empty() || line.front() == '#') continue;
    std::istringstream words(line);
    Entry entry;
    words >> entry.name >> entry.type >> entry.as >> entry.rate_hz >> entry.seconds >>
        entry.performers >> entry.quirks >> entry.faults;
    for (std::string* const word : {&entry.quirks, &entry.faults}) {
      if (*word == "-") word->clear();
    }
    entries.push_back(std::move(entry));
  }
  return entries;
}

Status WriteExpected(const Played& played, const std::string& file) {
  std::filesystem::remove(file);
  auto writer = recording::FileWriter::Create(
      file, {},
      {.block_size = 1U << 20U, .block_age_ns = std::numeric_limits<std::int64_t>::max()});
  if (!writer.ok()) return writer.status();
  Status status = Status::Ok();
  const auto add = [&](const recording::Record& record) {
    if (status.ok()) status = writer.value()->Add(record, 0);
  };
  recording::Record record;
  for (const auto& body : played.bodies) {
    record.mutable_published()->set_topic("body/" + body.performer() + "/");
    body.SerializeToString(record.mutable_published()->mutable_payload());
    add(record);
  }
  for (const auto& [topic, frames] : played.frames) {
    record.mutable_published()->set_topic(topic);
    for (std::size_t i = 0; i < frames.size(); ++i) {
      if (i % kEvery != 0 && i + 1 != frames.size()) continue;
      frames[i].SerializeToString(record.mutable_published()->mutable_payload());
      add(record);
    }
  }
  for (const auto& [name, value] : played.counters) {
    record.mutable_note()->set_text(name + " " + std::to_string(value));
    if (value != 0) add(record);
  }
  return status.ok() ? writer.value()->Flush() : status;
}

Result<Played> ReadExpected(const std::string& file) {
  auto reader = recording::Reader::Open(file);
  if (!reader.ok()) return reader.status();
  Played played;
  recording::Record record;
  while (reader.value()->Next(record)) {
    const auto& published = record.published();
    if (published.topic().starts_with("body/")) {
      played.bodies.emplace_back().ParseFromString(published.payload());
    } else if (record.has_published()) {
      played.frames[published.topic()].emplace_back().ParseFromString(published.payload());
    } else {
      std::istringstream words(record.note().text());
      std::string name;
      words >> name >> played.counters[name];
    }
  }
  return played;
}

}  // namespace styled::golden
