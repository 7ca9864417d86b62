#include "model/train/erd/lstm.h"

#include <Eigen/Dense>

namespace styled::train::style_erd {
namespace {

using torch::Tensor;
using Matrix = Eigen::Matrix<float, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
using MatrixMap = Eigen::Map<Matrix>;
using ConstMatrixMap = Eigen::Map<const Matrix>;

struct Shape {
  long groups, frames, samples, width;
  explicit Shape(const Tensor& x)
      : groups(x.size(0)), frames(x.size(1)), samples(x.size(2)), width(x.size(3)) {}
};

MatrixMap Group(const Tensor& tensor, long group, long rows, long columns) {
  return {tensor.data_ptr<float>() + group * rows * columns, rows, columns};
}

// The data that the forward pass keeps for the backward pass. Gates are stored after their
// nonlinearity, as the backward pass needs them. [G, T, N, 4Z or Z].
struct Activations {
  Tensor gates, outputs, cells, cell_tanh;
};

// The frames of one of the groups, one after the other.
void Forward(const Shape& s, long group, const Tensor& x, const Tensor& wi, const Tensor& wh,
             const Tensor& b, const Tensor& h0, const Tensor& c0, const Activations& out) {
  const long n = s.samples;
  const long z = s.width;
  const MatrixMap input = Group(x, group, s.frames * n, z);
  const MatrixMap input_weight = Group(wi, group, 4 * z, z);
  // As a plain matrix, so that it is packed column by column without strides at every frame.
  const Matrix hidden_weight_t = Group(wh, group, 4 * z, z).transpose();
  MatrixMap gate = Group(out.gates, group, s.frames * n, 4 * z);
  MatrixMap output = Group(out.outputs, group, s.frames * n, z);
  MatrixMap cell = Group(out.cells, group, s.frames * n, z);
  MatrixMap tanh_cell = Group(out.cell_tanh, group, s.frames * n, z);
  gate.noalias() = input * input_weight.transpose();
  gate.rowwise() +=
      Eigen::Map<const Eigen::RowVectorXf>(b.data_ptr<float>() + group * 4 * z, 4 * z);
  for (long t = 0; t < s.frames; ++t) {
    auto at = gate.middleRows(t * n, n);
    const float* h_before = t == 0 ? h0.data_ptr<float>() + group * n * z : &output((t - 1) * n, 0);
    const float* c_before = t == 0 ? c0.data_ptr<float>() + group * n * z : &cell((t - 1) * n, 0);
    at.noalias() += ConstMatrixMap(h_before, n, z) * hidden_weight_t;
    at.leftCols(2 * z) = at.leftCols(2 * z).array().logistic();
    at.middleCols(2 * z, z) = at.middleCols(2 * z, z).array().tanh();
    at.rightCols(z) = at.rightCols(z).array().logistic();
    cell.middleRows(t * n, n).array() =
        at.middleCols(z, z).array() * ConstMatrixMap(c_before, n, z).array() +
        at.leftCols(z).array() * at.middleCols(2 * z, z).array();
    tanh_cell.middleRows(t * n, n) = cell.middleRows(t * n, n).array().tanh();
    output.middleRows(t * n, n) = at.rightCols(z).array() * tanh_cell.middleRows(t * n, n).array();
  }
}

// The data that the backward pass of a group reads.
struct Saved {
  Tensor x, wi, wh, h0, c0;
  Activations made;
};

// The gradients of the gates before their nonlinearity, `dgate` [T * N, 4Z], from the last frame to
// the first. `dc` and `dh` [G, N, Z] start as the gradients of the last states (those of the
// outputs are `dy`) and end as those of the first.
void BackwardThroughTime(const Shape& s, long group, const Saved& saved, const Tensor& dy,
                         const Tensor& dc, const Tensor& dh, Matrix& dgate) {
  const long n = s.samples;
  const long z = s.width;
  const MatrixMap gate = Group(saved.made.gates, group, s.frames * n, 4 * z);
  const MatrixMap cell = Group(saved.made.cells, group, s.frames * n, z);
  const MatrixMap tanh_cell = Group(saved.made.cell_tanh, group, s.frames * n, z);
  const MatrixMap doutput = Group(dy, group, s.frames * n, z);
  const MatrixMap hidden_weight = Group(saved.wh, group, 4 * z, z);
  MatrixMap dcell = Group(dc, group, n, z);
  MatrixMap dhidden_before = Group(dh, group, n, z);
  Matrix dhidden(n, z);
  for (long t = s.frames - 1; t >= 0; --t) {
    const auto at = gate.middleRows(t * n, n).array();
    const auto i = at.leftCols(z);
    const auto f = at.middleCols(z, z);
    const auto c = at.middleCols(2 * z, z);
    const auto o = at.rightCols(z);
    const auto tc = tanh_cell.middleRows(t * n, n).array();
    auto d = dgate.middleRows(t * n, n).array();
    dhidden = doutput.middleRows(t * n, n) + dhidden_before;
    d.rightCols(z) = dhidden.array() * tc * o * (1.0F - o);
    dcell.array() += dhidden.array() * o * (1.0F - tc.square());
    const float* c_before =
        t == 0 ? saved.c0.data_ptr<float>() + group * n * z : &cell((t - 1) * n, 0);
    d.leftCols(z) = dcell.array() * c * i * (1.0F - i);
    d.middleCols(z, z) = dcell.array() * ConstMatrixMap(c_before, n, z).array() * f * (1.0F - f);
    d.middleCols(2 * z, z) = dcell.array() * i * (1.0F - c.square());
    dcell.array() *= f;
    dhidden_before.noalias() = dgate.middleRows(t * n, n) * hidden_weight;
  }
}

class LstmFunction : public torch::autograd::Function<LstmFunction> {
 public:
  static torch::autograd::variable_list forward(torch::autograd::AutogradContext* context,
                                                const Tensor& x_in, const Tensor& wi_in,
                                                const Tensor& wh_in, const Tensor& b_in,
                                                const Tensor& h0_in, const Tensor& c0_in) {
    const Tensor x = x_in.contiguous();
    const Tensor wi = wi_in.contiguous();
    const Tensor wh = wh_in.contiguous();
    const Tensor b = b_in.contiguous();
    const Tensor h0 = h0_in.contiguous();
    const Tensor c0 = c0_in.contiguous();
    const Shape s(x);
    const Activations made{
        .gates = torch::empty({s.groups, s.frames, s.samples, 4 * s.width}, x.options()),
        .outputs = torch::empty_like(x),
        .cells = torch::empty_like(x),
        .cell_tanh = torch::empty_like(x)};
    for (long g = 0; g < s.groups; ++g) Forward(s, g, x, wi, wh, b, h0, c0, made);
    context->save_for_backward(
        {x, wi, wh, h0, c0, made.gates, made.outputs, made.cells, made.cell_tanh});
    return {made.outputs, made.cells.select(1, s.frames - 1).clone()};
  }

  static torch::autograd::variable_list backward(torch::autograd::AutogradContext* context,
                                                 const torch::autograd::variable_list& gradients) {
    const auto v = context->get_saved_variables();
    const Saved saved{v[0], v[1], v[2], v[3], v[4], {v[5], v[6], v[7], v[8]}};
    const Shape s(saved.x);
    const long n = s.samples;
    const long z = s.width;
    const Tensor dy =
        gradients[0].defined() ? gradients[0].contiguous() : torch::zeros_like(saved.x);
    const Tensor dc =
        gradients[1].defined() ? gradients[1].contiguous().clone() : torch::zeros_like(saved.c0);
    const Tensor dh = torch::zeros_like(saved.h0);
    const Tensor dx = torch::empty_like(saved.x);
    const Tensor dwi = torch::empty_like(saved.wi);
    const Tensor dwh = torch::empty_like(saved.wh);
    const Tensor db = torch::empty({s.groups, 4 * z}, saved.x.options());
    Matrix dgate(s.frames * n, 4 * z);
    for (long g = 0; g < s.groups; ++g) {
      BackwardThroughTime(s, g, saved, dy, dc, dh, dgate);
      const MatrixMap output = Group(saved.made.outputs, g, s.frames * n, z);
      Group(dx, g, s.frames * n, z).noalias() = dgate * Group(saved.wi, g, 4 * z, z);
      Group(dwi, g, 4 * z, z).noalias() = dgate.transpose() * Group(saved.x, g, s.frames * n, z);
      MatrixMap dw = Group(dwh, g, 4 * z, z);
      dw.noalias() = dgate.topRows(n).transpose() * Group(saved.h0, g, n, z);
      dw.noalias() +=
          dgate.bottomRows((s.frames - 1) * n).transpose() * output.topRows((s.frames - 1) * n);
      Eigen::Map<Eigen::RowVectorXf>(db.data_ptr<float>() + g * 4 * z, 4 * z) =
          dgate.colwise().sum();
    }
    return {dx, dwi, dwh, db, dh, dc};
  }
};

}  // namespace

std::pair<Tensor, Tensor> LstmLayerByOps(const Tensor& x, const Tensor& input_weight,
                                         const Tensor& hidden_weight, const Tensor& bias,
                                         const Tensor& h0, const Tensor& c0) {
  const Shape s(x);
  const Tensor projected =
      torch::baddbmm(bias.unsqueeze(1), x.reshape({s.groups, s.frames * s.samples, s.width}),
                     input_weight.transpose(1, 2))
          .view({s.groups, s.frames, s.samples, 4 * s.width});
  const Tensor hidden_weight_t = hidden_weight.transpose(1, 2);
  Tensor h = h0;
  Tensor c = c0;
  std::vector<Tensor> outputs;
  for (long t = 0; t < s.frames; ++t) {
    const auto gates = torch::baddbmm(projected.select(1, t), h, hidden_weight_t).chunk(4, 2);
    c = torch::sigmoid(gates[1]) * c + torch::sigmoid(gates[0]) * torch::tanh(gates[2]);
    h = torch::sigmoid(gates[3]) * torch::tanh(c);
    outputs.push_back(h);
  }
  return {torch::stack(outputs, 1), c};
}

std::pair<Tensor, Tensor> LstmLayer(const Tensor& x, const Tensor& input_weight,
                                    const Tensor& hidden_weight, const Tensor& bias,
                                    const Tensor& h0, const Tensor& c0) {
  if (!x.device().is_cpu() || x.scalar_type() != torch::kFloat32) {
    return LstmLayerByOps(x, input_weight, hidden_weight, bias, h0, c0);
  }
  const auto out = LstmFunction::apply(x, input_weight, hidden_weight, bias, h0, c0);
  return {out[0], out[1]};
}

}  // namespace styled::train::style_erd
