#include "model/train/erd/lstm.h"

#include <Eigen/Dense>

namespace styled::train {
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

// Gates are stored after their nonlinearity: that is what the backward pass needs.
class LstmFunction : public torch::autograd::Function<LstmFunction> {
 public:
  static torch::autograd::variable_list forward(torch::autograd::AutogradContext* context, Tensor x,
                                                Tensor wi, Tensor wh, Tensor b, Tensor h0,
                                                Tensor c0) {
    x = x.contiguous();
    wi = wi.contiguous();
    wh = wh.contiguous();
    b = b.contiguous();
    h0 = h0.contiguous();
    c0 = c0.contiguous();
    const Shape s(x);
    const long n = s.samples;
    const long z = s.width;
    Tensor gates = torch::empty({s.groups, s.frames, n, 4 * z}, x.options());
    Tensor y = torch::empty_like(x);
    Tensor cells = torch::empty_like(x);
    Tensor cell_tanh = torch::empty_like(x);
    for (long g = 0; g < s.groups; ++g) {
      const MatrixMap input = Group(x, g, s.frames * n, z);
      const MatrixMap input_weight = Group(wi, g, 4 * z, z);
      // As a plain matrix, so that it is packed column by column without strides at every frame.
      const Matrix hidden_weight_t = Group(wh, g, 4 * z, z).transpose();
      MatrixMap gate = Group(gates, g, s.frames * n, 4 * z);
      MatrixMap output = Group(y, g, s.frames * n, z);
      MatrixMap cell = Group(cells, g, s.frames * n, z);
      MatrixMap tanh_cell = Group(cell_tanh, g, s.frames * n, z);
      gate.noalias() = input * input_weight.transpose();
      gate.rowwise() +=
          Eigen::Map<const Eigen::RowVectorXf>(b.data_ptr<float>() + g * 4 * z, 4 * z);
      for (long t = 0; t < s.frames; ++t) {
        auto at = gate.middleRows(t * n, n);
        const float* h_before = t == 0 ? h0.data_ptr<float>() + g * n * z : &output((t - 1) * n, 0);
        const float* c_before = t == 0 ? c0.data_ptr<float>() + g * n * z : &cell((t - 1) * n, 0);
        at.noalias() += ConstMatrixMap(h_before, n, z) * hidden_weight_t;
        at.leftCols(2 * z) = at.leftCols(2 * z).array().logistic();
        at.middleCols(2 * z, z) = at.middleCols(2 * z, z).array().tanh();
        at.rightCols(z) = at.rightCols(z).array().logistic();
        cell.middleRows(t * n, n).array() =
            at.middleCols(z, z).array() * ConstMatrixMap(c_before, n, z).array() +
            at.leftCols(z).array() * at.middleCols(2 * z, z).array();
        tanh_cell.middleRows(t * n, n) = cell.middleRows(t * n, n).array().tanh();
        output.middleRows(t * n, n) =
            at.rightCols(z).array() * tanh_cell.middleRows(t * n, n).array();
      }
    }
    context->save_for_backward({x, wi, wh, h0, c0, gates, y, cells, cell_tanh});
    return {y, cells.select(1, s.frames - 1).clone()};
  }

  static torch::autograd::variable_list backward(torch::autograd::AutogradContext* context,
                                                 torch::autograd::variable_list gradients) {
    const auto saved = context->get_saved_variables();
    const Tensor &x = saved[0], &wi = saved[1], &wh = saved[2], &h0 = saved[3], &c0 = saved[4],
                 &gates = saved[5], &y = saved[6], &cells = saved[7], &cell_tanh = saved[8];
    const Shape s(x);
    const long n = s.samples;
    const long z = s.width;
    const Tensor dy = gradients[0].defined() ? gradients[0].contiguous() : torch::zeros_like(x);
    // dc starts as the gradient of the last cell state and ends as that of c0; likewise dh.
    Tensor dc = gradients[1].defined() ? gradients[1].contiguous().clone() : torch::zeros_like(c0);
    Tensor dh = torch::zeros_like(h0);
    Tensor dx = torch::empty_like(x);
    Tensor dwi = torch::empty_like(wi);
    Tensor dwh = torch::empty_like(wh);
    Tensor db = torch::empty({s.groups, 4 * z}, x.options());
    Matrix dgate(s.frames * n, 4 * z);
    Matrix dhidden(n, z);
    for (long g = 0; g < s.groups; ++g) {
      const MatrixMap gate = Group(gates, g, s.frames * n, 4 * z);
      const MatrixMap cell = Group(cells, g, s.frames * n, z);
      const MatrixMap tanh_cell = Group(cell_tanh, g, s.frames * n, z);
      const MatrixMap output = Group(y, g, s.frames * n, z);
      const MatrixMap doutput = Group(dy, g, s.frames * n, z);
      const MatrixMap hidden_weight = Group(wh, g, 4 * z, z);
      MatrixMap dcell = Group(dc, g, n, z);
      MatrixMap dhidden_before = Group(dh, g, n, z);
      for (long t = s.frames - 1; t >= 0; --t) {
        const auto at = gate.middleRows(t * n, n).array();
        const auto i = at.leftCols(z), f = at.middleCols(z, z), c = at.middleCols(2 * z, z),
                   o = at.rightCols(z);
        const auto tc = tanh_cell.middleRows(t * n, n).array();
        auto d = dgate.middleRows(t * n, n).array();
        dhidden = doutput.middleRows(t * n, n) + dhidden_before;
        d.rightCols(z) = dhidden.array() * tc * o * (1.0F - o);
        dcell.array() += dhidden.array() * o * (1.0F - tc.square());
        const float* c_before = t == 0 ? c0.data_ptr<float>() + g * n * z : &cell((t - 1) * n, 0);
        d.leftCols(z) = dcell.array() * c * i * (1.0F - i);
        d.middleCols(z, z) =
            dcell.array() * ConstMatrixMap(c_before, n, z).array() * f * (1.0F - f);
        d.middleCols(2 * z, z) = dcell.array() * i * (1.0F - c.square());
        dcell.array() *= f;
        dhidden_before.noalias() = dgate.middleRows(t * n, n) * hidden_weight;
      }
      Group(dx, g, s.frames * n, z).noalias() = dgate * Group(wi, g, 4 * z, z);
      Group(dwi, g, 4 * z, z).noalias() = dgate.transpose() * Group(x, g, s.frames * n, z);
      MatrixMap dw = Group(dwh, g, 4 * z, z);
      dw.noalias() = dgate.topRows(n).transpose() * Group(h0, g, n, z);
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

}  // namespace styled::train
