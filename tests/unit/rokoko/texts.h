#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "proto/rigs/rokoko/rokoko.h"

// Frames as Rokoko's plug-ins read them, written by hand, and every way to get one wrong. Shared by
// the unit tests and, as seeds, by the fuzzer.
namespace styled::rokoko::testing {

// Layout 3, two actors: one with a few joints, one with gloves alone.
inline constexpr std::string_view kLayout3 = R"({
  "version": "3,0", "fps": 60.0,
  "scene": {
    "timestamp": 12.345678,
    "actors": [
      { "name": "J\u00fcrgen \"M\" \ud83d\ude00", "color": [255, 0, 10],
        "meta": { "hasGloves": false, "hasLeftGlove": false, "hasRightGlove": false,
                  "hasBody": true, "hasFace": true },
        "dimensions": { "totalHeight": 1.8, "hipHeight": 0.95 },
        "body": {
          "hip": { "position": { "x": 0.5, "y": 0.96, "z": -1.25e-1 },
                   "rotation": { "x": 0, "y": 0.25, "z": 0.0, "w": 1 } },
          "leftUpperArm": { "rotation": { "w": -0.5, "z": 0.5, "y": -0.5, "x": -0.5 },
                            "position": { "z": 3, "y": 2, "x": 1 } },
          "head": { "position": { "x": 0, "y": 1.7, "z": 0 }, "rotation": null },
          "tail": { "position": { "x": 0, "y": 1.7, "z": 0 } }
        },
        "face": { "faceId": "f", "jawOpen": 12.5, "nested": [[{}, []], {"a": {"b": [1]}}] } },
      { "name": "gloves", "body": {
          "rightLittleTip": { "position": { "x": 7, "y": 8, "z": 9 },
                              "rotation": { "x": 0, "y": 0, "z": 0, "w": 1 } } } }
    ],
    "props": [ { "name": "cup", "type": 0, "position": { "x": 0, "y": 0, "z": 0 } } ],
    "characters": [], "newtons": null
  }
})";

// Layout 2.5: all at the top, joints in the actor.
inline constexpr std::string_view kLayout2 =
    R"({"version":2.5,"timestamp":3.5,"playbackTimestamp":0,
  "props":[],"trackers":[{"name":"1","position":{"x":0,"y":0,"z":0}}],"faces":[],
  "actors":[{"name":"anna","profileName":"p","id":"0","isLive":true,"hipHeight":0.9,
    "hip":{"position":{"x":1,"y":2,"z":3},"rotation":{"x":0,"y":0,"z":0,"w":1}},
    "rightToe":{"position":{"x":4,"y":5,"z":6},"rotation":{"x":0,"y":1,"z":0,"w":0}}}]})";

struct DecodeCase {
  std::string name;
  std::string text;
  DecodeResult expected;
};

// A frame whose actor has this body, and one whose scene has these members.
inline std::string WithBody(const std::string& body) {
  return R"({"version":3,"scene":{"timestamp":1,"actors":[{"name":"a","body":)" + body + "}]}}";
}
inline std::string WithScene(const std::string& members) {
  return R"({"version":3,"scene":{)" + members + "}}";
}

inline void AddGood(std::vector<DecodeCase>& cases) {
  const auto add = [&](std::string name, std::string text) {
    cases.push_back({std::move(name), std::move(text), DecodeResult::kOk});
  };
  add("layout 3", std::string(kLayout3));
  add("layout 2.5", std::string(kLayout2));
  add("no actors", WithScene(R"("timestamp":1,"actors":[])"));
  add("no version", R"({"scene":{"timestamp":1,"actors":[]}})");
  for (const char* version : {"3", "3.0", "\"3\"", "\"3.0\"", "\"3,0\"", "2", "2.5", "\"2,5\""}) {
    add(std::string("version ") + version,
        R"({"scene":{"timestamp":1,"actors":[]},"version":)" + std::string(version) + "}");
  }
  add("space around", " \r\n\t" + WithScene(R"("timestamp":1,"actors":[])") + " \n");
  add("no body", R"({"scene":{"timestamp":1,"actors":[{"name":"a","body":null}]}})");
  add("an actor without a name", R"({"scene":{"timestamp":1,"actors":[{}]}})");
  add("a joint that is half there", WithBody(R"({"hip":{"position":{"x":1,"y":2}}})"));
  add("a joint that is no object", WithBody(R"({"hip":[1,2,3],"head":"no"})"));
  add("members twice", R"({"fps":1,"fps":2,"scene":{"timestamp":1,"actors":[{}]},)"
                       R"("scene":{"timestamp":2,"actors":[]}})");
  add("a number too small for a float", WithScene(R"("timestamp":1e-400,"actors":[])"));
  std::string nine;
  for (int k = 0; k < 9; ++k) nine += (k > 0 ? ",{}" : "{}");
  add("nine actors", WithScene(R"("timestamp":1,"actors":[)" + nine + "]"));
  add("an unknown member 30 deep", R"({"odd":)" + std::string(30, '[') + std::string(30, ']') +
                                       R"(,"scene":{"timestamp":1,"actors":[]}})");
}

inline void AddBad(std::vector<DecodeCase>& cases) {
  using R = DecodeResult;
  const auto add = [&](std::string name, R expected, std::string text) {
    cases.push_back({std::move(name), std::move(text), expected});
  };
  add("nothing", R::kNotRokoko, "");
  add("space alone", R::kNotRokoko, "   ");
  add("a number", R::kNotRokoko, "3");
  add("a list", R::kNotRokoko, "[]");
  add("one of ours", R::kNotRokoko, "STYD");
  add("an LZ4 frame that ends with its magic", R::kBadLz4, "\x04\x22\x4D\x18");
  add("LZ4's skippable frame", R::kNotRokoko, std::string("\x50\x2A\x4D\x18\0\0\0\0", 8));
  add("an empty object", R::kMissing, "{}");
  add("no timestamp", R::kMissing, WithScene(R"("actors":[])"));
  add("no list of actors", R::kMissing, WithScene(R"("timestamp":1)"));
  add("a scene that is null", R::kMissing, R"({"scene":null})");
  add("actors that are null", R::kMissing, WithScene(R"("timestamp":1,"actors":null)"));
  for (const char* version : {"1", "4", "-3", "1e30", "\"\"", "\"three\"", "\"1,0\"", "\"nan\""}) {
    add(std::string("version ") + version, R::kBadVersion,
        R"({"version":)" + std::string(version) + R"(,"scene":{"timestamp":1,"actors":[]}})");
  }
  add("version of another type", R::kBadValue, R"({"version":[3]})");
  add("a scene that is a list", R::kBadValue, R"({"scene":[]})");
  add("actors that are an object", R::kBadValue, WithScene(R"("timestamp":1,"actors":{})"));
  add("an actor that is a number", R::kBadValue, WithScene(R"("timestamp":1,"actors":[1])"));
  add("an actor that is null", R::kBadValue, WithScene(R"("timestamp":1,"actors":[null])"));
  add("a name that is a number", R::kBadValue, WithScene(R"("timestamp":1,"actors":[{"name":1}])"));
  add("a body that is a list", R::kBadValue, WithBody("[]"));
  add("a hip height that is text", R::kBadValue,
      WithScene(R"("timestamp":1,"actors":[{"dimensions":{"hipHeight":"1"}}])"));
  add("a timestamp that is text", R::kBadValue, WithScene(R"("timestamp":"1","actors":[])"));
  add("a timestamp before 0", R::kBadValue, WithScene(R"("timestamp":-1,"actors":[])"));
  add("a timestamp of 2e10", R::kBadValue, WithScene(R"("timestamp":2e10,"actors":[])"));
  add("a position that is a list", R::kBadValue, WithBody(R"({"hip":{"position":[1,2,3]}})"));
  add("a coordinate that is text", R::kBadValue,
      WithBody(R"({"hip":{"position":{"x":"1","y":2,"z":3}}})"));
  add("a coordinate beyond a float", R::kBadValue,
      WithBody(R"({"hip":{"position":{"x":1e39,"y":2,"z":3}}})"));
  add("a coordinate beyond a double", R::kBadJson,
      WithBody(R"({"hip":{"position":{"x":1e309,"y":2,"z":3}}})"));
  add("a bare NaN", R::kBadJson, WithBody(R"({"hip":{"position":{"x":NaN,"y":2,"z":3}}})"));
  add("cut short", R::kBadJson, std::string(kLayout3.substr(0, kLayout3.size() - 2)));
  add("two frames", R::kBadJson, std::string(kLayout2) + std::string(kLayout2));
  add("32 lists in an object", R::kTooDeep,
      R"({"odd":)" + std::string(32, '[') + std::string(32, ']') + "}");
  std::string thousand;
  for (int k = 0; k < 1000; ++k) thousand += R"({"a":)";
  add("a thousand objects within each other", R::kTooDeep, thousand + "0" + std::string(1000, '}'));
  add("a thousand objects within each other, never closed", R::kBadJson, thousand);
  add("more than a megabyte", R::kTooLong,
      R"({"scene":{"timestamp":1,"actors":[]}})" + std::string(kMaxTextSize, ' '));
}

inline std::vector<DecodeCase> DecodeCases() {
  std::vector<DecodeCase> cases;
  AddGood(cases);
  AddBad(cases);
  return cases;
}

}  // namespace styled::rokoko::testing
