#pragma once

#include <span>

#include "model/net/licence.h"
#include "model/net/styles.h"
#include "proto/styled/v1/control.pb.h"

// The licences of weights and styles in the daemon's answers. Pinned by
// tests/unit/daemon/terms_test.cpp.
namespace styled::pipeline {

void FillTerms(const net::Terms& terms, v1::WeightsTerms& out);

// Licence and credit of a style of the weights: its own, else those of its network's file among
// `files`.
void FillTerms(const net::StyleInfo& style, std::span<const net::Terms> files, v1::StyleInfo& out);

// Sets the answer to whether the licence in `out` allows commercial use. `before`, or null: the
// style listed before it; a thousand made styles share a licence, which is then judged once.
void FillCommercialUse(const v1::StyleInfo* before, v1::StyleInfo& out);

}  // namespace styled::pipeline
