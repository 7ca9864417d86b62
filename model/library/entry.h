#pragma once

#include "model/library/styled.h"

// The functions that make the first handle, on a processor that has the instructions of the build.
// All others are given such a handle, so that they need no check.
extern "C" {
styled_network* styled_load_checked(const char* weights, const char* precision, char* error,
                                    size_t error_size);
styled_clip* styled_read_clip_checked(const char* file, const char* const* joints, char* error,
                                      size_t error_size);
styled_clip* styled_make_clip_checked(const styled_body* body, double rate_hz, size_t frames,
                                      const float* root, const float* rotations, char* error,
                                      size_t error_size);
}
