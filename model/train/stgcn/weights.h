#pragma once

#include <filesystem>

#include "model/base/status.h"
#include "model/train/recipe.h"

namespace styled::train::st_gcn {

inline constexpr const char* kFamily = "st-gcn";

// The keys of the family in a weights file of version 2 (model/net/FORMAT.md): "heading_tau_s",
// "width" (w), "code", "noise", "window" (frames that the encoder sees), "contents" (names,
// informative). Its tensors, n styles, V nodes of the level whose adjacency a graph convolution
// mixes by (the finer one for gconv1 of g.enc* and e.res*, the coarser one for gconv1 of g.dec*):
//   features.mean, features.deviation [21, 7]
//   g.in.weight [w, 7], .bias [w], .node_bias [21, w]; g.out.weight [7, w], .bias [7]
//   g.enc1 (w to 2w), g.enc2 (2w to 4w): norm1.scale, .shift [Cin], gconv1.weight [3 Cin, Cin],
//     .bias [3 Cin], .node_bias [V, Cin], tconv1.weight [Cin, Cin, 3], .bias [Cin]; norm2 [Cin],
//     gconv2 [3 Cout, Cin], [3 Cout], [V, Cout], tconv2 [Cout, Cout, 3], [Cout];
//     skip.weight [Cout, Cin]
//   g.dec1 (4w to 2w), g.dec2 (2w to w): adain1.weight [2 Cin, code], .bias [2 Cin]: γ, then β;
//     gconv1 [3 Cout, Cin], ...; tconv1 [Cout, Cout, 3]; adain2 [2 Cout, code]; gconv2, tconv2,
//     skip
//   e.in, e.res1, e.res2 like g.in, g.enc1, g.enc2, without norms
//   e.conv.weight [4w, 4w, 16, 5]: out, in, frame, node; .bias [4w]
//   e.heads.weight [n, code, 4w], .bias [n, code]; e.free.weight [code, 4w], .bias [code]
//   f.noise.weight [256, noise], f.label.weight [256, n], f.fc1.weight [512, 512], f.fc2.weight
//     [1024, 512], f.out.weight [code, 1024], each with .bias; fc1 takes noise's output, then
//     label's
//   codes.mean [n, code]: of the training windows of each style
// Without node biases (an option of training) they are written as zeros.
// Everything that is needed is in the checkpoint; errors name what is missing.
Status ExportWeights(const Checkpoint& checkpoint, const std::filesystem::path& file);

}  // namespace styled::train::st_gcn
