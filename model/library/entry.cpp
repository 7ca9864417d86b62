// The functions of styled.h that make the first handle, compiled as model/base/processor.cpp is: on
// a processor without the instructions of the rest they refuse, and the program that loaded the
// library runs on.
#include "model/library/entry.h"

#include "model/base/processor.h"

namespace {

// Whether the processor lacks an instruction; then `error` says which.
bool Refused(char* error, size_t error_size) {
  const styled::Instructions* const missing = styled::MissingInstructions();
  if (missing != nullptr && error != nullptr && error_size > 0) {
    styled::ExplainMissing(*missing, error, error_size);
  }
  return missing != nullptr;
}

}  // namespace

styled_network* styled_load(const char* weights, const char* precision, char* error,
                            size_t error_size) {
  if (Refused(error, error_size)) return nullptr;
  return styled_load_checked(weights, precision, error, error_size);
}

styled_clip* styled_read_clip(const char* file, const char* const* joints, char* error,
                              size_t error_size) {
  if (Refused(error, error_size)) return nullptr;
  return styled_read_clip_checked(file, joints, error, error_size);
}

styled_clip* styled_make_clip(const styled_body* body, double rate_hz, size_t frames,
                              const float* root, const float* rotations, char* error,
                              size_t error_size) {
  if (Refused(error, error_size)) return nullptr;
  return styled_make_clip_checked(body, rate_hz, frames, root, rotations, error, error_size);
}
