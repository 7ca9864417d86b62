#include "proto/rigs/vmc/assembler.h"

#include <algorithm>
#include <bit>
#include <cmath>

#include "model/base/hash.h"

namespace styled::vmc {
namespace {

constexpr std::int64_t kStale_ns = 500'000'000;
// No datagram arrives later than this. A clock that shows the same value for longer stands still,
// and one that is back by then was restarted.
constexpr std::int64_t kLatest_ns = 250'000'000;
constexpr float kRestart_s = 1.0F;
// 36 hours: from here on a float's steps are 1/64 s, a frame's length.
constexpr float kCoarse_s = 131072.0F;
constexpr std::int64_t kMinPeriod_ns = 1'000'000, kMaxPeriod_ns = 250'000'000;
constexpr std::int64_t kMinSilence_ns = 4'000'000, kMaxSilence_ns = 50'000'000;

// The subject of a message. Bones are 1 .. 55; expressions have a hash with bit 6 set.
constexpr std::uint64_t kTimeKey = 60, kRootKey = 61, kAvailableKey = 62, kApplyKey = 63;

bool IsClock(float time_s) noexcept { return time_s >= 0 && time_s < kCoarse_s; }

std::uint64_t BlendKey(std::string_view name) noexcept { return HashOf(name) | 64U; }

// Finds the first T of a datagram, and checks that all of it is OSC.
osc::Result ScanTime(std::span<const std::byte> datagram, bool& has_time, float& time_s) noexcept {
  osc::Reader reader(datagram);
  osc::Message bytes;
  Message message;
  has_time = false;
  while (reader.Next(bytes) == osc::Reader::Step::kMessage) {
    if (has_time || bytes.address != kTimeAddress) continue;
    if (Decode(bytes, message) != DecodeResult::kOk) continue;
    time_s = std::get_if<Time>(&message)->seconds;
    has_time = std::isfinite(time_s);
  }
  return reader.result();
}

}  // namespace

osc::Result Assembler::Begin(std::span<const std::byte> datagram, std::int64_t now_ns) noexcept {
  bool has_time = false;
  float time_s = 0;
  const osc::Result result = ScanTime(datagram, has_time, time_s);
  if (result != osc::Result::kOk) return result;
  const bool silence = now_ns - now_ns_ > Silence_ns();
  flush_first_ = !empty_ && silence;
  of_open_frame_ = has_time && has_mark_ && !flush_first_ && !clock_stands_ && time_s == mark_s_;
  waiting_ = false;
  at_end_ = false;
  now_ns_ = now_ns;
  ++datagram_;
  reader_ = osc::Reader(datagram);
  // Datagrams without a T continue to belong to the skipped frame, until a T or a silence ends it.
  passing_over_ = passing_over_ && !has_time && !silence;
  if (has_time && !of_open_frame_ && IsOld(time_s)) {
    ++(time_s == last_time_s_ ? counts_.duplicate : counts_.late);
    PassOver();
  } else if (passing_over_) {
    ++counts_.late;
    PassOver();
  }
  return result;
}

// Whether a datagram with this T is a copy or a late one.
bool Assembler::IsOld(float time_s) noexcept {
  if (time_s != last_time_s_) clock_stands_ = false;
  if (!any_time_ || !IsClock(time_s) || time_s > last_time_s_ || clock_stands_) return false;
  const bool recent = now_ns_ - last_timed_ns_ <= kLatest_ns;
  if (time_s == last_time_s_) clock_stands_ = !recent;
  return recent && last_time_s_ - time_s <= kRestart_s;
}

// Skips all of an old datagram, so that its bones do not enter the open frame. If T comes last, the
// messages before it are dropped, too; otherwise those that follow it are.
void Assembler::PassOver() noexcept {
  reader_ = osc::Reader();
  at_end_ = true;
  passing_over_ = end_key_ != kTimeKey;
  if (!passing_over_ && !flush_first_ && !has_mark_) Clear();
}

bool Assembler::Next() noexcept {
  if (flush_first_) {
    flush_first_ = false;
    if (Close(true)) return true;
  }
  while (!at_end_) {
    if (waiting_) {
      waiting_ = false;
      Add();
    }
    osc::Message bytes;
    if (reader_.Next(bytes) != osc::Reader::Step::kMessage) {
      at_end_ = true;
      return IsComplete() && Close(false);
    }
    if (!Decode(bytes)) continue;
    if (IsLateEnd()) {
      ++counts_.duplicate;
      continue;
    }
    waiting_ = true;
    if (BeginsNext() && Close(true)) return true;
  }
  return false;
}

bool Assembler::Flush(std::int64_t now_ns) noexcept {
  return now_ns >= deadline_ns() && Close(true);
}

std::int64_t Assembler::deadline_ns() const noexcept {
  return empty_ ? kNever : now_ns_ + Silence_ns();
}

std::int64_t Assembler::Silence_ns() const noexcept {
  return std::clamp(period_ns_ / 2, kMinSilence_ns, kMaxSilence_ns);
}

// Decodes message_ and bone_; returns false for messages that are not used.
bool Assembler::Decode(const osc::Message& bytes) noexcept {
  const DecodeResult result = vmc::Decode(bytes, message_);
  if (result != DecodeResult::kOk) {
    ++(result == DecodeResult::kUnknownAddress ? counts_.ignored : counts_.refused);
    return false;
  }
  if (const auto* bone = std::get_if<Bone>(&message_)) {
    vrm1_ = vrm1_ || IsVrm1Name(bone->name);
    bone_ = FindBone(bone->name, vrm1_);
    if (bone_ < 0) ++counts_.refused;
    return bone_ >= 0;
  }
  if (const auto* time = std::get_if<Time>(&message_)) {
    if (!std::isfinite(time->seconds)) ++counts_.refused;
    return std::isfinite(time->seconds);
  }
  return true;
}

// Once the sender's last message is known, a frame ends with it. A repeated value that is unchanged
// is then a copy and begins no frame.
bool Assembler::BeginsNext() const noexcept {
  const Frame& frame = open();
  const bool no_copies = end_key_ == 0;
  if (const auto* time = std::get_if<Time>(&message_)) {
    return has_mark_ && time->seconds != mark_s_;
  }
  if (of_open_frame_) return false;
  if (const auto* bone = std::get_if<Bone>(&message_)) {
    const auto at = static_cast<std::size_t>(bone_);
    return Has(frame.bones, bone_) && bone_datagram_[at] != datagram_ &&
           (no_copies || frame.transforms[at] != bone->transform);
  }
  if (const auto* root = std::get_if<Root>(&message_)) {
    return frame.has_root && root_datagram_ != datagram_ &&
           (no_copies || frame.root != root->transform);
  }
  if (const auto* blend = std::get_if<Blend>(&message_)) {
    const std::size_t at = Find(*blend);
    return at < frame.blend_count && frame.blends[at].datagram != datagram_ &&
           (no_copies || frame.blends[at].value != blend->value);
  }
  return false;
}

// Index of the expression in the frame; blend_count if it is absent.
std::size_t Assembler::Find(const Blend& blend) const noexcept {
  const Frame& frame = open();
  std::size_t at = 0;
  while (at < frame.blend_count && frame.blends[at].name() != blend.name) ++at;
  return at;
}

Assembler::Key Assembler::MessageKey() const noexcept {
  if (std::holds_alternative<Bone>(message_)) return 1 + static_cast<Key>(bone_);
  if (const auto* blend = std::get_if<Blend>(&message_)) return BlendKey(blend->name);
  if (std::holds_alternative<Time>(message_)) return kTimeKey;
  if (std::holds_alternative<Root>(message_)) return kRootKey;
  if (std::holds_alternative<Available>(message_)) return kAvailableKey;
  return std::holds_alternative<BlendApply>(message_) ? kApplyKey : 0;
}

void Assembler::Add() noexcept {
  Frame& frame = open();
  if (empty_) frame.received_ns = now_ns_;
  empty_ = false;
  if (const auto* bone = std::get_if<Bone>(&message_)) {
    const auto at = static_cast<std::size_t>(bone_);
    frame.bones |= Bit(bone_);
    frame.transforms[at] = bone->transform;
    bone_datagram_[at] = datagram_;
  } else if (const auto* root = std::get_if<Root>(&message_)) {
    frame.has_root = true;
    frame.root = root->transform;
    root_datagram_ = datagram_;
  } else if (const auto* time = std::get_if<Time>(&message_)) {
    if (!has_mark_) mark_s_ = time->seconds;
    has_mark_ = true;
  } else if (const auto* available = std::get_if<Available>(&message_)) {
    frame.has_available = true;
    frame.available = *available;
  } else if (const auto* blend = std::get_if<Blend>(&message_)) {
    AddBlend(*blend);
  } else if (const auto* thru = std::get_if<Thru>(&message_)) {
    AddThru(*thru);
  } else {
    frame.blends_applied = true;
  }
  const Key key = MessageKey();
  if (key == 0) return;
  last_key_ = key;
  end_seen_ = end_seen_ || key == end_key_;
}

void Assembler::AddBlend(const Blend& blend) noexcept {
  Frame& frame = open();
  const std::size_t at = Find(blend);
  if (at == Frame::kMaxBlends || blend.name.size() > Frame::Expression::kMaxName) {
    ++counts_.left_out;
    return;
  }
  auto& expression = frame.blends[at];
  frame.blend_count = std::max(frame.blend_count, at + 1);
  std::copy(blend.name.begin(), blend.name.end(), expression.text.begin());
  expression.size = blend.name.size();
  expression.value = blend.value;
  expression.datagram = datagram_;
}

void Assembler::AddThru(const Thru& thru) noexcept {
  Frame& frame = open();
  if (frame.thru_count == Frame::kMaxThrus || thru.bytes.size() > Frame::Passed::kMaxSize) {
    ++counts_.left_out;
    return;
  }
  auto& passed = frame.thrus[frame.thru_count++];
  std::copy(thru.bytes.begin(), thru.bytes.end(), passed.text.begin());
  passed.size = thru.bytes.size();
}

bool Assembler::IsComplete() const noexcept {
  return open().bones != 0 && end_seen_ && (expected_ & ~open().bones) == 0;
}

// A frame of several messages never begins with the message that ends it: that is a copy, or the
// messages before it were lost.
bool Assembler::IsLateEnd() const noexcept {
  return empty_ && std::popcount(expected_) > 1 && MessageKey() != 0 && MessageKey() == end_key_;
}

// Ends the open frame. `learn`: the end was found by a rule that sees the sender's own end of the
// frame, so its last message is learned. Returns true if there is a new frame().
bool Assembler::Close(bool learn) noexcept {
  const Frame& frame = open();
  const bool pose = frame.bones != 0 || frame.has_root;
  const bool content = pose || frame.blend_count > 0 || frame.thru_count > 0;
  // Learn only from poses, since expressions may come separately and at their own rate; and from a
  // T alone, which ends a frame that was taken for finished before.
  if (learn && (pose || !content) && last_key_ != 0) LearnEnd();
  const bool good = content && AcceptTime();
  if (good) {
    AcceptBones();
    LearnPeriod();
    open_index_ = 1 - open_index_;
  }
  Clear();
  return good;
}

// Another last message is accepted when it came twice in a row, because the end itself may be lost.
void Assembler::LearnEnd() noexcept {
  if (end_key_ == 0 || last_key_ == candidate_key_) end_key_ = last_key_;
  candidate_key_ = last_key_;
}

// Sets the frame's time. Returns false if it is not later than the last one.
bool Assembler::AcceptTime() noexcept {
  Frame& frame = open();
  if (!has_mark_ || clock_stands_ || !IsClock(mark_s_)) return true;
  if (any_time_ && mark_s_ <= last_time_s_) {
    const bool recent = frame.received_ns - last_timed_ns_ <= kLatest_ns;
    if (recent && last_time_s_ - mark_s_ <= kRestart_s) {
      ++(mark_s_ == last_time_s_ ? counts_.duplicate : counts_.late);
      return false;
    }
    frame.restarted = true;
    seen_ = 0;
  }
  frame.has_time = true;
  frame.time_s = mark_s_;
  return true;
}

void Assembler::AcceptBones() noexcept {
  Frame& frame = open();
  if (frame.bones == 0) return;
  if ((expected_ & ~frame.bones) != 0) ++counts_.incomplete;
  expected_ = frame.bones;
  frame.missing = seen_ & ~frame.bones;
  seen_ |= frame.bones;
  for (int bone = 0; bone < kBoneCount; ++bone) {
    auto& seen_ns = seen_ns_[static_cast<std::size_t>(bone)];
    if (Has(frame.bones, bone)) seen_ns = frame.received_ns;
    if (Has(frame.missing, bone) && frame.received_ns - seen_ns > kStale_ns) {
      frame.stale |= Bit(bone);
    }
  }
}

void Assembler::LearnPeriod() noexcept {
  const Frame& frame = open();
  std::int64_t period_ns = frame.received_ns - last_frame_ns_;
  // Prefer the sender's clock: arrivals jitter.
  if (frame.has_time && last_had_time_) {
    period_ns = static_cast<std::int64_t>((frame.time_s - last_time_s_) * 1e9F);
  }
  if (period_ns > kMinPeriod_ns && period_ns < kMaxPeriod_ns) {
    period_ns_ += (period_ns - period_ns_) / 8;
  }
  last_frame_ns_ = frame.received_ns;
  last_had_time_ = frame.has_time;
  if (!frame.has_time) return;
  any_time_ = true;
  last_time_s_ = frame.time_s;
  last_timed_ns_ = frame.received_ns;
}

void Assembler::Clear() noexcept {
  Frame& frame = open();
  frame.bones = frame.missing = frame.stale = 0;
  frame.has_root = frame.has_time = frame.restarted = frame.has_available = false;
  frame.blends_applied = false;
  frame.blend_count = frame.thru_count = 0;
  empty_ = true;
  has_mark_ = end_seen_ = false;
  last_key_ = 0;
}

}  // namespace styled::vmc
