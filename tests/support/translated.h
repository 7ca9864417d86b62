#pragma once

#include <vector>

#include "daemon/source/source_frame.h"
#include "daemon/source/translator.h"
#include "proto/styled/v1/body.pb.h"
#include "proto/styled/v1/frame.pb.h"
#include "tests/support/native_frames.h"

namespace styled::support {

// Collects a translator's output for a rig's datagrams, without socket or pipeline.
class Translated : public source::Receiver {
 public:
  explicit Translated(std::unique_ptr<source::Translator> translator)
      : translator_(std::move(translator)) {}

  struct Item {
    std::uint64_t session = 0, sequence = 0;
    bool is_frame = false;
    v1::Body body;
    v1::SourceFrame frame;
    std::string refusal;  // of a body; "": none
  };

  void Handle(std::span<const std::byte> datagram, std::uint64_t peer = 1) {
    outbox_.Open(*this, -1);
    source::Peer from;
    from.id = peer;
    translator_->Handle(datagram, from, now_ns, outbox_);
    translator_->Tick(now_ns, outbox_);
    outbox_.Close();
  }
  void Tick() {
    outbox_.Open(*this, -1);
    translator_->Tick(now_ns, outbox_);
    outbox_.Close();
  }

  std::vector<v1::SourceFrame> Frames() const {
    std::vector<v1::SourceFrame> frames;
    for (const Item& item : items) {
      if (item.is_frame) frames.push_back(item.frame);
    }
    return frames;
  }
  std::vector<v1::Body> Bodies() const {
    std::vector<v1::Body> bodies;
    for (const Item& item : items) {
      if (!item.is_frame) bodies.push_back(item.body);
    }
    return bodies;
  }
  std::uint64_t Count(runtime::Counter counter) const { return counters_.Get(counter); }
  source::Translator& translator() { return *translator_; }

  void OnFrames(int, std::span<const source::SourceFrame> frames, bool) override {
    for (const source::SourceFrame& frame : frames) {
      Item& item = items.emplace_back();
      item.session = frame.session;
      item.sequence = frame.sequence;
      item.is_frame = !frame.is_body;
      if (frame.refusal != nullptr) item.refusal = *frame.refusal;
      if (item.is_frame) {
        item.frame = AsMessage(frame);
      } else if (!source::ReadBody(frame, item.body)) {
        ++undecodable;
      }
    }
  }
  void OnNote(int, const std::string& text) override { notes.push_back(text); }

  std::int64_t now_ns = 1'000'000'000;
  std::vector<Item> items;
  std::vector<std::string> notes;
  int undecodable = 0;

 private:
  runtime::Counters counters_;
  source::Outbox outbox_{0, counters_};
  std::unique_ptr<source::Translator> translator_;
};

}  // namespace styled::support
