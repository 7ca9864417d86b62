#pragma once

#include <bit>
#include <cstring>
#include <initializer_list>
#include <limits>
#include <string>
#include <string_view>
#include <vector>

#include "proto/rigs/mocopi/mocopi.h"

// Every way to get a datagram wrong, one by one, and some right ones, put together by hand from the
// grammar and not by the encoder under test. Shared by the unit test and, as seeds, by the fuzzer.
namespace styled::mocopi::testing {

using Bytes = std::vector<std::byte>;

struct DecodeCase {
  std::string name;
  Bytes bytes;
  DecodeResult expected;
};

inline Bytes Join(std::initializer_list<Bytes> parts) {
  Bytes all;
  for (const Bytes& part : parts) all.insert(all.end(), part.begin(), part.end());
  return all;
}
inline Bytes Text(std::string_view text) {
  Bytes bytes;
  for (const char c : text) bytes.push_back(static_cast<std::byte>(c));
  return bytes;
}
inline Bytes Little(std::uint64_t value, int size) {
  Bytes bytes;
  for (int i = 0; i < size; ++i) bytes.push_back(static_cast<std::byte>(value >> (8 * i)));
  return bytes;
}
inline Bytes Float(float value) { return Little(std::bit_cast<std::uint32_t>(value), 4); }
inline Bytes Double(double value) { return Little(std::bit_cast<std::uint64_t>(value), 8); }
inline Bytes Chunk(std::string_view tag, const Bytes& payload) {
  return Join({Little(payload.size(), 4), Text(tag), payload});
}
inline Bytes Floats(std::initializer_list<float> values) {
  Bytes bytes;
  for (const float value : values) bytes = Join({bytes, Float(value)});
  return bytes;
}

inline Bytes Head() {
  return Chunk("head",
               Join({Chunk("ftyp", Text("sony motion format")), Chunk("vrsn", Little(1, 1))}));
}
inline Bytes Sndf() {
  return Chunk("sndf", Join({Chunk("ipad", Text("12345678")), Chunk("rcvp", Little(12351, 2))}));
}
// Bone `id` is at (id, 1, 2) and turned to (-0, 0, -0, -1): identity, as the real ones say it.
inline Bytes Tran(int id) {
  return Chunk("tran", Floats({-0.0F, 0.0F, -0.0F, -1.0F, static_cast<float>(id), 1.0F, 2.0F}));
}
inline Bytes Bnid(int id) { return Chunk("bnid", Little(static_cast<std::uint64_t>(id), 2)); }
inline Bytes Btdt(int id) { return Chunk("btdt", Join({Bnid(id), Tran(id)})); }
inline Bytes Bndt(int id, int parent) {
  return Chunk("bndt", Join({Bnid(id), Chunk("pbid", Little(static_cast<std::uint64_t>(parent), 2)),
                             Tran(id)}));
}
// The published order of parents.
inline constexpr int kParents[kBones] = {-1, 0, 1,  2,  3,  4, 5,  6,  7,  8, 9,  7,  11, 12,
                                         13, 7, 15, 16, 17, 0, 19, 20, 21, 0, 23, 24, 25};
inline Bytes Bones() {
  Bytes all;
  for (int id = 0; id < kBones; ++id) all = Join({all, Btdt(id)});
  return all;
}
inline Bytes Definitions() {
  Bytes all;
  for (int id = 0; id < kBones; ++id) all = Join({all, Bndt(id, kParents[id])});
  return all;
}

inline Bytes Fnum() { return Chunk("fnum", Little(7, 4)); }
inline Bytes Time(float time_s = 0.25F) { return Chunk("time", Float(time_s)); }
inline Bytes Uttm() { return Chunk("uttm", Double(1703810998.5)); }
inline Bytes Tmcd() { return Chunk("tmcd", Text("abcdef")); }
inline Bytes FrameOf(const Bytes& fields) { return Join({Head(), Sndf(), Chunk("fram", fields)}); }
inline Bytes SkeletonOf(const Bytes& bones) {
  return Join({Head(), Sndf(), Chunk("skdf", Chunk("bons", bones))});
}
inline Bytes GoodFrame() { return FrameOf(Join({Fnum(), Time(), Uttm(), Chunk("btrs", Bones())})); }
inline Bytes GoodSkeleton() { return SkeletonOf(Definitions()); }

// A frame with these bones.
inline Bytes WithBones(const Bytes& bones) {
  return FrameOf(Join({Fnum(), Time(), Uttm(), Chunk("btrs", bones)}));
}

inline void AddGood(std::vector<DecodeCase>& cases) {
  const auto add = [&](std::string name, Bytes bytes) {
    cases.push_back({std::move(name), std::move(bytes), DecodeResult::kOk});
  };
  const Bytes btrs = Chunk("btrs", Bones());
  const Bytes odd = Chunk("odd!", Text("what a later app may say"));
  add("frame", GoodFrame());
  add("skeleton", GoodSkeleton());
  add("frame with tmcd", FrameOf(Join({Fnum(), Time(), Uttm(), Tmcd(), btrs})));
  add("frame of an early app", FrameOf(Join({Fnum(), Time(), btrs})));
  add("fields in another order", FrameOf(Join({btrs, Uttm(), Time(), Fnum()})));
  add("no sndf", Join({Head(), Chunk("fram", Join({Fnum(), Time(), btrs}))}));
  add("sndf behind the frame", Join({Head(), Chunk("fram", Join({Fnum(), Time(), btrs})), Sndf()}));
  add("unknown chunks at every level",
      Join({Chunk("head", Join({odd, Chunk("ftyp", Text("sony motion format")), odd,
                                Chunk("vrsn", Little(1, 1)), Chunk("none", {})})),
            odd,
            Chunk("sndf",
                  Join({Chunk("ipad", Text("12345678")), odd, Chunk("rcvp", Little(12351, 2))})),
            Chunk("fram", Join({odd, Fnum(), Time(), Chunk("btrs", Join({odd, Bones(), odd}))})),
            Chunk("none", {})}));
  Bytes deep = odd;
  for (int depth = 0; depth < 1000; ++depth) deep = Chunk("btrs", deep);
  add("an unknown chunk a thousand deep",
      FrameOf(Join({Fnum(), Time(), Chunk("deep", deep), btrs})));
  Bytes reversed;
  for (int id = kBones - 1; id >= 0; --id) reversed = Join({reversed, Btdt(id)});
  add("bones in another order", WithBones(reversed));
  Bytes not_a_number = Bones();
  const Bytes nan = Float(std::numeric_limits<float>::quiet_NaN());
  std::copy(nan.begin(), nan.end(), not_a_number.begin() + 26);
  add("a rotation that is no number", WithBones(not_a_number));
}

inline void AddBadHeads(std::vector<DecodeCase>& cases) {
  using R = DecodeResult;
  const auto add = [&](std::string name, R expected, Bytes bytes) {
    cases.push_back({std::move(name), std::move(bytes), expected});
  };
  const Bytes frame = Chunk("fram", Join({Fnum(), Time(), Chunk("btrs", Bones())}));
  const Bytes ftyp = Chunk("ftyp", Text("sony motion format"));
  const Bytes vrsn = Chunk("vrsn", Little(1, 1));
  add("nothing", R::kNotMocopi, {});
  add("less than a chunk", R::kNotMocopi, Text("\x23"));
  add("one of ours", R::kNotMocopi, Text("STYD and what follows"));
  add("head not first", R::kNotMocopi, Join({Sndf(), Head(), frame}));
  add("head longer than the datagram", R::kNotMocopi, Join({Little(35, 4), Text("head")}));
  add("no ftyp", R::kNotMocopi, Join({Chunk("head", vrsn), frame}));
  add("another ftyp", R::kNotMocopi,
      Join({Chunk("head", Join({Chunk("ftyp", Text("sony motion formaT")), vrsn})), frame}));
  add("a longer ftyp", R::kNotMocopi,
      Join({Chunk("head", Join({Chunk("ftyp", Text("sony motion format2")), vrsn})), frame}));
  add("no vrsn", R::kMissing, Join({Chunk("head", ftyp), frame}));
  add("vrsn of two bytes", R::kBadSize,
      Join({Chunk("head", Join({ftyp, Chunk("vrsn", Little(1, 2))})), frame}));
  add("vrsn 0", R::kBadVersion,
      Join({Chunk("head", Join({ftyp, Chunk("vrsn", Little(0, 1))})), frame}));
  add("vrsn 2", R::kBadVersion,
      Join({Chunk("head", Join({ftyp, Chunk("vrsn", Little(2, 1))})), frame}));
  add("ftyp twice", R::kRepeated, Join({Chunk("head", Join({ftyp, ftyp, vrsn})), frame}));
  add("head alone", R::kMissing, Head());
  add("neither skdf nor fram", R::kMissing, Join({Head(), Sndf()}));
  add("skdf and fram", R::kRepeated,
      Join({Head(), Sndf(), frame, Chunk("skdf", Chunk("bons", Definitions()))}));
  add("fram twice", R::kRepeated, Join({Head(), Sndf(), frame, frame}));
  add("sndf twice", R::kRepeated, Join({Head(), Sndf(), Sndf(), frame}));
  const Bytes rcvp = Chunk("rcvp", Little(12351, 2));
  add("no ipad", R::kMissing, Join({Head(), Chunk("sndf", rcvp), frame}));
  add("ipad of four bytes", R::kBadSize,
      Join({Head(), Chunk("sndf", Join({Chunk("ipad", Text("1234")), rcvp})), frame}));
  add("no rcvp", R::kMissing,
      Join({Head(), Chunk("sndf", Chunk("ipad", Text("12345678"))), frame}));
}

inline void AddBadFields(std::vector<DecodeCase>& cases) {
  using R = DecodeResult;
  const auto add = [&](std::string name, R expected, Bytes bytes) {
    cases.push_back({std::move(name), std::move(bytes), expected});
  };
  const Bytes btrs = Chunk("btrs", Bones());
  add("no fnum", R::kMissing, FrameOf(Join({Time(), btrs})));
  add("no time", R::kMissing, FrameOf(Join({Fnum(), btrs})));
  add("no btrs", R::kMissing, FrameOf(Join({Fnum(), Time()})));
  add("an empty fram", R::kMissing, FrameOf({}));
  add("no bons", R::kMissing, Join({Head(), Sndf(), Chunk("skdf", {})}));
  add("fnum twice", R::kRepeated, FrameOf(Join({Fnum(), Time(), Fnum(), btrs})));
  add("btrs twice", R::kRepeated, FrameOf(Join({Fnum(), Time(), btrs, btrs})));
  add("fnum of eight bytes", R::kBadSize,
      FrameOf(Join({Chunk("fnum", Little(7, 8)), Time(), btrs})));
  add("fnum of no bytes", R::kBadSize, FrameOf(Join({Chunk("fnum", {}), Time(), btrs})));
  add("time of eight bytes", R::kBadSize, FrameOf(Join({Fnum(), Chunk("time", Double(1)), btrs})));
  add("uttm of four bytes", R::kBadSize,
      FrameOf(Join({Fnum(), Time(), Chunk("uttm", Float(1)), btrs})));
  add("tmcd of five bytes", R::kBadSize,
      FrameOf(Join({Fnum(), Time(), Chunk("tmcd", Text("abcde")), btrs})));
  for (const float time_s : {-1.0F, 2e9F, std::numeric_limits<float>::infinity(),
                             std::numeric_limits<float>::quiet_NaN()}) {
    add("time " + std::to_string(time_s), R::kBadTime, FrameOf(Join({Fnum(), Time(time_s), btrs})));
  }
}

inline void AddBadBones(std::vector<DecodeCase>& cases) {
  using R = DecodeResult;
  const auto add = [&](std::string name, R expected, Bytes bytes) {
    cases.push_back({std::move(name), std::move(bytes), expected});
  };
  const std::size_t bone = Btdt(0).size();
  Bytes bones = Bones();
  add("26 bones", R::kMissing, WithBones({bones.begin() + static_cast<long>(bone), bones.end()}));
  add("no bones", R::kMissing, WithBones({}));
  add("28 bones", R::kBadBone, WithBones(Join({bones, Btdt(27)})));
  add("a bone twice", R::kBadBone, WithBones(Join({bones, Btdt(26)})));
  add("bone 65535", R::kBadBone, WithBones(Join({bones, Btdt(65535)})));
  add("bone 33, which is 1 of 32", R::kBadBone, WithBones(Join({bones, Btdt(33)})));
  add("a bone without its id", R::kMissing, WithBones(Join({bones, Chunk("btdt", Tran(1))})));
  add("a bone without its place", R::kMissing, WithBones(Chunk("btdt", Bnid(0))));
  add("a bone with its place twice", R::kRepeated,
      WithBones(Chunk("btdt", Join({Bnid(0), Tran(0), Tran(0)}))));
  add("an id of one byte", R::kBadSize,
      WithBones(Chunk("btdt", Join({Chunk("bnid", Little(0, 1)), Tran(0)}))));
  add("a place of six numbers", R::kBadSize,
      WithBones(Chunk("btdt", Join({Bnid(0), Chunk("tran", Bytes(24))}))));
  add("a place of eight numbers", R::kBadSize,
      WithBones(Chunk("btdt", Join({Bnid(0), Chunk("tran", Bytes(32))}))));
  const auto with_parent = [](int id, int parent) {
    Bytes all;
    for (int i = 0; i < kBones; ++i) all = Join({all, Bndt(i, i == id ? parent : kParents[i])});
    return SkeletonOf(all);
  };
  add("a bone that is its own parent", R::kBadBone, with_parent(5, 5));
  add("a parent that comes later", R::kBadBone, with_parent(5, 6));
  add("a second root", R::kBadBone, with_parent(5, -1));
  add("parent -2", R::kBadBone, with_parent(5, -2));
  add("a root with a parent", R::kBadBone, with_parent(0, 0));
  add("a definition without its parent", R::kMissing,
      SkeletonOf(Chunk("bndt", Join({Bnid(0), Tran(0)}))));
}

inline void AddCuts(std::vector<DecodeCase>& cases) {
  using R = DecodeResult;
  const auto add = [&](std::string name, Bytes bytes) {
    cases.push_back({std::move(name), std::move(bytes), R::kCutChunk});
  };
  Bytes cut = GoodFrame();
  cut.pop_back();
  add("frame, one byte short", cut);
  cut = GoodSkeleton();
  cut.resize(cut.size() / 2);
  add("half a skeleton", cut);
  add("one byte too many", Join({GoodFrame(), Bytes(1)}));
  add("seven bytes too many", Join({GoodFrame(), Bytes(7)}));
  add("a chunk of 4 GiB behind the frame", Join({GoodFrame(), Little(~0U, 4), Text("huge")}));
  add("a field that leaves the frame",
      FrameOf(Join({Fnum(), Time(), Chunk("btrs", Bones()), Little(1, 4), Text("uttm")})));
  add("a bone that leaves the list",
      FrameOf(Join(
          {Fnum(), Time(), Chunk("btrs", Join({Little(47, 4), Text("btdt"), Bnid(0), Tran(0)}))})));
  add("a field that leaves the head",
      Join({Chunk("head", Join({Little(19, 4), Text("ftyp"), Text("sony motion format")}))}));
}

inline std::vector<DecodeCase> DecodeCases() {
  std::vector<DecodeCase> cases;
  AddGood(cases);
  AddBadHeads(cases);
  AddBadFields(cases);
  AddBadBones(cases);
  AddCuts(cases);
  return cases;
}

}  // namespace styled::mocopi::testing
