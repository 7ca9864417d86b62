#include "model/train/stgcn/normalized_leaky.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>

namespace styled::train::st_gcn {
namespace {

using torch::Tensor;

constexpr float kLeak = 0.2F;
constexpr float kVarianceEpsilon = 1e-5F;  // of the variance of values of about 1

// Numbers in memory: float, or the upper half of one. Written so that the compiler vectorizes.
inline float Load(float value) { return value; }
inline float Load(std::uint16_t upper) {
  return std::bit_cast<float>(static_cast<std::uint32_t>(upper) << 16);
}
inline void Store(float value, float& to) { to = value; }
inline void Store(float value, std::uint16_t& to) {  // to the nearest, ties to even
  const auto bits = std::bit_cast<std::uint32_t>(value);
  to = static_cast<std::uint16_t>((bits + 0x7FFFU + ((bits >> 16) & 1U)) >> 16);
}

// Channels that are worked on together: a loop of fixed length over local arrays becomes vector
// instructions. Widths are multiples of 8.
constexpr int kLanes = 8;
using Lanes = std::array<float, kLanes>;

// The LeakyReLU's slope at `a`, without a branch: signs are as good as random.
inline float Slope(float a) { return 0.5F * (1 + kLeak) + std::copysign(0.5F * (1 - kLeak), a); }

// One sample's frames and nodes of kLanes channels: `rows` rows, `stride` numbers apart.
struct Rows {
  int64_t rows, stride;
};

template <typename T>
Lanes LoadRow(const T* from) {
  Lanes to;
  for (int i = 0; i < kLanes; ++i) to[i] = Load(from[i]);
  return to;
}

template <typename T>
void Moments(Rows of, const T* x, Lanes& mean, Lanes& inverse) {
  const float share = 1.0F / static_cast<float>(of.rows);
  Lanes sum{};
  for (int64_t row = 0; row < of.rows; ++row) {
    const Lanes v = LoadRow(x + row * of.stride);
    for (int i = 0; i < kLanes; ++i) sum[i] += v[i];
  }
  for (int i = 0; i < kLanes; ++i) mean[i] = share * sum[i];
  Lanes square{};
  for (int64_t row = 0; row < of.rows; ++row) {
    const Lanes v = LoadRow(x + row * of.stride);
    for (int i = 0; i < kLanes; ++i) square[i] += (v[i] - mean[i]) * (v[i] - mean[i]);
  }
  for (int i = 0; i < kLanes; ++i)
    inverse[i] = 1.0F / std::sqrt(square[i] * share + kVarianceEpsilon);
}

template <typename T>
void Forward(Rows of, const T* x, const float* scale, const float* shift, float* mean_out,
             float* inverse_out, T* y) {
  Lanes mean, inverse, gain, offset;
  Moments(of, x, mean, inverse);
  for (int i = 0; i < kLanes; ++i) {
    mean_out[i] = mean[i];
    inverse_out[i] = inverse[i];
    gain[i] = scale[i] * inverse[i];
    offset[i] = shift[i] - gain[i] * mean[i];
  }
  for (int64_t row = 0; row < of.rows; ++row) {
    const Lanes v = LoadRow(x + row * of.stride);
    T* out = y + row * of.stride;
    for (int i = 0; i < kLanes; ++i) {
      const float a = gain[i] * v[i] + offset[i];
      Store(std::max(a, kLeak * a), out[i]);
    }
  }
}

// With x̂ the normalized input and g the gradient before the LeakyReLU: by shift Σ g, by scale
// Σ g x̂, by x: scale / deviation · (g - mean(g) - x̂ mean(g x̂)).
template <typename T>
void Backward(Rows of, const T* x, const T* gradient, const float* scale, const float* shift,
              const float* mean_in, const float* inverse_in, float* by_scale, float* by_shift,
              T* by_x) {
  Lanes inverse, origin, gain, offset, sum{}, product{};
  for (int i = 0; i < kLanes; ++i) {
    inverse[i] = inverse_in[i];
    origin[i] = -mean_in[i] * inverse[i];
    gain[i] = scale[i];
    offset[i] = shift[i];
  }
  for (int64_t row = 0; row < of.rows; ++row) {
    const Lanes v = LoadRow(x + row * of.stride), g = LoadRow(gradient + row * of.stride);
    for (int i = 0; i < kLanes; ++i) {
      const float normalized = v[i] * inverse[i] + origin[i];
      const float inner = g[i] * Slope(gain[i] * normalized + offset[i]);
      sum[i] += inner;
      product[i] += inner * normalized;
    }
  }
  const float share = 1.0F / static_cast<float>(of.rows);
  for (int64_t row = 0; row < of.rows; ++row) {
    const Lanes v = LoadRow(x + row * of.stride), g = LoadRow(gradient + row * of.stride);
    T* out = by_x + row * of.stride;
    for (int i = 0; i < kLanes; ++i) {
      const float normalized = v[i] * inverse[i] + origin[i];
      const float inner = g[i] * Slope(gain[i] * normalized + offset[i]);
      Store(gain[i] * inverse[i] * (inner - share * (sum[i] + normalized * product[i])), out[i]);
    }
  }
  for (int i = 0; i < kLanes; ++i) {
    by_scale[i] = product[i];
    by_shift[i] = sum[i];
  }
}

template <typename T>
T* Data(const Tensor& tensor) {
  return static_cast<T*>(tensor.data_ptr());
}

class Fused : public torch::autograd::Function<Fused> {
 public:
  static Tensor forward(torch::autograd::AutogradContext* context, const Tensor& x_in,
                        const Tensor& scale_in, const Tensor& shift_in) {
    const Tensor x = x_in.contiguous(), scale = scale_in.contiguous(),
                 shift = shift_in.contiguous();
    Tensor y = torch::empty_like(x);
    Tensor mean = torch::empty_like(scale), inverse = torch::empty_like(scale);
    if (x.scalar_type() == torch::kFloat32) {
      Run<float>(x, scale, shift, mean, inverse, y);
    } else {
      Run<std::uint16_t>(x, scale, shift, mean, inverse, y);
    }
    context->save_for_backward({x, scale, shift, mean, inverse});
    return y;
  }

  static torch::autograd::variable_list backward(torch::autograd::AutogradContext* context,
                                                 torch::autograd::variable_list gradients) {
    const auto saved = context->get_saved_variables();
    const Tensor gradient = gradients[0].contiguous();
    Tensor by_x = torch::empty_like(saved[0]);
    Tensor by_scale = torch::empty_like(saved[1]), by_shift = torch::empty_like(saved[2]);
    if (saved[0].scalar_type() == torch::kFloat32) {
      RunBack<float>(saved, gradient, by_x, by_scale, by_shift);
    } else {
      RunBack<std::uint16_t>(saved, gradient, by_x, by_scale, by_shift);
    }
    return {by_x, by_scale, by_shift};
  }

 private:
  // Calls visit(place of the sample's and lanes' moments, place of their first number, rows).
  template <typename Visit>
  static void Each(const Tensor& x, const Visit& visit) {
    const int64_t channels = x.size(3);
    const Rows rows{x.size(1) * x.size(2), channels};
    for (int64_t sample = 0; sample < x.size(0); ++sample) {
      for (int64_t lane = 0; lane < channels; lane += kLanes) {
        visit(sample * channels + lane, sample * rows.rows * channels + lane, rows);
      }
    }
  }

  template <typename T>
  static void Run(const Tensor& x, const Tensor& scale, const Tensor& shift, const Tensor& mean,
                  const Tensor& inverse, const Tensor& y) {
    Each(x, [&](int64_t c, int64_t at, Rows rows) {
      Forward(rows, Data<T>(x) + at, Data<float>(scale) + c, Data<float>(shift) + c,
              Data<float>(mean) + c, Data<float>(inverse) + c, Data<T>(y) + at);
    });
  }

  template <typename T>
  static void RunBack(const torch::autograd::variable_list& saved, const Tensor& gradient,
                      const Tensor& by_x, const Tensor& by_scale, const Tensor& by_shift) {
    Each(by_x, [&](int64_t c, int64_t at, Rows rows) {
      Backward(rows, Data<T>(saved[0]) + at, Data<T>(gradient) + at, Data<float>(saved[1]) + c,
               Data<float>(saved[2]) + c, Data<float>(saved[3]) + c, Data<float>(saved[4]) + c,
               Data<float>(by_scale) + c, Data<float>(by_shift) + c, Data<T>(by_x) + at);
    });
  }
};

}  // namespace

Tensor NormalizedLeaky(const Tensor& x, const Tensor& scale, const Tensor& shift) {
  const bool known = x.scalar_type() == torch::kFloat32 || x.scalar_type() == torch::kBFloat16;
  if (!x.device().is_cpu() || !known || x.size(3) % kLanes != 0)
    return NormalizedLeakyByParts(x, scale, shift);
  return Fused::apply(x, scale.expand({x.size(0), -1}), shift.expand({x.size(0), -1}));
}

Tensor NormalizedLeakyByParts(const Tensor& x, const Tensor& scale, const Tensor& shift) {
  const Tensor flat = x.flatten(1, 2).to(torch::kFloat32);
  const Tensor centred = flat - flat.mean(1, true);
  const Tensor variance = centred.square().mean(1, true);
  const Tensor y =
      centred * ((variance + kVarianceEpsilon).rsqrt() * scale.unsqueeze(1)) + shift.unsqueeze(1);
  return at::leaky_relu(y, kLeak).to(x.scalar_type()).view(x.sizes());
}

}  // namespace styled::train::st_gcn
