#pragma once

#include <string>
#include <vector>

#include "proto/rigs/ifacialmocap/ifacialmocap.h"

namespace styled::ifacialmocap::testing {

// As the vendor's page for developers prints a frame's end, and a beginning in the same form.
inline constexpr const char* kVersion1 =
    "mouthSmile_R-0|eyeLookDown_L-17|jawOpen-12|mouthLeft-1|browDown_R-5|"
    "=head#-21.488958,-6.038993,-6.6019735,-0.030653415,-0.10287084,-0.6584072|"
    "rightEye#6.0297494,2.4403017,0.25649446|leftEye#6.034903,-1.6660284,-0.17520553|";
// Of a newer app: a state first, sides as whole words, and an unknown name.
inline constexpr const char* kVersion2 =
    "trackingStatus-1|mouthSmileRight&3|eyeLookDown_L&17|jawOpen&-3|FM_Tongue&40|"
    "=head#1,2,3,0.1,0.2,0.3|rightEye#0,0,0|leftEye#1,-1,0|";

struct Case {
  std::string name, text;
  DecodeResult result;
};

inline std::vector<Case> DecodeCases() {
  return {
      {"version 1", kVersion1, DecodeResult::kOk},
      {"version 2", kVersion2, DecodeResult::kOk},
      {"a head alone", "=head#1,2,3,4,5,6|", DecodeResult::kOk},
      {"without the last bar", "jawOpen-12", DecodeResult::kOk},
      {"a value of 1e30", "jawOpen&1e30|", DecodeResult::kOk},
      {"nothing", "", DecodeResult::kNotFace},
      {"bars", "||||", DecodeResult::kNotFace},
      {"unknown parts", "trackingStatus-1|FM_Tongue&40|hat#1,2|", DecodeResult::kNotFace},
      {"another language", "jawOpen-12|\xC3\xA4|", DecodeResult::kNotFace},
      {"the start text", std::string(kStart), DecodeResult::kNotFace},
      {"no number", "jawOpen-|", DecodeResult::kBadNumber},
      {"a word", "jawOpen&wide|", DecodeResult::kBadNumber},
      {"a number and more", "jawOpen&12%|", DecodeResult::kBadNumber},
      {"not a number", "jawOpen&nan|", DecodeResult::kBadNumber},
      {"a head of five", "=head#1,2,3,4,5|", DecodeResult::kBadNumber},
      {"a head of seven", "=head#1,2,3,4,5,6,7|", DecodeResult::kBadNumber},
      {"too long", std::string(kMaxSize + 1, '|'), DecodeResult::kTooLong},
  };
}

}  // namespace styled::ifacialmocap::testing
