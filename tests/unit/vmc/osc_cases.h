#pragma once

#include <string>
#include <utility>
#include <vector>

#include "proto/rigs/vmc/osc.h"
#include "tests/unit/vmc/bytes.h"

// Every way to get an OSC datagram wrong, one by one, and right ones. Shared by the unit test, by
// the witnesses and, as seeds, by the fuzzer. Those with VMC's addresses that are wrong are as in
// usd-vrm-plugins' corpus malformed-packets (Apache-2.0).
namespace styled::vmc::testing {

// How liblo and oscpack judge a datagram, compared with us.
// kDiffersBefore032: liblo 0.31, Debian 12's, differs; 0.32, Debian 13's, agrees.
enum class Verdict { kAgrees, kDiffers, kDiffersBefore032, kNotAsked };

struct OscCase {
  std::string name;
  Bytes bytes;
  osc::Result expected;
  Verdict liblo, oscpack;
};

inline Bytes Nested(int depth) {
  Bytes bytes = TimeMessage(1);
  for (int i = 0; i < depth; ++i) bytes = Bundle({bytes});
  return bytes;
}

// `parts` of a bundle, sizes and all.
inline Bytes RawBundle(const Bytes& parts) { return S("#bundle") + I(0) + I(1) + parts; }

class OscCaseTable {
 public:
  std::vector<OscCase> cases;

  void AddRight() {
    Add("a message", message_, R::kOk);
    Add("a bone", hips_, R::kOk);
    Add("no arguments", ApplyMessage(), R::kOk);
    // As old senders do; liblo wants them.
    Add("no type tags at all", S("/VMC/Ext/Blend/Apply"), R::kOk, kDiffers);
    Add("an empty bundle", Bundle({}), R::kOk);
    Add("a bundle", Bundle({message_, hips_}), R::kOk);
    Add("a bundle of the future", Bundle({message_}, 0xFFFFFFFF00000000ULL), R::kOk);
    Add("bundles in a bundle", Bundle({message_, Bundle({hips_, Bundle({message_})}), hips_}),
        R::kOk);
    Add("as many bundles as allowed", Nested(osc::kMaxDepth), R::kOk);
    Add("all types",
        S("/a") + S(",ifsbTFNIhtdcmS") + I(7) + F(2.5F) + S("Hips") + I(3) + S("abc") + I(0) +
            I(1) + I(0) + I(1) + I(0) + I(1) + I('x') + I(3) + S("sym"),
        R::kOk);
    Add("a colour", S("/a") + S(",r") + I(1), R::kOk, kDiffers);            // liblo knows none
    Add("an array", S("/a") + S(",[ii]") + I(1) + I(2), R::kOk, kDiffers);  // nor these
    Add("a blob of a multiple of 4", S("/a") + S(",b") + I(4) + I(9), R::kOk);
    Add("a text of a multiple of 4", S("/a") + S(",s") + S("Head"), R::kOk);
    Add("not a number", TimeMessage(std::bit_cast<float>(0x7FC00000U)), R::kOk);
  }

  void AddWrongMessages() {
    Add("nothing", {}, R::kTooShort);
    Add("three bytes", ToBytes("/a"), R::kBadSize);
    Add("not OSC", I(0xDEADBEEF) + I(0xDEADBEEF), R::kBadAddress);
    // oscpack takes any text for an address, and so does liblo 0.31.
    Add("an address without a slash", S("VMC/Ext/T") + S(",f") + F(1), R::kBadAddress,
        Verdict::kDiffersBefore032, kDiffers);
    Add("an address that does not end", ToBytes("/VMC/Ext/T/a"), R::kBadAddress);
    Add("an address cut short", ToBytes("/VMC/Ext/T"), R::kBadSize);
    // oscpack looks for the end at each fourth byte only.
    Add("an address padded with an x", ToBytes({"/VMC/Ext/T\0x", 12}) + S(",f") + F(1),
        R::kBadAddress);
    Add("type tags without a comma", S("/VMC/Ext/T") + S("f") + F(0.5F), R::kBadTypes);
    Add("type tags that do not end", S("/VMC/Ext/T") + ToBytes(",fff"), R::kBadTypes);
    Add("type tags padded with an x", S("/VMC/Ext/T") + ToBytes({",f\0x", 4}) + F(1), R::kBadTypes);
    Add("an unknown type", S("/VMC/Ext/T") + S(",x") + F(1), R::kBadTypes);
    Add("a float cut short", S("/VMC/Ext/T") + S(",f") + ToBytes("\x3D\xCC"), R::kBadSize);
    Add("no float", S("/VMC/Ext/T") + S(",f"), R::kBadArguments);
    Add("a bone without its numbers", S("/VMC/Ext/Bone/Pos") + S(",sfffffff") + S("Hip"),
        R::kBadArguments);
    Add("half a double", S("/a") + S(",d") + I(1), R::kBadArguments);
    Add("a text that does not end", S("/a") + S(",s") + ToBytes("Hips"), R::kBadArguments);
    Add("a text padded with an x", S("/a") + S(",s") + ToBytes({"Hi\0x", 4}), R::kBadArguments);
    Add("no text", S("/a") + S(",s"), R::kBadArguments);
    // oscpack does not look into blobs, nor behind the last argument.
    Add("a blob without a size", S("/a") + S(",b"), R::kBadArguments, kAgrees, kDiffers);
    Add("a blob that leaves the message", S("/a") + S(",b") + I(8) + I(1), R::kBadArguments,
        kAgrees, kDiffers);
    Add("a blob of 4 GiB", S("/a") + S(",b") + I(0xFFFFFFFFU) + I(1), R::kBadArguments, kAgrees,
        kDiffers);
    Add("a blob of 2 GiB", S("/a") + S(",b") + I(0x7FFFFFFFU) + I(1), R::kBadArguments, kAgrees,
        kDiffers);
    Add("four bytes too many", message_ + I(0), R::kSurplus, kAgrees, kDiffers);
    Add("arguments without types", S("/a") + S(",") + I(1), R::kSurplus, kAgrees, kDiffers);
    Add("three bytes too many", message_ + ToBytes("\1\2\3"), R::kBadSize);
    Add("more than UDP carries", Bytes(osc::kMaxDatagramSize + 1, std::byte{'/'}), R::kTooLong);
  }

  void AddWrongBundles() {
    Add("half a bundle's head", S("#bundle"), R::kTooShort);
    Add("a bundle without all of its timetag", S("#bundle") + I(0), R::kTooShort);
    Add("an element of no size", Bundle({message_}) + I(0), R::kBadElement);
    Add("an element's size alone", Bundle({message_}) + I(20), R::kBadElement);
    Add("an element that leaves the bundle", RawBundle(I(512) + message_), R::kBadElement);
    // oscpack 1.1.0 never comes back from it: it goes 4 bytes back with each element.
    Add("an element of 4 GiB", RawBundle(I(0xFFFFFFFCU) + message_), R::kBadElement, kAgrees,
        kNotAsked);
    Add("an element of an odd size", RawBundle(I(19) + message_), R::kBadSize);
    Add("a bundle not a multiple of 4", Bundle({message_}) + ToBytes("\1\2"), R::kBadSize);
    Add("a wrong message after a right one", Bundle({message_, S("/VMC/Ext/T") + S(",f")}),
        R::kBadArguments);
    // liblo refuses what is within, and does not tell.
    Add("a wrong message in a bundle within", Bundle({message_, Bundle({S("/a") + S(",f")})}),
        R::kBadArguments, kDiffers);
    Add("an element that leaves the bundle within", Bundle({RawBundle(I(24) + message_), hips_}),
        R::kBadElement, kDiffers);
    // The limit on the depth is ours alone.
    Add("one bundle more than allowed", Nested(osc::kMaxDepth + 1), R::kTooDeep, kDiffers,
        kDiffers);
    Add("hundreds of bundles", Nested(300), R::kTooDeep, kDiffers, kDiffers);
  }

 private:
  using R = osc::Result;
  static constexpr Verdict kAgrees = Verdict::kAgrees, kDiffers = Verdict::kDiffers,
                           kNotAsked = Verdict::kNotAsked;

  void Add(std::string name, Bytes bytes, R expected, Verdict liblo = kAgrees,
           Verdict oscpack = kAgrees) {
    cases.push_back({std::move(name), std::move(bytes), expected, liblo, oscpack});
  }

  const Bytes message_ = TimeMessage(0.5F);
  const Bytes hips_ = BoneMessage("Hips");
};

inline std::vector<OscCase> OscCases() {
  OscCaseTable table;
  table.AddRight();
  table.AddWrongMessages();
  table.AddWrongBundles();
  return table.cases;
}

}  // namespace styled::vmc::testing
