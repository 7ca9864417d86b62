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

// The same for a CUDA device: two kernels a frame forward and two backward, where op by op there
// are some twenty. The kernels of a cell are libtorch's own.
class DeviceLstmFunction : public torch::autograd::Function<DeviceLstmFunction> {
 public:
  static torch::autograd::variable_list forward(torch::autograd::AutogradContext* context,
                                                const Tensor& x, const Tensor& wi, const Tensor& wh,
                                                const Tensor& b, const Tensor& h0,
                                                const Tensor& c0) {
    const Shape s(x);
    const long rows = s.groups * s.samples;
    const Tensor in = x.reshape({s.groups, s.frames * s.samples, s.width});
    const Tensor projected = torch::baddbmm(b.unsqueeze(1), in, wi.transpose(1, 2))
                                 .view({s.groups, s.frames, s.samples, 4 * s.width})
                                 .transpose(0, 1)
                                 .contiguous();  // [T, G, N, 4Z]: a frame is in one piece
    const Tensor wh_t = wh.transpose(1, 2);
    std::vector<Tensor> hidden{h0.contiguous()};
    std::vector<Tensor> saved{c0.reshape({rows, s.width})};  // cells, then workspaces
    std::vector<Tensor> workspaces;
    for (long t = 0; t < s.frames; ++t) {
      const Tensor recurrent = torch::bmm(hidden.back(), wh_t);
      auto [h, c, workspace] =
          at::_thnn_fused_lstm_cell(projected[t].view({rows, 4 * s.width}),
                                    recurrent.view({rows, 4 * s.width}), saved.back());
      hidden.push_back(h.view({s.groups, s.samples, s.width}));
      saved.push_back(c);
      workspaces.push_back(workspace);
    }
    const Tensor all = torch::stack(hidden, 1);  // [G, T + 1, N, Z]
    const Tensor last = saved.back().view({s.groups, s.samples, s.width}).clone();
    saved.insert(saved.end(), workspaces.begin(), workspaces.end());
    saved.insert(saved.end(), {in, wi, wh, all});
    context->save_for_backward(saved);
    return {all.narrow(1, 1, s.frames).contiguous(), last};
  }

  static torch::autograd::variable_list backward(torch::autograd::AutogradContext* context,
                                                 const torch::autograd::variable_list& gradients) {
    const auto saved = context->get_saved_variables();
    const auto end = saved.end();
    const Tensor in = *(end - 4), wi = *(end - 3), wh = *(end - 2), all = *(end - 1);
    const long groups = all.size(0), frames = all.size(1) - 1, n = all.size(2), z = all.size(3);
    const auto cell = [&saved](long t) { return saved[static_cast<std::size_t>(t)]; };
    const auto workspace = [&](long t) { return saved[static_cast<std::size_t>(frames + 1 + t)]; };
    // [T, G, N, Z], to which the gradient through the next frame is added.
    const Tensor dy = gradients[0].defined()
                          ? gradients[0].transpose(0, 1).clone(at::MemoryFormat::Contiguous)
                          : torch::zeros({frames, groups, n, z}, all.options());
    Tensor dc = gradients[1].defined() ? gradients[1].reshape({groups * n, z})
                                       : torch::zeros({groups * n, z}, all.options());
    std::vector<Tensor> gates(static_cast<std::size_t>(frames));
    Tensor dh0;
    for (long t = frames - 1; t >= 0; --t) {
      Tensor dgates;
      std::tie(dgates, dc, std::ignore) = at::_thnn_fused_lstm_cell_backward_impl(
          dy[t].view({groups * n, z}), dc, cell(t), cell(t + 1), workspace(t), false);
      dgates = dgates.view({groups, n, 4 * z});
      gates[static_cast<std::size_t>(t)] = dgates;
      if (t > 0) {
        dy[t - 1].baddbmm_(dgates, wh);
      } else {
        dh0 = torch::bmm(dgates, wh);
      }
    }
    const Tensor dgate = torch::stack(gates, 1).view({groups, frames * n, 4 * z});
    const Tensor dgate_t = dgate.transpose(1, 2);
    const Tensor before = all.narrow(1, 0, frames).reshape({groups, frames * n, z});
    return {torch::bmm(dgate, wi).view({groups, frames, n, z}),
            torch::bmm(dgate_t, in),
            torch::bmm(dgate_t, before),
            dgate.sum(1),
            dh0,
            dc.view({groups, n, z})};
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
  if (x.scalar_type() != torch::kFloat32 || (!x.device().is_cpu() && !x.device().is_cuda())) {
    return LstmLayerByOps(x, input_weight, hidden_weight, bias, h0, c0);
  }
  const auto out = x.device().is_cuda()
                       ? DeviceLstmFunction::apply(x, input_weight, hidden_weight, bias, h0, c0)
                       : LstmFunction::apply(x, input_weight, hidden_weight, bias, h0, c0);
  return {out[0], out[1]};
}

}  // namespace styled::train::style_erd
