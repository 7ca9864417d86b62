#include "tests/hostile/attacks.h"

#include <cstdint>
#include <limits>

#include "tests/e2e/examples.h"

namespace styled::hostile {
namespace {

constexpr std::size_t kMiB = std::size_t{1} << 20U;
constexpr std::size_t kLargestText = 60'000;    // a request without a file may have 64 KiB
constexpr std::size_t kLargestFile = 7 * kMiB;  // with one, 8 MiB

std::string Times(std::size_t count, const std::string& text) {
  std::string all;
  all.reserve(count * text.size());
  for (std::size_t i = 0; i < count; ++i) all += text;
  return all;
}

v1::Request Of(const std::string& performer) {
  v1::Request request;
  request.set_performer(performer);
  return request;
}

v1::Request LikeClip(std::string clip) {
  v1::Request request = Of("");
  request.mutable_like()->set_name("attack");
  request.mutable_like()->set_file("attack.clip");
  request.mutable_like()->set_clip(std::move(clip));
  return request;
}

v1::Request Import(std::string file) {
  v1::Request request;
  request.mutable_import_style()->set_file(std::move(file));
  request.mutable_import_style()->set_replace(true);
  return request;
}

// A skeleton of `count` joints in a chain, and `frames` frames of zeros.
std::string ChainBvh(std::size_t count, std::size_t frames) {
  std::string text = "HIERARCHY\n";
  for (std::size_t i = 0; i < count; ++i) {
    text += (i == 0 ? "ROOT j" : "JOINT j") + std::to_string(i) +
            "\n{\nOFFSET 0 1 0\nCHANNELS 3 Zrotation Xrotation Yrotation\n";
  }
  text += "End Site\n{\nOFFSET 0 1 0\n}\n" + Times(count, "}\n") +
          "MOTION\nFrames: " + std::to_string(frames) + "\nFrame Time: 0.01\n";
  return text + Times(frames, Times(count, "0 0 0 ") + "\n");
}

std::string EmptyNodesGlb() {
  std::string json = R"({"asset":{"version":"2.0"},"nodes":[{})" + Times(60'000, ",{}") +
                     R"(],"animations":[{"channels":[],"samplers":[]})" +
                     Times(4'000, R"(,{"channels":[],"samplers":[]})") + "]}";
  return Glb(json);
}

std::string DeepNodesGlb() {
  std::string nodes;
  constexpr int kDeep = 50'000;
  for (int i = 0; i < kDeep; ++i) {
    nodes += (i == 0 ? R"({"children":[)" : R"(,{"children":[)") + std::to_string(i + 1) + "]}";
  }
  return Glb(R"({"asset":{"version":"2.0"},"scenes":[{"nodes":[0]}],"nodes":[)" + nodes + ",{}]}");
}

// One accessor of all of the buffer that many animations read.
std::string SharedAccessorGlb() {
  std::string animations;
  for (int i = 0; i < 20'000; ++i) {
    animations += (i == 0 ? "" : ",");
    animations += R"({"channels":[{"sampler":0,"target":{"node":0,"path":"rotation"}}],)"
                  R"("samplers":[{"input":0,"output":1}]})";
  }
  return Glb(R"({"asset":{"version":"2.0"},"nodes":[{"name":"Hips"}],)"
             R"("accessors":[{"componentType":5126,"count":4000000,"type":"SCALAR"},)"
             R"({"componentType":5126,"count":4000000,"type":"VEC4"}],"animations":[)" +
             animations + "]}");
}

// A style's file that this daemon reads, with `more` in front of its fields.
v1::Request ImportWith(const Loot& loot, const std::string& more) {
  std::string file = loot.style_file;
  return Import(file.insert(file.find('{') + 1, more));
}

v1::Request Set(const std::string& performer, int styles) {
  v1::Request request = Of(performer);
  for (int i = 0; i < styles; ++i) {
    auto& entry = *request.mutable_set()->add_mix();
    entry.set_style("style1");
    entry.set_weight(1);
  }
  return request;
}

// `entries` empty entries of a list of messages: 2 bytes each on the wire.
v1::Request EmptyMix(std::size_t entries) {
  v1::Request request = Of("rig.victim");
  v1::Look& look = *request.mutable_restore_checkpoint()->mutable_checkpoint()->mutable_look();
  for (std::size_t i = 0; i < entries; ++i) (void)look.add_mix();
  return request;
}

// A checkpoint that this daemon has taken, changed.
v1::Request Restore(const Loot& loot, const std::function<void(v1::Checkpoint&)>& change) {
  v1::Request request = Of("rig.other");
  v1::Checkpoint& checkpoint = *request.mutable_restore_checkpoint()->mutable_checkpoint();
  checkpoint = loot.checkpoint;
  checkpoint.set_performer("rig.other");
  change(checkpoint);
  return request;
}

}  // namespace

std::string LargeBvh(std::size_t bytes) {
  const std::string short_walk = support::WalkBvh(60, 2);
  const std::size_t motion = short_walk.find("Frames:");
  const std::size_t first = short_walk.find('\n', short_walk.find("Frame Time:")) + 1;
  const std::string frame = short_walk.substr(first, short_walk.find('\n', first) + 1 - first);
  const std::size_t frames = (bytes - first) / frame.size();
  // At most a minute is an example: the rate determines the number of its frames.
  return short_walk.substr(0, motion) + "Frames: " + std::to_string(frames) +
         "\nFrame Time: " + std::to_string(30.0 / static_cast<double>(frames)) + "\n" +
         Times(frames, frame);
}

std::string Glb(const std::string& json) {
  const std::string padded = json + std::string((4 - json.size() % 4) % 4, ' ');
  const auto number = [](std::uint32_t value) {
    return std::string(reinterpret_cast<const char*>(&value), sizeof value);
  };
  const auto size = static_cast<std::uint32_t>(padded.size());
  return "glTF" + number(2) + number(size + 20) + number(size) + "JSON" + padded;
}

std::vector<RequestAttack> RequestAttacks() {
  const std::string long_text(kLargestText, 'x');
  return {
      {"list", "Many",
       [](const Loot&) {
         v1::Request request;
         request.mutable_list();
         return request;
       }},
      {"set", "AStyle", [](const Loot&) { return Set("rig.victim", 1); }},
      {"set", "AStyleForAll", [](const Loot&) { return Set("*", 1); }},
      {"set", "FourThousandStyles", [](const Loot&) { return Set("rig.victim", 4'000); }},
      {"set", "NotANumber",
       [](const Loot&) {
         v1::Request request = Set("rig.victim", 1);
         request.mutable_set()->set_strength(std::numeric_limits<float>::quiet_NaN());
         return request;
       }},
      {"pin", "OfALongName",
       [=](const Loot&) {
         v1::Request request = Of(long_text);
         request.mutable_pin()->set_pinned(true);
         return request;
       }},
      {"preset", "OfALongName",
       [=](const Loot&) {
         v1::Request request = Of("rig.victim");
         request.mutable_preset()->set_name(long_text);
         return request;
       }},
      {"panic", "Many",
       [](const Loot&) {
         v1::Request request;
         request.mutable_panic();
         return request;
       }},
      {"reset", "Many",
       [](const Loot&) {
         v1::Request request = Of("rig.other");
         request.mutable_reset();
         return request;
       }},
      {"status", "Many",
       [](const Loot&) {
         v1::Request request;
         request.mutable_status();
         return request;
       }},
      {"calibrate", "WhileTheyMove",
       [](const Loot&) {
         v1::Request request = Of("rig.victim");
         request.mutable_calibrate();
         return request;
       }},
      {"cue", "OfALongName",
       [=](const Loot&) {
         v1::Request request;
         request.mutable_cue()->set_name(long_text);
         return request;
       }},
      {"like", "ASmallExample", [](const Loot&) { return LikeClip(support::WalkBvh(60, 2)); }},
      {"like", "AValidBvhOfSevenMegabytes",
       [](const Loot&) {
         static const std::string clip = LargeBvh(kLargestFile);
         return LikeClip(clip);
       }},
      {"like", "ABvhOfAThousandJoints", [](const Loot&) { return LikeClip(ChainBvh(1024, 1200)); }},
      {"like", "ABvhThatSaysABillionFrames",
       [](const Loot&) {
         std::string clip = ChainBvh(21, 1);
         return LikeClip(clip.replace(clip.find("Frames: 1"), 9, "Frames: 1000000000"));
       }},
      {"like", "AGlbOfEmptyNodes", [](const Loot&) { return LikeClip(EmptyNodesGlb()); }},
      {"like", "AGlbOfDeepNodes", [](const Loot&) { return LikeClip(DeepNodesGlb()); }},
      {"like", "AGlbThatReadsTheSameAgainAndAgain",
       [](const Loot&) { return LikeClip(SharedAccessorGlb()); }},
      {"like", "AGlbOfDeepJson",
       [](const Loot&) { return LikeClip(Glb(Times(1'000'000, "[") + Times(1'000'000, "]"))); }},
      {"like", "ACodeOfAMillionNumbers",
       [](const Loot&) {
         v1::Request request = LikeClip("");
         for (int i = 0; i < 1'000'000; ++i) request.mutable_like()->add_code(1);
         return request;
       }},
      {"like", "ASecondOfThePerformer",
       [](const Loot&) {
         v1::Request request = Of("rig.victim");
         request.mutable_like()->set_name("attack");
         request.mutable_like()->set_learn_s(1);
         return request;
       }},
      {"preview", "OfEachStyle",
       [](const Loot&) {
         v1::Request request;
         request.mutable_preview()->set_style("style1");
         return request;
       }},
      {"explain", "AllThatIsKeptAgainAndAgain",
       [](const Loot&) {
         v1::Request request = Of("rig.victim");
         request.mutable_explain()->set_last(std::numeric_limits<std::uint32_t>::max());
         return request;
       }},
      {"explain", "OfALongNameAndAllTime",
       [=](const Loot&) {
         v1::Request request = Of(long_text);
         request.mutable_explain()->set_after_ns(std::numeric_limits<std::int64_t>::min());
         return request;
       }},
      {"export_style", "OfALongName",
       [=](const Loot&) {
         v1::Request request;
         request.mutable_export_style()->set_name(long_text);
         return request;
       }},
      {"import_style", "AFileOfDeepUnknownFields",
       [](const Loot& loot) {
         return ImportWith(loot,
                           R"("more":)" + Times(10'000, "[1,") + "1" + Times(10'000, "]") + ",");
       }},
      {"import_style", "AFileOfManyUnknownFields",
       [](const Loot& loot) {
         std::string more;
         for (int i = 0; i < 60'000; ++i) more += "\"f" + std::to_string(i) + "\":1,";
         return ImportWith(loot, more);
       }},
      {"import_style", "AFileOfDeepJson",
       [](const Loot&) { return Import(Times(500'000, "{\"a\":") + "1" + Times(500'000, "}")); }},
      {"import_style", "AFileOfOtherWeights",
       [](const Loot& loot) {
         std::string file = loot.style_file;
         file.replace(file.find("\"crc32c:"), 9, "\"crc32c:x");  // instead of the first digit
         return Import(file);
       }},
      {"rename_style", "ToALongName",
       [=](const Loot&) {
         v1::Request request;
         request.mutable_rename_style()->set_name("attack");
         request.mutable_rename_style()->set_to(long_text);
         return request;
       }},
      {"remove_style", "OfALongName",
       [=](const Loot&) {
         v1::Request request;
         request.mutable_remove_style()->set_name(long_text);
         return request;
       }},
      {"take_checkpoint", "Many",
       [](const Loot&) {
         v1::Request request = Of("rig.victim");
         request.mutable_take_checkpoint();
         return request;
       }},
      {"restore_checkpoint", "ATrueOne",
       [](const Loot& loot) { return Restore(loot, [](auto&) {}); }},
      {"restore_checkpoint", "ALargeState",
       [](const Loot& loot) {
         return Restore(loot, [](auto& c) { c.set_state(std::string(kLargestFile, '\1')); });
       }},
      {"restore_checkpoint", "AMillionStyles",
       [](const Loot& loot) {
         return Restore(loot, [](auto& c) {
           for (int i = 0; i < 1'000'000; ++i) c.add_styles("");
         });
       }},
      {"restore_checkpoint", "AMillionEmptyEntries",
       [](const Loot&) { return EmptyMix(1'000'000); }},
      {"lead", "Many",
       [](const Loot&) {
         v1::Request request;
         request.mutable_lead();
         return request;
       }},
  };
}

}  // namespace styled::hostile
