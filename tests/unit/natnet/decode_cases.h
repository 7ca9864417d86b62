#pragma once

#include <string>
#include <utility>
#include <vector>

#include "proto/rigs/natnet/frame.h"
#include "proto/rigs/natnet/packet.h"
#include "tests/unit/natnet/bytes.h"

// Frames and models, right ones of every bitstream and every way to get them wrong. Shared by the
// unit tests and, as seeds, by the fuzzer.
namespace styled::natnet::testing {

struct DecodeCase {
  std::string name;
  MessageId id;  // kFrameOfData or kModelDef
  Version version;
  Bytes payload;
  DecodeResult expected;
};

inline constexpr Version k27{2, 7}, k29{2, 9}, k30{3, 0}, k31{3, 1}, k40{4, 0}, k41{4, 1},
    k42{4, 2}, k50{5, 0};

inline std::string ToString(Version v) {
  return std::to_string(v.major) + "." + std::to_string(v.minor);
}

// The [size] that follows a section's count, or a data set's kind, from 4.1 on.
inline Part Sized(Version v, const Bytes& elements, std::int64_t error = 0) {
  if (v < k41) return {elements};
  return {Join(I32{static_cast<std::int64_t>(elements.size()) + error}, Part{elements})};
}

// A rigid body or bone of a frame; before 3.0 with two markers (positions, ids, sizes).
inline Part Body(Version v, std::int64_t id, float x, float qw, int params) {
  return {Join(I32{id}, F32{x}, F32{x + 1}, F32{x + 2}, F32{0.5F}, F32{-0.5F}, F32{0.25F}, F32{qw},
               Part{v < k30 ? Join(I32{2}, Any{2 * 12}, Any{2 * 4}, Any{2 * 4}) : Bytes{}},
               F32{0.001F}, I16{params})};
}

// Two skeletons, of two bones and of one.
inline Bytes Skeletons(Version v) {
  return Join(I32{7}, I32{2}, Body(v, (7 << 16) | 1, 10, 0.75F, 1),
              Body(v, (7 << 16) | 2, 20, 1, 0), I32{8}, I32{1}, Body(v, (8 << 16) | 1, 30, -1, 1));
}

// The sections before and behind the skeletons; `used`: with elements in every section, else with
// none.
inline Bytes Head(Version v, bool used) {
  if (!used) return Join(I32{-5}, I32{0}, Sized(v, {}), I32{0}, Sized(v, {}), I32{0}, Sized(v, {}));
  const Bytes sets = Join(Text{"all"}, I32{2}, Any{24}, Text{""}, I32{0});
  const Bytes bodies = Join(Body(v, 1, 1, 1, 1), Body(v, 2, 2, 1, 0), Body(v, 3, 3, 1, 1));
  return Join(I32{162734}, I32{2}, Sized(v, sets), I32{1}, Sized(v, Join(Any{12})), I32{3},
              Sized(v, bodies));
}
inline Bytes Analog() { return Join(I32{4}, I32{2}, I32{3}, Any{12}, I32{0}); }
inline Bytes Tail(Version v, bool used, int end_size = 4) {
  const auto section = [&](const Bytes& element) {
    return Part{used ? Join(I32{1}, Sized(v, element)) : Join(I32{0}, Sized(v, {}))};
  };
  const Part none{{}};
  return Join(v < k41 ? none : section(Join(I32{9}, I32{1}, Any{38}, I32{2}, Any{52})),  // asset
              section(Join(Any{v < k30 ? 22U : 26U})),  // labelled marker
              v < k29 ? none : section(Analog()),       // force plate
              v < k30 ? none : section(Analog()),       // device
              v < k30 ? Part{Join(F32{0.01F})} : none,  // latency
              I32{0x0A0B0C0D}, I32{2}, F64{1356.125},
              v < k30 ? none : Part{Join(U64{0x0123456789ABCDEFULL}, U64{2}, U64{3})},
              v < k41 ? none : Part{Join(Any{8})},  // PTP
              I16{kModelsChanged | kEditing}, Any{static_cast<std::size_t>(end_size)});
}

inline Bytes FullFrame(Version v) {
  return Join(Part{Head(v, true)}, I32{2}, Sized(v, Skeletons(v)), Part{Tail(v, true)});
}

// A rigid body or bone of a model.
inline Part Description(Version v, std::string_view name, int id, int parent, float y,
                        int markers = 0) {
  Bytes names;
  for (int m = 0; v >= k40 && m < markers; ++m) Text{"m"}.AppendTo(names);
  const auto count = static_cast<std::size_t>(markers);
  return {Join(Text{name}, I32{id}, I32{parent}, F32{0.5F}, F32{y}, F32{-0.5F},
               v < k42 ? Part{{}} : Part{Join(Any{16})},
               v < k30 ? Part{{}} : Part{Join(I32{markers}, Any{12 * count}, Any{4 * count})},
               Part{names})};
}
inline Bytes SkeletonSet(Version v, std::string_view name, int id) {
  return Join(Text{name}, I32{id}, I32{2}, Description(v, "Hip", 1, 0, 1),
              Description(v, "Ab", 2, 1, 0.125F));
}
// One data set of every kind that the version can tell apart.
inline Bytes FullModel(Version v) {
  const Bytes plate = Join(I32{1}, Text{"serial"}, Any{8 + 12 + 576 + 48 + 8}, I32{1}, Text{"Fx"});
  const Bytes device =
      Join(I32{1}, Text{"NI"}, Text{"serial"}, Any{8}, I32{2}, Text{"a"}, Text{""});
  return Join(I32{v < k30 ? 4 : 7}, I32{0},
              Sized(v, Join(Text{"all"}, I32{2}, Text{"m1"}, Text{"m2"})), I32{1},
              Sized(v, Description(v, "Prop", 1, -1, 0, 2).value), I32{2},
              Sized(v, SkeletonSet(v, "Anna", 7)),
              v < k30 ? Part{{}}
                      : Part{Join(I32{3}, Sized(v, plate), I32{4}, Sized(v, device), I32{5},
                                  Sized(v, Join(Text{"Prime 13"}, Any{28})))},
              I32{2}, Sized(v, SkeletonSet(v, "Bert", 8)));
}

inline std::vector<DecodeCase> RightCases() {
  std::vector<DecodeCase> cases;
  for (const Version v : {k27, k29, k30, k31, k40, k41, k42}) {
    const std::string suffix = " of " + ToString(v);
    cases.push_back(
        {"full frame" + suffix, MessageId::kFrameOfData, v, FullFrame(v), DecodeResult::kOk});
    const Bytes empty = Join(Part{Head(v, false)}, I32{0}, Sized(v, {}), Part{Tail(v, false)});
    cases.push_back({"empty frame" + suffix, MessageId::kFrameOfData, v, empty, DecodeResult::kOk});
    cases.push_back(
        {"full model" + suffix, MessageId::kModelDef, v, FullModel(v), DecodeResult::kOk});
    cases.push_back(
        {"empty model" + suffix, MessageId::kModelDef, v, Join(I32{0}), DecodeResult::kOk});
  }
  return cases;
}

inline std::vector<DecodeCase> WrongFrames() {
  using R = DecodeResult;
  std::vector<DecodeCase> cases;
  const auto add = [&](std::string name, Version v, Bytes payload, R expected) {
    cases.push_back({std::move(name), MessageId::kFrameOfData, v, std::move(payload), expected});
  };
  const auto with_skeletons = [](Version v, std::int64_t count, const Bytes& elements,
                                 std::int64_t size_error = 0) {
    return Join(Part{Head(v, false)}, I32{count}, Sized(v, elements, size_error),
                Part{Tail(v, false)});
  };
  add("no version", {}, FullFrame(k30), R::kOldVersion);
  add("2.6", {2, 6}, FullFrame(k27), R::kOldVersion);
  add("nothing", k30, {}, R::kTruncated);
  add("-1 marker sets", k30, Join(I32{1}, I32{-1}, Any{400}), R::kBadCount);
  add("2 billion marker sets", k30, Join(I32{1}, I32{0x7FFFFFFF}, Any{400}), R::kBadCount);
  add("a marker set whose name does not end", k30, Join(I32{1}, I32{1}, Any{40}), R::kTruncated);
  add("a marker set of -1 markers", k30, Join(I32{1}, I32{1}, Text{"all"}, I32{-1}, Any{40}),
      R::kBadCount);
  add("-1 unlabelled markers", k30, Join(I32{1}, I32{0}, I32{-1}, Any{40}), R::kBadCount);
  add("more unlabelled markers than bytes", k30, Join(I32{1}, I32{0}, I32{4}, Any{40}),
      R::kBadCount);
  add("more rigid bodies than bytes", k30, Join(I32{1}, I32{0}, I32{0}, I32{2}, Any{75}),
      R::kBadCount);
  add("a rigid body of -1 markers", k27,
      Join(I32{1}, I32{0}, I32{0}, I32{1}, Any{32}, I32{-1}, Any{40}), R::kBadCount);
  add("-1 skeletons", k30, with_skeletons(k30, -1, {}), R::kBadCount);
  add("a skeleton of -1 bones", k30, with_skeletons(k30, 1, Join(I32{7}, I32{-1})), R::kBadCount);
  add("more bones than bytes", k30, with_skeletons(k30, 1, Join(I32{7}, I32{9999})), R::kBadCount);
  add("3 skeletons where there are 2", k41, with_skeletons(k41, 3, Skeletons(k41)), R::kTruncated);
  add("1 skeleton where there are 2", k41, with_skeletons(k41, 1, Skeletons(k41)),
      R::kSizeMismatch);
  add("a section's size 1 too small", k41, with_skeletons(k41, 2, Skeletons(k41), -1),
      R::kBadCount);
  add("a section's size 1 too large", k42, with_skeletons(k42, 2, Skeletons(k42), 1),
      R::kSizeMismatch);
  add("a size of -1", k41, with_skeletons(k41, 0, {}, -1), R::kBadCount);
  add("a size beyond the end", k41, with_skeletons(k41, 0, {}, 1000), R::kBadCount);
  add("a size of 2 billion", k50, with_skeletons(k50, 0, {}, 0x7FFFFFFF), R::kBadCount);
  add("4.1 read as 4.0", k40, FullFrame(k41), R::kBadCount);
  add("4.0 read as 4.1", k41, FullFrame(k40), R::kBadCount);
  add("2.9 read as 3.0", k30, FullFrame(k29), R::kBadCount);
  for (const Version v : {k27, k29, k30, k31, k40}) {
    Bytes longer = FullFrame(v);
    longer.push_back({});
    add("a byte too many in " + ToString(v), v, longer, R::kTrailing);
  }
  for (const Version v : {k27, k29, k30, k31, k40, k41, k42}) {
    Bytes shorter = FullFrame(v);
    shorter.pop_back();
    add("a byte too few in " + ToString(v), v, shorter, R::kTruncated);
  }
  return cases;
}

inline std::vector<DecodeCase> WrongModels() {
  using R = DecodeResult;
  std::vector<DecodeCase> cases;
  const auto add = [&](std::string name, Version v, Bytes payload, R expected) {
    cases.push_back({std::move(name), MessageId::kModelDef, v, std::move(payload), expected});
  };
  add("no version, model", {}, FullModel(k30), R::kOldVersion);
  add("no data sets, not even their number", k30, {}, R::kTruncated);
  add("-1 data sets", k30, Join(I32{-1}, Any{40}), R::kBadCount);
  add("more data sets than bytes", k30, Join(I32{9}, Any{40}), R::kBadCount);
  add("a name that does not end", k30, Join(I32{1}, I32{2}, Any{40}), R::kTruncated);
  add("-1 marker names", k30, Join(I32{1}, I32{0}, Text{"all"}, I32{-1}), R::kBadCount);
  add("-1 bones", k30, Join(I32{1}, I32{2}, Text{"Anna"}, I32{7}, I32{-1}), R::kBadCount);
  add("more bones than bytes, model", k30, Join(I32{1}, I32{2}, Text{"A"}, I32{7}, I32{3}, Any{60}),
      R::kBadCount);
  add("a bone of 1000 markers", k30,
      Join(I32{1}, I32{2}, Text{"A"}, I32{7}, I32{1}, Text{"Hip"}, I32{1}, I32{0}, Any{12},
           I32{1000}, Any{40}),
      R::kBadCount);
  add("a marker without a name", k40,
      Join(I32{1}, I32{1}, Text{"P"}, I32{1}, I32{-1}, Any{12}, I32{1}, Any{16}), R::kTruncated);
  add("a data set's size beyond the end", k41,
      Join(I32{1}, I32{2}, Sized(k41, SkeletonSet(k41, "Anna", 7), 1)), R::kBadCount);
  add("a data set's size of -1", k41, Join(I32{1}, I32{0}, I32{-1}, Any{9}), R::kBadCount);
  add("a skeleton shorter than its size", k41,
      Join(I32{1}, I32{2}, Sized(k41, SkeletonSet(k41, "Anna", 7), 1), Any{1}), R::kSizeMismatch);
  add("a skeleton longer than its size", k41,
      Join(I32{1}, I32{2}, Sized(k41, SkeletonSet(k41, "Anna", 7), -1)), R::kTruncated);
  for (const Version v : {k27, k30, k40, k41, k42}) {
    Bytes shorter = FullModel(v);
    shorter.pop_back();
    add("a model a byte too short of " + ToString(v), v, shorter,
        v < k41 ? R::kTruncated : R::kBadCount);
  }
  return cases;
}

inline std::vector<DecodeCase> DecodeCases() {
  auto cases = RightCases();
  for (auto& wrong : {WrongFrames(), WrongModels()}) {
    cases.insert(cases.end(), wrong.begin(), wrong.end());
  }
  return cases;
}

}  // namespace styled::natnet::testing
